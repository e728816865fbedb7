// Force of one contact at one step, and the energy that it dissipates between two steps.
//
// The compression rate v_n at t_n depends on the force at t_n, since velocities are known half a step earlier:
// v_n = u − F h/(2m), where u is the rate without this force. One Newton step from F = 0 gives F exactly where F(s, v)
// is linear in v, otherwise to second order. For the damping this is the implicit midpoint rule: a decay by e^{−z} in a
// step becomes (1 − z/2)/(1 + z/2), which is stable for any z.
//
// Between two steps velocities change by −h (F + F')/(2m), so the kinetic energy loses exactly
//   W = ½h (F + F') (v + v')/2.
// The spring takes ½(F_el + F_el') (ξ' − ξ) of it, and ξ' − ξ = h (v + v')/2 + (F' − F) h²/(4m). During a contact the
// energy of a leapfrog oscillates by G = F F_el h²/(8m), which returns to zero at the end, so it is no loss. The
// contact dissipates the rest,
//   W_d = ½h (F_d + F_d') (v + v')/2 + (F F_el' − F' F_el) h²/(8m),   F_d = F − F_el,
// which is exactly zero without damping. Once the force has ended the spring relaxes freely and F_d = −F_el: the stored
// energy is dissipated until the gap opens. The sum of kinetic, elastic and dissipated energy is therefore off by G and
// by the errors of the first and the last step of a contact, even if most is dissipated within a few steps.
#pragma once
#include "onset.hpp"

namespace hardlimit::boxes::steps {

struct ContactForce {
    double force, damping;  // repulsive force and its inelastic part [N]
    double rate;            // dξ/dt with this force [m/s]

    double elastic() const { return force - damping; }
};

// `rate` [m/s] is the compression rate without this force; each newton lowers it by `share` [s/kg].
template <class Law>
ContactForce contact_force(const Law& law, double compression, double rate, double share) {
    if (!(compression > 0.0)) return {0.0, 0.0, rate};
    const double s = onset_root<Law::onset_power>(compression);
    const auto f = law.force(LeadingTerms<2>{{s, 0.0}}, LeadingTerms<2>{{rate, 1.0}});  // with its slope
    const double force = f.c[0] > 0.0 ? f.c[0] / (1.0 + share * f.c[1]) : 0.0;
    return {force, force - law.elastic_force(s), rate - share * force};
}
// Force at the first step after touch. `inverse_mass` [1/kg]: inverse effective mass.
template <class Law>
ContactForce force_at_onset(const Law& law, double compression, double rate, double inverse_mass, Onset at) {
    const double set_in = onset_force(law, at.rate).impulse_until_step(at, 0.0) * inverse_mass;
    const ContactForce found = contact_force(law, compression, rate - set_in, 0.5 * at.since * inverse_mass);
    return found.force > 0.0 ? found : ContactForce{0.0, found.damping, rate};
}

// Energy dissipated between touch and the first step [J].
template <class Law>
double dissipated_at_onset(const Law& law, const ContactForce& now, Onset at) {
    if (!(now.force > 0.0)) return 0.25 * at.since * now.damping * (at.rate + now.rate);
    return 0.5 * onset_damping(law, at.rate).impulse_until_step(at, now.damping) * (at.rate + now.rate);
}
// Impulse of the damping that equal steps miss after the first step in contact [N s].
template <class Law>
double missed_damping(const Law& law, const ContactForce& first, Onset at, double h) {
    if (!(first.force > 0.0)) return 0.0;
    const auto damping = onset_damping(law, at.rate);
    return 0.5 * h * first.damping + damping.missed_impulse(at, h) -
           damping.impulse_until_step(at, first.damping);
}
// Impulse of the damping in a step [N s].
inline double damped(const ContactForce& before, const ContactForce& now, double h) {
    return 0.5 * h * (before.damping + now.damping);
}
// Energy dissipated in a step [J]. `damped` [N s]: impulse of the damping, including what equal steps miss.
inline double dissipated_between(const ContactForce& before, const ContactForce& now, double h,
                                 double inverse_mass, double damped) {
    const double crossed = before.force * now.elastic() - now.force * before.elastic();
    return 0.5 * damped * (before.rate + now.rate) + 0.125 * h * h * inverse_mass * crossed;
}
// Energy dissipated in the step in which the bodies separate [J]: the work of the damping until the force ends, and the
// energy that the spring holds then.
template <class Law>
double dissipated_at_end(const Law& law, const ContactForce& before, double compression) {
    const auto root = [](double depth) { return onset_root<Law::onset_power>(depth); };
    if (!(before.force > 0.0)) return law.energy(root(compression));
    const double left = math::clamp(law.slack(before.rate).depth, 0.0, compression), s = root(left);
    const double damping = 0.5 * (math::max(-before.damping, 0.0) + law.elastic_force(s));
    return damping * (compression - left) + law.energy(s);
}

}  // namespace hardlimit::boxes::steps
