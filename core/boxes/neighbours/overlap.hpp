// Finds the deepest overlap of two bodies in a box. Each size class has its own cells, so that small bodies do not
// crowd the cells of large ones: the work is proportional to the number of bodies for any size ratio.
#pragma once
#include <cstddef>
#include <utility>
#include <vector>

#include "../../base/math.hpp"
#include "../../base/stop.hpp"
#include "../common/box.hpp"

namespace hardlimit::boxes {

// Two bodies and the gap between them [m]; first < 0 if no two bodies overlap.
struct Overlap {
    i64 first = -1, second = -1;
    double gap = 0.0;
};

namespace detail {

struct Body {
    double at[3];
    double radius;
    i64 number;
};

// Cell list of bodies of similar size. Cells are at least as wide as the largest diameter.
class SizeClass {
public:
    SizeClass(const Box& box, std::vector<Body> bodies) : box_(box) {
        double widest = 0.0;
        for (const Body& b : bodies) widest = b.radius > widest ? b.radius : widest;
        divide(2.0 * widest, bodies.size());
        sort(bodies);
    }

    const std::vector<Body>& bodies() const { return bodies_; }

    // Calls visit(body) for every body in the cells around `position`.
    template <class Visit>
    void around(const double* position, const Visit& visit) const {
        int list[3][3], count[3];
        for (int axis = 0; axis < 3; ++axis) count[axis] = neighbours(axis, position[axis], list[axis]);
        for (int k = 0; k < count[2]; ++k)
            for (int j = 0; j < count[1]; ++j)
                for (int i = 0; i < count[0]; ++i) {
                    const std::size_t cell = index(list[0][i], list[1][j], list[2][k]);
                    for (std::size_t at = start_[cell]; at < start_[cell + 1]; ++at) visit(bodies_[at]);
                }
    }

private:
    Box box_;
    int cells_[3] = {1, 1, 1};
    std::vector<std::size_t> start_;
    std::vector<Body> bodies_;  // in the order of their cells

    // As many cells as their minimum width allows, up to about four per body.
    void divide(double width, std::size_t bodies) {
        const double most = 4.0 * static_cast<double>(bodies) + 64.0;
        for (double total = most + 1.0; total > most; width *= 1.25) {
            total = 1.0;
            for (int axis = 0; axis < box_.dimension; ++axis) {
                const double fit = box_.edge[axis] / width;
                cells_[axis] = fit < 1.0 ? 1 : fit > most ? static_cast<int>(most) : static_cast<int>(fit);
                total *= cells_[axis];
            }
        }
    }

    void sort(const std::vector<Body>& bodies) {
        start_.assign(index(0, 0, cells_[2]) + 1, 0);
        for (const Body& b : bodies) ++start_[cell_of(b) + 1];
        for (std::size_t i = 1; i < start_.size(); ++i) start_[i] += start_[i - 1];
        std::vector<std::size_t> next(start_.begin(), start_.end() - 1);
        bodies_.resize(bodies.size());
        for (const Body& b : bodies) bodies_[next[cell_of(b)]++] = b;
    }

    std::size_t index(int i, int j, int k) const {
        const auto wide = [](int n) { return static_cast<std::size_t>(n); };
        return wide(i) + wide(cells_[0]) * (wide(j) + wide(cells_[1]) * wide(k));
    }
    int cell_along(int axis, double x) const {
        const double cell = x / box_.edge[axis] * cells_[axis];
        if (axis >= box_.dimension || !(cell > 0.0)) return 0;
        return cell < cells_[axis] ? static_cast<int>(cell) : cells_[axis] - 1;
    }
    std::size_t cell_of(const Body& b) const {
        return index(cell_along(0, b.at[0]), cell_along(1, b.at[1]), cell_along(2, b.at[2]));
    }

    // Lists the cell that holds x and its neighbours, each once, and returns their number.
    int neighbours(int axis, double x, int* list) const {
        const int cells = cells_[axis], here = cell_along(axis, x);
        if (cells <= 3 && (cells < 3 || box_.is_periodic(axis))) {
            for (int i = 0; i < cells; ++i) list[i] = i;
            return cells;
        }
        int count = 0;
        for (int step = -1; step <= 1; ++step) {
            int cell = here + step;
            if (cell < 0 || cell >= cells) {
                if (!box_.is_periodic(axis)) continue;
                cell += cell < 0 ? cells : -cells;
            }
            list[count++] = cell;
        }
        return count;
    }
};

// Squared distance of the nearest images. A periodic edge is at least four times the largest radius.
HL_FN double distance_squared(const Box& box, const Body& a, const Body& b) {
    double sum = 0.0;
    for (int axis = 0; axis < box.dimension; ++axis) {
        double d = a.at[axis] - b.at[axis];
        d = d < 0.0 ? -d : d;
        if (box.is_periodic(axis) && box.edge[axis] - d < d) d = box.edge[axis] - d;
        sum += d * d;
    }
    return sum;
}

// Keeps the deepest overlap relative to the sum of the radii; on a tie, that of the lowest indices.
class DeepestOverlap {
public:
    explicit DeepestOverlap(const Box& box) : box_(box) {}

    void consider(const Body& a, const Body& b) {
        const double apart = a.radius + b.radius, squared = distance_squared(box_, a, b);
        if (!(squared < apart * apart)) return;
        const double gap = math::sqrt(squared) - apart, share = gap / apart;
        const i64 low = a.number < b.number ? a.number : b.number;
        const i64 high = a.number < b.number ? b.number : a.number;
        const bool earlier = low < found_.first || (low == found_.first && high < found_.second);
        if (!(gap < 0.0) || (found_.first >= 0 && !(share < share_ || (share == share_ && earlier)))) return;
        found_ = {low, high, gap};
        share_ = share;
    }
    const Overlap& found() const { return found_; }

private:
    Box box_;
    Overlap found_;
    double share_ = 0.0;
};

// Sorts the bodies into size classes, the largest first. Radii in a class differ by less than a factor of two.
inline std::vector<SizeClass> size_classes(const Box& box, const double* position, const double* radius,
                                           std::size_t count) {
    double largest = 0.0;
    for (std::size_t i = 0; i < count; ++i) largest = radius[i] > largest ? radius[i] : largest;
    std::vector<std::vector<Body>> by_size;
    for (std::size_t i = 0; i < count; ++i) {
        std::size_t size = 0;
        for (double limit = 0.5 * largest; radius[i] <= limit && limit > 0.0; limit *= 0.5) ++size;
        if (size >= by_size.size()) by_size.resize(size + 1);
        Body body{{0.0, 0.0, 0.0}, radius[i], static_cast<i64>(i)};
        for (int axis = 0; axis < box.dimension; ++axis)
            body.at[axis] =
                position[i * static_cast<std::size_t>(box.dimension) + static_cast<std::size_t>(axis)];
        by_size[size].push_back(body);
    }
    std::vector<SizeClass> classes;
    for (std::vector<Body>& bodies : by_size)
        if (!bodies.empty()) classes.emplace_back(box, std::move(bodies));
    return classes;
}

}  // namespace detail

// The deepest overlap of two bodies, relative to the sum of their radii. Positions (count × dimension) must lie in the
// box, radii (count) be positive, and a periodic edge be at least four times the largest radius.
inline Overlap deepest_overlap(const Box& box, const double* position, const double* radius,
                               std::size_t count, Stop& stop) {
    const std::vector<detail::SizeClass> classes = detail::size_classes(box, position, radius, count);
    detail::DeepestOverlap deepest(box);
    for (std::size_t small = 0; small < classes.size(); ++small)
        for (const detail::Body& body : classes[small].bodies()) {
            if (stop()) return {};
            for (std::size_t large = 0; large <= small; ++large)
                classes[large].around(body.at, [&](const detail::Body& other) {
                    if (large < small || other.number < body.number) deepest.consider(body, other);
                });
        }
    return deepest.found();
}

}  // namespace hardlimit::boxes
