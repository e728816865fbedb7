// Collisions under the soft rule: a contact takes time and turns the line of centres. Both bodies are put where the
// straight path, or at a wall the parabola, that they follow after the contact was at the instant of touch.
#pragma once
#include "engine.hpp"

namespace hardlimit::boxes {

// Adds to a sum what one body gets of a change of the relative motion.
template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::shift_body(u32 i, double share, const double (&velocity)[d],
                                               const double (&shift)[d]) {
    Particle<d>& p = particles_[i];
    for (int k = 0; k < d; ++k) {
        p.velocity[k] += share * velocity[k];
        p.position[k] += share * shift[k];
    }
    settle(i);
}

// Puts a particle that was moved into the cell where it is now.
template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::settle(u32 i) {
    Particle<d>& p = particles_[i];
    for (int k = 0; k < d; ++k)
        while (box_.periodic[k] && (p.position[k] < 0.0 || p.position[k] > box_.edge[k])) {
            const int step = p.position[k] < 0.0 ? -1 : 1;
            p.position[k] -= step * box_.edge[k];
            periods_[i][static_cast<std::size_t>(k)] += step;
        }
    const u32 cell = cells_.number(level(i), cells_.place_of(level(i), p.position));
    if (cell == pending_[i].cell) return;
    cells_.remove(pending_[i].cell, i);
    cells_.insert(cell, i);
    pending_[i].cell = cell & (most_cells - 1);
}

// Two bodies, both at the instant of touch; r leads from i to j, v is the velocity of j relative to i.
template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::collide_softly(u32 i, u32 j, const double (&r)[d], const double (&v)[d],
                                                   double distance, double speed) {
    double across[d], square = 0.0;
    for (int k = 0; k < d; ++k) {
        across[k] = v[k] + speed / distance * r[k];
        square += across[k] * across[k];
    }
    const double sideways = math::sqrt(square);
    const PairGeometry pair = geometry(i, j);
    const double touch = radius(i) + radius(j);
    const SoftImpact impact = (*soft_)({pair.effective_mass, touch, speed, sideways, 0.0}, pair,
                                       math::min(radius(i), radius(j)), deepest_);
    if (impact.outcome != Outcome::ok) return give_up(impact.outcome, i, j, speed);
    const DrawnBack& end = impact.drawn_back;
    double change[d], shift[d];
    for (int k = 0; k < d; ++k) {
        const double n = r[k] / distance, t = sideways > 0.0 ? across[k] / sideways : 0.0;
        change[k] = end.normal_velocity * n + end.tangential_velocity * t - v[k];
        shift[k] = end.normal_shift * n + end.tangential_shift * t;
    }
    const double before = dot(v, v);
    const double after =
        end.normal_velocity * end.normal_velocity + end.tangential_velocity * end.tangential_velocity;
    tally_.virial.add(pair.effective_mass * distance * (end.normal_velocity + speed));
    tally_.advance(now_);
    tally_.kinetic -= 0.5 * pair.effective_mass * (before - after);
    const double whole = mass(i) + mass(j);
    shift_body(i, -mass(j) / whole, change, shift);
    shift_body(j, mass(i) / whole, change, shift);
    remember(i, j, impact.duration);
    // Angular momentum: at equal distances the tangential speed is the same.
    const double separation = math::sqrt(math::max(0.0, after - square));
    note(i, j, speed, separation, 0.5 * pair.effective_mass * (before - after), math::infinity);
    ++tally_.pairs;
}

// A body at a wall; away: −1 or 1, the direction that leads from the wall.
template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::meet_wall_softly(u32 i, int axis, double away, double speed) {
    const double m = mass(i), pressing = -away * box_.gravity[axis];
    const i64 wall = wall_number(own_event(axis, away < 0.0));
    const SoftImpact impact =
        (*soft_)({m, math::infinity, speed, 0.0, pressing}, {m, radius(i)}, radius(i), deepest_);
    if (impact.outcome != Outcome::ok) return give_up(impact.outcome, i, wall, speed);
    ++tally_.walls;
    const DrawnBack& end = impact.drawn_back;
    double change[d] = {}, shift[d] = {};
    change[axis] = away * (end.normal_velocity + speed);
    shift[axis] = away * end.normal_shift;
    const double lost = 0.5 * m * (speed - end.normal_velocity) * (speed + end.normal_velocity);
    tally_.advance(now_);
    tally_.kinetic -= lost;
    tally_.momentum[axis] += m * change[axis];
    shift_body(i, 1.0, change, shift);
    remember(i, no_particle, impact.duration, 1 + static_cast<u32>(own_event(axis, away < 0.0)));
    const double dissipated = lost - m * pressing * end.normal_shift;
    const double separation = math::sqrt(math::max(0.0, speed * speed - 2.0 * dissipated / m));
    note(i, wall, speed, separation, dissipated, math::infinity);
}

// Until either has met something else a pair is not to collide again, though drawn back it may overlap and approach.
// Where a body is hit before its last contact is over, both contacts are more than the rule knows of.
template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::remember(u32 i, u32 j, double duration, u32 wall) {
    bool third = now_ < softs_[i].until;
    if (j != no_particle) third = third || now_ < softs_[j].until;
    ++soft_contacts_;
    if (third) ++soft_third_body_;
    softs_[i] = {now_ + duration, j, wall};
    if (j != no_particle) softs_[j] = {now_ + duration, i, 0};
}

// From when on a particle may meet this wall: not before its contact with it is over, though the parabola drawn back
// may lie behind the wall and lead on into it, where gravity pulls the particle off (a ceiling that it just reaches).
template <int d, Motion motion, bool mixed>
double HardSpheres<d, motion, mixed>::free_of_wall(u32 i, int axis, bool high) const {
    const bool met = !softs_.empty() && softs_[i].wall == 1 + static_cast<u32>(own_event(axis, high));
    return met ? math::max(now_, softs_[i].until) : now_;
}

// The particle that this one must not meet, or nobody.
template <int d, Motion motion, bool mixed>
u32 HardSpheres<d, motion, mixed>::last_met(u32 i) const {
    if (softs_.empty()) return no_particle;
    const u32 j = softs_[i].partner;
    return j != no_particle && softs_[j].partner == i ? j : no_particle;
}

}  // namespace hardlimit::boxes
