// The isolated contact of two spheres with friction under a linear law and a tangential spring of constant stiffness
// (turning_motion.hpp), by power series in time. The equations are polynomials in the components, 1/r and the direction
// of slip, whose series follow order by order (kernels/power_series.hpp). Between changes of stick and slip one or a
// few steps cover the contact, and every event function is made of polynomials.
//
// Surfaces that slip: f' = ω n×f with μ F_n ω = h_⊥. As this quotient is singular where F_n = 0, steps that are not in
// a plane are bounded by the distance in time to F_n = 0, until that matters no longer: the error of f counts in
// proportion to the force and to the rest of the impulse. An undamped contact that slips at touch starts at such a
// point; there f_n follows from the equation of order n itself. At the end of the contact one step suffices, with the
// mean of f (slip_closing.hpp). At a wall and in a plane f is constant.
#pragma once
#include <optional>

#include "../../base/event_location.hpp"
#include "../common/symmetric_tensor.hpp"
#include "slip_closing.hpp"
#include "turning_states.hpp"

namespace hardlimit::boxes {

// `virial`: also gives the virial.
template <class Normal, bool virial = false>
class TurningSeries : public TurningStates<Normal> {
public:
    static constexpr int order = 16;
    static constexpr double tolerance = 1e-14;                         // of the last terms of one step
    static constexpr double loose = 10.0, direction_tolerance = 10.0;  // beside that
    static constexpr int most_steps = 200;  // a contact that takes more is left to the other methods
    static constexpr int most_changes = 40;

    using TurningStates<Normal>::TurningStates;

    static bool applies(const FrictionTerms& f) {
        return f.stiffness.power == 0 && f.stiffness.factor > 0.0 && f.damping.power == 0 && f.loading == 0 &&
               f.unloading == 0;
    }

    // Calls visit(*this) after every step; at() then gives the states within that step. The outcome is `unresolved` if
    // the contact needs another method.
    template <class Visit>
    TurningContact integrate(Visit&& visit) {
        motion_.start(y_);
        motion_.choose_at_touch(y_);
        result_.slips_first = motion_.slips;
        can_slip_ = motion_.friction().coefficient < math::infinity;
        set_scales();
        for (int i = 0; i < most_steps; ++i) {
            prepare();
            expand();
            if (!(step_ > 1e-14 && step_ < math::infinity) || too_deep()) break;
            const Event event = first_event();
            if (event == Event::changes && closing_) {  // the contact does not end in this step
                closing_.reset();
                closes_ = false;
                continue;
            }
            closes_ = true;
            begin_ = y_[M::time];
            record_greatest();
            add_integrals(step_, y_);
            if (directed()) record_misalignment();
            move(step_, y_);
            visit(*this);
            if (event == Event::ends) return this->finish(y_);
            if (event == Event::changes && !change()) break;
            fresh_ = event == Event::changes;
        }
        return {.outcome = Outcome::unresolved};
    }

    // For one step from a state within the contact of two bodies. `now`: that state, where the frame starts, but with
    // the speed of `units` along the normal; `precision` replaces the tolerance.
    TurningSeries(const WithFriction<Normal>& law, const TurningApproach& now,
                  const PlanarMotion<Normal>& units, const WithinContact& at, double precision)
        : Base(law, now, units), precision_(precision), closes_(false) {
        motion_.start_within(y_, at.compression, at.rate, at.slips, at.memory);
        set_scales();
        prepare();
        steady_ = steady_ || at.frozen;
        expand();
    }
    enum class Event : unsigned char { none, changes, ends };
    // Length of this step [s], at most `most`, and the event at its end. `fresh`: stick or slip has just begun;
    // `changes`: whether they may change.
    struct Bound {
        double length;
        Event event;
    };
    Bound bound(double most, bool fresh, bool changes) {
        step_ = math::min(step_, most / motion_.time_unit());
        fresh_ = fresh, can_slip_ = changes;
        const Event event = first_event();
        return {step_ * motion_.time_unit(), event};
    }
    // The state after a time [s] within the step. `shift`: of the relative position since its start.
    struct Within {
        Vector3 shift, velocity, spin;
        Vector3 memory;  // as in WithinContact
    };
    Within after(double time) {
        double y[M::dimension] = {};
        const Tangential kept = motion_.reference;
        move(time / motion_.time_unit(), y);
        const Tangential memory =
            motion_.slips ? motion_.reference
                          : (1.0 / motion_.units().force_unit) * Tangential{y[M::memory], y[M::memory + 1]};
        motion_.reference = kept;
        Vector3 shift = this->shift_of(y);
        const double compression = motion_.units().length * y_[M::root_depth];
        for (std::size_t k = 0; k < 3; ++k) shift[k] += compression * motion_.touch().normal[k];
        return {shift, this->velocity_of(y), this->spin_of(y),
                motion_.in_space(y, memory.first, memory.second, 0.0)};
    }
    // Energies [J] that damping and the tangential force take until that time, and the virial.
    struct Taken {
        double damping, rubbed;
        SymmetricTensor tensor;
    };
    Taken until(double time) {
        const auto& units = motion_.units();
        const double energy = motion_.touch().effective_mass * units.speed * units.speed;
        double y[M::dimension] = {};
        virial_ = {};
        add_integrals(time / motion_.time_unit(), y);
        return {energy * y[M::loss], energy * y[M::work], virial_};
    }

    // Largest compression [m], and the symmetric part of ∫ r⊗F dt between two bodies [J s].
    double greatest() const { return motion_.units().length * greatest_; }
    const SymmetricTensor& virial_tensor() const { return virial_; }

    double end_time() const { return y_[M::time] * motion_.time_unit(); }

    // The state at a time [s] within the step just taken.
    TurningState at(double time) {
        double y[M::dimension] = {};
        const Tangential kept = motion_.reference;
        move(math::clamp(time / motion_.time_unit() - begin_, 0.0, step_), y);
        if (closing_) move_in_closing(y[M::time] - begin_, y);
        TurningState state = this->state_of(y);
        state.time = time;
        motion_.reference = kept;
        return state;
    }

private:
    using Base = TurningStates<Normal>;
    using Two = Vector<2>::Real;
    using Base::motion_, Base::result_;
    using typename Base::M;
    enum class Kind : unsigned char { wall, plane, space };
    static constexpr int length = order + 1;

    double y_[M::dimension];
    double precision_ = tolerance;  // of the last terms of one step
    double begin_ = 0.0, step_ = 0.0, greatest_ = 0.0;
    SymmetricTensor virial_;
    bool fresh_ = false;  // stick or slip has just begun
    bool can_slip_ = true;
    double misaligned_ = 1.0;  // sine of the angle by which the direction of slip may still change
    bool steady_ = false, frozen_ = false;  // the direction of slip keeps still; nothing changes any more
    std::optional<SlipClosing> closing_;    // the mean of the direction replaces it until the contact ends
    bool closes_ = true;                    // whether that is tried
    Kind kind_ = Kind::space;
    double direction_scale_ = 1.0, slide_ = 0.0, twist_scale_ = 0.0;
    // Series of the components and of what the events need. P, Q: (q1, q2) and (q0, q3) of the frame's quaternion, at a
    // wall P is the path.
    double X_[length], U_[length], twist_[length], N_[length], curve_[length], turning_[length];
    Two w_[length], u_[length], S_[length], f_[length], P_[length], Q_[length];
    Two a_[length], g_[length], push_[length], h_[length], ft_[length], at_[length];

    static double dot(Two a, Two b) {
        const Two p = a * b;
        return p[0] + p[1];
    }
    static double sum(Two a) { return a[0] + a[1]; }
    static Two turned(Two a) { return Two{-a[1], a[0]}; }
    static Two two(Tangential t) { return Two{t.first, t.second}; }
    static double length_of(Two a) { return math::sqrt(dot(a, a)); }

    // --- one step -------------------------------------------------------------------------------------------------

    void set_scales() {
        const auto now = motion_.now(y_);
        const double fast = math::abs(y_[M::twist]) + now.w.length() + now.u.length();
        slide_ = math::max(precision_ * math::max(1.0, now.g.length()), math::epsilon * fast);
        twist_scale_ = math::max(slide_, precision_ * math::abs(y_[M::twist]));
    }

    // The terms of order zero.
    void prepare() {
        const double *y = y_, *q = y + M::turn;
        X_[0] = y[M::root_depth], U_[0] = y[M::rate], twist_[0] = y[M::twist];
        w_[0] = Two{y[M::across], y[M::across + 1]};
        u_[0] = Two{y[M::surface], y[M::surface + 1]};
        P_[0] = Two{q[1], q[2]}, Q_[0] = Two{q[0], q[3]};
        const auto now = motion_.now(y);
        g_[0] = two(now.g);
        kind_ = motion_.is_wall() ? Kind::wall : motion_.is_planar(y) ? Kind::plane : Kind::space;
        if (motion_.slips) {
            f_[0] = two(motion_.reference);
            const double force = math::clamp(motion_.limit(now), 1e-5, 1.0);
            direction_scale_ = direction_tolerance * slide_ / (force * (U_[0] < 0.0 ? force : 1.0));
            const double rest = U_[0] < 0.0 ? rest_of_impulse(now) : math::infinity;
            frozen_ = rest < slide_;
            steady_ = frozen_ || rest * misaligned_ < slide_;
            direction_scale_ = math::min(direction_scale_, 1e-8);
            if (kind_ == Kind::space && U_[0] < 0.0 && !steady_ && closes_) close(now);
            if (closing_) steady_ = frozen_ = true, f_[0] = in_frame(closing_->mean());
        } else
            S_[0] = Two{y[M::memory], y[M::memory + 1]};
    }

    // What μ F_n, which falls to zero, still gives.
    double rest_of_impulse(const typename M::Now& now) const {
        const auto k = motion_.constants();
        const double growth = k.elastic * U_[0] - k.damping * now.normal, force = math::max(now.normal, 0.0);
        return motion_.friction().coefficient * force * force / math::abs(growth);
    }
    bool directed() const { return motion_.slips && kind_ == Kind::space && !steady_; }

    // Takes the mean of the direction from now on if its error is below the tolerance.
    void close(const typename M::Now& now) {
        const auto k = motion_.constants();
        double dy[M::dimension];
        motion_.slip_rates(y_, dy);
        const double mu = motion_.friction().coefficient, ratio = motion_.units().ratio;
        const double fast = math::abs(y_[M::twist]) + now.w.length() + now.u.length();
        FallingForce force{.stiffness = k.stiffness,
                           .dashpot = dashpot(true),
                           .mobility = 1.0 + motion_.touch().rotational_ratio,
                           .limit = mu * now.normal,
                           .fall = -mu * (k.elastic * dy[M::root_depth] + k.damping * dy[M::rate]),
                           .bend = 0.0,
                           .turning = ratio * fast,
                           .others = 0.0};
        if (!(force.fall > 0.0)) return;
        force.bend = k.damping * force.fall - k.elastic * force.limit;
        const auto rates = [&](int i) { return Two{dy[i], dy[i + 1]}; };
        const Two curve = rates(M::across) - now.width * rates(M::surface) +
                          (ratio * y_[M::rate]) * two(now.u) + (force.mobility * force.limit) * f_[0];
        const auto along = [this](Two a) { return SlipVector{dot(a, f_[0]), dot(a, turned(f_[0]))}; };
        const SlipClosing closing(force, along(two(now.g)), along(curve));
        if (closing.is_within(direction_tolerance * slide_, force)) closing_ = closing;
    }
    Two in_frame(SlipVector a) const {
        const Two f = two(motion_.reference);
        return a.along * f + a.across * turned(f);
    }
    // The state at a time within the last step.
    void move_in_closing(double t, double* y) {
        const auto part = closing_->until(math::clamp(value(N_, t) / N_[0], 1e-12, 1.0));
        const double whole = step_;
        f_[0] = in_frame(part.mean);
        expand();
        move(t, y);
        f_[0] = in_frame(closing_->mean());
        expand();
        step_ = whole;
        const Two f = in_frame(part.now);
        motion_.reference = {f[0], f[1]};
    }

    void expand() {
        const bool slips = motion_.slips;
        switch (kind_) {
            case Kind::wall:
                return slips ? expand_flat<Kind::wall, true>() : expand_flat<Kind::wall, false>();
            case Kind::plane:
                return slips ? expand_flat<Kind::plane, true>() : expand_flat<Kind::plane, false>();
            default:
                if (!slips) return expand_in_space<false, false>();
                return steady_ ? expand_in_space<true, false>() : expand_in_space<true, true>();
        }
    }

    double dashpot(bool slips) const {  // that adds to the spring
        return slips && motion_.limits_spring() ? 0.0 : motion_.constants().dashpot;
    }

    // At a wall and in a plane.
    template <Kind kind, bool slips>
    void expand_flat() {
        const auto k = motion_.constants();
        const double ratio = motion_.units().ratio, c = motion_.touch().rotational_ratio;
        const double damping = dashpot(slips), per_width = 1.0 / (1.0 - ratio * X_[0]);
        curve_[0] = ratio * per_width;
        for (int n = 0; n <= order; ++n) {
            N_[n] = k.elastic * X_[n] + k.damping * U_[n];
            push_[n] = slips ? (motion_.friction().coefficient * N_[n]) * f_[0] : S_[n] + damping * g_[n];
            if (n == order) break;
            const double share = 1.0 / (n + 1);
            X_[n + 1] = share * U_[n];
            twist_[n + 1] = 0.0;
            if constexpr (kind == Kind::wall) {
                U_[n + 1] = -share * N_[n];
                w_[n + 1] = -share * push_[n];
                u_[n + 1] = (share * c) * push_[n];
                P_[n + 1] = share * w_[n];
                Q_[n + 1] = Two{};
                g_[n + 1] = w_[n + 1] - u_[n + 1];
            } else {
                double curved = 0.0, moved = 0.0;
                for (int j = 0; j < n; ++j) curved += curve_[j] * X_[n - j];
                if (n > 0) curve_[n] = ratio * per_width * curved;
                turn_in_plane(n, share, c, ratio);
                for (int j = 0; j <= n + 1; ++j) moved += X_[j] * u_[n + 1 - j][0];
                g_[n + 1] = Two{(w_[n + 1][0] - u_[n + 1][0]) + ratio * moved, 0.0};
            }
            if constexpr (slips)
                h_[n] = k.stiffness * g_[n] + (damping * (n + 1)) * g_[n + 1];
            else
                S_[n + 1] = (share * k.stiffness) * g_[n];
        }
        step_ = longest_step<kind, slips, false>();
    }

    // `directed`: the direction of slip changes. Each sum of products is taken over all terms known by then, in few
    // loops of independent sums, and completed with the newest terms.
    template <bool slips, bool directed>
    void expand_in_space() {
        const auto k = motion_.constants();
        const double ratio = motion_.units().ratio, c = motion_.touch().rotational_ratio;
        const double mu = motion_.friction().coefficient, damping = dashpot(slips);
        N_[0] = k.elastic * X_[0] + k.damping * U_[0];
        const bool from_zero = directed && N_[0] == 0.0;
        const double per_width = 1.0 / (1.0 - ratio * X_[0]), per_force = from_zero ? 0.0 : 1.0 / N_[0];
        curve_[0] = ratio * per_width;
        if (directed) ft_[0] = turned(f_[0]);
        for (int n = 0; n <= order; ++n) {
            if (directed && from_zero && n > 0) f_[n] = ft_[n] = Two{};
            if (n > 0) N_[n] = k.elastic * X_[n] + k.damping * U_[n];
            Two force{}, a{}, moved{}, drive{}, next{};
            double curved = 0.0, known = 0.0;
            for (int j = 0, i = n; j < n; ++j, --i) {
                if constexpr (directed) {
                    force += N_[i] * f_[j];
                    drive += h_[j] * ft_[i];
                    known += N_[i] * turning_[j];
                    next += turning_[j] * ft_[i];
                }
                curved += curve_[j] * X_[i];
                a += curve_[j] * w_[i];
                moved += X_[j + 1] * u_[i];
            }
            if constexpr (directed)
                push_[n] = mu * (force + N_[0] * f_[n]);
            else if constexpr (slips)
                push_[n] = (mu * N_[n]) * f_[0];
            else
                push_[n] = S_[n] + damping * g_[n];
            if (n == order) break;
            if (n > 0) curve_[n] = ratio * per_width * curved;
            a_[n] = a + curve_[n] * w_[0], at_[n] = turned(a_[n]);
            turn_in_space(n, c, ratio);
            moved += X_[0] * u_[n + 1] + X_[n + 1] * u_[0];
            g_[n + 1] = (w_[n + 1] - u_[n + 1]) + ratio * moved;
            if constexpr (!slips) S_[n + 1] = (k.stiffness / (n + 1)) * g_[n];
            if constexpr (slips) h_[n] = k.stiffness * g_[n] + (damping * (n + 1)) * g_[n + 1];
            if constexpr (directed) {
                if (from_zero) {
                    direct_from_zero(n, mu);
                    continue;
                }
                turning_[n] = (sum(drive + h_[n] * ft_[0]) / mu - known) * per_force;
                f_[n + 1] = (1.0 / (n + 1)) * (next + turning_[n] * ft_[0]);
                ft_[n + 1] = turned(f_[n + 1]);
            }
        }
        step_ = longest_step<Kind::space, slips, directed>();
    }

    void turn_in_plane(int n, double share, double c, double ratio) {
        double a = 0.0, closing = 0.0, whirl = 0.0, lever = 0.0;
        for (int j = 0; j <= n; ++j) a += curve_[j] * w_[n - j][0];
        a_[n] = Two{a, 0.0};
        Two turn{};
        for (int j = 0; j <= n; ++j) {
            const double b = a_[j][0];
            closing += b * U_[n - j];
            whirl += b * w_[n - j][0];
            lever += X_[j] * push_[n - j][0];
            turn += b * P_[n - j][1] * Two{-1.0, 0.0} + b * Q_[n - j][0] * Two{0.0, 1.0};
        }
        U_[n + 1] = -share * (N_[n] + whirl);
        w_[n + 1] = Two{share * (closing - push_[n][0]), 0.0};
        u_[n + 1] = Two{share * c * (push_[n][0] - ratio * lever), 0.0};
        twist_[n + 1] = 0.0;
        Q_[n + 1] = Two{0.5 * share * turn[0], 0.0};
        P_[n + 1] = Two{0.0, 0.5 * share * turn[1]};
    }

    // The terms of order n + 1 of all but the forces.
    void turn_in_space(int n, double c, double ratio) {
        const double share = 1.0 / (n + 1);
        Two closing{}, twisted{}, whirl{}, lever{}, spun{}, tilt{}, along{}, across{};
        for (int j = 0, i = n; j <= n; ++j, --i) {
            closing += U_[i] * a_[j];
            twisted += twist_[i] * at_[j];
            whirl += a_[j] * w_[i];
            lever += X_[i] * push_[j];
            spun += u_[i] * at_[j];
            tilt += Q_[i][0] * at_[j] - Q_[i][1] * a_[j];
            along += P_[i] * a_[j];
            across += P_[i] * at_[j];
        }
        X_[n + 1] = share * U_[n];
        U_[n + 1] = -share * (N_[n] + sum(whirl));
        w_[n + 1] = share * (closing - push_[n]);
        u_[n + 1] = share * (c * (push_[n] - ratio * lever) + twisted);
        twist_[n + 1] = -share * sum(spun);
        P_[n + 1] = (0.5 * share) * tilt;
        Q_[n + 1] = (0.5 * share) * Two{-sum(across), sum(along)};
    }

    // f_n where F_n = 0 at the start: ω_{n-1} from the terms of order n.
    void direct_from_zero(int n, double mu) {
        if (n == 0) return;
        Two part{}, drive{};
        for (int j = 0; j <= n - 2; ++j) part += turning_[j] * ft_[n - 1 - j];
        part = (1.0 / n) * part;
        for (int j = 1; j <= n; ++j) drive += h_[j] * ft_[n - j];
        drive += h_[0] * turned(part);
        double known = 0.0;
        for (int j = 2; j <= n; ++j) known += N_[j] * turning_[n - j];
        turning_[n - 1] = (sum(drive) - mu * known) / (mu * N_[1] + dot(h_[0], f_[0]) / n);
        f_[n] = part + (turning_[n - 1] / n) * ft_[0];
        ft_[n] = turned(f_[n]);
    }

    // The step after which the next two terms would be below the tolerance. These are judged from the last four.
    template <Kind kind, bool slips, bool directed>
    double longest_step() const {
        const double slide = directed ? loose * slide_ : slide_;
        const double per_slide = 1.0 / slide, per_depth = 1.0 / precision_;
        const int last = order - (directed && N_[0] == 0.0);
        double most[2];
        for (int i = 0; i < 2; ++i) {
            Two scaled{1e-300, 1e-300};
            const auto include = [&](Two x, double per_scale) {
                x *= per_scale;
                scaled = math::max<Two>(scaled, math::max<Two>(x, -x));
            };
            for (int n = last - 3 + 2 * i; n <= last - 2 + 2 * i; ++n) {
                include(Two{X_[n], U_[n]}, per_depth);
                include(w_[n], per_slide);
                include(u_[n], per_slide);
                include(P_[n], per_slide);
                if constexpr (kind == Kind::space) include(Two{twist_[n], 0.0}, 1.0 / twist_scale_);
                if constexpr (!slips) include(S_[n], per_slide);
                if constexpr (directed) include(f_[n], 1.0 / direction_scale_);
            }
            most[i] = math::max(scaled[0], scaled[1]);
        }
        const double next = most[1] * math::min(most[1] / most[0], 1e3);
        // No longer than after the end the bodies separate.
        return math::min(math::exp(-math::log(next) / (last + 1)), 1.5);
    }

    bool too_deep() const {
        const double deepest = PlanarSolver<Normal>::deepest, ratio = motion_.units().ratio;
        if (ratio * X_[0] > 0.25 * deepest) return true;
        for (int i = 1; i <= 2; ++i)
            if (ratio * value(X_, 0.5 * i * step_) > deepest) return true;
        return false;
    }

    // --- values ---------------------------------------------------------------------------------------------------

    template <class T>
    static T value(const T* terms, double t) {
        T x = terms[order];
        for (int k = order - 1; k >= 0; --k) x = x * t + terms[k];
        return x;
    }
    template <class T>
    struct Slope {
        T value, slope;
    };
    // Terms from `first` on, as a series of its own.
    template <class T>
    static Slope<T> slope(const T* terms, double t, int first = 0, int last = order) {
        Slope<T> x{terms[last], T{}};
        for (int k = last - 1; k >= first; --k) {
            x.slope = x.slope * t + x.value;
            x.value = x.value * t + terms[k];
        }
        return x;
    }

    // All components but the integrals.
    void move(double t, double* y) {
        y[M::root_depth] = value(X_, t), y[M::rate] = value(U_, t);
        const Two w = value(w_, t), u = value(u_, t), P = value(P_, t);
        y[M::across] = w[0], y[M::across + 1] = w[1];
        y[M::surface] = u[0], y[M::surface + 1] = u[1];
        y[M::twist] = kind_ == Kind::space ? value(twist_, t) : twist_[0];
        const Two Q = kind_ == Kind::wall ? Q_[0] : value(Q_, t);
        y[M::turn] = Q[0], y[M::turn + 1] = P[0], y[M::turn + 2] = P[1], y[M::turn + 3] = Q[1];
        y[M::time] = begin_ + t;
        y[M::memory] = y[M::memory + 1] = 0.0;
        if (!motion_.slips) {
            const Two S = value(S_, t);
            y[M::memory] = S[0], y[M::memory + 1] = S[1];
        } else if (directed()) {
            const Two f = value(f_, t);
            const double per_length = 1.0 / length_of(f);
            motion_.reference = {per_length * f[0], per_length * f[1]};
        }
    }

    // Adds the integrals of products of two series over a step, by Gauss-Legendre quadrature.
    void add_integrals(double step, double* y) {
        const auto k = motion_.constants();
        const bool dissipates = k.damping > 0.0, damped = !motion_.slips && k.dashpot > 0.0;
        const double lever = 1.0 + motion_.touch().rotational_ratio, spring = math::sqrt(k.stiffness * lever);
        const double turned = 2.0 * step * (math::max(1.0, spring) + lever * k.dashpot + k.damping);
        const bool brief = turned < 0.3;
        const int panels = 1 + int(0.5 * turned), nodes = brief ? 4 : 8;
        const double *node = brief ? four_nodes : eight_nodes, *weight = brief ? four_weights : eight_weights;
        const double width = step / panels;
        Two work{}, damping{};
        double loss = 0.0;
        for (int panel = 0; panel < panels; ++panel) {
            for (int i = 0; i < nodes; ++i) {
                const double at = (panel + node[i]) * width;
                const Two g = value(g_, at), push = value(push_, at);
                work += weight[i] * (push * g);
                if constexpr (virial) add_virial(at, width * weight[i], push);
                if (damped) damping += weight[i] * (g * g);
                if (!dissipates) continue;
                const double rate = value(U_, at);
                loss += weight[i] * (rate * rate);
            }
        }
        y[M::work] += width * sum(work);
        y[M::loss] += width * (k.damping * loss);
        y[M::damped] += width * (k.dashpot * sum(damping));
    }
    void add_virial(double t, double weight, Two push) {
        if (kind_ == Kind::wall) return;
        double y[M::dimension] = {};
        const Two P = value(P_, t), Q = value(Q_, t);
        y[M::turn] = Q[0], y[M::turn + 1] = P[0], y[M::turn + 2] = P[1], y[M::turn + 3] = Q[1];
        const auto& units = motion_.units();
        const double distance = motion_.touch().distance * (1.0 - units.ratio * value(X_, t));
        const double unit = weight * motion_.time_unit() / units.force_unit;
        const Vector3 force = motion_.in_space(y, -push[0], -push[1], value(N_, t));
        virial_.add_product(unit * distance, motion_.in_space(y, 0.0, 0.0, 1.0), force);
    }
    void record_misalignment() {
        const Two f = value(f_, step_), h = slope(h_, step_, 0, order - 1).value;
        misaligned_ = math::abs(dot(h, turned(f))) / math::max(length_of(h), 1e-300);
    }
    void record_greatest() {
        greatest_ = math::max(greatest_, value(X_, step_));
        if (!(U_[0] > 0.0 && value(U_, step_) < 0.0)) return;
        const double rest = zero(step_, [&](double t) {
            const auto u = slope(U_, t);
            return simple(u.value, u.slope);
        });
        greatest_ = math::max(greatest_, value(X_, rest));
    }
    static constexpr double four_nodes[4] = {0.06943184420297371, 0.33000947820757187, 0.6699905217924281,
                                             0.9305681557970263};
    static constexpr double four_weights[4] = {0.17392742256872692, 0.32607257743127307, 0.32607257743127307,
                                               0.17392742256872692};
    static constexpr double eight_nodes[8] = {0.01985507175123188, 0.10166676129318663, 0.2372337950418355,
                                              0.4082826787521751,  0.5917173212478249,  0.7627662049581645,
                                              0.8983332387068134,  0.9801449282487681};
    static constexpr double eight_weights[8] = {0.05061426814518813, 0.11119051722668724, 0.15685332293894363,
                                                0.18134189168918100, 0.18134189168918100, 0.15685332293894363,
                                                0.11119051722668724, 0.05061426814518813};

    // --- events ---------------------------------------------------------------------------------------------------

    static EventFunction simple(double value, double slope) { return {value, slope, value, slope}; }

    EventFunction pressing(double t) const {
        const auto f = slope(N_, t);
        return simple(f.value, f.slope);
    }
    // Positive until the surfaces begin to slip, or to stick. Divided by t if both forces are zero at the start; in the
    // first step, where they may be small, dips are sought of the function over μ F_n.
    EventFunction holding(double t) const {
        const double mu = motion_.friction().coefficient;
        if (!motion_.slips) {
            const int first = N_[0] == 0.0 ? 1 : 0;
            const auto force = slope(N_, t, first);
            const auto limited = slope(motion_.limits_spring() ? S_ : push_, t, first);
            const double size = length_of(limited.value);
            const double growth =
                size > 0.0 ? dot(limited.value, limited.slope) / size : length_of(limited.slope);
            const EventFunction grip = simple(mu * force.value - size, mu * force.slope - growth);
            if (X_[0] != 0.0 || !(force.value > 0.0)) return grip;
            const double part = size / (mu * force.value);
            return {grip.value, grip.slope, 1.0 - part,
                    (part * mu * force.slope - growth) / (mu * force.value)};
        }
        const auto drive = slope(h_, t, 0, order - 1);
        Slope<Two> f{f_[0], Two{}};
        if (directed()) f = slope(f_, t);
        double force[3] = {N_[order], 0.0, 0.0};
        for (int k = order - 1; k >= 0; --k) {
            force[2] = force[2] * t + force[1];
            force[1] = force[1] * t + force[0];
            force[0] = force[0] * t + N_[k];
        }
        return simple(dot(drive.value, f.value) - mu * force[1],
                      dot(drive.slope, f.value) + dot(drive.value, f.slope) - 2.0 * mu * force[2]);
    }

    template <class Function>
    static double zero(double high, const Function& function) {
        double x = high;
        return locate_zero(
            x, high, [&] { return function(x); },
            [](EventFunction, double at, double next) {
                return math::abs(next - at) <= 2.0 * math::epsilon * at;
            },
            [&](double, double next) { x = next; });
    }

    // Shortens the step to the first event.
    Event first_event() {
        Event event = Event::none;
        if (value(U_, step_) < 0.0 && !(value(N_, step_) > 0.0)) {
            step_ =
                zero(step_, [&](double t) { return value(U_, t) < 0.0 ? pressing(t) : simple(1.0, 0.0); });
            event = Event::ends;
        }
        if (!can_slip_ || (motion_.slips && frozen_ && !closing_)) return event;
        // At the end of the force that limits T, T may be zero too: look just before.
        const double last = event == Event::ends && !motion_.slips ? step_ * (1.0 - 1e-6) : step_;
        EventFunction before = holding(0.0);
        const int pieces = reverses(last) ? 12 : step_ > 0.3 ? 4 : 1;
        double low = 0.0;
        for (int i = 1; i <= pieces; ++i) {
            const double high = last * (double(i) / pieces);
            const EventFunction after = holding(high);
            const bool rounding = fresh_ && i == 1 && !(before.value > 0.0) && after.value > 0.0;
            double reached = high - low;
            const auto at = [&](double x) { return holding(low + x); };
            if (!rounding && falls_to_zero(before, after, fresh_ && i == 1, reached, at)) {
                const double whole = step_, change = low + zero(reached, at);
                if (event == Event::ends && motion_.slips && !(change < whole * (1.0 - 1e-13))) return event;
                step_ = change;
                return Event::changes;
            }
            before = after, low = high;
        }
        return event;
    }
    // Whether the force that may reach the limit turns back until then. Its length has a kink where it vanishes, after
    // it may have been beyond the limit.
    bool reverses(double until) const {
        if (motion_.slips) return false;
        const Two* limited = motion_.limits_spring() ? S_ : push_;
        return dot(limited[0], value(limited, until)) < 0.0;
    }

    bool change() {
        if (result_.changes < most_intervals) result_.change[result_.changes] = end_time();
        if (++result_.changes > most_changes) return false;
        if (motion_.slips) {
            motion_.begin_stick(y_);
            return !motion_.follows;
        }
        motion_.begin_slip(y_, motion_.limited(y_, motion_.now(y_)));
        misaligned_ = 1.0;
        return true;
    }
};

}  // namespace hardlimit::boxes
