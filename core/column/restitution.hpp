// The coefficient of restitution that the independent-collisions model would need.
#pragma once
#include "../math.hpp"

namespace hardlimit::column {

// ε that gives the relative velocity v_r in the ICM, v_r = ε (1 + ε) V (Eq. 4 inverted, in the stable form).
HL_FN double effective_restitution(double relative_velocity, double impact_speed) {
    const double ratio = relative_velocity / impact_speed;
    return ratio >= -0.25 ? 2.0 * ratio / (1.0 + math::sqrt(1.0 + 4.0 * ratio)) : math::nan;
}

}  // namespace hardlimit::column
