// Times until a particle in free flight meets a wall or leaves its cell.
#pragma once
#include "../common/box.hpp"

namespace hardlimit::boxes {

// Time during which x + v τ stays at or below `high`.
HL_FN double time_below(double x, double v, double high) {
    return v > 0.0 ? math::max(0.0, (high - x) / v) : math::infinity;
}

// Time to cover a distance at velocity v, both of the same sign; 0 if rounding has passed the end, infinity for v = 0.
HL_FN double time_to(double way, double v) {
    constexpr double standing[2] = {math::infinity, 0.0};
    return math::max(0.0, way / v) + standing[math::abs(v) > 0.0];
}

// Time during which x + v τ + g τ²/2 stays at or below `high`, if x ≤ high or v leads there. It is the last upward
// crossing for g > 0 and the first for g < 0, each computed without cancellation.
HL_FN double time_below(double x, double v, double g, double high) {
    if (g == 0.0) return time_below(x, v, high);
    const double room = v < 0.0 ? high - x : math::max(0.0, high - x);
    if (g > 0.0) {
        const double root = math::sqrt(math::max(0.0, v * v + 2.0 * g * room));
        return v > 0.0 ? 2.0 * room / (v + root) : (root - v) / g;
    }
    const double square = v * v + 2.0 * g * room;
    return v > 0.0 && square >= 0.0 ? 2.0 * room / (v + math::sqrt(square)) : math::infinity;
}

// Time after `now` at which a particle in free flight, at x with velocity v and acceleration g along the axis, comes
// within `reach` of a wall. The wall moves uniformly: collisions with a wall that accelerates would be located here.
HL_FN double wall_contact_time(const Wall& wall, double now, double x, double v, double g, double reach) {
    const double out = -wall.inward();
    return time_below(reach - wall.distance(x, now), out * (v - wall.velocity(now)), out * g, 0.0);
}

}  // namespace hardlimit::boxes
