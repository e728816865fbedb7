// Time transformation that makes the motion smooth at the beginning and end of a contact.
//
// A force like ξ^{3/2} has a singular derivative at touch, at which every integration method loses its order. While
// such a contact is closed its coordinate is s = ξ^{1/p} (p = onset_power of the law), in which the force is a
// polynomial, and the integration variable is τ with dt = γ dτ:
//   ds_j/dτ = (dξ_j/dt) γ/(p s_j^{p−1}),   1/γ² = 1 + Σ_j (s_j/ℓ_j)^{2−2p}   over the closed contacts,
// so that γ/s_j^{p−1} is bounded and smooth. Written relative to the smallest s it never divides by zero. γ has the
// sign of that s, so the solution is smooth through s = 0, which is a simple zero at the end of an elastic contact.
// (1/γ linear in 1/s would have a pole where two contacts end at the same instant.) For p = 1, s = ξ and γ = 1.
#pragma once
#include "../base/math.hpp"

namespace hardlimit {

// Returns γ from factor[j] = (s_j/ℓ_j)^{p−1} of the contacts and replaces factor[j] by γ/factor[j], which is at most 1.
// for_each(f) calls f(j) for each of these contacts.
template <class ForEach>
double smooth_time_rate(const ForEach& for_each, double* factor) {
    double smallest = 0.0;
    bool any = false;
    for_each([&](int j) {
        if (!any || math::abs(factor[j]) < math::abs(smallest)) smallest = factor[j];
        any = true;
    });
    if (!any) return 1.0;
    double square = smallest * smallest;
    for_each([&](int j) {
        factor[j] = factor[j] == smallest ? 1.0 : smallest / factor[j];  // several may be zero
        square += factor[j] * factor[j];
    });
    const double norm = math::sqrt(square);
    for_each([&](int j) { factor[j] /= norm; });
    return smallest / norm;
}

}  // namespace hardlimit
