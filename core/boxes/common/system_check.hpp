// Validates a system: ranges of values, particles inside the box. Overlaps, also with moving walls, are not checked
// here: an overlapping pair that approaches collides at once. Python checks them (neighbours/overlap.hpp).
#pragma once
#include <algorithm>

#include "engine.hpp"

namespace hardlimit::boxes {

struct Fault {
    enum Kind { none, not_finite, radius, mass, box, outside } kind = none;
    std::size_t particle = 0;
    int axis = 0;
    double value = 0.0;  // the bad value; for `box`: the minimum edge
};

// Checks radii and box only.
inline Fault fault_of_sizes(const System& s) {
    for (std::size_t i = 0; i < s.n; ++i)
        if (!(s.radius[i] > 0.0 && math::is_finite(s.radius[i]))) return {Fault::radius, i, 0, s.radius[i]};
    const double diameter = 2.0 * *std::max_element(s.radius, s.radius + s.n);
    for (int k = 0; k < s.box.dimension; ++k)
        if (!(s.box.edge[k] >= diameter && math::is_finite(s.box.edge[k])))
            return {Fault::box, 0, k, diameter};
    return {};
}

inline Fault validate(const System& s) {
    if (const Fault f = fault_of_sizes(s); f.kind != Fault::none) return f;
    const std::size_t d = static_cast<std::size_t>(s.box.dimension);
    for (std::size_t i = 0; i < s.n; ++i) {
        if (!(s.mass[i] > 0.0 && math::is_finite(s.mass[i]))) return {Fault::mass, i, 0, s.mass[i]};
        for (std::size_t k = 0; k < d; ++k)
            if (!math::is_finite(s.position[i * d + k]) || !math::is_finite(s.velocity[i * d + k]))
                return {Fault::not_finite, i, static_cast<int>(k), 0.0};
    }
    for (std::size_t i = 0; i < s.n; ++i)
        for (std::size_t k = 0; k < d; ++k)
            if (const double x = s.position[i * d + k];
                !s.box.has_moving_walls(static_cast<int>(k)) && !(x >= 0.0 && x <= s.box.edge[k]))
                return {Fault::outside, i, static_cast<int>(k), x};
    return {};
}

}  // namespace hardlimit::boxes
