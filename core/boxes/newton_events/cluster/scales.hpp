// Scales of the motion in a cluster, from its energy.
#pragma once
#include "network.hpp"

namespace hardlimit::boxes {

// Velocity to which the speeds of a cluster are relative: of the centre of mass, or near walls that of the walls [m/s].
template <class Law>
Vector3 frame_velocity(const ContactNetwork<Law>& network) {
    Vector3 mean{};
    if (network.near_a_wall()) {
        for (const ContactPair<Law>& q : network.pairs)
            if (q.second < 0) mean[static_cast<std::size_t>(q.axis)] = network.wall_velocity(q, network.time);
        return mean;
    }
    double mass = 0.0;
    for (const Member& m : network.members) {
        mass += m.mass;
        for (std::size_t a = 0; a < 3; ++a) mean[a] += m.mass * m.velocity[a];
    }
    for (double& x : mean) x /= mass;
    return mean;
}

class Scales {
public:
    double mass = 0.0;  // of the lightest member [kg]
    double speed =
        0.0;  // upper bound on a member's speed relative to the others, or to walls if one may be touched [m/s]

    Scales() = default;
    // The speed is that of the lightest member with all energy, kinetic in the cluster's frame, of spins and elastic. A
    // second wall with another velocity, a wall that changes its velocity, or a moving image does work in this frame:
    // it may add several times this difference. Bodies may lie at rest: gravity adds its speed within a millionth of a
    // radius.
    template <class Law>
    explicit Scales(const ContactNetwork<Law>& network) {
        double smallest = math::infinity, energy = 0.0;
        const Vector3 mean = frame_velocity(network);
        mass = math::infinity;
        for (const Member& m : network.members) {
            mass = math::min(mass, m.mass);
            smallest = math::min(smallest, m.radius);
            for (std::size_t a = 0; a < 3; ++a)
                energy += 0.5 * m.mass * (m.velocity[a] - mean[a]) * (m.velocity[a] - mean[a]);
        }
        for (const ContactPair<Law>& q : network.pairs)
            if (q.state == ContactState::closed) energy += q.law.energy(network.depth_root(q));
        if constexpr (FrictionalLaw<Law>) {
            energy += network.tangential();
            for (const Rotation& r : network.rotations) energy += 0.5 * r.inertia * dot(r.spin, r.spin);
        }
        const double fall = 1e-6 * smallest * math::sqrt(dot(network.gravity, network.gravity));
        speed = math::max(math::sqrt(2.0 * energy / mass + fall) + gain(network, mean), slowest_approach);
    }

    double energy() const { return 0.5 * mass * speed * speed; }

    // Of the fastest closed contact; if there is none, of the fastest that has scales [s].
    template <class Law>
    double time(const ContactNetwork<Law>& network) const {
        double least = math::infinity, least_open = math::infinity;
        for (const ContactPair<Law>& q : network.pairs) {
            double& of = q.state == ContactState::closed ? least : least_open;
            if (q.scaled) of = math::min(of, q.depth_unit);
        }
        return (least < math::infinity ? least : least_open) /
               speed;  // without a contact: in flight over a sine
    }

    // Sets the scales of a pair, unless it has them. `compressed`: largest compression so far.
    template <class Law>
    void set(ContactPair<Law>& q, const ContactNetwork<Law>& network, double compressed) const {
        if (q.scaled) return;
        const double least = math::min(q.mass, mass);  // no contact has more energy than the lightest member
        if constexpr (LinearLaw<Law>) {
            q.s_unit = speed * math::sqrt(least / q.law.elastic_force(1.0));
        } else {
            const double most = 0.5 * least * speed * speed;
            q.s_unit = roots::solve_power([&](double x) { return q.law.energy(x); }, most);
        }
        q.depth_unit = math::power<Law::onset_power>(q.s_unit);
        const double most = most_energy(network);
        const auto may_reach = [&](double part) {
            return q.law.energy(onset_root<Law::onset_power>(part * network.smaller_radius(q))) <= most;
        };
        q.may_be_too_deep = may_reach(deepest_compression);
        q.may_be_deepest = may_reach(compressed);
        q.scaled = true;
    }
    // Sets those of all closed pairs, or of all pairs if none is closed.
    template <class Law>
    void set_active(ContactNetwork<Law>& network, double compressed) const {
        const bool in_contact = network.any(ContactState::closed);
        for (ContactPair<Law>& q : network.pairs)
            if (q.state == ContactState::closed || !in_contact) set(q, network, compressed);
    }

private:
    template <class Law>
    static double gain(const ContactNetwork<Law>& network, const Vector3& mean) {
        double most = 4.0 * network.image_speed();
        for (const ContactPair<Law>& q : network.pairs) {
            if (q.second >= 0) continue;
            const double other =
                network.wall_velocity(q, network.time) - mean[static_cast<std::size_t>(q.axis)];
            const double change = network.wall_pieces.empty() ? 0.0 : 2.0 * network.piece(q).motion.fastest();
            most = math::max(most, 4.0 * math::abs(other) + change);
        }
        return most;
    }
    // Upper bound on the energy that one contact can store: all energy, and the work of each member's weight, or of its
    // inertia on an accelerated wall, over its radius [J].
    template <class Law>
    double most_energy(const ContactNetwork<Law>& network) const {
        double pull = math::sqrt(dot(network.gravity, network.gravity)), sum = energy();
        for (const WallPiece& p : network.wall_pieces)
            pull = math::max(pull, p.motion.greatest_acceleration());
        for (const Member& m : network.members) sum += m.mass * pull * m.radius;
        return sum;
    }
};

}  // namespace hardlimit::boxes
