// Solves one point of a map of N balls, given by its row of numbers (parameter_table.hpp). Used where the two-ball
// kernels do not apply: other numbers of balls, and results for each ball.
#pragma once
#include "../column/rebound.hpp"
#include "parameter_table.hpp"

namespace hardlimit::sweep {

// Settings common to all points of a map.
struct ColumnSetting {
    Model model;
    int alternative;                     // which of the law's parameter sets is given
    std::vector<unsigned char> density;  // [N] matter of a ball is its density, otherwise its mass
    double tolerance;                    // of the general solver
    bool rebound_heights, final_velocities;

    int balls() const { return static_cast<int>(density.size()); }
};

struct ColumnResult {
    column::Sequence sequence;
    std::vector<double> rebound_height, final_velocity;  // [N]; empty if not requested

    ColumnResult() { sequence.outcome = Outcome::invalid; }
};

// The column of a point. Null if the lowest ball would overlap the floor or the impact speed is zero or not finite.
template <class Law>
column::SharedColumn<Law> column_of(const ColumnSetting& setting, const double* p) {
    const int n = setting.balls();
    const auto at = [&](Field field) { return p + first_of(field, n); };
    const std::size_t balls = setting.density.size();
    column::Column<Law> c{.balls = n, .floor = true, .gravity = *at(Field::gravity)};
    c.radius.assign(at(Field::radius), at(Field::radius) + n);
    const double ratio = *at(Field::radius_ratio);
    if (n > 1 && !math::is_nan(ratio)) c.radius[0] = ratio * c.radius[1];
    c.velocity.assign(at(Field::velocity), at(Field::velocity) + n);
    c.gaps.assign(at(Field::gap), at(Field::gap) + n - 1);
    c.gaps.insert(c.gaps.begin(), *at(Field::height) - c.radius[0]);
    double sum = 0.0;
    for (std::size_t i = 0; i < balls; ++i) {
        c.mass.push_back(ball_mass(at(Field::matter)[i], setting.density[i] != 0, c.radius[i]));
        sum += c.mass[i];
        const double below = i == 0 ? math::infinity : c.mass[i - 1];
        const double size = i == 0 ? math::infinity : c.radius[i - 1];
        const PairGeometry pair{effective(c.mass[i], below), effective(c.radius[i], size)};
        c.contacts.push_back(
            Law::from_parameters(setting.alternative, p + law_of(static_cast<int>(i), n), pair));
    }
    if (!(c.gaps[0] >= 0.0)) return nullptr;
    const double speed = column::impact_speed(c.gaps[0], c.velocity[0], c.gravity);
    if (!(speed > 0.0) || !math::is_finite(sum + speed)) return nullptr;
    return std::make_shared<const column::Column<Law>>(std::move(c));
}

template <class Law>
ColumnResult solve_one(const ColumnSetting& setting, const double* p, Stop& stop) {
    ColumnResult r;
    const std::vector<double> none(setting.density.size(), math::nan);
    if (setting.rebound_heights) r.rebound_height = none;
    if (setting.final_velocities) r.final_velocity = none;
    const column::SharedColumn<Law> c = column_of<Law>(setting, p);
    if (!c) return r;
    r.sequence.outcome = Outcome::never_lands;
    if (math::is_nan(column::fall_time(c->gaps[0], c->velocity[0], c->gravity))) return r;
    column::SolveOptions options;
    options.tolerance = setting.tolerance;
    options.record = setting.rebound_heights || setting.final_velocities;
    options.stop = &stop;
    const std::unique_ptr<column::Solution> s = column::solve_column(c, setting.model, options);
    if (stop.stopped()) return r;  // the result of a stopped run is invalid
    r.sequence = s->sequence;
    if (setting.rebound_heights) r.rebound_height = column::rebound_heights(c, setting.model, options, *s);
    if (setting.final_velocities) r.final_velocity = column::final_velocities(*s, setting.balls());
    return r;
}

}  // namespace hardlimit::sweep
