// How a particle finds its next event.
#pragma once
#include "engine.hpp"

namespace hardlimit::boxes {

// What is the same in all queries.
template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::prepare_query() {
    query_ = {};
    query_.radius = mixed ? 0.0 : 2.0 * largest_radius_;
    query_.others = mixed ? 1.0 : 0.0;
    query_.share = 1.0;
    query_.rate = growth_.rate;
    for (int k = 0; k < d; ++k) {
        query_.edge[k] = box_.edge[k];
        query_.per_edge[k] = box_.periodic[k] ? 1.0 / box_.edge[k] : 0.0;
        query_.half_gravity[k] = 0.5 * box_.gravity[k];
        query_.gravity[k] = box_.gravity[k];
    }
}

template <int d, Motion motion, bool mixed>
auto HardSpheres<d, motion, mixed>::look(u32 i) -> Look {
    const Particle<d>& p = particles_[i];
    query_.now = now_;
    if constexpr (mixed) query_.radius = radius(i);
    if constexpr (motion == Motion::growing) query_.share = growth_.at(now_);
    for (int k = 0; k < d; ++k) {
        query_.position[k] = position_after<motion>(p, k, now_ - p.time, box_);
        query_.velocity[k] = velocity_after<motion>(p, k, now_ - p.time, box_);
    }
    return Look{i};
}

// Whether the image of a particle that was just examined touches the one that looks, or lies in it. `nearest`: of its
// images the nearest one is meant.
template <int d, Motion motion, bool mixed>
bool HardSpheres<d, motion, mixed>::in_touch(u32 id, bool nearest) const {
    const Particle<d>& p = particles_[id];
    double square = 0.0;
    for (int k = 0; k < d; ++k) {
        double r = position_after<motion>(p, k, now_ - p.time, box_) + query_.shift[k] - query_.position[k];
        if (nearest) r -= query_.edge[k] * math::round_small(r * query_.per_edge[k]);
        square += r * r;
    }
    const double touch = (query_.radius + query_.others * radius(id)) * query_.share;
    return square <= touch * touch * (1.0 + 1e-9);
}

// What a kernel has found among the candidates. Simultaneous ones are told apart by the user's numbers.
template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::examine(Look& look, const hardlimit_abi::Touched& touched, bool nearest) {
    if (!(touched.time <= look.in) || touched.time == math::infinity) return;
    if (touched.time < look.in && !touched.several && touched.id != look.except) {
        look.in = touched.time;
        look.partner = touched.id;
        return;
    }
    for (std::size_t k = 0; k < touched.n; ++k) {
        if (times_[k] > look.in || times_[k] == math::infinity) continue;
        const u32 id = candidates_[k];
        if (id == look.except && in_touch(id, nearest)) continue;
        if (times_[k] < look.in || names_[id] < names_[look.partner]) {
            look.in = times_[k];
            look.partner = id;
        }
    }
}

template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::make_room_for_candidates() {
    if (times_.size() >= cells_.room()) return;
    times_.resize(cells_.room());
    candidates_.resize(cells_.room());
}

template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::search_block(Look& look, int level, const Place<d>& from,
                                                 const Place<d>& to) {
    if (cells_.grids()[static_cast<std::size_t>(level)].few) return search_images(look, level, from, to);
    make_room_for_candidates();
    hardlimit_abi::CellBlock block;
    const bool across = cells_.lay_block(block, box_, level, from, to);
    const auto touch = across ? touch_.across : touch_.near;
    examine(look, touch(query_, particles_.data(), look.id, candidates_.data(), times_.data(), block),
            across);
}

// A block that is so large a part of the box that several images of a particle may lie in it.
template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::search_images(Look& look, int level, const Place<d>& from,
                                                  const Place<d>& to) {
    make_room_for_candidates();
    cells_.for_block(box_, level, from, to, [&](u32 cell, const double (&shift)[d]) {
        for (int k = 0; k < d; ++k) query_.shift[k] = shift[k];
        const std::size_t n = cells_.collect(cell, candidates_, 0);
        examine(look, touch_.listed(query_, particles_.data(), look.id, candidates_.data(), times_.data(), n),
                false);
    });
    for (double& shift : query_.shift) shift = 0.0;
}

template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::keep(const Look& found) {
    Pending& e = pending_[found.id];
    const double time = now_ + found.in;
    if (found.partner == no_particle || time > e.pair_time) return;
    if (time == e.pair_time && e.partner != no_particle && names_[e.partner] < names_[found.partner]) return;
    e.pair_time = time;
    e.partner = found.partner;
    e.partner_count = collisions(found.partner);
}

template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::predict(u32 i, u32 except) {
    predict_unscheduled(i, except);
    schedule(i);
}

// All events of a particle anew.
template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::predict_unscheduled(u32 i, u32 except) {
    Pending& e = pending_[i];
    const int own = level(i);
    const Place<d> at = cells_.place(own, e.cell);
    Look found = look(i);
    found.except = except;
    cells_.for_neighbourhoods(own, at, [&](int level, const Place<d>& from, const Place<d>& to) {
        search_block(found, level, from, to);
    });
    e.pair_time = math::infinity;
    e.partner = no_particle;
    if constexpr (mixed)
        if (own > 0) search_finer(found, own);
    keep(found);
    predict_own(i, at);
}

// Speed now in a frame that falls with gravity along the periodic axes, where a speed would grow for ever.
template <int d, Motion motion, bool mixed>
double HardSpheres<d, motion, mixed>::frame_speed(const double* velocity) const {
    double square = 0.0;
    for (int k = 0; k < d; ++k) {
        const double v = velocity[k] - (box_.periodic[k] ? box_.gravity[k] * now_ : 0.0);
        square += v * v;
    }
    return math::sqrt(square);
}
// A bound of that speed for all particles: between walls a fall gains no more than the height of the box gives.
template <int d, Motion motion, bool mixed>
double HardSpheres<d, motion, mixed>::fastest_possible() const {
    double square = fastest_ * fastest_;
    for (int k = 0; k < d; ++k)
        if (!box_.periodic[k]) square += 2.0 * math::abs(box_.gravity[k]) * box_.edge[k];
    return math::sqrt(square);
}

// Smaller particles may be many: only those that can arrive before the next look are examined.
template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::search_finer(Look& look, int level) {
    double horizon = math::infinity;
    const double speed = frame_speed(query_.velocity) + fastest_possible();
    for (int q = 0; q < level; ++q) {
        const Grid<d>& g = cells_.grids()[q];
        const double margin = 1.5 * g.diameter, reach = query_.radius + 0.5 * g.diameter + margin;
        horizon = math::min(horizon, 0.99 * margin / speed);
        Place<d> from, to;
        for (int k = 0; k < d; ++k) {
            from[k] = floor_of((query_.position[k] - reach) / g.edge[k]);
            to[k] = floor_of((query_.position[k] + reach) / g.edge[k]);
        }
        bool wide = false;
        for (int k = 0; k < d; ++k) wide = wide || to[k] - from[k] > 2;
        if (wide)
            search_images(look, q, from, to);
        else
            search_block(look, q, from, to);
    }
    rescans_[look.id] = now_ + horizon;
}

// Leaves the cell, which is at this place, or meets a wall, whichever comes first.
template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::predict_own(u32 i, const Place<d>& at) {
    Pending& e = pending_[i];
    const Particle<d>& p = particles_[i];
    const int own = level(i);
    const Grid<d>& g = cells_.grids()[static_cast<std::size_t>(own)];
    double in = math::infinity;
    SelfEvent which = SelfEvent::low_x;
    // Without branches: which border is the first, no processor can foresee.
    const auto consider = [&](double time, int axis, bool high) {
        which = time < in ? own_event(axis, high) : which;
        in = math::min(in, time);
    };
    HL_UNROLL
    for (int k = 0; k < d; ++k) {
        const double x = p.position[k], v = p.velocity[k], size = radius(i);
        const double low = at[k] * g.edge[k], high = (at[k] + 1) * g.edge[k];
        const bool walls = motion != Motion::growing && !box_.periodic[k];
        const double lowest = walls && at[k] == 0 ? size : low;
        const double highest = walls && at[k] == g.cells[k] - 1 ? box_.edge[k] - size : high;
        if constexpr (motion == Motion::falling) {
            // From now on: a border passed on the way up is not to be met again in the past.
            for (const bool upper : {true, false}) {
                const bool wall = walls && at[k] == (upper ? g.cells[k] - 1 : 0);
                const double since = (wall ? free_of_wall(i, k, upper) : now_) - p.time;
                const double x_then = position_after<motion>(p, k, since, box_);
                const double v_then = velocity_after<motion>(p, k, since, box_);
                const double pull = box_.gravity[k];
                consider(since + (upper ? time_below(x_then, v_then, pull, highest)
                                        : time_below(-x_then, -v_then, -pull, -lowest)),
                         k, upper);
            }
        } else {
            const double borders[2] = {lowest, highest};
            const bool up = v > 0.0;
            consider(time_to(borders[up] - x, v), k, up);
        }
        if (motion == Motion::growing && !box_.periodic[k]) {
            const double touch = size * growth_.at(p.time), rate = size * growth_.rate;
            if (at[k] == 0) consider(time_below(touch - x, rate - v, 0.0), k, false);
            if (at[k] == g.cells[k] - 1) consider(time_below(x + touch, v + rate, box_.edge[k]), k, true);
        }
    }
    e.own_time = math::max(now_, p.time + in);
    e.own = static_cast<u32>(which) & 7u;
    if constexpr (mixed)
        if (own > 0 && rescans_[i] < e.own_time) {
            e.own_time = rescans_[i];
            e.own = static_cast<u32>(SelfEvent::rescan) & 7u;
        }
}

}  // namespace hardlimit::boxes
