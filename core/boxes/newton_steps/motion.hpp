// Moves the bodies of a slab: leapfrog kick and drift.
#pragma once
#include "slab.hpp"

namespace hardlimit::boxes::steps {

template <class Law>
void change_velocity(Slab<Law>& slab, Bodies& bodies, const Box& box, std::uint32_t i, Double4 change) {
    bodies.velocity[i] += change;
    const Double4 v = velocity_from_flow(box, bodies, i);
    slab.fastest = math::max(slab.fastest, dot(v, v));
}

// Advances the velocities by `kick` [s] with the accelerations of a step. Contacts accelerate few bodies, gravity all.
// `previous`: the slab whose pairs reach into this one.
template <class Law>
void kick(Slab<Law>& slab, const Slab<Law>& previous, Bodies& bodies, const Box& box, std::uint64_t step,
          double kick) {
    const auto accelerate = [&](std::uint32_t i) {
        change_velocity(slab, bodies, box, i, double4(bodies.acceleration[i].at(step)) * kick);
        if constexpr (FrictionalLaw<Law>)
            bodies.spin[i] += double4(bodies.angular_acceleration[i].at(step)) * kick;
    };
    for (const std::uint32_t i : slab.accelerated) accelerate(i);
    for (const std::uint32_t i : previous.accelerated_next)
        if (slab.holds(i)) accelerate(i);
    const auto add_impulses = [&](const Slab<Law>& from) {
        for (const Impulse& impulse : from.impulses)
            if (slab.holds(impulse.body))
                change_velocity(slab, bodies, box, impulse.body, impulse.velocity_change);
        if constexpr (FrictionalLaw<Law>)
            for (const Impulse& turn : from.turns)
                if (slab.holds(turn.body)) bodies.spin[turn.body] += turn.velocity_change;
    };
    add_impulses(slab);
    if (&previous != &slab) add_impulses(previous);
    const Double4 fall = gravity_of(box) * kick;
    if (dot(fall, fall) > 0.0)
        for (std::uint32_t i = slab.first_body; i < slab.last_body; ++i) bodies.velocity[i] += fall;
}

// Advances the positions by h. Uses scalars: where the processor has vectors of only two doubles, a compiler would pass
// vectors of four through memory.
template <class Law>
void drift(const Slab<Law>& slab, Bodies& bodies, double h) {
    const double by[4] = {h, h, h, 0.0};
    double* position = as_doubles(bodies.position);
    const double* velocity = as_doubles(bodies.velocity);
    for (std::size_t i = slab.first_body; i < slab.last_body; ++i)
        for (std::size_t k = 0; k < 4; ++k) position[4 * i + k] += velocity[4 * i + k] * by[k];
}

}  // namespace hardlimit::boxes::steps
