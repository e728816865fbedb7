// Solution of an isolated contact, which no third body disturbs, from touch to separation. With friction, only under a
// linear law with a tangential spring (turning_series.hpp); the others are clusters of two bodies.
#pragma once
#include <array>

#include "../binary_contact/tabulated_contact.hpp"
#include "../binary_contact/turning_contact.hpp"
#include "../kernels/interface.hpp"
#include "frames.hpp"
#include "limits.hpp"

namespace hardlimit::boxes::events {

using SeparatedMembers = std::array<Member, 2>;  // at the end of an isolated contact

// Table for pairs of the largest bodies. Whether the damping varies between pairs is judged from the smallest and the
// largest body; a pair that does not fit the table is solved directly.
template <class Law>
TabulatedContacts<Law, true> contact_table(const PairLaws<Law>& laws, std::size_t count,
                                           const hardlimit_abi::TouchKernels& kernels) {
    std::size_t least = 0, most = 0;
    for (std::size_t i = 1; i < count; ++i) {
        if (laws.radius(i) < laws.radius(least)) least = i;
        if (laws.radius(i) > laws.radius(most)) most = i;
    }
    const auto mass = [&](std::size_t i, std::size_t j) { return effective(laws.mass(i), laws.mass(j)); };
    const auto reach = [&](std::size_t i, std::size_t j) { return laws.radius(i) + laws.radius(j); };
    const auto damping = [&](std::size_t i, std::size_t j) {
        const Law law = laws(static_cast<std::int64_t>(i), static_cast<std::int64_t>(j));
        return TabulatedContacts<Law, true>::damping(law, mass(i, j), reach(i, j));
    };
    const double of_most = damping(most, most);
    const auto differs = [&](double other) { return math::abs(other - of_most) > 1e-13 * of_most; };
    const bool varies = differs(damping(least, least)) || differs(damping(least, most));
    const auto first = static_cast<std::int64_t>(most);
    return {laws(first, first), mass(most, most), reach(most, most), varies, kernels.read_cell};
}

// The virial ∫ r⊗F dt (planar_contact.hpp): its trace, and its components along normal and tangent at touch.
template <class Law>
void set_virial(IsolatedContact<Law>& l, const Approach& touch, const PlanarContact& end,
                const Vector3& normal, const Vector3& tangent) {
    const double distance = touch.distance, left = distance - end.compression;
    const double trace = (end.radial_speed * left + touch.normal_speed * distance) - end.rate_square -
                         touch.tangential_speed * distance * end.turn;
    const double mass = touch.effective_mass, nn = mass * (trace - end.virial_tt), nt = mass * end.virial_nt,
                 tt = mass * end.virial_tt;
    Vector3 along, across;
    for (std::size_t k = 0; k < 3; ++k) {
        along[k] = nn * normal[k] + nt * tangent[k];
        across[k] = nt * normal[k] + tt * tangent[k];
    }
    for (std::size_t c = 0; c < SymmetricTensor::size; ++c) {
        const auto i = static_cast<std::size_t>(SymmetricTensor::row[c]);
        const auto j = static_cast<std::size_t>(SymmetricTensor::column[c]);
        l.virial.component[c] = normal[i] * along[j] + tangent[i] * across[j];
    }
}

// Computes the states when the surfaces separate; after the force has ended the relative path is straight. At an
// earlier time s, the relative path deviates from the outgoing one by ∫_s^∞ (t − s) a dt, where a is the force per
// mass. As a rotates with the line of centres, the deviation is at most that at touch, divided by the cosine of half of
// the rotation.
template <class Law>
void separate_pair(IsolatedContact<Law>& l, SeparatedMembers& after, const PlanarContact& end,
                   const Vector3& normal, const Vector3& tangent, const double (&gravity)[3]) {
    const Member &a = l.before[0], &b = l.before[1];
    const double distance = l.pair.contact_distance, r = distance - end.compression;
    const double radial = end.radial_speed, tangential = end.tangential_speed;
    const double left = end.compression * (distance + r), along = r * radial;
    const double square = along * along + (radial * radial + tangential * tangential) * left;
    const double opening = left > 0.0 ? left / (along + math::sqrt(square)) : 0.0;
    l.span = end.duration + opening;
    const auto turn = math::sincos(end.turn);
    const double vn = radial * turn.cos - tangential * turn.sin,
                 vt = radial * turn.sin + tangential * turn.cos;
    const double rn = r * turn.cos + vn * opening, rt = r * turn.sin + vt * opening;
    const double per_total = 1.0 / (a.mass + b.mass), of_a = a.mass * per_total, of_b = b.mass * per_total;
    after[0] = a, after[1] = b;
    for (std::size_t k = 0; k < 3; ++k) {
        const double mean = of_a * a.velocity[k] + of_b * b.velocity[k], fall = gravity[k] * l.span;
        const double moved = l.span * (mean + 0.5 * fall);
        const double position = (rn - distance) * normal[k] + rt * tangent[k];
        const double velocity = vn * normal[k] + vt * tangent[k];
        after[0].position[k] += moved - of_b * position;
        after[1].position[k] += moved + of_a * position;
        after[0].velocity[k] = (mean + fall) - of_b * velocity;
        after[1].velocity[k] = (mean + fall) + of_a * velocity;
    }
    const double off_n = rn - l.span * vn - distance, off_t = rt - l.span * vt;
    const double per_cosine = 1.0001 / (1.0 - 0.125 * end.turn * end.turn);  // a lower bound of the cosine
    l.rotation = end.turn;
    l.deviation = per_cosine * math::sqrt(off_n * off_n + off_t * off_t);
    for (std::size_t k = 0; k < 3; ++k)
        l.initial_offset[k] = -per_cosine * (off_n * normal[k] + off_t * tangent[k]);
}

// The relative position at separation is that at the end of the force, followed for the time `opening`. Without gravity
// at a wall.
template <FrictionalLaw Law>
void separate_with_friction(ContactGroup<Law>& g, SeparatedMembers& after, const TurningContact& end,
                            double opening, const double (&gravity)[3]) {
    IsolatedContact<Law>& l = g.isolated_contact;
    const ContactPair<Law>& q = l.pair;
    const Member &a = l.before[0], &b = l.before[1];
    Vector3 moved;
    for (std::size_t k = 0; k < 3; ++k) moved[k] = end.shift[k] + opening * end.velocity[k];
    after[0] = a, after[1] = b;
    if (q.second < 0) {
        const auto axis = static_cast<std::size_t>(q.axis);
        for (std::size_t k = 0; k < 3; ++k) {
            after[0].position[k] -= moved[k];
            after[0].velocity[k] = -end.velocity[k];
        }
        after[0].velocity[axis] += q.wall_velocity;
        after[0].position[axis] = q.wall_position(l.span) + q.side * q.contact_distance;
        g.wall_impulse = q.side * (q.mass * (after[0].velocity[axis] - a.velocity[axis]));
        return;
    }
    const double per_total = 1.0 / (a.mass + b.mass), of_a = a.mass * per_total, of_b = b.mass * per_total;
    for (std::size_t k = 0; k < 3; ++k) {
        const double mean = of_a * a.velocity[k] + of_b * b.velocity[k], fall = gravity[k] * l.span;
        const double drift = l.span * (mean + 0.5 * fall);
        after[0].position[k] += drift - of_b * moved[k];
        after[1].position[k] += drift + of_a * moved[k];
        after[0].velocity[k] = (mean + fall) - of_b * end.velocity[k];
        after[1].velocity[k] = (mean + fall) + of_a * end.velocity[k];
    }
}

// Spins at the end, energies and the row of the log. `arm`: distance of the centres at the end, at a wall the radius.
template <FrictionalLaw Law>
void rub(IsolatedContact<Law>& l, const TurningApproach& touch, const TurningContact& end, double arm,
         const std::vector<Rotation>& rotations) {
    const auto slip = [](const Vector3& v, const Vector3& spin, const Vector3& normal, double distance) {
        return v - dot(v, normal) * normal - distance * cross(spin, normal);
    };
    const Vector3 change = end.spin - touch.spin;
    for (std::size_t m = 0; m < (l.body[1] < 0 ? 1u : 2u); ++m) {
        const Rotation& before = rotations[static_cast<std::size_t>(l.body[m])];
        const double lever = l.before[m].radius * touch.arm / before.inertia;
        l.surfaces.spin[m] = before.spin + (touch.effective_mass * lever / touch.rotational_ratio) * change;
    }
    l.surfaces.rubbed = end.tangential_spring + end.tangential_damping + end.slip;
    l.dissipated = end.normal_damping + end.normal_spring + l.surfaces.rubbed;
    const Vector3 first = slip(touch.velocity, touch.spin, touch.normal, touch.arm),
                  last = slip(end.velocity, end.spin, end.normal, arm);
    const double square = dot(first, first);
    l.contact.slid = end.slips_first || end.changes > 0;
    l.contact.tangential_speed = math::sqrt(square);
    l.contact.tangential_restitution = square > 0.0 ? -dot(last, first) / square : math::nan;
    l.pair.surfaces.slip = first;
}

template <class Law>
class IsolatedContacts {
public:
    using Group = ContactGroup<Law>;
    using IsolatedContact = boxes::IsolatedContact<Law>;

    // Largest rotation of the line of centres in a contact that is solved as isolated [rad].
    static constexpr double largest_rotation = 1.0;

    // Before the bodies are sorted.
    IsolatedContacts(std::size_t count, const Limits& limits, const Paths<Law>& paths,
                     const Frames<Law>& frames, const hardlimit_abi::TouchKernels& kernels)
        : limits_(limits),
          paths_(paths),
          frames_(frames),
          table_(contact_table(paths.laws(), count, kernels)) {}

    // Sets up the group of a new contact of body i with body j, or with a wall if j < 0, at the current time.
    void open(Group& g, int i, int j, WallId wall) const {
        g.alive = g.isolated = true;
        const std::size_t members = j >= 0 ? 2 : 1;
        g.body.resize(members);
        g.body[0] = i;
        if (j >= 0) g.body[1] = j;
        frames_.open(g);
        IsolatedContact& l = g.isolated_contact;
        l.body[0] = i, l.body[1] = j;
        for (std::size_t m = 0; m < members; ++m) frames_.set_member(g, m, l.before[m]);
        frames_.begin_shear_work(g, [&](std::size_t m) { return l.before[m].velocity; });
        if (j >= 0)
            frames_.set_pair(g, 0, 1, l.before[0], l.before[1], l.pair);
        else
            l.pair = frames_.wall_pair(g, 0, box_.wall(wall));
        l.pair.state = ContactState::closed;
        l.pair.fresh = true;
        l.pair.begin = paths_.now;
        if constexpr (FrictionalLaw<Law>) l.pair.surfaces.start = PairSurfaces<Law>::Start::touch;
    }
    // Solves the contact, and sets the safety radius of each member from its share of the deviation of the relative
    // path. Returns false if the contact does not end, or if a member moves too far for its cell or near another wall.
    bool solve(Group& g, SeparatedMembers& after) {
        IsolatedContact& l = g.isolated_contact;
        const Member(&b)[2] = l.before;
        if constexpr (FrictionalLaw<Law>) {
            if (!solve_with_friction(g, after)) return false;
        } else if (!(l.pair.second >= 0 ? solve_pair(g, after) : solve_wall(g, after)))
            return false;
        for (std::size_t m = 0; m < 2; ++m) {
            l.share[m] = l.body[1] < 0 ? 1.0 : b[1 - m].mass / (b[0].mass + b[1].mass);
            l.safety_radius[m] = l.share[m] * l.deviation * l.rotation;
        }
        return far_from_walls(g, after);
    }

private:
    const Limits& limits_;
    const Paths<Law>& paths_;
    const Box& box_ = paths_.box;
    const Frames<Law>& frames_;
    TabulatedContacts<Law, true> table_;

    // Solves the contact of two bodies in their plane of approach. Returns false if the contact does not end, or if a
    // member moves too far for its cell.
    bool solve_pair(Group& g, SeparatedMembers& after) {
        IsolatedContact& l = g.isolated_contact;
        ContactPair<Law>& q = l.pair;
        const Member &a = l.before[0], &b = l.before[1];
        Vector3 normal, v, tangent;
        for (std::size_t k = 0; k < 3; ++k) {
            normal[k] = (b.position[k] - a.position[k]) + q.image[k];
            v[k] = b.velocity[k] - a.velocity[k];
        }
        const double per_distance = 1.0 / math::sqrt(dot(normal, normal)),
                     approach = -dot(normal, v) * per_distance;
        for (double& x : normal) x *= per_distance;
        for (std::size_t k = 0; k < 3; ++k) tangent[k] = v[k] + approach * normal[k];
        const double tangential = math::sqrt(dot(tangent, tangent));
        if (!(approach > 0.0)) return false;
        const double per_tangential = tangential > 0.0 ? 1.0 / tangential : 0.0,
                     distance = q.contact_distance;
        for (double& x : tangent) x *= per_tangential;
        const Approach touch{q.mass, distance, approach, tangential};
        const PlanarContact end = table_(q.law, touch);
        if (end.outcome != Outcome::ok) return false;
        const double separation = end.radial_speed, tangential_after = end.tangential_speed;
        l.contact = {0, paths_.now, paths_.now + end.duration, approach, separation, false};
        q.impact_speed = approach;
        g.compression = end.greatest / math::min(a.radius, b.radius);
        l.dissipated = 0.5 * q.mass *
                       (end.speed_loss * (approach + separation) +
                        (tangential - tangential_after) * (tangential + tangential_after));
        set_virial(l, touch, end, normal, tangent);
        separate_pair(l, after, end, normal, tangent, box_.gravity);
        const double share = math::max(a.mass, b.mass) / (a.mass + b.mass);
        return g.compression < deepest_compression && end.turn < largest_rotation &&
               l.span * (approach + tangential) <= limits_.largest_displacement &&
               share * l.deviation <= limits_.largest_safety_radius;
    }
    // solve_pair() for a body and a wall that moves uniformly, in the frame of the wall. Contacts with an oscillating
    // wall are integrated as clusters.
    bool solve_wall(Group& g, SeparatedMembers& after) {
        IsolatedContact& l = g.isolated_contact;
        ContactPair<Law>& q = l.pair;
        const auto axis = static_cast<std::size_t>(q.axis);
        const Member& a = l.before[0];
        Vector3 v = a.velocity;
        v[axis] -= q.wall_velocity;
        const double approach = -q.side * v[axis], weight = -q.side * box_.gravity[axis];
        if (!(approach > 0.0) || box_.wall(q.wall_id).motion.oscillates()) return false;
        const PlanarContact end = table_(q.law, Approach{q.mass, math::infinity, approach, 0.0, weight});
        if (end.outcome != Outcome::ok) return false;
        const double square = end.radial_speed * end.radial_speed - 2.0 * weight * end.compression;
        if (square < 0.0) return false;
        const double opening =
            end.compression > 0.0 ? 2.0 * end.compression / (end.radial_speed + math::sqrt(square)) : 0.0;
        l.span = end.duration + opening;
        g.compression = end.greatest / a.radius;
        Member& to = after[0] = a;
        for (std::size_t k = 0; k < 3; ++k) {
            to.position[k] += l.span * (a.velocity[k] + 0.5 * box_.gravity[k] * l.span);
            to.velocity[k] += box_.gravity[k] * l.span;
        }
        to.position[axis] = q.wall_position(l.span) + q.side * q.contact_distance;
        const double out = end.radial_speed - weight * opening;
        to.velocity[axis] = q.side * out + q.wall_velocity;
        const double gained = to.velocity[axis] - a.velocity[axis] - l.span * box_.gravity[axis];
        g.wall_impulse = q.side * (q.mass * gained);
        l.dissipated =
            q.mass * (0.5 * end.speed_loss * (approach + end.radial_speed) + weight * end.compression);
        l.virial = {};  // counts pairs of bodies only
        l.contact = {0, paths_.now, paths_.now + end.duration, approach, end.radial_speed, false};
        q.impact_speed = approach;
        // The force per mass a keeps its direction: the deviation of the path is largest at touch, ∫ t a dt.
        const double off = 1.0001 * (l.span * (out + 0.5 * weight * l.span));
        l.rotation = 0.0, l.deviation = math::abs(off), l.initial_offset = {};
        l.initial_offset[axis] = -q.side * off;
        return g.compression < deepest_compression &&
               l.span * math::sqrt(dot(v, v)) <= limits_.largest_displacement &&
               l.deviation <= limits_.largest_safety_radius;
    }
    // Solves a contact with friction under a linear law, of two bodies or of a body and a wall that moves uniformly and
    // without gravity. Returns false if the contact needs another method, or if a member moves too far for its cell.
    bool solve_with_friction(Group& g, SeparatedMembers& after)
        requires FrictionalLaw<Law>
    {
        using Normal = typename Law::Frictionless;
        if constexpr (has_series<Normal>) {
            IsolatedContact& l = g.isolated_contact;
            ContactPair<Law>& q = l.pair;
            const FrictionTerms& friction = q.law.friction;
            const double steepest = angle_of_force(friction);
            if (!(steepest < steepest_force) || !TurningSeries<Normal>::applies(friction)) return false;
            if (q.second < 0 &&
                (dot(box_.gravity, box_.gravity) > 0.0 || box_.wall(q.wall_id).motion.oscillates()))
                return false;
            const TurningApproach touch = approach_of(l);
            if (!TurningSolver<Normal>::accepts(touch)) return false;
            TurningSeries<Normal, true> series(q.law, touch);
            const TurningContact end = series.integrate([](const auto&) {});
            if (end.outcome != Outcome::ok) return false;
            return end_with_friction(g, after, touch, end, series.greatest(), series.virial_tensor(),
                                     steepest);
        } else
            return false;
    }
    // Largest angle between the force and the normal that is solved as isolated [rad].
    static constexpr double steepest_force = 1.2;

    static double angle_of_force(const FrictionTerms& f) {
        const bool limited = f.limit == SlipLimit::total || f.damping.factor == 0.0;
        return limited && f.coefficient < 10.0 ? math::atan2_upper(f.coefficient, 1.0) : math::infinity;
    }
    // At a wall the body is the first one.
    TurningApproach approach_of(const IsolatedContact& l) const
        requires FrictionalLaw<Law>
    {
        const ContactPair<Law>& q = l.pair;
        const Member &a = l.before[0], &b = l.before[1];
        const Rotation& first = paths_.rotations[static_cast<std::size_t>(l.body[0])];
        const double lever = a.radius * a.radius / first.inertia;
        TurningApproach touch{q.mass, math::infinity, a.radius, q.mass * lever, {}, {}, first.spin};
        if (q.second < 0) {
            const auto axis = static_cast<std::size_t>(q.axis);
            for (std::size_t k = 0; k < 3; ++k) touch.velocity[k] = -a.velocity[k];
            touch.velocity[axis] += q.wall_velocity;
            touch.normal[axis] = -q.side;
            return touch;
        }
        const Rotation& second = paths_.rotations[static_cast<std::size_t>(l.body[1])];
        touch.distance = touch.arm = q.contact_distance;
        touch.rotational_ratio = q.mass * (lever + b.radius * b.radius / second.inertia);
        for (std::size_t k = 0; k < 3; ++k) {
            touch.normal[k] = (b.position[k] - a.position[k]) + q.image[k];
            touch.velocity[k] = b.velocity[k] - a.velocity[k];
            touch.spin[k] = (a.radius * first.spin[k] + b.radius * second.spin[k]) / q.contact_distance;
        }
        const double per_distance = 1.0 / math::sqrt(dot(touch.normal, touch.normal));
        for (double& x : touch.normal) x *= per_distance;
        return touch;
    }
    // Computes the states when the surfaces separate. The force keeps within the angle `steepest`, and the rotation,
    // of the normal at touch: at most this angle, seen from the outgoing path, is the deviation from the normal.
    bool end_with_friction(Group& g, SeparatedMembers& after, const TurningApproach& touch,
                           const TurningContact& end, double greatest, const SymmetricTensor& virial,
                           double steepest)
        requires FrictionalLaw<Law>
    {
        IsolatedContact& l = g.isolated_contact;
        ContactPair<Law>& q = l.pair;
        const bool wall = q.second < 0;
        const double approach = -dot(touch.velocity, touch.normal),
                     separation = dot(end.velocity, end.normal);
        const double r = wall ? 0.0 : q.contact_distance - end.compression;
        const double left = end.compression * (wall ? 1.0 : q.contact_distance + r);
        const double along = wall ? 0.5 * separation : r * separation;
        const double square = along * along + (wall ? 0.0 : dot(end.velocity, end.velocity) * left);
        if (!(separation > 0.0)) return false;
        const double opening = left > 0.0 ? left / (along + math::sqrt(square)) : 0.0;
        l.span = end.duration + opening;
        g.compression =
            greatest / (wall ? l.before[0].radius : math::min(l.before[0].radius, l.before[1].radius));
        separate_with_friction(g, after, end, opening, box_.gravity);
        q.impact_speed = approach;
        l.contact = {0, paths_.now, paths_.now + end.duration, approach, separation, false};
        rub(l, touch, end, wall ? touch.arm : r, paths_.rotations);
        l.virial = virial;
        const Vector3 turned = end.normal - touch.normal;
        const double half = math::min(0.5 * math::sqrt(dot(turned, turned)), 1.0);
        const double rotation = wall ? 0.0 : 2.0 * half * (1.0 + half * half);  // at least the angle
        const double cone = rotation + steepest, per_cosine = 1.0001 / (1.0 - 0.5 * cone * cone);
        double off = 0.0;  // along the normal
        for (std::size_t k = 0; k < 3; ++k)
            off += (end.shift[k] - end.duration * end.velocity[k]) * touch.normal[k];
        l.deviation = per_cosine * math::abs(off);
        l.rotation = math::sin(cone);
        for (std::size_t k = 0; k < 3; ++k) l.initial_offset[k] = l.deviation * touch.normal[k];
        const Vector3 v = touch.velocity;
        const double share =
            wall ? 1.0
                 : math::max(l.before[0].mass, l.before[1].mass) / (l.before[0].mass + l.before[1].mass);
        const double tangential = math::sqrt(dot(v, v) - approach * approach);
        return cone < largest_cone && g.compression < deepest_compression &&
               l.span * (approach + tangential) <= limits_.largest_displacement &&
               share * l.deviation <= limits_.largest_safety_radius;
    }
    static constexpr double largest_cone = 1.3;
    // Whether all members stay away from all other walls. A member is enlarged by its safety radius on its outgoing
    // parabola, which is closest to a wall at one of its ends or at its vertex.
    bool far_from_walls(const Group& g, const SeparatedMembers& after) const {
        if (!box_.any_wall()) return true;
        const IsolatedContact& l = g.isolated_contact;
        for (std::size_t m = 0; m < g.body.size(); ++m) {
            const double enlarged = paths_.radius(g.body[m]) + l.share[m] * l.deviation;
            for (int axis = 0; axis < box_.dimension; ++axis) {
                if (!box_.has_walls(axis)) continue;
                const auto a = static_cast<std::size_t>(axis);
                const double end = g.origin[a] + after[m].position[a], v = after[m].velocity[a];
                const double pull = box_.gravity[axis], back = v / pull;  // time from the vertex to the end
                const double begin = end - l.span * (v - 0.5 * pull * l.span);
                const double vertex = back > 0.0 && back < l.span ? end - 0.5 * v * back : end;
                const double least = math::min(math::min(begin, end), vertex);
                const double most = math::max(math::max(begin, end), vertex);
                const double needed = enlarged * (1.0 + rounding_of_touch);
                for (const bool high : {false, true}) {
                    const Wall wall = box_.wall(axis, high);
                    if (l.pair.second < 0 && l.pair.wall_id == wall.id) continue;
                    if (!wall.stays_beyond(needed, high ? most : least, paths_.now, paths_.now + l.span))
                        return false;
                }
            }
        }
        return true;
    }
};

}  // namespace hardlimit::boxes::events
