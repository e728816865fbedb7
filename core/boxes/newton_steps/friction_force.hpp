// Tangential force of one contact at one step: T of core/contact/friction.hpp and Coulomb's limit (return mapping).
//
// Between two steps the bodies move uniformly. The displacement of the surfaces since the last step is therefore known,
// and T is computed from it like the elastic part of the normal force from the compression. The damping needs the
// velocity g of the surfaces at t_n, which depends on the force at t_n as in contact_force.hpp.
//
// All is of second order in h, also where the surfaces begin to slip or to stick: there the force is continuous, and
// only its slope jumps. With SlipLimit::spring and damping the force jumps there, and the order is the first.
#pragma once
#include "../../contact/friction.hpp"
#include "../common/bodies.hpp"
#include "contact_force.hpp"

namespace hardlimit::boxes::steps {

// Motion of the second surface relative to the first at their contact.
struct Slide {
    Double4 displacement;  // since the last step, or since touch [m]
    Double4 velocity;      // now, without the tangential force of this step [m/s]
    double share;          // by which each newton changes this velocity [s/kg]
};

// A vector in the plane across `from`, turned with the normal without twist about it.
inline Double4 turned(Double4 vector, Double4 from, Double4 to) {
    return vector - (from + to) * (dot(vector, to) / (1.0 + dot(from, to)));
}

// Tangential force of a contact; empty without friction.
template <class Law>
struct ContactFriction {};
template <FrictionalLaw Law>
struct ContactFriction<Law> {
    Double4 elastic{};         // T [N]
    Double4 force{};           // on the second body, −(T + γ_t g) [N]
    double touch_speed = 0.0;  // γ_t touch_speed is the force at touch unless the surfaces slip [m/s]
    bool slips = false;
    bool slid = false;         // at any step
    Double4 first_velocity{};  // of the surfaces at the begin [m/s], turned with the normal

    // ½T²/k_t [J]. With k_t that depends on the compression this is a definition; the dissipated energy is the rest.
    double energy(const Law& law, double compression) const {
        const double stiffness = law.friction.stiffness(math::max(compression, 0.0));
        return stiffness > 0.0 ? 0.5 * dot(elastic, elastic) / stiffness : 0.0;
    }
    double length() const { return math::sqrt(dot(force, force)); }
    void turn(Double4 from, Double4 to) {
        elastic = turned(elastic, from, to), force = turned(force, from, to);
        first_velocity = turned(first_velocity, from, to);
    }
    void reverse() { elastic = -elastic, force = -force, first_velocity = -first_velocity; }
};

// Mean of k_t (a'/a)^m over a uniform change of the compression from ξ to ξ', where a' is the contact radius at the
// end. By Simpson's rule in √ξ, which is exact for all models but the unloading of mindlin_rescale.
inline double mean_stiffness(const FrictionTerms& f, int m, double from, double to) {
    if (f.stiffness.power == 0 && m == 0) return f.stiffness.factor;
    const double first = math::sqrt(from), last = math::sqrt(to), middle = 0.5 * (first + last);
    const auto integrand = [&](double root) {
        const double k = f.stiffness(root * root);
        return m == 0 ? k * root : m == 1 ? k * last : k * last * last / root;
    };
    return (integrand(first) + 4.0 * integrand(middle) + integrand(last)) / (3.0 * (first + last));
}

// T if the surfaces stick since the last step [N].
inline Double4 stuck_force(const FrictionTerms& f, Double4 before, Double4 displacement, double from,
                           double to) {
    const int m = to > from ? f.loading : f.unloading;
    const double ratio = from > 0.0 ? to / from : 1.0;
    const double shrinks = m == 0 ? 1.0 : m == 1 ? math::sqrt(ratio) : ratio;  // (a/a_old)^m
    return displacement * mean_stiffness(f, m, from, to) + before * shrinks;
}

// The tangential force at touch. Where the damping alone exceeds a limit on the total force, T is set against g.
template <FrictionalLaw Law>
ContactFriction<Law> friction_at_touch(const Law& law, Double4 velocity, double rate) {
    const FrictionTerms& f = law.friction;
    const double speed = math::sqrt(dot(velocity, velocity)), damping = f.damping(0.0);
    const double limit = f.coefficient * math::max(law.force(0.0, rate), 0.0);
    ContactFriction<Law> touch;
    touch.touch_speed = speed;
    if (!(f.limit == SlipLimit::total && f.stiffness.factor > 0.0 && damping * speed > limit)) return touch;
    touch.elastic = velocity * (limit / speed - damping), touch.force = -velocity * (limit / speed);
    touch.touch_speed = limit / damping, touch.slips = true;
    return touch;
}

// A force of this magnitude after a step in which surfaces slip. `before` [N]: the force at the step before if they
// slipped there too, else 0; trial [N]: the force now if they stuck since.
//
// While they slip the direction f of the force turns to that of its change h under sticking,
//   df/dt = (h − (h·f) f)/(μ F_n),
// solved here for constant h/(μ F_n). With f along the trial force (radial return) it would be of first order; that is
// done only in the step in which they begin to slip, or if h turns f round, so that they stuck in between.
inline Double4 slipping_force(Double4 before, Double4 trial, double magnitude) {
    const auto length = [](Double4 v) { return math::sqrt(dot(v, v)); };
    const Double4 change = trial - before;
    const double first = length(before), step = length(change), product = dot(before, change);
    const double angle = 0.5 * step * (1.0 / first + 1.0 / magnitude);
    if (!(first > 0.0 && (product > 0.0 || angle < 1.0))) return trial * (magnitude / length(trial));
    if (!(step > 0.0)) return before * (magnitude / first);
    const double along = product / (first * step), decay = math::exp(-angle);
    const double even = 0.5 * (1.0 + decay * decay), odd = 0.5 * (1.0 - decay * decay);
    const Double4 direction = before * (decay / first) + change * (((even - decay) * along + odd) / step);
    return direction * (magnitude / (even + odd * along));
}

// The tangential force now. `before`: that of the last step, turned with the normal; from, to: ξ then and now [m].
template <FrictionalLaw Law>
ContactFriction<Law> friction_force(const Law& law, const ContactFriction<Law>& before, const Slide& slide,
                                    double from, double to, double normal_force) {
    const FrictionTerms& f = law.friction;
    const double limit = normal_force > 0.0 ? f.coefficient * normal_force : 0.0;
    if (!(limit > 0.0)) return {};
    const bool has_spring = f.stiffness.factor > 0.0;
    const bool limits_spring = has_spring && f.limit == SlipLimit::spring;
    const double damping = f.damping(to);
    const auto exceeds = [=](Double4 force) { return dot(force, force) > limit * limit; };
    const Double4 slipped = before.slips ? before.force : Double4{};
    ContactFriction<Law> now;
    now.touch_speed = before.touch_speed;
    if (has_spring) now.elastic = stuck_force(f, before.elastic, slide.displacement, from, to);
    if (limits_spring && exceeds(now.elastic)) {
        now.force = slipping_force(slipped, -now.elastic, limit);
        now.elastic = -now.force, now.slips = true;
        return now;
    }
    now.force = -(now.elastic + slide.velocity * damping) * (1.0 / (1.0 + slide.share * damping));
    if (!limits_spring && exceeds(now.force)) {
        now.force = slipping_force(slipped, now.force, limit), now.slips = true;
        if (has_spring) now.elastic = -now.force - (slide.velocity + now.force * slide.share) * damping;
    }
    return now;
}

// Impulses of a tangential force around touch, in units of its value at the first step in contact [s].
struct FrictionOnset {
    double until_step;  // from touch to that step
    double missed;      // that equal steps miss if that step counts in full
};
template <FrictionalLaw Law>
FrictionOnset friction_onset(const Law& law, const ContactFriction<Law>& first, Onset at, double h) {
    constexpr int p = Law::onset_power;
    const double value = first.length();
    if (!(value > 0.0)) return {0.0, 0.0};
    // Leading terms: of μ F_n if the surfaces slip at the first step, else of γ_t |g|.
    OnsetForce<p> force = onset_force(law, at.rate);
    if (first.slips) {
        force.terms = force.terms * law.friction.coefficient;
    } else {
        const PowerTerm& damping = law.friction.damping;
        const int j = p * damping.power / 4;  // ξ^(power/4) = (ξ^(1/p))^j
        force = {};
        if (j < p) force.terms.c[j] = damping.factor * first.touch_speed;
    }
    return {force.impulse_until_step(at, value) / value, force.missed_impulse(at, h) / value};
}

}  // namespace hardlimit::boxes::steps
