// Hertz contact of two elastic spheres of one material (H. Hertz, J. reine angew. Math. 92, 156 (1882)):
// F = ρ ξ^{3/2} with ρ = (4/3) E* √R_eff, where 1/E* = 2 (1 − ν²)/Y. So ρ = 2Y√R_eff/(3 (1 − ν²)) [N/m^{3/2}].
#pragma once
#include "law.hpp"

namespace hardlimit::contact {

inline constexpr Parameter youngs_modulus = positive("youngs_modulus", "Pa", "Young's modulus Y");
inline constexpr Parameter poisson_ratio{"poisson_ratio", "1", -1.0, 0.5, false, true, "Poisson's ratio ν"};

// ρ. 1 − ν² is computed as a product, which is accurate also for ν near −1.
HL_FN double hertz_prefactor(double youngs, double poisson, double effective_radius) {
    return 2.0 * youngs * math::sqrt(effective_radius) / (3.0 * ((1.0 - poisson) * (1.0 + poisson)));
}

}  // namespace hardlimit::contact
