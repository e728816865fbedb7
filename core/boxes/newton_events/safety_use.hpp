// For tests: how much of its safety radius a body in contact uses.
#pragma once
#include <algorithm>

#include "busy_bodies.hpp"
#include "clusters.hpp"

namespace hardlimit::boxes::events {

template <class Law>
struct SafetyUse {
    using Group = ContactGroup<Law>;

    const Paths<Law>& paths;
    const Groups<Law>& groups;
    const Frames<Law>& frames;
    const Clusters<Law>& clusters;
    const BusyBodies<Law>& busy;

    // The largest part that a body uses now and at `instants` later times.
    double largest(int instants) const {
        double most = 0.0;
        Cluster<Law> c;
        groups.for_all([&](int, const Group& g) {
            clusters.set_initial(g, c);
            const double span = paths.pending[g.body[0]].end - c.base;
            for (int k = 0; k <= instants; ++k) {
                const double since = span * k / instants, time = c.base + since;
                c.run_through(since);
                for (std::size_t m = 0; m < g.body.size(); ++m)
                    most = math::max(most,
                                     at(g, m, frames.body_position(g, m, c.members[m].position, time), time));
            }
        });
        return most;
    }

private:
    // Part of a member's safety radius that is used at its true position x. In an isolated contact the safety region
    // shrinks with time and lies on one side of the path: stays_clear() must be false for a point at the true position.
    double at(const Group& g, std::size_t m, const Vector3& x, double time) const {
        const int i = g.body[m];
        const Vector3 path = paths.position(i, time);
        const double radius = paths.radius(i);
        const IsolatedContact<Law>& l = g.isolated_contact;
        double rounding = 1e-10 * radius;  // including the error of a contact table
        if (g.isolated) rounding += speed_from_rounding(l.pair) * (time - l.contact.begin);
        Vector3 off;
        for (std::size_t a = 0; a < 3; ++a) off[a] = x[a] - path[a];
        const double far = math::sqrt(dot(off, off));
        if (!g.isolated) return far / (paths.particles[i].radius - radius + rounding);
        if (busy.stays_clear({off, {}}, i, i, time, rounding - radius)) return math::infinity;
        const double left = math::max(paths.pending[i].end - time, 0.0) / l.span;
        return far / (l.share[paths.pending[i].first ? 0 : 1] * l.deviation * left + rounding);
    }
    // Speed that two bodies gain from the compression by rounding at touch, which the solution of an isolated contact
    // leaves out. Under a law that is not linear an impact at a far lower speed lasts so long that this moves them
    // visibly.
    double speed_from_rounding(const ContactPair<Law>& q) const {
        const double depth = 4.0 * math::epsilon * *std::ranges::max_element(paths.box.edge);
        return math::sqrt(2.0 * q.law.energy(onset_root<Law::onset_power>(depth)) / q.mass);
    }
};

}  // namespace hardlimit::boxes::events
