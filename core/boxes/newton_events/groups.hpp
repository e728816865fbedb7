// Groups of bodies in contact: begin of contacts, and formation, merging, splitting and end of groups.
#pragma once
#include "engine.hpp"

namespace hardlimit::boxes {

// Particles that overlap initially by more than rounding error start in contact if their force is repulsive.
// `touching`, in ascending order, contains all bodies that overlap with another. Returns whether a body overlaps with
// another or with a wall.
template <class Law>
bool NewtonEvents<Law>::begin_contacts(const std::vector<int>& touching) {
    std::vector<int> bodies;
    std::vector<char> known(particles_.size(), 0);
    std::vector<ActivePair> active;
    const auto overlap = [&](int i, int j, WallId wall, double depth, double rate) {
        if (!(depth > touching_depth * (j < 0 ? radius(i) : radius(i) + radius(j)))) return;
        ActivePair pair = active_pair(i, j, wall);
        if (depth > law(i, j).slack(rate).depth) {
            pair.pair.state = ContactState::closed;
            ++begun_;
            begun_pairs_ += j >= 0;
        } else {
            const double stored = law(i, j).energy(onset_root<Law::onset_power>(depth));
            dissipated_ += stored;
            if (j < 0) walls_.add(wall, 0.0, stored);
        }
        active.push_back(pair);
        for (const int k : {i, j})
            if (k >= 0 && !std::exchange(known[static_cast<std::size_t>(k)], 1)) bodies.push_back(k);
    };
    auto next = touching.begin();
    for (int i = 0; i < static_cast<int>(particles_.size()); ++i) {
        const Particle<3>& p = particles_[i];
        if (next != touching.end() && *next == i) {
            ++next;
            for_neighbours(i, [&](int j, const Vector3& r, const double (&image_velocity)[3]) {
                if (j <= i) return;
                Vector3 v;
                for (std::size_t a = 0; a < 3; ++a)
                    v[a] = (particles_[j].velocity[a] + image_velocity[a]) - p.velocity[a];
                const double distance = math::sqrt(dot(r, r));
                overlap(i, j, {}, (radius(i) + radius(j)) - distance, -dot(r, v) / distance);
            });
        }
        for (int axis = 0; axis < box_.dimension; ++axis) {
            if (!box_.has_walls(axis)) continue;
            for (const bool high : {false, true}) {
                const Wall wall = box_.wall(axis, high);
                overlap(i, -1, wall.id, radius(i) - wall.distance(p.position[axis], now_),
                        -wall.inward() * (p.velocity[axis] - wall.velocity(now_)));
            }
        }
    }
    if (active.empty()) return false;
    split_cluster(bodies, active);
    form_parts();
    return true;
}

// Begins a contact between bodies i and j, or between body i and a wall if j < 0.
template <class Law>
void NewtonEvents<Law>::begin_contact(int i, int j, WallId wall) {
    restart_path(i);
    if (j >= 0) restart_path(j);
    ++begun_;
    begun_pairs_ += j >= 0;
    int third_body = -1;
    if (try_isolated_contact(i, j, wall, third_body)) return;
    ClusterSeed set{{i}, {active_pair(i, j, wall)}};
    set.pairs[0].pair.state = ContactState::closed;
    set.pairs[0].pair.fresh = true;
    if (j >= 0) set.bodies.push_back(j);
    if (third_body >= 0) absorb(third_body, set);
    form_group(set);
}

// A pair that starts to overlap at the current time.
template <class Law>
ActivePair<Law> NewtonEvents<Law>::active_pair(int i, int j, WallId wall) const {
    ActivePair active{};
    active.first = i;
    active.second = j;
    active.pair.state = ContactState::slack;
    active.pair.wall_id = wall;
    active.pair.begin = now_;
    active.pair.impact_speed = math::nan;
    return active;
}

// All groups are integrated up to now and formed again from the contacts that are open.
template <class Law>
double NewtonEvents<Law>::set_velocities(const double* velocity) {
    groups_at_present_.reset();
    ClusterSeed set;
    for (std::size_t index = 0; index < groups_.size(); ++index) {
        const Group& g = groups_[index];
        if (!g.alive) continue;
        set.bodies.insert(set.bodies.end(), g.body.begin(), g.body.end());
        dissolve_group(static_cast<int>(index), false, set.pairs);
    }
    for (ActivePair& active : set.pairs) active.pair.velocity_jumped();
    const std::size_t d = setting_.axes();
    for (int i = 0; i < static_cast<int>(size32()); ++i) {
        restart_path(i);
        std::copy_n(velocity + d * std::size_t{pending_[i].original_index}, d, particles_[i].velocity);
        particles_[i].velocity[0] -= box_.image(pending_[i].image_flags, now_).velocity[0];
    }
    split_cluster(set.bodies, set.pairs);
    form_parts();
    for (int i = 0; i < static_cast<int>(size32()); ++i)
        if (free(i)) reschedule(i);
    return 0.0;
}

template <class Law>
void NewtonEvents<Law>::resolve_conflict(int i, int j) {
    ClusterSeed set;
    for (const int k : {i, j}) absorb(k, set);
    form_group(set);
}

template <class Law>
void NewtonEvents<Law>::end_cluster(int first) {
    const int index = pending_[first].group;
    if (ends_too_deep(index)) return;
    const Group& g = group(index);
    ClusterSeed set{{g.body.begin(), g.body.end()}, {}, g.until};
    const std::vector<int>& bodies = set.bodies;
    dissolve_group(index, true, set.pairs);
    if (bodies.size() >= large_cluster && now_ < set.until && !set.pairs.empty()) return form_group(set);
    split_cluster(bodies, set.pairs);
    form_parts();
    for (const int i : bodies)
        if (free(i)) reschedule(i);
}

// Ends an isolated contact: its members get their own radius back. Their paths continue, and their predicted collisions
// stay valid. Collisions with walls and, in a small box, with other images of the partner must be predicted now.
template <class Law>
void NewtonEvents<Law>::end_isolated_contact(int index) {
    const IsolatedContact& l = group(index).isolated_contact;
    ++ended_;
    largest_compression_ = math::max(largest_compression_, group(index).compression);
    if (setting_.log) log_.push_back(contact_row(group(index), l.pair, l.contact));
    dissipated_ += l.dissipated;
    virial_ += l.virial;
    if (const ContactPair<Law>& q = l.pair; q.second < 0) {
        const double impulse = group(index).wall_impulse, work = q.side * impulse * q.wall_velocity;
        wall_work_ += work;
        walls_.add(q.wall_id, impulse, l.dissipated - work);
    }
    shear_work_ += shear_work_of_contact(group(index));
    const int first = l.body[0], second = l.body[1];
    const auto for_both = [&](const auto& f) {
        f(first);
        if (second >= 0) f(second);
    };
    for_both([&](int i) { release_members(i); });
    discard_group(index);
    if (several_images_) return for_both([&](int i) { reschedule(i); });
    if (!walled_) return;
    for_both([&](int i) {
        set_query(i);
        predict_self_event(i, cells_.place(level_, pending_[i].cell));
        schedule(i);
    });
}

template <class Law>
void NewtonEvents<Law>::form_parts() {
    while (!parts_.empty()) {
        ClusterSeed next = std::move(parts_.back());
        parts_.pop_back();
        form_group(next);
    }
}

// Splits bodies into parts connected by active pairs. Bodies without an active pair stay free.
template <class Law>
void NewtonEvents<Law>::split_cluster(const std::vector<int>& bodies, const std::vector<ActivePair>& active) {
    const MemberIndex member(bodies);
    std::vector<std::size_t> above(bodies.size());
    for (std::size_t m = 0; m < bodies.size(); ++m) above[m] = m;
    const auto root = [&](int body) {
        std::size_t m = member(body);
        while (above[m] != m) m = above[m] = above[above[m]];
        return m;
    };
    for (const ActivePair& pair : active)
        if (pair.second >= 0) above[root(pair.second)] = root(pair.first);
    constexpr std::size_t none = ~std::size_t{0};
    std::vector<std::size_t> part_of(bodies.size(), none);
    for (const ActivePair& pair : active) part_of[root(pair.first)] = 0;
    for (std::size_t& at : part_of) {
        if (at == none) continue;
        at = parts_.size();
        parts_.emplace_back();
    }
    for (const ActivePair& pair : active) parts_[part_of[root(pair.first)]].pairs.push_back(pair);
    for (const int body : bodies)
        if (const std::size_t at = part_of[root(body)]; at != none) parts_[at].bodies.push_back(body);
}

// Sets up the group of a new contact at the current time, without solving it.
template <class Law>
void NewtonEvents<Law>::open_isolated_contact(Group& g, int i, int j, WallId wall) const {
    g.alive = g.isolated = true;
    const std::size_t members = j >= 0 ? 2 : 1;
    g.body.resize(members);
    g.body[0] = i;
    if (j >= 0) g.body[1] = j;
    std::copy_n(particles_[i].position, 3, g.origin.begin());
    g.image_offset.resize(members);
    IsolatedContact& l = g.isolated_contact;
    l.body[0] = i, l.body[1] = j;
    for (std::size_t m = 0; m < members; ++m) set_member(g, m, l.before[m]);
    if (box_.is_sheared())
        g.sheared_energy = sheared_energy(g, [&](std::size_t m) { return l.before[m].velocity; });
    if (j >= 0)
        set_pair(g, 0, 1, l.before[0], l.before[1], l.pair);
    else
        l.pair = wall_pair(g, 0, box_.wall(wall));
    l.pair.state = ContactState::closed;
    l.pair.fresh = true;
    l.pair.begin = now_;
}

// Solves a new contact as isolated if, according to the present predictions, no third body disturbs it. Otherwise
// nothing changes; `third_body` is then the body that is too near, if that is the reason.
template <class Law>
bool NewtonEvents<Law>::try_isolated_contact(int i, int j, WallId wall, int& third_body) {
    const int index = new_group();
    Group& g = group(index);
    open_isolated_contact(g, i, j, wall);
    IsolatedContact& l = g.isolated_contact;
    SeparatedMembers after;
    const std::size_t members = g.body.size();
    const bool solved = j >= 0 ? solve_pair(g, after) : solve_wall(g, after);
    if (solved) set_safety_radii(l);
    if (!solved || !far_from_walls(g, after)) {
        discard_group(index);
        return false;
    }
    for (std::size_t m = 0; m < members; ++m) follow_outgoing_path(index, m, after[m]);
    for (const int k : g.body) {
        predict_events_without(k, members == 1 ? k : g.body[k == i ? 1 : 0]);
        if (pending_[k].pair_time > now_) continue;
        third_body = static_cast<int>(pending_[k].partner);
        revert_group(index);
        return false;
    }
    for (const int k : g.body) schedule(k);
    contact_ends_.push(pending_[i].end, i, index, by_original_index());
    return true;
}

// Forms a cluster of the bodies in the set and of all others that may touch one of them.
template <class Law>
void NewtonEvents<Law>::form_group(ClusterSeed& set) {
    for (;;) {
        const int index = new_group();
        build_cluster(index, set);
        const Cluster<Law>& after = group(index).cluster->after;
        if (after.unresolved || exceeds_step_budget(after)) end_run(Outcome::unresolved, set.bodies);
        if (after.time == 0.0 && ends_too_deep(index)) return;
        std::vector<int> near;
        if (after.time > 0.0 && outcome_ == Outcome::ok)
            for (const int i : set.bodies) {
                predict_events(i);
                if (!(pending_[i].pair_time > now_)) find_third_bodies(i, index, near);
            }
        if (near.empty()) return schedule_group(index);
        revert_group(index);
        const std::size_t before = set.bodies.size();
        for (const int k : near) absorb(k, set);
        if (set.bodies.size() > largest_renewed_cluster) absorb_touching(before, set);
    }
}

// Adds a body to the set, with its whole group and with all bodies it is still in contact with.
template <class Law>
void NewtonEvents<Law>::absorb(int i, ClusterSeed& set) {
    if (std::find(set.bodies.begin(), set.bodies.end(), i) != set.bodies.end()) return;
    if (!free(i)) {
        const int index = pending_[i].group;
        const auto& bodies = group(index).body;
        if (bodies.size() > largest_renewed_cluster) set.until = math::min(set.until, group(index).until);
        dissolve_group(index, false, set.pairs);
        set.bodies.insert(set.bodies.end(), bodies.begin(), bodies.end());
        return;
    }
    for (ClusterSeed& r : parts_) {
        if (std::find(r.bodies.begin(), r.bodies.end(), i) == r.bodies.end()) continue;
        set.bodies.insert(set.bodies.end(), r.bodies.begin(), r.bodies.end());
        set.pairs.insert(set.pairs.end(), r.pairs.begin(), r.pairs.end());
        std::swap(r, parts_.back());
        parts_.pop_back();
        return;
    }
    restart_path(i);
    set.bodies.push_back(i);
}

// Adds all bodies that touch those of the set from index `last` on. form_group() would find them as well, but with one
// attempt per body along a chain of contacts.
template <class Law>
void NewtonEvents<Law>::absorb_touching(std::size_t last, ClusterSeed& set) {
    std::vector<int> near;
    for (; last < set.bodies.size(); ++last) {
        const int i = set.bodies[last];
        near.clear();
        for_neighbours(i, [&](int j, const Vector3& r, const double (&)[3]) {
            const double reach = (particles_[i].radius + particles_[j].radius) * (1.0 + rounding_of_touch);
            if (dot(r, r) < reach * reach) near.push_back(j);
        });
        std::sort(near.begin(), near.end());  // the order within a cell is not saved
        for (const int k : near) absorb(k, set);
    }
}

template <class Law>
void NewtonEvents<Law>::find_third_bodies(int i, int index, std::vector<int>& near) const {
    for_neighbours(i, [&](int j, const Vector3& r, const double (&)[3]) {
        const double reach = particles_[i].radius + particles_[j].radius;
        if (pending_[j].group != index && dot(r, r) < reach * reach &&
            std::find(near.begin(), near.end(), j) == near.end())
            near.push_back(j);
    });
    std::sort(near.begin(), near.end());  // the order within a cell is not saved
}

template <class Law>
void NewtonEvents<Law>::schedule_group(int index) {
    const auto& set = group(index).body;
    if (group(index).cluster->after.time == 0.0) {  // no pair is closed
        std::vector<ActivePair> none;
        dissolve_group(index, true, none);
        for (const int i : set) reschedule(i);
        return;
    }
    largest_cluster_ = std::max(largest_cluster_, static_cast<int>(set.size()));
    for (const int i : set) schedule(i);
}

// Ends the run if a contact of the group has reached the largest compression of its law. Does not change the group.
template <class Law>
bool NewtonEvents<Law>::ends_too_deep(int index) {
    const Group& g = group(index);
    const Cluster<Law>& c = g.cluster->after;
    if (c.too_deep < 0) return false;
    const ContactPair<Law>& q = c.pairs[static_cast<std::size_t>(c.too_deep)];
    std::vector<int> bodies{g.body[static_cast<std::size_t>(q.first)]};
    if (q.second >= 0) bodies.push_back(g.body[static_cast<std::size_t>(q.second)]);
    end_run(Outcome::too_deep, bodies, q.wall_id);
    return true;
}

// Ends the run at these bodies.
template <class Law>
void NewtonEvents<Law>::end_run(Outcome outcome, const std::vector<int>& bodies, WallId wall) {
    if (outcome_ != Outcome::ok) return;
    outcome_ = outcome;
    ended_at_wall_ = wall;
    for (const int i : bodies) ended_by_.push_back(pending_[i].original_index);
    std::sort(ended_by_.begin(), ended_by_.end());
}

}  // namespace hardlimit::boxes
