// The state vector of a cluster, its units, and the geometry of a pair.
#pragma once
#include "cluster.hpp"

namespace hardlimit::boxes {

// Replaces the pieces of walls that have ended. Returns when the present ones end, at most `until`; steps along a sine
// are at most a 32nd of its period, so that no event within a step is missed.
template <class Law>
double Cluster<Law>::end_of_pieces(double until) {
    double end = until;
    bool jumps = false;
    for (const ContactPair<Law>& q : pairs) {
        if (q.second >= 0) continue;
        WallPiece& p = wall_pieces[q.wall_id.index()];
        if (p.follow(time, base + time)) {
            known_ = false;
            if (p.amplitude == 0.0) {
                h_ = 0.0;
                jumps = true;
            }
        }
        end = math::min(end, p.end);
        if (p.amplitude != 0.0) end = math::min(end, time + 0.125 * (p.end - p.begin));
    }
    if (jumps)
        for (ContactPair<Law>& q : pairs)
            if (q.second < 0) q.velocity_jumped();
    return end;
}

template <class Law>
void Cluster<Law>::load_state() {
    walls_move_ = !wall_pieces.empty() || std::any_of(pairs.begin(), pairs.end(),
                                                      [](const auto& q) { return q.wall_velocity != 0.0; });
    images_move_ = std::any_of(pairs.begin(), pairs.end(), [](const auto& q) { return q.image_moves; });
    integrates_ = !LinearLaw<Law> || images_move_;
    sine_ = false;
    if (!wall_pieces.empty())
        for (const ContactPair<Law>& q : pairs) {
            if (q.second >= 0) continue;
            sine_ = sine_ || piece(q).amplitude != 0.0;
        }
    wall_slot_.fill(-1);
    touched_walls_ = 0;
    for (const ContactPair<Law>& q : pairs)
        if (q.second < 0 && wall_slot_[q.wall_id.index()] < 0)
            wall_slot_[q.wall_id.index()] = touched_walls_++;
    slot_.assign(pairs.size(), -1);
    rooted_.clear();
    for (std::size_t q = 0; q < pairs.size(); ++q) {
        if (!pairs[q].rooted) continue;
        slot_[q] = first_root_index() + static_cast<int>(rooted_.size());
        rooted_.push_back(static_cast<int>(q));
    }
    y_.assign(static_cast<std::size_t>(dimension()), 0.0);
    for (int i = 0; i < count(); ++i)
        for (int a = 0; a < 3; ++a) {
            y_[3 * i + a] = members[i].position[a];
            y_[3 * (count() + i) + a] = members[i].velocity[a];
        }
    y_[time_index()] = time;
    y_[loss_index()] = dissipated;
    std::ranges::copy(virial.component, &y_[virial_index()]);
    for_touched_walls(
        [&](std::size_t wall, int at) { y_[at] = walls.impulse[wall], y_[at + 1] = walls.energy[wall]; });
    if (walls_move_) y_[wall_work_index()] = wall_work;
    if (images_move_) y_[shear_work_index()] = shear_work;
    for (const int q : rooted_) y_[slot_[q]] = pairs[q].s;
    if (integrates()) resize();
    lightest_ = lightest();
    speed_unit_ = unit_of_speed();
    known_ = false;
    trajectory.clear();
    record_state();
}

template <class Law>
void Cluster<Law>::resize() {
    const auto n = static_cast<std::size_t>(dimension());
    for (auto* v : {&k_, &end_, &k_end_, &trial_, &k_trial_, &tolerance_}) v->resize(n);
    stages_.resize(n * DormandPrince::stages);
    factor_.resize(pairs.size());
}

template <class Law>
void Cluster<Law>::store_state() {
    for (int i = 0; i < count(); ++i)
        for (int a = 0; a < 3; ++a) {
            members[i].position[a] = y_[3 * i + a];
            members[i].velocity[a] = y_[3 * (count() + i) + a];
        }
    dissipated = y_[loss_index()];
    std::copy_n(&y_[virial_index()], SymmetricTensor::size, virial.component);
    for_touched_walls(
        [&](std::size_t wall, int at) { walls.impulse[wall] = y_[at], walls.energy[wall] = y_[at + 1]; });
    if (walls_move_) wall_work = y_[wall_work_index()];
    if (images_move_) shear_work = y_[shear_work_index()];
    for (const int q : rooted_) pairs[q].s = y_[slot_[q]];
}

template <class Law>
void Cluster<Law>::record_state() {
    if (!record) return;
    trajectory.time.push_back(y_[time_index()]);
    trajectory.state.insert(trajectory.state.end(), y_.begin(), y_.begin() + 6 * count());
    if (!integrates()) trajectory.chord_deviation.resize(trajectory.time.size() * members.size());
}

template <class Law>
Vector3 Cluster<Law>::frame_velocity() const {
    Vector3 mean{};
    if (near_a_wall()) {
        for (const ContactPair<Law>& q : pairs)
            if (q.second < 0) mean[static_cast<std::size_t>(q.axis)] = wall_velocity(q, time);
        return mean;
    }
    double mass = 0.0;
    for (const Member& m : members) {
        mass += m.mass;
        for (std::size_t a = 0; a < 3; ++a) mean[a] += m.mass * m.velocity[a];
    }
    for (double& x : mean) x /= mass;
    return mean;
}

template <class Law>
double Cluster<Law>::lightest() const {
    double least = math::infinity;
    for (const Member& m : members) least = math::min(least, m.mass);
    return least;
}

// Speed that the lightest member would have with all energy, kinetic in the cluster's frame and elastic. A second wall
// with another velocity, a wall that changes its velocity, or a moving image does work in this frame: it may add
// several times this difference.
template <class Law>
double Cluster<Law>::unit_of_speed() const {
    const Vector3 mean = frame_velocity();
    double energy = 0.0, gain = 0.0;
    for (const Member& m : members)
        for (int a = 0; a < 3; ++a)
            energy += 0.5 * m.mass * (m.velocity[a] - mean[a]) * (m.velocity[a] - mean[a]);
    for (const ContactPair<Law>& q : pairs) {
        if (q.state == ContactState::closed) energy += q.law.energy(depth_root(q));
        if (q.image_moves) gain = math::max(gain, 4.0 * math::sqrt(dot(q.image_velocity, q.image_velocity)));
        if (q.second >= 0) continue;
        const double other = wall_velocity(q, time) - mean[static_cast<std::size_t>(q.axis)];
        const double change = wall_pieces.empty() ? 0.0 : 2.0 * piece(q).motion.fastest();
        gain = math::max(gain, 4.0 * math::abs(other) + change);
    }
    // Speed that gravity adds within a millionth of a radius, since bodies may lie at rest.
    double smallest = math::infinity;
    for (const Member& m : members) smallest = math::min(smallest, m.radius);
    const double fall = 1e-6 * smallest * math::sqrt(dot(gravity, gravity));
    return math::max(math::sqrt(2.0 * energy / lightest() + fall) + gain, slowest_approach);
}

template <class Law>
void Cluster<Law>::set_scales(ContactPair<Law>& q) const {
    if (q.scaled) return;
    const double mass = math::min(q.mass, lightest_);  // of the lightest member: no contact has more energy
    if constexpr (LinearLaw<Law>) {
        q.s_unit = speed_unit_ * math::sqrt(mass / q.law.elastic_force(1.0));
    } else {
        const double energy = 0.5 * mass * speed_unit_ * speed_unit_;
        q.s_unit = roots::solve_power([&](double x) { return q.law.energy(x); }, energy);
    }
    q.depth_unit = math::power<p>(q.s_unit);
    const auto may_reach = [&](double part) {
        return q.law.energy(onset_root<p>(part * smaller_radius(q))) <= most_energy();
    };
    q.may_be_too_deep = may_reach(deepest_compression);
    q.may_be_deepest = may_reach(largest_compression);
    q.scaled = true;
}

// Upper bound on the energy that one contact can store: all energy, and the work of each member's weight, or of its
// inertia on an accelerated wall, over its radius [J].
template <class Law>
double Cluster<Law>::most_energy() const {
    double pull = math::sqrt(dot(gravity, gravity)), sum = energy_unit();
    for (const WallPiece& p : wall_pieces) pull = math::max(pull, p.motion.greatest_acceleration());
    for (const Member& m : members) sum += m.mass * pull * m.radius;
    return sum;
}

template <class Law>
double Cluster<Law>::time_unit() const {
    double least = math::infinity, least_open = math::infinity;
    for (const ContactPair<Law>& q : pairs) {
        double& of = q.state == ContactState::closed ? least : least_open;
        if (q.scaled) of = math::min(of, q.depth_unit);
    }
    return (least < math::infinity ? least : least_open) /
           speed_unit_;  // without a contact: in flight over a sine
}

// A body at x with the velocity v, and a wall, at the time t since `base`.
template <class Law>
typename Cluster<Law>::Geometry Cluster<Law>::wall_geometry(const ContactPair<Law>& q, const double* x,
                                                            const double* v, double t) const {
    Geometry g{};
    const double away = q.side * (x[q.axis] - wall_position(q, t));
    g.normal[static_cast<std::size_t>(q.axis)] = -q.side;
    g.depth = q.contact_distance - away;
    g.rate = -q.side * (v[q.axis] - wall_velocity(q, t));
    g.distance = math::infinity;
    return g;
}

template <class Law>
typename Cluster<Law>::Geometry Cluster<Law>::geometry(const ContactPair<Law>& q, const double* xa,
                                                       const double* va, const double* xb, const double* vb,
                                                       double t) {
    Geometry g{};
    Vector3 v;
    for (std::size_t a = 0; a < 3; ++a) {
        g.normal[a] = (xb[a] - xa[a]) + q.image[a];
        v[a] = vb[a] - va[a];
    }
    if (q.image_moves) [[unlikely]]
        for (std::size_t a = 0; a < 3; ++a) {
            g.normal[a] += q.image_velocity[a] * t;
            v[a] += q.image_velocity[a];
        }
    g.distance = math::sqrt(dot(g.normal, g.normal));
    const double inverse = 1.0 / g.distance;
    for (double& x : g.normal) x *= inverse;
    g.depth = q.contact_distance - g.distance;
    g.rate = -dot(g.normal, v);
    return g;
}

template <class Law>
double Cluster<Law>::depth_root(const ContactPair<Law>& q) const {
    return q.rooted ? q.s : onset_root<p>(geometry_of_members(q).depth);
}

}  // namespace hardlimit::boxes
