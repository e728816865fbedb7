// Contacts of finite duration as equivalent collisions: the path of each particle after the contact, a straight line or
// at a wall a parabola, is extrapolated back to the instant of touch, and the particle is moved there.
#pragma once
#include "engine.hpp"

namespace hardlimit::boxes {

// Adds one particle's share of a change of the relative velocity and position.
template <int d, bool mixed>
void HardSpheres<d, mixed>::displace(u32 i, double share, const double (&velocity)[d],
                                     const double (&shift)[d]) {
    Particle<d>& p = particles_[i];
    double changed[d];
    for (int k = 0; k < d; ++k) {
        changed[k] = p.velocity[k] + share * velocity[k];
    }
    set_velocity(i, changed);
    for (int k = 0; k < d; ++k) p.position[k] += share * shift[k];
    if (box_.is_sheared()) {  // the mean flow at the new place is another one
        const double flow = box_.mean_flow(p.position[box_.gradient]);
        const double moved = box_.shear_rate * (share * shift[box_.gradient]);
        double before[d];
        changed[0] -= flow;
        std::copy_n(changed, d, before);
        before[0] += moved;
        accumulators_.from_flow.change(mass(i), before, changed);
    }
    if (falls()) accumulators_.sums.add_potential(-share * mass(i) * dot(accumulators_.gravity, shift));
    update_cell(i);
}

// Moves a displaced particle to its new cell.
template <int d, bool mixed>
void HardSpheres<d, mixed>::update_cell(u32 i) {
    Particle<d>& p = particles_[i];
    const int first = box_.is_sheared() ? 1 : 0;  // fold_into_column() wraps along the first axis
    for (int k = d - 1; k >= first; --k)
        while (box_.wraps(k) && (p.position[k] < 0.0 || p.position[k] > box_.edge[k])) {
            const int step = p.position[k] < 0.0 ? -1 : 1;
            if (box_.is_periodic(k))
                box_.wrap(p.position, p.velocity, image_flags_[i], k, step, p.time);
            else
                cross_sheared_side(i, step);
        }
    const u32 cell = fold_into_column(i);
    if (cell == pending_[i].cell) return;
    cells_.remove(pending_[i].cell, i);
    cells_.insert(cell, i);
    pending_[i].cell = cell & (most_cells - 1);
}

// Contact of two particles at the instant of touch. r: vector from i to j; v: velocity of j relative to i.
template <int d, bool mixed>
void HardSpheres<d, mixed>::contact(u32 i, u32 j, const double (&r)[d], const double (&v)[d], double distance,
                                    double speed, double image_velocity) {
    double across[d], square = 0.0;
    for (int k = 0; k < d; ++k) {
        across[k] = v[k] + speed / distance * r[k];
        square += across[k] * across[k];
    }
    const double tangential = math::sqrt(square);
    const PairGeometry pair = geometry(i, j);
    const double touch = radius(i) + radius(j), smaller = math::min(radius(i), radius(j));
    const SoftContact found = rule_->contact(
        {{pair.effective_mass, touch, speed, tangential, 0.0}, pair, smaller, math::infinity}, deepest_);
    if (found.outcome != Outcome::ok) return end_unsolved(found.outcome, i, j, speed);
    const EquivalentCollision& end = found.collision;
    double change[d], shift[d];
    for (int k = 0; k < d; ++k) {
        const double n = r[k] / distance, t = tangential > 0.0 ? across[k] / tangential : 0.0;
        change[k] = end.normal_velocity * n + end.tangential_velocity * t - v[k];
        shift[k] = end.normal_shift * n + end.tangential_shift * t;
    }
    const double before = dot(v, v);
    const double after =
        end.normal_velocity * end.normal_velocity + end.tangential_velocity * end.tangential_velocity;
    const double lost = 0.5 * pair.effective_mass * (before - after);
    // Virial: d/dt (m r⊗v) = m v⊗v + r⊗F, with the effective mass m. The equivalent collision takes the pair from r⊗v
    // to (r + shift)⊗v' at the instant of touch, and the states after the contact are exact. So the virial
    //   W = m ((r + shift)⊗v' − r⊗v)
    // plus the time integral of m v⊗v along the straight paths is exact over the whole contact. W is symmetric, since
    // the angular momentum is conserved. If a third body takes part, W is as inexact as the states.
    double departing[d];
    for (int k = 0; k < d; ++k) departing[k] = v[k] + change[k];
    accumulators_.add_virial(pair.effective_mass, r, change);
    accumulators_.add_virial(pair.effective_mass, shift, departing);
    if (image_velocity != 0.0)
        accumulators_.shear_work.add(-(pair.effective_mass * change[0]) * image_velocity);
    const double whole = mass(i) + mass(j);
    displace(i, -mass(j) / whole, change, shift);
    displace(j, mass(i) / whole, change, shift);
    remember_contact(i, j, found.duration);
    // Angular momentum is conserved: at equal distances the tangential speed is the same.
    const double separation = math::sqrt(math::max(0.0, after - square));
    record(i, j, speed, separation, lost, math::infinity);
    ++accumulators_.pairs;
}

// Contact of a particle with a wall, in the frame of the wall, whose acceleration is taken as constant during the
// contact. speed: of approach. The parabola of the equivalent collision is in the frame of the wall; the flight after
// the contact is one in the laboratory. An oscillating wall therefore needs the state at the end, extrapolated back
// there.
template <int d, bool mixed>
void HardSpheres<d, mixed>::contact_with_wall(u32 i, const Wall& wall, double speed) {
    const int axis = wall.id.axis();
    const double away = wall.inward(), m = mass(i), g = box_.gravity[axis];
    const double pressing = -away * (g - wall.acceleration(now_));
    const SoftContact found = rule_->contact(
        {{m, math::infinity, speed, 0.0, pressing}, {m, radius(i)}, radius(i), math::infinity}, deepest_);
    if (found.outcome != Outcome::ok) return end_unsolved(found.outcome, i, wall.id.number, speed);
    const EquivalentCollision& end = found.collision;
    double change[d] = {}, shift[d] = {};
    change[axis] = away * (end.normal_velocity + speed);
    shift[axis] = away * end.normal_shift;
    const double lost = 0.5 * m * (speed - end.normal_velocity) * (speed + end.normal_velocity);
    const double dissipated = lost - m * pressing * end.normal_shift;
    double work = m * change[axis] * wall.velocity(now_);
    if (wall.motion.oscillates()) {
        const double t = found.duration, before = particles_[i].velocity[axis];
        const double opening = end.normal_velocity - pressing * t;
        const double beyond = end.normal_shift + t * (end.normal_velocity - 0.5 * pressing * t);
        const double after = wall.velocity(now_ + t) + away * opening - g * t;
        const double moved = wall.position(now_ + t) - wall.position(now_);
        change[axis] = after - before;
        shift[axis] = moved + away * beyond - t * (after + 0.5 * g * t);
        work = 0.5 * m * change[axis] * (after + before) - m * g * shift[axis] + dissipated;
    }
    accumulators_.add_wall(wall.id, m * away * change[axis], work, dissipated);
    displace(i, 1.0, change, shift);
    remember_contact(i, no_particle, found.duration, wall.id);
    const double separation = math::sqrt(math::max(0.0, speed * speed - 2.0 * dissipated / m));
    record(i, wall.id.number, speed, separation, dissipated, math::infinity);
}

// Stores the contact as the last one of both particles. The pair must not collide again before one of them has another
// collision, although its equivalent collision may leave it overlapping and approaching. If a particle is hit before
// its last contact is over, a third body takes part, which the rule does not describe; such contacts are counted.
template <int d, bool mixed>
void HardSpheres<d, mixed>::remember_contact(u32 i, u32 j, double duration, WallId wall) {
    bool third = now_ < last_contacts_[i].until;
    if (j != no_particle) third = third || now_ < last_contacts_[j].until;
    ++soft_contacts_;
    if (third) ++soft_third_body_;
    if (wall) {
        LastContact& last = last_contacts_[i];
        const auto axis = static_cast<std::size_t>(wall.axis());
        last.until = last.wall_until[axis] = now_ + duration;
        last.partner = no_particle, last.wall[axis] = wall;
    } else {
        last_contacts_[i] = {now_ + duration, j};
        last_contacts_[j] = {now_ + duration, i};
    }
}

// Earliest time at which a particle may meet this wall: not before its contact with this wall is over. Until then, the
// parabola of the equivalent collision may lie behind the wall and lead further into it, if gravity pulls the particle
// off the wall (a ceiling that it just reaches).
template <int d, bool mixed>
double HardSpheres<d, mixed>::wall_blocked_until(u32 i, WallId wall) const {
    if (last_contacts_.empty()) return now_;
    const LastContact& last = last_contacts_[i];
    const auto axis = static_cast<std::size_t>(wall.axis());
    return last.wall[axis] == wall ? math::max(now_, last.wall_until[axis]) : now_;
}

// Ends the contacts of a particle with walls at the present instant. Behind a wall, where the parabola of an equivalent
// collision may lead, the particle is moved to its surface. Returns the energy that it gains there [J].
template <int d, bool mixed>
double HardSpheres<d, mixed>::end_wall_contacts(u32 i) {
    double gained = 0.0;
    LastContact& last = last_contacts_[i];
    for (int k = 0; k < d; ++k) {
        const WallId id = std::exchange(last.wall[k], WallId{});
        if (!id || last.wall_until[k] <= now_) continue;
        const Wall wall = box_.wall(id);
        double& x = particles_[i].position[k];
        if (!(wall.distance(x, now_) < radius(i))) continue;
        const double surface = wall.position(now_) + wall.inward() * radius(i);
        gained -= mass(i) * box_.gravity[k] * (surface - x);
        x = surface;
    }
    return gained;
}

// The particle with which this one must not collide, or no_particle.
template <int d, bool mixed>
u32 HardSpheres<d, mixed>::excluded_partner(u32 i) const {
    if (last_contacts_.empty()) return no_particle;
    const u32 j = last_contacts_[i].partner;
    return j != no_particle && last_contacts_[j].partner == i ? j : no_particle;
}

}  // namespace hardlimit::boxes
