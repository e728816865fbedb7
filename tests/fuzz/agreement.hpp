// Compares the exact and the general solver on a column of two balls, and classifies any difference.
//
// A difference has one of three explanations.
//   * Integration error: a tighter tolerance removes at least half of it.
//   * Conditioning: the general solver's result is that of the exact solver for a column whose parameters differ from
//     the given ones by a small relative amount, the joint backward error of both solvers. Where a contact barely
//     happens, or thousands follow each other, such a change alters the number of contacts and all that depends on it
//     (a tie).
//   * Flat force: only the instants differ at which a force that passes slowly through zero ends. The exact force is
//     zero to rounding at both.
#pragma once
#include <algorithm>
#include <vector>

#include "column/solve.hpp"
#include "draw.hpp"

namespace hardlimit::fuzz {

using LinearColumn = column::Column<contact::LinearDashpot>;
using column::Sequence;

enum class Verdict { equal, truncated, conditioned, tie, flat, invalid, unresolved, unexplained };
inline constexpr int verdicts = 8;

struct Agreement {
    Verdict verdict;
    Sequence exact, general;
    double difference = 0.0;      // largest of the compared values, in units of the impact (see differences)
    double backward_error = 0.0;  // relative change of the column that explains it
};

// Natural units of a column: the impact speed or, if larger, the speed that gravity produces while the contacts are
// compressed; the time scale of the faster contact, and that of the floor contact.
struct Measure {
    double speed, time, floor_time, fall;
    explicit Measure(const LinearColumn& c) : fall(column::fall_time(c.gaps[0], c.velocity[0], c.gravity)) {
        const double reduced = effective(c.mass[0], c.mass[1]), total = c.mass[0] + c.mass[1];
        const double swing = math::max(total / c.contacts[0].stiffness, c.mass[1] / c.contacts[1].stiffness);
        speed = math::max(column::impact_speed(c.gaps[0], c.velocity[0], c.gravity),
                          c.gravity * math::sqrt(swing));
        floor_time = math::sqrt(c.mass[0] / c.contacts[0].stiffness);
        time = math::min(floor_time, math::sqrt(reduced / c.contacts[1].stiffness));
    }
};

inline bool same_events(const Sequence& a, const Sequence& b) {
    return a.outcome == b.outcome && a.n_contacts == b.n_contacts &&
           math::is_nan(a.t_end) == math::is_nan(b.t_end) &&
           math::is_nan(a.t_floor_end) == math::is_nan(b.t_floor_end) &&
           math::is_nan(a.separation_velocity) == math::is_nan(b.separation_velocity) &&
           math::is_nan(a.relative_velocity) == math::is_nan(b.relative_velocity);
}

// Differences of both velocities in units of the impact speed, and of both times in units of the contact time, minus
// the rounding error of the time since release.
struct Differences {
    double value[4];
    double largest() const { return *std::max_element(value, value + 4); }
};
inline Differences differences(const Sequence& a, const Sequence& b, const Measure& unit) {
    const auto of = [&](double x, double y, double scale, double relative) {
        if (math::is_nan(x) || math::is_nan(y)) return 0.0;
        const double since_release = math::max(math::max(math::abs(x), math::abs(y)), unit.fall);
        return math::max(math::abs(x - y) - relative * since_release, 0.0) / scale;
    };
    return {{of(a.relative_velocity, b.relative_velocity, unit.speed, 0.0),
             of(a.separation_velocity, b.separation_velocity, unit.speed, 0.0),
             of(a.t_end, b.t_end, unit.time, 1e-12),
             of(a.t_floor_end, b.t_floor_end, unit.floor_time, 1e-12)}};
}

// The column with every parameter changed by a relative amount up to `relative`; velocities and gaps also by that part
// of their natural unit.
inline LinearColumn nearby(LinearColumn c, double relative, Random& random) {
    Draw<Random&> draw(random);
    const Measure unit(c);
    const auto change = [&](double& x) { x *= 1.0 + relative * draw.between(-1.0, 1.0); };
    change(c.gravity);
    for (std::size_t j = 0; j < 2; ++j) {
        change(c.mass[j]);
        change(c.gaps[j]);
        change(c.contacts[j].stiffness);
        change(c.contacts[j].damping);
        c.velocity[j] += relative * unit.speed * draw.between(-1.0, 1.0);
        c.gaps[j] = math::max(0.0, c.gaps[j] + relative * unit.speed * unit.time * draw.between(-1.0, 1.0));
    }
    return c;
}

inline constexpr double rounding =
    1e-10;  // differences up to this, in units of the impact, need no explanation
inline constexpr double largest_backward_error = 1e-10;

// The exact solution, stopped after `most` checks of its Stop; there is one check for each 64 pieces.
inline Sequence solve_exactly(const LinearColumn& c, long most) {
    Stop stop([](void* left) { return --*static_cast<long*>(left) < 0; }, &most);
    return column::solve_sequence(c, column::Model::newton, {.stop = &stop}, nullptr);
}
inline Sequence integrate(const LinearColumn& c, long max_steps, double tolerance) {
    return column::solve_sequence(c, column::Model::newton,
                                  {.general = true, .tolerance = tolerance, .max_steps = max_steps}, nullptr);
}

// Whether changes of the column by `relative` change the exact solution by as much as the general one differs from it.
// In a tie, one of the changed columns has the events of the general solution, or the contact counts of the changed
// columns lie on both sides of its count. Stores the verdict in `a`.
inline bool explained_by_condition(double relative, const LinearColumn& c, Random& random, Agreement& a) {
    const Measure unit(c);
    const Differences found = differences(a.exact, a.general, unit);
    Differences spread{}, closest{{math::infinity, math::infinity, math::infinity, math::infinity}};
    int fewest = a.exact.n_contacts, most = a.exact.n_contacts;
    for (int i = 0; i < 24; ++i) {
        const Sequence near = solve_exactly(nearby(c, relative, random), 2000);
        const Differences off = differences(near, a.exact, unit), left = differences(near, a.general, unit);
        for (int k = 0; k < 4; ++k) spread.value[k] = math::max(spread.value[k], off.value[k]);
        if (same_events(near, a.general) && left.largest() < closest.largest()) closest = left;
        if (near.outcome == Outcome::unresolved) continue;
        fewest = std::min(fewest, near.n_contacts);
        most = std::max(most, near.n_contacts);
    }
    const bool tie = !same_events(a.exact, a.general);
    if (tie && fewest < a.general.n_contacts && a.general.n_contacts < most) closest = found;
    for (int k = 0; k < 4; ++k)
        if ((tie ? closest : found).value[k] > 2.0 * spread.value[k] + rounding) return false;
    a.verdict = tie ? Verdict::tie : Verdict::conditioned;
    a.backward_error = relative;
    return true;
}

// Whether the general solution comes closer to the exact one with a tighter tolerance.
inline bool explained_by_tolerance(const LinearColumn& c, long max_steps, Agreement& a) {
    const Measure unit(c);
    const Sequence sharp = integrate(c, 4 * max_steps, 2e-15);
    if (!same_events(a.exact, sharp)) return false;
    const Differences found = differences(a.exact, a.general, unit), left = differences(a.exact, sharp, unit);
    for (int k = 0; k < 4; ++k)
        if (left.value[k] > 0.5 * found.value[k] + rounding) return false;
    a.verdict = Verdict::truncated;
    return true;
}

// Whether, at the instants at which the general solution ends its contacts, the exact solution has zero force and the
// same v'_r; then only these instants differ. Velocities and compressions, and so the force, are known to `rounding`.
inline bool explained_by_flat_force(const LinearColumn& c, Agreement& a) {
    const Measure unit(c);
    const Differences found = differences(a.exact, a.general, unit);
    if (!same_events(a.exact, a.general) || found.value[1] > rounding) return false;
    const column::Drop drop = column::solve_drop(c, column::Coupling::full, math::nan, true, nullptr);
    const double mass[2] = {c.mass[0], effective(c.mass[0], c.mass[1])},
                 end[2] = {a.general.t_floor_end, a.general.t_end};
    const std::vector<double> nothing(drop.nodes.size(), 0.0);
    for (std::size_t j = 0; j < 2; ++j) {
        if (math::is_nan(end[j])) continue;
        const column::DropSample s = column::sample_drop(c, drop, nothing, end[j]);
        const double rate = j == 0 ? s.velocity[0] : s.velocity[1] - s.velocity[0];
        const contact::LinearDashpot& k = c.contacts[j];
        const double largest = (k.damping + math::sqrt(k.stiffness * mass[j])) * unit.speed;
        if (math::abs(k.force(-s.gap[j], -rate)) > rounding * largest) return false;
        if (j == 1 && math::abs(rate - a.general.relative_velocity) > rounding * unit.speed) return false;
    }
    a.verdict = Verdict::flat;
    return true;
}

inline Agreement compare(const LinearColumn& c, long max_steps, Random random) {
    Agreement a{Verdict::equal, {}, integrate(c, max_steps, 1e-14)};
    if (a.general.outcome != Outcome::unresolved) a.exact = solve_exactly(c, 20'000);
    const auto one_is = [&](Outcome o) { return a.exact.outcome == o || a.general.outcome == o; };
    if (one_is(Outcome::unresolved)) {
        a.verdict = Verdict::unresolved;
        return a;
    }
    if (one_is(Outcome::invalid)) {
        a.verdict = a.exact.outcome == a.general.outcome ? Verdict::invalid : Verdict::unexplained;
        return a;
    }
    a.difference = differences(a.exact, a.general, Measure(c)).largest();
    if (same_events(a.exact, a.general) && a.difference <= rounding) return a;
    a.verdict = Verdict::unexplained;
    if (explained_by_tolerance(c, max_steps, a)) return a;
    for (double relative = 1e-15; relative <= 1.5 * largest_backward_error; relative *= 10.0)
        if (explained_by_condition(relative, c, random, a)) return a;
    explained_by_flat_force(c, a);
    return a;
}

}  // namespace hardlimit::fuzz
