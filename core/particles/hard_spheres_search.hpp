// How a particle finds its next event.
#pragma once
#include "hard_spheres.hpp"

namespace hardlimit::particles {

template <int d, Motion motion, bool mixed>
auto HardSpheres<d, motion, mixed>::look(u32 i) const -> Look {
    const Particle<d>& p = particles_[i];
    Look look{};
    hardlimit_abi::TouchQuery& q = look.query;
    look.id = i;
    q.now = now_;
    q.radius = radius(i);
    q.share = growth_.at(now_);
    q.rate = growth_.rate;
    for (int k = 0; k < d; ++k) {
        q.position[k] = position_after<motion>(p, k, now_ - p.time, box_);
        q.velocity[k] = velocity_after<motion>(p, k, now_ - p.time, box_);
        q.edge[k] = box_.edge[k];
        q.half_gravity[k] = 0.5 * box_.gravity[k];
        q.gravity[k] = box_.gravity[k];
    }
    return look;
}

// Whether the image of a particle that was just examined touches the one that looks, or lies in it.
template <int d, Motion motion, bool mixed>
bool HardSpheres<d, motion, mixed>::in_touch(const Look& look, u32 id) const {
    const hardlimit_abi::TouchQuery& q = look.query;
    const Particle<d>& p = particles_[id];
    double square = 0.0;
    for (int k = 0; k < d; ++k) {
        const double r = position_after<motion>(p, k, now_ - p.time, box_) + q.shift[k] - q.position[k];
        const double nearest = r - q.edge[k] * math::round_small(r * q.per_edge[k]);
        square += nearest * nearest;
    }
    const double touch = (q.radius + radius(id)) * q.share;
    return square <= touch * touch * (1.0 + 1e-9);
}

// What a kernel has found among the candidates. Simultaneous ones are told apart by the user's numbers.
template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::examine(Look& look, const hardlimit_abi::Touched& touched) {
    if (!(touched.time <= look.in) || touched.time == math::infinity) return;
    if (touched.time < look.in && !touched.several && touched.id != look.except) {
        look.in = touched.time;
        look.partner = touched.id;
        return;
    }
    for (std::size_t k = 0; k < touched.n; ++k) {
        if (times_[k] > look.in || times_[k] == math::infinity) continue;
        const u32 id = candidates_[k];
        if (id == look.except && in_touch(look, id)) continue;
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
    const Grid<d>& g = cells_.grids()[static_cast<std::size_t>(level)];
    for (int k = 0; k < d; ++k)
        // With four cells an image that is not the nearest one is more than two cells away.
        if (to[k] - from[k] > 2 || (box_.periodic[k] && g.cells[k] < 4))
            return search_images(look, level, from, to);
    make_room_for_candidates();
    hardlimit_abi::CellBlock block;
    const bool across = cells_.lay_block(block, box_, level, from, to);
    if (across)
        for (int k = 0; k < d; ++k) look.query.per_edge[k] = box_.periodic[k] ? 1.0 / box_.edge[k] : 0.0;
    const auto touch = across ? touch_.across : touch_.near;
    examine(look, touch(look.query, particles_.data(), look.id, candidates_.data(), times_.data(), block));
    if (across)
        for (double& per_edge : look.query.per_edge) per_edge = 0.0;
}

// A block that is so large a part of the box that several images of a particle may lie in it.
template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::search_images(Look& look, int level, const Place<d>& from,
                                                  const Place<d>& to) {
    make_room_for_candidates();
    cells_.for_block(box_, level, from, to, [&](u32 cell, const double (&shift)[d]) {
        for (int k = 0; k < d; ++k) look.query.shift[k] = shift[k];
        const std::size_t n = cells_.collect(cell, candidates_, 0);
        examine(look,
                touch_.listed(look.query, particles_.data(), look.id, candidates_.data(), times_.data(), n));
    });
    for (double& shift : look.query.shift) shift = 0.0;
}

template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::keep(const Look& found) {
    Pending& e = pending_[found.id];
    const double time = now_ + found.in;
    if (found.partner == nobody || time > e.pair_time) return;
    if (time == e.pair_time && e.partner != nobody && names_[e.partner] < names_[found.partner]) return;
    e.pair_time = time;
    e.partner = found.partner;
    e.partner_count = pending_[found.partner].count;
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
    Look found = look(i);
    found.except = except;
    cells_.for_neighbourhoods(own, e.cell, [&](int level, const Place<d>& from, const Place<d>& to) {
        search_block(found, level, from, to);
    });
    e.pair_time = math::infinity;
    e.partner = nobody;
    if constexpr (mixed)
        if (own > 0) search_finer(found, own);
    keep(found);
    predict_own(i);
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
    const double speed = frame_speed(look.query.velocity) + fastest_possible();
    for (int q = 0; q < level; ++q) {
        const Grid<d>& g = cells_.grids()[q];
        const double margin = 1.5 * g.diameter, reach = look.query.radius + 0.5 * g.diameter + margin;
        horizon = math::min(horizon, 0.99 * margin / speed);
        Place<d> from, to;
        for (int k = 0; k < d; ++k) {
            from[k] = floor_of((look.query.position[k] - reach) / g.edge[k]);
            to[k] = floor_of((look.query.position[k] + reach) / g.edge[k]);
        }
        search_block(look, q, from, to);
    }
    rescans_[look.id] = now_ + horizon;
}

// Leaves the cell or meets a wall, whichever comes first.
template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::predict_own(u32 i) {
    Pending& e = pending_[i];
    const Particle<d>& p = particles_[i];
    const int own = level(i);
    const Grid<d>& g = cells_.grids()[own];
    const Place<d> at = cells_.place(own, e.cell);
    double in = math::infinity;
    Own which = Own::low_x;
    const auto consider = [&](double time, int axis, bool high) {
        if (time < in) in = time, which = own_event(axis, high);
    };
    for (int k = 0; k < d; ++k) {
        double low = at[k] * g.edge[k], high = (at[k] + 1) * g.edge[k];
        const double x = p.position[k], v = p.velocity[k], size = radius(i);
        if (motion != Motion::growing && !box_.periodic[k]) {
            if (at[k] == 0) low = size;
            if (at[k] == g.cells[k] - 1) high = box_.edge[k] - size;
        }
        if constexpr (motion == Motion::falling) {
            // From now on: a border passed on the way up is not to be met again in the past.
            const double since = now_ - p.time, g = box_.gravity[k];
            const double x_now = position_after<motion>(p, k, since, box_);
            const double v_now = velocity_after<motion>(p, k, since, box_);
            consider(since + time_below(x_now, v_now, g, high), k, true);
            consider(since + time_below(-x_now, -v_now, -g, -low), k, false);
        } else {
            consider(v > 0.0 ? time_below(x, v, high) : time_below(-x, -v, -low), k, v > 0.0);
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
            e.own = static_cast<u32>(Own::rescan) & 7u;
        }
}

}  // namespace hardlimit::particles
