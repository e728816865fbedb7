// Free flight of bodies between contacts: their paths, and the prediction of their next events.
#pragma once
#include "engine.hpp"

namespace hardlimit::boxes {

template <class Law>
Vector3 NewtonEvents<Law>::position(int i, double t) const {
    const Particle<3>& p = particles_[i];
    const double s = t - p.time;
    Vector3 x;
    for (std::size_t a = 0; a < 3; ++a)
        x[a] = p.position[a] + s * (p.velocity[a] + 0.5 * s * box_.gravity[a]);
    return x;
}

template <class Law>
Vector3 NewtonEvents<Law>::velocity(int i, double t) const {
    const Particle<3>& p = particles_[i];
    Vector3 v;
    for (std::size_t a = 0; a < 3; ++a) v[a] = p.velocity[a] + (t - p.time) * box_.gravity[a];
    return v;
}

template <class Law>
bool NewtonEvents<Law>::meets_wall(int i, const Wall& wall) const {
    if (!wall.motion.oscillates()) return true;
    const auto axis = static_cast<std::size_t>(wall.id.axis());
    return meets_oscillating_wall(wall, now_, position(i, now_)[axis], velocity(i, now_)[axis],
                                  box_.gravity[axis], radius(i));
}

// Starts a new parabola at the current time.
template <class Law>
void NewtonEvents<Law>::restart_path(int i) {
    if (!free(i)) return;
    Particle<3>& p = particles_[i];
    const double s = now_ - p.time;
    for (int a = 0; a < 3; ++a) {
        p.position[a] += s * (p.velocity[a] + 0.5 * s * box_.gravity[a]);
        p.velocity[a] += s * box_.gravity[a];
    }
    p.time = now_;
    ++pending_[i].count;
}

template <class Law>
void NewtonEvents<Law>::schedule(int i) {
    const u32 id = static_cast<u32>(i);
    calendar_queue_.push(id, pending_[i].time(), by_original_index());
}

template <class Law>
void NewtonEvents<Law>::reschedule(int i) {
    predict_events(i);
    schedule(i);
}

// Predicts all events of body i.
template <class Law>
void NewtonEvents<Law>::predict_events(int i) {
    set_query(i);
    predict_events_of_query(i);
}

template <class Law>
void NewtonEvents<Law>::predict_events_of_query(int i) {
    PendingEvents& e = pending_[i];
    e.pair_time = math::infinity;
    e.partner = no_particle;
    const Place<3> at = cells_.place(level_, e.cell);
    predict_collisions(i, around(at));
    predict_self_event(i, at);
}

// Predicts the events of all bodies at the start. Returns the bodies that may overlap with another, in ascending order:
// those that the kernel reports with a slightly larger radius. Their events must be predicted again.
template <class Law>
std::vector<int> NewtonEvents<Law>::predict_first_events() {
    constexpr double wider = 1e-8;  // of the largest radius: more than the rounding that the kernel allows
    static_assert(wider > rounding_of_touch);
    std::vector<int> touching;
    for (int i = 0; i < static_cast<int>(particles_.size()); ++i) {
        set_query(i);
        query_.enlarged_radius += wider * largest_radius_;
        predict_events_of_query(i);
        if (pending_[i].pair_time <= now_) touching.push_back(i);
    }
    return touching;
}

// Predicts all events of body i except collisions with body `other`: the kernel finds no contact with a body whose time
// is NaN.
template <class Law>
void NewtonEvents<Law>::predict_events_without(int i, int other) {
    if (i == other) return predict_events(i);
    const double time = std::exchange(particles_[other].time, math::nan);
    predict_events(i);
    particles_[other].time = time;
}

// Sets the kernel's query to body i. After an isolated contact a body has its own radius again.
template <class Law>
void NewtonEvents<Law>::set_query(int i) {
    const Particle<3>& p = particles_[i];
    const BodyEvents& e = pending_[i];
    const double s = now_ - p.time;
    const bool shrinks = e.group >= 0 && !e.clustered;
    query_.now = now_;
    query_.radius = shrinks ? radius(i) : p.radius;
    query_.enlarged_radius = p.radius;
    query_.enlarged_span = shrinks ? e.end - now_ : 0.0;
    kernel_exact_after_ =
        shrinks ? now_ + query_.enlarged_span : (e.clustered ? math::infinity : -math::infinity);
    for (int a = 0; a < 3; ++a) {
        query_.position[a] = p.position[a] + s * (p.velocity[a] + 0.5 * s * box_.gravity[a]);
        query_.velocity[a] = p.velocity[a] + s * box_.gravity[a];
    }
}

template <class Law>
void NewtonEvents<Law>::predict_collisions(int i, const Block& in) {
    if (!box_.is_sheared()) return predict_part(i, in);
    for_sides(in, [&](const Block& part, const ImageMotion& image) {
        const hardlimit_abi::ContactQuery own = query_;
        for (int a = 0; a < 3; ++a)
            query_.position[a] -= image.shift[a], query_.velocity[a] -= image.velocity[a];
        predict_part(i, part);
        for (int a = 0; a < 3; ++a)
            query_.position[a] = own.position[a], query_.velocity[a] = own.velocity[a];
    });
}

// Predicts collisions with the bodies in a block of cells, in whose frame the query is.
template <class Law>
void NewtonEvents<Law>::predict_part(int i, const Block& in) {
    reserve_candidates();
    const auto self = static_cast<unsigned>(i);
    if (several_images_) {
        cells_.for_block(cell_box_, level_, in.from, in.to, [&](u32 cell, const double (&shift)[3]) {
            std::copy_n(shift, 3, query_.shift);
            const std::size_t n = cells_.collect(cell, candidates_, 0);
            take_candidates(
                i, touch_.listed(query_, particles_.data(), self, candidates_.data(), times_.data(), n));
        });
        return;
    }
    hardlimit_abi::CellBlock block;
    const bool outside = cells_.lay_block(block, cell_box_, level_, in.from, in.to);
    const auto touch = outside ? touch_.across : touch_.near;
    take_candidates(i, touch(query_, particles_.data(), self, candidates_.data(), times_.data(), block));
}

// Takes the earliest collision among the candidates. The kernel's times are lower bounds if a body is busy.
// Simultaneous collisions are ordered by original index.
template <class Law>
void NewtonEvents<Law>::take_candidates(int i, const hardlimit_abi::EarliestContact& touched) {
    const PendingEvents& e = pending_[i];
    if (now_ + touched.time > e.pair_time || touched.time == math::infinity) return;
    take_candidate(i, touched.id, now_ + touched.time);
    if (!touched.several && (now_ + touched.next > e.pair_time || touched.next == math::infinity)) return;
    double last = e.pair_time;
    for (std::size_t k = 0; k < touched.n; ++k) {
        if (now_ + times_[k] > last || times_[k] == math::infinity || candidates_[k] == touched.id) continue;
        take_candidate(i, candidates_[k], now_ + times_[k]);
        last = e.pair_time;
    }
}

// Makes body `id` the next partner of body i if they collide earlier. `enlarged_time`: see collision_time().
template <class Law>
void NewtonEvents<Law>::take_candidate(int i, u32 id, double enlarged_time) {
    PendingEvents& e = pending_[i];
    const bool known = pending_[id].group < 0 && enlarged_time > kernel_exact_after_;
    const double time = known ? enlarged_time : collision_time(i, static_cast<int>(id), enlarged_time);
    if (time > e.pair_time || time == math::infinity) return;
    if (time == e.pair_time && e.partner != no_particle &&
        pending_[e.partner].original_index < pending_[id].original_index)
        return;
    e.pair_time = time;
    e.partner = id;
    e.partner_count = pending_[id].count;
}

// Time at which bodies i and j collide if at least one of them is busy. `enlarged_time`: time at which they would
// collide if both kept their safety radius. The path of a cluster's member is unknown beyond the end of the cluster:
// its later collisions are predicted then. Members of one group do not collide here.
template <class Law>
double NewtonEvents<Law>::collision_time(int i, int j, double enlarged_time) const {
    if (pending_[i].group == pending_[j].group) return math::infinity;
    const bool i_first = free(j) || (!free(i) && pending_[i].end < pending_[j].end);
    const int first = i_first ? i : j, last = i_first ? j : i;
    if (enlarged_time < pending_[first].end) {
        const RelativeMotion r = relative_motion(j);
        const bool apart = stays_clear(r, i, first, now_, particles_[last].radius) ||
                           stays_clear(r, i, last, now_, particles_[first].radius);
        if (!apart) return enlarged_time;
    }
    if (clustered(first)) return math::infinity;
    if (!free(last)) {
        const double time = time_at_distance(j, radius(first) + particles_[last].radius);
        if (time < pending_[last].end &&
            !stays_clear(relative_motion(j), i, last, pending_[first].end, radius(first)))
            return math::max(time, pending_[first].end);
        if (clustered(last)) return math::infinity;
    }
    return time_at_distance(j, radius(i) + radius(j));
}

// Position and velocity of body j relative to body i of the query, at the current time.
template <class Law>
typename NewtonEvents<Law>::RelativeMotion NewtonEvents<Law>::relative_motion(int j) const {
    const Vector3 x = position(j, now_), v = velocity(j, now_);
    RelativeMotion between;
    for (std::size_t k = 0; k < 3; ++k) {
        const double r = x[k] - query_.position[k];
        between.position[k] =
            r +
            (several_images_ ? query_.shift[k] : -query_.edge[k] * math::round_small(r * query_.per_edge[k]));
        between.velocity[k] = v[k] - query_.velocity[k];
    }
    return between;
}

// Whether `member`, body i or j in an isolated contact, stays out of reach of the other body from the time `from` until
// its group ends. The distance of its true path from its outgoing path is at most b(s) = ∫_s^∞ (t − s) |a| dt, which is
// convex in s and zero at the end, so that b ≤ b(touch) (T − s)/T. The true path deviates away from the partner, within
// the angle by which the line of centres rotates. Seen from the other body, the true positions therefore lie in a
// triangle: its corners are both ends of the outgoing path and the true position at `from`.
template <class Law>
bool NewtonEvents<Law>::stays_clear(const RelativeMotion& between, int i, int member, double from,
                                    double other_radius) const {
    if (free(member) || clustered(member)) return false;
    const BodyEvents& e = pending_[member];
    const IsolatedContact& l = group(e.group).isolated_contact;
    const std::size_t m = e.first ? 0 : 1;
    const double share = l.share[m], left = e.end - from, sign = member == i ? 1.0 : -1.0;
    const double off = (m == 0 ? -share : share) * math::clamp(left / l.span, 0.0, 1.0);
    Vector3 begin, away, along;
    for (std::size_t k = 0; k < 3; ++k) {
        begin[k] = sign * (between.position[k] + (from - now_) * between.velocity[k]);
        along[k] = sign * left * between.velocity[k];
        away[k] = -off * l.initial_offset[k];
    }
    const double reach = radius(member) + other_radius + l.safety_radius[m];
    return square_to_triangle(begin, away, along) > reach * reach * (1.0 + rounding_of_touch);
}

// Time at which the paths of body i of the query and of body j come within this distance.
template <class Law>
double NewtonEvents<Law>::time_at_distance(int j, double distance) const {
    const RelativeMotion between = relative_motion(j);
    const double a = dot(between.velocity, between.velocity), b = dot(between.position, between.velocity);
    const double c = dot(between.position, between.position) - distance * distance,
                 discriminant = b * b - a * c;
    if (!(b < 0.0 && discriminant > 0.0)) return math::infinity;
    return now_ + math::max(c, 0.0) / (math::sqrt(discriminant) - b);
}

// Predicts the self event of body i: it leaves its cell `at`, or meets a wall if it is free, or its cluster ends if it
// is the first member. Has few branches, since which face comes first is unpredictable for a processor. A wall at rest
// is the face of the outermost cells. A moving wall may be in any cell.
template <class Law>
void NewtonEvents<Law>::predict_self_event(int i, const Place<3>& at) {
    BodyEvents& e = pending_[i];
    const Grid<3>& g = cells_.grids()[static_cast<std::size_t>(level_)];
    const bool is_free = free(i);
    double in = math::infinity;
    SelfEvent which = SelfEvent::low_x;
    const auto consider = [&](double time, int axis, bool up, bool wall) {
        const auto sooner =
            0u - static_cast<u32>(time < in);  // a mask, since gcc would turn ?: into a branch
        which = static_cast<SelfEvent>((static_cast<u32>(self_event(axis, up, wall)) & sooner) |
                                       (static_cast<u32>(which) & ~sooner));
        in = math::min(in, time);
    };
    bool walls_move = false;
    HL_UNROLL
    for (int a = 0; a < 3; ++a) {
        if (a == box_.dimension) break;
        if (a == 0 && box_.is_sheared()) continue;
        const double x = query_.position[a], v = query_.velocity[a], pull = box_.gravity[a];
        double low = at[a] * g.edge[a], high = (at[a] + 1) * g.edge[a];
        bool outermost[2] = {};
        if (walled_ && box_.has_walls(a)) {
            const bool moving = box_.has_moving_walls(a), face = is_free && !moving;
            outermost[0] = at[a] == 0, outermost[1] = at[a] == g.cells[a] - 1;
            if (outermost[0])
                low = face ? box_.wall(a, false).position(now_) + query_.radius : -math::infinity;
            if (outermost[1])
                high = face ? box_.wall(a, true).position(now_) - query_.radius : math::infinity;
            walls_move = walls_move || (moving && is_free);
        }
        if (pull == 0.0) {
            const double borders[2] = {low, high};
            const bool up = v > 0.0;
            consider(time_to(borders[up] - x, v), a, up, outermost[up]);
        } else {
            consider(time_below(x, v, pull, high), a, true, outermost[1]);
            consider(time_below(-x, -v, -pull, -low), a, false, outermost[0]);
        }
    }
    if (walls_move) [[unlikely]]
        for (int a = 0; a < box_.dimension; ++a)
            for (const bool up : {false, true})
                if (box_.has_moving_walls(a))
                    consider(wall_contact_time(box_.wall(a, up), now_, query_.position[a], query_.velocity[a],
                                               box_.gravity[a], query_.radius, in),
                             a, up, true);
    if (box_.is_sheared()) {
        const int y = box_.gradient;
        const auto u = cells_.along(query_.position[0], query_.position[y], query_.velocity[0],
                                    query_.velocity[y], now_);
        const Exit leaves = exit_of(u.at, u.rate, u.acceleration, at[0] * g.edge[0], (at[0] + 1) * g.edge[0],
                                    4.0 * math::epsilon * now_);
        consider(leaves.time, 0, leaves.high, false);
    }
    e.own_time = now_ + in;
    e.own = static_cast<u32>(which) & 15u;
    if (!e.first || !e.clustered || e.end > e.own_time) return;
    e.own_time = e.end;
    e.own = static_cast<u32>(SelfEvent::ends) & 15u;
}

}  // namespace hardlimit::boxes
