// The contact of scaled_impact.hpp under any powers, integrated at order 8 in X = s⁴, dt = s³ dτ as in powers.hpp, with
// every change of stick and slip located. The spring is S = U s^(2m): the variable U needs no division by s.
//
// The integration starts and ends at a compression so small that neither time nor impulses matter. What happens at
// touch, where all forces vanish, is decided there as everywhere else.
#pragma once
#include "../base/event_location.hpp"
#include "../base/roots.hpp"
#include "powers.hpp"
#include "scaled_impact.hpp"

namespace hardlimit::contact {

namespace impact {

// A function of time with its first two derivatives.
struct Jet {
    double value, rate, second;
};

// X^(1/4), X' and what follows from them, at one instant.
struct Instant {
    double s, velocity, slip;  // X^(1/4), X', G
    double x;                  // X
    Jet force, stiffness, damping;
};

HL_FN double quarter_power(double s, int n) {
    return n >= 0 ? powers::whole_power(s, n) : 1.0 / powers::whole_power(s, -n);
}

// factor · X^(power/4), for the velocity X' and acceleration X''.
HL_FN Jet power_jet(PowerTerm of, double s, double x, double velocity, double acceleration) {
    if (of.power == 0 || of.factor == 0.0) return {of.factor, 0.0, 0.0};
    const double p = 0.25 * of.power, value = of.factor * quarter_power(s, of.power), growth = velocity / x;
    return {value, p * value * growth, p * value * ((p - 1.0) * growth * growth + acceleration / x)};
}

}  // namespace impact

class PowerImpact {
public:
    HL_FN explicit PowerImpact(const ScaledImpact& of) : of_(impact::simplified(of)), m_(of.loading) {
        scale_ = of_.coefficient > 1.0 ? 1.0 / of_.coefficient : 1.0;
        touch();
    }

    // Follows the contact to its end; false if that takes too many steps.
    template <class Observer>
    HL_FN bool run(Observer& observe) {
        for (int i = 0; i < most_steps; ++i) {
            double high = step();
            if (high == 0.0) return false;
            const Event kind = first_event(high);
            observe(surfaces_, state_[t], next_[t], [&](double time) { return state_at(time, high); });
            for (int k = 0; k < size; ++k) state_[k] = next_[k];
            rests_ = kind != Event::turn && rests(i);  // at the turn X' is 0 up to rounding error
            if (kind == Event::end || kind == Event::release || rests_) return true;
            if (kind == Event::none) {
                rearm();
            } else {
                disarmed_[0] = disarmed_[1] = false;
                handle(kind);
            }
        }
        return false;
    }
    HL_FN impact::State state() const { return state_of(state_); }
    HL_FN impact::Work work() const { return {state_[damped], state_[creep], state_[stuck], state_[slid]}; }
    // Whether the contact ended.
    HL_FN bool over() const { return !rests_; }

private:
    using Instant = impact::Instant;
    using Jet = impact::Jet;
    using State = impact::State;
    using Work = impact::Work;
    // s, V, G, U; integrals: time and the four of Work.
    enum Component { s, v, g, u, t, damped, creep, stuck, slid, size };
    enum class Event { none, release, end, turn, vanishing, upper, lower };
    static constexpr Event limits[] = {Event::upper, Event::lower};
    static constexpr int most_steps = 100000, patience = 20000;
    static constexpr double first = 1e-16, last = 1e-5;  // s at start and end
    static constexpr double tolerance = 1e-14, floor_of_scale = 1e-3;

    // --- forces

    HL_FN double normal_force(const double* y) const {
        return impact::quarter_power(y[s], of_.powers.elastic) +
               of_.normal_damping * impact::quarter_power(y[s], of_.powers.damping) * y[v];
    }
    HL_FN bool has_spring() const { return of_.stiffness.factor > 0.0; }
    HL_FN bool limits_spring() const { return of_.limit == SlipLimit::spring && has_spring(); }
    HL_FN double spring(const double* y) const { return y[u] * impact::quarter_power(y[s], 2 * m_); }

    HL_FN Instant instant(const double* y) const {
        Instant i{y[s], y[v], y[g], math::power<4>(y[s]), {}, {}, {}};
        const double a = -normal_force(y);
        const Jet elastic = impact::power_jet({1.0, of_.powers.elastic}, i.s, i.x, i.velocity, a);
        const Jet viscous =
            impact::power_jet({of_.normal_damping, of_.powers.damping}, i.s, i.x, i.velocity, a);
        const double rate = elastic.rate + viscous.rate * i.velocity + viscous.value * a;
        i.force = {
            -a, rate,
            elastic.second + viscous.second * i.velocity + 2.0 * viscous.rate * a - viscous.value * rate};
        i.force = {sign_ * i.force.value, sign_ * i.force.rate, sign_ * i.force.second};
        i.stiffness = impact::power_jet(of_.stiffness, i.s, i.x, i.velocity, a);
        i.damping = impact::power_jet(of_.damping, i.s, i.x, i.velocity, a);
        return i;
    }
    HL_FN double acceleration(const Instant& i) const { return -sign_ * i.force.value; }

    // m S X'/(2X) and its derivative.
    HL_FN Jet carried(const Instant& i, const Jet& force) const {
        const double growth = i.velocity / i.x, half = 0.5 * m_;
        const double bend = acceleration(i) / i.x - growth * growth;
        return {half * force.value * growth, half * (force.rate * growth + force.value * bend), 0.0};
    }
    // The spring of sticking surfaces.
    HL_FN Jet sticking_spring(const Instant& i, double force) const {
        Jet f{force, 0.0, 0.0};
        f.rate = i.stiffness.value * i.slip + carried(i, f).value;
        const double slowing = -(force + i.damping.value * i.slip);
        f.second = i.stiffness.rate * i.slip + i.stiffness.value * slowing + carried(i, f).rate;
        return f;
    }
    // The spring of slipping surfaces.
    HL_FN Jet slipping_spring(const Instant& i) const {
        const double most = of_.coefficient * sigma_;
        Jet f{most * i.force.value, most * i.force.rate, most * i.force.second};
        if (limits_spring()) return f;
        const double slowing = -f.value, jerk = -f.rate;
        const Jet& c = i.damping;
        f.second -= c.second * i.slip + 2.0 * c.rate * slowing + c.value * jerk;
        f.rate -= c.rate * i.slip + c.value * slowing;
        f.value -= c.value * i.slip;
        return f;
    }
    // G while the spring follows its limit, and its rate.
    HL_FN Jet following_slip(const Instant& i) const {
        const Jet f = slipping_spring(i), c = carried(i, f);
        const double value = (f.rate - c.value) / i.stiffness.value;
        return {value, (f.second - c.rate - i.stiffness.rate * value) / i.stiffness.value, 0.0};
    }
    HL_FN double tangential_force(const double* y) const {
        if (surfaces_ == Surfaces::slip) return of_.coefficient * sigma_ * sign_ * normal_force(y);
        if (surfaces_ == Surfaces::follow) return -following_slip(instant(y)).rate;
        return spring(y) + of_.damping.factor * impact::quarter_power(y[s], of_.damping.power) * y[g];
    }

    // --- integration

    HL_FN void rates(const double* y, double* out) const {
        const double cube = y[s] * y[s] * y[s], force = tangential_force(y), power = cube * force * y[g];
        out[s] = 0.25 * y[v];
        out[v] = -cube * normal_force(y);
        out[g] = -cube * force;
        out[u] = out[creep] = out[stuck] = out[slid] = 0.0;
        out[t] = cube;
        out[damped] =
            cube * of_.normal_damping * impact::quarter_power(y[s], of_.powers.damping) * y[v] * y[v];
        if (surfaces_ == Surfaces::slip) {
            out[slid] = power;
            return;
        }
        const bool sticks = surfaces_ == Surfaces::stick;
        if (sticks)
            out[u] =
                of_.stiffness.factor * y[g] * impact::quarter_power(y[s], 3 + of_.stiffness.power - 2 * m_);
        const double elastic = sticks ? spring(y) : slipping_spring(instant(y)).value;
        out[stuck] = cube * elastic * y[g];
        out[creep] = power - out[stuck];
    }
    HL_FN void at(double h, double* out) {
        const auto f = [&](const double* y, double* dy) { rates(y, dy); };
        DormandPrince::step(f, state_, h, size, stages_, out, t);
    }
    // Takes one step from state_ to next_, with error control; returns its length, 0 if every step is too long.
    HL_FN double step() {
        rates(state_, stages_);
        while (length_ > 1e-300) {
            at(length_, next_);
            double scale[size];
            for (int k = 0; k < size; ++k) {
                const bool relative = k == s || k == v || k == u || k == t;
                const double least = relative ? 1e-300 : floor_of_scale;
                scale[k] = tolerance * (math::abs(state_[k]) + math::abs(next_[k]) + least);
            }
            const double error = DormandPrince::error(stages_, length_, size, scale), taken = length_;
            length_ *= DormandPrince::growth(error);
            if (error <= 1.0) return taken;
        }
        return 0.0;
    }

    // --- events

    HL_FN EventFunction event(Event kind, const double* y) const {
        const double cube = y[s] * y[s] * y[s];
        const auto of = [&](double value, double rate) {
            return EventFunction{value, cube * rate, value, cube * rate};
        };
        if (kind == Event::turn) return of(y[v], -normal_force(y));
        if (kind == Event::release) {
            const double above = y[s] - last, climb = 0.25 * y[v];
            return {above, climb, above, climb};
        }
        const Instant i = instant(y);
        if (kind == Event::end || kind == Event::vanishing) return of(i.force.value, i.force.rate);
        const double value = scale_ * of_.coefficient;
        if (surfaces_ == Surfaces::stick) {
            const double side = kind == Event::upper ? scale_ : -scale_;
            const Jet q = limited_force(i, y);
            return of(value * i.force.value - side * q.value, value * i.force.rate - side * q.rate);
        }
        const Jet excess = surfaces_ == Surfaces::slip ? slip_excess(i) : share(kind, i);
        return of(scale_ * excess.value, scale_ * excess.rate);
    }
    // What Coulomb's law limits, of sticking surfaces.
    HL_FN Jet limited_force(const Instant& i, const double* y) const {
        Jet q = sticking_spring(i, spring(y));
        if (limits_spring()) return q;
        const double slowing = -(q.value + i.damping.value * i.slip);
        q.value += i.damping.value * i.slip;
        q.rate += i.damping.rate * i.slip + i.damping.value * slowing;
        return q;
    }
    // N σ, positive while the surfaces slip.
    HL_FN Jet slip_excess(const Instant& i) const {
        const double slowing = -of_.coefficient * sigma_ * i.force.value;
        if (!has_spring()) {
            const Jet& c = i.damping;
            return {sigma_ * (c.value * i.slip + slowing),
                    sigma_ * (c.rate * i.slip + c.value * slowing) - of_.coefficient * i.force.rate, 0.0};
        }
        const Jet f = slipping_spring(i), moved = carried(i, f), &k = i.stiffness;
        return {sigma_ * (k.value * i.slip - f.rate + moved.value),
                sigma_ * (k.rate * i.slip + k.value * slowing - f.second + moved.rate), 0.0};
    }
    // While the spring follows its limit: how far the force is from that of slip (upper) and of sticking (lower).
    HL_FN Jet share(Event kind, const Instant& i) const {
        const double least = of_.coefficient * i.force.value, force = -sigma_ * following_slip(i).rate;
        if (kind == Event::upper) return {least - force, 0.0, 0.0};
        return {force - least - sigma_ * i.damping.value * i.slip, 0.0, 0.0};
    }

    // Moves `high`, where next_ is, to the first zero of an event before it.
    HL_FN bool occurs(Event kind, double& high) {
        const bool disarmed =
            (kind == Event::upper && disarmed_[0]) || (kind == Event::lower && disarmed_[1]);
        EventFunction start = event(kind, state_);
        if (disarmed) start.smooth_slope = math::max(start.smooth_slope, 0.0);
        const auto value_at = [&](double h) {
            double y[size];
            at(h, y);
            return event(kind, y);
        };
        double bound = high;
        if (!falls_to_zero(start, event(kind, next_), disarmed, bound, value_at)) return false;
        at(bound, next_);
        high = locate_zero(
            bound, bound, [&] { return event(kind, next_); },
            [&](EventFunction, double here, double next) {
                return math::abs(next - here) <= 2.0 * math::epsilon * bound;
            },
            [&](double, double next) { at(next, next_); });
        return true;
    }

    // A limit is on guard again once its distance is more than rounding error.
    HL_FN void rearm() {
        for (const Event kind : limits) {
            bool& disarmed = disarmed_[kind == Event::upper ? 0 : 1];
            if (!disarmed) continue;
            const Instant i = instant(state_);
            const double forces = of_.coefficient * i.force.value + math::abs(spring(state_)) +
                                  i.damping.value * math::abs(i.slip);
            disarmed = surfaces_ == Surfaces::stick && event(kind, state_).value <= 1e-14 * scale_ * forces;
        }
    }
    // The first event within the step, whose length is cut there.
    HL_FN Event first_event(double& high) {
        Event kind = Event::none;
        const auto look = [&](Event possible) {
            if (occurs(possible, high)) kind = possible;
        };
        if (next_[s] < last && next_[v] < 0.0) look(Event::release);
        if (!of_.powers.attracts && next_[v] < 0.0) look(Event::end);
        if (m_ != of_.unloading && next_[v] < 0.0) look(Event::turn);
        if (of_.powers.attracts && sign_ > 0.0 && next_[v] < 0.0) look(Event::vanishing);
        if (of_.coefficient > 0.0 && of_.coefficient < math::infinity) {
            if (surfaces_ != Surfaces::slip || sigma_ > 0.0) look(Event::upper);
            if (surfaces_ != Surfaces::slip || sigma_ < 0.0) look(Event::lower);
        }
        return kind;
    }
    // An overdamped contact with attraction never ends. It is followed until the bodies creep.
    HL_FN bool rests(int steps) const {
        const bool creeps = of_.powers.attracts && state_[v] < 0.0;
        return creeps && (steps < patience ? state_[v] > -1e-10 && state_[s] < 0.1 : state_[v] > -1e-3);
    }

    // --- output

    HL_FN State state_of(const double* y) const {
        const bool sticks = surfaces_ == Surfaces::stick;
        const double elastic = !has_spring() ? 0.0 : sticks ? spring(y) : slipping_spring(instant(y)).value;
        return {y[t], math::power<4>(y[s]), y[v], normal_force(y), y[g], elastic, tangential_force(y)};
    }
    // Within the step of length `high` that follows state_.
    HL_FN State state_at(double time, double high) {
        double y[size];
        const auto left = [&](double h) {
            at(h, y);
            return time - y[t];
        };
        const double above = time - state_[t], below = time - next_[t];
        double h = above <= 0.0 ? 0.0 : high;
        if (above > 0.0 && below < 0.0)
            h = roots::falling_zero(left, 0.0, above, high, below, math::epsilon * time);
        at(h, y);
        return state_of(y);
    }

    // --- what an event changes

    HL_FN void set_spring(double force) { state_[u] = force / impact::quarter_power(state_[s], 2 * m_); }

    HL_FN void handle(Event kind) {
        if (kind == Event::turn) {
            const double force = spring(state_);
            m_ = of_.unloading;
            set_spring(force);
        } else if (kind == Event::vanishing) {
            sign_ = -1.0;
            if (has_spring() && of_.coefficient < math::infinity) choose_at_zero_force();
        } else if (surfaces_ == Surfaces::stick) {
            sigma_ = kind == Event::upper ? 1.0 : -1.0;
            surfaces_ = Surfaces::slip;
        } else {
            leave_limit(kind);
        }
    }
    // From slip, or from a spring that follows its limit.
    HL_FN void leave_limit(Event kind) {
        const Instant i = instant(state_);
        const Jet f = slipping_spring(i);
        if (has_spring()) set_spring(f.value);
        const bool to_slip = surfaces_ == Surfaces::follow && kind == Event::upper;
        const bool from_slip = surfaces_ == Surfaces::slip;
        surfaces_ = to_slip ? Surfaces::slip : Surfaces::stick;
        disarmed_[sigma_ > 0.0 ? 0 : 1] = true;
        if (!from_slip || !limits_spring() || !(i.damping.value > 0.0)) return;
        const double bend = of_.coefficient * i.force.second - sigma_ * sticking_spring(i, f.value).second;
        if (bend < 0.0) surfaces_ = Surfaces::follow, disarmed_[0] = disarmed_[1] = false;
    }
    // Where F_n changes its sign the surfaces have slipped; D = 0.
    HL_FN void choose_at_zero_force() {
        const Instant i = instant(state_);
        const bool followed = surfaces_ == Surfaces::follow;  // as fast as its limit; codes stick
        set_spring(limits_spring() ? 0.0 : -i.damping.value * i.slip);
        surfaces_ = Surfaces::stick;
        const double rate = limited_force(i, state_).rate;
        disarmed_[0] = disarmed_[1] = true;
        if (followed || math::abs(rate) <= of_.coefficient * i.force.rate) return;
        sigma_ = rate > 0.0 ? 1.0 : -1.0;
        surfaces_ = Surfaces::slip;
    }
    HL_FN void touch() {
        for (double& component : state_) component = 0.0;
        state_[s] = first;
        state_[v] = state_[g] = 1.0;
        state_[t] = math::power<4>(first);
        const Instant i = instant(state_);
        const double trial = limits_spring() ? 0.0 : i.damping.value;
        const bool within = of_.coefficient == math::infinity || trial <= of_.coefficient * i.force.value;
        surfaces_ = within && of_.coefficient > 0.0 ? Surfaces::stick : Surfaces::slip;
        if (surfaces_ == Surfaces::stick || of_.coefficient == 0.0 || !has_spring()) return;
        if (slip_excess(i).value >= 0.0) return;
        set_spring(slipping_spring(i).value);
        surfaces_ = Surfaces::stick;
        disarmed_[0] = true;
    }

    ScaledImpact of_;
    int m_;               // of the spring, at present
    double scale_;        // of Coulomb's limit, for large M
    double sign_ = 1.0;   // of F_n
    double sigma_ = 1.0;  // direction of slip
    Surfaces surfaces_ = Surfaces::stick;
    bool disarmed_[2] = {}, rests_ = false;
    double state_[size], next_[size], stages_[DormandPrince::stages * size];
    double length_ = first;
};

}  // namespace hardlimit::contact
