// One point of a map: two balls from their physical parameters to the numbers a sweep keeps.
#pragma once
#include "../column/drop.hpp"
#include "../column/independent.hpp"
#include "../column/integrate.hpp"

namespace hardlimit::sweep {

enum class Model : int { newton = 0, adiabatic = 1, independent = 2 };

// The physical parameters of a point. Mass or density of each ball, whichever the user gave; a radius ratio that is
// not NaN replaces the lower radius.
struct Parameters {
    double radius_1, radius_2, radius_ratio, matter_1, matter_2, gap, height, velocity_1, velocity_2, gravity;
    double floor_law[max_parameters], pair_law[max_parameters];
};
inline constexpr int parameter_count = 10 + 2 * max_parameters;
static_assert(sizeof(Parameters) == parameter_count * sizeof(double));

// What all points have in common.
struct Setting {
    Model model;
    int alternative;               // of the law's parameters
    bool density_1, density_2;     // matter is a density, else a mass
    int restitution_at;            // place of ε among the law's parameters; -1: the law was not given by ε
};

struct PointResult {
    int n_contacts = 0;
    double relative_velocity = math::nan, separation_velocity = math::nan, effective_restitution = math::nan,
           restitution_ratio = math::nan, t_end = math::nan, t_floor_end = math::nan;
    Outcome outcome = Outcome::invalid;
};

HL_FN double ball_mass(double matter, bool density, double radius) {
    return density ? (4.0 / 3.0 * math::pi) * (matter * (radius * radius * radius)) : matter;
}

HL_FN void finish(const column::Sequence& q, const Setting& s, const Parameters& p, double speed, PointResult& r) {
    r.n_contacts = q.n_contacts;
    r.relative_velocity = q.relative_velocity;
    r.separation_velocity = q.separation_velocity;
    r.t_end = q.t_end;
    r.t_floor_end = q.t_floor_end;
    r.outcome = q.outcome;
    r.effective_restitution = column::effective_restitution(q.relative_velocity, speed);
    if (s.restitution_at >= 0 && p.floor_law[s.restitution_at] == p.pair_law[s.restitution_at])
        r.restitution_ratio = r.effective_restitution / p.floor_law[s.restitution_at];
}

template <class Law>
PointResult solve_point(const Setting& setting, Parameters p) {
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
    if constexpr (std::is_same_v<Law, contact::LinearDashpot>) {
        if (setting.model != Model::independent) {
            const column::Start s = column::start_two_ball(
                floor_law, pair_law, m1, m2, p.gravity, start,
                setting.model == Model::newton ? column::Coupling::full : column::Coupling::adiabatic);
            r.outcome = s.outcome;
            if (s.outcome != Outcome::ok) return r;
            column::NoRecorder none;
            column::Sequence q = column::run_two_ball(s.groups, s.first, s.t, -math::infinity, none);
            column::to_si(q, s.units);
            finish(q, setting, p, speed, r);
            return r;
        }
    }
    const column::Column<Law> c{2,        true,           p.gravity,        {m1, m2},
                                {p.radius_1, p.radius_2}, {floor_law, pair_law}, {height, p.gap},
                                {p.velocity_1, p.velocity_2}};
    if (math::is_nan(column::fall_time(height, p.velocity_1, p.gravity))) {
        r.outcome = Outcome::never_lands;
    } else if (setting.model == Model::independent) {
        finish(column::solve_independent(c, math::nan).sequence, setting, p, speed, r);
    } else {
        finish(column::integrate(c, column::IntegrateOptions{}).sequence, setting, p, speed, r);
    }
    return r;
}

}  // namespace hardlimit::sweep
