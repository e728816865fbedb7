// Gauss-Legendre quadrature with eight nodes: ∫_0^1 f dt = Σ weight f(node), exact up to degree 15.
#pragma once
#include "../../base/math.hpp"

namespace hardlimit::boxes::quadrature {

using Eight = Vector<8>::Real;

inline constexpr Eight node = {0.01985507175123188, 0.10166676129318663, 0.2372337950418355,
                               0.4082826787521751,  0.5917173212478249,  0.7627662049581645,
                               0.8983332387068134,  0.9801449282487681};
inline constexpr Eight weight = {0.05061426814518813, 0.11119051722668724, 0.15685332293894363,
                                 0.18134189168918100, 0.18134189168918100, 0.15685332293894363,
                                 0.11119051722668724, 0.05061426814518813};

}  // namespace hardlimit::boxes::quadrature
