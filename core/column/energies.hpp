// Energies of a column, from gaps rather than heights: a gap of 1e-15 m then keeps its digits.
#pragma once
#include "state.hpp"

namespace hardlimit::column {

// Energies of the whole column [J]; potential is zero when all gaps are.
struct Energies {
    double kinetic, potential, contact, dissipated;
};

// Kinetic and potential energy of each ball [N] [J]. Potential is zero where all balls lie on each other and the lowest
// on the floor (cradle: is where it is).
template <class Law>
void mechanical_energies(const Column<Law>& c, const double* gap, const double* velocity, double* energy) {
    double height = 0.0;
    for (int i = 0; i < c.balls; ++i) {
        if (i > 0 || c.floor) height += gap[i];
        energy[i] =
            c.mass[static_cast<std::size_t>(i)] * (0.5 * velocity[i] * velocity[i] + c.gravity * height);
    }
}

}  // namespace hardlimit::column
