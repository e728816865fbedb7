// The contact of scaled_impact.hpp with a linear normal force, constant R and c, and m = 0: in closed form, piece by
// piece.
//
// X obeys X'' + 2ζX' + X = 0, f = −X''. While the surfaces stick, S'' + c S' + R S = 0, G = S'/R, D = −S''/R; while
// they slip, G = G_0 − σM|X'_0 − X'|. So every event is a zero of a sum of two damped oscillations. Bounds of their
// derivatives from any time on are exact: with E = (y')² + w²y², E' = −4a(y')² <= 0, and every derivative of y is an
// oscillation of the same kind. The parabola below the event function that they give leads to its first zero without
// passing it. Functions that begin at zero, because an event put them there, leave it as their first derivative that
// does not vanish tells.
#pragma once
#include "../base/math.hpp"
#include "linear_dashpot.hpp"
#include "scaled_impact.hpp"

namespace hardlimit::contact {

namespace impact {

// A function of time with its derivatives, and bounds of their absolute values from that time on.
struct Curve {
    static constexpr int orders = 10;
    double value[orders] = {}, most[orders] = {};

    HL_FN void add(double factor, const Curve& other, int shift) {
        for (int n = 0; n + shift < orders; ++n) {
            value[n] += factor * other.value[n + shift];
            most[n] += math::abs(factor) * other.most[n + shift];
        }
    }
    // Sign just after now of a function whose derivatives below the order `from` vanish; 0: not decided by the first.
    HL_FN int sign_after(int from, int& leading) const {
        constexpr double rounding = 1e-13;
        for (leading = from; leading < 4; ++leading)
            if (math::abs(value[leading]) > rounding * most[leading]) return value[leading] > 0.0 ? 1 : -1;
        return 0;
    }
};

// y'' + 2a y' + w² y = 0.
class Oscillation {
public:
    HL_FN Oscillation(double a, double w, double value, double rate)
        : a_(a), w_(w), value_(value), rate_(rate) {
        width_ = math::sqrt(math::abs(w - a)) * math::sqrt(w + a);
        creeps_ = a > 1.1 * w;
        if (!creeps_) return;
        fast_ = a + width_;
        slow_ = w / fast_ * w;
        slow_part_ = (fast_ * value + rate) / (2.0 * width_);
        fast_part_ = -(slow_ * value + rate) / (2.0 * width_);
    }

    HL_FN Curve at(double t) const { return creeps_ ? creeping(t) : swinging(t); }

private:
    HL_FN Curve creeping(double t) const {
        Curve c;
        double slow = slow_part_ * math::exp(-slow_ * t), fast = fast_part_ * math::exp(-fast_ * t);
        for (int n = 0; n < Curve::orders; ++n, slow *= -slow_, fast *= -fast_) {
            c.value[n] = slow + fast;
            c.most[n] = math::abs(slow) + math::abs(fast);
        }
        return c;
    }
    HL_FN Curve swinging(double t) const {
        const double decay = math::exp(-a_ * t), phase = width_ * t;
        double even, odd;  // cos Ωt and sin Ωt/Ω, or cosh and sinh
        if (a_ < w_) {
            const math::SinCos<double> turn = math::sincos(phase);
            even = decay * turn.cos;
            odd = decay * (turn.sin / width_);
        } else if (phase < 0.5) {
            const double x = phase * phase;
            odd =
                decay * t *
                (1.0 + x / 6.0 * (1.0 + x / 20.0 * (1.0 + x / 42.0 * (1.0 + x / 72.0 * (1.0 + x / 110.0)))));
            even =
                decay *
                (1.0 + x / 2.0 * (1.0 + x / 12.0 * (1.0 + x / 30.0 * (1.0 + x / 56.0 * (1.0 + x / 90.0)))));
        } else {
            const double slow = math::exp(-(w_ / (a_ + width_) * w_) * t),
                         fast = math::exp(-(a_ + width_) * t);
            odd = 0.5 * (slow - fast) / width_;
            even = 0.5 * (slow + fast);
        }
        Curve c;
        c.value[0] = value_ * (even + a_ * odd) + rate_ * odd;
        c.value[1] = rate_ * (even - a_ * odd) - w_ * w_ * odd * value_;
        for (int n = 2; n < Curve::orders; ++n)
            c.value[n] = -2.0 * a_ * c.value[n - 1] - w_ * w_ * c.value[n - 2];
        for (int n = 0; n < Curve::orders; ++n) {
            const double below = n > 0 ? w_ * c.value[n - 1] : c.value[1] / w_;
            c.most[n] = math::sqrt(c.value[n] * c.value[n] + below * below);
        }
        return c;
    }

    double a_, w_, value_, rate_, width_, fast_, slow_, slow_part_, fast_part_;
    bool creeps_;
};

}  // namespace impact

class LinearImpact {
public:
    HL_FN static bool solves(const ScaledImpact& of) {
        const auto constant = [](PowerTerm term) { return term.power == 0 || term.factor == 0.0; };
        return of.powers.elastic == 4 && of.powers.damping == 0 && constant(of.stiffness) &&
               constant(of.damping) && of.loading == 0 && of.unloading == 0;
    }

    HL_FN explicit LinearImpact(const ScaledImpact& of)
        : of_(impact::simplified(of)),
          r_(of_.stiffness.factor),
          c_(of_.damping.factor),
          normal_(0.5 * of.normal_damping, 1.0, 0.0, 1.0),
          sticking_(0.0, 1.0, 0.0, 0.0) {
        scale_ = of_.coefficient > 1.0 ? 1.0 / of_.coefficient : 1.0;
        set_times();
        touch();
    }

    // Follows the contact to its end; false if that takes too many pieces.
    template <class Observer>
    HL_FN bool run(Observer& observe) {
        for (int i = 0; i < most_pieces && steps_ < most_steps; ++i) {
            const bool turns = sign_ > 0.0 && vanishing_ < end_;
            double until = turns ? vanishing_ : end_;
            const Event event = first_event(until);
            observe(surfaces_, begin_, until, [&](double time) { return state_at(time); });
            finish_piece(until);
            if (event != Event::none)
                change_surfaces(event);
            else if (turns)
                reverse_force();
            else
                return true;
        }
        return false;
    }
    HL_FN impact::State state() const { return state_; }
    HL_FN impact::Work work() const { return work_; }
    HL_FN bool over() const { return ends_; }

private:
    using Curve = impact::Curve;
    using Oscillation = impact::Oscillation;
    using State = impact::State;
    using Work = impact::Work;
    enum class Event { none, upper, lower };
    static constexpr Event limits[] = {Event::upper, Event::lower};
    static constexpr int most_pieces = 100000, most_steps = 2000000, most_steps_to_zero = 20000;

    HL_FN bool limits_spring() const { return of_.limit == SlipLimit::spring && r_ > 0.0; }

    // --- times

    HL_FN void set_times() {
        const double b = 0.5 * of_.normal_damping, after = 40.0;
        vanishing_ = linear_scaled_duration(b);
        if (!of_.powers.attracts) {
            end_ = vanishing_;
            return;
        }
        ends_ = b < 1.0;
        end_ = ends_ ? math::pi / (math::sqrt(1.0 - b) * math::sqrt(1.0 + b)) : math::infinity;
        // What comes later is below rounding.
        const double slowest = b < 1.0 ? b : 1.0 / (b + math::sqrt(b - 1.0) * math::sqrt(b + 1.0));
        end_ = math::min(end_, after / slowest);
    }

    // --- states

    // |f| with derivatives, from X.
    HL_FN static void add_force(Curve& sum, double factor, const Curve& x, double sign, int shift) {
        sum.add(-sign * factor, x, 2 + shift);
    }
    HL_FN double normal_force(const Curve& x) const { return -x.value[2]; }
    HL_FN State state_at(double time) const {
        const Curve x = normal_.at(time);
        State now{time, x.value[0], x.value[1], normal_force(x), slip_, spring_, 0.0};
        const double limit = of_.coefficient > 0.0 ? sigma_ * of_.coefficient * sign_ : 0.0;
        if (surfaces_ == Surfaces::stick) {
            set_sticking(now);
        } else if (surfaces_ == Surfaces::slip) {
            now.slip = slip_ + limit * slowing(time, x);
            now.tangential_force = limit * now.force;
            now.spring = r_ == 0.0         ? 0.0
                         : limits_spring() ? now.tangential_force
                                           : now.tangential_force - c_ * now.slip;
        } else {
            now.spring = limit * now.force;
            now.slip = -limit * x.value[3] / r_;
            now.tangential_force = limit * x.value[4] / r_;
        }
        return now;
    }
    // X' − X'_0, of a short time by Taylor series: M may be large.
    HL_FN double slowing(double time, const Curve& x) const {
        const double since = time - begin_;
        if (since * (1.0 + of_.normal_damping) > 0.02) return x.value[1] - rate_;
        const Curve before = normal_.at(begin_);
        double sum = 0.0;
        for (int n = Curve::orders - 1; n > 1; --n) sum = (sum + before.value[n]) * (since / (n - 1));
        return sum;
    }
    HL_FN void set_sticking(State& now) const {
        const double since = now.time - begin_;
        if (r_ == 0.0) {
            now.slip = slip_ * math::exp(-c_ * since);
            now.tangential_force = c_ * now.slip;
            return;
        }
        const Curve s = sticking_.at(since);
        now.spring = s.value[0];
        now.slip = s.value[1] / r_;
        now.tangential_force = -s.value[2] / r_;
    }

    // --- events

    // Positive until the event.
    HL_FN Curve margin(Event kind, double time) const {
        const Curve x = normal_.at(time);
        const double limit = scale_ * of_.coefficient, side = kind == Event::upper ? scale_ : -scale_;
        Curve g;
        if (surfaces_ == Surfaces::follow) {
            const double factor = limit / r_;
            add_force(g, kind == Event::upper ? limit : -limit, x, sign_, 0);
            add_force(g, kind == Event::upper ? factor : -factor, x, sign_, 2);
            if (kind == Event::lower) add_force(g, -c_ * factor, x, sign_, 1);
            return g;
        }
        if (surfaces_ == Surfaces::slip) return slip_margin(x);
        add_force(g, limit, x, sign_, 0);
        if (r_ > 0.0) {
            const Curve s = sticking_.at(time - begin_);
            g.add(limits_spring() ? -side : side / r_, s, limits_spring() ? 0 : 2);
            return g;
        }
        double viscous = -side * c_ * slip_ * math::exp(-c_ * (time - begin_));
        for (int n = 0; n < Curve::orders; ++n, viscous *= -c_) {
            g.value[n] += viscous;
            g.most[n] += math::abs(viscous);
        }
        return g;
    }
    // N σ, or without a spring the excess of the damping over the limit.
    HL_FN Curve slip_margin(const Curve& x) const {
        const double limit = scale_ * of_.coefficient, pull = r_ > 0.0 ? r_ : c_;
        Curve g;
        add_force(g, -limit, x, sign_, r_ > 0.0 ? 1 : 0);
        if (r_ > 0.0 && !limits_spring()) add_force(g, -limit * c_, x, sign_, 0);
        g.add(pull * limit * sign_, x, 1);
        const double constant = scale_ * pull * (sigma_ * slip_) - pull * limit * sign_ * rate_;
        g.value[0] += constant;
        g.most[0] += math::abs(constant);
        return g;
    }

    // The first zero of the margin before `until`.
    HL_FN double first_fall(Event kind, int order, double until) {
        double t = begin_;
        Curve g = margin(kind, t);
        int leading = 0;
        const int sign = g.sign_after(order, leading);
        if (sign < 0) return t;
        if (sign == 0) return math::infinity;  // zero throughout: three derivatives determine such a sum
        // Up to there the first derivative that does not vanish exceeds what the next can take.
        if (sign > 0 && leading > 0) t += 0.5 * (leading + 1) * g.value[leading] / g.most[leading + 1];
        for (int i = 0; i < most_steps_to_zero && t < until; ++i, ++steps_) {
            g = margin(kind, t);
            if (g.value[0] <= 0.0) return t;
            const double root = math::sqrt(g.value[1] * g.value[1] + 2.0 * g.most[2] * g.value[0]);
            const double step =
                g.value[1] > 0.0 ? (root + g.value[1]) / g.most[2] : 2.0 * g.value[0] / (root - g.value[1]);
            if (!(t + step > t)) return t;
            t += step;
            if (step <= math::epsilon * t) return math::min(t, until);
        }
        return math::infinity;
    }
    // The first event before `until`, which moves there.
    HL_FN Event first_event(double& until) {
        if (!(of_.coefficient > 0.0) || of_.coefficient == math::infinity) return Event::none;
        Event first = Event::none;
        for (const Event kind : limits) {
            const int side = kind == Event::upper ? 0 : 1;
            if (surfaces_ == Surfaces::slip && (sigma_ > 0.0) != (side == 0)) continue;
            const double time = first_fall(kind, order_[side], until);
            if (!(time < until)) continue;
            until = time;
            first = kind;
        }
        return first;
    }

    // --- pieces

    HL_FN double spring_energy(const State& s) const {
        return r_ > 0.0 ? 0.5 * s.spring / r_ * s.spring : 0.0;
    }
    HL_FN void finish_piece(double until) {
        const State a = state_at(begin_), b = state_at(until);
        const double work = 0.5 * (a.slip - b.slip) * (a.slip + b.slip);
        if (surfaces_ == Surfaces::slip) {
            work_.slipping += work;
        } else {
            const double stored = c_ > 0.0 ? spring_energy(b) - spring_energy(a) : work;
            work_.sticking += stored;
            work_.damping += work - stored;
        }
        const double kinetic = 0.5 * (a.rate - b.rate) * (a.rate + b.rate);
        work_.normal_damping +=
            kinetic - 0.5 * (b.compression - a.compression) * (b.compression + a.compression);
        state_ = b;
        begin_ = until;
        slip_ = b.slip;
        spring_ = b.spring;
        rate_ = b.rate;
    }
    HL_FN void start(Surfaces surfaces, int upper_order, int lower_order) {
        surfaces_ = surfaces;
        order_[0] = upper_order;
        order_[1] = lower_order;
        if (surfaces == Surfaces::stick && r_ > 0.0)
            sticking_ = Oscillation(0.5 * c_, math::sqrt(r_), spring_, r_ * slip_);
    }
    HL_FN void start_towards(Surfaces surfaces, int order) {
        start(surfaces, sigma_ > 0.0 ? order : 0, sigma_ > 0.0 ? 0 : order);
    }
    HL_FN void change_surfaces(Event kind) {
        if (surfaces_ == Surfaces::stick) {
            sigma_ = kind == Event::upper ? 1.0 : -1.0;
            start(Surfaces::slip, 0, 0);
        } else if (surfaces_ == Surfaces::follow) {
            const bool slips = kind == Event::upper;
            start_towards(slips ? Surfaces::slip : Surfaces::stick, slips ? 2 : 3);
        } else {
            start_towards(Surfaces::stick, r_ > 0.0 ? 2 : 1);
            if (!limits_spring() || !(c_ > 0.0)) return;
            const Event back = sigma_ > 0.0 ? Event::upper : Event::lower;
            if (margin(back, begin_).value[2] < 0.0) start(Surfaces::follow, 0, 0);
        }
    }
    HL_FN void reverse_force() {
        sign_ = -1.0;
        if (of_.coefficient == math::infinity) return start(Surfaces::stick, 0, 0);
        if (surfaces_ == Surfaces::follow) {  // as fast as its limit, whose bend decides; codes stick
            sigma_ = -sigma_;
            spring_ = 0.0;
            return start_towards(Surfaces::stick, 2);
        }
        if (r_ > 0.0 && of_.coefficient > 0.0) choose_at_zero_force();
    }
    // Where F_n is zero and the surfaces move: the limit is, too.
    HL_FN void choose_at_zero_force() {
        spring_ = limits_spring() ? 0.0 : -c_ * slip_;
        start(Surfaces::stick, 1, 1);
        for (const Event kind : limits) {
            int leading = 0;
            if (margin(kind, begin_).sign_after(1, leading) >= 0) continue;
            sigma_ = kind == Event::upper ? 1.0 : -1.0;
            start(Surfaces::slip, 0, 0);
            return;
        }
    }
    HL_FN void touch() {
        const double most = of_.coefficient * of_.normal_damping;
        if (of_.coefficient == 0.0) return start(Surfaces::slip, 0, 0);
        if (of_.coefficient == math::infinity) return start(Surfaces::stick, 0, 0);
        if (of_.normal_damping == 0.0 && r_ > 0.0) return choose_at_zero_force();
        if (limits_spring() || c_ <= most) return start(Surfaces::stick, 0, 0);
        start(Surfaces::slip, 0, 0);
        int leading = 0;
        if (r_ == 0.0 || margin(Event::upper, 0.0).sign_after(0, leading) >= 0) return;
        spring_ = most - c_;
        start(Surfaces::stick, 1, 0);
    }

    ScaledImpact of_;
    double r_, c_, scale_;
    double vanishing_, end_;  // first zero of f after touch, and end of the contact
    bool ends_ = true;
    int steps_ = 0;
    Oscillation normal_, sticking_;
    Work work_;
    State state_{};
    Surfaces surfaces_ = Surfaces::stick;
    double begin_ = 0.0, slip_ = 1.0, spring_ = 0.0, rate_ = 1.0;  // of the present piece: τ, G, S, X'
    double sign_ = 1.0, sigma_ = 1.0;                              // of F_n; direction of slip
    int order_[2] = {};  // of the zero with which the margins of the present piece begin
};

}  // namespace hardlimit::contact
