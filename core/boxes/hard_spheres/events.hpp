// What happens when an event's time has come.
#pragma once
#include "engine.hpp"

namespace hardlimit::boxes {

template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::happen(u32 i) {
    const Pending& e = pending_[i];
    if (e.pair_time <= e.own_time) {
        if (collisions(e.partner) == e.partner_count)
            collide(i, e.partner);
        else
            predict(i, last_met(i));
        return;
    }
    const SelfEvent own = static_cast<SelfEvent>(e.own);
    if (own == SelfEvent::rescan) return predict(i, last_met(i));
    const int axis = axis_of(own), level_i = level(i);
    const Place<d> at = cells_.place(level_i, e.cell);
    const Grid<d>& g = cells_.grids()[static_cast<std::size_t>(level_i)];
    const int last = is_high(own) ? g.cells[axis] - 1 : 0;
    if (at[axis] == last && !box_.periodic[axis])
        meet_wall(i);
    else
        leave_cell(i, at);
}

// Moves on from the cell at this place to the next one and looks into the cells that have become neighbours, in its own
// grid and where the border is one of a coarser grid too.
template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::leave_cell(u32 i, Place<d> at) {
    Pending& e = pending_[i];
    Particle<d>& p = particles_[i];
    const SelfEvent own = static_cast<SelfEvent>(e.own);
    const int axis = axis_of(own), step = is_high(own) ? 1 : -1, fine = level(i);
    const Grid<d>& g = cells_.grids()[fine];
    cells_.remove(e.cell, i);
    at[axis] += step;
    if (at[axis] < 0 || at[axis] == g.cells[axis]) {
        at[axis] -= step * g.cells[axis];
        p.position[axis] -= step * box_.edge[axis];
        periods_[i][static_cast<std::size_t>(axis)] += step;
    }
    e.cell = cells_.number(fine, at) & (most_cells - 1);
    cells_.insert(e.cell, i);

    Look found = look(i);
    found.except = last_met(i);
    Place<d> place = at;
    for (int q = fine;; ++q) {
        Place<d> from, to;
        for (int k = 0; k < d; ++k) from[k] = place[k] - 1, to[k] = place[k] + 1;
        from[axis] = to[axis] = place[axis] + step;
        search_block(found, q, from, to);
        // The border just crossed is one of the next coarser grid where an even number of cells lies below it.
        const int border = step > 0 ? place[axis] : place[axis] + 1;
        if (q + 1 == cells_.levels() || border % 2 != 0) break;
        for (int k = 0; k < d; ++k) place[k] >>= 1;
    }
    keep(found);
    predict_own(i, at);
    schedule(i);
}

// Bounces off the wall of its own event. One that arrives without a speed stays there if gravity presses it on.
template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::meet_wall(u32 i) {
    Particle<d>& p = particles_[i];
    const SelfEvent own = static_cast<SelfEvent>(pending_[i].own);
    const int axis = axis_of(own);
    const double away = is_high(own) ? -1.0 : 1.0, waited = now_ - p.time;
    advance_to_now(i);
    const double size = radius(i) * growth_.at(now_);
    const double place = is_high(own) ? box_.edge[axis] - size : size;
    const double moved = place - p.position[axis];  // by rounding, or where a soft contact was cut short
    p.position[axis] = place;
    const double before = p.velocity[axis], speed = math::abs(before);
    const i64 wall = wall_number(own);
    if (soft_) tally_.dissipated.add(mass(i) * box_.gravity[axis] * moved);
    if constexpr (motion == Motion::growing) {
        p.velocity[axis] = away * math::max(speed, separation * radius(i) * growth_.rate);
        ++tally_.walls;
    } else if (speed == 0.0) {
        ++tally_.walls;
        note(i, wall, speed, 0.0, 0.0, math::infinity);
        if (!(away * box_.gravity[axis] > 0.0)) return end_here(Outcome::at_rest, i, wall);
    } else if (soft_) {
        meet_wall_softly(i, axis, away, speed);
    } else {
        const double m = mass(i), e = restitution(had_before(i, waited), speed, {m, radius(i)}, radius(i));
        if (deepest_.too_deep) return give_up(Outcome::too_deep, i, wall, speed);
        p.velocity[axis] = away * (e * speed);
        const double lost = 0.5 * m * (1.0 - e) * (1.0 + e) * speed * speed;
        tally_.advance(now_);
        tally_.kinetic -= lost;
        tally_.momentum[axis] += m * (p.velocity[axis] - before);
        ++tally_.walls;
        note(i, wall, speed, e * speed, lost, waited);
    }
    count_collision(i);
    keep_bounds(i);
    predict(i, no_particle);
}

template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::advance_to_now(u32 i) {
    boxes::advance<motion>(particles_[i], now_, box_);
}

// From i to the image of j that i touches.
template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::nearest(u32 i, u32 j, double (&r)[d]) const {
    const Particle<d>&p = particles_[i], &q = particles_[j];
    for (int k = 0; k < d; ++k) {
        r[k] = q.position[k] - p.position[k];
        const double edge = box_.edge[k];
        if (math::abs(r[k]) < 0.499 * edge || !box_.periodic[k]) continue;
        r[k] = nearest_image(r[k], edge);
        // Where both images may touch, the one that approaches does.
        const double other = r[k] > 0.0 ? r[k] - edge : r[k] + edge;
        const double v = q.velocity[k] - p.velocity[k];
        if (math::abs(r[k]) > 0.499999 * edge && r[k] * v > 0.0) r[k] = other;
    }
}

// Whether i collided less than t_c ago.
template <int d, Motion motion, bool mixed>
bool HardSpheres<d, motion, mixed>::had_before(u32 i, double waited) const {
    return rule_.is_tc() && waited < rule_.contact_duration() && collisions(i) > 0;
}

template <int d, Motion motion, bool mixed>
double HardSpheres<d, motion, mixed>::restitution(bool within_contact, double speed, PairGeometry pair,
                                                  double smaller_radius) {
    if (within_contact) {
        ++tally_.elastic_by_tc;
        return 1.0;
    }
    return rule_.restitution(speed, pair, smaller_radius, deepest_);
}

template <int d, Motion motion, bool mixed>
PairGeometry HardSpheres<d, motion, mixed>::geometry(u32 i, u32 j) const {
    if constexpr (mixed) return {effective(mass(i), mass(j)), effective(radius(i), radius(j))};
    return {0.5 * mass_, 0.5 * largest_radius_};
}

// The bookkeeping of a collision, before it is counted: i has met another particle or a wall, which is negative.
template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::note(u32 i, i64 second, double speed, double separation_speed,
                                         double lost, double waited) {
    if (lost != 0.0) tally_.dissipated.add(lost);
    const auto name = [this](u32 id) { return names_[id]; };
    if (keep_log_) {
        const auto [first, last] = named(i, second);
        log_.time.push_back(now_);
        log_.first.push_back(first);
        log_.second.push_back(last);
        log_.impact_speed.push_back(speed);
        log_.separation_speed.push_back(separation_speed);
    }
    const auto typical = [&] { return math::sqrt(math::max(0.0, 2.0 * tally_.kinetic / tally_.mass)); };
    const Impact impact{now_, i, second, speed, waited, !rule_.is_tc() && !rule_.elastic_always()};
    if (watch_.collapses(impact, largest_radius_, typical, name)) end_here(Outcome::collapse, i, second);
}

// A particle and another one, or a wall, which is negative, by the user's numbers.
template <int d, Motion motion, bool mixed>
std::pair<i64, i64> HardSpheres<d, motion, mixed>::named(u32 i, i64 second) const {
    const i64 a = names_[i];
    if (second < 0) return {a, second};
    return std::minmax({a, i64{names_[static_cast<u32>(second)]}});
}

// The run is over, at a collision.
template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::end_here(Outcome outcome, u32 i, i64 second) {
    const auto [first, last] = named(i, second);
    outcome_ = outcome;
    early_end_ = {now_, first, last};
}

// The same where the collision has no result: it is logged, and velocities stay.
template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::give_up(Outcome outcome, u32 i, i64 second, double speed) {
    ++(second < 0 ? tally_.walls : tally_.pairs);
    note(i, second, speed, math::nan, 0.0, math::infinity);
    end_here(outcome, i, second);
}

template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::collide(u32 i, u32 j) {
    Particle<d>&p = particles_[i], &q = particles_[j];
    const double waited_i = now_ - p.time, waited_j = now_ - q.time;
    advance_to_now(i);
    advance_to_now(j);
    double r[d], v[d];
    nearest(i, j, r);
    for (int k = 0; k < d; ++k) v[k] = q.velocity[k] - p.velocity[k];
    const double square = dot(r, r), distance = math::sqrt(square), speed = -dot(r, v) / distance;
    if (motion != Motion::growing && !(speed > 0.0)) {  // by rounding: they only touch
        if (soft_) softs_[i] = {now_, j}, softs_[j] = {now_, i};
    } else if (motion != Motion::growing && soft_) {
        collide_softly(i, j, r, v, distance, speed);
    } else {
        collide_at_once(i, j, r, v, distance, speed, std::array{waited_i, waited_j});
    }
    count_collision(i);
    count_collision(j);
    keep_bounds(i);
    keep_bounds(j);
    predict(i, except_for(i, j));
    predict(j, except_for(j, i));
}

// All but the soft rule. r leads from i to j.
template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::collide_at_once(u32 i, u32 j, const double (&r)[d], const double (&v)[d],
                                                    double distance, double speed,
                                                    std::array<double, 2> waited) {
    Particle<d>&p = particles_[i], &q = particles_[j];
    const PairGeometry pair = geometry(i, j);
    const double mi = mass(i), mj = mass(j), reduced = pair.effective_mass;
    // Relative velocity gained along r, in units of r [1/s]. From r² and not from its root: all pairs touch at
    // about the same distance, so that the rounding of the root would be the same each time, and the energy
    // would drift.
    double gain;
    if constexpr (motion == Motion::growing) {
        const double rate = (radius(i) + radius(j)) * growth_.rate;
        gain = (speed + math::max(speed, separation * rate)) / distance;
    } else {
        const bool within_contact = had_before(i, waited[0]) || had_before(j, waited[1]);
        const double e = restitution(within_contact, speed, pair, math::min(radius(i), radius(j)));
        if (deepest_.too_deep) return give_up(Outcome::too_deep, i, j, speed);
        gain = (1.0 + e) * (-dot(r, v) / dot(r, r));
        const double lost = 0.5 * reduced * (1.0 - e) * (1.0 + e) * speed * speed;
        tally_.virial.add(distance * distance * reduced * gain);
        if (lost != 0.0) {
            tally_.advance(now_);
            tally_.kinetic -= lost;
        }
        note(i, j, speed, e * speed, lost, math::max(waited[0], waited[1]));
    }
    for (int k = 0; k < d; ++k) {
        const double impulse = reduced * gain * r[k];
        p.velocity[k] -= impulse / mi;
        q.velocity[k] += impulse / mj;
    }
    ++tally_.pairs;
}

// What a particle that has just collided need not look at: its partner, which cannot be met again before either has met
// something else; another image of it may be.
template <int d, Motion motion, bool mixed>
u32 HardSpheres<d, motion, mixed>::except_for(u32 i, u32 partner) const {
    return soft_ ? last_met(i) : partner;
}

// After each collision of a particle.
template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::keep_bounds(u32 i) {
    if (mixed && cells_.levels() > 1) fastest_ = math::max(fastest_, frame_speed(particles_[i].velocity));
    if (--until_refresh_ == 0) refresh_tally();
}

}  // namespace hardlimit::boxes
