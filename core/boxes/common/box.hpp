// The box: from 0 to L along each axis, periodic or between two walls.
#pragma once
#include "particle.hpp"

namespace hardlimit::boxes {

template <int d>
struct Box {
    double edge[d];     // L [m]
    bool periodic[d];   // else walls at 0 and at L
    double gravity[d];  // acceleration [m/s²]

    bool falls() const {
        bool any = false;
        for (int k = 0; k < d; ++k) any = any || gravity[k] != 0.0;
        return any;
    }
    double volume() const {
        double product = 1.0;
        for (int k = 0; k < d; ++k) product *= edge[k];
        return product;
    }
};

// The shorter way between two places along a periodic axis.
HL_FN double nearest_image(double distance, double edge) {
    return distance - edge * math::round_small(distance / edge);
}

HL_FN int floor_of(double x) {
    const int toward_zero = static_cast<int>(x);
    return toward_zero - (x < toward_zero ? 1 : 0);
}

template <int d>
double dot(const double (&a)[d], const double (&b)[d]) {
    double sum = a[0] * b[0];
    for (int k = 1; k < d; ++k) sum += a[k] * b[k];
    return sum;
}

// Where a particle is `after` its last collision.
template <Motion motion, int d>
double position_after(const Particle<d>& p, int k, double after, const Box<d>& box) {
    if constexpr (motion == Motion::falling)
        return p.position[k] + after * (p.velocity[k] + (0.5 * box.gravity[k]) * after);
    else
        return p.position[k] + after * p.velocity[k];
}
template <Motion motion, int d>
double velocity_after(const Particle<d>& p, int k, double after, const Box<d>& box) {
    if constexpr (motion == Motion::falling)
        return p.velocity[k] + box.gravity[k] * after;
    else
        return p.velocity[k];
}

template <Motion motion, int d>
void advance(Particle<d>& p, double time, const Box<d>& box) {
    const double after = time - p.time;
    for (int k = 0; k < d; ++k) {
        p.position[k] = position_after<motion>(p, k, after, box);
        p.velocity[k] = velocity_after<motion>(p, k, after, box);
    }
    p.time = time;
}

}  // namespace hardlimit::boxes
