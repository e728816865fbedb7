// Newton's equations for the state vector of a cluster, in the scaled time (contact/smooth_time.hpp).
#pragma once
#include <algorithm>
#include <vector>

#include "../../../contact/smooth_time.hpp"
#include "surfaces.hpp"

namespace hardlimit::boxes {

// The closed pairs at the state of the last evaluation, and what turns the directions of slip.
template <class Law>
struct SurfacesNow {};
template <FrictionalLaw Law>
struct SurfacesNow<Law> {
    struct Turning {
        double limit;  // μ F_n
        typename SurfacePair<Law>::Drive drive;
    };
    std::vector<SurfacePair<Law>> pairs;
    std::vector<Turning> turning;  // of the pairs that turn, in their order
};

template <class AnyLaw>
struct Equations {
    using Law = AnyLaw;
    static constexpr int p = Law::onset_power;

    const ContactNetwork<Law>& network;
    const StateLayout& layout;
    bool in_time = false;  // whether τ is the time
    mutable SurfacesNow<Law> surfaces{};

    // dy = dy/dτ
    void operator()(const double* y, double* dy) const {
        const int n = layout.members();
        const double gamma = clock_rate(y, dy);
        for (int i = 0; i < 3 * n; ++i) dy[i] = gamma * y[3 * n + i];
        for (int i = 3 * n; i < 6 * n; i += 3)
            for (std::size_t a = 0; a < 3; ++a) dy[static_cast<std::size_t>(i) + a] = network.gravity[a];
        if constexpr (FrictionalLaw<Law>) {
            std::fill(dy + layout.rubbed(), dy + layout.first_root(), 0.0);
            surfaces.pairs.clear(), surfaces.turning.clear();
        }
        Sums sums;
        int index = 0;
        for (const ContactPair<Law>& q : network.pairs) {
            if (q.state == ContactState::closed) add_contact(q, index, y, dy, sums, gamma);
            ++index;
        }
        if constexpr (p > 1) {
            for (int i = 3 * n; i < 6 * n; ++i) dy[i] *= gamma;
            if constexpr (FrictionalLaw<Law>)
                for (int i = layout.spin(0); i < layout.spin(n); ++i) dy[i] *= gamma;
        }
        dy[layout.time()] = gamma;
        dy[layout.loss()] = gamma * sums.loss;
        if (layout.walls_move()) dy[layout.wall_work()] = gamma * sums.wall_power;
        if (layout.images_move()) dy[layout.shear_work()] = gamma * sums.shear_power;
        for (std::size_t k = 0; k < SymmetricTensor::size; ++k)
            dy[static_cast<std::size_t>(layout.virial()) + k] = gamma * sums.virial.component[k];
        for (int k = 0; k < 2 * layout.walls(); ++k) dy[layout.wall_sums() + k] = gamma * sums.given[k];
        if constexpr (FrictionalLaw<Law>) {
            dy[layout.rubbed()] = gamma * sums.rubbed;
            turn_directions(y, dy);
        }
    }

    // Whether the direction in which a pair slips may turn in this step.
    bool turns(int pair) const
        requires FrictionalLaw<Law>
    {
        const ContactPair<Law>& q = network.pairs[pair];
        return q.state == ContactState::closed && q.surfaces.slips && !q.surfaces.frozen && !network.planar &&
               q.law.friction.stiffness.factor > 0.0;
    }

private:
    // Rates of the sums, per time.
    struct Sums {
        double loss = 0.0, wall_power = 0.0, shear_power = 0.0, rubbed = 0.0;
        SymmetricTensor virial;             // Σ r⊗F
        double given[2 * most_walls] = {};  // force on each wall of the pairs, and power that it gets
    };

    // Returns γ, and stores γ (ℓ/s)^{p−1} of each rooted contact in place of the derivative of its s.
    double clock_rate(const double* y, double* dy) const {
        if constexpr (p == 1) return 1.0;
        const auto for_rooted = [first = layout.first_root(), end = layout.virial()](const auto& f) {
            for (int c = first; c < end; ++c) f(c);
        };
        for (const int q : layout.rooted())
            dy[layout.root(q)] = math::power<p - 1>(y[layout.root(q)] / network.pairs[q].s_unit);
        if (in_time) {
            for_rooted([dy](int c) { dy[c] = 1.0 / dy[c]; });
            return 1.0;
        }
        return smooth_time_rate(for_rooted, dy);
    }

    // Adds the force of a closed contact to the accelerations of its bodies.
    HL_FN_INLINE void add_contact(const ContactPair<Law>& q, int index, const double* y, double* dy,
                                  Sums& sums, [[maybe_unused]] double gamma) const {
        const Snapshot<Law> now{network, layout, y};
        const ContactGeometry g = now.geometry(q);
        const double s = q.rooted ? y[layout.root(index)] : onset_root<p>(g.depth),
                     force = q.law.force(s, g.rate);
        const double lost = (force - q.law.elastic_force(s)) * g.rate;
        sums.loss += lost;
        if (q.second >= 0) sums.virial.add_square(force * g.distance, g.normal);
        if (q.image_moves) sums.shear_power -= force * dot(g.normal, q.image_velocity);
        if (q.second < 0) {
            const double work = force * q.side * network.wall_velocity(q, now.time());
            sums.wall_power += work;
            double* const of_wall = sums.given + (layout.wall_sums(q.wall_id) - layout.wall_sums());
            of_wall[0] += force, of_wall[1] += lost - work;
        }
        double *a = dy + layout.velocity(q.first), *b = dy + layout.velocity(q.second);
        for (std::size_t k = 0; k < 3; ++k) {
            const double along = force * g.normal[k];
            a[k] -= along / network.members[q.first].mass;
            if (q.second >= 0) b[k] += along / network.members[q.second].mass;
        }
        if constexpr (FrictionalLaw<Law>)
            add_friction(q, surfaces.pairs.emplace_back(now, index, g), dy, sums, gamma);
        if (q.rooted) {
            double& slope = dy[layout.root(index)];
            slope = g.rate / p * slope / math::power<p - 1>(q.s_unit);
        }
    }
    // Adds the tangential force of a closed contact, and the rate of T if the surfaces stick.
    void add_friction(const ContactPair<Law>& q, const auto& at, double* dy, Sums& sums, double gamma) const
        requires FrictionalLaw<Law>
    {
        const int index = at.pair();
        const Vector3 push = at.push(), torque = cross(at.g.normal, push);
        const double power = dot(push, at.slip);
        sums.loss += power;
        sums.rubbed += power;
        if (q.second >= 0) sums.virial.add_product(-at.g.distance, at.g.normal, push);
        if (q.image_moves) sums.shear_power += dot(push, q.image_velocity);
        if (q.second < 0) sums.given[layout.wall_sums(q.wall_id) - layout.wall_sums() + 1] += power;
        const auto act = [&](int member, double sign, double arm) {
            double *v = dy + layout.velocity(member), *w = dy + layout.spin(member);
            const double mass = network.members[member].mass, inertia = network.rotations[member].inertia;
            for (std::size_t k = 0; k < 3; ++k) {
                v[k] += sign * push[k] / mass;
                w[k] += arm * torque[k] / inertia;
            }
        };
        act(q.first, 1.0, at.first_arm);
        if (q.second >= 0) act(q.second, -1.0, at.second_arm);
        if (q.surfaces.slips || !at.has_spring()) return;
        // γ s^n, also where s and γ are zero
        const int n = at.memory_power();
        const double stretched = n >= 0 ? gamma * whole_power(at.s, n)
                                 : q.rooted
                                     ? dy[layout.root(index)] * whole_power(at.s / q.s_unit, n + p - 1) *
                                           math::pow(q.s_unit, double(n))
                                 : at.s > 0.0 ? gamma / whole_power(at.s, -n)
                                              : 0.0;
        const double stiffness = q.law.friction.stiffness.factor * stretched;
        const Vector3 still = at.transport(at.memory());
        for (std::size_t k = 0; k < 3; ++k)
            dy[static_cast<std::size_t>(layout.surface(index)) + k] =
                stiffness * at.slip[k] + gamma * still[k];
    }
    // Adds the rates of the directions of pairs that slip.
    void turn_directions(const double* y, double* dy) const
        requires FrictionalLaw<Law>
    {
        for (const SurfacePair<Law>& at : surfaces.pairs) {
            const int q = at.pair();
            if (!network.pairs[q].surfaces.slips || !at.has_spring()) continue;
            double* slope = dy + layout.surface(q);
            const Vector3 still = at.transport(at.memory());
            for (std::size_t k = 0; k < 3; ++k) slope[k] = dy[layout.time()] * still[k];
            if (!turns(q)) continue;
            const auto& drive = surfaces.turning.emplace_back(at.limit(), at.drive(dy)).drive;
            const double across = drive.across, z = y[layout.surface(q) + 3];
            if (across != 0.0 && at.limit() != 0.0) slope[3] = 0.5 * (1.0 + z * z) * across / at.limit();
        }
    }
};

}  // namespace hardlimit::boxes
