// Safety radii of bodies in contact: bounds on the distance of a true path from the path used for predictions.
#pragma once
#include "engine.hpp"

namespace hardlimit::boxes {

// Makes all members busy, with their safety radii. Returns whether the cells are wide enough for these.
template <class Law>
bool NewtonEvents<Law>::set_safety_radii(int index) {
    const Group& g = group(index);
    const Cluster<Law>&before = g.cluster->before, &after = g.cluster->after;
    bool fits = true;
    for (std::size_t m = 0; m < g.body.size(); ++m) {
        assign_path(index, m, before.members[m], after.members[m], after.time);
        if (!(after.time > 0.0)) continue;
        const double safety_radius = deviation_from_path(g, m);
        set_radius(g.body[m], safety_radius);
        fits = fits && safety_radius <= largest_safety_radius_;
    }
    return fits;
}

// Largest distance of a member's true path from its parabola. Between steps the chord deviation is added. If that is
// unknown, the distance is close to a cubic within a step: it exceeds its values at the ends by at most a quarter of
// the step times the larger slope, and 0.3 of it leaves a margin for the terms of higher order.
template <class Law>
double NewtonEvents<Law>::deviation_from_path(const Group& g, std::size_t m) const {
    const std::size_t n = g.body.size();
    const Vector3& x0 = g.cluster->before.members[m].position;
    Vector3 chord;
    std::copy_n(particles_[g.body[m]].velocity, 3, chord.begin());
    if (box_.is_sheared()) chord[0] -= cell_frame(g, m, now_).velocity[0];
    const Trajectory& trajectory = g.cluster->after.trajectory;
    double largest = 0.0, last = 0.0, last_rate = 0.0, last_time = 0.0;
    for (std::size_t k = 0; k < trajectory.time.size(); ++k) {
        const double t = trajectory.time[k];
        const double *x = &trajectory.state[6 * n * k + 3 * m], *v = x + 3 * n;
        double off = 0.0, rate = 0.0;
        for (std::size_t a = 0; a < 3; ++a) {
            const double gt = box_.gravity[a] * t;
            const double e = x[a] - (x0[a] + t * (chord[a] + 0.5 * gt));
            const double d = v[a] - (chord[a] + gt);
            off += e * e;
            rate += d * d;
        }
        off = math::sqrt(off);
        rate = math::sqrt(rate);
        const bool known = !trajectory.chord_deviation.empty();
        const double chord_deviation = known ? trajectory.chord_deviation[n * k + m]
                                             : 0.3 * (t - last_time) * math::max(rate, last_rate);
        largest = math::max(largest, math::max(off, last) + chord_deviation);
        last = off;
        last_rate = rate;
        last_time = t;
    }
    return 1.01 * largest;
}

// Puts a member of a cluster on the parabola through both ends of its path until its group ends.
template <class Law>
void NewtonEvents<Law>::assign_path(int index, std::size_t m, const Member& before, const Member& after,
                                    double span) {
    const int i = group(index).body[m];
    join_group(i, index, m, span);
    set_radius(i, 0.0);
    if (!(span > 0.0)) return;
    for (std::size_t a = 0; a < 3; ++a)
        particles_[i].velocity[a] =
            (after.position[a] - before.position[a]) / span - 0.5 * span * box_.gravity[a];
    if (box_.is_sheared()) particles_[i].velocity[0] += cell_frame(group(index), m, now_).velocity[0];
}

// Sets the safety radius of each member from its share of the deviation of the relative path.
template <class Law>
void NewtonEvents<Law>::set_safety_radii(IsolatedContact& l) const {
    const Member(&b)[2] = l.before;
    for (std::size_t m = 0; m < 2; ++m) {
        l.share[m] = l.body[1] < 0 ? 1.0 : b[1 - m].mass / (b[0].mass + b[1].mass);
        l.safety_radius[m] = l.share[m] * l.deviation * l.rotation;
    }
}

// Puts a member of an isolated contact on its outgoing path, with a larger radius, until the contact ends.
template <class Law>
void NewtonEvents<Law>::follow_outgoing_path(int index, std::size_t m, const Member& after) {
    const IsolatedContact& l = group(index).isolated_contact;
    const int i = l.body[m];
    join_group(i, index, m, l.span);
    set_radius(i, l.share[m] * l.deviation);
    for (std::size_t a = 0; a < 3; ++a) {
        const double v = after.velocity[a] - l.span * box_.gravity[a];
        const double x = after.position[a] - l.span * (v + 0.5 * l.span * box_.gravity[a]);
        particles_[i].velocity[a] = v;
        particles_[i].position[a] += x - l.before[m].position[a];
    }
    if (box_.is_sheared()) particles_[i].velocity[0] += cell_frame(group(index), m, now_).velocity[0];
}

// Sets a radius including the safety radius. It is enlarged by the overlap that counts as rounding error.
template <class Law>
void NewtonEvents<Law>::set_radius(int i, double safety_radius) {
    particles_[i].radius = (radius(i) + safety_radius) * (1.0 + rounding_of_touch);
}

template <class Law>
double NewtonEvents<Law>::largest_safety_use(int instants) const {
    double most = 0.0;
    Cluster<Law> c;
    for (const Group& g : groups_) {
        if (!g.alive) continue;
        initial_cluster(g, c);
        const double span = pending_[g.body[0]].end - c.base;
        for (int k = 0; k <= instants; ++k) {
            const double time = span * k / instants;
            c.run_through(time);
            for (std::size_t m = 0; m < g.body.size(); ++m)
                most = math::max(
                    most, safety_radius_used(g, m, body_position(g, m, c.members[m].position, c.base + time),
                                             c.base + time));
        }
    }
    return most;
}

// Speed that two bodies gain from the compression by rounding at touch, which the solution of an isolated contact
// leaves out. Under a law that is not linear an impact at a far lower speed lasts so long that this moves them visibly.
template <class Law>
double NewtonEvents<Law>::speed_from_rounding(const Group& g) const {
    const ContactPair<Law>& q = g.isolated_contact.pair;
    const double depth = 4.0 * math::epsilon * *std::ranges::max_element(box_.edge);
    return math::sqrt(2.0 * q.law.energy(onset_root<Law::onset_power>(depth)) / q.mass);
}

// Part of a member's safety radius that is used at its true position `at`. In an isolated contact the safety region
// shrinks with time and lies on one side of the path: stays_clear() must be false for a point at the true position.
template <class Law>
double NewtonEvents<Law>::safety_radius_used(const Group& g, std::size_t m, const Vector3& at,
                                             double time) const {
    const int i = g.body[m];
    const Vector3 path = position(i, time);
    double rounding = 1e-10 * radius(i);  // including the error of a contact table
    if (g.isolated) rounding += speed_from_rounding(g) * (time - g.isolated_contact.contact.begin);
    Vector3 off;
    for (std::size_t a = 0; a < 3; ++a) off[a] = at[a] - path[a];
    const double far = math::sqrt(dot(off, off));
    if (!g.isolated) return far / (particles_[i].radius - radius(i) + rounding);
    if (stays_clear({off, {}}, i, i, time, rounding - radius(i))) return math::infinity;
    const double left = math::max(pending_[i].end - time, 0.0) / g.isolated_contact.span;
    return far / (g.isolated_contact.share[pending_[i].first ? 0 : 1] * g.isolated_contact.deviation * left +
                  rounding);
}

}  // namespace hardlimit::boxes
