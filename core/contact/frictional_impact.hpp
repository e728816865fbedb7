// One contact with friction and a fixed normal, under any normal force F = K ξ^p + C ξ^q ξ̇ and any FrictionTerms: the
// hard limit of a collision, exact at walls.
//
// The slip velocity keeps its line, because the spring is zero at touch: it is a number g, and m_t ġ = −D with the
// tangential force D. Scaled: ξ = L X with K L^(p+1) = m v², time in L/v, G = g/g_0, forces along the normal in m v²/L
// and tangential ones in m_t g_0 v/L. Then
//   X'' = −f,  G' = −D,  |D| <= M |f|,  M = κ μ v/g_0 = 1/ψ,  κ = m/m_t,
// X(0) = 0, X'(0) = 1, G(0) = 1, β = −G(end). While the surfaces stick, D = S + c G with the force S of the spring,
//   S' = R G + m S X'/(2X),
// and a slip ends when the spring alone would yield faster than its limit falls: when N σ < 0,
//   N = R G − S' + m S X'/(2X),  S = σ M |f| − c G (SlipLimit::total) or S = σ M |f| (SlipLimit::spring),
// with the direction σ of the slip.
//
// Under SlipLimit::spring with damping, a slip may end where the force of sticking bodies would lead back to the limit
// at once: then the spring follows its limit without slip, and the damping acts in part (the solution of Filippov
// between both; codes alternate from step to step). Without a spring D is c G limited by M |f|, under both limits.
#pragma once
#include "../base/event_location.hpp"
#include "friction.hpp"
#include "powers.hpp"

namespace hardlimit::contact {

// One contact in the units above.
struct ScaledImpact {
    Powers powers;
    double normal_damping;         // of X^q X'
    PowerTerm stiffness, damping;  // R and c as functions of X
    int loading, unloading;        // m while X grows and while it falls
    SlipLimit limit;
    double coefficient;  // M
};

// A contact in units of the user.
struct FrictionalContact {
    Powers powers;
    Coefficients normal;
    double mass, tangential_mass;  // m and m_t
    FrictionTerms friction;

    // L at this speed.
    HL_FN double length(double speed) const {
        const double square = mass * speed * speed / normal.elastic;
        return powers.elastic == 4 ? speed * math::sqrt(mass / normal.elastic)
                                   : math::pow(square, 4.0 / (powers.elastic + 4));
    }
    HL_FN ScaledImpact scaled(double speed, double slip) const {
        const double unit = length(speed), time = unit / speed;
        const PowerTerm k = friction.stiffness, c = friction.damping;
        const auto in_units = [&](double factor, int power) {
            return power == 0 ? factor : factor * math::pow(unit, 0.25 * power);
        };
        const bool linear = powers.elastic == 4 && k.power == 0;
        const double square = linear ? mass / normal.elastic : time * time;
        return {powers,
                in_units(normal.damping, powers.damping) * time / mass,
                {in_units(k.factor, k.power) * square / tangential_mass, k.power},
                {in_units(c.factor, c.power) * time / tangential_mass, c.power},
                friction.loading,
                friction.unloading,
                friction.limit,
                friction.coefficient == 0.0
                    ? 0.0
                    : friction.coefficient * (mass / tangential_mass) * (speed / slip)};
    }
};

enum class Surfaces : unsigned char {
    stick,
    slip,
    follow
};  // follow: the spring follows its limit without slip

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

// Integration at order 8 in X = s⁴, dt = s³ dτ, as in powers.hpp. It starts and ends at a compression so small that
// neither time nor forces matter: what happens first is decided there as it is later.
class Integration {
public:
    HL_FN explicit Integration(const ScaledImpact& of) : of_(of), m_(of.loading) {
        scale_ = of.coefficient > 1.0 ? 1.0 / of.coefficient : 1.0;
        touch();
    }

    HL_FN double slip_velocity() const { return state_[g]; }

    // Follows the contact to its end; false if that takes too many steps.
    HL_FN bool run() {
        for (int i = 0; i < most_steps; ++i) {
            if (advance()) return true;
        }
        return false;
    }

private:
    enum Component { s, v, g, u, t, size };
    enum class Event { none, release, end, turn, vanishing, upper, lower };
    static constexpr int most_steps = 100000;
    static constexpr double smallest = 1e-5;  // X^(1/4) at start and end
    static constexpr double tolerance = 1e-14, floor_of_scale = 1e-3;

    // --- forces

    HL_FN double normal_force(const double* y) const {
        return quarter_power(y[s], of_.powers.elastic) +
               of_.normal_damping * quarter_power(y[s], of_.powers.damping) * y[v];
    }
    HL_FN bool has_spring() const { return of_.stiffness.factor > 0.0; }
    HL_FN bool limits_spring() const { return of_.limit == SlipLimit::spring && has_spring(); }
    HL_FN double spring(const double* y) const { return y[u] * quarter_power(y[s], 2 * m_); }

    HL_FN Instant instant(const double* y) const {
        Instant i{y[s], y[v], y[g], math::power<4>(y[s]), {}, {}, {}};
        const double a = -normal_force(y);
        const Jet elastic = power_jet({1.0, of_.powers.elastic}, i.s, i.x, i.velocity, a);
        const Jet viscous = power_jet({of_.normal_damping, of_.powers.damping}, i.s, i.x, i.velocity, a);
        const double rate = elastic.rate + viscous.rate * i.velocity + viscous.value * a;
        i.force = {
            -a, rate,
            elastic.second + viscous.second * i.velocity + 2.0 * viscous.rate * a - viscous.value * rate};
        i.force = {sign_ * i.force.value, sign_ * i.force.rate, sign_ * i.force.second};
        i.stiffness = power_jet(of_.stiffness, i.s, i.x, i.velocity, a);
        i.damping = power_jet(of_.damping, i.s, i.x, i.velocity, a);
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
        return spring(y) + of_.damping.factor * quarter_power(y[s], of_.damping.power) * y[g];
    }

    // --- integration

    HL_FN void rates(const double* y, double* out) const {
        const double cube = y[s] * y[s] * y[s];
        out[s] = 0.25 * y[v];
        out[v] = -cube * normal_force(y);
        out[g] = -cube * tangential_force(y);
        out[u] = 0.0;
        if (surfaces_ == Surfaces::stick)
            out[u] = of_.stiffness.factor * y[g] * quarter_power(y[s], 3 + of_.stiffness.power - 2 * m_);
        out[t] = cube;
    }
    HL_FN void at(double h, double* out) {
        const auto f = [&](const double* y, double* dy) { rates(y, dy); };
        DormandPrince::step(f, state_, h, size, stages_, out, t);
    }
    // Takes one step from state_ to next_, with error control; returns its length.
    HL_FN double step() {
        rates(state_, stages_);
        for (;;) {
            at(length_, next_);
            double scale[size];
            for (int k = 0; k < size; ++k) {
                const bool relative = k == s || k == u || k == t;
                const double least = relative ? 1e-300 : floor_of_scale;
                scale[k] = tolerance * (math::abs(state_[k]) + math::abs(next_[k]) + least);
            }
            const double error = DormandPrince::error(stages_, length_, size, scale), taken = length_;
            length_ *= DormandPrince::growth(error);
            if (error <= 1.0) return taken;
        }
    }

    // --- events

    HL_FN EventFunction event(Event kind, const double* y) const {
        const double cube = y[s] * y[s] * y[s];
        const auto of = [&](double value, double rate) {
            return EventFunction{value, cube * rate, value, cube * rate};
        };
        if (kind == Event::turn) return of(y[v], -normal_force(y));
        const double above = y[s] - 0.5 * smallest, climb = 0.25 * y[v];
        if (kind == Event::release) return {above, climb, above, climb};
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

    // One step, cut at the first event; true at the end of the contact.
    HL_FN bool advance() {
        double high = step();
        Event first = Event::none;
        const auto look = [&](Event kind) {
            if (occurs(kind, high)) first = kind;
        };
        if (next_[s] < 0.5 * smallest) look(Event::release);
        if (!of_.powers.attracts && next_[v] < 0.0) look(Event::end);
        if (state_[v] > 0.0 && of_.loading != of_.unloading) look(Event::turn);
        if (of_.powers.attracts && sign_ > 0.0 && next_[v] < 0.0) look(Event::vanishing);
        if (of_.coefficient > 0.0 && of_.coefficient < math::infinity) {
            if (surfaces_ != Surfaces::slip || sigma_ > 0.0) look(Event::upper);
            if (surfaces_ != Surfaces::slip || sigma_ < 0.0) look(Event::lower);
        }
        for (int k = 0; k < size; ++k) state_[k] = next_[k];
        disarmed_[0] = disarmed_[1] = false;
        return first == Event::none ? rests() : handle(first);
    }
    // An overdamped contact with attraction never ends.
    HL_FN bool rests() const { return of_.powers.attracts && state_[v] < 0.0 && -state_[v] < 1e-17; }

    // --- what an event changes; true at the end of the contact

    HL_FN void set_spring(double force) { state_[u] = force / quarter_power(state_[s], 2 * m_); }

    HL_FN bool handle(Event kind) {
        if (kind == Event::end || kind == Event::release) return true;
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
        return false;
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
        set_spring(limits_spring() ? 0.0 : -i.damping.value * i.slip);
        surfaces_ = Surfaces::stick;
        const double rate = limited_force(i, state_).rate;
        disarmed_[0] = disarmed_[1] = true;
        if (math::abs(rate) <= of_.coefficient * i.force.rate) return;
        sigma_ = rate > 0.0 ? 1.0 : -1.0;
        surfaces_ = Surfaces::slip;
    }
    HL_FN void touch() {
        state_[s] = smallest;
        state_[v] = state_[g] = 1.0;
        state_[u] = 0.0;
        state_[t] = math::power<4>(smallest);
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
    bool disarmed_[2] = {};
    double state_[size], next_[size], stages_[DormandPrince::stages * size];
    double length_ = smallest;
};

}  // namespace impact

// β of one contact with this slip velocity at touch; NaN if it takes too many steps. Without slip velocity: the limit
// of a small one.
HL_FN double tangential_restitution(const FrictionalContact& contact, double speed, double slip) {
    impact::Integration motion(contact.scaled(speed, math::abs(slip)));
    return motion.run() ? -motion.slip_velocity() : math::nan;
}

}  // namespace hardlimit::contact
