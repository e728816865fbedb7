// Finds the deepest overlap of two bodies in a box. The hierarchical cells keep small bodies out of the cells of large
// ones, so that the work is proportional to the number of bodies for any size ratio.
#pragma once
#include <algorithm>
#include <cstddef>
#include <vector>

#include "../../base/stop.hpp"
#include "cells.hpp"

namespace hardlimit::boxes {

// Two bodies and the gap between them [m]; first < 0 if no two bodies overlap.
struct Overlap {
    i64 first = -1, second = -1;
    double gap = 0.0;
};

// Keeps the deepest overlap relative to the sum of the radii; on a tie, that of the lowest indices.
template <int d>
class DeepestOverlap {
public:
    DeepestOverlap(const Box& box, const double* position, const double* radius)
        : box_(box), position_(position), radius_(radius) {}

    void consider(u32 a, u32 b) {
        const double contact = radius_[a] + radius_[b], squared = distance_squared(a, b);
        if (!(squared < contact * contact)) return;
        const double gap = math::sqrt(squared) - contact, relative = gap / contact;
        const i64 low = std::min(a, b), high = std::max(a, b);
        const bool earlier = low < found_.first || (low == found_.first && high < found_.second);
        if (!(gap < 0.0) ||
            (found_.first >= 0 && !(relative < relative_ || (relative == relative_ && earlier))))
            return;
        found_ = {low, high, gap};
        relative_ = relative;
    }
    const Overlap& found() const { return found_; }

private:
    const Box& box_;
    const double *position_, *radius_;
    Overlap found_;
    double relative_ = 0.0;  // gap over contact distance

    // Of the nearest images. A periodic edge is at least four times the largest radius.
    double distance_squared(u32 a, u32 b) const {
        double r[d];
        for (int axis = 0; axis < d; ++axis)
            r[axis] = position_[std::size_t{b} * d + axis] - position_[std::size_t{a} * d + axis];
        box_.to_minimum_image(r, 0.0);
        return boxes::dot(r, r);
    }
};

template <int d>
Overlap deepest_overlap_in(const Box& box, const double* position, const double* radius, std::size_t count,
                           Stop& stop) {
    if (count == 0) return {};
    const auto [smallest, largest] = std::minmax_element(radius, radius + count);
    Cells<d> cells(box, count, 2.0 * *smallest, 2.0 * *largest);
    const auto place = [&](u32 i, int level) {
        double at[d];
        // NaN gives 0: as an index it would lie outside the cells.
        for (int axis = 0; axis < d; ++axis) at[axis] = math::max(0.0, position[std::size_t{i} * d + axis]);
        cells.fold(box, at);
        return cells.place_of(level, at);
    };
    const u32 n = static_cast<u32>(count);
    for (u32 i = 0; i < n; ++i) {
        const int level = cells.level_for(2.0 * radius[i]);
        cells.insert(cells.number(level, place(i, level)), i);
    }
    DeepestOverlap<d> deepest(box, position, radius);
    Scratch<u32> near(cells.room());
    for (u32 i = 0; i < n && !stop(); ++i) {
        const int own = cells.level_for(2.0 * radius[i]);
        cells.for_stencils(own, place(i, own), [&](int level, const Place<d>& from, const Place<d>& to) {
            const auto consider = [&](u32 cell, const double (&)[d]) {
                const std::size_t held = cells.collect(cell, near, 0);
                for (std::size_t k = 0; k < held; ++k)
                    if (level > own || near[k] < i) deepest.consider(i, near[k]);
            };
            cells.for_block(box, level, from, to, consider);
            cells.for_sheared_parts(box, level, from, to, 0.0,
                                    [&](const Place<d>& low, const Place<d>& high, const ImageMotion&) {
                                        cells.for_block(box, level, low, high, consider);
                                    });
        });
    }
    return stop.stopped() ? Overlap{} : deepest.found();
}

// The deepest overlap of two bodies, relative to the sum of their radii. Positions (count × dimension) must lie in the
// box, radii (count) be positive, and a periodic edge be at least four times the largest radius.
inline Overlap deepest_overlap(const Box& box, const double* position, const double* radius,
                               std::size_t count, Stop& stop) {
    return box.dimension == 2 ? deepest_overlap_in<2>(box, position, radius, count, stop)
                              : deepest_overlap_in<3>(box, position, radius, count, stop);
}

}  // namespace hardlimit::boxes
