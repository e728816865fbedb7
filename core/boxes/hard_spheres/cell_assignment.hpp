// In which cell each particle is, and how it comes into another one.
#pragma once
#include <vector>

#include "../neighbours/cell_order.hpp"
#include "../neighbours/cells.hpp"
#include "observe.hpp"

namespace hardlimit::boxes::spheres {

template <int d, bool mixed>
class CellAssignment {
public:
    CellAssignment(Particles<d, mixed>& particles, Totals<d, mixed>& totals)
        : particles_(particles), totals_(totals) {}

    // Stores the particles of a new run, sorted by cell, so that neighbours in space are neighbours in memory.
    void begin(const System& s) {
        lay(s.n);
        columns_ = cells_.columns();
        const u32 n = static_cast<u32>(s.n);
        std::vector<u32> cell(n);
        double x[d];
        const auto fold = [&](u32 i) {
            std::copy_n(&s.position[std::size_t{i} * d], d, x);
            return cells_.fold(box_, x);
        };
        for (u32 i = 0; i < n; ++i) {
            fold(i);
            const int own = mixed ? cells_.level_for(2.0 * s.radius[i]) : 0;
            cell[i] = cells_.number(own, cells_.place_of(own, x));
        }
        const std::vector<u32> order = order_by_cell(cell);
        particles_.resize(n, has_levels());
        for (u32 i = 0; i < n; ++i) {
            const u32 from = order[i], later = order[std::min(i + 24, n - 1)];
            prefetch(&s.position[std::size_t{later} * d]);
            prefetch(&s.velocity[std::size_t{later} * d]);
            particles_.put(i, s, from);
            if (const int turns = fold(from); turns != 0) particles_.wrap(i, 0, turns);
            particles_.pending[i].cell = cell[from] & (most_cells - 1);
        }
        fill();
    }
    // Makes the cells of a saved run.
    void resume() {
        lay(particles_.size());
        cells_.set_columns(columns_);
        fill();
    }
    // Puts the particles into the cells that `pending` names.
    void fill() {
        cells_.clear();
        for (u32 i = 0; i < particles_.size(); ++i) {
            cells_.insert(particles_.pending[i].cell, i);
            if constexpr (mixed) cells_.note(level(i), 2.0 * particles_.radius(i));
        }
    }

    const Cells<d>& cells() const { return cells_; }
    int level(u32 i) const {
        if constexpr (mixed) return cells_.level_for(2.0 * particles_.radius(i));
        return 0;
    }
    bool has_levels() const { return mixed && cells_.levels() > 1; }
    bool holds_any(int level) const {
        return !mixed || cells_.grids()[static_cast<std::size_t>(level)].widest > 0.0;
    }
    Place<d> place(u32 i) const { return cells_.place(level(i), particles_.pending[i].cell); }

    // Moves a particle through a face of its cell, that at the end of the axis (step 1) or at its begin (−1). Returns
    // its new place.
    Place<d> cross_face(u32 i, int axis, int step) {
        PendingEvents& e = particles_.pending[i];
        const int own = level(i);
        const Grid<d>& g = cells_.grids()[static_cast<std::size_t>(own)];
        Place<d> at = cells_.place(own, e.cell);
        cells_.remove(e.cell, i);
        at[axis] += step;
        if (at[axis] < 0 || at[axis] == g.cells[axis]) {
            at[axis] -= step * g.cells[axis];
            int along = axis, turns = step;
            if (box_.slides(axis)) {
                cross_sheared_side(i, step);
                along = 0, turns = cells_.displace(own, at[0], -step);
            }
            particles_.wrap(i, along, turns);
        }
        e.cell = cells_.number(own, at) & (most_cells - 1);
        cells_.insert(e.cell, i);
        return at;
    }
    // Moves a displaced particle to its new cell.
    void update(u32 i) {
        const Particle<d>& p = particles_.paths[i];
        const int first = box_.is_sheared() ? 1 : 0;  // fold_into_column() wraps along the first axis
        for (int k = d - 1; k >= first; --k)
            while (box_.wraps(k) && (p.position[k] < 0.0 || p.position[k] > box_.edge[k])) {
                const int step = p.position[k] < 0.0 ? -1 : 1;
                if (box_.is_periodic(k))
                    particles_.wrap(i, k, step);
                else
                    cross_sheared_side(i, step);
            }
        const u32 cell = fold_into_column(i);
        PendingEvents& e = particles_.pending[i];
        if (cell == e.cell) return;
        cells_.remove(e.cell, i);
        cells_.insert(cell, i);
        e.cell = cell & (most_cells - 1);
    }
    // Tilts the columns of cells of a sheared box back, against the flow. All particles get new cells.
    void tilt_back() {
        cells_.tilt_back();
        columns_ = cells_.columns();
        for (u32 i = 0; i < particles_.size(); ++i)
            particles_.pending[i].cell = fold_into_column(i) & (most_cells - 1);
        fill();
    }

    template <class Archive>
    void exchange(Archive& a) {
        a(columns_);
    }

private:
    Particles<d, mixed>& particles_;
    Totals<d, mixed>& totals_;
    const Box& box_ = particles_.box;
    Cells<d> cells_;
    double columns_ = 0.0;  // Cells::columns(), for checkpoints

    void lay(std::size_t n) {
        const Setting& s = particles_.setting;
        cells_ = Cells<d>(box_, n, 2.0 * s.smallest_radius, 2.0 * s.largest_radius);
    }
    void cross_sheared_side(u32 i, int step) {
        totals_.cross_sheared_side(i, step);
        if (has_levels()) particles_.note_present_speed(i);
    }
    // Wraps a particle along the first axis of a box, whose columns of cells may be tilted. Returns its cell.
    u32 fold_into_column(u32 i) {
        double x[d];
        for (int k = 0; k < d; ++k) x[k] = particles_.position(i, k);
        if (const int turns = cells_.fold(box_, x, particles_.now)) particles_.wrap(i, 0, turns);
        return cells_.number(level(i), cells_.place_of(level(i), x, particles_.now));
    }
};

}  // namespace hardlimit::boxes::spheres
