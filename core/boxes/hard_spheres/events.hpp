// Collisions of two particles or with a wall, as the rule describes them.
#pragma once
#include <memory>

#include "collapse.hpp"
#include "rubbing.hpp"
#include "soft_contact.hpp"

namespace hardlimit::boxes::spheres {

// Changes velocities, sums and log; predicts nothing.
template <int d, bool mixed>
class Collisions {
public:
    Collisions(Particles<d, mixed>& particles, Totals<d, mixed>& totals, CellAssignment<d, mixed>& cells,
               LastContacts<d>& contacts, CollapseDetector& collapse, CollisionLog& log)
        : particles_(particles),
          totals_(totals),
          soft_(particles, totals, cells, contacts),
          rubbing_(particles),
          collapse_(collapse),
          log_(log),
          rule_(make_rule(setting_.rule, {setting_.mass, setting_.largest_radius, !mixed, setting_.kinds})),
          take_time_(rule_ && rule_->takes_time()) {}

    // Whether contacts take time under the rule, so that LastContacts holds them.
    bool take_time() const { return take_time_; }
    // May end the run.
    void collide(u32 i, u32 j) {
        Particle<d>&p = particles_.paths[i], &q = particles_.paths[j];
        if (particles_.rotates()) prefetch_near(&particles_.spins[i]), prefetch_near(&particles_.spins[j]);
        const double waited_i = particles_.now - p.time, waited_j = particles_.now - q.time;
        particles_.advance_to_now(i);
        particles_.advance_to_now(j);
        totals_.advance();
        Touch<d> t;
        t.i = i, t.j = j;
        t.image_velocity = particles_.to_nearest_image(i, j, t.r);
        for (int k = 0; k < d; ++k) t.v[k] = q.velocity[k] - p.velocity[k];
        if (t.image_velocity != 0.0) t.v[0] += t.image_velocity;
        t.distance = math::sqrt(dot(t.r, t.r));
        t.speed = -dot(t.r, t.v) / t.distance;
        if (!(t.speed > 0.0)) {  // by rounding: they only touch
            if (take_time_) soft_.touch(i, j);
        } else if (take_time_) {
            contact(t);
        } else {
            rebound(t, math::max(waited_i, waited_j),
                    math::min(since_last(i, waited_i), since_last(j, waited_j)));
        }
    }
    // A particle that arrives at zero speed rests there if gravity and the acceleration of the wall press it on the
    // wall.
    void collide_with_wall(u32 i, const Wall& wall) {
        Particle<d>& p = particles_.paths[i];
        Accumulators<d>& sums = totals_.so_far;
        const int axis = wall.id.axis();
        const double now = particles_.now, away = wall.inward(), waited = now - p.time;
        particles_.advance_to_now(i);
        totals_.advance();
        const double place = wall.position(now) + away * particles_.radius(i);
        // Nonzero by rounding, or if a soft contact was cut short.
        const double moved = place - p.position[axis];
        const double gravity = particles_.box.gravity[axis];
        p.position[axis] = place;
        if (setting_.falls()) sums.sums.add_potential(-(particles_.mass(i) * gravity) * moved);
        WallArrival arrival{math::abs(p.velocity[axis] - wall.velocity(now)), gravity * moved};
        if (take_time_ && arrival.gained != 0.0) arrive(i, wall, arrival);
        if (arrival.surface_speed == 0.0) {
            ++sums.walls;
            record(i, wall.id.number, 0.0, {0.0, 0.0}, math::infinity);
            if (!(away * (gravity - wall.acceleration(now)) > 0.0))
                end_run(Outcome::at_rest, i, wall.id.number);
        } else if (take_time_) {
            contact_with_wall(i, wall, arrival);
        } else {
            rebound_from_wall(i, wall, arrival.speed, waited);
        }
    }
    // Largest so far, in units of the smaller radius; NaN without a law.
    double largest_compression() const { return deepest_.compression; }

    template <class Archive>
    void exchange(Archive& a) {
        a(deepest_);
    }

private:
    Particles<d, mixed>& particles_;
    Totals<d, mixed>& totals_;
    const Setting& setting_ = particles_.setting;
    SoftContacts<d, mixed> soft_;
    Rubbing<d, mixed> rubbing_;
    CollapseDetector& collapse_;
    CollisionLog& log_;
    std::unique_ptr<Rule> rule_;
    bool take_time_;
    DeepestImpact deepest_;  // if there is a law

    // An instantaneous collision. waited: since the last collision of either, the longer of the two; since_last: the
    // shorter.
    void rebound(const Touch<d>& t, double waited, double since_last) {
        const u32 i = t.i, j = t.j;
        Particle<d>&p = particles_.paths[i], &q = particles_.paths[j];
        const PairGeometry pair = geometry(i, j);
        const double reduced = pair.effective_mass;
        const double smaller = math::min(particles_.radius(i), particles_.radius(j));
        Impact impact{{reduced, t.distance, t.speed}, pair, smaller, since_last};
        Slip slip;
        if (particles_.rotates()) slip = rubbing_.of_pair(t, impact);
        const Rebound result = restitution(impact);
        const double e = result.restitution;
        if (const Outcome o = outcome_of(result); o != Outcome::ok) return end_unsolved(o, i, j, t.speed);
        // Relative velocity gained along r, in units of r [1/s]. Computed from r² without a square root: all pairs
        // touch at about the same distance, so that the rounding error of the root would be the same each time, and the
        // energy would drift.
        const double gain = (1.0 + e) * (-dot(t.r, t.v) / dot(t.r, t.r));
        const double lost = 0.5 * reduced * (1.0 - e) * (1.0 + e) * t.speed * t.speed;
        Accumulators<d>& sums = totals_.so_far;
        double to_i[d], to_j[d];
        for (int k = 0; k < d; ++k) {
            const double impulse = reduced * gain * t.r[k];
            to_i[k] = p.velocity[k] - impulse / particles_.mass(i);
            to_j[k] = q.velocity[k] + impulse / particles_.mass(j);
        }
        CollisionResult end{e * t.speed, lost};
        if (particles_.rotates()) Rubbing<d, mixed>::add_result(slip, result, end);
        if (result.tangential_gain != 0.0) {
            rub(t, slip, result.tangential_gain, reduced * gain, to_i, to_j);
        } else {
            sums.add_virial(reduced * gain, t.r,
                            t.r);  // r⊗Δp, exactly: the force acts along r at one instant
            if (t.image_velocity != 0.0) sums.shear_work.add(-(reduced * gain * t.r[0]) * t.image_velocity);
        }
        totals_.set_velocity(i, to_i);
        totals_.set_velocity(j, to_j);
        record(i, j, t.speed, end, waited);
        ++sums.pairs;
    }
    // Adds the tangential impulse to the velocities, and both impulses to the virial; along: normal impulse over r.
    void rub(const Touch<d>& t, const Slip& slip, double gain, double along, double (&to_i)[d],
             double (&to_j)[d]) {
        const Vector3 impulse = Rubbing<d, mixed>::impulse(slip, gain);
        const double inverse_i = 1.0 / particles_.mass(t.i);
        const double inverse_j = mixed ? 1.0 / particles_.mass(t.j) : inverse_i;
        double whole[d];
        for (std::size_t k = 0; k < d; ++k) {
            whole[k] = along * t.r[k] + impulse[k];
            to_i[k] -= inverse_i * impulse[k];
            to_j[k] += inverse_j * impulse[k];
        }
        totals_.so_far.add_virial(1.0, t.r, whole);
        if (t.image_velocity != 0.0) totals_.so_far.shear_work.add(-whole[0] * t.image_velocity);
        rubbing_.turn(t.i, slip, impulse);
        rubbing_.turn(t.j, slip, impulse);
    }
    void contact(const Touch<d>& t) {
        double across[d];
        const double square = t.tangential(across);
        const PairGeometry pair = geometry(t.i, t.j);
        const double one = particles_.radius(t.i), other = particles_.radius(t.j);
        const Approach approach{pair.effective_mass, one + other, t.speed, math::sqrt(square)};
        const Impact impact{approach, pair, math::min(one, other), math::infinity};
        if (particles_.rotates()) return rough_contact(t, impact);
        const SoftContact contact = rule_->contact(impact, deepest_);
        if (contact.outcome != Outcome::ok) return end_unsolved(contact.outcome, t.i, t.j, t.speed);
        record(t.i, t.j, t.speed, soft_.of_pair(t, pair, contact), math::infinity);
        ++totals_.so_far.pairs;
    }
    void rough_contact(const Touch<d>& t, Impact impact) {
        const Slip slip = rubbing_.of_pair(t, impact);
        Vector3 normal{}, velocity{};
        for (std::size_t k = 0; k < d; ++k) normal[k] = t.r[k] / t.distance, velocity[k] = t.v[k];
        const TurningApproach touch = rubbing_.approach(slip, impact, normal, velocity);
        const TurningContact end = rule_->turning_contact(touch, impact, deepest_);
        if (end.outcome != Outcome::ok) return end_unsolved(end.outcome, t.i, t.j, t.speed);
        CollisionResult result = soft_.of_rough_pair(t, impact.pair, end);
        result.lost += rubbing_.turn(t.i, slip, end) + rubbing_.turn(t.j, slip, end);
        rubbing_.add_result(slip, touch, end, result);
        record(t.i, t.j, t.speed, result, math::infinity);
        ++totals_.so_far.pairs;
    }
    // A soft contact of the particle with this wall was cut short behind its surface. The particle goes back along its
    // parabola, and arrives at the surface with the energy that it has. If that does not suffice it is lifted: this
    // energy comes from the contact, which had stored more.
    void arrive(u32 i, const Wall& wall, WallArrival& arrival) {
        const double square = arrival.speed * arrival.speed + 2.0 * arrival.gained;
        if (square > 0.0) {
            arrival.surface_speed = math::sqrt(square);
            return;
        }
        const double lost = particles_.mass(i) * arrival.gained;
        totals_.so_far.dissipated.add(lost);
        totals_.so_far.wall_energy[wall.id.index()].add(lost);
        arrival.gained = 0.0;
    }
    // In the frame of the wall.
    void rebound_from_wall(u32 i, const Wall& wall, double speed, double waited) {
        const int axis = wall.id.axis();
        const double m = particles_.mass(i), radius = particles_.radius(i), away = wall.inward();
        const double wall_velocity = wall.velocity(particles_.now);
        Impact impact{{m, math::infinity, speed}, {m, radius}, radius, since_last(i, waited)};
        Slip slip;
        if (particles_.rotates()) slip = rubbing_.at_wall(i, wall, impact);
        const Rebound result = restitution(impact);
        const double e = result.restitution;
        if (const Outcome o = outcome_of(result); o != Outcome::ok)
            return end_unsolved(o, i, wall.id.number, speed);
        double velocity[d];
        std::copy_n(particles_.paths[i].velocity, d, velocity);
        const double before = velocity[axis];
        velocity[axis] = away * (e * speed) + wall_velocity;
        const double gained = m * (velocity[axis] - before);
        CollisionResult end{e * speed, 0.5 * m * (1.0 - e) * (1.0 + e) * speed * speed};
        if (particles_.rotates()) rub_at_wall(i, slip, result, velocity, end);
        totals_.set_velocity(i, velocity);
        totals_.so_far.add_wall(wall.id, away * gained, gained * wall_velocity, end.lost);
        record(i, wall.id.number, speed, end, waited);
    }
    // A wall moves along its normal only: it does no work by the tangential impulse.
    void rub_at_wall(u32 i, const Slip& slip, const Rebound& result, double (&velocity)[d],
                     CollisionResult& end) {
        rubbing_.add_result(slip, result, end);
        if (result.tangential_gain == 0.0) return;
        const Vector3 impulse = rubbing_.impulse(slip, result.tangential_gain);
        for (std::size_t k = 0; k < d; ++k) velocity[k] -= impulse[k] / particles_.mass(i);
        rubbing_.turn(i, slip, impulse);
    }
    void contact_with_wall(u32 i, const Wall& wall, const WallArrival& arrival) {
        const double m = particles_.mass(i), radius = particles_.radius(i);
        const double pressing =
            -wall.inward() * (particles_.box.gravity[wall.id.axis()] - wall.acceleration(particles_.now));
        const double speed = arrival.surface_speed;
        const Impact impact{{m, math::infinity, speed, 0.0, pressing}, {m, radius}, radius, math::infinity};
        const SoftContact contact = rule_->contact(impact, deepest_);
        if (contact.outcome != Outcome::ok) return end_unsolved(contact.outcome, i, wall.id.number, speed);
        if (particles_.rotates()) return rough_contact_with_wall(i, wall, arrival, pressing, impact, contact);
        record(i, wall.id.number, speed, soft_.at_wall(i, wall, arrival, pressing, contact), math::infinity);
    }
    // The normal motion is that without friction. Tangential motion is that of a contact without gravity, then a free
    // flight: it neglects terms of order g t_c/v.
    void rough_contact_with_wall(u32 i, const Wall& wall, const WallArrival& arrival, double pressing,
                                 Impact impact, const SoftContact& contact) {
        const Slip slip = rubbing_.at_wall(i, wall, impact);
        const auto axis = static_cast<std::size_t>(wall.id.axis());
        Vector3 normal{}, velocity{};
        for (std::size_t k = 0; k < d; ++k) velocity[k] = -particles_.paths[i].velocity[k];
        normal[axis] = -wall.inward(), velocity[axis] = wall.inward() * arrival.surface_speed;
        const TurningApproach touch = rubbing_.approach(slip, impact, normal, velocity);
        const TurningContact end = rule_->turning_contact(touch, impact, deepest_);
        if (end.outcome != Outcome::ok)
            return end_unsolved(end.outcome, i, wall.id.number, arrival.surface_speed);
        const double m = particles_.mass(i);
        Sliding<d> sliding;
        for (std::size_t k = 0; k < d; ++k) {
            if (k == axis) continue;
            sliding.velocity[k] = velocity[k] - end.velocity[k];
            sliding.shift[k] = end.duration * end.velocity[k] - end.shift[k];
            sliding.lost += m * (0.5 * sliding.velocity[k] * (velocity[k] + end.velocity[k]) +
                                 particles_.box.gravity[k] * sliding.shift[k]);
        }
        sliding.lost += rubbing_.turn(i, slip, end);
        CollisionResult result = soft_.at_wall(i, wall, arrival, pressing, contact, sliding);
        rubbing_.add_result(slip, touch, end, result);
        record(i, wall.id.number, arrival.surface_speed, result, math::infinity);
    }
    Rebound restitution(Impact& impact) {
        impact.collisions = totals_.so_far.collisions();
        const Rebound rebound = rule_->rebound(impact, deepest_);
        totals_.so_far.elastic_by_tc += rebound.elastic_by_tc;
        return rebound;
    }
    Outcome outcome_of(const Rebound& rebound) const {
        if (deepest_.too_deep) return Outcome::too_deep;
        return math::is_finite(rebound.tangential_gain) ? Outcome::ok : Outcome::unresolved;
    }
    double since_last(u32 i, double waited) const {
        return particles_.collisions(i) > 0 ? waited : math::infinity;
    }
    PairGeometry geometry(u32 i, u32 j) const {
        if constexpr (mixed)
            return {effective(particles_.mass(i), particles_.mass(j)),
                    effective(particles_.radius(i), particles_.radius(j))};
        return {0.5 * setting_.mass, 0.5 * setting_.largest_radius};
    }
    // Logs a collision of i, before it is counted, and ends the run if it is part of a collapse.
    void record(u32 i, i64 second, double speed, const CollisionResult& result, double waited) {
        if (result.lost != 0.0) totals_.so_far.dissipated.add(result.lost);
        if (result.friction_loss != 0.0) totals_.so_far.friction_loss.add(result.friction_loss);
        log_.add(particles_.now, i, second, speed, result);
        const CollapseDetector::Collision c{particles_.now, i, second, speed, waited, rule_->can_collapse()};
        if (collapse_.collapses(
                c, setting_.largest_radius, [this] { return totals_.typical_speed(); },
                [this](u32 id) { return particles_.original_index[id]; }))
            end_run(Outcome::collapse, i, second);
    }
    void end_run(Outcome outcome, u32 i, i64 second) { log_.end_run(outcome, particles_.now, i, second); }
    // Ends the run at a collision without a result: it is logged, and the velocities do not change.
    void end_unsolved(Outcome outcome, u32 i, i64 second, double speed) {
        ++(second < 0 ? totals_.so_far.walls : totals_.so_far.pairs);
        record(i, second, speed, {math::nan, 0.0}, math::infinity);
        end_run(outcome, i, second);
    }
};

}  // namespace hardlimit::boxes::spheres
