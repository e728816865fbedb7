// The cells of the bodies: neighbours of a body, and cell crossings.
//
// The images of bodies beyond a Lees–Edwards boundary move along the first axis. A search there moves the body to the
// frame of the images, and then reads their cells like any others.
#pragma once
#include <vector>

#include "../neighbours/cell_order.hpp"
#include "../neighbours/cells.hpp"
#include "paths.hpp"

namespace hardlimit::boxes::events {

struct Block {
    Place<3> from, to;
};

// All bodies lie in one grid. During an isolated contact, a body's position on its outgoing path may lie outside of its
// cell by the safety radius.
template <class Law>
class BodyCells {
public:
    // A body's new cell, the cells that become its neighbours, and what the boundary does on it [J].
    struct Crossing {
        Place<3> to;
        Block beyond;
        double shear_work = 0.0;
    };

    BodyCells(const NewtonSetting& setting, double shortest_cell, Paths<Law>& paths) : paths_(paths) {
        if (box_.dimension == 2) cell_box_.edge[2] = shortest_cell;
        cell_box_.dimension = 3;
        cells_ = Cells<3>(cell_box_, setting.count(), shortest_cell, shortest_cell);
        level_ = cells_.level_for(shortest_cell);
        several_images_ = grid().few;
        for (int a = 0; a < box_.dimension; ++a)
            several_images_ = several_images_ || (box_.wraps(a) && grid().cells[a] < 4);
    }

    const Cells<3>& cells() const { return cells_; }
    const Box& box() const { return cell_box_; }  // one cell deep in two dimensions
    int level() const { return level_; }
    const Grid<3>& grid() const { return cells_.grids()[static_cast<std::size_t>(level_)]; }
    bool several_images() const { return several_images_; }  // whether several images of a body may be near
    Place<3> place(int i) const { return cells_.place(level_, paths_.pending[i].cell); }

    // Stores the bodies of a system sorted by cell.
    void sort_in(const NewtonSetting& setting, const System& s) {
        std::vector<u32> cell(s.n);
        for (std::size_t i = 0; i < s.n; ++i) {
            double x[3];
            setting.in_three(s.position, i, x);
            cells_.fold(box_, x);
            cell[i] = cells_.number(level_, cells_.place_of(level_, x));
        }
        const std::vector<u32> order = order_by_cell(cell);
        paths_.sort_in(setting, s, order);
        put_in_anew();
    }
    void put_in() {
        cells_.clear();
        for (int i = 0; i < paths_.size(); ++i) cells_.insert(paths_.pending[i].cell, static_cast<u32>(i));
    }

    // The block of cells around a cell. Set element by element: wider loads after these stores would stall.
    Block around(const Place<3>& at) const {
        const int deep = box_.dimension == 3 ? 1 : 0;
        return {{at[0] - 1, at[1] - 1, at[2] - deep}, {at[0] + 1, at[1] + 1, at[2] + deep}};
    }
    // Calls f(block, image) for a block, whose cells beyond a sheared side are left out, and for its parts there. The
    // bodies in the cells of `block` are in the frame of `in` after `image` has been added to them.
    template <class F>
    void for_sides(const Block& in, const F& f) const {
        f(in, ImageMotion{});
        cells_.for_sheared_parts(box_, level_, in.from, in.to, paths_.now,
                                 [&](const Place<3>& from, const Place<3>& to, const ImageMotion& image) {
                                     f(Block{from, to}, image);
                                 });
    }
    // Calls f(j, r, v) for all images of bodies in the cells around body i. r: vector from i to j at the current time;
    // v: what the image adds to the velocity of j.
    template <class F>
    void for_neighbours(int i, const F& f) const {
        if (ids_.size() < cells_.room()) ids_.resize(cells_.room());
        const Vector3 x = paths_.position(i, paths_.now);
        for_sides(around(place(i)), [&](const Block& in, const ImageMotion& image) {
            cells_.for_block(cell_box_, level_, in.from, in.to, [&](u32 cell, const double (&shift)[3]) {
                const std::size_t n = cells_.collect(cell, ids_, 0);
                for (std::size_t k = 0; k < n; ++k) {
                    const int j = static_cast<int>(ids_[k]);
                    if (j == i) continue;
                    Vector3 r = paths_.position(j, paths_.now);
                    for (std::size_t a = 0; a < 3; ++a) r[a] = (r[a] + (shift[a] + image.shift[a])) - x[a];
                    f(j, r, image.velocity);
                }
            });
        });
    }

    // Moves body i, which leaves its cell, into the next one.
    Crossing cross(int i) {
        BodyEvents& e = paths_.pending[i];
        const SelfEvent own = static_cast<SelfEvent>(e.own);
        const int axis = axis_of(own), step = is_high(own) ? 1 : -1, cells = grid().cells[axis];
        Crossing crossing;
        Place<3>& at = crossing.to = cells_.place(level_, e.cell);
        cells_.remove(e.cell, static_cast<u32>(i));
        at[axis] += step;
        if (at[axis] < 0 || at[axis] == cells) {
            at[axis] -= step * cells;
            if (box_.slides(axis)) {
                crossing.shear_work = cross_sheared_side(i, step);
                wrap(i, 0, cells_.displace(level_, at[0], -step));
            } else {
                wrap(i, axis, step);
            }
        }
        e.cell = cells_.number(level_, at) & (most_cells - 1);
        cells_.insert(e.cell, static_cast<u32>(i));
        crossing.beyond = around(at);
        crossing.beyond.from[axis] = crossing.beyond.to[axis] = at[axis] + step;
        return crossing;
    }

    // In a sheared box the columns of cells are tilted. At this time [s] they must be tilted back, against the flow,
    // which gives all bodies new cells.
    double next_tilt() const { return cells_.next_tilt(); }
    void tilt_back() {
        cells_.tilt_back();
        put_in_anew();
    }
    double columns() const { return cells_.columns(); }
    void set_columns(double columns) { cells_.set_columns(columns); }

    std::size_t bytes() const { return cells_.bytes() + ids_.capacity() * sizeof(u32); }

private:
    Paths<Law>& paths_;
    const Box& box_ = paths_.box;
    Box cell_box_ = paths_.box;
    Cells<3> cells_;
    int level_ = 0;
    bool several_images_ = false;
    mutable Scratch<u32> ids_;

    void wrap(int i, int axis, int step) {
        Particle<3>& p = paths_.particles[i];
        box_.wrap(p.position, p.velocity, paths_.pending[i].image_flags, axis, step, p.time);
    }
    // Moves body i, which has left through the sheared side, to its image in the box. Returns the work on it [J], which
    // is counted with its group if it is busy.
    double cross_sheared_side(int i, int step) {
        const double before = paths_.velocity(i, paths_.now)[0];
        wrap(i, box_.gradient, step);
        if (!paths_.free(i)) return 0.0;
        return gained_energy(paths_.mass(i), before, -(step * box_.image_velocity()));
    }
    // Puts every body into the cell where it is.
    void put_in_anew() {
        for (int i = 0; i < paths_.size(); ++i) {
            const Vector3 now = paths_.position(i, paths_.now);
            double x[3] = {now[0], now[1], now[2]};
            if (const int turns = cells_.fold(box_, x, paths_.now)) wrap(i, 0, turns);
            paths_.pending[i].cell =
                cells_.number(level_, cells_.place_of(level_, x, paths_.now)) & (most_cells - 1);
        }
        put_in();
    }
};

}  // namespace hardlimit::boxes::events
