// Lengths that bound how far bodies in contact move.
#pragma once
#include <algorithm>

#include "../common/newton_setting.hpp"

namespace hardlimit::boxes::events {

struct Limits {
    double largest_radius, smallest_radius;  // [m]
    double largest_safety_radius;            // for which the cells are wide enough [m]
    double largest_displacement;             // of a member while its group lasts [m]

    // R/4 limits the number of pairs in a cluster. In a small box, no second image of a body may come near while a
    // group lasts: it is at least L/2 away along its axis, and both bodies move by D, so L/2 − 2 D > 2 R. This bound,
    // D < 0.25 L − R, is lowered by 0.03 L − 0.1 R, positive in every box that this engine accepts (L >= 4.2 R).
    Limits(const NewtonSetting& setting, double safety_radius)
        : largest_radius(*std::ranges::max_element(setting.radius)),
          smallest_radius(*std::ranges::min_element(setting.radius)),
          largest_safety_radius(safety_radius),
          largest_displacement(math::min(0.25 * smallest_radius,
                                         0.22 * shortest_period(setting.box) - 0.9 * largest_radius)) {}

    // Of a cell: bodies that touch are in neighbouring ones [m].
    double shortest_cell() const { return 2.001 * (largest_radius + 2.0 * largest_safety_radius); }

private:
    static double shortest_period(const Box& box) {
        double least = math::infinity;
        for (int axis = 0; axis < box.dimension; ++axis)
            if (box.wraps(axis)) least = math::min(least, box.edge[axis]);
        return least;
    }
};

}  // namespace hardlimit::boxes::events
