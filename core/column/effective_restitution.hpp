// The coefficient of restitution that reproduces a relative velocity in the independent-collisions model (ICM).
#pragma once
#include "../base/math.hpp"

namespace hardlimit::column {

// Solves v_r = ε (1 + ε) V for ε (inverse of Eq. 4), in the form without cancellation.
template <class R>
HL_FN R effective_restitution(R relative_velocity, R impact_speed) {
    const R ratio = relative_velocity / impact_speed;
    return select<R>(ratio >= -0.25, 2.0 * ratio / (1.0 + math::sqrt<R>(1.0 + 4.0 * ratio)),
                     broadcast<R>(math::nan));
}

}  // namespace hardlimit::column
