// Whether the space that busy bodies claim holds their true paths: for tests.
#pragma once
#include "newton_events.hpp"

namespace hardlimit::particles {

template <class Law>
double NewtonEvents<Law>::margin_used(int instants) const {
    double most = 0.0;
    for (const Group& g : groups_) {
        if (!g.alive) continue;
        Cluster<Law> c = start_of(g);
        const double span = end_[g.body[0]] - c.base;
        for (int k = 0; k <= instants; ++k) {
            const double time = span * k / instants;
            Stop never;
            c.run(time, never);
            // Where all have parted before, they fly on.
            const double after = time - c.time;
            for (std::size_t m = 0; m < g.body.size(); ++m) {
                Vector3 x = c.members[m].position;
                for (std::size_t a = 0; a < 3; ++a)
                    x[a] += after * (c.members[m].velocity[a] + 0.5 * after * gravity_[a]);
                most = math::max(most, margin_used(g, m, place(g, m, x), c.base + time));
            }
        }
    }
    return most;
}

// That of a member at a place where it is at this time. In an undisturbed contact what it may need shrinks as passes()
// has it, and so does what it may need sideways.
template <class Law>
double NewtonEvents<Law>::margin_used(const Group& g, std::size_t m, const Vector3& place,
                                      double time) const {
    const int i = g.body[m];
    const Vector3 path = position(i, time);
    const double rounding = 1e-10 * radius(i);  // and what a table of contacts is off
    Vector3 off;
    for (std::size_t a = 0; a < 3; ++a) off[a] = place[a] - path[a];
    if (!g.isolated) return math::sqrt(dot(off, off)) / (paths_[i].radius - radius(i) + rounding);
    const double left = math::max(end_[i] - time, 0.0) / g.lone.span;
    const double margin = share_of(g, m) * g.lone.margin * left;
    const double length = (m == 0 ? -1.0 : 1.0) * math::sqrt(dot(g.lone.off, g.lone.off));
    const double along = dot(off, g.lone.off) / length;
    for (std::size_t a = 0; a < 3; ++a) off[a] -= along / length * g.lone.off[a];
    if (along < -rounding) return math::infinity;
    const double across = math::sqrt(dot(off, off));
    return math::max(along / (margin + rounding), across / (margin * g.lone.turn + rounding));
}

}  // namespace hardlimit::particles
