// Solves one point of a two-ball map with the scalar solvers.
#pragma once
#include "../column/exact/drop.hpp"
#include "../column/general/sample.hpp"
#include "../column/independent.hpp"
#include "parameters.hpp"

namespace hardlimit::sweep {

// The result of a stopped run is invalid.
template <class Law>
PointResult solve_point(const Setting& setting, Parameters p, Stop& stop) {
    PointResult r;
    if (!math::is_nan(p.radius_ratio)) p.radius_1 = p.radius_ratio * p.radius_2;
    const double height = p.height - p.radius_1;
    if (!(height >= 0.0)) return r;
    const double m1 = ball_mass(p.matter_1, setting.density_1, p.radius_1);
    const double m2 = ball_mass(p.matter_2, setting.density_2, p.radius_2);
    const double speed = column::impact_speed(height, p.velocity_1, p.gravity);
    if (!(speed > 0.0) || !math::is_finite(m1 + m2 + speed)) return r;
    const PairGeometry floor{m1, p.radius_1}, pair{effective(m1, m2), effective(p.radius_1, p.radius_2)};
    const Law floor_law = Law::from_parameters(setting.alternative, p.floor_law, floor);
    const Law pair_law = Law::from_parameters(setting.alternative, p.pair_law, pair);
    const column::Gaps start{height, p.velocity_1, p.gap, p.velocity_2 - p.velocity_1};
    if constexpr (column::has_exact_solver<Law>) {
        if (setting.model != Model::independent) {
            const column::Start s = column::start_two_ball(
                floor_law, pair_law, m1, m2, p.gravity, start,
                setting.model == Model::newton ? column::Coupling::full : column::Coupling::adiabatic);
            r.outcome = s.outcome;
            if (s.outcome != Outcome::ok) return r;
            const column::CompressionBound bound =
                bound_of(setting, p, {height, m1, m2}, floor_law, pair_law);
            column::Sequence q = column::drop::sequence_of(s, bound, p.gap, -math::infinity, &stop);
            column::to_si(q, s.units);
            finish(q, setting, p, speed, r);
            return r;
        }
    }
    const column::Column<Law> c{2,
                                true,
                                p.gravity,
                                {m1, m2},
                                {p.radius_1, p.radius_2},
                                {floor_law, pair_law},
                                {height, p.gap},
                                {p.velocity_1, p.velocity_2}};
    if (math::is_nan(column::fall_time(height, p.velocity_1, p.gravity))) {
        r.outcome = Outcome::never_lands;
    } else if (setting.model == Model::independent) {
        finish(column::solve_independent(c, math::nan, &stop).sequence, setting, p, speed, r);
    } else {
        column::IntegrateOptions options;
        options.tolerance = setting.tolerance;
        options.stop = &stop;
        finish(column::integrate(c, options).sequence, setting, p, speed, r);
    }
    return r;
}

}  // namespace hardlimit::sweep
