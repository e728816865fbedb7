// Which bodies may touch before the list is made anew: cells, slabs of cells, and the half list of pairs.
//
// Bodies are sorted by cell, layer by layer along the axis with the most cells. Pairs belong to the body of the lower
// cell, so those of a layer reach into this layer and the next one only. Layers are gathered in slabs. The even
// slabs share no body among each other, nor do the odd ones: with those of one kind before their neighbours of the
// other, every body receives its pushes in one order, whatever the number of threads (schedule.hpp).
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "../common/bodies.hpp"

namespace hardlimit::boxes::steps {

// Two bodies that may touch. The second one is moved by the image with this code, 0 … 26.
struct Pair {
    std::uint32_t first;
    std::uint32_t coded;

    static constexpr unsigned bits = 27;  // of the index of a body
    static Pair of(std::uint32_t i, std::uint32_t j, std::uint32_t image) { return {i, j | image << bits}; }
    std::uint32_t second() const { return coded & ((1u << bits) - 1); }
    std::uint32_t image() const { return coded >> bits; }
};
inline constexpr std::uint32_t no_image = 13;

// The image of the second body along the unfolded paths, in edges: the same as long as the two stay together.
inline std::array<std::int32_t, 3> unfolded(Pair p, const Records<Label>& label) {
    std::array<std::int32_t, 3> turns{};
    std::uint32_t code = p.image();
    for (std::size_t axis = 0; axis < 3; ++axis, code /= 3)
        turns[axis] = static_cast<std::int32_t>(code % 3) - 1 - label[p.second()].turns[axis] +
                      label[p.first].turns[axis];
    return turns;
}

// A body that may touch a wall, 2·axis at 0 or 2·axis + 1 at the far edge.
struct AtWall {
    std::uint32_t body;
    std::uint32_t wall;
};

class Grid {
public:
    Grid() = default;
    // Cells at least as wide as `reach`, and not many more than bodies. Many layers are made even in number: slabs are
    // even in number too, and alike then, so that threads have as much to do.
    Grid(const Box& box, double reach, std::size_t bodies) : box_(box) {
        divide(reach, 2.0 * static_cast<double>(bodies) + 64.0);
        for (int a = 0; a < 3; ++a) order_[a] = a;
        std::stable_sort(order_, order_ + 3, [&](int a, int b) { return cells_[a] > cells_[b]; });
        if (int& layers = cells_[order_[0]]; layers > 16) layers -= layers % 2;
        for (std::uint32_t code = 0; code < 27; ++code) {
            const int step[3] = {static_cast<int>(code % 3) - 1, static_cast<int>(code / 3 % 3) - 1,
                                 static_cast<int>(code / 9) - 1};
            for (int a = 0; a < 3; ++a) shift_[code][a] = step[a] * box.edge[a];
        }
    }

    std::uint32_t layers() const { return width(0); }
    std::uint32_t cells_in_layer() const { return width(1) * width(2); }
    std::uint32_t cells() const { return layers() * cells_in_layer(); }
    const Four* shifts() const { return shift_; }

    std::uint32_t cell_of(Four place) const {
        return (along(0, place) * width(1) + along(1, place)) * width(2) + along(2, place);
    }

    // Calls visit(cell, cells, image) for runs of neighbouring cells that come after `cell` in the half stencil.
    template <class Visit>
    void after(std::uint32_t cell, const Visit& visit) const {
        const int z = static_cast<int>(cell % width(2)), y = static_cast<int>(cell / width(2) % width(1));
        const int x = static_cast<int>(cell / cells_in_layer());
        visit_run(x, y, z + 1, z + 1, visit);
        visit_run(x, y + 1, z - 1, z + 1, visit);
        for (int dy = -1; dy <= 1; ++dy) visit_run(x + 1, y + dy, z - 1, z + 1, visit);
    }

private:
    Box box_{};
    int cells_[3] = {1, 1, 1};  // along x, y, z
    int order_[3] = {0, 1, 2};  // axes, the one with the most cells first
    Four shift_[27] = {};       // of the images [m]

    std::uint32_t width(int place) const { return static_cast<std::uint32_t>(cells_[order_[place]]); }

    void divide(double reach, double most) {
        for (double total = most + 1.0; total > most; reach *= 1.1) {
            total = 1.0;
            for (int a = 0; a < box_.dimension; ++a) {
                const double fit = box_.edge[a] / reach;
                cells_[a] = fit < 1.0 ? 1 : static_cast<int>(fit < most ? fit : most);
                total *= cells_[a];
            }
        }
    }
    std::uint32_t along(int place, Four at) const {
        const int axis = order_[place], n = cells_[axis];
        const double cell = at[axis] / box_.edge[axis] * n;
        if (axis >= box_.dimension || !(cell > 0.0)) return 0;
        return static_cast<std::uint32_t>(cell < n ? static_cast<int>(cell) : n - 1);
    }

    // Takes a cell beyond a periodic side to its image; false where there is nothing beyond.
    bool wrap(int place, int& cell, std::uint32_t& image) const {
        constexpr std::uint32_t unit[3] = {1, 3, 9};
        const int axis = order_[place], n = cells_[axis];
        if (cell >= 0 && cell < n) return true;
        if (!box_.wraps(axis)) return false;
        image += cell < 0 ? 0u - unit[axis] : unit[axis];
        cell += cell < 0 ? n : -n;
        return true;
    }
    template <class Visit>
    void visit_run(int x, int y, int from, int to, const Visit& visit) const {
        std::uint32_t image = no_image;
        if (!wrap(0, x, image) || !wrap(1, y, image)) return;
        const std::uint32_t row =
            (static_cast<std::uint32_t>(x) * width(1) + static_cast<std::uint32_t>(y)) * width(2);
        for (int z = from; z <= to; ++z) {
            int at = z;
            std::uint32_t moved = image;
            if (!wrap(2, at, moved)) continue;
            int run = 1;
            if (moved == image)
                while (z + run <= to && at + run < static_cast<int>(width(2))) ++run;
            visit(row + static_cast<std::uint32_t>(at), static_cast<std::uint32_t>(run), moved);
            z += run - 1;
        }
    }
};

// Appends the pairs of the bodies first … last − 1 of `cell` that are no further apart than touch and `skin`.
// start [cells + 1]: the first body of each cell.
inline void list_pairs(const Grid& grid, const Records<Four>& place, const std::vector<std::uint32_t>& start,
                       std::uint32_t cell, double skin, std::vector<Pair>& pairs) {
    struct Run {
        std::uint32_t first, last, image;
    };
    Run runs[13];
    int count = 0;
    grid.after(cell, [&](std::uint32_t at, std::uint32_t cells, std::uint32_t image) {
        if (start[at] < start[at + cells]) runs[count++] = {start[at], start[at + cells], image};
    });
    const double* at = numbers(place);
    for (std::uint32_t i = start[cell]; i < start[cell + 1]; ++i) {
        const double reach = at[4 * std::size_t{i} + 3] + skin;
        const auto consider = [&](std::uint32_t from, std::uint32_t to, std::uint32_t image) {
            const Four here = place[i] - grid.shifts()[image];
            const double hx = here[0], hy = here[1], hz = here[2];
            for (std::uint32_t j = from; j < to; ++j) {
                const double* there = at + 4 * std::size_t{j};
                const double x = there[0] - hx, y = there[1] - hy, z = there[2] - hz, far = reach + there[3];
                if ((x * x + y * y) + z * z < far * far && j != i) pairs.push_back(Pair::of(i, j, image));
            }
        };
        consider(i + 1, start[cell + 1], no_image);
        for (int k = 0; k < count; ++k) consider(runs[k].first, runs[k].last, runs[k].image);
    }
}

// Appends the walls that each of the bodies first … last − 1 may touch while it moves by less than half the skin.
inline void list_walls(const Box& box, const Records<Four>& place, std::uint32_t first, std::uint32_t last,
                       double skin, std::vector<AtWall>& walls) {
    for (std::uint32_t i = first; i < last; ++i)
        for (int axis = 0; axis < box.dimension; ++axis) {
            if (!box.walled(axis)) continue;
            const double near = place[i][3] + 0.5 * skin, x = place[i][axis];
            const auto wall = static_cast<std::uint32_t>(2 * axis);
            if (x < near) walls.push_back({i, wall});
            if (box.edge[axis] - x < near) walls.push_back({i, wall + 1});
        }
}

// How far to look beyond touch [m]. A wide skin makes the list long, a narrow one makes it soon out of date: per
// body and step the cost is σ λ + κ 2 v h/σ in units of one look at a pair, with λ pairs in the list per body and
// metre of skin, v the largest speed, h the step, and κ what a new list costs per body. The least is at σ = √(2 v h
// κ/λ).
inline double best_skin(double pairs_per_skin, double largest_speed, double time_step) {
    constexpr double list_cost = 40.0;  // κ, measured at packing fractions of 0.3 and 0.6
    return math::sqrt(2.0 * largest_speed * time_step * list_cost / pairs_per_skin);
}

}  // namespace hardlimit::boxes::steps
