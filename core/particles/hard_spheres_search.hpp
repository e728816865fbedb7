// How a particle finds its next event.
#pragma once

namespace hardlimit::particles {

template <int d, Motion motion, bool mixed>
auto HardSpheres<d, motion, mixed>::here(u32 i, u32 except) const -> Here {
    const Particle<d>& p = particles_[i];
    Here h;
    h.id = i;
    for (int k = 0; k < d; ++k) {
        h.position[k] = position_after<motion>(p, k, now_ - p.time, box_);
        h.velocity[k] = velocity_after<motion>(p, k, now_ - p.time, box_);
    }
    h.radius = radius(i);
    h.except = except;
    return h;
}

// Of q, moved by `shift`, and p.
template <int d, Motion motion, bool mixed>
Approach HardSpheres<d, motion, mixed>::approach(const Here& p, const Particle<d>& q,
                                                 const double (&shift)[d]) const {
    double r[d], v[d];
    const double after = now_ - q.time;
    for (int k = 0; k < d; ++k) {
        r[k] = position_after<motion>(q, k, after, box_) + shift[k] - p.position[k];
        v[k] = velocity_after<motion>(q, k, after, box_) - p.velocity[k];
    }
    double touch = 0.0;
    if constexpr (mixed)
        touch = p.radius + q.radius;
    else
        touch = 2.0 * largest_radius_;
    if constexpr (motion == Motion::growing) {
        const double now = touch * growth_.at(now_), rate = touch * growth_.rate;
        return {dot(v, v) - rate * rate, dot(r, v) - now * rate, dot(r, r) - now * now};
    } else {
        return {dot(v, v), dot(r, v), dot(r, r) - touch * touch};
    }
}

// The first n candidates, all moved by `shift`. Nothing branches before it is known who will be met.
template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::examine(const Here& p, std::size_t n, const double (&shift)[d],
                                            Earliest& best) {
    for (std::size_t k = 0; k < n; ++k) {
        const u32 id = candidates_[k];
        const Approach a = approach(p, particles_[id], shift);
        const double discriminant = a.discriminant();
        double in;
        if constexpr (motion == Motion::growing) {
            if (id == p.id || !will_touch(a, discriminant)) continue;
            in = time_to_touch_growing(a, discriminant);
        } else {
            if (!((a.b < 0.0) & (discriminant > 0.0))) continue;
            in = time_to_touch(a.b, a.c, discriminant);
        }
        if (in > best.in || id == p.except) continue;
        if (in < best.in || names_[id] < names_[best.partner]) best = {in, id};
    }
}

template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::search_block(const Here& p, int level, const Place<d>& from,
                                                 const Place<d>& to, Earliest& best) {
    const Grid<d>& g = cells_.grids()[level];
    for (int k = 0; k < d; ++k)
        if (from[k] < 0 || to[k] >= g.cells[k]) return search_wrapped(p, level, from, to, best);
    std::size_t n = 0;
    Place<d> row = from;
    const u32 length = static_cast<u32>(to[0] - from[0]) + 1;
    const int high = d == 3 ? to[d - 1] : 0, low = d == 3 ? from[d - 1] : 0;
    for (int z = low; z <= high; ++z) {
        if constexpr (d == 3) row[2] = z;
        for (row[1] = from[1]; row[1] <= to[1]; ++row[1]) {
            const u32 first = cells_.number(level, row);
            if (candidates_.size() < n + 4 * length + 4) candidates_.resize(2 * n + 4 * length + 4);
            for (u32 c = 0; c < length; ++c) n = cells_.collect(first + c, candidates_, n);
        }
    }
    const double none[d] = {};
    examine(p, n, none, best);
}

// A block that reaches across a border of the box.
template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::search_wrapped(const Here& p, int level, const Place<d>& from,
                                                   const Place<d>& to, Earliest& best) {
    cells_.for_block(box_, level, from, to, [&](u32 cell, const double (&shift)[d]) {
        examine(p, cells_.collect(cell, candidates_, 0), shift, best);
    });
}

template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::keep(u32 i, const Earliest& found) {
    Pending& e = pending_[i];
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
    const Here p = here(i, except);
    Earliest best;
    cells_.for_neighbourhoods(own, e.cell, [&](int level, const Place<d>& from, const Place<d>& to) {
        search_block(p, level, from, to, best);
    });
    e.pair_time = math::infinity;
    e.partner = nobody;
    if constexpr (mixed)
        if (own > 0) search_finer(p, own, best);
    keep(i, best);
    predict_own(i);
}

// Speed now in a frame that falls with gravity along the periodic axes, where a speed would grow for ever.
template <int d, Motion motion, bool mixed>
double HardSpheres<d, motion, mixed>::frame_speed(const double (&velocity)[d]) const {
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
void HardSpheres<d, motion, mixed>::search_finer(const Here& p, int level, Earliest& best) {
    double horizon = math::infinity;
    const double speed = frame_speed(p.velocity) + fastest_possible();
    for (int q = 0; q < level; ++q) {
        const Grid<d>& g = cells_.grids()[q];
        const double margin = 1.5 * g.diameter, reach = p.radius + 0.5 * g.diameter + margin;
        horizon = math::min(horizon, 0.99 * margin / speed);
        Place<d> from, to;
        for (int k = 0; k < d; ++k) {
            from[k] = floor_of((p.position[k] - reach) / g.edge[k]);
            to[k] = floor_of((p.position[k] + reach) / g.edge[k]);
        }
        search_block(p, q, from, to, best);
    }
    rescans_[p.id] = now_ + horizon;
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
            consider(time_below(x, v, box_.gravity[k], high), k, true);
            consider(time_below(-x, -v, -box_.gravity[k], -low), k, false);
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
