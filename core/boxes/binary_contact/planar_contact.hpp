// The isolated contact of two spheres in the plane of their approach, for any law (P. Müller and T. Pöschel, Phys. Rev.
// E 87, 033301 (2013)). r is the distance of the centres, l that at touch, ξ = l − r the compression, h = l v_t:
//   ξ̈ = −F(ξ, ξ̇)/m_eff − h²/r³ + g,   θ̇ = h/r²,   ξ = 0, ξ̇ = v_n at touch,
// until F = 0. θ is the angle by which the line of centres has turned. At a wall the distance is infinite, the normal
// does not turn, and g presses the body against the wall. Between two bodies common gravity drops out.
//
// Units: length L, speed V, time L/V, so that a contact 1e-8 l deep keeps its digits. With ξ = L X, c = v_t² L/(l V²),
// λ = L/l, f = F L/(m_eff V²) and w = 1 − λX:
//   dU/dT = −f − c/w³ + gL/V²,   turn = (v_t/V) λ (T + λ J),   dJ/dT = X (2 − λX)/w².
// L is the depth of an elastic impact at v_n, divided by 1 + c, because c alone would reverse the motion at 1/(2c). So
// a grazing contact, which ends before any force acts, is as well scaled as a head-on one.
//
// Smooth variables: a force like ξ^{3/2} has a singular derivative at touch. With X = σ^p, p = Law::onset_power, and
// dT = σ^{p−1} dτ the equations are smooth: dσ/dτ = U/p. An elastic contact ends at a simple zero of σ, through which
// the solution is smooth.
//
// Virial: ∫ r⊗F dt = ∫ F r n⊗n dt, n the line of centres, lies in the plane. By d/dt (m r⊗v) = m v⊗v + r⊗F its trace is
// m ([r ṙ] − ∫ ξ̇² dt − h θ_end). Two components are integrated, along the normal n0 and the tangent t0 at touch, with
// n = cosθ n0 + sinθ t0:
//   nt: ∫ F r sinθ cosθ dt,   tt: ∫ F r sin²θ dt.
// Nothing depends on them, so that they are not under error control.
//
// The contact ends when the law's force ends (law.hpp). While bodies separate without a force, r̈ = h²/r³ >= 0 and the
// slack does not decrease, so that the contact does not begin again. Between two bodies ξ̈ < 0 throughout, and the
// contact always ends. At a wall gravity may hold a contact closed. Once the compression rises again, the contact never
// ends: the trajectory in the phase plane (ξ, ξ̇) stays inside the loop it has drawn, which the curve of zero force,
// starting at the origin, does not enter.
#pragma once
#include "../../base/dormand_prince.hpp"
#include "../../base/outcome.hpp"
#include "../../base/roots.hpp"
#include "../../contact/law.hpp"

namespace hardlimit::boxes {

// Two bodies at the instant of touch.
struct Approach {
    double effective_mass;          // [kg]
    double distance;                // of the centres [m]; infinite at a wall
    double normal_speed;            // at which they approach [m/s], > 0
    double tangential_speed = 0.0;  // [m/s], >= 0
    double gravity = 0.0;           // presses the body against the wall [m/s²]
};

// Slowest approach whose energy does not underflow [m/s].
inline constexpr double slowest_approach = 1e-100;

// The end of a contact. If it does not end (`outcome`), the numbers are NaN, except `greatest` if the body rests.
struct PlanarContact {
    Outcome outcome;
    double duration;                 // from touch to zero force [s]; infinite if the contact never ends
    double turn;                     // of the line of centres [rad]
    double compression;              // residual, when the force ends [m]
    double radial_speed;             // at which the bodies separate along the line of centres [m/s]
    double tangential_speed;         // perpendicular to it [m/s]
    double speed_loss;               // normal_speed − radial_speed [m/s], without cancellation
    double rate_square = math::nan;  // ∫ (dξ/dt)² dt [m²/s], for the virial
    double greatest = math::nan;     // compression [m]
    // ∫ F r (sinθ cosθ, sin²θ) dt per effective mass [m²/s]: components nt and tt of the virial; NaN unless asked for.
    double virial_nt = math::nan, virial_tt = math::nan;
};

// State during a contact, or after it.
struct PlanarState {
    double time;         // since touch [s]
    double compression;  // l − r [m]; negative once the bodies are apart
    double rate;         // of compression [m/s]
    double turn;         // [rad]
};

// Tangential speed at a compression, from the conservation of angular momentum.
HL_FN double tangential_speed(const Approach& a, double compression) {
    return a.distance == math::infinity ? a.tangential_speed
                                        : a.tangential_speed * (a.distance / (a.distance - compression));
}

// The equations of motion in the units above. `virial`: includes the components nt and tt of the virial.
template <class Law, bool virial = false>
struct PlanarMotion {
    static constexpr int p = Law::onset_power;
    // Components of the state: σ, U, T, ∫(f − f_elastic) dX, J, ∫U² dT, ∫ f w (sinθ cosθ, sin²θ) dT.
    enum : int {
        root_depth,
        rate,
        time,
        loss,
        turn,
        square,
        needed,  // components up to here are under error control
        virial_nt = needed,
        virial_tt,
        dimension = virial ? needed + 2 : needed
    };

    const Law* law;
    Approach approach;
    double root, length, speed;                // L^{1/p}, L, V
    double force_unit, ratio, swing, gravity;  // L/(m V²), λ, c, gL/V²

    PlanarMotion(const Law& of, const Approach& a) : law(&of), approach(a) {
        const double energy = 0.5 * a.effective_mass * a.normal_speed * a.normal_speed;
        const auto stored = [&](double s) { return of.energy(s); };
        const double elastic = power(roots::solve_power(stored, energy));
        const double slope = a.tangential_speed / a.normal_speed;
        length = elastic / (1.0 + slope * slope * (elastic / a.distance));
        speed = a.normal_speed;
        if (a.gravity * length > faint_pull * speed * speed) rescale_under_gravity(of);
        set_units();
    }
    // In units of this length and of the normal speed of `a`.
    PlanarMotion(const Law& of, const Approach& a, double unit)
        : law(&of), approach(a), length(unit), speed(a.normal_speed) {
        set_units();
    }

    static constexpr double faint_pull = 1e-30;  // in units of V²/L; weaker gravity is neglected
    static double power(double s) { return math::power<p>(s); }

    void operator()(const double* y, double* dy) const {
        const double s = root * y[root_depth], closing = speed * y[rate];
        const double x = power(y[root_depth]), clock = math::power<p - 1>(y[root_depth]);
        const double force = force_unit * law->force(s, closing);
        const double damping = force - force_unit * law->force(s, 0.0);  // exactly zero without damping
        const double inverse = 1.0 / (1.0 - ratio * x), inverse2 = inverse * inverse;
        dy[root_depth] = y[rate] * (1.0 / p);
        dy[rate] = -clock * ((force + swing * (inverse2 * inverse)) - gravity);
        dy[time] = clock;
        dy[loss] = clock * damping * y[rate];
        dy[turn] = clock * (x * (2.0 - ratio * x) * inverse2);
        dy[square] = clock * (y[rate] * y[rate]);
        if constexpr (virial) {
            const auto angle = math::sincos(turned(y));
            const double pressing = clock * force * (1.0 - ratio * x) * angle.sin;
            dy[virial_nt] = pressing * angle.cos;
            dy[virial_tt] = pressing * angle.sin;
        }
    }

    // Event function that falls to zero where the force ends, and its derivative in τ. The zero is simple even for a
    // contact that ends at ξ = 0.
    struct Surface {
        double value, slope;
    };
    Surface end_surface(const double* y, const double* dy) const {
        const double closing = speed * y[rate];
        const Slack slack = law->slack(closing);
        if (!(slack.depth > 0.0)) return {y[root_depth], dy[root_depth]};
        const double least = onset_root<p>(slack.depth) / root;
        const double exponent = slack.slope * closing / slack.depth;  // d ln depth/d ln rate
        return {y[root_depth] - least, dy[root_depth] - least * exponent * dy[rate] / (p * y[rate])};
    }

    PlanarState state(const double* y) const {
        const double x = power(y[root_depth]);
        return {y[time] * (length / speed), length * x, speed * y[rate], turned(y)};
    }
    double turned(const double* y) const {  // θ
        const double angle = y[time] + ratio * y[turn];
        return approach.distance == math::infinity ? 0.0 : approach.tangential_speed / speed * ratio * angle;
    }

    // The result, from the state at the end. The speed of separation follows from the energy balance, so that an
    // undamped contact returns all energy to the last bit.
    PlanarContact finish(const double* y) const {
        const PlanarState at = state(y);
        const double left = math::max(law->slack(at.rate).depth, 0.0), x = left / length;
        const double start = approach.normal_speed / speed, w = 1.0 - ratio * x;
        const double stored = force_unit / length * law->energy(onset_root<p>(left));
        const double lost =
            2.0 * (y[loss] + stored) + x * (swing * (2.0 - ratio * x) / (w * w) - 2.0 * gravity);
        const double across = boxes::tangential_speed(approach, left),
                     slowed = approach.normal_speed + at.rate;
        const double rate_square = speed * length * y[square];
        PlanarContact end{.outcome = Outcome::ok,
                          .duration = at.time,
                          .turn = at.turn,
                          .compression = left,
                          .radial_speed = -at.rate,
                          .tangential_speed = across,
                          .speed_loss = slowed,
                          .rate_square = rate_square};
        if (lost < 0.75 * start * start) {
            end.radial_speed = speed * math::sqrt(start * start - lost);
            end.speed_loss = speed * lost / (start + end.radial_speed / speed);
        }
        if constexpr (virial) {
            const bool wall = approach.distance == math::infinity;
            end.virial_nt = wall ? 0.0 : speed * approach.distance * y[virial_nt];
            end.virial_tt = wall ? 0.0 : speed * approach.distance * y[virial_tt];
        }
        return end;
    }

private:
    void set_units() {
        root = onset_root<p>(length);
        const double slowness = approach.tangential_speed / speed;
        force_unit = length / speed / speed / approach.effective_mass;
        ratio = length / approach.distance;
        swing = slowness * slowness * ratio;
        gravity = approach.gravity * length / speed / speed;
    }
    // Under its weight, a slow body gets faster and deeper than its impact speed alone would make it.
    void rescale_under_gravity(const Law& of) {
        const double weight = approach.effective_mass * approach.gravity;
        const auto mean_force = [&](double s) { return of.energy(s) / power(s); };
        length += power(roots::solve_power(mean_force, weight));
        speed = math::max(speed, math::sqrt(approach.gravity * length));
    }
};

// Integrates a contact from touch to its end.
template <class Law, bool virial = false>
class PlanarSolver {
public:
    static constexpr double tolerance = 1e-14;  // relative, of one step
    // In τ. A force of a high power of σ starts so slowly that the error estimate misses it.
    static constexpr double longest_step = 0.2;
    static constexpr double deepest = 0.5;  // compression over distance at which a contact is too deep
    static constexpr long most_steps = 1'000'000;
    static constexpr double strong_pull = 1e17;  // gravity away from the wall at which forces are negligible
    static constexpr double resting_part = 1e-10;  // part of speed and weight below which a body is at rest

    PlanarSolver(const Law& law, const Approach& approach) : motion_(law, approach) {}

    // Whether the input is in range.
    static bool accepts(const Approach& a) {
        const double fastest = math::max(a.normal_speed, a.tangential_speed);
        return a.effective_mass > 0.0 && a.distance > 0.0 && a.normal_speed > 0.0 &&
               a.tangential_speed >= 0.0 && math::is_finite(a.gravity) && math::is_finite(fastest) &&
               math::is_finite(a.effective_mass) && (a.gravity == 0.0 || a.distance == math::infinity);
    }

    const PlanarMotion<Law, virial>& motion() const { return motion_; }

    // Calls visit(*this) after every step; at() then gives the states within that step.
    template <class Visit>
    PlanarContact integrate(Visit&& visit) {
        if (motion_.gravity < -strong_pull) return pulled_off();
        double y[n] = {0.0, motion_.approach.normal_speed / motion_.speed};
        motion_(y, stages_);
        copy(y, begin_);
        for (long i = 0; i < most_steps; ++i) {
            if (!take_step()) {
                if (h_ < 1e-30) break;
                continue;
            }
            if (!(greatest_ > 0.0) && !(end_[M::rate] > 0.0)) greatest_ = compression_at_rest();
            const bool over = ends();
            visit(*this);
            if (over && !(greatest_ > deepest * motion_.approach.distance)) {
                PlanarContact end = motion_.finish(end_);
                end.greatest = greatest_;
                return end;
            }
            const double compression = math::max(motion_.state(end_).compression, greatest_);
            if (compression > deepest * motion_.approach.distance) return without_end(Outcome::too_deep);
            if (motion_.gravity > 0.0 && rests()) {
                PlanarContact end = without_end(Outcome::at_rest);
                end.greatest = greatest_ > 0.0 ? greatest_ : compression;
                return end;
            }
            copy(end_, begin_);
            copy(slope_, stages_);
        }
        return without_end(Outcome::unresolved);
    }

    // Gravity away from the wall reverses the body before any force acts.
    PlanarContact pulled_off() const {
        const Approach& a = motion_.approach;
        const double speed = a.normal_speed, duration = 2.0 * speed / -a.gravity;
        const double square = speed * speed / 3.0 * duration, greatest = 0.25 * speed * duration;
        return {Outcome::ok, duration, 0.0, 0.0, speed, a.tangential_speed, 0.0, square, greatest, 0.0, 0.0};
    }

    static PlanarContact without_end(Outcome outcome) {
        const double never = outcome == Outcome::at_rest ? math::infinity : math::nan;
        constexpr double none = math::nan;
        return {outcome, never, none, none, none, none, none, none, none};
    }

    double end_time() const { return end_[M::time] * time_unit(); }

    // The state at a time [s] within the step just taken, by Newton's method on T(τ), which is increasing.
    PlanarState at(double time) {
        const double wanted = time / time_unit();
        if (wanted == begin_[M::time]) return motion_.state(begin_);
        double low = 0.0, high = length_, x = length_ * (wanted - begin_[M::time]);
        x /= end_[M::time] - begin_[M::time];
        double out[n], slope[n];
        for (int i = 0; i < 80; ++i) {
            DormandPrince::step(motion_, begin_, x, n, stages_, out, M::needed);
            motion_(out, slope);
            const double excess = out[M::time] - wanted;
            (excess > 0.0 ? high : low) = x;
            const double newton = x - excess / slope[M::time];
            const double next = newton >= low && newton <= high ? newton : 0.5 * (low + high);
            if (math::abs(next - x) <= 2.0 * math::epsilon * length_) break;
            x = next;
        }
        PlanarState state = motion_.state(out);
        state.time = time;
        return state;
    }

private:
    using M = PlanarMotion<Law, virial>;
    static constexpr int n = M::dimension;

    M motion_;
    double begin_[n], end_[n], slope_[n];
    double stages_[DormandPrince::stages * n];  // the first is the derivative at begin_
    double h_ = longest_step, length_ = 0.0;
    double greatest_ = 0.0;  // maximum compression, known once the bodies separate [m]

    static void copy(const double* from, double* to) {
        for (int i = 0; i < n; ++i) to[i] = from[i];
    }
    double time_unit() const { return motion_.length / motion_.speed; }

    // Longest step. Near rest under gravity a body moves so slowly that the limit is inversely proportional to its
    // motion.
    double longest() const {
        if (!(motion_.gravity > 0.0)) return longest_step;
        const double motion = math::max(math::abs(end_[M::rate]), math::abs(end_[M::root_depth]));
        return longest_step / math::clamp(10.0 * motion, 1e-100, 1.0);
    }

    bool take_step() {
        DormandPrince::step(motion_, begin_, h_, n, stages_, end_, M::needed);
        double scale[M::needed] = {0.0, 0.0, 0.0,
                                   1.0, 1.0, 1.0};  // errors of the integrals relative to their total
        for (int i = 0; i < M::needed; ++i) {
            scale[i] = tolerance * math::max(scale[i], math::max(math::abs(begin_[i]), math::abs(end_[i])));
        }
        if (motion_.gravity > 0.0) scale[M::rate] = math::max(scale[M::rate], rounding_of_rate());
        const double error = DormandPrince::error(stages_, h_, n, scale, M::needed, M::needed);
        length_ = h_;
        h_ = math::min(h_ * DormandPrince::growth(error), longest());
        if (!(error <= 1.0)) return false;
        motion_(end_, slope_);
        return true;
    }

    // Rounding error of the balanced forces on a body that creeps to rest; it does not count as error of the step.
    double rounding_of_rate() const {
        const double clock = math::power<M::p - 1>(begin_[M::root_depth]);
        return 4.0 * math::epsilon * h_ * clock * motion_.gravity;
    }

    // The greatest compression [m] in the step just taken, where the rate is zero, by Newton's method. Its error is
    // second order in the residual rate.
    double compression_at_rest() {
        double x = length_ * (begin_[M::rate] / (begin_[M::rate] - end_[M::rate]));
        double at[n], slope[n];
        for (int i = 0; i < 8; ++i) {
            DormandPrince::step(motion_, begin_, x, n, stages_, at, M::needed);
            motion_(at, slope);
            const double step = at[M::rate] / slope[M::rate];
            if (!(math::abs(step) > 1e-7 * length_)) break;
            x = math::clamp(x - step, 0.0, length_);
        }
        return motion_.state(at).compression;
    }

    // Whether the contact ends in the step just taken; if so, moves end_ there.
    bool ends() {
        if (!(end_[M::rate] < 0.0)) return motion_.gravity > 0.0 && begin_[M::rate] < 0.0 && dips();
        if (motion_.end_surface(end_, slope_).value > 0.0) return false;
        locate(length_);
        return true;
    }

    void probe(double at) {
        DormandPrince::step(motion_, begin_, at, n, stages_, end_, M::needed);
        motion_(end_, slope_);
        length_ = at;
    }

    // Locates the end in (0, up] by bracketed Newton iteration; the event function is negative at `up`.
    void locate(double up) {
        double low = 0.0, x = length_;
        probe(x);
        for (int i = 0; i < 100; ++i) {
            const auto f = motion_.end_surface(end_, slope_);
            const bool before = end_[M::rate] >= 0.0 || f.value > 0.0;
            (before ? low : up) = x;
            const double newton = x - f.value / f.slope;
            const double next = f.slope < 0.0 && newton > low && newton < up ? newton : 0.5 * (low + up);
            if (math::abs(next - x) <= 2.0 * math::epsilon * x || next == low || next == up) break;
            probe(x = next);
        }
    }

    // Whether the force has ended within a step in which gravity reverses the body. Bisects for the minimum of the end
    // function by the sign of its slope.
    bool dips() {
        const double whole = length_;
        double low = 0.0, up = whole;
        for (int i = 0; i < 50; ++i) {
            probe(0.5 * (low + up));
            const auto f = motion_.end_surface(end_, slope_);
            if (end_[M::rate] < 0.0 && f.value <= 0.0) {
                locate(length_);
                return true;
            }
            (end_[M::rate] < 0.0 && f.slope < 0.0 ? low : up) = length_;
        }
        probe(whole);
        return false;
    }

    // Whether gravity holds the contact closed: the compression rises again, or the motion has died away.
    bool rests() const {
        if (begin_[M::rate] < 0.0 && end_[M::rate] >= 0.0) return true;
        const double clock = math::power<M::p - 1>(end_[M::root_depth]);
        return math::abs(end_[M::rate]) <= resting_part &&
               math::abs(slope_[M::rate]) <= resting_part * motion_.gravity * clock;
    }
};

// Solves the contact from touch to its end. The outcome is `invalid` if PlanarSolver::accepts refuses the input, and
// `too_deep` if the centres come closer than half of their distance at touch. An approach slower than slowest_approach
// is solved at that speed, and the result is scaled in proportion.
template <bool virial = false, class Law>
PlanarContact solve_planar_contact(const Law& law, const Approach& approach) {
    using Solver = PlanarSolver<Law, virial>;
    if (!Solver::accepts(approach)) return Solver::without_end(Outcome::invalid);
    if (approach.normal_speed >= slowest_approach) return Solver(law, approach).integrate([](const auto&) {});
    const double part = approach.normal_speed / slowest_approach;
    Approach faster = approach;
    faster.normal_speed = slowest_approach;
    if (approach.gravity < 0.0) faster.gravity = math::max(approach.gravity / part, -1e100);
    PlanarContact end = Solver(law, faster).integrate([](const auto&) {});
    for (double* x : {&end.compression, &end.radial_speed, &end.speed_loss, &end.greatest, &end.virial_nt,
                      &end.virial_tt})
        *x *= part;
    end.rate_square *= part * part;
    return end;
}

// The state in free flight at a time [s] after the end of a contact: straight, at a wall on a parabola.
HL_FN PlanarState fly_on(const Approach& a, const PlanarContact& end, double time) {
    const double t = time - end.duration;
    if (a.distance == math::infinity) {
        const double rate = -end.radial_speed + a.gravity * t;
        return {time, end.compression + t * (0.5 * a.gravity * t - end.radial_speed), rate, 0.0};
    }
    const double across = t * end.tangential_speed, begun = a.distance - end.compression;
    const double along = begun + t * end.radial_speed, distance = math::sqrt(along * along + across * across);
    const double moved = t * (end.radial_speed * (begun + along) + end.tangential_speed * across);
    const double rate = -(along * end.radial_speed + across * end.tangential_speed) / distance;
    return {time, end.compression - moved / (distance + begun), rate,
            end.turn + math::atan2_upper(across, along)};
}

// The states at `count` times [s] after touch, in ascending order, during the contact and after it. NaN if the input is
// refused, and after the contact is found never to end.
template <class Law>
PlanarContact sample_planar_contact(const Law& law, const Approach& approach, const double* times, long count,
                                    PlanarState* states) {
    long done = 0;
    PlanarContact end = PlanarSolver<Law>::without_end(Outcome::invalid);
    if (PlanarSolver<Law>::accepts(approach)) {
        end = PlanarSolver<Law>(law, approach).integrate([&](auto& run) {
            while (done < count && times[done] <= run.end_time()) {
                states[done] = run.at(times[done]);
                ++done;
            }
        });
    }
    for (; done < count; ++done) {
        states[done] = end.outcome == Outcome::ok ? fly_on(approach, end, times[done])
                                                  : PlanarState{times[done], math::nan, math::nan, math::nan};
    }
    return end;
}

}  // namespace hardlimit::boxes
