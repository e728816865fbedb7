// Construction of the event-driven engine, and its cells: neighbours of a body, cell crossings.
#pragma once
#include "engine.hpp"

namespace hardlimit::boxes {

template <class Law>
NewtonEvents<Law>::NewtonEvents(const NewtonSetting& setting, const System& s,
                                const hardlimit_abi::TouchKernels& kernels)
    : setting_(setting),
      laws_(setting_.laws<Law>()),
      soft_(soft_contacts(laws_, s.n, kernels)),
      gravity_(std::to_array(box_.gravity)) {
    find_extreme_radii(s.n);
    largest_safety_radius_ = initial_safety_radius(s);
    make_cells(s.n, kernels);
    sort_in(s);
    const std::vector<int> touching = predict_first_events();
    if (begin_contacts(touching)) {
        for (int i = 0; i < static_cast<int>(s.n); ++i)
            if (free(i)) predict_events(i);
    } else {
        for (const int i : touching) predict_events(i);
    }
    restart_calendar_queue();
}

template <class Law>
void NewtonEvents<Law>::find_extreme_radii(std::size_t n) {
    for (std::size_t i = 0; i < n; ++i) {
        largest_radius_ = math::max(largest_radius_, laws_.radius(i));
        smallest_radius_ = math::min(smallest_radius_, laws_.radius(i));
    }
}

// A multiple of the compression of contacts at the initial speeds of bodies, relative to a sheared flow, and of walls.
// A larger radius requires wider cells, which hold more candidates. The largest value under gravity, since speeds grow.
template <class Law>
double NewtonEvents<Law>::initial_safety_radius(const System& s) const {
    const double most = 0.1 * largest_radius_;
    if (dot(gravity_, gravity_) > 0.0) return most;
    double square = 0.0;
    std::size_t at = 0;
    const std::size_t n = setting_.count();
    for (std::size_t i = 0; i < n; ++i) {
        double x[3]{}, v[3]{};
        setting_.in_three(s.position, i, x);
        setting_.in_three(s.velocity, i, v);
        if (box_.is_sheared()) v[0] -= box_.mean_flow(x[box_.gradient]);
        square += dot(v, v);
    }
    for (std::size_t i = 0; i < n; ++i)
        if (laws_.radius(i) == largest_radius_) at = i;
    const double of_shear = math::abs(box_.shear_rate) * largest_radius_;
    const double speed = math::max(math::sqrt(square / static_cast<double>(n)),
                                   math::max(2.0 * box_.fastest_wall(), of_shear));
    if (!(speed > 0.0)) return most;
    const auto body = static_cast<std::int64_t>(at);
    const double duration = laws_(body, body).duration(speed, 0.5 * laws_.mass(at));
    return math::clamp(2.0 * speed * duration, 0.005 * largest_radius_, most);
}

template <class Law>
double NewtonEvents<Law>::smallest_edge() const {
    double least = math::infinity;
    for (int axis = 0; axis < box_.dimension; ++axis)
        if (box_.wraps(axis)) least = math::min(least, box_.edge[axis]);
    return least;
}

// All bodies lie in one grid. During an isolated contact, a body's position on its outgoing path may lie outside of its
// cell by the safety radius.
template <class Law>
void NewtonEvents<Law>::make_cells(std::size_t n, const hardlimit_abi::TouchKernels& kernels) {
    series_ = &kernels.series;
    touch_ = kernels.enlarged[dot(gravity_, gravity_) > 0.0 ? 1 : 0];
    const double most = 2.001 * (largest_radius_ + 2.0 * largest_safety_radius_);
    if (box_.is_sheared()) cell_box_.shear(box_.gradient, box_.shear_rate, box_.shear_displacement);
    query_.others = 1.0;
    for (int a = 0; a < 3; ++a) {
        const bool used = a < box_.dimension;
        cell_box_.edge[a] = used ? box_.edge[a] : most;
        cell_box_.boundary[a] = box_.boundary[a];
        query_.edge[a] = box_.edge[a];
        query_.per_edge[a] = cell_box_.is_periodic(a) ? 1.0 / box_.edge[a] : 0.0;
        query_.gravity[a] = box_.gravity[a];
        query_.half_gravity[a] = 0.5 * box_.gravity[a];
    }
    cells_ = Cells<3>(cell_box_, n, most, most);
    level_ = cells_.level_for(most);
    prefetches_ = n > most_in_caches;
    // R/4 limits the number of pairs in a cluster. In a small box, no second image of a body may come near while a
    // group lasts: it is at least L/2 away along its axis, and both bodies move by D, so L/2 − 2 D > 2 R. This bound,
    // D < 0.25 L − R, is lowered by 0.03 L − 0.1 R, positive in every box that this engine accepts (L >= 4.2 R).
    largest_displacement_ =
        math::min(0.25 * smallest_radius_, 0.22 * smallest_edge() - 0.9 * largest_radius_);
    several_images_ = grid().few;
    for (int a = 0; a < box_.dimension; ++a) {
        several_images_ = several_images_ || (box_.wraps(a) && grid().cells[a] < 4);
        walled_ = walled_ || box_.has_walls(a);
    }
}

// Stores the bodies sorted by cell, so that neighbours in space are neighbours in memory.
template <class Law>
void NewtonEvents<Law>::sort_in(const System& s) {
    const auto n = static_cast<u32>(s.n);
    std::vector<u32> cell(n);
    std::vector<int> turns(box_.is_sheared() ? n : 0);
    for (u32 i = 0; i < n; ++i) {
        double x[3];
        setting_.in_three(s.position, i, x);
        if (box_.is_sheared()) x[0] -= (turns[i] = box_.turns(cells_.along(x, 0.0), 0)) * box_.edge[0];
        cell[i] = cells_.number(level_, cells_.place_of(level_, x));
    }
    const std::vector<u32> order = order_by_cell(cell);
    particles_.resize(n);
    pending_.resize(n);
    laws_.reorder(order);
    for (u32 i = 0; i < n; ++i) {
        const u32 from = order[i];
        Particle<3>& p = particles_[i];
        setting_.in_three(s.position, from, p.position);
        setting_.in_three(s.velocity, from, p.velocity);
        p.time = 0.0;
        p.radius = radius(static_cast<int>(i));
        pending_[i].original_index = from;
        if (box_.is_sheared())
            box_.wrap(p.position, p.velocity, pending_[i].image_flags, 0, turns[from], 0.0);
        pending_[i].cell = cell[from] & (most_cells - 1);
    }
    put_into_cells();
}

template <class Law>
void NewtonEvents<Law>::put_into_cells() {
    cells_.clear();
    for (u32 i = 0; i < size32(); ++i) cells_.insert(pending_[i].cell, i);
}

template <class Law>
void NewtonEvents<Law>::restart_calendar_queue() {
    calendar_queue_.rebuild(size32(), [this](u32 id) { return pending_[id].time(); }, by_original_index());
}

template <class Law>
void NewtonEvents<Law>::reserve_candidates() const {
    if (times_.size() >= cells_.room()) return;
    times_.resize(cells_.room());
    candidates_.resize(cells_.room());
}

// The block of cells around a cell. Set element by element: wider loads after these stores would stall.
template <class Law>
typename NewtonEvents<Law>::Block NewtonEvents<Law>::around(const Place<3>& at) const {
    const int deep = box_.dimension == 3 ? 1 : 0;
    return {{at[0] - 1, at[1] - 1, at[2] - deep}, {at[0] + 1, at[1] + 1, at[2] + deep}};
}

// Calls f(j, r, v) for all images of bodies in the cells around body i. r: vector from i to j at the current time; v:
// what the image adds to the velocity of j.
template <class Law>
template <class F>
void NewtonEvents<Law>::for_neighbours(int i, const F& f) const {
    reserve_candidates();
    const Block near = around(cells_.place(level_, pending_[i].cell));
    const Vector3 x = position(i, now_);
    for_sides(near, [&](const Block& in, const ImageMotion& image) {
        cells_.for_block(cell_box_, level_, in.from, in.to, [&](u32 cell, const double (&shift)[3]) {
            const std::size_t n = cells_.collect(cell, candidates_, 0);
            for (std::size_t k = 0; k < n; ++k) {
                const int j = static_cast<int>(candidates_[k]);
                if (j == i) continue;
                Vector3 r = position(j, now_);
                for (std::size_t a = 0; a < 3; ++a) r[a] = (r[a] + (shift[a] + image.shift[a])) - x[a];
                f(j, r, image.velocity);
            }
        });
    });
}

// Moves the body into the next cell and predicts collisions in the cells that become neighbours.
template <class Law>
void NewtonEvents<Law>::leave_cell(int i) {
    BodyEvents& e = pending_[i];
    const SelfEvent own = static_cast<SelfEvent>(e.own);
    const int axis = axis_of(own), step = is_high(own) ? 1 : -1;
    const Grid<3>& g = cells_.grids()[static_cast<std::size_t>(level_)];
    Place<3> at = cells_.place(level_, e.cell);
    cells_.remove(e.cell, static_cast<u32>(i));
    at[axis] += step;
    if (at[axis] < 0 || at[axis] == g.cells[axis]) {
        at[axis] -= step * g.cells[axis];
        int along = axis, turns = step;
        if (box_.is_sheared() && axis == box_.gradient) {
            cross_sheared_side(i, step);
            along = 0, turns = cells_.displace(level_, at[0], -step);
        }
        Particle<3>& p = particles_[i];
        box_.wrap(p.position, p.velocity, e.image_flags, along, turns, p.time);
    }
    e.cell = cells_.number(level_, at) & (most_cells - 1);
    cells_.insert(e.cell, static_cast<u32>(i));
    Block beyond = around(at);
    beyond.from[axis] = beyond.to[axis] = at[axis] + step;
    set_query(i);
    predict_collisions(i, beyond);
    predict_self_event(i, at);
    schedule(i);
}

}  // namespace hardlimit::boxes
