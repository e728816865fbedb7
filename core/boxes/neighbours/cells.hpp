// Hierarchical cell lists: nested grids of cells for particles of different sizes.
//
// A particle is stored in the finest grid whose cells are at least as long as its diameter. Two particles can touch
// only if both positions lie in the same or in neighbouring cells of the larger particle's grid. A cell of one grid is
// 2^d cells of the next finer one, so a face of a coarse cell consists of faces of fine cells. Grids of fewer than
// three cells along an axis are no special case: neighbours are counted by offset, and a periodic image of a particle
// is a separate neighbour.
//
// In a sheared box the columns of cells along the first axis follow the mean flow, so that only the velocity relative
// to it takes a particle to another column (D. P. Hansen and D. J. Evans, Mol. Simul. 13, 375 (1994), use such cells).
// A column is a range of
//   u = x − τ (y − L/2),   τ(t) = (D(t) − c w)/L,
// with the edge L along the gradient axis y, the displacement D of the images beyond its far side, the width w of a
// column and a whole number c of columns. The tilt τ grows at the shear rate, and beyond that side the images are
// displaced by exactly c columns. When |τ| reaches its limit, c changes by a fixed number and all particles are put
// into cells anew. Columns are wide enough that particles which touch are in neighbouring ones at any tilt. Particles
// are folded into 0 ≤ u < edge, so that x is continuous from one column to the next. Blocks leave out the cells beyond
// a sheared side, as beyond a wall; for_sheared_parts() has them.
#pragma once
#include <algorithm>
#include <cstring>
#include <vector>

#include "../common/particle.hpp"
#include "../common/storage.hpp"
#include "../kernels/interface.hpp"

namespace hardlimit::boxes {

// Up to three ids, padded with no_particle, then their number. If there are more ids, `tail` is 4 + the index of the
// spilled cell that holds the rest.
struct Cell {
    u32 id[3];
    u32 tail;
};
static_assert(sizeof(Cell) == 16);

template <int d>
struct Grid {
    int cells[d];     // along each axis
    double edge[d];   // of a cell [m]
    u32 first;        // index of its first cell among the cells of all grids
    double diameter;  // of the largest particle that it can hold [m]
    double widest;    // diameter of the largest particle in it [m], as note() was told; 0: it is empty
    u32 rows[9];      // offsets of the 3 × 3 rows of a block along the first axis from its first row
    u32 planes[3];    // offsets of those rows that differ only in the third coordinate
    u32 steps[d];     // start of each axis in `steps_`
    double columns;   // c, by which the images beyond a sheared side are displaced
    bool few;         // cells along a periodic axis: several images of a neighbour may be near
};

template <int d>
struct Place {
    int at[d];

    int& operator[](int k) { return at[k]; }
    int operator[](int k) const { return at[k]; }
};

template <int d>
class Cells {
public:
    static constexpr std::size_t padding = 128;

    // Grids for `n` particles, the finest first.
    Cells() = default;
    Cells(const Box& box, std::size_t n, double smallest, double largest) {
        lay(box, n, smallest, largest);
        shear_rate_ = box.shear_rate, displacement_ = box.shear_displacement;
        gradient_ = box.gradient, length_ = box.edge[gradient_], middle_ = 0.5 * length_;
        set_columns(math::round_small(displacement_ / grids_.back().edge[0]));
    }

    const std::vector<Grid<d>>& grids() const { return grids_; }
    int levels() const { return static_cast<int>(grids_.size()); }

    int level_for(double diameter) const {
        int level = 0;
        while (level + 1 < levels() && diameter > grids_[level].diameter) ++level;
        return level;
    }

    u32 number(int level, const Place<d>& place) const {
        const Grid<d>& g = grids_[level];
        u32 index = static_cast<u32>(place[d - 1]);
        for (int k = d - 2; k >= 0; --k)
            index = index * static_cast<u32>(g.cells[k]) + static_cast<u32>(place[k]);
        return g.first + index;
    }
    Place<d> place(int level, u32 cell) const {
        const Grid<d>& g = grids_[level];
        u32 index = cell - g.first;
        Place<d> p;
        for (int k = 0; k < d - 1; ++k) {
            const u32 n = static_cast<u32>(g.cells[k]), rest = index / n;
            p[k] = static_cast<int>(index - rest * n);
            index = rest;
        }
        p[d - 1] = static_cast<int>(index);
        return p;
    }
    // Moves a position into the columns of a sheared box at this time: 0 <= along() < edge. Returns the number of edges
    // by which it was moved back along the first axis, 0 without shear.
    int fold(const Box& box, double* position, double time = 0.0) const {
        if (!box.is_sheared()) return 0;
        const int turns = box.turns(along(position, time), 0);
        position[0] -= turns * box.edge[0];
        return turns;
    }
    // In a sheared box the position must be folded.
    Place<d> place_of(int level, const double (&position)[d], double time = 0.0) const {
        const Grid<d>& g = grids_[level];
        Place<d> p;
        for (int k = 0; k < d; ++k) {
            const double x = k == 0 ? along(position, time) : position[k];
            p[k] = static_cast<int>(math::clamp(x / g.edge[k], 0.0, g.cells[k] - 1.0));
        }
        return p;
    }

    // Coordinate u [m] of a position at this time. Without shear it is x.
    double along(const double* position, double time) const {
        return position[0] - tilt(time) * (position[gradient_] - middle_);
    }
    double tilt(double time) const { return tilt_ + shear_rate_ * time; }
    // Half the extent of a ball of this radius along u [m].
    double extent_along(double radius, double time) const { return stretched(radius, tilt(time)); }
    // u of a particle in free flight at (x, y): its value [m], its rate [m/s] and its acceleration [m/s²].
    struct Along {
        double at, rate, acceleration;
    };
    Along along(double x, double y, double v_x, double v_y, double time) const {
        const double steep = tilt(time), height = y - middle_;
        return {x - steep * height, (v_x - steep * v_y) - shear_rate_ * height, -2.0 * shear_rate_ * v_y};
    }
    // The displacement c of the coarsest grid. Every particle must be put into a cell anew after a change.
    double columns() const { return grids_.back().columns; }
    void set_columns(double columns) {
        const double width = grids_.back().edge[0];
        tilt_ = (displacement_ - columns * width) / length_;
        const double limit = 0.5 * step_ * width / length_;
        next_tilt_ = shear_rate_ == 0.0 ? math::infinity
                                        : (shear_rate_ > 0.0 ? limit - tilt_ : -limit - tilt_) / shear_rate_;
        for (int level = levels() - 1; level >= 0; --level, columns *= 2.0) grids_[level].columns = columns;
    }
    // Time at which the tilt reaches its limit [s]; infinity without shear. tilt_back() must be called then.
    double next_tilt() const { return next_tilt_; }
    void tilt_back() { set_columns(columns() + (shear_rate_ > 0.0 ? step_ : -step_)); }
    // Changes the column of a particle that is replaced by its image `count` boxes farther along the gradient axis.
    // Returns the number of edges along the first axis by which the particle has to be moved back.
    int displace(int level, int& column, int count) const {
        const Grid<d>& g = grids_[static_cast<std::size_t>(level)];
        const double moved = column + count * g.columns, turns = math::floor_small(moved / g.cells[0]);
        column = static_cast<int>(moved - turns * g.cells[0]);
        return static_cast<int>(turns);
    }

    void insert(u32 cell, u32 id) {
        Cell* c = &cells_[cell];
        std::size_t links = 1;
        for (; c->tail > inline_ids; ++links) c = &spilled_[c->tail - linked];
        if (c->tail < inline_ids) {
            c->id[c->tail++] = id;
            return;
        }
        const std::ptrdiff_t at =
            c >= spilled_.data() && c < spilled_.data() + spilled_.size() ? c - spilled_.data() : -1;
        const u32 more = new_cell();
        if (at >= 0) c = &spilled_[static_cast<std::size_t>(at)];
        c->tail = linked + more;
        spilled_[more] = {{id, no_particle, no_particle}, 1};
        longest_chain_ = std::max(longest_chain_, links);
    }
    void remove(u32 cell, u32 id) {
        Cell* c = &cells_[cell];
        Cell* before = nullptr;
        u32* found = nullptr;
        for (;;) {
            const u32 held = std::min(c->tail, inline_ids);
            for (u32 k = 0; k < held; ++k)
                if (c->id[k] == id) found = &c->id[k];
            if (c->tail <= inline_ids) break;
            before = c;
            c = &spilled_[c->tail - linked];
        }
        *found = c->id[--c->tail];
        c->id[c->tail] = no_particle;
        if (c->tail == 0 && before) {
            free_.push_back(before->tail - linked);
            before->tail = inline_ids;
        }
    }
    void clear() {
        std::fill(cells_.begin(), cells_.end(), Cell{{no_particle, no_particle, no_particle}, 0});
        spilled_.clear();
        free_.clear();
    }

    // Writes the ids to list[n …] and returns the new n. The list has room for `padding` more ids before and after.
    std::size_t collect(u32 cell, Scratch<u32>& list, std::size_t n) const {
        const Cell* c = &cells_[cell];
        u32* to = list.data() + n;
        to[0] = c->id[0], to[1] = c->id[1], to[2] = c->id[2];
        if (c->tail <= inline_ids) return n + c->tail;
        return collect_chain(c, list, n);
    }
    // Describes a block of at most three cells along each axis to the kernels. Cells beyond a periodic boundary are
    // those of the other side; cells beyond a wall are left out. The block has at most room() ids. Returns whether the
    // block reaches beyond the box.
    bool lay_block(hardlimit_abi::CellBlock& block, const Box& box, int level, const Place<d>& from,
                   const Place<d>& to) const {
        const Grid<d>& g = grids_[static_cast<std::size_t>(level)];
        block.cells = cells_.data() + g.first;
        block.spilled = spilled_.data();
        int outside = 0;
        u32 first = 0;
        HL_UNROLL
        for (int k = d - 1; k >= 0; --k) {
            outside |= from[k] | (g.cells[k] - 1 - to[k]);  // negative if either is
            first = first * static_cast<u32>(g.cells[k]) + static_cast<u32>(from[k]);
        }
        const u32 rows = static_cast<u32>(to[1] - from[1] + 1);
        if (outside < 0 || rows == 2) {
            lay_by_rows(block, g, box, from, to);
            return outside < 0;
        }
        block.parts = 1;
        block.begin[0] = first;
        block.length[0] = static_cast<u32>(to[0] - from[0] + 1);
        block.row = rows == 3 ? g.rows : g.planes;
        block.rows = d == 3 ? rows * static_cast<u32>(to[d - 1] - from[d - 1] + 1) : rows;
        return false;
    }
    std::size_t room(std::size_t cells = 27) const {
        return cells * inline_ids * (longest_chain_ + 1) + padding;
    }

    // Describes the cells within `reach` of a point, all in this block, to the kernels: as rows of up to eight cells.
    // Calls f(block, most ids in it) for each eight. Periodic edges must be longer than 2 reach, so that only the
    // nearest image of a particle is within reach. `rows` is storage.
    template <class F>
    void for_blocks_within(const Box& box, int level, const double* point, double reach, Place<d> from,
                           Place<d> to, std::vector<u32>& rows, const F& f) const {
        const Grid<d>& g = grids_[static_cast<std::size_t>(level)];
        for (int k = 0; k < d; ++k)
            if (!box.is_periodic(k)) from[k] = std::max(from[k], 0), to[k] = std::min(to[k], g.cells[k] - 1);
        // Index of a cell along an axis, and the squared distance between its layer and the point.
        const auto wrapped = [&](int k, int at) {
            return static_cast<u32>(at < 0 ? at + g.cells[k] : at >= g.cells[k] ? at - g.cells[k] : at);
        };
        const auto away = [&](int k, int at) {
            const double low = at * g.edge[k] - point[k], gap = math::max(low, -low - g.edge[k]);
            return gap > 0.0 ? gap * gap : 0.0;
        };
        rows.clear();
        const auto add_plane = [&](u32 plane, double square) {
            for (int y = from[1]; y <= to[1]; ++y)
                if (square + away(1, y) <= reach * reach)
                    rows.push_back((plane + wrapped(1, y)) * static_cast<u32>(g.cells[0]));
        };
        if constexpr (d == 2) {
            add_plane(0, 0.0);
        } else {
            for (int z = from[2]; z <= to[2]; ++z)
                add_plane(wrapped(2, z) * static_cast<u32>(g.cells[1]), away(2, z));
        }
        hardlimit_abi::CellBlock line, block;
        cut(line, from[0], to[0], g.cells[0], box.is_periodic(0));
        block.cells = cells_.data() + g.first;
        block.spilled = spilled_.data();
        block.row = rows.data();
        block.rows = static_cast<u32>(rows.size());
        block.parts = 0;
        for (u32 part = 0; part < line.parts; ++part)
            for (u32 x = 0; x < line.length[part]; x += cells_of_part) {
                if (block.parts == 2) f(block, room(2 * cells_of_part * rows.size())), block.parts = 0;
                block.begin[block.parts] = line.begin[part] + x;
                block.length[block.parts++] = std::min(line.length[part] - x, cells_of_part);
            }
        f(block, room(2 * cells_of_part * rows.size()));
    }
    // Notes that a grid has a particle of this diameter.
    void note(int level, double diameter) {
        double& widest = grids_[static_cast<std::size_t>(level)].widest;
        widest = math::max(widest, diameter);
    }

    // Cells that a particle will search, as offsets from its own: the neighbours, or the layer beyond them on one side.
    struct Stencil {
        int from[3] = {-1, -1, d == 3 ? -1 : 0}, to[3] = {1, 1, d == 3 ? 1 : 0};

        static Stencil beyond(int axis, bool high) {
            Stencil s;
            s.from[axis] = s.to[axis] = high ? 2 : -2;
            return s;
        }
    };
    // Prefetches those cells. Periodic images are not handled: it would not pay.
    void fetch(int level, u32 cell, const Stencil& s) const {
        for_rows(level, cell, s, [](const Cell* row, int length) {
            prefetch(row);
            if (length == 3) prefetch(row + 2);
        });
    }
    // Calls f(id) for the particles in those cells, except spilled ones. Their ids are listed first, without branches:
    // cells hold too few for a loop whose end can be predicted.
    template <class F>
    void for_inline(int level, u32 cell, const Stencil& s, const F& f) const {
        u32 list[27 * inline_ids + 1];
        std::size_t n = 0;
        for_rows(level, cell, s, [&](const Cell* row, int length) {
            for (int x = 0; x < length; ++x) {
                std::memcpy(list + n, &row[x], sizeof(Cell));
                n += std::min(row[x].tail, inline_ids);
            }
        });
        for (std::size_t k = 0; k < n; ++k) f(list[k]);
    }

    // Calls f(cell, shift) for the cells of a block of one grid, which may reach beyond the box: `shift` moves the
    // particles of the cell into the block. Cells beyond a wall are left out.
    template <class F>
    void for_block(const Box& box, int level, const Place<d>& from, const Place<d>& to, const F& f) const {
        const Grid<d>& g = grids_[static_cast<std::size_t>(level)];
        Place<d> at = from;
        for (;;) {
            Place<d> cell = at;
            int flags[d] = {};
            bool inside = true;
            for (int k = 0; k < d; ++k) {
                while (cell[k] < 0) cell[k] += g.cells[k], --flags[k];
                while (cell[k] >= g.cells[k]) cell[k] -= g.cells[k], ++flags[k];
                inside = inside && (box.is_periodic(k) || flags[k] == 0);
            }
            double shift[d];
            const ImageMotion image = box.image(flags, 0.0);
            for (int k = 0; k < d; ++k) shift[k] = image.shift[k];
            if (inside) f(number(level, cell), shift);
            int k = 0;
            for (; k < d && at[k] == to[k]; ++k) at[k] = from[k];
            if (k == d) return;
            ++at[k];
        }
    }
    // Calls f(from, to, image) for each part of a block that lies beyond a side of a sheared box, at a time [s]: the
    // cells in the box whose particles are there, moved by this image. They may reach beyond the far side of the first
    // axis.
    template <class F>
    void for_sheared_parts(const Box& box, int level, const Place<d>& from, const Place<d>& to, double time,
                           const F& f) const {
        const Grid<d>& g = grids_[static_cast<std::size_t>(level)];
        const int axis = box.gradient, rows = g.cells[axis];
        if (!box.is_sheared() || (from[axis] >= 0 && to[axis] < rows)) return;
        const int last = floor_to_int(static_cast<double>(to[axis]) / rows);
        for (int count = floor_to_int(static_cast<double>(from[axis]) / rows); count <= last; ++count) {
            if (count == 0) continue;
            Place<d> low = from, high = to;
            low[axis] = std::max(from[axis] - count * rows, 0);
            high[axis] = std::min(to[axis] - count * rows, rows - 1);
            displace(level, low[0], -count);
            high[0] = low[0] + (to[0] - from[0]);
            ImageMotion image{};
            image.shift[axis] = count * box.edge[axis];
            image.shift[0] = count * (tilt(time) * length_) + (from[0] - low[0]) * g.edge[0];
            image.velocity[0] = count * box.image_velocity();
            f(low, high, image);
        }
    }
    // Calls f(level, from, to) for the block around a cell, in its own grid and in each coarser one.
    template <class F>
    void for_stencils(int level, Place<d> at, const F& f) const {
        Place<d> from, to;
        for (; level < levels(); ++level) {
            for (int k = 0; k < d; ++k) from[k] = at[k] - 1, to[k] = at[k] + 1, at[k] >>= 1;
            f(level, from, to);
        }
    }
    const Cell* data() const { return cells_.data(); }

    std::size_t bytes() const {
        return cells_.capacity() * sizeof(Cell) + spilled_.capacity() * sizeof(Cell) +
               (free_.capacity() + steps_.capacity()) * sizeof(u32);
    }

private:
    static constexpr u32 inline_ids = 3, linked = 4, cells_of_part = 4;
    // A smaller limit needs more changes of c, a larger one wider columns.
    static constexpr double largest_tilt = 0.5;
    static constexpr u32 beyond = 3;  // empty cells at the end, for a kernel that reads four cells at once

    // A block of three cells, of which at least one is in the box, reaches at most this far beyond the box.
    static constexpr int steps_beyond = 2;

    std::vector<Grid<d>> grids_;
    std::vector<u32> steps_;
    Records<Cell> cells_;
    std::vector<Cell> spilled_;
    std::vector<u32> free_;          // unused cells of `spilled_`
    std::size_t longest_chain_ = 0;  // spilled cells of one cell
    // Of a sheared box; without shear u is x.
    double shear_rate_ = 0.0, displacement_ = 0.0;  // [1/s], D at time 0 [m]
    double length_ = 0.0, middle_ = 0.0;            // L and L/2 [m]
    int gradient_ = 0;
    double tilt_ = 0.0;                  // at time 0
    double step_ = 0.0;                  // by which c changes
    double next_tilt_ = math::infinity;  // [s]

    void lay_by_rows(hardlimit_abi::CellBlock& block, const Grid<d>& g, const Box& box, const Place<d>& from,
                     const Place<d>& to) const {
        block.rows = 0;
        block.row = block.own_rows;
        const u32* const along_y = steps_.data() + g.steps[1] + steps_beyond;
        const auto add_rows = [&](u32 plane) {
            for (int y = from[1]; y <= to[1]; ++y)
                if (along_y[y] != no_particle) block.own_rows[block.rows++] = plane + along_y[y];
        };
        if constexpr (d == 2) {
            add_rows(0);
        } else {
            const u32* const along_z = steps_.data() + g.steps[2] + steps_beyond;
            for (int z = from[2]; z <= to[2]; ++z)
                if (along_z[z] != no_particle) add_rows(along_z[z]);
        }
        cut(block, from[0], to[0], g.cells[0], box.is_periodic(0));
    }
    // Index offsets of the cells along each axis. Beyond a periodic boundary they are those of the other side, beyond a
    // wall no_particle.
    void lay_steps(Grid<d>& g, const Box& box) {
        u32 stride = 1;
        for (int k = 0; k < d; ++k) {
            const int n = g.cells[k];
            g.steps[k] = static_cast<u32>(steps_.size());
            for (int at = -steps_beyond; at < n + steps_beyond; ++at) {
                const bool inside = at >= 0 && at < n;
                const int wrapped = ((at % n) + n) % n;
                steps_.push_back(inside || box.is_periodic(k) ? static_cast<u32>(wrapped) * stride
                                                              : no_particle);
            }
            stride *= static_cast<u32>(n);
        }
    }
    // Splits a row along the first axis into one or two parts, at a periodic boundary.
    static void cut(hardlimit_abi::CellBlock& block, int from, int to, int cells, bool periodic) {
        const auto part = [&](int first, int last) {
            block.begin[block.parts] = static_cast<u32>(first);
            block.length[block.parts++] = static_cast<u32>(last - first + 1);
        };
        block.parts = 0;
        if (from < cells && to >= 0) part(std::max(from, 0), std::min(to, cells - 1));
        if (from < 0 && periodic) part(from + cells, std::min(to, -1) + cells);
        if (to >= cells && periodic) part(std::max(from, cells) - cells, to - cells);
    }

    // Calls f(first cell, number of cells) for each row. Skips rows outside the array of cells.
    template <class F>
    void for_rows(int level, u32 cell, const Stencil& s, const F& f) const {
        const Grid<d>& g = grids_[static_cast<std::size_t>(level)];
        const i64 row = g.cells[0], plane = d == 3 ? row * g.cells[1] : 0;
        const int length = s.to[0] - s.from[0] + 1;
        const i64 most = static_cast<i64>(cells_.size()) - length;
        for (int z = s.from[2]; z <= s.to[2]; ++z)
            for (int y = s.from[1]; y <= s.to[1]; ++y) {
                const i64 first = static_cast<i64>(cell) + s.from[0] + y * row + z * plane;
                if (first >= 0 && first <= most) f(cells_.data() + first, length);
            }
    }

    u32 new_cell() {
        if (free_.empty()) {
            spilled_.push_back({});
            return static_cast<u32>(spilled_.size() - 1);
        }
        const u32 last = free_.back();
        free_.pop_back();
        return last;
    }

    std::size_t collect_chain(const Cell* c, Scratch<u32>& list, std::size_t n) const {
        for (;;) {
            if (list.size() < n + padding) list.resize(2 * n + padding);
            for (u32 k = 0; k < inline_ids; ++k) list[n + k] = c->id[k];
            n += std::min(c->tail, inline_ids);
            if (c->tail <= inline_ids) return n;
            c = &spilled_[c->tail - linked];
        }
    }

    // The cells of the coarsest grid are as long as the largest diameter, or longer if there would be more than two per
    // particle. Finer grids are added while there are smaller particles, up to the same number of cells.
    void lay(const Box& box, std::size_t n, double smallest, double largest) {
        const double most = math::min(2.0 * static_cast<double>(n) + 32.0, 0.7 * most_cells);
        double edge = largest;
        Grid<d> coarse = grid(box, edge);
        while (count(coarse) > most) coarse = grid(box, edge *= 1.05);
        coarse.diameter = largest;
        step_ = step_of(box, coarse);
        const double steepest = tilt_limit(box, coarse), stretch = stretched(1.0, steepest);
        grids_ = {coarse};
        for (;;) {
            Grid<d> g = grids_.back();
            double shortest = math::infinity;
            for (int k = 0; k < d; ++k) {
                g.cells[k] *= 2;
                g.edge[k] *= 0.5;
                shortest = std::min(shortest, k == 0 ? g.edge[0] / stretch : g.edge[k]);
            }
            if (shortest < smallest || count(g) > most) break;
            g.diameter = shortest;
            grids_.push_back(g);
        }
        std::reverse(grids_.begin(), grids_.end());
        u32 first = 0;
        for (Grid<d>& g : grids_) {
            g.first = first;
            g.few = false;
            // With four cells, every image but the nearest is more than two cells away. Tilted rows are displaced.
            for (int k = 0; k < d; ++k) {
                const double rows = k == 0 ? 4.0 * steepest * g.edge[box.gradient] / g.edge[0] : 0.0;
                g.few = g.few || (box.is_periodic(k) && g.cells[k] < 4.0 + rows);
            }
            lay_steps(g, box);
            first += static_cast<u32>(count(g));
            const u32 row = static_cast<u32>(g.cells[0]),
                      plane = d == 3 ? row * static_cast<u32>(g.cells[1]) : 0;
            for (u32 z = 0; z < 3; ++z) {
                g.planes[z] = z * plane;
                for (u32 y = 0; y < 3; ++y) g.rows[3 * z + y] = z * plane + y * row;
            }
        }
        cells_.resize(first + beyond);
        clear();
    }
    static Grid<d> grid(const Box& box, double edge) {
        Grid<d> g{};
        for (int k = 0; k < d; ++k) {
            const double least = k == 0 && box.is_sheared() ? stretched(edge, largest_tilt) : edge;
            g.cells[k] = std::max(1, static_cast<int>(math::min(box.edge[k] / least, 1e9)));
            // Rounding must not make a cell shorter than a diameter.
            if (g.cells[k] > 1 && box.edge[k] / g.cells[k] < least) --g.cells[k];
            g.edge[k] = box.edge[k] / g.cells[k];
            // In a low box a single column may be more than the largest tilt. It is then |τ| = ½ g.edge/Ly, and
            // the cell long enough from edge/√(1 − (½ edge/Ly)²) on.
            const auto short_of_tilt = [&] {
                return k == 0 && g.cells[k] > 1 && g.edge[k] < stretched(edge, tilt_limit(box, g));
            };
            if (short_of_tilt()) {
                const double half = 0.5 * edge / box.edge[box.gradient];
                const double most = box.edge[k] / edge * math::sqrt(math::max(0.0, 1.0 - half * half));
                g.cells[k] = std::min(g.cells[k], static_cast<int>(math::min(most, 1e9)) + 2);
                g.edge[k] = box.edge[k] / g.cells[k];
            }
            while (short_of_tilt()) g.edge[k] = box.edge[k] / --g.cells[k];
        }
        return g;
    }
    // Width of a tilted column in which particles of this diameter touch those of the next columns only [m].
    static double stretched(double diameter, double tilt) { return diameter * math::sqrt(1.0 + tilt * tilt); }
    // Number of columns by which the displacement c changes at a time, and the largest |τ| that this requires.
    static double step_of(const Box& box, const Grid<d>& g) {
        return math::max(1.0, math::floor_small(2.0 * largest_tilt * box.edge[box.gradient] / g.edge[0]));
    }
    static double tilt_limit(const Box& box, const Grid<d>& g) {
        return box.is_sheared() ? 0.5 * step_of(box, g) * g.edge[0] / box.edge[box.gradient] : 0.0;
    }
    static double count(const Grid<d>& g) {
        double product = 1.0;
        for (int k = 0; k < d; ++k) product *= g.cells[k];
        return product;
    }
};

}  // namespace hardlimit::boxes
