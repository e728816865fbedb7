// Processing of events: collisions of two particles or with a wall, and cell crossings.
#pragma once
#include "engine.hpp"

namespace hardlimit::boxes {

template <int d, bool mixed>
void HardSpheres<d, mixed>::process_event(u32 i) {
    const PendingEvents& e = pending_[i];
    if (e.pair_time <= e.own_time) {
        if (collisions(e.partner) == e.partner_count)
            collide(i, e.partner);
        else
            predict(i, excluded_partner(i));
        return;
    }
    const SelfEvent own = static_cast<SelfEvent>(e.own);
    if (own == SelfEvent::rescan) return predict(i, excluded_partner(i));
    if (is_wall(own)) return collide_with_wall(i, box_.wall(wall_at(own)));
    leave_cell(i, cells_.place(level(i), e.cell));
}

// Moves a particle from cell `at` to the next one, and predicts its collisions in the cells that have become
// neighbours: those of its own grid, and of coarser grids in which it has changed its cell as well.
template <int d, bool mixed>
void HardSpheres<d, mixed>::leave_cell(u32 i, Place<d> at) {
    PendingEvents& e = pending_[i];
    Particle<d>& p = particles_[i];
    const SelfEvent own = static_cast<SelfEvent>(e.own);
    const int axis = axis_of(own), step = is_high(own) ? 1 : -1, fine = level(i);
    const Grid<d>& g = cells_.grids()[fine];
    cells_.remove(e.cell, i);
    at[axis] += step;
    if (at[axis] < 0 || at[axis] == g.cells[axis]) {
        at[axis] -= step * g.cells[axis];
        int along = axis, turns = step;
        if (box_.is_sheared() && axis == box_.gradient) {
            cross_sheared_side(i, step);
            along = 0, turns = cells_.displace(fine, at[0], -step);
        }
        box_.wrap(p.position, p.velocity, image_flags_[i], along, turns, p.time);
    }
    e.cell = cells_.number(fine, at) & (most_cells - 1);
    cells_.insert(e.cell, i);

    NextCollision next = begin_prediction(i, excluded_partner(i));
    Place<d> place = at;
    for (int q = fine;; ++q) {
        Place<d> from, to;
        for (int k = 0; k < d; ++k) from[k] = place[k] - 1, to[k] = place[k] + 1;
        from[axis] = to[axis] = place[axis] + step;
        if (holds_any(q)) predict_near(next, q, from, to);
        // The face just crossed is a face of the next coarser grid if an even number of cells lies below it.
        const int border = step > 0 ? place[axis] : place[axis] + 1;
        if (q + 1 == cells_.levels() || border % 2 != 0) break;
        for (int k = 0; k < d; ++k) place[k] >>= 1;
    }
    store(next);
    predict_self_event(i, at);
    schedule(i);
}

// Moves a particle that leaves a sheared box through the far side (step 1) or that at 0 (−1) to its image in the box.
// The boundary does the work by which its kinetic energy changes.
template <int d, bool mixed>
void HardSpheres<d, mixed>::cross_sheared_side(u32 i, int step) {
    Particle<d>& p = particles_[i];
    accumulators_.advance(now_);
    const double after = now_ - p.time;
    double before[d], crossed[d];
    for (int k = 0; k < d; ++k) before[k] = crossed[k] = velocity_after(p, k, after, box_);
    box_.wrap(p.position, p.velocity, image_flags_[i], box_.gradient, step, p.time);
    crossed[0] = p.velocity[0];
    accumulators_.sums.change(mass(i), before, crossed);
    accumulators_.shear_work.add(gained_energy(mass(i), before[0], crossed[0] - before[0]));
    if (mixed && cells_.levels() > 1) fastest_ = math::max(fastest_, frame_speed(crossed));
}

// Wraps a particle along the first axis of a box, whose columns of cells may be tilted. Returns its cell.
template <int d, bool mixed>
u32 HardSpheres<d, mixed>::fold_into_column(u32 i) {
    Particle<d>& p = particles_[i];
    double now[d];
    for (int k = 0; k < d; ++k) now[k] = position_after(p, k, now_ - p.time, box_);
    const int turns = box_.is_sheared() ? box_.turns(cells_.along(now, now_), 0) : 0;
    if (turns != 0) {
        box_.wrap(p.position, p.velocity, image_flags_[i], 0, turns, p.time);
        now[0] -= turns * box_.edge[0];
    }
    return cells_.number(level(i), cells_.place_of(level(i), now, now_));
}

template <int d, bool mixed>
bool HardSpheres<d, mixed>::meets_wall(u32 i, const Wall& wall) const {
    const Particle<d>& p = particles_[i];
    const int axis = wall.id.axis();
    const double x = position_after(p, axis, now_ - p.time, box_);
    const double v = velocity_after(p, axis, now_ - p.time, box_);
    return meets_oscillating_wall(wall, now_, x, v, box_.gravity[axis], radius(i));
}

// Collision with a wall, in the frame of the wall. A particle that arrives at zero speed rests there if gravity and the
// acceleration of the wall press it on the wall.
template <int d, bool mixed>
void HardSpheres<d, mixed>::collide_with_wall(u32 i, const Wall& wall) {
    if (wall.motion.oscillates() && !meets_wall(i, wall)) [[unlikely]] {
        predict_self_event(i, cells_.place(level(i), pending_[i].cell));
        return schedule(i);
    }
    Particle<d>& p = particles_[i];
    const int axis = wall.id.axis();
    const double away = wall.inward(), waited = now_ - p.time;
    advance_to_now(i);
    if (!grows()) accumulators_.advance(now_);
    double velocity[d];
    std::copy_n(p.velocity, d, velocity);
    const double place = wall.position(now_) + away * (radius(i) * growth_.at(now_));
    const double moved = place - p.position[axis];  // nonzero by rounding, or if a soft contact was cut short
    p.position[axis] = place;
    if (falls()) accumulators_.sums.add_potential(-mass(i) * box_.gravity[axis] * moved);
    const double before = p.velocity[axis], speed = math::abs(before - wall.velocity(now_));
    if (takes_time_) {
        accumulators_.dissipated.add(mass(i) * box_.gravity[axis] * moved);
        accumulators_.wall_energy[wall.id.index()].add(mass(i) * box_.gravity[axis] * moved);
    }
    if (grows()) {
        velocity[axis] = away * math::max(speed, separation_of_growing * radius(i) * growth_.rate);
        set_velocity(i, velocity);
        ++accumulators_.walls;
    } else if (speed == 0.0) {
        ++accumulators_.walls;
        record(i, wall.id.number, speed, 0.0, 0.0, math::infinity);
        if (!(away * (box_.gravity[axis] - wall.acceleration(now_)) > 0.0))
            return end_run(Outcome::at_rest, i, wall.id.number);
    } else if (takes_time_) {
        contact_with_wall(i, wall, speed);
    } else {
        const double m = mass(i);
        const double e =
            rebound_of({{m, math::infinity, speed}, {m, radius(i)}, radius(i), since_last(i, waited)})
                .restitution;
        if (deepest_.too_deep) return end_unsolved(Outcome::too_deep, i, wall.id.number, speed);
        velocity[axis] = away * (e * speed) + wall.velocity(now_);
        set_velocity(i, velocity);
        const double lost = 0.5 * m * (1.0 - e) * (1.0 + e) * speed * speed;
        const double gained = m * (velocity[axis] - before);
        accumulators_.add_wall(wall.id, away * gained, gained * wall.velocity(now_), lost);
        record(i, wall.id.number, speed, e * speed, lost, waited);
    }
    count_collision(i);
    after_collision(i);
    predict(i, no_particle);
}

// Vector from i to the image of j that i touches. Returns the velocity of this image along the first axis [m/s].
template <int d, bool mixed>
double HardSpheres<d, mixed>::to_nearest_image(u32 i, u32 j, double (&r)[d]) const {
    const Particle<d>&p = particles_[i], &q = particles_[j];
    for (int k = 0; k < d; ++k) r[k] = q.position[k] - p.position[k];
    const double image_velocity = box_.to_nearest_layer(r, now_);
    for (int k = 0; k < d; ++k) {
        const double edge = box_.edge[k];
        if (math::abs(r[k]) < 0.499 * edge || !box_.is_periodic(k)) continue;
        r[k] = box_.minimum_image(r[k], k);
        // If both images may touch, the approaching one does.
        const double other = r[k] > 0.0 ? r[k] - edge : r[k] + edge;
        const double v = q.velocity[k] - p.velocity[k] + (k == 0 ? image_velocity : 0.0);
        if (math::abs(r[k]) > 0.499999 * edge && r[k] * v > 0.0) r[k] = other;
    }
    return image_velocity;
}

template <int d, bool mixed>
Rebound HardSpheres<d, mixed>::rebound_of(const Impact& impact) {
    const Rebound rebound = rule_->rebound(impact, deepest_);
    accumulators_.elastic_by_tc += rebound.elastic_by_tc;
    return rebound;
}

template <int d, bool mixed>
PairGeometry HardSpheres<d, mixed>::geometry(u32 i, u32 j) const {
    if constexpr (mixed) return {effective(mass(i), mass(j)), effective(radius(i), radius(j))};
    return {0.5 * mass_, 0.5 * largest_radius_};
}

// Logs a collision of i, before it is counted, and ends the run if it is part of a collapse. second: the other
// particle, or the number of a wall.
template <int d, bool mixed>
void HardSpheres<d, mixed>::record(u32 i, i64 second, double speed, double separation_speed, double lost,
                                   double waited) {
    if (lost != 0.0) accumulators_.dissipated.add(lost);
    const auto index = [this](u32 id) { return original_index_[id]; };
    if (keep_log_) {
        const auto [first, last] = original_pair(i, second);
        log_.push_back({now_, now_, static_cast<std::int32_t>(first), static_cast<std::int32_t>(last), speed,
                        separation_speed, false});
    }
    const auto typical = [&] {
        return math::sqrt(math::max(0.0, accumulators_.sums.twice_kinetic() / accumulators_.mass));
    };
    const CollapseDetector::Collision c{now_, i, second, speed, waited, rule_->can_collapse()};
    if (collapse_.collapses(c, largest_radius_, typical, index)) end_run(Outcome::collapse, i, second);
}

// Original indices of a particle and its partner; a wall keeps its number.
template <int d, bool mixed>
std::pair<i64, i64> HardSpheres<d, mixed>::original_pair(u32 i, i64 second) const {
    const i64 a = original_index_[i];
    if (second < 0) return {a, second};
    return std::minmax({a, i64{original_index_[static_cast<u32>(second)]}});
}

// Ends the run at a collision.
template <int d, bool mixed>
void HardSpheres<d, mixed>::end_run(Outcome outcome, u32 i, i64 second) {
    const auto [first, last] = original_pair(i, second);
    outcome_ = outcome;
    early_end_ = {now_, {first}, WallId::of(last)};
    if (!early_end_.wall) early_end_.particles.push_back(last);
}

// The same for a collision without a result: it is logged, and the velocities do not change.
template <int d, bool mixed>
void HardSpheres<d, mixed>::end_unsolved(Outcome outcome, u32 i, i64 second, double speed) {
    ++(second < 0 ? accumulators_.walls : accumulators_.pairs);
    record(i, second, speed, math::nan, 0.0, math::infinity);
    end_run(outcome, i, second);
}

template <int d, bool mixed>
void HardSpheres<d, mixed>::collide(u32 i, u32 j) {
    Particle<d>&p = particles_[i], &q = particles_[j];
    const double waited_i = now_ - p.time, waited_j = now_ - q.time;
    advance_to_now(i);
    advance_to_now(j);
    if (!grows()) accumulators_.advance(now_);
    double r[d], v[d];
    const double image_velocity = to_nearest_image(i, j, r);
    for (int k = 0; k < d; ++k) v[k] = q.velocity[k] - p.velocity[k];
    if (image_velocity != 0.0) v[0] += image_velocity;
    const double square = dot(r, r), distance = math::sqrt(square), speed = -dot(r, v) / distance;
    if (!grows() && !(speed > 0.0)) {  // by rounding: they only touch
        if (takes_time_) last_contacts_[i] = {now_, j}, last_contacts_[j] = {now_, i};
    } else if (!grows() && takes_time_) {
        contact(i, j, r, v, distance, speed, image_velocity);
    } else {
        rebound(i, j, r, v, distance, speed, image_velocity, std::array{waited_i, waited_j});
    }
    count_collision(i);
    count_collision(j);
    after_collision(i);
    after_collision(j);
    // A pair that has just collided cannot collide again before one of them has another collision; other images can.
    predict(i, takes_time_ ? excluded_partner(i) : j);
    predict(j, takes_time_ ? excluded_partner(j) : i);
}

// An instantaneous collision. r: vector from i to j. image_velocity: of the image of j that i touches; a sheared
// boundary does work on it.
template <int d, bool mixed>
void HardSpheres<d, mixed>::rebound(u32 i, u32 j, const double (&r)[d], const double (&v)[d], double distance,
                                    double speed, double image_velocity, std::array<double, 2> waited) {
    Particle<d>&p = particles_[i], &q = particles_[j];
    const PairGeometry pair = geometry(i, j);
    const double mi = mass(i), mj = mass(j), reduced = pair.effective_mass;
    // Relative velocity gained along r, in units of r [1/s]. Computed from r² without a square root: all pairs touch at
    // about the same distance, so that the rounding error of the root would be the same each time, and the energy would
    // drift.
    double gain, lost = 0.0, e = 1.0;
    if (grows()) {
        const double rate = (radius(i) + radius(j)) * growth_.rate;
        gain = (speed + math::max(speed, separation_of_growing * rate)) / distance;
    } else {
        const double since = math::min(since_last(i, waited[0]), since_last(j, waited[1]));
        e = rebound_of({{reduced, distance, speed}, pair, math::min(radius(i), radius(j)), since})
                .restitution;
        if (deepest_.too_deep) return end_unsolved(Outcome::too_deep, i, j, speed);
        gain = (1.0 + e) * (-dot(r, v) / dot(r, r));
        lost = 0.5 * reduced * (1.0 - e) * (1.0 + e) * speed * speed;
        accumulators_.add_virial(reduced * gain, r,
                                 r);  // r⊗Δp, exactly: the force acts along r at one instant
    }
    double to_i[d], to_j[d];
    for (int k = 0; k < d; ++k) {
        const double impulse = reduced * gain * r[k];
        to_i[k] = p.velocity[k] - impulse / mi;
        to_j[k] = q.velocity[k] + impulse / mj;
    }
    set_velocity(i, to_i);
    set_velocity(j, to_j);
    if (image_velocity != 0.0) accumulators_.shear_work.add(-(reduced * gain * r[0]) * image_velocity);
    if (!grows()) record(i, j, speed, e * speed, lost, math::max(waited[0], waited[1]));
    ++accumulators_.pairs;
}

// Gives a particle another velocity at the instant of its position.
template <int d, bool mixed>
void HardSpheres<d, mixed>::set_velocity(u32 i, const double (&velocity)[d]) {
    double (&own)[d] = particles_[i].velocity;
    if (!grows()) accumulators_.sums.change(mass(i), own, velocity);
    if (box_.is_sheared()) {
        const double flow = box_.mean_flow(particles_[i].position[box_.gradient]);
        double before[d], after[d];
        std::copy_n(own, d, before);
        std::copy_n(velocity, d, after);
        before[0] -= flow, after[0] -= flow;
        accumulators_.from_flow.change(mass(i), before, after);
    }
    std::copy_n(velocity, d, own);
}

// Updates the bound on the speeds, and refreshes the accumulators when due.
template <int d, bool mixed>
void HardSpheres<d, mixed>::after_collision(u32 i) {
    if (mixed && cells_.levels() > 1) fastest_ = math::max(fastest_, frame_speed(particles_[i].velocity));
    const i64 changes = changes_between_refreshes() - --until_refresh_;
    if (until_refresh_ == 0 || (changes >= size32() && !accumulators_.are_exact())) refresh_accumulators();
}

}  // namespace hardlimit::boxes
