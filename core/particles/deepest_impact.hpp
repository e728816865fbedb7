// The impact of an event-driven run that presses its bodies deepest, if the contact law is followed.
//
// Impacts are compared by their energy: by the compression at which an undamped contact would have stored it, over the
// smaller radius. Only the contact of the deepest one is solved, when its compression is asked for or near the limit.
#pragma once
#include "planar_contact.hpp"

namespace hardlimit::particles {

struct DeepestImpact {
    double elastic = 0.0;       // compression without damping, over the smaller radius
    double radius = math::nan;  // the smaller [m]
    Approach approach{};
    PairGeometry pair{};
    bool too_deep = false;  // beyond deepest_compression
};

// Its greatest compression over the smaller radius; NaN before any impact. Where the solver gives up, what it got to.
template <class Law>
double compression_of(const DeepestImpact& impact, const Law& law) {
    const PlanarContact contact = solve_planar_contact(law, impact.approach);
    const double given_up = PlanarRun<Law>::deepest * impact.approach.distance;
    return (contact.outcome == Outcome::too_deep ? given_up : contact.greatest) / impact.radius;
}

template <class Law>
void note_impact(DeepestImpact& deepest, const Law& law, const Approach& a, PairGeometry pair,
                 double radius) {
    constexpr int p = Law::onset_power;
    const double energy = 0.5 * a.effective_mass * a.normal_speed * a.normal_speed;
    if (!(energy > law.energy(onset_root<p>(deepest.elastic * radius)))) return;
    const double s = column::newton::solve_power([&](double x) { return law.energy(x); }, energy);
    deepest = {column::newton::power<p>(s) / radius, radius, a, pair};
    deepest.too_deep =
        deepest.elastic >= deepest_compression && compression_of(deepest, law) >= deepest_compression;
}

}  // namespace hardlimit::particles
