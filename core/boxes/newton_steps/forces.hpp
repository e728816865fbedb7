// Sweep over the pairs and walls of a slab at one step: contacts begin, act on their bodies, and end.
#pragma once
#include <cstdint>

#include "../common/pair_laws.hpp"
#include "../common/triangle.hpp"
#include "slab.hpp"

namespace hardlimit::boxes::steps {

// The step at which forces are evaluated.
struct Instant {
    std::uint64_t step;   // counts from 2 on
    double time;          // [s]
    double h;             // length of the step before [s]
    double velocity_lag;  // velocities are known this much earlier: h/2, at the start 0 [s]
    double weight;        // of this step in integrals over time: h, at the end of an advance h/2 [s]
    bool closing;         // last step of advance(): velocities are needed at this instant
};

template <class Law>
class Forces {
public:
    Forces(const Box& box, const CellLayers& grid, Bodies& bodies, const PairLaws<Law>& laws, Instant now)
        : box_(box), grid_(grid), bodies_(bodies), laws_(laws), now_(now) {}

    void sweep(Slab<Law>& slab) {
        slab.clear_step();
        sweep_pairs(slab);
        sweep_walls(slab);
    }

    // Onset correction for contacts that were new at the last step of the previous advance(): the part that falls into
    // the half step after it.
    static void resume(Slab<Law>& slab, const Bodies& bodies, double h) {
        slab.impulses.clear(), slab.turns.clear();
        for (const Contact<Law>& c : slab.contacts) {
            if (c.index_first == no_body) continue;
            double impulse = 0.0;
            if (c.is_new && c.force > 0.0) {
                const auto force = onset_force(c.law, c.onset.rate);
                impulse = 0.5 * h * c.force + force.missed_impulse(c.onset, h) -
                          force.impulse_until_step(c.onset, c.force);
                add_impulse(slab, bodies, c, impulse);
            }
            add_sums(slab, c, 0.5 * h * c.force + impulse);
            if constexpr (FrictionalLaw<Law>) {
                const Double4 friction = c.friction.force;
                const auto onset = friction_onset(c.law, c.friction, c.onset, h);
                const double missed = c.is_new ? 0.5 * h + onset.missed - onset.until_step : 0.0;
                if (missed != 0.0) add_friction_impulse(slab, bodies, c, friction * missed);
                add_friction_sums(slab, c, friction * (0.5 * h + missed));
            }
        }
    }

private:
    const Box& box_;
    const CellLayers& grid_;
    Bodies& bodies_;
    const PairLaws<Law>& laws_;
    Instant now_;

    // Motion of the second body, or of the wall, relative to the first.
    struct RelativeMotion {
        std::uint32_t first, second;  // indices; second is no_body at a wall
        std::int32_t number;          // original index of the second, or the number of the wall
        std::uint32_t image;
        Double4 normal;
        double distance, reach;  // reach: distance at touch [m]
        Double4 velocity;        // [m/s], known velocity_lag before now
        Double4 acceleration;    // at the step before [m/s²]
        double wall_velocity;    // inwards [m/s]; 0 for two bodies
        double image_velocity;   // of the image of the second body, along the first axis [m/s]

        double compression() const { return reach - distance; }
    };

    void sweep_pairs(Slab<Law>& slab) {
        const double* position = as_doubles(bodies_.position);
        const Double4* shift = grid_.shifts();
        Double4 present[CellLayers::most_images];
        if (box_.is_sheared() && slab.last_cell == grid_.cells()) {
            grid_.shifts_at(now_.time, present);
            shift = present;
        }
        const std::size_t count = slab.pairs.size();
        for (std::size_t k = 0; k < count; ++k) {
            const NeighbourPair p = slab.pairs[k];
            const double *a = position + 4 * std::size_t{p.first},
                         *b = position + 4 * std::size_t{p.second()};
            const Double4& s = shift[p.image()];
            const double x = b[0] - a[0] + s[0], y = b[1] - a[1] + s[1], z = b[2] - a[2] + s[2];
            const double reach = a[3] + b[3], squared = (x * x + y * y) + z * z;
            if (squared < reach * reach || slab.contact_of_pair[k] >= 0) [[unlikely]]
                pair_contact(slab, slab.contact_of_pair[k], p, double4(x, y, z, 0.0), reach);
        }
    }
    void sweep_walls(Slab<Law>& slab) {
        for (std::size_t k = 0; k < slab.walls.size(); ++k) {
            const WallNeighbour w = slab.walls[k];
            const Double4 position = bodies_.position[w.body];
            const double x = position[w.wall.axis()];
            const double distance = box_.wall(w.wall).distance(x, now_.time);
            if (distance < position[3] || slab.contact_of_wall[k] >= 0)
                wall_contact(slab, slab.contact_of_wall[k], w, distance);
        }
    }

    HL_FN_APART void pair_contact(Slab<Law>& slab, std::int32_t& slot, NeighbourPair p, Double4 separation,
                                  double reach) {
        const std::uint32_t i = p.first, j = p.second();
        if constexpr (FrictionalLaw<Law>) fetch_rotation(i), fetch_rotation(j);
        const double distance = math::sqrt(dot(separation, separation));
        const Double4 normal = separation * (1.0 / distance);
        Double4 v = bodies_.velocity[j] - bodies_.velocity[i];
        const double image_velocity = grid_.velocity(p.image());
        if (image_velocity != 0.0) v[0] += image_velocity;
        const double *last_i = bodies_.acceleration[i].previous(now_.step),
                     *last_j = bodies_.acceleration[j].previous(now_.step);
        const Double4 a = double4(last_j[0] - last_i[0], last_j[1] - last_i[1], last_j[2] - last_i[2], 0.0);
        const auto number = static_cast<std::int32_t>(bodies_.tag[j].original_index);
        update_contact(slab, slot,
                       {i, j, number, p.image(), normal, distance, reach, v, a, 0.0, image_velocity},
                       separation);
    }
    HL_FN_APART void wall_contact(Slab<Law>& slab, std::int32_t& slot, WallNeighbour w, double distance) {
        const std::uint32_t i = w.body;
        const Wall wall = box_.wall(w.wall);
        Double4 normal{}, v = -bodies_.velocity[i];
        normal[w.wall.axis()] = -wall.inward();
        // Velocities of the wall at this step and the one before are means over a step around it: impulses are then of
        // second order also where the wall jumps.
        const double lag = now_.velocity_lag, mean = wall.mean_velocity(now_.time, now_.h);
        const double before = lag > 0.0 ? wall.mean_velocity(now_.time - 2.0 * lag, now_.h) : mean;
        v[w.wall.axis()] += 0.5 * (before + mean);
        Double4 a = -double4(bodies_.acceleration[i].previous(now_.step)) - gravity_of(box_);
        if (lag > 0.0) a[w.wall.axis()] += 0.5 * (mean - before) / lag;
        const double reach = bodies_.position[i][3];
        update_contact(slab, slot,
                       {i, no_body, w.wall.number, grid_.no_image(), normal, distance, reach, v, a,
                        wall.inward() * mean, 0.0},
                       normal * distance);
    }

    void update_contact(Slab<Law>& slab, std::int32_t& slot, const RelativeMotion& m, Double4 separation) {
        const bool is_new = slot < 0 && now_.velocity_lag > 0.0;
        if (slot < 0) {
            slot = free_slot(slab);
            slab.contacts[static_cast<std::size_t>(slot)] = begin(m, separation);
        }
        Contact<Law>& c = slab.contacts[static_cast<std::size_t>(slot)];
        // The forces of other contacts are those of the step before. The force of this one is not known yet.
        const double own = inverse_mass(m) * now_.velocity_lag, compression = m.compression();
        const double rate = own * c.force - dot(m.normal, m.velocity + m.acceleration * now_.velocity_lag);
        const ContactForce f = is_new ? force_at_onset(c.law, compression, rate, inverse_mass(m), c.onset)
                                      : contact_force(c.law, compression, rate, own);
        const double excess = compression - math::max(0.0, c.law.slack(f.rate).depth);
        if ((f.force > 0.0) != c.in_contact) add_event(slab, slot, c, m, excess, is_new);
        if (now_.velocity_lag > 0.0)
            add_loss(slab, c, is_new ? dissipated_at_onset(c.law, f, c.onset) : dissipated(c, f, m));
        [[maybe_unused]] Double4 correction;
        if constexpr (FrictionalLaw<Law>) correction = update_friction(slab, c, m, f.force, excess, is_new);
        c.in_contact = f.force > 0.0;
        c.index_first = m.first, c.index_second = m.second;
        c.normal = m.normal, c.distance = m.distance;
        c.wall_velocity = m.wall_velocity, c.image_velocity = m.image_velocity;
        c.excess = excess, c.is_new = is_new, c.compression = compression;
        static_cast<ContactForce&>(c) = f;
        record_depth(slab, c, m);
        apply(slab, c);
        if constexpr (FrictionalLaw<Law>) apply_friction(slab, c, correction);
        if (!(compression > 0.0)) {
            c.index_first = no_body;
            slab.freed_slots.push_back(slot);
            slot = -1;
        }
    }

    double inverse_mass(const RelativeMotion& m) const {
        return bodies_.velocity[m.first][3] + (m.second != no_body ? bodies_.velocity[m.second][3] : 0.0);
    }
    // Energy dissipated since the last step [J]; c still holds the values of that step. Its compression rate is known
    // accurately only now, with the forces of the other contacts, so the dissipation before that step is corrected.
    double dissipated(Contact<Law>& c, const ContactForce& now, const RelativeMotion& m) const {
        ContactForce before = c;
        if (!c.is_new) before.rate = -dot(c.normal, m.velocity - m.acceleration * now_.velocity_lag);
        const double correction = 0.5 * c.damped * (before.rate - c.rate);
        if (!(m.compression() > 0.0)) return correction + dissipated_at_end(c.law, before, c.compression);
        c.damped = damped(before, now, now_.h);
        if (c.is_new) c.damped += missed_damping(c.law, before, c.onset, now_.h);
        // ½h (F_d v + F_d' v') instead of ½h (F_d + F_d') (v + v')/2, as far as the wall has changed v.
        const double jump =
            0.25 * now_.h * (now.damping - before.damping) * (m.wall_velocity - c.wall_velocity);
        return correction + jump + dissipated_between(before, now, now_.h, inverse_mass(m), c.damped);
    }

    void record_depth(Slab<Law>& slab, const Contact<Law>& c, const RelativeMotion& m) const {
        const double first = bodies_.position[m.first][3];
        const double smaller = m.second == no_body ? first : math::min(first, m.reach - first);
        const double relative = c.compression / smaller;
        if (!(relative > slab.largest_compression)) return;
        slab.largest_compression = relative;
        slab.deepest[0] = c.first, slab.deepest[1] = c.second;
    }

    static std::int32_t free_slot(Slab<Law>& slab) {
        if (slab.free_slots.empty()) {
            slab.contacts.emplace_back();
            return static_cast<std::int32_t>(slab.contacts.size()) - 1;
        }
        const std::int32_t slot = slab.free_slots.back();
        slab.free_slots.pop_back();
        return slot;
    }

    // A contact at its first step. Bodies move uniformly between two steps: the time of touch follows from the
    // compressions at both, the compression rate at touch also from the curvature of the distance.
    Contact<Law> begin(const RelativeMotion& m, Double4 separation) const {
        Contact<Law> c{};
        const bool wall = m.second == no_body;
        c.first = static_cast<std::int32_t>(bodies_.tag[m.first].original_index);
        c.second = m.number;
        c.begin_event = -1;
        if constexpr (FrictionalLaw<Law>) c.normal = m.normal;
        c.law = laws_(c.first, wall ? -1 : m.number);
        if (!wall) c.image = grid_.relative_image(NeighbourPair::of(m.first, m.second, m.image), bodies_.tag);
        c.begin = now_.time;
        c.impact_speed = -dot(m.normal, m.velocity);
        if (!(now_.velocity_lag > 0.0)) return c;
        const Double4 before = separation - m.velocity * now_.h;
        const double distance = wall ? dot(before, m.normal) : math::sqrt(dot(before, before));
        const double growth = math::max(distance - m.distance, 1e-300);
        const double share = math::min(1.0, m.compression() / growth);
        c.onset = {share * now_.h, growth / now_.h};
        c.begin -= c.onset.since;
        c.impact_speed = math::max(0.0, rate_at(c.begin, m, growth, 0.0));
        if (c.impact_speed > 0.0) c.onset.rate = c.impact_speed;
        return c;
    }

    // dξ/dt [m/s] at a time between the last two steps, between which ξ grew by `growth` [m]. `own` [N] is the force of
    // this contact at the step before, which no longer acts.
    double rate_at(double time, const RelativeMotion& m, double growth, double own) const {
        const double along = dot(m.normal, m.velocity);
        const double turning =
            m.second != no_body ? (dot(m.velocity, m.velocity) - along * along) / m.distance : 0.0;
        const double curvature = own * inverse_mass(m) - dot(m.normal, m.acceleration) - turning;
        return growth / now_.h + curvature * (time - (now_.time - 0.5 * now_.h));
    }

    // Part of the last step at whose end the excess compression passed through zero.
    static double share_before(const Contact<Law>& c, double excess) {
        const double span = c.excess - excess;
        return span != 0.0 ? math::clamp(c.excess / span, 0.0, 1.0) : 1.0;
    }
    // Stores the begin or the end of a contact. Unless it begins by touch, its time is where the excess compression
    // passes through zero.
    void add_event(Slab<Law>& slab, std::int32_t slot, Contact<Law>& c, const RelativeMotion& m,
                   double excess, bool is_new) const {
        const bool begins = !c.in_contact, known = begins && (is_new || !(now_.velocity_lag > 0.0));
        const double time = known ? c.begin : now_.time - (1.0 - share_before(c, excess)) * now_.h;
        const double rate =
            known ? c.impact_speed : rate_at(time, m, m.compression() - c.compression, c.force);
        if (begins) c.begin = time, c.impact_speed = rate;
        const std::int32_t begin_event = begins ? -1 : c.begin_event;
        if (begins) c.begin_event = static_cast<std::int32_t>(slab.events.size());
        slab.events.push_back({c, now_.step, time, slot, begins, -rate, begin_event});
    }

    void apply(Slab<Law>& slab, const Contact<Law>& c) {
        double impulse = 0.0;
        if (c.is_new && c.force > 0.0) {
            const auto force = onset_force(c.law, c.onset.rate);
            impulse = now_.closing ? force.impulse_until_step(c.onset, c.force) - now_.weight * c.force
                                   : force.missed_impulse(c.onset, now_.h);
            add_impulse(slab, bodies_, c, impulse);
        }
        add_sums(slab, c, now_.weight * c.force + impulse);
        if (!(c.force > 0.0)) return;
        accelerate(slab, c.index_first, c.normal * (-c.force * bodies_.velocity[c.index_first][3]));
        if (c.index_second != no_body)
            accelerate(slab, c.index_second, c.normal * (c.force * bodies_.velocity[c.index_second][3]));
    }
    // Distances of the contact from the centres [m], in proportion to the radii so that angular momentum and energy are
    // conserved; at a wall the radius.
    struct Arms {
        double first, second;
    };
    static Arms arms(const Bodies& bodies, std::uint32_t i, std::uint32_t j, double distance) {
        const double radius = bodies.position[i][3];
        if (j == no_body) return {radius, 0.0};
        const double first = distance * (radius / (radius + bodies.position[j][3]));
        return {first, distance - first};
    }
    // What a tangential force or impulse on the second body does to the spins of both [rad/s² or rad/s].
    struct Turns {
        Double4 first, second;
    };
    static Turns turns_of(const Bodies& bodies, const Contact<Law>& c, Double4 force) {
        const Arms arm = arms(bodies, c.index_first, c.index_second, c.distance);
        const Double4 torque = -cross(c.normal, force);  // over the arm, on either body
        Turns turns{torque * (arm.first * bodies.spin[c.index_first][3]), Double4{}};
        if (c.index_second != no_body) turns.second = torque * (arm.second * bodies.spin[c.index_second][3]);
        return turns;
    }
    // Velocity of the second surface relative to the first [m/s] a time `ago` [s] before this step, in the plane across
    // the present normal. Velocities advance by `lag` [s] with the accelerations of the step before. In scalars, as
    // drift() is.
    Double4 sliding_velocity(const RelativeMotion& m, double ago, double lag) const {
        const Vector3 now = first_three(m.normal), v = first_three(m.velocity);
        const bool wall = m.second == no_body;
        Vector3 normal = now, turning, g;
        double distance = m.distance;
        if (!wall && ago > 0.0) {
            for (std::size_t k = 0; k < 3; ++k) normal[k] = now[k] * distance - v[k] * ago;
            distance = math::sqrt(dot(normal, normal));
            const double inverse = 1.0 / distance;
            for (double& n : normal) n *= inverse;
        }
        const Arms arm = arms(bodies_, m.first, m.second, distance);
        for (std::size_t k = 0; k < 3; ++k) turning[k] = spin(m.first, k, lag) * arm.first;
        if (!wall)
            for (std::size_t k = 0; k < 3; ++k) turning[k] += spin(m.second, k, lag) * arm.second;
        const Vector3 across = cross(turning, normal);
        for (std::size_t k = 0; k < 3; ++k) g[k] = v[k] + m.acceleration[k] * lag - across[k];
        const double along = dot(g, normal);
        for (std::size_t k = 0; k < 3; ++k) g[k] = g[k] - normal[k] * along;
        const double share = dot(g, now) / (1.0 + dot(normal, now));  // as in turned()
        for (std::size_t k = 0; k < 3; ++k) g[k] = g[k] - (normal[k] + now[k]) * share;
        return double4(g[0], g[1], g[2], 0.0);
    }
    // Velocity by which a newton of tangential force changes that of the surfaces in a second [1/kg].
    double inverse_tangential_mass(const RelativeMotion& m) const {
        const Arms arm = arms(bodies_, m.first, m.second, m.distance);
        double inverse = inverse_mass(m) + arm.first * arm.first * bodies_.spin[m.first][3];
        if (m.second != no_body) inverse += arm.second * arm.second * bodies_.spin[m.second][3];
        return inverse;
    }
    Slide slide(const RelativeMotion& m, const ContactFriction<Law>& before, double since,
                bool is_new) const {
        const double inverse = inverse_tangential_mass(m), lag = now_.velocity_lag;
        // The accelerations contain the force of this contact at the step before.
        const Double4 velocity = sliding_velocity(m, 0.0, lag) - before.force * (inverse * lag);
        return {sliding_velocity(m, 0.5 * since, 0.0) * since, velocity, inverse * (is_new ? since : lag)};
    }

    // Computes the tangential force at this step, and the energy dissipated since the last one, whose values c still
    // holds. Between two steps velocities change by h (F + F')/2 and surfaces move by Δ, so F takes −½ (F + F')·Δ from
    // the bodies; the spring stores a part of it. Returns the impulse [N s] that equal steps miss where the contact
    // begins or ends.
    Double4 update_friction(Slab<Law>& slab, Contact<Law>& c, const RelativeMotion& m, double normal_force,
                            double excess, bool is_new) const {
        ContactFriction<Law> before = c.friction;
        const double compression = math::max(m.compression(), 0.0), since = is_new ? c.onset.since : now_.h;
        before.turn(c.normal, m.normal);
        const Slide moved = slide(m, before, since, is_new);
        const double stored_before = before.energy(c.law, c.compression);
        const bool begins = normal_force > 0.0 && !c.in_contact, ends = c.in_contact && !(normal_force > 0.0);
        const Double4 first = is_new   ? sliding_velocity(m, since, now_.velocity_lag - since)
                              : begins ? moved.velocity
                                       : before.first_velocity;
        const bool slid = before.slid && !begins;
        if (is_new) before = friction_at_touch(c.law, first, c.onset.rate);
        c.friction = friction_force(c.law, before, moved, c.compression, compression, normal_force);
        c.friction.first_velocity = first, c.friction.slid = slid || c.friction.slips;
        Double4 impulse = (before.force + c.friction.force) * (0.5 * since), correction{};
        if (is_new) {
            const auto onset = friction_onset(c.law, c.friction, c.onset, now_.h);
            impulse = c.friction.force * onset.until_step;
            correction = c.friction.force * (now_.closing ? onset.until_step - now_.weight : onset.missed);
        } else if (!(normal_force > 0.0) && before.length() > 0.0) {
            // The surfaces stick until μ F_n, which falls to zero, equals the force of the last step. While they slip
            // equal steps miss as much of F as of F_n.
            const double ratio = before.length() / (c.law.friction.coefficient * c.force);
            const double lasts = share_before(c, excess) * now_.h;
            correction = before.force * ((1.0 - ratio) * (lasts - 0.5 * now_.h));
            impulse += correction;
        }
        const double stored = c.friction.energy(c.law, compression) - stored_before;
        const double work = since > 0.0 ? -dot(impulse, moved.displacement) / since : 0.0;
        add_loss(slab, c, work - stored);
        slab.friction_loss += work - stored;
        if (ends)
            slab.events.back().sliding = sliding(c, moved.velocity + correction * inverse_tangential_mass(m));
        return correction;
    }
    void apply_friction(Slab<Law>& slab, const Contact<Law>& c, Double4 correction) {
        const Double4 force = c.friction.force;
        if (dot(correction, correction) > 0.0) add_friction_impulse(slab, bodies_, c, correction);
        add_friction_sums(slab, c, force * now_.weight + correction);
        if (!(dot(force, force) > 0.0)) return;
        const std::uint32_t i = c.index_first, j = c.index_second;
        const Turns turns = turns_of(bodies_, c, force);
        accelerate(slab, i, -force * bodies_.velocity[i][3]);
        bodies_.angular_acceleration[i].add(now_.step, turns.first);
        if (j == no_body) return;
        accelerate(slab, j, force * bodies_.velocity[j][3]);
        bodies_.angular_acceleration[j].add(now_.step, turns.second);
    }
    void fetch_rotation(std::uint32_t body) const {
        prefetch(&bodies_.spin[body]), prefetch(&bodies_.angular_acceleration[body]);
    }
    // Component of the angular velocity [rad/s], from the torques of the step before.
    double spin(std::uint32_t body, std::size_t axis, double lag) const {
        return bodies_.spin[body][axis] + bodies_.angular_acceleration[body].previous(now_.step)[axis] * lag;
    }
    void accelerate(Slab<Law>& slab, std::uint32_t body, Double4 acceleration) {
        if (bodies_.acceleration[body].add(now_.step, acceleration))
            (slab.holds(body) ? slab.accelerated : slab.accelerated_next).push_back(body);
    }
    // Virial r⊗Δp of an impulse along the line of centres r, and its work on what moves the bodies. With friction r⊗F
    // is not symmetric; its symmetric part is added.
    static void add_sums(Slab<Law>& slab, const Contact<Law>& c, double impulse) {
        slab.wall_work += impulse * c.wall_velocity;
        slab.shear_work -= impulse * c.normal[0] * c.image_velocity;
        if (c.index_second != no_body)
            slab.virial.add_square(impulse * c.distance, c.normal);
        else
            slab.given_to_walls.add(WallId::of(c.second), impulse, -impulse * c.wall_velocity);
    }
    static void add_friction_sums(Slab<Law>& slab, const Contact<Law>& c, Double4 impulse) {
        slab.shear_work -= impulse[0] * c.image_velocity;
        if (c.index_second != no_body) slab.virial.add_product(c.distance, c.normal, impulse);
    }
    // Energy dissipated in a contact [J].
    static void add_loss(Slab<Law>& slab, const Contact<Law>& c, double energy) {
        slab.dissipated += energy;
        if (c.second < 0) slab.given_to_walls.add(WallId::of(c.second), 0.0, energy);
    }
    static void add_impulse(Slab<Law>& slab, const Bodies& bodies, const Contact<Law>& c, double impulse) {
        slab.impulses.push_back({c.index_first, c.normal * (-impulse * bodies.velocity[c.index_first][3])});
        if (c.index_second != no_body)
            slab.impulses.push_back(
                {c.index_second, c.normal * (impulse * bodies.velocity[c.index_second][3])});
    }
    // Tangential impulse on the second body [N s].
    static void add_friction_impulse(Slab<Law>& slab, const Bodies& bodies, const Contact<Law>& c,
                                     Double4 impulse) {
        const std::uint32_t i = c.index_first, j = c.index_second;
        const Turns turns = turns_of(bodies, c, impulse);
        slab.impulses.push_back({i, -impulse * bodies.velocity[i][3]});
        slab.turns.push_back({i, turns.first});
        if (j == no_body) return;
        slab.impulses.push_back({j, impulse * bodies.velocity[j][3]});
        slab.turns.push_back({j, turns.second});
    }
};

}  // namespace hardlimit::boxes::steps
