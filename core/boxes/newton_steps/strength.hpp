// One contact at one step: its force, and what it dissipates between two steps.
//
// The rate v_n at which a contact is compressed at t_n is known from the velocities half a step before only
// together with its force: v_n = u − F h/(2m), u being the rate without this force. One step of Newton's method
// from F = 0 finds F exactly where F(s, v) is linear in v, to second order elsewhere. That is the implicit midpoint
// rule of the damping: a decay by e^{−z} in a step becomes one by (1 − z/2)/(1 + z/2), which is stable for any z.
//
// Between two steps velocities change by −h (F + F')/(2m), so that the kinetic energy loses exactly
//   W = ½h (F + F') (v + v')/2.
// Of it the spring takes ½(F_el + F_el') (ξ' − ξ), and ξ' − ξ = h (v + v')/2 + (F' − F) h²/(4m). Within a contact
// the energy of a leapfrog oscillates by G = F F_el h²/(8m), which is no loss and zero again at the end. What
// remains is what the contact dissipates,
//   W_d = ½h (F_d + F_d') (v + v')/2 + (F F_el' − F' F_el) h²/(8m),   F_d = F − F_el,
// exactly zero where nothing damps. Once the force has ended the spring relaxes without it and F_d = −F_el: what it
// held is dissipated until the gap opens. So the sum of kinetic, elastic and dissipated energy is off by G and by
// what the first and the last step of a contact leave, also where nearly all is dissipated within a few steps.
#pragma once
#include "onset.hpp"

namespace hardlimit::boxes::steps {

struct Strength {
    double force, damping;  // that pushes, and its part that is not elastic [N]
    double rate;            // dξ/dt with this force [m/s]

    double elastic() const { return force - damping; }
};

// `rate` [m/s]: without this force, of which each newton lowers it by `share` [s/kg].
template <class Law>
Strength strength_of(const Law& law, double compression, double rate, double share) {
    if (!(compression > 0.0)) return {0.0, 0.0, rate};
    const double s = onset_root<Law::onset_power>(compression);
    const auto f = law.force(LeadingTerms<2>{{s, 0.0}}, LeadingTerms<2>{{rate, 1.0}});  // with its slope
    const double force = f.c[0] > 0.0 ? f.c[0] / (1.0 + share * f.c[1]) : 0.0;
    return {force, force - law.elastic_force(s), rate - share * force};
}
// At the first step after touch. `inverse_mass` [1/kg]: of the relative motion.
template <class Law>
Strength strength_at_onset(const Law& law, double compression, double rate, double inverse_mass, Onset at) {
    const double set_in = force_sets_in(law, at.rate).reached(at, 0.0) * inverse_mass;
    const Strength found = strength_of(law, compression, rate - set_in, 0.5 * at.since * inverse_mass);
    return found.force > 0.0 ? found : Strength{0.0, found.damping, rate};
}

// What a contact has dissipated at its first step [J].
template <class Law>
double dissipated_at_onset(const Law& law, const Strength& now, Onset at) {
    if (!(now.force > 0.0)) return 0.25 * at.since * now.damping * (at.rate + now.rate);
    return 0.5 * damping_sets_in(law, at.rate).reached(at, now.damping) * (at.rate + now.rate);
}
// Of a step h that begins with the first one in contact, the impulse of damping that equal steps miss [N s].
template <class Law>
double missed_damping(const Law& law, const Strength& first, Onset at, double h) {
    if (!(first.force > 0.0)) return 0.0;
    const auto damping = damping_sets_in(law, at.rate);
    return 0.5 * h * first.damping + damping.missed(at, h) - damping.reached(at, first.damping);
}
// The impulse of damping in a step [N s].
inline double damped(const Strength& before, const Strength& now, double h) {
    return 0.5 * h * (before.damping + now.damping);
}
// What it dissipates in a step [J]. `damped` [N s]: with what steps miss.
inline double dissipated_between(const Strength& before, const Strength& now, double h, double inverse_mass,
                                 double damped) {
    const double crossed = before.force * now.elastic() - now.force * before.elastic();
    return 0.5 * damped * (before.rate + now.rate) + 0.125 * h * h * inverse_mass * crossed;
}
// In the step in which the bodies part: the work of damping until the force ends, and what the spring holds then.
template <class Law>
double dissipated_at_end(const Law& law, const Strength& before, double compression) {
    const auto root = [](double depth) { return onset_root<Law::onset_power>(depth); };
    if (!(before.force > 0.0)) return law.energy(root(compression));
    const double left = math::clamp(law.slack(before.rate).depth, 0.0, compression), s = root(left);
    const double damping = 0.5 * (math::max(-before.damping, 0.0) + law.elastic_force(s));
    return damping * (compression - left) + law.energy(s);
}

}  // namespace hardlimit::boxes::steps
