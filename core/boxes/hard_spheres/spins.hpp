// Spins of particles with friction, in an array beside the particles that only collisions touch.
#pragma once
#include <algorithm>

#include "../common/engine.hpp"

namespace hardlimit::boxes::spheres {

// Half a cache line.
struct alignas(32) Spin {
    double velocity[3];      // ω [rad/s]; disks turn about the third axis
    double inverse_inertia;  // 1/I [1/(kg m²)]

    double energy() const {
        double square = 0.0;
        for (const double w : velocity) square += w * w;
        return 0.5 * square / inverse_inertia;
    }
};
static_assert(sizeof(Spin) == 32);

inline double inertia_factor(const System& s, std::size_t i) {
    return s.inertia_factor ? s.inertia_factor[i] : solid_inertia_factor(s.box.dimension);
}

inline Spin spin_of(const System& s, std::size_t i) {
    Spin spin{{}, 1.0 / (inertia_factor(s, i) * s.mass[i] * s.radius[i] * s.radius[i])};
    if (s.angular_velocity) std::copy_n(s.angular_velocity + 3 * i, 3, spin.velocity);
    return spin;
}

}  // namespace hardlimit::boxes::spheres
