// Conversion of a point of a two-ball map from physical parameters to a scaled drop, and of its result to SI units.
// Contains no containers, so that it also compiles for a GPU.
#pragma once
#include "../column/compression.hpp"
#include "../column/effective_restitution.hpp"
#include "../column/exact/scaling.hpp"
#include "../column/model.hpp"

namespace hardlimit::sweep {

using column::Model;

// Physical parameters of a point. matter: mass or density of a ball, as given by the user. radius_ratio: unless NaN, it
// determines the lower radius.
struct Parameters {
    double radius_1, radius_2, radius_ratio, matter_1, matter_2, gap, height, velocity_1, velocity_2, gravity;
    double floor_law[max_parameters], pair_law[max_parameters];
};
inline constexpr int geometry_count = 10;
inline constexpr int parameter_count = geometry_count + 2 * max_parameters;
static_assert(sizeof(Parameters) == parameter_count * sizeof(double));

// Settings common to all points of a map.
struct Setting {
    Model model;
    int alternative;            // which of the law's parameter sets is given
    bool density_1, density_2;  // matter is a density, else a mass
    int restitution_at;         // index of ε among the law's parameters; −1: the law is not specified by ε
    double tolerance = 1e-14;   // of the general solver, where it is used
};

// The results of a sequence that a sweep stores, in SI units.
inline constexpr int quantity_count = 6;
inline constexpr const char* quantity_names[quantity_count] = {
    "relative_velocity", "separation_velocity", "effective_restitution", "restitution_ratio", "t_end",
    "t_floor_end"};
inline constexpr int t_end_index = 4;
template <class R>
struct Quantities {
    R of[quantity_count];
};
struct PointResult : Quantities<double> {
    int n_contacts = 0;
    Outcome outcome = Outcome::invalid;
    HL_FN PointResult() : Quantities{{math::nan, math::nan, math::nan, math::nan, math::nan, math::nan}} {}
};

HL_FN double ball_mass(double matter, bool density, double radius) {
    return density ? (4.0 / 3.0 * math::pi) * (matter * (radius * radius * radius)) : matter;
}

// Replaces any NaN by the canonical one: the sign and payload of a NaN result depend on the processor.
template <class R>
HL_FN R one_nan(R x) {
    return select<R>(math::is_nan(x), broadcast<R>(math::nan), x);
}

// ε of both contacts; NaN if they differ or the law is not specified by ε.
HL_FN double restitution_of(const Setting& s, const Parameters& p) {
    const int at = s.restitution_at;
    return at >= 0 && p.floor_law[at] == p.pair_law[at] ? p.floor_law[at] : math::nan;
}

// The quantities of a sequence in SI units.
template <class Q, class R>
HL_FN Quantities<R> quantities_of(const Q& q, R restitution, R speed) {
    const R effective = one_nan<R>(column::effective_restitution<R>(q.relative_velocity, speed));
    return {{one_nan<R>(q.relative_velocity), one_nan<R>(q.separation_velocity), effective,
             one_nan<R>(effective / restitution), one_nan<R>(q.t_end), one_nan<R>(q.t_floor_end)}};
}

HL_FN void finish(const column::Sequence& q, const Setting& s, const Parameters& p, double speed,
                  PointResult& r) {
    r.n_contacts = q.n_contacts;
    r.outcome = q.outcome;
    static_cast<Quantities<double>&>(r) =
        quantities_of<column::Sequence, double>(q, restitution_of(s, p), speed);
}

struct Bodies {
    double height, m1, m2;  // height of the lower ball above the floor
};

// Computes masses and height from the parameters, and the lower radius from a radius ratio. False if the lower ball
// would overlap the floor.
HL_FN bool measure(const Setting& setting, Parameters& q, Bodies& b) {
    if (!math::is_nan(q.radius_ratio)) q.radius_1 = q.radius_ratio * q.radius_2;
    q.radius_ratio = math::nan;
    b = {q.height - q.radius_1, ball_mass(q.matter_1, setting.density_1, q.radius_1),
         ball_mass(q.matter_2, setting.density_2, q.radius_2)};
    return b.height >= 0.0;
}

// The balls of a point at release.
HL_FN column::TwoBalls released(const Parameters& q, const Bodies& b) {
    return {.m1 = b.m1,
            .m2 = b.m2,
            .gravity = q.gravity,
            .released = {b.height, q.velocity_1, q.gap, q.velocity_2 - q.velocity_1}};
}

// Converts a point to a drop for linear_kernel.hpp; false if that kernel cannot solve it. The damping ratios β/ω0 of
// floor and pair are used if the law is specified by ε.
HL_FN bool enter(const Setting& setting, Parameters& q, double floor_ratio, double pair_ratio,
                 column::Start& s) {
    Bodies b;
    if (!measure(setting, q, b)) return false;
    const double m1 = b.m1, m2 = b.m2;
    using contact::LinearDashpot;
    const bool given = setting.restitution_at >= 0;
    const LinearDashpot floor = given ? LinearDashpot::from_damping_ratio(q.floor_law[0], floor_ratio, m1)
                                      : LinearDashpot{q.floor_law[0], q.floor_law[1]};
    const LinearDashpot pair =
        given ? LinearDashpot::from_damping_ratio(q.pair_law[0], pair_ratio, effective(m1, m2))
              : LinearDashpot{q.pair_law[0], q.pair_law[1]};
    s = column::start_two_ball(
        floor, pair, released(q, b),
        setting.model == Model::newton ? column::Coupling::full : column::Coupling::adiabatic);
    return s.outcome == Outcome::ok && math::is_finite(s.groups.gravity + s.first.w);
}

// Bound on the compressions of a point; only the elastic part of its contacts is used.
template <class Law>
HL_FN column::CompressionBound bound_of(const Setting& setting, const Parameters& q, const Bodies& b,
                                        const Law& floor, const Law& pair) {
    return column::CompressionBound{.m1 = b.m1,
                                    .m2 = b.m2,
                                    .gravity = q.gravity,
                                    .height = b.height,
                                    .v1 = q.velocity_1,
                                    .v2 = q.velocity_2,
                                    .coupled = setting.model == Model::newton}
        .within(deepest_compression, q.radius_1, q.radius_2, floor, pair);
}
// The same for a point that enter() accepted.
HL_FN column::CompressionBound linear_bound(const Setting& setting, Parameters q) {
    using contact::LinearDashpot;
    Bodies b;
    measure(setting, q, b);
    return bound_of(setting, q, b, LinearDashpot{q.floor_law[0], 0.0}, LinearDashpot{q.pair_law[0], 0.0});
}

// Result of the kernel for one drop, in scaled units.
struct Found {
    double contacts, t_first, t_end, t_floor_end, relative, separation;
};

// Converts it to a Sequence in SI units.
HL_FN column::Sequence sequence_of(const Found& found, const column::Units& units, Outcome outcome) {
    column::Sequence q;
    q.outcome = outcome;
    q.n_contacts = static_cast<int>(found.contacts);
    q.t_first_touch = found.t_first;
    q.t_end = found.t_end;
    q.t_floor_end = found.t_floor_end;
    q.relative_velocity = found.relative;
    q.separation_velocity = found.separation;
    q.close();
    column::to_si(q, units);
    return q;
}

HL_FN PointResult leave(const Setting& setting, const Parameters& p, const column::Units& units,
                        const Found& found) {
    PointResult r;
    finish(sequence_of(found, units, Outcome::ok), setting, p, units.speed, r);
    return r;
}

}  // namespace hardlimit::sweep
