// A column of balls on one vertical line, in SI units.
//
// The state consists of gaps and velocities, not positions, so that a gap of 1e-15 m keeps all its digits. Pair 0 is
// the floor and the lowest ball; pair j is balls j and j + 1, counted from the bottom (ball 1 is the lowest). A cradle
// has no floor: pair 0 exists in the arrays but is never closed.
#pragma once
#include <vector>

#include "../base/outcome.hpp"
#include "../contact/law.hpp"
#include "flight.hpp"

namespace hardlimit::column {

template <class Law>
struct Column {
    int balls;                        // N
    bool floor;                       // false: cradle
    double gravity;                   // [m/s²], downwards
    std::vector<double> mass = {};    // [N], bottom first [kg]
    std::vector<double> radius = {};  // [N] [m]
    std::vector<Law> contacts = {};   // [N], pair 0 first; contacts[0] is unused without a floor
    std::vector<double> gaps =
        {};  // [N], gaps[0] = height of the lowest ball's underside above the floor [m]
    std::vector<double> velocity = {};  // [N] at release, upwards [m/s]
};

// Smaller radius [m] of the bodies of pair j, by which compressions are divided; for pair 0 the radius of the ball.
template <class Law>
double smaller_radius(const Column<Law>& c, int j) {
    const double* above = c.radius.data() + j;
    return j == 0 ? *above : math::min(*above, *(above - 1));
}

// One contact. Times in s after the first floor touch (cradle: after release).
struct Contact {
    int pair;
    double begin, end;  // end is NaN for a contact that never ends or was still open when the run stopped
};

}  // namespace hardlimit::column
