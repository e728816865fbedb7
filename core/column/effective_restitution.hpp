// The coefficient of restitution that the independent-collisions model would need.
#pragma once
#include "../base/math.hpp"

namespace hardlimit::column {

// ε that gives the relative velocity v_r in the ICM, v_r = ε (1 + ε) V (Eq. 4 inverted, in the stable form).
template <class R>
HL_FN R effective_restitution(R relative_velocity, R impact_speed) {
    const R ratio = relative_velocity / impact_speed;
    return select<R>(ratio >= -0.25, 2.0 * ratio / (1.0 + math::sqrt<R>(1.0 + 4.0 * ratio)),
                     broadcast<R>(math::nan));
}

}  // namespace hardlimit::column
