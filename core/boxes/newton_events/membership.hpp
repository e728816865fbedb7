// Membership of bodies in groups: entering, leaving, and ending a group.
#pragma once
#include "engine.hpp"

namespace hardlimit::boxes {

template <class Law>
int NewtonEvents<Law>::new_group() {
    if (free_groups_.empty()) {
        groups_.emplace_back();
        return static_cast<int>(groups_.size()) - 1;
    }
    const int index = free_groups_.back();
    free_groups_.pop_back();
    return index;
}

template <class Law>
void NewtonEvents<Law>::join_group(int i, int index, std::size_t m, double span) {
    BodyEvents& e = pending_[i];
    e.group = index;
    e.end = now_ + span;
    e.first = m == 0;
    e.clustered = !group(index).isolated;
}

template <class Law>
void NewtonEvents<Law>::release_members(int i) {
    BodyEvents& e = pending_[i];
    e.group = -1;
    e.end = math::infinity;
    e.first = e.clustered = false;
    particles_[i].radius = radius(i);
}

// Frees a member at its true position and velocity.
template <class Law>
void NewtonEvents<Law>::restart_body(const Group& g, std::size_t m, const Member& at) {
    const int i = g.body[m];
    Particle<3>& p = particles_[i];
    const Vector3 x = body_position(g, m, at.position, now_), v = body_velocity(g, m, at.velocity);
    std::copy_n(x.data(), 3, p.position);
    std::copy_n(v.data(), 3, p.velocity);
    p.time = now_;
    release_members(i);
    ++pending_[i].count;
}

// Position of a member in the frame of its body's cell.
template <class Law>
Vector3 NewtonEvents<Law>::body_position(const Group& g, std::size_t m, Vector3 x, double time) const {
    const ImageMotion image = cell_frame(g, m, time);
    for (std::size_t a = 0; a < 3; ++a) x[a] += g.origin[a] + image.shift[a];
    return x;
}

// Velocity of a member in the frame of its body's cell.
template <class Law>
Vector3 NewtonEvents<Law>::body_velocity(const Group& g, std::size_t m, Vector3 v) const {
    if (!box_.is_sheared()) return v;
    const ImageMotion image = cell_frame(g, m, now_);
    for (std::size_t a = 0; a < 3; ++a) v[a] += image.velocity[a];
    return v;
}

// Ends a group at the current time: all members become free bodies, and `active` receives the pairs still active.
template <class Law>
void NewtonEvents<Law>::dissolve_group(int index, bool at_end, std::vector<ActivePair>& active) {
    Group& g = group(index);
    if (!g.cluster) g.cluster = std::make_unique<ClusterStates>();
    if (!at_end) {
        initial_cluster(g, g.cluster->after);
        g.cluster->after.run_through(now_ - g.cluster->after.base);
        if (g.cluster->after.unresolved) end_run(Outcome::unresolved, {g.body.begin(), g.body.end()});
    }
    const Cluster<Law>& c = g.cluster->after;
    dissipated_ += c.dissipated;
    virial_ += c.virial;
    wall_work_ += c.wall_work;
    walls_ += c.walls;
    shear_work_ += c.shear_work + shear_work(g, [&](std::size_t m) { return c.members[m].velocity; });
    largest_compression_ = math::max(largest_compression_, c.largest_compression);
    begun_ += static_cast<std::uint64_t>(c.begun);
    begun_pairs_ += static_cast<std::uint64_t>(c.begun_pairs);
    if (!g.isolated) clustered_ += (now_ - c.base) * static_cast<double>(g.body.size());
    for (const EndedContact& e : c.ended) log(g, c.pairs[static_cast<std::size_t>(e.pair)], e);
    for (std::size_t m = 0; m < g.body.size(); ++m) restart_body(g, m, c.members[m]);
    for (const ContactPair<Law>& q : c.pairs) {
        if (q.state == ContactState::open) continue;
        const int second = q.second < 0 ? -1 : g.body[static_cast<std::size_t>(q.second)];
        active.push_back({g.body[static_cast<std::size_t>(q.first)], second, q});
    }
    discard_group(index);
}

// Reverts build_cluster() and try_isolated_contact(): the members are free bodies at their present positions.
template <class Law>
void NewtonEvents<Law>::revert_group(int index) {
    Group& g = group(index);
    for (std::size_t m = 0; m < g.body.size(); ++m) {
        const int i = g.body[m];
        const Member& before = g.isolated ? g.isolated_contact.before[m] : g.cluster->before.members[m];
        const Vector3 x = body_position(g, m, before.position, now_),
                      v = body_velocity(g, m, before.velocity);
        release_members(i);
        std::copy_n(x.data(), 3, particles_[i].position);
        std::copy_n(v.data(), 3, particles_[i].velocity);
    }
    discard_group(index);
}

// Frees the record of a group, and prefetches it, since the next group will soon reuse it.
template <class Law>
void NewtonEvents<Law>::discard_group(int index) {
    Group& g = group(index);
    g.alive = false;
    free_groups_.push_back(index);
    if (!prefetches_) return;
    for (std::size_t k = 0; k < sizeof g; k += 64) prefetch(reinterpret_cast<const char*>(&g) + k);
}

}  // namespace hardlimit::boxes
