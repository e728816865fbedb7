// Bodies enter groups and leave them.
//
// Until its group ends, a member is for all other bodies a larger body on a parabola: its radius grows by a safety
// radius, the largest distance between its true path and that parabola. The parabola of a cluster's member connects
// both ends of its path; collisions beyond the end are predicted at the end. The parabola of a body in an isolated
// contact is its outgoing path, extrapolated back from the end: collisions after the contact are predicted at its
// begin, and the end changes only the body's radius.
#pragma once
#include <algorithm>
#include <memory>

#include "clusters.hpp"
#include "groups.hpp"
#include "isolated_contacts.hpp"
#include "ledger.hpp"

namespace hardlimit::boxes::events {

template <class Law>
struct Membership {
    using Group = ContactGroup<Law>;

    const Limits& limits;
    Paths<Law>& paths;
    Groups<Law>& groups;
    const Frames<Law>& frames;
    const Clusters<Law>& clusters;
    Ledger<Law>& ledger;

    // Puts the members of an integrated cluster on their parabolas, with their safety radii. Returns whether the cells
    // are wide enough for these.
    bool connect_ends(int index) {
        const Group& g = groups[index];
        const Cluster<Law>&before = g.cluster->before, &after = g.cluster->after;
        bool fits = true;
        for (std::size_t m = 0; m < g.body.size(); ++m) {
            join(index, m, after.time);
            paths.set_safety_radius(g.body[m], 0.0);
            if (!(after.time > 0.0)) continue;
            follow_chord(g, m, before.members[m], after.members[m], after.time);
            const double safety_radius = deviation_from_path(g, m);
            paths.set_safety_radius(g.body[m], safety_radius);
            fits = fits && safety_radius <= limits.largest_safety_radius;
        }
        return fits;
    }
    // Puts the members of an isolated contact on their outgoing paths.
    void follow_outgoing(int index, const SeparatedMembers& after) {
        const Group& g = groups[index];
        const IsolatedContact<Law>& l = g.isolated_contact;
        for (std::size_t m = 0; m < g.body.size(); ++m) {
            const int i = l.body[m];
            Particle<3>& p = paths.particles[i];
            join(index, m, l.span);
            paths.set_safety_radius(i, l.share[m] * l.deviation);
            for (std::size_t a = 0; a < 3; ++a) {
                const double v = after[m].velocity[a] - l.span * paths.box.gravity[a];
                const double x = after[m].position[a] - l.span * (v + 0.5 * l.span * paths.box.gravity[a]);
                p.velocity[a] = v;
                p.position[a] += x - l.before[m].position[a];
            }
            p.velocity[0] -= frames.cell_velocity(g, m);
        }
    }
    // Reverts both: the members are free bodies at their present positions.
    void revert(int index) {
        const Group& g = groups[index];
        for (std::size_t m = 0; m < g.body.size(); ++m)
            free(g, m, g.isolated ? g.isolated_contact.before[m] : g.cluster->before.members[m]);
        groups.discard(index);
    }
    // Ends a group at the current time: all members become free bodies, and `active` receives the pairs still active.
    void dissolve(int index, bool at_end, ActivePairs<Law>& active) {
        Group& g = groups[index];
        if (!g.cluster) g.cluster = std::make_unique<ClusterStates<Law>>();
        Cluster<Law>& c = g.cluster->after;
        if (!at_end) {
            clusters.set_initial(g, c);
            c.run_through(paths.now - c.base);
            if (c.unresolved) ledger.end_run(Outcome::unresolved, g.body);
        }
        add_cluster(ledger.sums, c, c.dissipated, c.walls,
                    frames.shear_work(g, [&](std::size_t m) { return c.members[m].velocity; }));
        if (!g.isolated) ledger.clustered += (paths.now - c.base) * static_cast<double>(g.body.size());
        for (const EndedContact& e : c.ended)
            ledger.end_contact(g, c.pairs[static_cast<std::size_t>(e.pair)], e);
        for (std::size_t m = 0; m < g.body.size(); ++m) {
            free(g, m, c.members[m]);
            if constexpr (FrictionalLaw<Law>)
                paths.rotations[static_cast<std::size_t>(g.body[m])] = c.rotations[m];
            ++paths.pending[g.body[m]].count;
        }
        for (const ContactPair<Law>& q : c.pairs) {
            if (q.state == ContactState::open) continue;
            const int second = q.second < 0 ? -1 : g.body[static_cast<std::size_t>(q.second)];
            active.push_back({g.body[static_cast<std::size_t>(q.first)], second, q});
        }
        groups.discard(index);
    }

private:
    // Frees a member at its position and velocity in the frame of the group.
    void free(const Group& g, std::size_t m, const Member& at) {
        paths.release(g.body[m], frames.body_position(g, m, at.position, paths.now),
                      frames.body_velocity(g, m, at.velocity));
    }
    void join(int index, std::size_t m, double span) {
        const Group& g = groups[index];
        paths.join(g.body[m], index, m == 0, !g.isolated, paths.now + span);
    }
    // Puts a member of a cluster on the parabola through both ends of its path.
    void follow_chord(const Group& g, std::size_t m, const Member& before, const Member& after, double span) {
        Particle<3>& p = paths.particles[g.body[m]];
        for (std::size_t a = 0; a < 3; ++a)
            p.velocity[a] =
                (after.position[a] - before.position[a]) / span - 0.5 * span * paths.box.gravity[a];
        p.velocity[0] -= frames.cell_velocity(g, m);
    }
    // Largest distance of a member's true path from its parabola. Between steps the chord deviation is added. If that
    // is unknown, the distance is close to a cubic within a step: it exceeds its values at the ends by at most a
    // quarter of the step times the larger slope, and 0.3 of it leaves a margin for the terms of higher order.
    double deviation_from_path(const Group& g, std::size_t m) const {
        const std::size_t n = g.body.size();
        const Vector3& x0 = g.cluster->before.members[m].position;
        Vector3 chord;
        std::copy_n(paths.particles[g.body[m]].velocity, 3, chord.begin());
        chord[0] += frames.cell_velocity(g, m);
        const Trajectory& trajectory = g.cluster->after.trajectory;
        double largest = 0.0, last = 0.0, last_rate = 0.0, last_time = 0.0;
        for (std::size_t k = 0; k < trajectory.time.size(); ++k) {
            const double t = trajectory.time[k];
            const double *x = &trajectory.state[6 * n * k + 3 * m], *v = x + 3 * n;
            double off = 0.0, rate = 0.0;
            for (std::size_t a = 0; a < 3; ++a) {
                const double gt = paths.box.gravity[a] * t;
                const double e = x[a] - (x0[a] + t * (chord[a] + 0.5 * gt));
                const double d = v[a] - (chord[a] + gt);
                off += e * e;
                rate += d * d;
            }
            off = math::sqrt(off);
            rate = math::sqrt(rate);
            const bool known = !trajectory.chord_deviation.empty();
            const double chord_deviation = known ? trajectory.chord_deviation[n * k + m]
                                                 : 0.3 * (t - last_time) * math::max(rate, last_rate);
            largest = math::max(largest, math::max(off, last) + chord_deviation);
            last = off;
            last_rate = rate;
            last_time = t;
        }
        return 1.01 * largest;
    }
};

}  // namespace hardlimit::boxes::events
