// One isolated contact, stepped as the box steps it, to measure the error that a time step makes.
#pragma once
#include "onset.hpp"

namespace hardlimit::particles::steps {

// The repulsive force [N] and the power dissipated [W] at a compression > 0.
struct Strength {
    double force, loss;
};
template <class Law>
Strength strength_of(const Law& law, double compression, double rate) {
    const double s = onset_root<Law::onset_power>(compression);
    const double force = math::max(0.0, law.force(s, rate));
    return {force, (force - law.elastic_force(s)) * rate};
}

// ε of a contact of two free bodies that touch `since` before a step; NaN where it does not end.
template <class Law>
double stepped_restitution(const Law& law, double effective_mass, double speed, double time_step,
                           double since) {
    constexpr int most = 1000000;
    double compression = speed * since, rate_before = speed, acceleration = 0.0;
    for (int step = 0; step < most && compression > 0.0; ++step) {
        const double rate = rate_before + 0.5 * acceleration * time_step;
        const double force = strength_of(law, compression, rate).force;
        if (!(force > 0.0) && step > 0) break;
        double impulse = force * time_step;
        if (step == 0) impulse += force_sets_in(law, speed).missed({since, speed}, time_step);
        acceleration = -force / effective_mass;
        rate_before -= impulse / effective_mass;
        compression += rate_before * time_step;
    }
    const bool ended = rate_before <= 0.0;
    return ended ? -rate_before / speed : math::nan;
}

// The largest error of ε that a time step makes, over where between two steps the bodies touch; NaN where a contact
// does not end.
template <class Law>
double restitution_error(const Law& law, double effective_mass, double speed, double time_step) {
    constexpr int phases = 16;
    const double exact = law.restitution(speed, effective_mass);
    double worst = 0.0;
    for (int i = 1; i <= phases; ++i) {
        const double since = time_step * (i - 0.4) / phases;
        const double error =
            math::abs(stepped_restitution(law, effective_mass, speed, time_step, since) - exact);
        if (!(error <= worst)) worst = error;
    }
    return worst;
}

// The longest time step whose error of ε is at most `error`, and at most a tenth of the contact [s]: with fewer
// steps the contacts of a dense packing, in which a body has up to twelve at a time, are no longer stable.
template <class Law>
double longest_step(const Law& law, double effective_mass, double speed, double error) {
    constexpr double fewest = 10.0, most = 1e6;
    const double duration = law.duration(speed, effective_mass);
    const auto good = [&](double steps) {
        return restitution_error(law, effective_mass, speed, duration / steps) <= error;
    };
    // An error may happen to vanish at some step: the next finer one is asked as well.
    double steps = fewest;
    while (steps < most && !(good(steps) && good(1.2 * steps))) steps *= 1.1;
    return duration / steps;
}

}  // namespace hardlimit::particles::steps
