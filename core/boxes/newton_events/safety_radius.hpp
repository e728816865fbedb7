// Whether the space that busy bodies claim holds their true paths: for tests.
#pragma once
#include "engine.hpp"

namespace hardlimit::boxes {

template <class Law>
double NewtonEvents<Law>::margin_used(int instants) const {
    double most = 0.0;
    Cluster<Law> c;
    for (const Group& g : groups_) {
        if (!g.alive) continue;
        start(g, c);
        const double span = pending_[g.body[0]].end - c.base;
        for (int k = 0; k <= instants; ++k) {
            const double time = span * k / instants;
            c.run_through(time);
            for (std::size_t m = 0; m < g.body.size(); ++m)
                most = math::max(most, margin_used(g, m, place(g, m, c.members[m].position), c.base + time));
        }
    }
    return most;
}

// That of a member at a place where it is at this time. In an undisturbed contact what it may need shrinks, and leads
// one way: a point that flies along at its true place must not be told to pass.
template <class Law>
double NewtonEvents<Law>::margin_used(const Group& g, std::size_t m, const Vector3& place,
                                      double time) const {
    const int i = g.body[m];
    const Vector3 path = position(i, time);
    const double rounding = 1e-10 * radius(i);  // and what a table of contacts is off
    Vector3 off;
    for (std::size_t a = 0; a < 3; ++a) off[a] = place[a] - path[a];
    const double far = math::sqrt(dot(off, off));
    if (!g.isolated) return far / (paths_[i].radius - radius(i) + rounding);
    if (passes({off, {}}, i, i, time, rounding - radius(i))) return math::infinity;
    const double left = math::max(pending_[i].end - time, 0.0) / g.lone.span;
    return far / (g.lone.share[pending_[i].first ? 0 : 1] * g.lone.margin * left + rounding);
}

}  // namespace hardlimit::boxes
