// Solves one point of a two-ball map with the scalar solvers.
#pragma once
#include "../column/solve.hpp"
#include "parameters.hpp"

namespace hardlimit::sweep {

// The result of a stopped run is invalid.
template <class Law>
PointResult solve_point(const Setting& setting, Parameters p, Stop& stop) {
    PointResult r;
    Bodies b;
    if (!measure(setting, p, b)) return r;
    const double speed = column::impact_speed(b.height, p.velocity_1, p.gravity);
    if (!(speed > 0.0) || !math::is_finite(b.m1 + b.m2 + speed)) return r;
    const PairGeometry floor{b.m1, p.radius_1};
    const PairGeometry pair{effective(b.m1, b.m2), effective(p.radius_1, p.radius_2)};
    const column::Column<Law> c{.balls = 2,
                                .floor = true,
                                .gravity = p.gravity,
                                .mass = {b.m1, b.m2},
                                .radius = {p.radius_1, p.radius_2},
                                .contacts = {Law::from_parameters(setting.alternative, p.floor_law, floor),
                                             Law::from_parameters(setting.alternative, p.pair_law, pair)},
                                .gaps = {b.height, p.gap},
                                .velocity = {p.velocity_1, p.velocity_2}};
    r.outcome = Outcome::never_lands;
    if (math::is_nan(column::fall_time(b.height, p.velocity_1, p.gravity))) return r;
    column::SolveOptions options;
    options.tolerance = setting.tolerance;
    options.stop = &stop;
    finish(column::solve_sequence(c, setting.model, options, nullptr), setting, p, speed, r);
    return r;
}

}  // namespace hardlimit::sweep
