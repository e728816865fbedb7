// Newton's equations for N balls in a column and any contact law, integrated with high order and every switch
// of a force located (Eq. 14 of Müller & Pöschel, Phys. Rev. E 83, 041304 (2011), for N balls):
//   m_i dv_i/dt = F_i − F_{i+1} − m_i g,   d(gap_j)/dt = −rate_j,   rate_j = v_{j−1} − v_j  (floor: −v_1),
//   F_j = force(s_j, rate_j) while contact j is closed, otherwise 0;   ξ_j = −gap_j = s_j^p.
// The law is asked for nothing but the interface in contact/law.hpp.
//
// Order. A force like ξ^{3/2} has a singular derivative at touch, where every method loses its order. While a
// contact is closed its coordinate is therefore s = ξ^{1/p} (p = Law::onset_power), in which the force is a
// polynomial, and time runs as dt = g dτ:
//   ds_j/dτ = rate_j g/(p s_j^{p−1}),   1/g² = 1 + Σ_j (s_j/ℓ_j)^{2−2p}   over the closed contacts,
// so that g/s_j^{p−1} is bounded and smooth. Written relative to the smallest s it needs no division by zero,
// and g has the sign of that s: the solution continues smoothly through s = 0, where the end of an elastic
// contact is a simple zero like any other. (1/g linear in 1/s has a pole where two contacts end at one
// instant.) A contact that is pressed only indirectly (rate = 0 at touch) has ξ ~ t^{7/2} or so: there ξ is
// the better coordinate, and the choice is made anew before each step; it costs nothing, since a one-step
// method has no memory. p = 1: ξ, g = 1.
//
// Switches of pair j, each with the function that falls to zero there (τ_r = relaxation time of the law):
//   open → closed      gap                     slack → open      ξ
//   closed → slack     s − (−τ_r rate)^{1/p}   slack → closed    −(ξ + τ_r rate)      (a new contact)
// That of closed → slack is ξ + τ_r rate written as a simple zero also for τ_r → 0, where that has a double
// one. A slack pair overlaps without force. After a switch the state is put exactly on the surface, and the
// function that vanishes there counts again once it has become positive; a value below zero while it rises is
// rounding. A pair with gap and rate exactly 0 beside a closed contact is `touching`: its force law is on,
// and whether it becomes a contact, from that instant, is decided by the sign of ξ once that stands out from
// rounding.
//
// A zero inside a step is found by Newton's method in a bracket, each state being one Runge-Kutta step from
// the start of the interval. Two zeros within a step show as a minimum, which is followed until it is
// decided. While no force acts the motion is a parabola and everything is in closed form.
//
// Energy: potential = Σ_j W_j gap_j with W_j the weight above gap j (zero for balls lying on each other), the
// only form that keeps the digits of a small gap. Dissipation = ∫ Σ (F − F_elastic) rate dt; what a slack
// pair gives back of its stored energy is dissipation too.
//
// Rest. With all contacts closed the energy above the static equilibrium is Σ_j B_j(ξ_j) + kinetic energy
// with B_j(ξ) = U_j(ξ) − U_j(ξ_s) − W_j (ξ − ξ_s) >= 0 for a convex U, and never grows. Contact j can end
// only if this reaches min_ξ B_j(ξ) + m_eff (ξ/τ_r)²/2, the least energy with ξ + τ_r rate = 0. Below that it
// never ends.
#pragma once
#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "dormand_prince.hpp"
#include "sequence.hpp"
#include "state.hpp"

namespace hardlimit::column {

struct IntegrateOptions {
    double tolerance = 1e-14;    // local error in units of the impact (see Scales)
    long max_steps = 2'000'000;  // integration steps and switches together
    double until = math::nan;    // [s] after the first floor touch (cradle: release); NaN: end of sequence
    bool record = false;         // keep what sample() needs
};

namespace newton {

enum class Pair : unsigned char { open, touching, slack, closed };
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

// Energies of the column [J]; potential is zero when all gaps are.
struct Energies {
    double kinetic, potential, contact, dissipated;
};

namespace newton {

template <int p>
double power(double x) {
    double product = 1.0;
    for (int i = 0; i < p; ++i) product *= x;
    return product;
}
template <int p>
double root(double x) {
    if constexpr (p == 1) return x;
    if (!(x > 0.0)) return 0.0;
    return p == 2 ? math::sqrt(x) : math::pow(x, 1.0 / p);
}

// s > 0 with f(s) = target for an f that is nearly a power of s: secant steps in the logarithms.
template <class F>
double solve_power(const F& f, double target) {
    double s = 1.0;
    for (int i = 0; i < 4; ++i) {
        const double value = f(s);
        const double exponent = math::log(f(2.0 * s) / value) / math::log(2.0);
        s *= math::exp(math::log(target / value) / exponent);
    }
    return s;
}

template <class Law>
double pair_mass(const Column<Law>& c, int j) {
    return effective(j == 0 ? math::infinity : c.mass[j - 1], c.mass[j]);
}

// Units: the impact speed, and of each contact the compression ξ = s^p an elastic impact at this speed
// reaches.
struct Scales {
    double speed = 0.0, time = math::infinity, energy = 0.0;
    std::vector<double> s, depth;  // [N] ℓ_j and ℓ_j^p

    template <class Law>
    explicit Scales(const Column<Law>& c) : s(c.balls, 0.0), depth(c.balls, 0.0) {
        for (const double v : c.velocity) speed = math::max(speed, math::abs(v));
        const double landing = c.velocity[0] * c.velocity[0] + 2.0 * c.gravity * math::max(c.gaps[0], 0.0);
        if (c.floor) speed = math::max(speed, math::sqrt(landing));
        if (!(speed > 0.0)) return;
        for (int j = 0; j < c.balls; ++j) energy += 0.5 * c.mass[j] * speed * speed;
        for (int j = c.floor ? 0 : 1; j < c.balls; ++j) {
            const Law& law = c.contacts[j];
            const double target = 0.5 * pair_mass(c, j) * speed * speed;
            s[j] = solve_power([&](double x) { return law.energy(x); }, target);
            depth[j] = power<Law::onset_power>(s[j]);
            time = math::min(time, depth[j] / speed);
        }
        if (!c.floor) depth[0] = speed * time;
    }
};

// The equations of motion between two switches.
template <class Law>
struct Motion {
    static constexpr int p = Law::onset_power;

    const Column<Law>* column;
    Scales scales;
    std::vector<Pair> pair;
    std::vector<unsigned char> rooted;
    mutable std::vector<double> force, factor, stages;

    explicit Motion(const Column<Law>& c)
        : column(&c),
          scales(c),
          pair(c.balls, Pair::open),
          rooted(c.balls, 0),
          force(c.balls + 1, 0.0),
          factor(c.balls, 0.0),
          stages(DormandPrince::stages * dimension()) {}

    int balls() const { return column->balls; }
    int dimension() const { return 2 * balls() + 2; }
    int clock() const { return 2 * balls(); }
    int loss() const { return 2 * balls() + 1; }

    bool pushes(int j) const { return pair[j] == Pair::closed || pair[j] == Pair::touching; }
    bool free() const { return std::find(pair.begin(), pair.end(), Pair::closed) == pair.end(); }

    double rate(int j, const double* y) const {
        const double* v = y + balls();
        return (j == 0 ? 0.0 : v[j - 1]) - v[j];
    }
    double gap(int j, const double* y) const { return rooted[j] ? -power<p>(y[j]) : y[j]; }
    double s(int j, const double* y) const { return rooted[j] ? y[j] : root<p>(-y[j]); }

    // Returns g and leaves g (ℓ_j/s_j)^{p−1} in factor[j], which is at most 1.
    double clock_rate(const double* y) const {
        if constexpr (p == 1) return 1.0;
        int least = -1;
        for (int j = 0; j < balls(); ++j) {
            if (!rooted[j]) continue;
            factor[j] = power<p - 1>(y[j] / scales.s[j]);
            if (least < 0 || math::abs(factor[j]) < math::abs(factor[least])) least = j;
        }
        if (least < 0) return 1.0;
        const double smallest = factor[least];
        double square = smallest * smallest;
        for (int j = 0; j < balls(); ++j) {
            if (!rooted[j]) continue;
            factor[j] = j == least ? 1.0 : smallest / factor[j];
            square += factor[j] * factor[j];
        }
        const double norm = math::sqrt(square);
        for (int j = 0; j < balls(); ++j) factor[j] /= norm;
        return smallest / norm;
    }

    void operator()(const double* y, double* dy) const {
        const int n = balls();
        const double g = clock_rate(y);
        double dissipation = 0.0;
        for (int j = 0; j < n; ++j) {
            const double closing = rate(j, y);
            dy[j] = -g * closing;
            force[j] = 0.0;
            if (!pushes(j)) continue;
            const Law& law = column->contacts[j];
            const double at = s(j, y);
            force[j] = law.force(at, closing);
            dissipation += (force[j] - law.elastic_force(at)) * closing;
            if (rooted[j]) dy[j] = closing / p * factor[j] / power<p - 1>(scales.s[j]);
        }
        for (int i = 0; i < n; ++i) {
            dy[n + i] = g * ((force[i] - force[i + 1]) / column->mass[i] - column->gravity);
        }
        dy[clock()] = g;
        dy[loss()] = g * dissipation;
    }

    // State a time (in τ) after y; k0 = dy/dτ there. Without forces it is the parabola.
    void advance(const double* y, const double* k0, double length, double* out) const {
        const int n = balls();
        if (!free()) {
            std::copy(k0, k0 + dimension(), stages.begin());
            DormandPrince::step(*this, y, length, dimension(), stages.data(), out);
            return;
        }
        const double g = column->gravity;
        for (int j = 0; j < n; ++j) {
            out[j] = y[j] - length * (rate(j, y) + (j == 0 ? 0.5 * g * length : 0.0));
            out[n + j] = y[n + j] - g * length;
        }
        out[clock()] = y[clock()] + length;
        out[loss()] = y[loss()];
    }

    // The same at a given time within an interval; Newton's method on t(τ), which rises monotonically.
    void reach(const double* y, const double* k0, double length, double time, double* out) const {
        const double wanted = time - y[clock()];
        if (std::find(rooted.begin(), rooted.end(), 1) == rooted.end()) return advance(y, k0, wanted, out);
        std::vector<double> k(dimension());
        double low = 0.0, high = length, at = 0.5 * length;
        for (int i = 0; i < 80; ++i) {
            advance(y, k0, at, out);
            const double excess = out[clock()] - time;
            (excess > 0.0 ? high : low) = at;
            const double next = at - excess / clock_rate(out);
            const double previous = at;
            at = next > low && next < high ? next : 0.5 * (low + high);
            if (math::abs(at - previous) <= 4.0 * math::epsilon * length) break;
        }
        advance(y, k0, at, out);
    }

    Energies energies(const double* y) const {
        Energies e{0.0, 0.0, 0.0, y[loss()]};
        double weight = 0.0;
        for (int j = balls() - 1; j >= 0; --j) {
            weight += column->mass[j] * column->gravity;
            e.kinetic += 0.5 * column->mass[j] * y[balls() + j] * y[balls() + j];
            e.potential += weight * gap(j, y);
            if (pair[j] == Pair::open) continue;
            const double stored = column->contacts[j].energy(s(j, y));
            e.contact += stored;
            if (pair[j] == Pair::slack) e.dissipated -= stored;  // counted as lost where the force ended
        }
        return e;
    }

    void choose_coordinate(int j, double* y, bool use_root) {
        if (use_root == static_cast<bool>(rooted[j])) return;
        y[j] = use_root ? root<p>(-y[j]) : -power<p>(y[j]);
        rooted[j] = use_root;
    }

    // s where the contact is compressed or being compressed in earnest, the gap elsewhere. Returns whether
    // any coordinate has changed.
    bool choose_coordinates(double* y) {
        if constexpr (p == 1) return false;
        bool changed = false, at_zero = false;
        for (int j = 0; j < balls(); ++j) {
            const double sigma = pair[j] == Pair::closed ? s(j, y) / scales.s[j] : 0.0;
            const bool earnest = sigma > 0.1 || math::abs(rate(j, y)) > sigma * scales.speed;
            const bool use_root = pair[j] == Pair::closed && earnest && !(sigma == 0.0 && at_zero);
            at_zero = at_zero || (use_root && sigma == 0.0);
            changed = changed || use_root != static_cast<bool>(rooted[j]);
            choose_coordinate(j, y, use_root);
        }
        return changed;
    }
};

// The static equilibrium of the closed column and the energy that keeps it closed.
template <class Law>
struct Equilibrium {
    std::vector<double> weight, depth, stored;
    double barrier = math::infinity, rounding = 0.0;

    explicit Equilibrium(const Column<Law>& c) : weight(c.balls), depth(c.balls), stored(c.balls) {
        constexpr int p = Law::onset_power;
        double above = 0.0;
        for (int j = c.balls - 1; j >= 0; --j) {
            const Law& law = c.contacts[j];
            weight[j] = above += c.mass[j] * c.gravity;
            const double s = solve_power([&](double x) { return law.elastic_force(x); }, above);
            depth[j] = power<p>(s);
            stored[j] = law.energy(s);
            rounding += 1e-13 * above * depth[j];
            const double time = law.relaxation_time();
            const double inertia = time > 0.0 ? pair_mass(c, j) / (time * time) : math::infinity;
            double low = 0.0, high = depth[j];  // of the ξ that costs least
            for (int i = 0; i < 100 && time > 0.0; ++i) {
                const double middle = 0.5 * (low + high);
                const double slope = law.elastic_force(root<p>(middle)) - above + inertia * middle;
                (slope > 0.0 ? high : low) = middle;
            }
            const double kinetic = time > 0.0 ? 0.5 * inertia * low * low : 0.0;
            barrier = math::min(barrier, excess(law, j, root<p>(low)) + kinetic);
        }
    }

    double excess(const Law& law, int j, double s) const {
        return (law.energy(s) - stored[j]) - weight[j] * (power<Law::onset_power>(s) - depth[j]);
    }

    bool holds(const Motion<Law>& motion, const double* y) const {
        double total = motion.energies(y).kinetic;
        for (int j = 0; j < motion.balls(); ++j) {
            total += excess(motion.column->contacts[j], j, motion.s(j, y));
        }
        return total < barrier || total < rounding;
    }
};

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

// Where sample() writes; a null pointer asks for nothing.
struct Samples {
    double* gaps;        // [n × N] [m]
    double* velocity;    // [n × N] [m/s]
    double* force;       // [n × N] [N], pair 0 (floor) first
    Energies* energies;  // [n] [J]
};

// State at n times from a recorded integration. NaN outside the recorded range.
template <class Law>
void sample(const Column<Law>& column, const Integration<Law>& run, const double* times, long n,
            const Samples& out) {
    newton::Motion<Law> motion(column);
    const int balls = column.balls;
    std::vector<double> k(motion.dimension()), y(motion.dimension());
    for (long i = 0; i < n; ++i) {
        const auto after =
            std::upper_bound(run.intervals.begin(), run.intervals.end(), times[i],
                             [](double t, const newton::Interval& interval) { return t < interval.t; });
        const bool known = after != run.intervals.begin() && times[i] <= run.intervals.back().t;
        if (known) {
            const newton::Interval& from = *(after - 1);
            motion.pair = from.pair;
            motion.rooted = from.rooted;
            motion(from.y.data(), k.data());
            motion.reach(from.y.data(), k.data(), from.length, times[i], y.data());
        } else {
            std::fill(y.begin(), y.end(), math::nan);
        }
        for (int j = 0; j < balls; ++j) {
            const double pushed = column.contacts[j].force(motion.s(j, y.data()), motion.rate(j, y.data()));
            const double force = motion.pushes(j) ? math::max(pushed, 0.0) : 0.0;
            if (out.gaps) out.gaps[i * balls + j] = motion.gap(j, y.data());
            if (out.velocity) out.velocity[i * balls + j] = y[balls + j];
            if (out.force) out.force[i * balls + j] = known ? force : math::nan;
        }
        if (out.energies) out.energies[i] = motion.energies(y.data());
    }
}

}  // namespace hardlimit::column
