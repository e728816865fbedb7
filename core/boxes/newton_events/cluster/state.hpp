// The state vector of a cluster, its units, and the geometry of a pair.
#pragma once
#include "cluster.hpp"

namespace hardlimit::boxes {

template <class Law>
void Cluster<Law>::load_state() {
    walls_move_ =
        std::any_of(pairs.begin(), pairs.end(), [](const auto& q) { return q.wall_velocity != 0.0; });
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
    if (walls_move_) y_[wall_work_index()] = wall_work;
    for (const int q : rooted_) y_[slot_[q]] = pairs[q].s;
    if constexpr (!LinearLaw<Law>) resize();
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
    if (walls_move_) wall_work = y_[wall_work_index()];
    for (const int q : rooted_) pairs[q].s = y_[slot_[q]];
}

template <class Law>
void Cluster<Law>::record_state() {
    if (!record) return;
    trajectory.time.push_back(y_[time_index()]);
    trajectory.state.insert(trajectory.state.end(), y_.begin(), y_.begin() + 6 * count());
    if constexpr (LinearLaw<Law>) trajectory.chord_deviation.resize(trajectory.time.size() * members.size());
}

template <class Law>
Vector3 Cluster<Law>::frame_velocity() const {
    Vector3 mean{};
    if (near_a_wall()) {
        for (const ContactPair<Law>& q : pairs)
            if (q.second < 0) mean[static_cast<std::size_t>(q.axis)] = q.wall_velocity;
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
// with another velocity does work in this frame: it may add several times its relative velocity.
template <class Law>
double Cluster<Law>::unit_of_speed() const {
    const Vector3 mean = frame_velocity();
    double energy = 0.0, gain = 0.0;
    for (const Member& m : members)
        for (int a = 0; a < 3; ++a)
            energy += 0.5 * m.mass * (m.velocity[a] - mean[a]) * (m.velocity[a] - mean[a]);
    for (const ContactPair<Law>& q : pairs) {
        if (q.state == ContactState::closed) energy += q.law.energy(depth_root(q));
        if (q.second >= 0) continue;
        gain = math::max(gain, 4.0 * math::abs(q.wall_velocity - mean[static_cast<std::size_t>(q.axis)]));
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

// Upper bound on the energy that one contact can store: all energy, and the work of each member's weight over its
// radius [J].
template <class Law>
double Cluster<Law>::most_energy() const {
    const double pull = math::sqrt(dot(gravity, gravity));
    double sum = energy_unit();
    for (const Member& m : members) sum += m.mass * pull * m.radius;
    return sum;
}

template <class Law>
double Cluster<Law>::time_unit() const {
    double least = math::infinity;
    for (const ContactPair<Law>& q : pairs)
        if (q.state == ContactState::closed) least = math::min(least, q.depth_unit);
    return least / speed_unit_;
}

// A body at x with the velocity v, and a wall, at the time t since `base`.
template <class Law>
typename Cluster<Law>::Geometry Cluster<Law>::wall_geometry(const ContactPair<Law>& q, const double* x,
                                                            const double* v, double t) {
    Geometry g{};
    const double away = q.side * (x[q.axis] - q.wall_position(t));
    g.normal[static_cast<std::size_t>(q.axis)] = -q.side;
    g.depth = q.contact_distance - away;
    g.rate = -q.side * (v[q.axis] - q.wall_velocity);
    g.distance = math::infinity;
    return g;
}

template <class Law>
typename Cluster<Law>::Geometry Cluster<Law>::geometry(const ContactPair<Law>& q, const double* xa,
                                                       const double* va, const double* xb, const double* vb) {
    Geometry g{};
    Vector3 v;
    for (std::size_t a = 0; a < 3; ++a) {
        g.normal[a] = (xb[a] - xa[a]) + q.image[a];
        v[a] = vb[a] - va[a];
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
