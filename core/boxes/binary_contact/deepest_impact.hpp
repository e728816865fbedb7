// The largest compression that the collisions of a hard-sphere run would reach as contacts of the force law.
//
// A contact is solved only if its impact may be the deepest so far. Without damping a head-on impact reaches the depth
// e at which its energy is stored. An oblique impact reaches less: ξ² + 2 (v_t/v_n)² (e²/l) ξ = e² under the linear
// law, so that ξ <= e/(1 + (v_t/v_n)² e/l). Impacts are compared by this bound.
#pragma once
#include "planar_contact.hpp"

namespace hardlimit::boxes {

struct DeepestImpact {
    double bound = 0.0;              // largest bound so far, in units of the smaller radius
    double compression = math::nan;  // largest of the solved impacts, in units of the smaller radius
    bool too_deep = false;           // beyond deepest_compression: the run ends
};

// Updates `deepest` with one impact. radius: that of the smaller body [m].
template <class Law>
void note_impact(DeepestImpact& deepest, const Law& law, const Approach& a, double radius) {
    constexpr int p = Law::onset_power;
    const double energy = 0.5 * a.effective_mass * a.normal_speed * a.normal_speed;
    const double asked = math::min(deepest.bound, deepest_compression);
    if (!(energy > law.energy(onset_root<p>(asked * radius)))) return;
    const double s = roots::solve_power([&](double x) { return law.energy(x); }, energy);
    const double elastic = math::power<p>(s), share = a.tangential_speed / a.normal_speed;
    const double bound = elastic / (1.0 + share * share * (elastic / a.distance)) / radius;
    if (!(bound > asked)) return;
    deepest.bound = math::max(deepest.bound, bound);
    const PlanarContact contact = solve_planar_contact(law, a);
    const double given_up = PlanarSolver<Law>::deepest * a.distance;
    const double found = (contact.outcome == Outcome::too_deep ? given_up : contact.greatest) / radius;
    if (!(found <= deepest.compression)) deepest.compression = found;
    deepest.too_deep = found >= deepest_compression;
}

}  // namespace hardlimit::boxes
