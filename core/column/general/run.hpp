// The run of the general solver: from switch to switch until the sequence is over (see motions.hpp).
#pragma once
#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "rest.hpp"

namespace hardlimit::column {

struct IntegrateOptions {
    double tolerance = 1e-14;    // local error in units of the impact (see Scales)
    long max_steps = 2'000'000;  // integration steps and switches together
    double until = math::nan;    // [s] after the first floor touch (cradle: release); NaN: end of sequence
    bool record = false;         // keep what sample() needs
};

namespace newton {

enum class Switch : unsigned char { none, begins, ends, opens, engages, parts };

// Start of an interval without switches. State: N coordinates (gap or s), N velocities, time, dissipated
// energy.
struct Interval {
    double t, length;  // length in τ
    std::vector<double> y;
    std::vector<Pair> pair;
    std::vector<unsigned char> rooted;  // whether the coordinate is s
};

}  // namespace newton

template <class Law>
struct Integration {
    Sequence sequence;              // times relative to the first floor touch (cradle: release)
    std::vector<Contact> contacts;  // by begin, then pair; with `until`, those that begin up to it
    double t_stop = math::nan;      // [s] time of the state below
    std::vector<double> gaps;       // [N] [m] at `until`, else t_end (two balls), else where the run stopped
    std::vector<double> velocity;   // [N] [m/s]
    long steps = 0;                 // integration steps, rejected ones included, and switches
    double energy_error = 0.0;      // largest error of the energy balance relative to the initial energy
    std::vector<newton::Interval> intervals;  // with `record`; the last has length 0
};

namespace newton {

// Distance to a switch, and its derivative in τ; `smooth` has the same zero and is smooth everywhere.
struct Surface {
    double value, slope, smooth, smooth_slope;
};

template <class Law>
class Run {
public:
    Run(const Column<Law>& c, const IntegrateOptions& o)
        : column(c),
          options(o),
          motion(c),
          y(motion.dimension(), 0.0),
          k(y),
          end(y),
          k_end(y),
          trial(y),
          k_trial(y),
          tolerance(y),
          contact_of(c.balls, -1),
          counted(c.balls, 0),
          fresh(c.balls, 0),
          touch_time(c.balls, 0.0) {
        std::copy(c.gaps.begin(), c.gaps.end(), y.begin());
        std::copy(c.velocity.begin(), c.velocity.end(), y.begin() + c.balls);
    }

    Integration<Law> integrate() {
        if (!(motion.scales.speed > 0.0)) {
            sequence().outcome = Outcome::invalid;
            return finish();
        }
        const Energies e = motion.energies(y.data());
        initial_energy = e.kinetic + e.potential;
        h = 0.05 * motion.scales.time;
        while (!stopped) {
            if (++result.steps > options.max_steps) {
                if (!sequence().finished || timed) sequence().outcome = Outcome::unresolved;
                break;
            }
            if (motion.free()) {
                fly();
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
    Motion<Law> motion;
    std::vector<double> y, k, end, k_end, trial, k_trial, tolerance;  // states and derivatives
    std::vector<int> contact_of;                                      // [N] index of the open contact
    std::vector<unsigned char> counted, fresh;  // [N] contact of the sequence; just put on a surface
    std::vector<double> touch_time;             // [N]
    std::vector<Equilibrium<Law>> equilibrium;  // made when first needed
    bool timed = !math::is_nan(options.until), stopped = false, kept = false;
    double initial_energy = 0.0, h = 0.0;

    Sequence& sequence() { return result.sequence; }
    double now() const { return y[motion.clock()]; }
    double tiny(int j) const { return 10.0 * options.tolerance * motion.scales.depth[j]; }

    bool clock_started() const { return !column.floor || !math::is_nan(result.sequence.t_first_touch); }

    // With `until`, more than two balls need nothing after it; two balls need the rest of the sequence.
    bool complete() {
        if (!timed) return sequence().finished;
        return kept && (column.balls != 2 || sequence().finished);
    }

    // ---- one interval -------------------------------------------------------------------------------------

    // Ends the interval at `end`, `length` in τ after y, with a switch of pair j there.
    void close_interval(double length, Switch what, int j) {
        record(length);
        if (timed && !kept && clock_started() && end[motion.clock()] >= options.until) {
            motion.reach(y.data(), k.data(), length, options.until, trial.data());
            trial[motion.clock()] =
                options.until;  // reached to rounding: below it, sample() would not know this state
            keep(trial);
            if (complete()) {
                y = trial;
                stopped = true;
                return;
            }
        }
        y.swap(end);
        check_energy();
        settle_touching();
        if (what != Switch::none) apply(what, j);
    }

    void record(double length) {
        if (options.record) result.intervals.push_back({now(), length, y, motion.pair, motion.rooted});
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

    // ---- no force acts ------------------------------------------------------------------------------------

    struct Next {
        double dt = math::infinity;
        Switch what = Switch::none;
        int pair = 0;

        void consider(double at, Switch kind, int j) {
            if (at < dt) *this = {at, kind, j};
        }
    };

    void fly() {
        double least = math::infinity;
        for (int j = 0; j < column.balls; ++j) {
            if (motion.pair[j] == Pair::touching) motion.pair[j] = Pair::open;
            motion.choose_coordinate(j, y.data(), false);
            if (j > 0) least = math::min(least, -motion.rate(j, y.data()));
        }
        sequence().moves_freely(least,
                                !column.floor || (sequence().floor_opened && motion.pair[0] == Pair::open));
        if ((stopped = complete())) return;
        Next next;
        for (int j = column.floor ? 0 : 1; j < column.balls; ++j) next_of_pair(j, next);
        if (next.what == Switch::none) {
            if (!clock_started()) sequence().outcome = Outcome::never_lands;
            stopped = true;
            if (!timed || kept || sequence().outcome == Outcome::never_lands) return;
            next.dt = options.until - now();
        }
        motion(y.data(), k.data());
        motion.advance(y.data(), k.data(), next.dt, end.data());
        if (next.what == Switch::none) end[motion.clock()] = options.until;  // not one rounding before it
        if (next.dt > 0.0) std::fill(fresh.begin(), fresh.end(), 0);
        close_interval(next.dt, next.what, next.pair);
    }

    // Gaps between balls change at constant rates, the floor gap is a parabola.
    void next_of_pair(int j, Next& next) const {
        const double gap = y[j], rate = motion.rate(j, y.data()), g = j == 0 ? column.gravity : 0.0;
        if (motion.pair[j] == Pair::open) {
            next.consider(time_to_close(gap, rate, g), Switch::begins, j);
            return;
        }
        const double square = rate * rate + 2.0 * g * gap;
        if (rate < 0.0 && square >= 0.0) {
            next.consider(math::max(2.0 * gap / (rate - math::sqrt(square)), 0.0), Switch::opens, j);
        }
        // ξ + τ_r rate = −missing now, growing as (rate + τ_r g) t + g t²/2.
        const double relaxation = column.contacts[j].relaxation_time(), speed = rate + relaxation * g;
        const double missing = fresh[j] ? 0.0 : math::max(gap - relaxation * rate, 0.0);
        const double grown = math::sqrt(speed * speed + 2.0 * g * missing);
        if (speed > 0.0) {
            next.consider(2.0 * missing / (speed + grown), Switch::engages, j);
        } else if (g > 0.0) {
            next.consider((grown - speed) / g, Switch::engages, j);
        }
    }

    static double time_to_close(double gap, double rate, double g) {
        if (gap > 0.0) {
            const double time = fall_time(gap, -rate, g);
            return math::is_nan(time) ? math::infinity : time;
        }
        if (rate > 0.0) return 0.0;
        return g > 0.0 ? -2.0 * rate / g : math::infinity;
    }

    // ---- some force acts ----------------------------------------------------------------------------------

    void integrate_step() {
        find_touching();
        if (motion.choose_coordinates(y.data())) h = math::min(h, 0.25 * motion.scales.time);
        motion(y.data(), k.data());
        if (at_surface() || rests()) return;
        const int n = motion.dimension();
        motion.advance(y.data(), k.data(), h, end.data());
        set_tolerance();
        const double error = DormandPrince::error(motion.stages.data(), h, n, tolerance.data());
        const double step = h;
        h *= DormandPrince::growth(error);
        if (!(error <= 1.0)) {
            if (h < 1e-20 * motion.scales.time) fail();
            return;
        }
        motion(end.data(), k_end.data());
        double length = step;
        Switch what = Switch::none;
        int which = 0;
        for (int j = 0; j < column.balls; ++j) {
            for (const Switch kind : switches_of(j)) {
                if (kind != Switch::none && crosses(j, kind, length)) {
                    what = kind;
                    which = j;
                }
            }
        }
        for (int j = 0; j < column.balls; ++j) {
            if (fresh[j] && (what == Switch::none || which != j)) fresh[j] = still_fresh(j);
        }
        close_interval(length, what, which);
    }

    void fail() {
        sequence().outcome = Outcome::unresolved;
        stopped = true;
    }

    void set_tolerance() {
        const int n = column.balls;
        const Scales& unit = motion.scales;
        for (int j = 0; j < n; ++j) {
            tolerance[j] = math::abs(y[j]) + (motion.rooted[j] ? unit.s[j] : unit.depth[j]);
            tolerance[n + j] = math::abs(y[n + j]) + unit.speed;
        }
        tolerance[motion.clock()] = unit.time;
        tolerance[motion.loss()] = unit.energy;
        for (double& x : tolerance) x *= options.tolerance;
    }

    void find_touching() {
        for (int j = 0; j < column.balls; ++j) {
            if (motion.pair[j] != Pair::open || y[j] != 0.0 || motion.rate(j, y.data()) != 0.0) continue;
            if (j == 0 && !column.floor) continue;
            motion.pair[j] = Pair::touching;
            touch_time[j] = now();
        }
    }

    void settle_touching() {
        for (int j = 0; j < column.balls; ++j) {
            if (motion.pair[j] == Pair::touching && -y[j] > tiny(j)) begin(j, touch_time[j]);
        }
    }

    std::array<Switch, 2> switches_of(int j) const {
        if (j == 0 && !column.floor) return {Switch::none, Switch::none};
        switch (motion.pair[j]) {
            case Pair::open:
                return {Switch::begins, Switch::none};
            case Pair::touching:
                return {Switch::parts, Switch::none};
            case Pair::slack:
                return {Switch::opens, Switch::engages};
            case Pair::closed:
                break;
        }
        return {Switch::ends, Switch::none};
    }

    Surface surface(int j, Switch kind, const double* state, const double* slope) const {
        constexpr int p = Law::onset_power;
        const double rate = motion.rate(j, state), rate_slope = motion.rate(j, slope);
        const double at = state[j], change = slope[j];
        const double depth = -motion.gap(j, state);
        const double depth_slope = motion.rooted[j] ? p * power<p - 1>(at) * change : -change;
        const auto simple = [](double f, double df) { return Surface{f, df, f, df}; };
        if (kind == Switch::begins) return simple(-depth, -depth_slope);
        if (kind == Switch::opens) return simple(depth, depth_slope);
        if (kind == Switch::parts) return simple(tiny(j) + depth, depth_slope);
        const double relaxation = column.contacts[j].relaxation_time();
        const double drive = depth + relaxation * rate, drive_slope = depth_slope + relaxation * rate_slope;
        if (kind == Switch::engages) return simple(-drive, -drive_slope);
        if (!motion.rooted[j]) return simple(drive, drive_slope);
        if (rate >= 0.0 || relaxation == 0.0) return {at, change, drive, drive_slope};
        const double least = root<p>(-relaxation * rate);
        return {at - least, change - least * rate_slope / (p * rate), drive, drive_slope};
    }

    // A surface reached before this step begins, without being the one just left.
    bool at_surface() {
        for (int j = 0; j < column.balls; ++j) {
            for (const Switch kind : switches_of(j)) {
                if (kind == Switch::none || fresh[j]) continue;
                if (surface(j, kind, y.data(), k.data()).value > 0.0) continue;
                apply(kind, j);
                return true;
            }
        }
        return false;
    }

    bool still_fresh(int j) const {
        for (const Switch kind : switches_of(j)) {
            if (kind == Switch::none) continue;
            if (!(surface(j, kind, end.data(), k_end.data()).value > 0.0)) return true;
        }
        return false;
    }

    void probe(double at) {
        motion.advance(y.data(), k.data(), at, trial.data());
        motion(trial.data(), k_trial.data());
    }

    // Looks for a zero of one surface in (0, length]; if there is one, `length` and `end` move to it.
    bool crosses(int j, Switch kind, double& length) {
        const Surface a = surface(j, kind, y.data(), k.data());
        const Surface b = surface(j, kind, end.data(), k_end.data());
        double high = length;
        if (b.value > 0.0 || (fresh[j] && b.value == 0.0)) {
            if (!(a.smooth_slope < 0.0 && b.smooth_slope > 0.0)) return false;
            if (!dips(j, kind, a, b, high)) return false;
        } else if (fresh[j] && a.smooth_slope >= 0.0 && b.smooth_slope >= 0.0) {
            return false;  // rising from the surface: rounding
        }
        locate(j, kind, high);
        length = high;
        end.swap(trial);
        k_end.swap(k_trial);
        return true;
    }

    // Follows the minimum of a surface between two positive values; `high` becomes a place below zero.
    bool dips(int j, Switch kind, Surface a, Surface b, double& high) {
        double low = 0.0, up = high;
        for (int i = 0; i < 40; ++i) {
            const double width = up - low;
            const double chord = (b.smooth - a.smooth) / width;
            // Cubic Hermite interpolant a + a' x + c x² + d x³: where its slope vanishes from below.
            const double d = (a.smooth_slope + b.smooth_slope - 2.0 * chord) / (width * width);
            const double c = (3.0 * chord - 2.0 * a.smooth_slope - b.smooth_slope) / width;
            const double square = math::max(c * c - 3.0 * d * a.smooth_slope, 0.0);
            const double lowest = -a.smooth_slope / (c + math::sqrt(square));
            const double x = math::clamp(lowest, 0.01 * width, 0.99 * width);
            const double least = a.smooth + x * (a.smooth_slope + x * (c + x * d));
            const double margin = 0.1 * width * math::max(-a.smooth_slope, b.smooth_slope);
            if (!(least < margin)) return false;
            probe(low + x);
            const Surface m = surface(j, kind, trial.data(), k_trial.data());
            if (m.value <= 0.0) {
                high = low + x;
                return true;
            }
            (m.smooth_slope > 0.0 ? b : a) = m;
            (m.smooth_slope > 0.0 ? up : low) = low + x;
        }
        return false;
    }

    // First zero in (0, high], the surface being below zero at `high`; leaves the state there in `trial`.
    void locate(int j, Switch kind, double& high) {
        const Surface a = surface(j, kind, y.data(), k.data());
        double low = 0.0, up = high, at = 0.5 * high;
        if (!fresh[j] && a.smooth_slope < 0.0) at = math::min(-a.smooth / a.smooth_slope, at);
        for (int i = 0; i < 100; ++i) {
            probe(at);
            const Surface f = surface(j, kind, trial.data(), k_trial.data());
            (f.value > 0.0 ? low : up) = at;
            const double newton = at - f.value / f.slope;
            const double next = newton >= low && newton <= up && f.slope < 0.0 ? newton : 0.5 * (low + up);
            if (math::abs(next - at) <= 4.0 * math::epsilon * math::abs(at) || next == at) break;
            at = next;
        }
        high = at;
    }

    // ---- switches -----------------------------------------------------------------------------------------

    void apply(Switch what, int j) {
        motion.choose_coordinate(j, y.data(), false);
        const double rate = motion.rate(j, y.data());
        const double balanced = column.contacts[j].relaxation_time() * rate;  // gap of zero force
        fresh[j] = 1;
        switch (what) {
            case Switch::none:
                break;
            case Switch::begins:
                y[j] = 0.0;
                begin(j, now());
                break;
            case Switch::engages:
                y[j] = math::min(balanced, 0.0);
                y[motion.loss()] -= column.contacts[j].energy(motion.s(j, y.data()));
                begin(j, now());
                break;
            case Switch::ends:
                y[j] = math::min(balanced, 0.0);
                close_contact(j, -rate);
                break;
            case Switch::opens:
                y[j] = 0.0;
                open(j);
                break;
            case Switch::parts:
                motion.pair[j] = Pair::open;
                fresh[j] = 0;
                break;
        }
        result.steps += 1;
        h = math::min(h, 0.25 * motion.scales.time);
    }

    void begin(int j, double t) {
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

    // Moves time zero to the first floor touch.
    void start_clock(double& t) {
        for (Contact& c : result.contacts) {
            c.begin -= t;
            c.end -= t;
        }
        for (Interval& i : result.intervals) {
            i.t -= t;
            i.y[motion.clock()] -= t;
        }
        for (double& x : touch_time) x -= t;
        sequence().t_end -= t;
        y[motion.clock()] -= t;
        t = 0.0;
    }

    void close_contact(int j, double gap_rate) {
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
        motion.pair[j] = Pair::open;
        if (j == 0) sequence().floor_opens();
    }

    // ---- the end ------------------------------------------------------------------------------------------

    bool rests() {
        if (!column.floor || !(column.gravity > 0.0) || sequence().outcome == Outcome::at_rest) return false;
        for (const Pair pair : motion.pair) {
            if (pair != Pair::closed) return false;
        }
        if (equilibrium.empty()) equilibrium.emplace_back(column);
        if (!equilibrium.front().holds(motion, y.data())) return false;
        if (!sequence().finished) sequence().comes_to_rest(column.balls > 1);
        stopped = complete();
        return stopped;
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
