// Free fall of the lowest ball onto the floor.
#pragma once
#include "../base/math.hpp"

namespace hardlimit::column {

// Time until the ball touches the floor, NaN if it never does: the root of gap + v t − g t²/2 = 0 without cancellation.
// A ball that leaves the floor (gap 0, v > 0) touches it at 2v/g, not at 0.
HL_FN double fall_time(double gap, double velocity, double gravity) {
    if (gap <= 0.0 && !(velocity > 0.0)) return velocity < 0.0 || gravity > 0.0 ? 0.0 : math::nan;
    if (gravity == 0.0) return velocity < 0.0 ? -gap / velocity : math::nan;
    const double speed = math::sqrt(velocity * velocity + 2.0 * gravity * math::max(gap, 0.0));
    return velocity > 0.0 ? (velocity + speed) / gravity : 2.0 * gap / (speed - velocity);
}

// Speed at the floor, V = √(v1² + 2 g u).
HL_FN double impact_speed(double gap, double velocity, double gravity) {
    return math::sqrt(velocity * velocity + 2.0 * gravity * gap);
}

}  // namespace hardlimit::column
