// Energies of a column, computed from gaps rather than heights so that a gap of 1e-15 m keeps its digits.
#pragma once
#include "state.hpp"

namespace hardlimit::column {

// Energies of the whole column [J]; the potential energy is zero when all gaps are zero.
struct Energies {
    double kinetic, potential, contact, dissipated;
};

// Kinetic plus potential energy of each ball [N] [J]. The potential energy is zero when all gaps are zero (cradle: when
// the pair gaps are zero, whatever the position of the lowest ball).
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
