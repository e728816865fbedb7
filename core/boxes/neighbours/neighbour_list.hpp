// Verlet neighbour list of the time-stepping engine: layers of cells, half list of pairs, and walls within reach.
//
// Bodies are sorted by cell, layer by layer along the axis with the most cells. A pair belongs to its body in the lower
// cell, so the pairs of a layer reach into this layer and the next one only.
//
// In a sheared box the layers follow the gradient, so that only pairs of the last layer reach across the sheared side.
// There the cells are displaced along the first axis: three columns face four.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "../common/bodies.hpp"

namespace hardlimit::boxes {

// Two bodies that may touch, and the periodic image of the second one as a code of CellLayers.
struct NeighbourPair {
    std::uint32_t first;
    std::uint32_t coded;  // second body and image

    static constexpr unsigned bits = 27;  // of the index of a body
    static NeighbourPair of(std::uint32_t i, std::uint32_t j, std::uint32_t image) {
        return {i, j | image << bits};
    }
    std::uint32_t second() const { return coded & ((1u << bits) - 1); }
    std::uint32_t image() const { return coded >> bits; }
};

// A body that may touch a wall.
struct WallNeighbour {
    std::uint32_t body;
    WallId wall;
};

class CellLayers {
public:
    static constexpr std::uint32_t most_images = 30;

    CellLayers() = default;
    // Cells are at least as wide as `reach`, and at most about two per body. More than 16 layers are rounded down to an
    // even number: the number of slabs is even too, so slabs then have equal work. `time` [s]: of the positions.
    CellLayers(const Box& box, double reach, std::size_t bodies, double time) : box_(box) {
        divide(reach, 2.0 * static_cast<double>(bodies) + 64.0);
        for (int a = 0; a < 3; ++a) order_[a] = a;
        std::stable_sort(order_, order_ + 3, [&](int a, int b) {
            return box.slides(a) != box.slides(b) ? box.slides(a) : cells_[a] > cells_[b];
        });
        if (int& layers = cells_[order_[0]]; layers > 16) layers -= layers % 2;
        if (box.is_sheared()) {
            periods_ = math::round_small(box.image_displacement(time) / box.edge[0]);
            displacement_ = displacement(time);
            least_[0] = -2, count_[0] = 5;  // a displaced row of cells reaches further
            least_[box.gradient] = 0, count_[box.gradient] = 2;
        }
        for (std::uint32_t code = 0; code < count_[0] * count_[1] * count_[2]; ++code) {
            const std::array<int, 3> flags = flags_of(code);
            for (std::size_t a = 0; a < 3; ++a) shift_[code][a] = flags[a] * box.edge[a];
            shift_[code][3] = box.layer(flags);
            shift_[code][0] += shift_[code][3] * displacement_;
        }
    }

    std::uint32_t layers() const { return width(0); }
    std::uint32_t cells_in_layer() const { return width(1) * width(2); }
    std::uint32_t cells() const { return layers() * cells_in_layer(); }
    // Shifts of the images, by code [m]; the last component counts how often the image lies beyond the sheared side.
    // They are those at the time of the list, as they stay unless they are beyond this side.
    const Double4* shifts() const { return shift_; }
    // Writes those at another time.
    void shifts_at(double time, Double4 (&shift)[most_images]) const {
        const double moved = displacement(time) - displacement_;
        for (std::uint32_t code = 0; code < most_images; ++code) {
            shift[code] = shift_[code];
            shift[code][0] += shift[code][3] * moved;
        }
    }
    // Velocity of an image relative to the body itself, along the first axis [m/s].
    double velocity(std::uint32_t code) const { return shift_[code][3] * box_.image_velocity(); }
    std::uint32_t no_image() const {
        std::uint32_t code = 0;
        for (int a = 2; a >= 0; --a) code = code * count_[a] - static_cast<std::uint32_t>(least_[a]);
        return code;
    }
    // Image of the second body relative to the first in unfolded coordinates, in units of the edges. It does not change
    // while the bodies are neighbours, even if one crosses a periodic boundary.
    std::array<std::int32_t, 3> relative_image(NeighbourPair p, const Records<BodyTag>& tag) const {
        std::array<std::int32_t, 3> image = flags_of(p.image());
        image[0] -= static_cast<std::int32_t>(shift_[p.image()][3] * periods_);
        for (std::size_t a = 0; a < 3; ++a)
            image[a] += tag[p.first].image_flags[a] - tag[p.second()].image_flags[a];
        return image;
    }

    std::uint32_t cell_of(Double4 position) const {
        return (along(0, position) * width(1) + along(1, position)) * width(2) + along(2, position);
    }

    // Calls visit(first cell, number of cells, image) for each run of cells in the half stencil after `cell`.
    template <class Visit>
    void after(std::uint32_t cell, const Visit& visit) const {
        const int z = static_cast<int>(cell % width(2)), y = static_cast<int>(cell / width(2) % width(1));
        const int x = static_cast<int>(cell / cells_in_layer());
        visit_run(x, y, z + 1, z + 1, visit);
        visit_run(x, y + 1, z - 1, z + 1, visit);
        int from[2] = {y - 1, z - 1}, to[2] = {y + 1, z + 1};
        if (box_.slides(order_[0]) && x + 1 == cells_[order_[0]]) {
            const int k = order_[1] == 0 ? 0 : 1;
            from[k] = floor_to_int(from[k] - displacement_ / box_.edge[0] * cells_[0]);
            to[k] = from[k] + 3;
        }
        for (int at = from[0]; at <= to[0]; ++at) visit_run(x + 1, at, from[1], to[1], visit);
    }

private:
    Box box_{};
    int cells_[3] = {1, 1, 1};  // along x, y, z
    int order_[3] = {0, 1, 2};  // axes by decreasing number of cells
    // The code of an image: its flags as digits, for each axis count_ values from least_ on.
    std::uint32_t count_[3] = {3, 3, 3};
    int least_[3] = {-1, -1, -1};
    Double4 shift_[most_images] = {};
    // Of the images beyond the sheared side at the time of the list: at most half an edge and whole edges.
    double displacement_ = 0.0, periods_ = 0.0;  // [m], edges

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
    std::uint32_t along(int place, Double4 at) const {
        const int axis = order_[place], n = cells_[axis];
        const double cell = at[axis] / box_.edge[axis] * n;
        if (axis >= box_.dimension || !(cell > 0.0)) return 0;
        return static_cast<std::uint32_t>(cell < n ? static_cast<int>(cell) : n - 1);
    }

    std::array<std::int32_t, 3> flags_of(std::uint32_t code) const {
        std::array<std::int32_t, 3> flags{};
        for (std::size_t a = 0; a < 3; code /= count_[a++])
            flags[a] = static_cast<std::int32_t>(code % count_[a]) + least_[a];
        return flags;
    }
    // Displacement of the images beyond the sheared side, less whole edges at the time of the list [m].
    double displacement(double time) const { return box_.image_displacement(time) - periods_ * box_.edge[0]; }

    // Replaces a cell beyond a periodic boundary by its image. Returns false beyond a wall.
    bool wrap(int place, int& cell, std::uint32_t& image) const {
        const int axis = order_[place], n = cells_[axis];
        if (cell >= 0 && cell < n) return true;
        if (!box_.wraps(axis)) return false;
        std::uint32_t unit = 1;
        for (int a = 0; a < axis; ++a) unit *= count_[a];
        for (; cell < 0; cell += n) image -= unit;
        for (; cell >= n; cell -= n) image += unit;
        return true;
    }
    template <class Visit>
    void visit_run(int x, int y, int from, int to, const Visit& visit) const {
        std::uint32_t image = no_image();
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

// Appends the pairs of the bodies of `cell` whose gap is less than `skin` [m]. start [cells + 1]: first body of each
// cell.
inline void list_pairs(const CellLayers& grid, const Records<Double4>& position,
                       const std::vector<std::uint32_t>& start, std::uint32_t cell, double skin,
                       std::vector<NeighbourPair>& pairs) {
    struct Run {
        std::uint32_t first, last, image;
    };
    Run runs[16];
    int count = 0;
    grid.after(cell, [&](std::uint32_t at, std::uint32_t cells, std::uint32_t image) {
        if (start[at] < start[at + cells]) runs[count++] = {start[at], start[at + cells], image};
    });
    const double* at = as_doubles(position);
    for (std::uint32_t i = start[cell]; i < start[cell + 1]; ++i) {
        const double reach = at[4 * std::size_t{i} + 3] + skin;
        const auto consider = [&](std::uint32_t from, std::uint32_t to, std::uint32_t image) {
            const Double4 here = position[i] - grid.shifts()[image];
            const double hx = here[0], hy = here[1], hz = here[2];
            for (std::uint32_t j = from; j < to; ++j) {
                const double* there = at + 4 * std::size_t{j};
                const double x = there[0] - hx, y = there[1] - hy, z = there[2] - hz, far = reach + there[3];
                if ((x * x + y * y) + z * z < far * far && j != i)
                    pairs.push_back(NeighbourPair::of(i, j, image));
            }
        };
        consider(i + 1, start[cell + 1], grid.no_image());
        for (int k = 0; k < count; ++k) consider(runs[k].first, runs[k].last, runs[k].image);
    }
}

// Appends the walls that the bodies first … last − 1 may touch while bodies and walls move by less than half the skin.
inline void list_walls(const Box& box, const Records<Double4>& position, std::uint32_t first,
                       std::uint32_t last, double skin, double time, std::vector<WallNeighbour>& walls) {
    for (std::uint32_t i = first; i < last; ++i)
        for (int axis = 0; axis < box.dimension; ++axis) {
            if (!box.has_walls(axis)) continue;
            const double reach = box.has_moving_walls(axis) ? skin : 0.5 * skin;
            const double near = position[i][3] + reach, x = position[i][axis];
            for (const bool high : {false, true})
                if (const Wall wall = box.wall(axis, high); wall.distance(x, time) < near)
                    walls.push_back({i, wall.id});
        }
}

// Optimal skin σ [m]. A wide skin makes the list long, a narrow one makes rebuilds frequent. A body costs
// σ λ + κ 2 v h/σ per step, in units of the cost of one pair: λ is the number of its listed pairs per metre of skin, v
// the largest speed, h the step, κ the cost of a rebuild per body. The minimum is at σ = √(2 v h κ/λ).
inline double best_skin(double pairs_per_skin, double largest_speed, double time_step) {
    constexpr double list_cost = 40.0;  // κ, measured at packing fractions of 0.3 and 0.6
    return math::sqrt(2.0 * largest_speed * time_step * list_cost / pairs_per_skin);
}

}  // namespace hardlimit::boxes
