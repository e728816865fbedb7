// When a particle touches each of its neighbours: the one loop of the engine that runs in vector lanes, eight, four
// or two neighbours at once. A neighbour's record is eight doubles, so that as many records as there are lanes are
// turned into columns by shuffles alone. A lane never depends on the others: the same bits for any number of lanes.
//
// Two particles are apart by r, move apart at the rate v, and touch at the distance σ, which grows at the rate s (0 but
// for growing radii). With a = v² − s², b = r·v − σ s, c = r² − σ²:
//   |r + v τ| = σ + s τ   ⇔   a τ² + 2 b τ + c = 0,
// whose first root is c/(−b + √(b² − a c)) where b < 0, a form that neither cancels nor leads into the past. Where c
// ≤ 0, by rounding or because positions are drawn back, a pair that approaches collides now (Bannerman, Strobl,
// Formella & Pöschel, Comput. Part. Mech. 1, 191 (2014)). Where radii grow faster than the pair parts, b ≥ 0 and a <
// 0, the root is (b + √(b² − a c))/(−a).
//
// Where a radius stands for the space that a particle may need (`reach`), two may have come too near without
// approaching: then c < 0 by more than rounding means now, whatever b is.
#pragma once
#include <cstddef>

#include "particle.hpp"

namespace hardlimit_abi {

// The particle that looks, now, and where.
struct TouchQuery {
    double now;                          // [s]
    double position[3];                  // [m]
    double velocity[3];                  // [m/s]
    double radius;                       // [m]
    double shift[3];                     // of all neighbours [m]
    double edge[3];                      // L [m]
    double per_edge[3];                  // 1/L where the nearest image is meant, else 0
    double half_gravity[3], gravity[3];  // g/2 and g [m/s²]
    double share, rate;  // of the radii now, and its growth [1/s]: 1 and 0 but for growing radii
};

// Times from now at which the n particles with these ids are touched, infinity where they are not; the least of
// them. The list of ids and that of times have room for seven more. `particles` is an array of cache lines.
using TouchTimes = double (*)(const TouchQuery& query, const void* particles, unsigned* ids, std::size_t n,
                              unsigned self, double* times);

struct TouchKernels {
    const char* name;
    TouchTimes times[2][3];  // by dimension − 2 and motion
    TouchTimes reach[2];     // in three dimensions, by motion; straight and falling
};

}  // namespace hardlimit_abi

namespace hardlimit::particles {

// Part of the square of the distance up to which overlap is rounding.
inline constexpr double rounding_of_touch = 4e-9;

template <class Real, int d, Motion motion, bool reach>
HL_FN Real touch_times_of(const hardlimit_abi::TouchQuery& q, const Columns<Real>& p) {
    const Real after = q.now - p.of[2 * d];
    Real a{}, b{}, square{};
    HL_UNROLL
    for (int k = 0; k < d; ++k) {
        Real x, v;
        if constexpr (motion == Motion::falling) {
            x = p.of[k] + after * (p.of[d + k] + q.half_gravity[k] * after);
            v = p.of[d + k] + q.gravity[k] * after;
        } else {
            x = p.of[k] + after * p.of[d + k];
            v = p.of[d + k];
        }
        Real r = (x + q.shift[k]) - q.position[k];
        r = r - q.edge[k] * math::round_small<Real>(r * q.per_edge[k]);
        v = v - q.velocity[k];
        a = k == 0 ? v * v : a + v * v;
        b = k == 0 ? r * v : b + r * v;
        square = k == 0 ? r * r : square + r * r;
    }
    const Real touch = q.radius + p.of[2 * d + 1], never = broadcast<Real>(math::infinity);
    if constexpr (motion == Motion::growing) {
        const Real distance = touch * q.share, speed = touch * q.rate;
        a = a - speed * speed;
        b = b - distance * speed;
        const Real c = square - distance * distance;
        const Real discriminant = b * b - a * c;
        const Mask<Real> approaching = (b < 0.0) & (discriminant > 0.0);
        const Mask<Real> overtaken = (c > 0.0) & (a < 0.0);
        const Real root = math::sqrt<Real>(math::max<Real>(discriminant, Real{}));
        const Real time = select<Real>(b < 0.0, math::max<Real>(c, Real{}) / (root - b), (b + root) / -a);
        return select<Real>((approaching | overtaken) & (square > 0.0), time, never);
    } else {
        const Real c = square - touch * touch;
        const Real discriminant = b * b - a * c;
        const Mask<Real> will = (b < 0.0) & (discriminant > 0.0);
        if constexpr (reach) {
            // The particle itself, which is where it is, does not count.
            const Mask<Real> inside = (c < -rounding_of_touch * (touch * touch)) & (square > 0.0);
            if (any(inside)) {
                const Real time = math::max<Real>(c, Real{}) /
                                  (math::sqrt<Real>(math::max<Real>(discriminant, Real{})) - b);
                return select<Real>(inside, Real{}, select<Real>(will, time, never));
            }
        }
        if (!any(will)) return never;
        const Real time =
            math::max<Real>(c, Real{}) / (math::sqrt<Real>(math::max<Real>(discriminant, Real{})) - b);
        return select<Real>(will, time, never);
    }
}

template <class Real, int d, Motion motion, bool reach = false>
double touch_times(const hardlimit_abi::TouchQuery& q, const void* particles, unsigned* ids, std::size_t n,
                   unsigned self, double* times) {
    constexpr std::size_t lanes = Lanes<Real>::count;
    const double* const lines = static_cast<const double*>(particles);
    // What is left of the last group of lanes is the particle itself, which it never touches.
    for (std::size_t k = 0; k + 1 < lanes; ++k) ids[n + k] = self;
    Real least = broadcast<Real>(math::infinity);
    for (std::size_t k = 0; k < n; k += lanes) {
        const double* row[lanes];
        HL_UNROLL
        for (std::size_t lane = 0; lane < lanes; ++lane) row[lane] = lines + 8 * std::size_t{ids[k + lane]};
        const Real time = touch_times_of<Real, d, motion, reach>(q, load_columns<Real>(row));
        store_lanes(times + k, time);
        least = math::min<Real>(least, time);
    }
    double each[lanes], first = math::infinity;
    store_lanes(each, least);
    for (const double time : each) first = math::min(first, time);
    return first;
}

template <class Real>
constexpr hardlimit_abi::TouchKernels touch_kernels(const char* name) {
    return {name,
            {{&touch_times<Real, 2, Motion::straight>, &touch_times<Real, 2, Motion::falling>,
              &touch_times<Real, 2, Motion::growing>},
             {&touch_times<Real, 3, Motion::straight>, &touch_times<Real, 3, Motion::falling>,
              &touch_times<Real, 3, Motion::growing>}},
            {&touch_times<Real, 3, Motion::straight, true>, &touch_times<Real, 3, Motion::falling, true>}};
}

}  // namespace hardlimit::particles
