// Dimensionless groups, units and initial state of two balls on a floor under the viscoelastic law.
//
// With gaps u, w, L1 = u + c1 u̇, L2 = w + c2 ẇ (c = 3A/2) and a force of −ρ √ξ L, ξ = −gap, while in contact:
//   ü = −G − a1 √ξ1 L1 [floor] + a2 √ξ2 L2 [pair],      ẅ = a1 √ξ1 L1 [floor] − √ξ2 L2 [pair],
// in units of length (m_eff V²/ρ12)^{2/5} and speed V: the equations of exact/motions.hpp with a factor √ξ in each
// force.
#pragma once
#include "../column/exact/scaling.hpp"
#include "../contact/viscoelastic.hpp"

namespace hardlimit::column {

// 1/(unit of time): (ρ/m)^{2/5} V^{1/5}.
HL_FN double viscoelastic_rate(double elastic_prefactor, double mass, double speed) {
    return math::pow(elastic_prefactor / mass, 0.4) * math::pow(speed, 0.2);
}

// Scales a problem, given the units.
HL_FN Start start_two_ball(const contact::Viscoelastic& floor, const contact::Viscoelastic& pair,
                           const TwoBalls& balls, const Units& units) {
    const double m1 = balls.m1, m2 = balls.m2, reduced = effective(m1, m2);
    const TwoBall groups = {
        {(floor.elastic_prefactor / pair.elastic_prefactor) * (reduced / m1), reduced / m1,
         1.5 * floor.dissipative_time * units.rate, 1.5 * pair.dissipative_time * units.rate,
         balls.gravity / (units.speed * units.rate)},
        upper_share(reduced, m1, m2)};
    return start_scaled(groups, units, balls.gravity, balls.released);
}

}  // namespace hardlimit::column
