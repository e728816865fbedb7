// Prediction of a particle's next events: collisions, walls, cell crossings.
#pragma once
#include "engine.hpp"

namespace hardlimit::boxes {

// Sets the fields that are the same in all queries.
template <int d, bool mixed>
void HardSpheres<d, mixed>::prepare_query() {
    query_ = {};
    query_.radius = mixed ? 0.0 : 2.0 * largest_radius_;
    query_.others = mixed ? 1.0 : 0.0;
    query_.radius_factor = 1.0;
    query_.growth_rate = growth_.rate;
    for (int k = 0; k < d; ++k) {
        query_.edge[k] = box_.edge[k];
        query_.per_edge[k] = box_.is_periodic(k) ? 1.0 / box_.edge[k] : 0.0;
        query_.half_gravity[k] = 0.5 * box_.gravity[k];
        query_.gravity[k] = box_.gravity[k];
    }
}

template <int d, bool mixed>
auto HardSpheres<d, mixed>::begin_prediction(u32 i, u32 except) -> NextCollision {
    const Particle<d>& p = particles_[i];
    query_.now = now_;
    if constexpr (mixed) query_.radius = radius(i);
    if (grows()) query_.radius_factor = growth_.at(now_);
    for (int k = 0; k < d; ++k) {
        query_.position[k] = position_after(p, k, now_ - p.time, box_);
        query_.velocity[k] = velocity_after(p, k, now_ - p.time, box_);
    }
    return NextCollision{i, except};
}

// Whether the image of a particle that was just examined touches or overlaps the particle of the query. `nearest`:
// takes the nearest image.
template <int d, bool mixed>
bool HardSpheres<d, mixed>::touches(u32 id, bool nearest) const {
    const Particle<d>& p = particles_[id];
    double square = 0.0;
    for (int k = 0; k < d; ++k) {
        double r = position_after(p, k, now_ - p.time, box_) + query_.shift[k] - query_.position[k];
        if (nearest) r -= query_.edge[k] * math::round_small(r * query_.per_edge[k]);
        square += r * r;
    }
    const double touch = (query_.radius + query_.others * radius(id)) * query_.radius_factor;
    return square <= touch * touch * (1.0 + 1e-9);
}

// Keeps the earliest collision that a kernel has found among the candidates; among simultaneous ones, that with the
// lowest original index.
template <int d, bool mixed>
void HardSpheres<d, mixed>::keep_earliest(NextCollision& next, const hardlimit_abi::EarliestContact& touched,
                                          bool nearest) {
    if (!(touched.time <= next.in) || touched.time == math::infinity) return;
    if (touched.time < next.in && !touched.several && touched.id != next.except) {
        next.in = touched.time;
        next.partner = touched.id;
        return;
    }
    for (std::size_t k = 0; k < touched.n; ++k) {
        if (times_[k] > next.in || times_[k] == math::infinity) continue;
        const u32 id = candidates_[k];
        if (id == next.except && touches(id, nearest)) continue;
        if (times_[k] < next.in || original_index_[id] < original_index_[next.partner]) {
            next.in = times_[k];
            next.partner = id;
        }
    }
}

template <int d, bool mixed>
void HardSpheres<d, mixed>::make_room_for_candidates(std::size_t room) {
    if (times_.size() >= room) return;
    times_.resize(room);
    candidates_.resize(room);
}

// Predicts collisions with the particles of a block that may reach beyond the sides of the box.
template <int d, bool mixed>
void HardSpheres<d, mixed>::predict_near(NextCollision& next, int level, const Place<d>& from,
                                         const Place<d>& to) {
    predict_in_block(next, level, from, to);
    if (box_.is_sheared()) predict_beyond_sides(next, level, from, to);
}

// The same for the parts of the block beyond the sides of a sheared box.
template <int d, bool mixed>
void HardSpheres<d, mixed>::predict_beyond_sides(NextCollision& next, int level, const Place<d>& from,
                                                 const Place<d>& to) {
    for_images_beyond(level, from, to, [&](const Place<d>& low, const Place<d>& high) {
        predict_in_block(next, level, low, high);
    });
}

// Calls f(from, to) for the parts of a block beyond the sides of a sheared box. Meanwhile, the particle of the query is
// in the frame of the images there: the relative motion is the same, and the neighbours stay as they are.
template <int d, bool mixed>
template <class F>
void HardSpheres<d, mixed>::for_images_beyond(int level, const Place<d>& from, const Place<d>& to,
                                              const F& f) {
    cells_.for_sheared_parts(box_, level, from, to, now_,
                             [&](const Place<d>& low, const Place<d>& high, const ImageMotion& image) {
                                 const auto query = query_;
                                 for (int k = 0; k < d; ++k) {
                                     query_.position[k] -= image.shift[k];
                                     query_.velocity[k] -= image.velocity[k];
                                 }
                                 f(low, high);
                                 query_ = query;
                             });
}

template <int d, bool mixed>
void HardSpheres<d, mixed>::predict_in_block(NextCollision& next, int level, const Place<d>& from,
                                             const Place<d>& to) {
    if (cells_.grids()[static_cast<std::size_t>(level)].few) return predict_in_images(next, level, from, to);
    make_room_for_candidates(cells_.room());
    hardlimit_abi::CellBlock block;
    const bool across = cells_.lay_block(block, box_, level, from, to);
    const auto touch = across ? touch_.across : touch_.near;
    keep_earliest(next, touch(query_, particles_.data(), next.id, candidates_.data(), times_.data(), block),
                  across);
}

// The same for a block that may hold several images of a particle, because the box is small.
template <int d, bool mixed>
void HardSpheres<d, mixed>::predict_in_images(NextCollision& next, int level, const Place<d>& from,
                                              const Place<d>& to) {
    make_room_for_candidates(cells_.room());
    cells_.for_block(box_, level, from, to, [&](u32 cell, const double (&shift)[d]) {
        for (int k = 0; k < d; ++k) query_.shift[k] = shift[k];
        const std::size_t n = cells_.collect(cell, candidates_, 0);
        keep_earliest(next,
                      touch_.listed(query_, particles_.data(), next.id, candidates_.data(), times_.data(), n),
                      false);
    });
    for (double& shift : query_.shift) shift = 0.0;
}

// Stores the collision if it is earlier than the one that is pending.
template <int d, bool mixed>
void HardSpheres<d, mixed>::store(const NextCollision& next) {
    PendingEvents& e = pending_[next.id];
    const double time = now_ + next.in;
    if (next.partner == no_particle || time > e.pair_time) return;
    if (time == e.pair_time && e.partner != no_particle &&
        original_index_[e.partner] < original_index_[next.partner])
        return;
    e.pair_time = time;
    e.partner = next.partner;
    e.partner_count = collisions(next.partner);
}

template <int d, bool mixed>
void HardSpheres<d, mixed>::predict(u32 i, u32 except) {
    predict_unscheduled(i, except);
    schedule(i);
}

// Predicts all events of a particle.
template <int d, bool mixed>
void HardSpheres<d, mixed>::predict_unscheduled(u32 i, u32 except) {
    PendingEvents& e = pending_[i];
    const int own = level(i);
    const Place<d> at = cells_.place(own, e.cell);
    NextCollision next = begin_prediction(i, except);
    cells_.for_stencils(own, at, [&](int level, const Place<d>& from, const Place<d>& to) {
        if (holds_any(level)) predict_near(next, level, from, to);
    });
    e.pair_time = math::infinity;
    e.partner = no_particle;
    if constexpr (mixed)
        if (own > 0) predict_finer(next, own);
    store(next);
    predict_self_event(i, at);
}

// Present speed in a frame that falls with gravity along the periodic axes, where speeds grow without bound.
template <int d, bool mixed>
double HardSpheres<d, mixed>::frame_speed(const double* velocity) const {
    double square = 0.0;
    for (int k = 0; k < d; ++k) {
        const double v = velocity[k] - (box_.is_periodic(k) ? box_.gravity[k] * now_ : 0.0);
        square += v * v;
    }
    return math::sqrt(square);
}
// Bound on that speed for all particles: between walls a fall is limited by the height of the box. The factor leaves
// time for moving walls.
template <int d, bool mixed>
double HardSpheres<d, mixed>::speed_bound() const {
    double square = fastest_ * fastest_;
    for (int k = 0; k < d; ++k)
        if (box_.has_walls(k)) {
            const bool moving = box_.has_moving_walls(k);
            const double height = box_.edge[k] + (moving ? 4.0 * box_.farthest_wall(now_) : 0.0);
            square += 2.0 * math::abs(box_.gravity[k]) * height;
        }
    return math::sqrt(square);
}

// Predicts collisions with particles of finer grids, which may be many: examines only those that can arrive before the
// next such search, and sets the time of that search.
template <int d, bool mixed>
void HardSpheres<d, mixed>::predict_finer(NextCollision& next, int level) {
    double horizon = math::infinity;
    const double speed = frame_speed(query_.velocity) + speed_bound() + math::abs(box_.image_velocity());
    for (int q = 0; q < level; ++q) {
        const double widest = cells_.grids()[q].widest;
        if (widest == 0.0) continue;
        const double margin = 2.0 * widest, reach = query_.radius + 0.5 * widest + margin;
        horizon = math::min(horizon, 0.99 * margin / speed);
        Place<d> from, to;
        bool narrow = false;  // so that two images of a particle may be within reach
        for (int k = 0; k < d; ++k) {
            const double x = k == 0 ? cells_.along(query_.position, now_) : query_.position[k];
            const double far = k == 0 ? cells_.extent_along(reach, now_) : reach;
            narrow = narrow || (box_.is_periodic(k) && box_.edge[k] < 2.001 * far);
            from[k] = floor_to_int((x - far) / cells_.grids()[q].edge[k]);
            to[k] = floor_to_int((x + far) / cells_.grids()[q].edge[k]);
        }
        const auto examine = [&](const hardlimit_abi::CellBlock& block, std::size_t room) {
            make_room_for_candidates(room);
            keep_earliest(
                next,
                touch_.across(query_, particles_.data(), next.id, candidates_.data(), times_.data(), block),
                true);
        };
        const auto predict_within = [&](const Place<d>& low, const Place<d>& high) {
            if (narrow) return predict_in_images(next, q, low, high);
            cells_.for_blocks_within(box_, q, query_.position, reach, low, high, rows_, examine);
        };
        predict_within(from, to);
        if (box_.is_sheared()) for_images_beyond(q, from, to, predict_within);
    }
    rescans_[next.id] = now_ + horizon;
}

// The path of a particle since its last collision, for next_self_event(). A fall is followed from now on: a face
// crossed on the way up must not be found again.
template <int d, bool mixed>
struct HardSpheres<d, mixed>::Flight {
    const HardSpheres& of;
    u32 i;
    const Particle<d>& path = of.particles_[i];
    double radius = of.radius(i);

    static constexpr int axes = d;
    bool falls(int) const { return of.falls(); }
    bool meets_walls() const { return true; }
    bool walls_move(int axis) const { return of.grows() || of.box_.has_moving_walls(axis); }
    AxisState at(int axis, double time) const {
        const double since = time - path.time;
        return {since, position_after(path, axis, since, of.box_),
                velocity_after(path, axis, since, of.box_)};
    }
    AxisState at_present(int axis) const { return at(axis, of.now_); }
    AxisState from(int axis, bool high, bool wall) const {
        if (!of.falls()) return {0.0, path.position[axis], path.velocity[axis]};
        return at(axis, wall ? of.wall_blocked_until(i, WallId::at(axis, high)) : of.now_);
    }
    double until_wall(const Wall& wall, double horizon) const {
        const int axis = wall.id.axis();
        if (of.grows()) {
            const double touch = radius * of.growth_.at(path.time), out = -wall.inward();
            return time_below(touch + out * path.position[axis],
                              radius * of.growth_.rate + out * path.velocity[axis], wall.start);
        }
        const double begin = of.wall_blocked_until(i, wall.id);
        const AxisState s = at(axis, begin);
        return s.since +
               wall_contact_time(wall, begin, s.x, s.v, of.box_.gravity[axis], radius, horizon - s.since);
    }
};

template <int d, bool mixed>
void HardSpheres<d, mixed>::predict_self_event(u32 i, const Place<d>& at) {
    PendingEvents& e = pending_[i];
    const int own = level(i);
    const NextSelfEvent next = next_self_event(box_, cells_, own, at, now_, Flight{*this, i});
    e.own_time = math::max(now_, particles_[i].time + next.in);
    e.own = static_cast<u32>(next.which) & 15u;
    if constexpr (mixed)
        if (own > 0 && rescans_[i] < e.own_time) {
            e.own_time = rescans_[i];
            e.own = static_cast<u32>(SelfEvent::rescan) & 15u;
        }
}

}  // namespace hardlimit::boxes
