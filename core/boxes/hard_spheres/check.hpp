// What is wrong with a system, if anything: numbers out of range, particles beside the box. Overlap is no fault here:
// a pair that overlaps and approaches collides at once. Whether a start may overlap is asked at the boundary
// (overlap.hpp).
#pragma once
#include <algorithm>

#include "../common/box.hpp"
#include "../common/engine.hpp"

namespace hardlimit::boxes {

struct Fault {
    enum Kind { none, not_finite, radius, mass, box, outside } kind = none;
    std::size_t particle = 0;
    int axis = 0;
    double value = 0.0;  // what was found, or by how much it is too little
};

template <int d>
class Check {
public:
    explicit Check(const Setting& s) : s_(s) {
        for (int k = 0; k < d; ++k) {
            box_.edge[k] = s.edge[k];
            box_.periodic[k] = s.periodic[k];
        }
    }

    Fault fault() const {
        Fault f = of_sizes();
        if (f.kind == Fault::none) f = of_numbers();
        if (f.kind == Fault::none) f = of_places();
        return f;
    }

    // Of radii and box alone.
    Fault of_sizes() const {
        for (std::size_t i = 0; i < s_.n; ++i)
            if (!(s_.radius[i] > 0.0 && math::is_finite(s_.radius[i])))
                return {Fault::radius, i, 0, s_.radius[i]};
        const double diameter = 2.0 * *std::max_element(s_.radius, s_.radius + s_.n);
        for (int k = 0; k < d; ++k)
            if (!(box_.edge[k] >= diameter && math::is_finite(box_.edge[k])))
                return {Fault::box, 0, k, diameter};
        return {};
    }

private:
    const Setting& s_;
    Box<d> box_{};

    double position(std::size_t i, int k) const { return s_.position[i * d + static_cast<std::size_t>(k)]; }

    Fault of_numbers() const {
        for (std::size_t i = 0; i < s_.n; ++i) {
            if (!(s_.mass[i] > 0.0 && math::is_finite(s_.mass[i]))) return {Fault::mass, i, 0, s_.mass[i]};
            for (int k = 0; k < d; ++k)
                if (!math::is_finite(position(i, k)) ||
                    !math::is_finite(s_.velocity[i * d + static_cast<std::size_t>(k)]))
                    return {Fault::not_finite, i, k, 0.0};
        }
        return {};
    }
    Fault of_places() const {
        for (std::size_t i = 0; i < s_.n; ++i)
            for (int k = 0; k < d; ++k) {
                const double x = position(i, k);
                if (!(x >= 0.0 && x <= box_.edge[k])) return {Fault::outside, i, k, x};
            }
        return {};
    }
};

inline Fault fault_of(const Setting& s) {
    return s.dimension == 2 ? Check<2>(s).fault() : Check<3>(s).fault();
}

inline Fault fault_of_sizes(const Setting& s) {
    return s.dimension == 2 ? Check<2>(s).of_sizes() : Check<3>(s).of_sizes();
}

}  // namespace hardlimit::boxes
