// Errors of the time stepping in one isolated contact, and the longest step within a tolerance.
#pragma once
#include "contact_force.hpp"

namespace hardlimit::boxes::steps {

// Errors in a contact of two free bodies; infinite if the contact does not end.
struct ContactErrors {
    double restitution = 0.0;  // of ε
    double energy = 0.0;    // of the energy balance at any step, relative to the kinetic energy of the impact
    double position = 0.0;  // after the contact, relative to impact speed × duration

    double largest() const { return math::max(restitution, math::max(energy, position)); }
    void include(const ContactErrors& other) {
        restitution = math::max(restitution, other.restitution);
        energy = math::max(energy, other.energy);
        position = math::max(position, other.position);
    }
};

// Errors if the bodies touch a time `since` [s] before a step.
template <class Law>
ContactErrors contact_errors(const Law& law, double effective_mass, double speed, double h, double since) {
    constexpr int most = 1000000;
    const double impact = 0.5 * effective_mass * speed * speed, inverse_mass = 1.0 / effective_mass;
    const Onset onset{since, speed};
    ContactErrors found;
    double compression = speed * since;
    ContactForce now = force_at_onset(law, compression, speed, inverse_mass, onset);
    double dissipated = dissipated_at_onset(law, now, onset), missed = missed_damping(law, now, onset, h);
    double rate = speed - (h * now.force + onset_force(law, speed).missed_impulse(onset, h)) * inverse_mass;
    for (int step = 0;; ++step) {
        const double stored = law.energy(onset_root<Law::onset_power>(math::max(compression, 0.0)));
        const double sum = 0.5 * effective_mass * now.rate * now.rate + stored + dissipated;
        found.energy = math::max(found.energy, math::abs(sum - impact) / impact);
        if (step == most || !math::is_finite(sum)) return {math::infinity, math::infinity, math::infinity};
        if (step > 0 && !(now.force > 0.0)) {
            const double separation = law.restitution(speed, effective_mass) * speed;
            const double duration = law.duration(speed, effective_mass);
            const double left = math::max(law.slack(-separation).depth, 0.0);
            const double flown = since + step * h - duration;
            found.restitution = math::abs(now.rate + separation) / speed;
            found.position = math::abs(compression - left + separation * flown) / (speed * duration);
            return found;
        }
        compression += rate * h;
        const ContactForce before = now;
        now = contact_force(law, compression, rate, 0.5 * h * inverse_mass);
        dissipated += compression > 0.0
                          ? dissipated_between(before, now, h, inverse_mass, damped(before, now, h) + missed)
                          : dissipated_at_end(law, before, compression - rate * h);
        missed = 0.0;
        rate -= h * now.force * inverse_mass;
    }
}

// The largest errors over all instants of touch between two steps.
template <class Law>
ContactErrors contact_errors(const Law& law, double effective_mass, double speed, double time_step) {
    constexpr int phases = 16;
    ContactErrors worst;
    for (int i = 1; i <= phases; ++i)
        worst.include(contact_errors(law, effective_mass, speed, time_step, time_step * (i - 0.4) / phases));
    return worst;
}

// The longest time step whose errors are at most `error` [s]. A contact gets at least ten steps, and its damping takes
// at most a quarter of the speed in a step: a dense packing, where a body has up to twelve contacts, is stable only for
// h γ/m < 1/3. With n steps per contact h γ/m = −2 ln(ε)/n for the linear law, and about as much for others.
template <class Law>
double longest_step(const Law& law, double effective_mass, double speed, double error) {
    constexpr double most = 1e6;
    const double duration = law.duration(speed, effective_mass);
    const double fewest = math::max(10.0, -8.0 * math::log(law.restitution(speed, effective_mass)));
    const auto good = [&](double steps) {
        return contact_errors(law, effective_mass, speed, duration / steps).largest() <= error;
    };
    // An error may vanish by chance at some step, so a finer one is checked as well.
    double steps = fewest;
    while (steps < most && !(good(steps) && good(1.2 * steps))) steps *= 1.1;
    return duration / steps;
}

}  // namespace hardlimit::boxes::steps
