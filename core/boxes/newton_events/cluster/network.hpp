// The contact network of a cluster: its bodies, the pairs that may touch, the walls near them, and gravity.
#pragma once
#include <algorithm>
#include <cstddef>
#include <vector>

#include "../../binary_contact/planar_contact.hpp"
#include "records.hpp"

namespace hardlimit::boxes {

// A pair at one time: ξ, dξ/dt, distance of the centres (infinite at a wall), normal from the first body to the second.
struct ContactGeometry {
    double depth, rate, distance;
    Vector3 normal;
};

template <class Law>
struct ContactNetwork {
    using Pair = ContactPair<Law>;

    std::vector<Member> members;
    std::vector<Rotation> rotations;  // [members] with friction, otherwise empty
    std::vector<Pair> pairs;
    std::vector<WallPiece>
        wall_pieces;  // present pieces, by index() of the wall; empty if no wall oscillates
    Vector3 gravity{};
    bool planar = false;  // whether nothing leaves the plane of the first two axes
    double base = 0.0;    // absolute time at time = 0 [s]
    double time = 0.0;    // since `base` [s]

    // Keeps the allocated storage.
    void clear() {
        members.clear();
        rotations.clear();
        pairs.clear();
        wall_pieces.clear();
        base = time = 0.0;
    }

    bool any(ContactState state) const {
        return std::any_of(pairs.begin(), pairs.end(), [&](const Pair& q) { return q.state == state; });
    }
    bool all_open() const { return !any(ContactState::closed) && !any(ContactState::slack); }
    bool near_a_wall() const {
        return std::any_of(pairs.begin(), pairs.end(), [](const Pair& q) { return q.second < 0; });
    }
    bool has_sine() const {
        return std::any_of(pairs.begin(), pairs.end(), [&](const Pair& q) {
            return q.second < 0 && !wall_pieces.empty() && piece(q).amplitude != 0.0;
        });
    }
    // The largest velocity of an image of a pair [m/s].
    double image_speed() const {
        double most = 0.0;
        for (const Pair& q : pairs)
            if (q.image_moves) most = math::max(most, math::sqrt(dot(q.image_velocity, q.image_velocity)));
        return most;
    }
    double smaller_radius(const Pair& q) const {
        const double first = members[q.first].radius;
        return q.second < 0 ? first : math::min(first, members[q.second].radius);
    }

    // The geometry of a pair, from the positions and velocities of its bodies; at a wall those of the first only. One
    // variable is filled and returned: a copy of it would load words that are wider than those just stored, and stall.
    HL_FN_INLINE ContactGeometry geometry(const Pair& q, const double* xa, const double* va, const double* xb,
                                          const double* vb, double t) const {
        ContactGeometry g;
        if (q.second < 0)
            set_wall_geometry(q, xa, va, t, g);
        else
            set_geometry(q, xa, va, xb, vb, t, g);
        return g;
    }
    ContactGeometry geometry(const Pair& q) const {
        const Member &a = members[q.first], &b = members[q.second < 0 ? q.first : q.second];
        return geometry(q, a.position.data(), a.velocity.data(), b.position.data(), b.velocity.data(), time);
    }
    // Rate of approach of a pair [m/s], and distance between its surfaces [m].
    double rate(const Pair& q) const { return geometry(q).rate; }
    double gap(const Pair& q) const { return -geometry(q).depth; }
    double depth_root(const Pair& q) const {
        return q.rooted ? q.s : onset_root<Law::onset_power>(geometry(q).depth);
    }
    // Elastic energy of a pair, and of all pairs in this state, closed or slack [J].
    double stored(const Pair& q) const { return q.law.energy(math::max(depth_root(q), 0.0)); }
    double stored(ContactState state) const {
        double sum = 0.0;
        for (const Pair& q : pairs)
            if (q.state == state) sum += stored(q);
        return sum;
    }

    // Energy of the tangential spring of a pair, and of all closed pairs, at the end of the last run [J].
    double tangential(const Pair& q) const {
        if constexpr (FrictionalLaw<Law>) {
            const double k =
                q.law.friction.stiffness(math::power<Law::onset_power>(math::max(depth_root(q), 0.0)));
            if (q.state == ContactState::closed && k > 0.0)
                return 0.5 * dot(q.surfaces.elastic, q.surfaces.elastic) / k;
        }
        return 0.0;
    }
    double tangential() const {
        double sum = 0.0;
        for (const Pair& q : pairs) sum += tangential(q);
        return sum;
    }

    double wall_position(const Pair& q, double t) const {
        return wall_pieces.empty() ? q.wall_position(t) : piece(q).position(t);
    }
    double wall_velocity(const Pair& q, double t) const {
        return wall_pieces.empty() ? q.wall_velocity : piece(q).velocity(t);
    }
    double wall_acceleration(const Pair& q, double t) const {
        return wall_pieces.empty() ? 0.0 : piece(q).acceleration(t);
    }
    const WallPiece& piece(const Pair& q) const { return wall_pieces[q.wall_id.index()]; }

private:
    HL_FN_INLINE static void set_geometry(const Pair& q, const double* xa, const double* va, const double* xb,
                                          const double* vb, double t, ContactGeometry& g) {
        Vector3 v;
        for (std::size_t a = 0; a < 3; ++a) {
            g.normal[a] = (xb[a] - xa[a]) + q.image[a];
            v[a] = vb[a] - va[a];
        }
        if (q.image_moves) [[unlikely]]
            for (std::size_t a = 0; a < 3; ++a) {
                g.normal[a] += q.image_velocity[a] * t;
                v[a] += q.image_velocity[a];
            }
        g.distance = math::sqrt(dot(g.normal, g.normal));
        const double inverse = 1.0 / g.distance;
        for (double& x : g.normal) x *= inverse;
        g.depth = q.contact_distance - g.distance;
        g.rate = -dot(g.normal, v);
    }
    HL_FN_APART void set_wall_geometry(const Pair& q, const double* x, const double* v, double t,
                                       ContactGeometry& g) const {
        const double away = q.side * (x[q.axis] - wall_position(q, t));
        g.normal = {};
        g.normal[static_cast<std::size_t>(q.axis)] = -q.side;
        g.depth = q.contact_distance - away;
        g.rate = -q.side * (v[q.axis] - wall_velocity(q, t));
        g.distance = math::infinity;
    }
};

}  // namespace hardlimit::boxes
