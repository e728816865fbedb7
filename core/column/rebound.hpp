// Rebound heights (largest height of each ball's centre after its first bounce) and final velocities.
//
// The first bounce of a ball is its first contact with the ball or floor below; it counts as over at the first floor
// touch at the earliest. The rebound height is the largest height after it
//   * up to `until`, if that is given;
//   * otherwise, with the lowest ball removed when it touches the floor for the second time. Later contacts of the
//     other balls count, and so does their flight to the top: the upper balls usually still rise at that time, and the
//     later motion of the lowest ball does not belong to this rebound.
// A ball whose contact never ends has its height in the static equilibrium. NaN: no bounce above the floor, or no
// floor.
#pragma once
#include "../base/roots.hpp"
#include "solve.hpp"

namespace hardlimit::column {

namespace rebound {

// Largest height of each ball so far, and the time from which its height counts.
struct Heights {
    std::vector<double> greatest;  // [N] [m]
    std::vector<double> from;      // [N] end of the first bounce [s]; infinity: none so far

    explicit Heights(int balls)
        : greatest(static_cast<std::size_t>(balls), math::nan), from(greatest.size(), math::infinity) {}
    void reach(std::size_t ball, double height) {
        if (!(height <= greatest[ball])) greatest[ball] = height;
    }
};

// Sets from[j] to the end of pair j's first contact, but not before the first floor touch.
inline void find_bounces(const Solution& s, std::vector<double>& from) {
    std::vector<bool> met(from.size(), false);
    for (const Contact& k : s.contacts) {
        const std::size_t ball = static_cast<std::size_t>(k.pair);
        if (met[ball]) continue;
        met[ball] = true;
        if (from[ball] == math::infinity && !math::is_nan(k.end)) from[ball] = math::max(k.end, 0.0);
    }
}

// Largest height of a ball that rises at time `low` and falls at time `high`.
inline double apex(const Solution& s, std::size_t ball, States& at, double low, double rising, double high,
                   double falling) {
    const auto velocity = [&](double t) {
        s.sample(&t, at);
        return at.velocity[ball];
    };
    roots::falling_zero(velocity, low, rising, high, falling, 1e-13 * (rising - falling));
    return at.position[ball];
}

// Whether a ball that turns between two knots may rise above `greatest`. `ends` is the higher of its positions at the
// knots, `travel` the time between the knots times the change of velocity. The ball rises by less than `travel` above
// `ends`, because its speed stays below that change: it decreases monotonically in flight and smoothly within an
// integration step. The factor 4 is a margin. The test avoids the search for the top, tens of steps, for a ball at
// rest, which turns in every step by rounding error.
inline bool may_exceed(double greatest, double ends, double travel) {
    return !(ends + 4.0 * travel <= greatest);
}

// Knots of the run and limits of the time windows, sorted.
inline std::vector<double> marks(const Solution& s, const std::vector<double>& from,
                                 const std::vector<double>& to) {
    std::vector<double> times = s.knots();
    times.insert(times.end(), from.begin(), from.end());
    times.insert(times.end(), to.begin(), to.end());
    std::erase_if(times, [&](double t) { return !(t >= s.first && t <= s.last); });
    std::sort(times.begin(), times.end());
    times.erase(std::unique(times.begin(), times.end()), times.end());
    return times;
}

// Finds the largest height of each ball in its time window [found.from, to]. `origin`: height of the first ball of a
// cradle at release.
inline void find_heights(const Solution& s, double origin, const std::vector<double>& to, Stop* stop,
                         Heights& found) {
    constexpr std::size_t most = 1024;
    const std::size_t balls = to.size();
    const std::vector<double> times = marks(s, found.from, to);
    if (stop) s.prepare(*stop);
    States one(1, static_cast<int>(balls), origin);
    for (std::size_t k = 0; k < times.size() && !(stop && stop->now());
         k += most - 1) {  // chunks overlap by one knot
        const double* t = &times[k];
        States at(std::min(most, times.size() - k), static_cast<int>(balls), origin);
        s.sample(t, at);
        for (std::size_t j = 0; j < balls; ++j) {
            for (std::size_t i = 0; i < at.n; ++i) {
                if (!(t[i] >= found.from[j] && t[i] <= to[j])) continue;
                found.reach(j, at.position[i * balls + j]);
                if (i == 0 || t[i - 1] < found.from[j]) continue;
                const double before = at.velocity[(i - 1) * balls + j], now = at.velocity[i * balls + j];
                const double ends = math::max(at.position[(i - 1) * balls + j], at.position[i * balls + j]);
                const bool turns = before > 0.0 && now < 0.0;
                if (turns && may_exceed(found.greatest[j], ends, (t[i] - t[i - 1]) * (before - now)))
                    found.reach(j, apex(s, j, one, t[i - 1], before, t[i], now));
            }
        }
    }
}

// Heights in the static equilibrium. Adiabatic model: the upper ball does not act on the lower one.
template <class Law>
void equilibrium_heights(const Column<Law>& c, Model model, Heights& found) {
    double above = 0.0;
    std::vector<double> depth(c.mass.size(), 0.0);
    for (std::size_t j = c.mass.size(); j-- > 0 && model != Model::independent;) {
        const double own = c.mass[j] * c.gravity;
        above = model == Model::adiabatic ? own : above + own;
        const Law& law = c.contacts[j];
        depth[j] = math::power<Law::onset_power>(
            roots::solve_power([&](double x) { return law.elastic_force(x); }, above));
    }
    double z = 0.0;
    for (std::size_t j = 0; j < depth.size(); ++j) {
        z += (j > 0 ? c.radius[j - 1] : 0.0) - depth[j] + c.radius[j];
        found.reach(j, z);
    }
}

// Heights to which the balls from `lowest` upwards rise in free flight.
inline void flight_heights(const States& end, std::size_t lowest, double gravity, Heights& found) {
    for (std::size_t j = lowest; j < end.balls; ++j) {
        if (found.from[j] == math::infinity) continue;
        const double v = math::max(end.velocity[j], 0.0);
        found.reach(j, end.position[j] + (v > 0.0 ? v * v / (2.0 * gravity) : 0.0));
    }
}

inline bool some_approach(const States& end, std::size_t lowest) {
    for (std::size_t j = lowest + 1; j < end.balls; ++j)
        if (end.velocity[j - 1] > end.velocity[j]) return true;
    return false;
}

// All balls but the lowest, in free fall from a state in which they do not overlap.
template <class Law>
SharedColumn<Law> without_lowest(const Column<Law>& c, const States& at) {
    Column<Law> r{.balls = c.balls - 1, .floor = false, .gravity = c.gravity};
    for (std::size_t j = 1; j < at.balls; ++j) {
        r.mass.push_back(c.mass[j]);
        r.radius.push_back(c.radius[j]);
        r.contacts.push_back(c.contacts[j]);
        r.gaps.push_back(j == 1 ? 0.0 : math::max(at.gap[j], 0.0));
        r.velocity.push_back(at.velocity[j]);
    }
    return std::make_shared<const Column<Law>>(std::move(r));
}

// Heights of the upper balls, with their contacts, after the lowest ball is removed at its second floor touch.
template <class Law>
void continue_without_lowest(const Column<Law>& c, Model model, SolveOptions o, const States& at,
                             Heights& found) {
    o.until = math::nan;
    const SharedColumn<Law> upper = without_lowest(c, at);
    const std::unique_ptr<Solution> s = solve_column(upper, model, o);
    const double origin = at.position[1];
    Heights rest(upper->balls);
    for (std::size_t j = 1; j < at.balls; ++j)
        if (found.from[j] < math::infinity) rest.from[j - 1] = 0.0;
    find_bounces(*s, rest.from);
    find_heights(*s, origin, std::vector<double>(rest.from.size(), s->last), o.stop, rest);
    States end(1, upper->balls, origin);
    s->sample(&s->last, end);
    flight_heights(end, 0, c.gravity, rest);
    const bool resolved = s->sequence.outcome != Outcome::unresolved;
    for (std::size_t j = 1; j < at.balls; ++j) {
        if (rest.from[j - 1] == math::infinity) continue;
        const double height = resolved ? rest.greatest[j - 1] : math::nan;
        if (!(height < c.radius[j])) found.reach(j, height);  // otherwise it would be below the floor
    }
}

// The state at the end of the sequence, or a little later if upper balls still overlap. Sets `at` to that time [s].
template <class Law>
States end_of_sequence(SharedColumn<Law> c, Model model, SolveOptions o, const Solution& s, double& at) {
    States end(1, c->balls);
    at = s.last;
    s.sample(&at, end);
    const auto overlap = [&] {
        for (std::size_t j = 2; j < end.balls; ++j)
            if (end.gap[j] < 0.0) return true;
        return false;
    };
    double later = 1e-3 * s.last;
    for (int i = 0; i < 12 && overlap(); ++i, later *= 2.0) {
        at = o.until = s.last + later;
        solve_column(c, model, o)->sample(&at, end);
    }
    return end;
}

}  // namespace rebound

// Rebound heights [N] [m]; NaN where there is none. `s` is the result of solve_column(c, model, o).
template <class Law>
std::vector<double> rebound_heights(SharedColumn<Law> c, Model model, const SolveOptions& o,
                                    const Solution& s) {
    using namespace rebound;
    Heights found(c->balls);
    const Sequence& q = s.sequence;
    if (!c->floor || math::is_nan(s.last)) return found.greatest;
    for (const Outcome unknown : {Outcome::unresolved, Outcome::never_lands, Outcome::too_deep})
        if (q.outcome == unknown) return found.greatest;
    const bool timed = !math::is_nan(o.until);
    find_bounces(s, found.from);
    std::vector<double> to(found.from.size(), timed ? math::min(o.until, s.last) : s.last);
    if (!timed && q.second_floor_contact) to[0] = math::min(to[0], q.t_second_touch);
    find_heights(s, 0.0, to, o.stop, found);
    if (q.outcome == Outcome::at_rest) {
        equilibrium_heights(*c, model, found);
    } else if (!timed) {
        double at;
        const States end = end_of_sequence(c, model, o, s, at);
        const std::size_t lowest = q.second_floor_contact ? 1 : 0;
        if (lowest == 1 && some_approach(end, 1))
            continue_without_lowest(*c, model, o, end, found);
        else
            flight_heights(end, lowest, c->gravity, found);
    }
    return found.greatest;
}

// Velocities of the balls after the last contact of the sequence.
struct Parting {
    std::vector<double> velocity;  // [N] [m/s] in the frame in free fall since time 0; constant in flight
    std::vector<double> since;     // [N] [s] end of each ball's last contact; NaN: it had none
};

namespace rebound {

// Most collisions of the upper balls that are followed for a few missing contacts; a collapse has no end to wait for.
inline constexpr long most_later = 100'000;

inline void note_end(const Contact& k, std::vector<double>& since) {
    const std::size_t above = static_cast<std::size_t>(k.pair);
    for (std::size_t j = above - (above > 0); j <= above; ++j)
        if (!(k.end <= since[j])) since[j] = k.end;
}

}  // namespace rebound

// `missing` [N − 2] or empty: the lowest ball is removed when it meets the floor for the second time, and the others
// continue until each pair of them has had this many further contacts or has no more. `s` is the result of
// solve_column(c, model, o) without `until`.
template <class Law>
Parting parting(SharedColumn<Law> c, Model model, const SolveOptions& o, const Solution& s,
                std::vector<int> missing) {
    using namespace rebound;
    const std::size_t balls = c->mass.size();
    Parting found{final_velocities(s, c->balls), std::vector<double>(balls, math::nan)};
    double last = -math::infinity;
    for_ended_contacts(s, math::nan, [&](std::size_t, const Contact& k) {
        note_end(k, found.since);
        last = math::max(last, k.end);
    });
    for (double& v : found.velocity) v += c->gravity * last;
    const auto all_met = [&] { return std::ranges::all_of(missing, [](int n) { return n <= 0; }); };
    if (all_met() || !s.sequence.second_floor_contact || math::is_nan(found.velocity[0])) return found;
    double at;
    const States end = end_of_sequence(c, model, o, s, at);
    const SharedColumn<Law> upper = without_lowest(*c, end);
    SolveOptions later = o;
    later.max_events = std::min(o.max_events, most_later);
    const std::unique_ptr<Solution> run = solve_column(upper, model, later);
    States after(1, upper->balls);
    after.velocity.assign(end.velocity.begin() + 1, end.velocity.end());
    std::vector<double> since(balls - 1, math::nan);
    std::ptrdiff_t latest = -1;  // the contact that ends last; the state after one costs up to 64 collisions
    last = 0.0;
    for_ended_contacts(*run, math::nan, [&](std::size_t i, const Contact& k) {
        if (all_met()) return;
        --missing[static_cast<std::size_t>(k.pair) - 1];
        note_end(k, since);
        if (k.end < last) return;
        last = k.end;
        latest = static_cast<std::ptrdiff_t>(i);
    });
    if (!all_met() && run->sequence.outcome == Outcome::unresolved) {  // what is missing is unknown
        std::fill(found.velocity.begin(), found.velocity.end(), math::nan);
        return found;
    }
    if (latest >= 0) run->sample_after(static_cast<std::size_t>(latest), after);
    for (std::size_t j = 1; j < balls; ++j) {
        found.velocity[j] = after.velocity[j - 1] + c->gravity * (at + last);
        if (!math::is_nan(since[j - 1])) found.since[j] = at + since[j - 1];
    }
    return found;
}

}  // namespace hardlimit::column
