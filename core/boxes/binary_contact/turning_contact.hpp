// The isolated contact of two spheres with friction, in three dimensions: the line of centres turns, the surfaces stick
// and slip. Equations: turning_motion.hpp. The contact ends when the normal force ends, as in planar_contact.hpp.
//
// Integration of order 8. Located to rounding: the end; the begin of slip, |T + γ_t g| = μ F_n (|T| under
// SlipLimit::spring); the begin of sticking, where the rate of slip would become negative; and, if the history of T
// changes there, the greatest compression. Near F_n = 0 the direction of slip relaxes at the rate |h|/(μ F_n): an
// implicit method (implicit_slip.hpp) takes steps that this rate does not bound, and a direction that relaxes slowly is
// followed by steps in proportion to F_n until the rest of the impulse is negligible.
//
// The spins of both bodies follow from Ω: with K = ∫ r n×F_t dt, ΔΩ = −(c/(m l²)) K and Δω_i = −R_i K/(l I_i).
#pragma once
#include "../../base/event_location.hpp"
#include "implicit_slip.hpp"
#include "turning_series.hpp"

namespace hardlimit::boxes {

template <class Normal>
class TurningSolver : public TurningStates<Normal> {
public:
    using Base = TurningStates<Normal>;
    static constexpr double tolerance = 1e-13;   // of one step
    static constexpr double longest_step = 0.2;  // in τ
    static constexpr double first_step =
        0.05;  // short: forces that begin at zero change fast beside each other
    static constexpr int most_steps = 100'000;
    static constexpr int most_changes = 1000;

    using Base::Base;
    using Base::state_of;

    static bool accepts(const TurningApproach& a) {
        const Approach planar = M::approach_of(a);
        return PlanarSolver<Normal>::accepts(planar) && planar.normal_speed >= slowest_approach &&
               a.arm > 0.0 && a.rotational_ratio > 0.0 && math::is_finite(dot(a.spin, a.spin));
    }

    // Calls visit(*this) after every step; at() then gives the states within that step.
    template <class Visit>
    TurningContact integrate(Visit&& visit) {
        if (!motion_.solvable()) return {.outcome = Outcome::invalid};
        motion_.start(begin_);
        motion_.choose_at_touch(begin_);
        motion_.frozen = motion_.friction().coefficient == 0.0;
        result_.slips_first = motion_.slips;
        set_scales();
        motion_(begin_, stages_);
        for (int i = 0; i < most_steps; ++i) {
            if (!take_step()) {
                if (!(math::max(h_, implicit_h_) > 1e-14)) break;
                continue;
            }
            const Event event = first_event();
            visit(*this);
            if (event == Event::ends) return this->finish(end_);
            if (too_deep()) return {.outcome = Outcome::too_deep};
            if (event != Event::none && !apply(event)) break;
            motion_.renew_reference(end_);
            for (int c = 0; c < n; ++c) begin_[c] = end_[c];
            motion_(begin_, stages_);
            last_ = event;
        }
        return {.outcome = Outcome::unresolved};
    }

    double end_time() const { return end_[M::time] * motion_.time_unit(); }

    // The state at a time [s] within the step just taken, by Newton's method on T(τ), which is increasing.
    TurningState at(double time) {
        const double wanted = time / motion_.time_unit(), whole = length_;
        double kept[n], slope[n], low = 0.0, high = whole;
        for (int c = 0; c < n; ++c) kept[c] = end_[c];
        double x = whole * (wanted - begin_[M::time]) / (end_[M::time] - begin_[M::time]);
        for (int i = 0; i < 80 && x > 0.0; ++i) {
            advance(x);
            motion_(end_, slope);
            const double excess = end_[M::time] - wanted;
            (excess > 0.0 ? high : low) = x;
            const double newton = x - excess / slope[M::time];
            const double next = newton >= low && newton <= high ? newton : 0.5 * (low + high);
            if (math::abs(next - x) <= 2.0 * math::epsilon * whole) break;
            x = next;
        }
        TurningState state = state_of(x > 0.0 ? end_ : begin_);
        state.time = time;
        for (int c = 0; c < n; ++c) end_[c] = kept[c];
        length_ = whole;
        return state;
    }

private:
    using M = TurningMotion<Normal>;
    static constexpr int n = M::dimension, m = M::turn;  // m: components under error control
    enum class Event : unsigned char {
        none,
        turns,
        slips,
        sticks,
        holds,
        ends
    };  // holds: ceases to follow the limit

    using Base::motion_, Base::result_;
    double begin_[n], end_[n], slope_[n], scale_[m];
    double stages_[DormandPrince::stages * n];  // the first is the derivative at begin_
    double h_ = first_step, implicit_h_ = first_step, length_ = 0.0;
    bool implicit_ = false;
    int followed_ = 0;
    double drift_ = 0.0;  // by which the rate of slip is too small after T has followed its limit
    Event last_ = Event::none;

    // --- one step -------------------------------------------------------------------------------------------------

    void set_scales() {
        const auto now = motion_.now(begin_);
        const double fast = math::abs(begin_[M::twist]) + now.w.length() + now.u.length();
        const double slide =
            math::max(tolerance * math::max(1.0, now.g.length()), 4.0 * math::epsilon * fast);
        for (double& s : scale_) s = slide;
        scale_[M::root_depth] = scale_[M::rate] = tolerance;
        scale_[M::twist] = math::max(slide, tolerance * math::abs(begin_[M::twist]));
    }

    // end_ = the state x after begin_.
    void advance(double x) {
        length_ = x;
        if (implicit_)
            ImplicitSlip<M>::step(motion_, begin_, x, scale_, end_);
        else
            DormandPrince::step(motion_, begin_, x, n, stages_, end_, M::coupled);
    }

    // Error in the direction of slip counts in proportion to the force; near the end, to the rest of the impulse.
    void scale_direction() {
        if (!motion_.slips) {
            scale_[M::memory] = scale_[M::memory + 1] = scale_[M::across];
            return;
        }
        const double force = math::clamp(motion_.limit(motion_.now(begin_)), 1e-5, 1.0);
        const double rest = begin_[M::rate] < 0.0 ? force : 1.0;
        scale_[M::memory] = scale_[M::across] / (force * rest);
        scale_[M::memory + 1] = 1.0;
    }

    // Chooses the method and a bound of the step.
    double prepare() {
        implicit_ = false;
        if (motion_.follows && begin_[M::rate] < 0.0 && motion_.limit(motion_.now(begin_)) < negligible_limit)
            motion_.freeze(begin_);
        if (!motion_.slips || !motion_.has_spring() || motion_.frozen || motion_.is_planar(begin_))
            return longest_step;
        double dy[n];
        const auto drive = motion_.slip_rates(begin_, dy);
        const double limit = motion_.limit(motion_.now(begin_));
        const double pull = math::sqrt(drive.along * drive.along + drive.across * drive.across);
        implicit_ = !(pull * math::min(h_, longest_step) < mild * limit);
        if (!(begin_[M::rate] < 0.0)) return longest_step;
        if (limit < negligible_limit) {
            motion_.freeze(begin_);
            implicit_ = false;
        }
        const auto surface = motion_.units().end_surface(begin_, dy);
        const double left = surface.value / -surface.slope;
        if (motion_.frozen || !(pull * left < mild * limit)) return longest_step;
        implicit_ = false;
        return 0.7 * left;
    }
    static constexpr double mild =
        3.0;  // rate of the direction over that of the step up to which the step is explicit
    static constexpr double negligible_limit =
        1e-7;  // μ F_n at which the direction no longer matters, in m V²/L

    bool take_step() {
        const double longest = prepare();
        scale_direction();
        if (motion_.frozen) motion_(begin_, stages_);
        if (implicit_) {
            length_ = math::min(implicit_h_, longest_implicit_step);
            const double error = ImplicitSlip<M>::step(motion_, begin_, length_, scale_, end_);
            implicit_h_ = length_ * Radau::growth(error);
            if (!(error <= 1.0)) return false;
        } else {
            length_ = math::min(h_, longest);
            DormandPrince::step(motion_, begin_, length_, n, stages_, end_, M::coupled);
            const double error = DormandPrince::error(stages_, length_, n, scale_, m, m);
            h_ = length_ * DormandPrince::growth(error);
            if (!(error <= 1.0)) return false;
        }
        motion_(end_, slope_);
        return true;
    }
    static constexpr double longest_implicit_step = 0.5;

    // --- events ---------------------------------------------------------------------------------------------------

    // The first event in the step just taken; moves end_ there.
    Event first_event() {
        Event first = Event::none;
        if (end_[M::rate] < 0.0 && motion_.units().end_surface(end_, slope_).value <= 0.0) {
            locate(Event::ends);
            first = Event::ends;
        }
        const double end = length_;
        const auto& f = motion_.friction();
        if (!motion_.unloads && f.loading != f.unloading && end_[M::rate] <= 0.0) {
            locate(Event::turns);
            first = Event::turns;
        }
        if (f.coefficient == math::infinity || motion_.frozen) return first;
        for (const Event change : {motion_.slips ? Event::sticks : Event::slips, Event::holds}) {
            if (change == Event::holds && !motion_.follows) continue;
            // At the end of the force that limits T, T may be zero too: look just before.
            const bool both_end = first == Event::ends && change == Event::slips && !motion_.follows;
            if (both_end) probe(change, end * (1.0 - 1e-6));
            if (!occurs(change)) {
                if (both_end) probe(change, end);
                continue;
            }
            locate(change);
            if (first != Event::ends || length_ < end * (1.0 - 1e-13)) first = change;
        }
        return first;
    }

    // Value and slope of an event function at a state; the slopes of those of stick and slip by a difference.
    EventFunction function(Event event, const double* y, const double* dy) const {
        if (event == Event::turns) return simple(y[M::rate], dy[M::rate]);
        if (event == Event::ends) {
            if (!(y[M::rate] < 0.0)) return simple(1.0, 0.0);
            const auto f = motion_.units().end_surface(y, dy);
            return simple(f.value, f.slope);
        }
        const double difference = 1e-5 * length_;
        double near[n];
        for (int c = 0; c < n; ++c) near[c] = y[c] + difference * dy[c];
        const Change here = change(event, y), then = change(event, near);
        return {here.value, (then.value - here.value) / difference, here.smooth,
                (then.smooth - here.smooth) / difference};
    }
    static EventFunction simple(double value, double slope) { return {value, slope, value, slope}; }

    // What is positive until the surfaces change, and a smooth function of the same sign. In the first step, where all
    // forces may begin at zero, the latter is divided by powers of the normal force.
    struct Change {
        double value, smooth;
    };
    Change change(Event event, const double* y) const {
        const auto now = motion_.now(y);
        if (motion_.follows) {
            const double part = motion_.damping_part(y, now);
            const double value = event == Event::slips ? math::min(part, 10.0) : math::max(1.0 - part, -10.0);
            return {value, value};
        }
        const double limit = motion_.limit(now);
        const bool first = begin_[M::root_depth] == 0.0 && limit > 0.0;
        if (event == Event::slips) {
            const Tangential force = motion_.limited(y, now);
            const double square = limit * limit, smooth = square - force * force;
            return {limit - force.length(), first ? smooth / square : smooth};
        }
        const double excess = motion_.slipping(y) + drift_;
        return {excess, first ? excess * y[M::root_depth] / limit : excess};
    }

    EventFunction probe(Event event, double x) {
        advance(x);
        motion_(end_, slope_);
        return function(event, end_, slope_);
    }
    // The function at a part of the step just taken, from the cubic polynomials of the state.
    EventFunction estimate(Event event, double part) const {
        const double rest = 1.0 - part, moved = part * part * (3.0 - 2.0 * part);
        const double first = rest * rest * part * length_, last = -part * part * rest * length_;
        const double fast = 6.0 * part * rest / length_;
        const double first_rate = rest * (1.0 - 3.0 * part), last_rate = part * (3.0 * part - 2.0);
        double y[n] = {}, dy[n] = {};
        for (int c = 0; c < M::turn; ++c) {
            const double change = end_[c] - begin_[c];
            y[c] = begin_[c] + moved * change + first * stages_[c] + last * slope_[c];
            dy[c] = fast * change + first_rate * stages_[c] + last_rate * slope_[c];
        }
        return function(event, y, dy);
    }

    // Whether a change of stick and slip occurs in the step; end_ moves to a point beyond it.
    bool occurs(Event change) {
        const double whole = length_;
        const EventFunction after = function(change, end_, slope_);
        EventFunction before = function(change, begin_, stages_);
        if (begin_[M::root_depth] == 0.0 && !(before.value > 0.0)) {  // all forces begin at zero
            before = estimate(change, 1e-6);
            if (!(before.value > 0.0)) return after.value <= 0.0;
        }
        const EventFunction between = motion_.follows ? after : estimate(change, 0.5);
        const bool disarmed = last_ != Event::none && last_ != Event::turns;
        if (disarmed && !(before.value > 0.0) && between.value > 0.0)
            before.smooth_slope = 0.0;  // rounding at the event before
        const auto at = [&](double x) { return probe(change, x); };
        double high = whole;
        const bool falls = falls_to_zero(before, between, after, disarmed, 0.5 * whole, high, at);
        if (length_ != high) probe(change, high);
        return falls;
    }

    void locate(Event event) {
        locate_zero(
            length_, length_, [&] { return function(event, end_, slope_); },
            [](EventFunction, double at, double next) {
                return math::abs(next - at) <= 2.0 * math::epsilon * at;
            },
            [&](double, double next) { probe(event, next); });
    }

    bool apply(Event event) {
        if (event == Event::turns) {
            motion_.begin_unloading(end_);
            return true;
        }
        if (event == Event::holds) {
            motion_.follows = false;
            return ++followed_ < most_changes;
        }
        if (result_.changes < most_intervals) result_.change[result_.changes] = end_time();
        if (++result_.changes > most_changes) return false;
        drift_ = 0.0;
        if (event == Event::slips) {
            const bool followed = motion_.follows;
            motion_.begin_slip(end_, motion_.limited(end_, motion_.now(end_)));
            if (followed) drift_ = 2.0 * math::max(-motion_.slipping(end_), 0.0);
        } else
            motion_.begin_stick(end_);
        implicit_h_ = longest_step;
        return true;
    }

    bool too_deep() const {
        const double depth =
            math::max(math::power<M::p>(begin_[M::root_depth]), math::power<M::p>(end_[M::root_depth]));
        return depth * motion_.units().ratio > PlanarSolver<Normal>::deepest;
    }
};

// A contact without friction: planar_contact.hpp, bit for bit. The spin rests.
template <class Normal>
TurningContact frictionless_contact(const Normal& law, const TurningApproach& touch) {
    const TurningMotion<Normal> motion({law, {}}, touch);
    const Approach approach = TurningMotion<Normal>::approach_of(touch);
    const PlanarContact end = solve_planar_contact(law, approach);
    if (end.outcome != Outcome::ok) return {.outcome = end.outcome};
    const bool wall = motion.is_wall();
    const double half = 0.5 * end.turn, sine = math::sin(end.turn);
    const double versine = 2.0 * math::sin(half) * math::sin(half), r = touch.distance - end.compression;
    const auto turned = [&](double along, double across) {
        return motion.from_touch(
            {across * (1.0 - versine) + along * sine, 0.0, along * (1.0 - versine) - across * sine});
    };
    const double left = end.compression;
    const Vector3 shift =
        wall ? motion.from_touch({approach.tangential_speed * end.duration, 0.0, -left})
             : motion.from_touch({r * sine, 0.0, -left * (1.0 - versine) - touch.distance * versine});
    const double stored = law.energy(onset_root<Normal::onset_power>(left)), v = approach.normal_speed;
    const double lost =
        0.5 * touch.effective_mass *
        (end.speed_loss * (v + end.radial_speed) + (approach.tangential_speed - end.tangential_speed) *
                                                       (approach.tangential_speed + end.tangential_speed));
    return {.outcome = Outcome::ok,
            .duration = end.duration,
            .shift = shift,
            .velocity = turned(end.radial_speed, end.tangential_speed),
            .spin = touch.spin,
            .normal = turned(1.0, 0.0),
            .compression = left,
            .normal_spring = stored,
            .tangential_spring = 0.0,
            .normal_damping = lost - stored,
            .tangential_damping = 0.0,
            .slip = 0.0,
            .changes = 0,
            .slips_first = true,
            .change = {}};
}

template <class Normal>
inline constexpr bool has_series = Normal::onset_power == 1;

// Solves the contact from touch to its end. The outcome is `invalid` if TurningSolver::accepts refuses the input or the
// history of the friction is singular at touch.
template <class Normal>
TurningContact solve_turning_contact(const WithFriction<Normal>& law, const TurningApproach& touch) {
    using Solver = TurningSolver<Normal>;
    if (!Solver::accepts(touch)) return {.outcome = Outcome::invalid};
    if (law.friction.coefficient == 0.0) return frictionless_contact<Normal>(law, touch);
    if constexpr (has_series<Normal>) {
        if (TurningSeries<Normal>::applies(law.friction)) {
            const TurningContact end = TurningSeries<Normal>(law, touch).integrate([](const auto&) {});
            if (end.outcome == Outcome::ok) return end;
        }
    }
    return Solver(law, touch).integrate([](const auto&) {});
}

// The states at `count` times [s] after touch, in ascending order, during the contact. Returns how many there are.
template <class Normal>
long sample_turning_contact(const WithFriction<Normal>& law, const TurningApproach& touch,
                            const double* times, long count, TurningState* states) {
    using Solver = TurningSolver<Normal>;
    long done = 0;
    if (!Solver::accepts(touch)) return done;
    const auto take = [&](auto& run) {
        while (done < count && times[done] <= run.end_time()) {
            states[done] = run.at(times[done]);
            ++done;
        }
    };
    if constexpr (has_series<Normal>) {
        if (TurningSeries<Normal>::applies(law.friction) && law.friction.coefficient > 0.0) {
            if (TurningSeries<Normal>(law, touch).integrate(take).outcome == Outcome::ok) return done;
        }
    }
    Solver(law, touch).integrate(take);
    return done;
}

}  // namespace hardlimit::boxes
