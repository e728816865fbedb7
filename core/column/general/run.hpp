// Main loop of the general column solver: integrates from event to event until the sequence is over (motions.hpp).
#pragma once
#include <algorithm>
#include <utility>
#include <vector>

#include "../../base/roots.hpp"
#include "../../base/stop.hpp"
#include "events.hpp"
#include "rest.hpp"

namespace hardlimit::column {

struct IntegrateOptions {
    double tolerance = 1e-14;    // local error in units of the impact (see Scales)
    long max_steps = 2'000'000;  // integration steps and events together
    double until = math::nan;    // [s] after the first floor touch (cradle: release); NaN: end of sequence
    bool record = false;         // store the states for sample()
    Stop* stop = nullptr;        // checked at every step; the result of a stopped run is invalid
};

namespace newton {

// Discrete state of the integration; constant within an interval.
struct Modes {
    std::vector<Pair> pair;
    std::vector<unsigned char> uses_root;  // whether the coordinate is s
    bool implicit;                         // implicit method
    bool operator==(const Modes&) const = default;
};

// An interval without events.
struct Interval {
    double t, length;   // start [s] after the first floor touch (cradle: release); length in τ
    std::size_t modes;  // index into Integration::modes
};

}  // namespace newton

template <class Law>
struct Integration {
    Sequence sequence;              // times relative to the first floor touch (cradle: release)
    std::vector<Contact> contacts;  // by begin, then pair; with `until`, those that begin up to it
    double t_stop = math::nan;      // [s] time of the state below
    std::vector<double> gaps;       // [N] [m] at `until`, else t_end (two balls), else where the run stopped
    std::vector<double> velocity;   // [N] [m/s]
    long steps = 0;                 // integration steps, rejected ones included, and events
    double energy_error = 0.0;      // largest error of the energy balance relative to the initial energy
    std::vector<double> compression;          // [N] largest compression over the smaller radius
    int too_deep = -1;                        // pair that ended the run at deepest_compression; −1: none
    double settling = 0.0;                    // [s] if at rest: time in which the oscillations decay
    std::vector<newton::Interval> intervals;  // with `record`; in one of length 0 the state is constant
    std::vector<double> states;  // [intervals × (2N + 2)] state at the start of each, as in Motion
    std::vector<newton::Modes> modes;
};

namespace newton {

template <class Law>
class Run {
public:
    Run(const Column<Law>& c, const IntegrateOptions& o)
        : column(c),
          options(o),
          step(c, 10.0 * o.tolerance),
          tolerance(step.y),
          contact_of(c.balls, -1),
          counted(c.balls, 0),
          radius(c.balls) {
        sequence().one_ball = c.balls == 1;
        result.compression.assign(radius.size(), 0.0);
        for (int j = 0; j < c.balls; ++j) radius[j] = smaller_radius(c, j);
    }

    Integration<Law> integrate() {
        if (!(motion.scales.speed > 0.0 && math::is_finite(motion.scales.time))) {
            sequence().outcome = Outcome::invalid;
            return finish();
        }
        const Energies e = motion.energies(y.data());
        initial_energy = e.kinetic + e.potential;
        h = 0.05 * motion.scales.time;
        while (!stopped) {
            if (options.stop && (*options.stop)()) break;
            if (++result.steps > options.max_steps) {
                if (!sequence().finished || timed) sequence().outcome = Outcome::unresolved;
                break;
            }
            if (motion.free()) {
                free_flight();
            } else {
                integrate_step();
            }
        }
        return finish();
    }

private:
    const Column<Law>& column;
    const IntegrateOptions& options;
    Integration<Law> result;
    Step<Law> step;
    Motion<Law>& motion = step.motion;
    std::vector<double>& y = step.y;            // the state
    std::vector<double> tolerance;              // [dimension]
    std::vector<int> contact_of;                // [N] index of the open contact
    std::vector<unsigned char> counted;         // [N] the open contact belongs to the sequence
    std::vector<double> radius;                 // [N] smaller radius of each pair
    std::vector<Equilibrium<Law>> equilibrium;  // empty until first needed
    bool timed = !math::is_nan(options.until), stopped = false, kept = false;
    double initial_energy = 0.0, h = 0.0;
    int steps_without_change = 0;  // explicit steps since the last change of the contacts
    double explicit_length = 0.0;  // of the last explicit step

    // The implicit method is tried after `patience` explicit steps without a change of contacts, kept while its steps
    // are `least_gain` times longer, and used for at most `most_implicit` balls, since its cost grows as N³.
    static constexpr int patience = 5000, least_gain = 50, most_implicit = 16;

    Sequence& sequence() { return result.sequence; }
    double now() const { return y[motion.clock()]; }

    bool clock_started() const { return !column.floor || !math::is_nan(result.sequence.t_first_touch); }

    // With `until`, the run may end there; for two balls it continues to the end of the sequence.
    bool complete() {
        if (!timed) return sequence().finished;
        return kept && (column.balls != 2 || sequence().finished);
    }

    // ---- one interval -------------------------------------------------------------------------------------

    // Accepts the interval from y to `end`, of length `length` in τ, and applies the event of pair j at its end.
    void close_interval(double length, Event what, int j) {
        compress(length);
        record(length);
        if (timed && !kept && clock_started() && step.end[motion.clock()] >= options.until) {
            motion.reach(y.data(), step.k.data(), length, options.until, step.trial.data());
            step.trial[motion.clock()] =
                options.until;  // exactly: sample() gives NaN after the last recorded time
            keep(step.trial);
            if (complete()) {
                y = step.trial;
                stopped = true;
                return;
            }
        }
        y.swap(step.end);
        check_energy();
        if (result.too_deep >= 0) {
            sequence().goes_too_deep(now());
            stopped = true;
            return;
        }
        settle_pressed();
        if (what != Event::none) apply(what, j);
    }

    // Updates the largest compressions within the step. Shortens the step to the instant a contact reaches its limit.
    void compress(double& length) {
        const double time = step.end[motion.clock()] - now();
        const auto probed = [&](const auto& of) {
            return [&, of](double at) {
                step.probe(at);
                return of(step.trial.data());
            };
        };
        for (int j = 0; j < column.balls; ++j) {
            if (!motion.pushes(j)) continue;
            const auto rate = [this, j](const double* state) { return motion.rate(j, state); };
            const auto part = [this, j](const double* state) { return -motion.gap(j, state) / radius[j]; };
            const double before = rate(y.data()), after = rate(step.end.data()), from = part(y.data());
            double deepest = math::max(from, part(step.end.data())), turn = length;
            const double reach = time * math::max(math::abs(before), math::abs(after)) / radius[j];
            if (!(deepest + reach > result.compression[j])) continue;  // cannot exceed the largest so far
            if (before > 0.0 && after < 0.0) {
                turn =
                    roots::falling_zero(probed(rate), 0.0, before, length, after, 1e-14 * (before - after));
                deepest = math::max(deepest, part(step.trial.data()));
            }
            result.compression[j] = math::max(result.compression[j], deepest);
            if (deepest < deepest_compression) continue;
            const auto room = [&](const double* state) { return deepest_compression - part(state); };
            length = roots::falling_zero(probed(room), 0.0, deepest_compression - from, turn,
                                         deepest_compression - deepest, 1e-15);
            step.end.swap(step.trial);
            result.compression[j] = deepest_compression;
            result.too_deep = j;
        }
    }

    void record(double length) {
        if (!options.record) return;
        Modes modes{motion.pair, motion.uses_root, motion.implicit};
        if (result.modes.empty() || result.modes.back() != modes) result.modes.push_back(std::move(modes));
        result.intervals.push_back({now(), length, result.modes.size() - 1});
        result.states.insert(result.states.end(), y.begin(), y.end());
    }

    void keep(const std::vector<double>& state) {
        kept = true;
        result.t_stop = state[motion.clock()];
        result.gaps.resize(column.balls);
        for (int j = 0; j < column.balls; ++j) result.gaps[j] = motion.gap(j, state.data());
        result.velocity.assign(state.begin() + column.balls, state.begin() + 2 * column.balls);
    }

    void check_energy() {
        const Energies e = motion.energies(y.data());
        const double error = (e.kinetic + e.potential) + (e.contact + e.dissipated) - initial_energy;
        const double relative = math::abs(error) / math::max(initial_energy, motion.scales.energy);
        if (!(relative <= result.energy_error)) result.energy_error = relative;
    }

    // ---- free flight --------------------------------------------------------------------------------------

    void free_flight() {
        if (release_pressed()) return;
        double least = math::infinity;
        for (int j = 0; j < column.balls; ++j) {
            motion.choose_coordinate(j, y.data(), false);
            if (j > 0) least = math::min(least, -motion.rate(j, y.data()));
        }
        sequence().moves_freely(least,
                                !column.floor || (sequence().floor_opened && motion.pair[0] == Pair::open));
        if ((stopped = complete())) return;
        NextEvent next;
        for (int j = column.floor ? 0 : 1; j < column.balls; ++j)
            next_event_of_pair(motion, y.data(), j, step.disarmed[j], next);
        if (next.what == Event::none) {
            if (!clock_started()) sequence().outcome = Outcome::never_lands;
            stopped = true;
            if (!timed || kept || sequence().outcome == Outcome::never_lands) return;
            next.dt = options.until - now();
        }
        motion(y.data(), step.k.data());
        motion.advance(y.data(), step.k.data(), next.dt, step.end.data());
        if (next.what == Event::none) step.end[motion.clock()] = options.until;  // exactly, despite rounding
        if (next.dt > 0.0) std::fill(step.disarmed.begin(), step.disarmed.end(), 0);
        close_interval(next.dt, next.what, next.pair);
    }

    // ---- with forces --------------------------------------------------------------------------------------

    void integrate_step() {
        find_pressed();
        if (stopped) return;
        if (motion.choose_coordinates(y.data())) h = math::min(h, 0.25 * motion.scales.time);
        motion(y.data(), step.k.data());
        if (event_at_start() || rests()) return;
        const double taken = h;
        if (!(motion.implicit ? implicit_step() : explicit_step())) return;
        motion(step.end.data(), step.k_end.data());
        double length = taken;
        Event what = Event::none;
        int which = 0;
        for (int j = 0; j < column.balls; ++j) {
            for (const Event kind : step.events_of(j)) {
                if (kind != Event::none && step.crosses(j, kind, length)) {
                    what = kind;
                    which = j;
                }
            }
        }
        for (int j = 0; j < column.balls; ++j) {
            if (step.disarmed[j] && (what == Event::none || which != j))
                step.disarmed[j] = step.still_disarmed(j);
        }
        close_interval(length, what, which);
        if (what == Event::none) consider_implicit();
    }

    // Takes a step of length h to `end` and sets h for the next step. Returns whether the step was accurate enough.
    bool explicit_step() {
        motion.advance(y.data(), step.k.data(), h, step.end.data());
        set_tolerance();
        const double error =
            DormandPrince::error(motion.stages.data(), h, motion.dimension(), tolerance.data());
        h *= DormandPrince::growth(error);
        if (error <= 1.0) return true;
        if (h < 1e-20 * motion.scales.time) fail();
        return false;
    }

    // The same with the implicit method. The error is the difference from two half steps, beyond rounding.
    bool implicit_step() {
        set_tolerance();
        std::vector<double>&middle = step.trial, &halves = step.k_trial;
        double error = math::infinity;
        if (motion.advance(y.data(), step.k.data(), h, step.end.data()) &&
            motion.advance(y.data(), step.k.data(), 0.5 * h, middle.data()) &&
            motion.advance(middle.data(), step.k.data(), 0.5 * h, halves.data())) {
            error = 0.0;
            for (int c = 0; c < motion.dimension(); ++c)
                error = math::max(error, math::abs(halves[c] - step.end[c]) /
                                             (tolerance[c] + 8.0 * math::epsilon * math::abs(step.end[c])));
        }
        h *= Radau::growth(error);
        if (error <= 1.0) return true;
        if (h < least_gain * explicit_length) leave_implicit();
        return false;
    }

    void consider_implicit() {
        if (motion.implicit || ++steps_without_change < patience || column.balls > most_implicit) return;
        motion.implicit = true;
        explicit_length = h;
        h *= 2.0 * least_gain;
    }

    void leave_implicit() {
        steps_without_change = 0;
        if (!motion.implicit) return;
        motion.implicit = false;
        h = explicit_length;
    }

    void fail() {
        sequence().outcome = Outcome::unresolved;
        stopped = true;
    }

    void set_tolerance() {
        const int n = column.balls;
        const Scales& unit = motion.scales;
        for (int j = 0; j < n; ++j) {
            tolerance[j] = math::abs(y[j]) + (motion.uses_root[j] ? unit.s[j] : unit.depth[j]);
            tolerance[n + j] = math::abs(y[n + j]) + unit.speed;
        }
        tolerance[motion.clock()] = unit.time;
        // Balls that settle slowly dissipate the work of gravity, which may far exceed the impact energy.
        tolerance[motion.loss()] = math::max(unit.energy, 0.5 * math::abs(y[motion.loss()]));
        for (double& x : tolerance) x *= options.tolerance;
        // The net force on a light ball between heavy ones is a small difference of large forces. Its rounding error is
        // not a truncation error: shorter steps would not reduce it.
        for (int i = 0; i < n; ++i) {
            const double forces = math::abs(motion.force[i]) + math::abs(motion.force[i + 1]);
            tolerance[n + i] =
                math::max(tolerance[n + i], 0.25 * math::epsilon * h * forces / column.mass[i]);
        }
    }

    // ---- touching pairs -----------------------------------------------------------------------------------

    // Whether a neighbouring contact or gravity closes pair j, whose gap and rate are 0.
    bool presses(int j) const {
        const bool below = j == 0 ? column.gravity > 0.0 : motion.pushes(j - 1);
        return below || (j + 1 < column.balls && motion.pushes(j + 1));
    }

    void find_pressed() {
        for (bool changed = true; changed;) {
            changed = false;
            for (int j = column.floor ? 0 : 1; j < column.balls; ++j) {
                const bool touching = motion.pair[j] == Pair::open && y[j] == 0.0;
                if (!touching || motion.rate(j, y.data()) != 0.0 || !presses(j)) continue;
                begin(j, now());
                motion.pair[j] = Pair::pressed;
                changed = true;
            }
        }
    }

    // Turns pressed pairs into ordinary contacts once their compression exceeds rounding error.
    void settle_pressed() {
        for (int j = 0; j < column.balls; ++j) {
            if (motion.pair[j] != Pair::pressed || !(-y[j] > step.tiny(j))) continue;
            leave_implicit();
            motion.pair[j] = Pair::closed;
            step.disarmed[j] = 1;
        }
    }

    // Called when no ordinary contact is closed: pressed pairs that still approach become ordinary contacts, the others
    // end at gap 0. Returns whether there were any.
    bool release_pressed() {
        bool any = false;
        for (int j = 0; j < column.balls; ++j) {
            if (motion.pair[j] != Pair::pressed) continue;
            any = true;
            y[j] = 0.0;
            step.disarmed[j] = 1;
            motion.pair[j] = Pair::closed;
            const double rate = motion.rate(j, y.data());
            if (!(rate > 0.0)) close_contact(j, -rate);
        }
        return any;
    }

    // ---- events -------------------------------------------------------------------------------------------

    // Applies an event whose function is not positive at the start of the step, unless the pair is disarmed. Returns
    // whether there was one.
    bool event_at_start() {
        for (int j = 0; j < column.balls; ++j) {
            for (const Event kind : step.events_of(j)) {
                if (kind == Event::none || step.disarmed[j]) continue;
                if (step.function(j, kind, y.data(), step.k.data()).value > 0.0) continue;
                if (kind == Event::begins && !(motion.rate(j, y.data()) > 0.0)) {
                    y[j] = 0.0;  // touches without closing
                    step.disarmed[j] = 1;
                    continue;
                }
                apply(kind, j);
                return true;
            }
        }
        return false;
    }

    void apply(Event what, int j) {
        motion.choose_coordinate(j, y.data(), false);
        const double rate = motion.rate(j, y.data());
        const double balanced = -column.contacts[j].slack(rate).depth;  // gap of zero force
        step.disarmed[j] = 1;
        switch (what) {
            case Event::none:
            case Event::deepens:
            case Event::turns:
            case Event::slips:
            case Event::sticks:
                break;
            case Event::begins:
                y[j] = 0.0;
                begin(j, now());
                break;
            case Event::engages:
                y[j] = math::min(balanced, 0.0);
                y[motion.loss()] -= column.contacts[j].energy(motion.s(j, y.data()));
                begin(j, now());
                break;
            case Event::ends:
                y[j] = math::min(balanced, 0.0);
                close_contact(j, -rate);
                break;
            case Event::opens:
                y[j] = 0.0;
                open(j);
                break;
            case Event::parts:
                close_contact(j, -rate);
                step.disarmed[j] = 0;
                break;
        }
        result.steps += 1;
        h = math::min(h, 0.25 * motion.scales.time);
    }

    void begin(int j, double t) {
        leave_implicit();
        motion.pair[j] = Pair::closed;
        if (j == 0 && math::is_nan(sequence().t_first_touch)) start_clock(t);
        if (j == 0) {
            sequence().floor_begins(t);
        } else {
            counted[j] = sequence().pair_begins();
        }
        contact_of[j] = static_cast<int>(result.contacts.size());
        result.contacts.push_back({j, t, math::nan});
        if (!timed || kept) stopped = complete();
    }

    // Sets the origin of time to the first floor touch.
    void start_clock(double& t) {
        for (Contact& c : result.contacts) {
            c.begin -= t;
            c.end -= t;
        }
        for (std::size_t i = 0; i < result.intervals.size(); ++i) {
            result.intervals[i].t -= t;
            result.states[i * y.size() + static_cast<std::size_t>(motion.clock())] -= t;
        }
        sequence().t_end -= t;
        y[motion.clock()] -= t;
        t = 0.0;
    }

    void close_contact(int j, double gap_rate) {
        leave_implicit();
        result.contacts[contact_of[j]].end = now();
        if (j == 0) {
            sequence().floor_ends(now());
        } else if (counted[j]) {
            sequence().pair_ends(now(), gap_rate);
            if (!timed && column.balls == 2) keep(y);
        }
        motion.pair[j] = Pair::slack;
        if (y[j] < 0.0) {
            y[motion.loss()] += column.contacts[j].energy(motion.s(j, y.data()));
        } else {
            open(j);
        }
        if (!timed || kept) stopped = complete();
    }

    void open(int j) {
        leave_implicit();
        motion.pair[j] = Pair::open;
        if (j == 0) sequence().floor_opens();
    }

    // ---- the end ------------------------------------------------------------------------------------------

    bool rests() {
        if (!column.floor || !(column.gravity > 0.0)) return false;
        for (const Pair pair : motion.pair) {
            if (pair != Pair::closed) return false;
        }
        if (equilibrium.empty()) equilibrium.emplace_back(column);
        const double energy = equilibrium.front().energy(motion, y.data());
        if (!equilibrium.front().holds(energy)) return false;
        double sag = 0.0;
        for (int j = 0; j < column.balls; ++j) {
            if (equilibrium.front().reaches(column.contacts[j], j, deepest_compression * radius[j], energy))
                return false;
            const double depth = equilibrium.front().depth[j];
            result.compression[j] = math::max(result.compression[j], depth / radius[j]);
            sag += depth;
        }
        result.settling = 20.0 * (2.0 * math::pi) * math::sqrt(sag / column.gravity);
        if (!sequence().finished) sequence().comes_to_rest(column.balls > 1);
        stopped = complete();
        if (!stopped && equilibrium.front().settled(energy)) set_equilibrium();
        return stopped;
    }

    // Sets the state to the static equilibrium until `until`, recorded as an interval of length 0.
    void set_equilibrium() {
        for (int j = 0; j < column.balls; ++j) {
            motion.choose_coordinate(j, y.data(), false);
            y[j] = -equilibrium.front().depth[j];
            y[column.balls + j] = 0.0;
        }
        record(0.0);
        y[motion.clock()] = math::max(now(), options.until);
        keep(y);
        stopped = true;
    }

    Integration<Law> finish() {
        if (!kept || (!timed && math::is_nan(sequence().t_end))) keep(y);
        record(0.0);
        if (timed) {
            std::erase_if(result.contacts, [&](const Contact& c) { return c.begin > options.until; });
        }
        std::sort(result.contacts.begin(), result.contacts.end(), [](const Contact& a, const Contact& b) {
            return a.begin < b.begin || (a.begin == b.begin && a.pair < b.pair);
        });
        if (column.balls != 2) sequence().relative_velocity = sequence().separation_velocity = math::nan;
        sequence().close();
        return std::move(result);
    }
};

}  // namespace newton

template <class Law>
Integration<Law> integrate(const Column<Law>& column, const IntegrateOptions& options) {
    return newton::Run<Law>(column, options).integrate();
}

}  // namespace hardlimit::column
