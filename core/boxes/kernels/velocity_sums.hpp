// Sums over the velocities of free bodies. Of each body one cache line is read.
#pragma once
#include <cstddef>

#include "../../base/math.hpp"
#include "interface.hpp"

namespace hardlimit::boxes {

// Momentum and Σ m v⊗v. With registers of four a vector is one, and the fourth component does not count.
template <int lanes>
struct VelocitySums {
    using Four = typename Vector<4>::Real;
    Four momentum{}, squares{}, products{};

    HL_FN_INLINE void add(double mass, const double* velocity) {
        const Four v = load_lanes<Four>(velocity), mv = mass * v;
        momentum += mv;
        squares += mv * v;
        products += HL_SHUFFLE(mv, mv, 0, 0, 1, 3) * HL_SHUFFLE(v, v, 1, 2, 2, 3);
    }
};
template <int lanes>
    requires(lanes < 4)
struct VelocitySums<lanes> {
    double momentum[3] = {}, squares[3] = {}, products[3] = {};

    HL_FN_INLINE void add(double mass, const double* velocity) {
        const double x = velocity[0], y = velocity[1], z = velocity[2];
        const double mx = mass * x, my = mass * y, mz = mass * z;
        momentum[0] += mx, momentum[1] += my, momentum[2] += mz;
        squares[0] += mx * x, squares[1] += my * y, squares[2] += mz * z;
        products[0] += mx * y, products[1] += mx * z, products[2] += my * z;
    }
};

// Adds up the particles whose radius is their own: that of a body in contact is enlarged by its safety radius. Writes
// the momentum [3] and Σ m v⊗v [6, in the order of SymmetricTensor].
template <int lanes>
void sum_velocities(const void* particles, std::size_t n, const hardlimit_abi::BodyKinds& kinds,
                    double* momentum, double* tensor) {
    constexpr int velocity = 3, radius = 7, length = 8;  // places and number of words of a Particle
    VelocitySums<lanes> sums;
    for (std::size_t i = 0; i < n; ++i) {
        const double* const particle = static_cast<const double*>(particles) + length * i;
        const double* const own = kinds.mass_and_radius + 2 * (kinds.kind ? kinds.kind[i] : kinds.step * i);
        if (particle[radius] == own[1]) sums.add(own[0], particle + velocity);
    }
    for (int a = 0; a < 3; ++a) {
        momentum[a] = sums.momentum[a];
        tensor[a] = sums.squares[a];
        tensor[3 + a] = sums.products[a];
    }
}

}  // namespace hardlimit::boxes
