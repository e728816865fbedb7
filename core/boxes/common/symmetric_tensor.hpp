// Symmetric tensor of three dimensions, such as a virial.
#pragma once
#include <cstddef>

#include "../../base/math.hpp"

namespace hardlimit::boxes {

// Components in LAMMPS' order: xx, yy, zz, xy, xz, yz.
struct SymmetricTensor {
    static constexpr std::size_t size = 6;
    static constexpr int row[size] = {0, 1, 2, 0, 0, 1}, column[size] = {0, 1, 2, 1, 2, 2};

    double component[size] = {};

    double trace() const { return (component[0] + component[1]) + component[2]; }
    SymmetricTensor& operator+=(const SymmetricTensor& other) {
        for (std::size_t k = 0; k < size; ++k) component[k] += other.component[k];
        return *this;
    }
    // Adds factor · (a⊗b + b⊗a)/2.
    template <class Vector>
    void add_product(double factor, const Vector& a, const Vector& b) {
        for (std::size_t k = 0; k < size; ++k)
            component[k] += (0.5 * factor) * (a[row[k]] * b[column[k]] + b[row[k]] * a[column[k]]);
    }
    // Adds factor · a⊗a.
    template <class Vector>
    HL_FN_INLINE void add_square(double factor, const Vector& a) {
        const double x = factor * a[0], y = factor * a[1], z = factor * a[2];
        component[0] += x * a[0], component[1] += y * a[1], component[2] += z * a[2];
        component[3] += x * a[1], component[4] += x * a[2], component[5] += y * a[2];
    }
};

}  // namespace hardlimit::boxes
