// Set-up of a cluster: members, pairs that may touch, and the integration time.
#pragma once
#include "engine.hpp"

namespace hardlimit::boxes {

// Integrates a cluster of these bodies from the current time, and makes its members busy. The time is halved until the
// cells are wide enough for the safety radii.
template <class Law>
void NewtonEvents<Law>::build_cluster(int index, ClusterSeed& set) {
    Group& g = group(index);
    open_group(g, set.bodies);
    make_pairs(g, set.pairs);
    const Cluster<Law>& before = g.cluster->before;
    Cluster<Law>& after = g.cluster->after;
    double horizon = horizon_of(g);
    const double left = set.until - now_;
    if (left > 1e-6 * horizon) horizon = math::min(horizon, left);  // less is the rounding error of times
    g.until = now_ + horizon;
    for (;;) {
        after = before;
        after.record = true;
        Stop never;
        after.run(horizon, never,
                  set.bodies.size() < large_cluster ? steps_of_small_cluster : steps_of_large_cluster);
        if (set_safety_radii(index) || after.time == 0.0 || after.unresolved) break;
        horizon = 0.5 * after.time;
    }
    after.trajectory.clear();
}

// Whether contacts are persistent: clusters are integrated again and again without a new contact.
template <class Law>
bool NewtonEvents<Law>::exceeds_step_budget(const Cluster<Law>& c) {
    const std::size_t members = c.members.size();
    const bool small = members < large_cluster;
    if (small && c.steps() < steps_of_small_cluster) return false;
    const auto bodies = static_cast<double>(particles_.size());
    const double most = most_integration_steps * (small ? math::max(bodies, fewest_bodies) : bodies);
    integration_steps_ = math::max(
        integration_steps_ - most_integration_steps * static_cast<double>(begun_ - begun_before_), 0.0);
    begun_before_ = begun_;
    integration_steps_ += static_cast<double>(members) * static_cast<double>(c.steps());
    return integration_steps_ > most;
}

// Clears a cluster, and sets what does not depend on its members.
template <class Law>
void NewtonEvents<Law>::reset_cluster(Cluster<Law>& c, double base) const {
    c.clear();
    c.base = base;
    c.gravity = gravity_;
    c.largest_coordinate = *std::ranges::max_element(box_.edge);
    c.largest_compression = largest_compression_;
    c.kernels = series_;
}

// A cluster of these bodies at the current time, without pairs.
template <class Law>
void NewtonEvents<Law>::open_group(Group& g, const std::vector<int>& set) const {
    g.alive = true;
    g.isolated = false;
    g.body.assign(set);
    std::copy_n(particles_[set[0]].position, 3, g.origin.begin());
    g.image_offset.resize(set.size());
    if (!g.cluster) g.cluster = std::make_unique<ClusterStates>();
    Cluster<Law>& c = g.cluster->before;
    reset_cluster(c, now_);
    for (std::size_t m = 0; m < set.size(); ++m) set_member(g, m, c.members.emplace_back());
    if (box_.is_sheared())
        g.sheared_energy = sheared_energy(g, [&](std::size_t m) { return c.members[m].velocity; });
}

// Sets a member from the image of its body that is nearest to the group's origin, and stores which image that is. Works
// element by element: wider loads just after narrow stores would stall (store forwarding).
template <class Law>
void NewtonEvents<Law>::set_member(Group& g, std::size_t m, Member& member) const {
    const int i = g.body[m];
    const Particle<3>& p = particles_[i];
    member.mass = mass(i);
    member.radius = radius(i);
    if (box_.is_sheared()) return set_sheared_member(g, m, member);
    for (std::size_t a = 0; a < 3; ++a) {
        const double x = p.position[a] - g.origin[a];
        const double period = nearest_period(x, static_cast<int>(a));
        member.position[a] = x - period * box_.edge[a];
        member.velocity[a] = p.velocity[a];
        g.image_offset[m][a] = pending_[i].image_flags[a] + period;
    }
}

// Adds the pairs that may touch while the cluster lasts, and carries over the state of active pairs.
template <class Law>
void NewtonEvents<Law>::make_pairs(Group& g, std::vector<ActivePair>& active) const {
    Cluster<Law>& c = g.cluster->before;
    const std::size_t n = g.body.size();
    std::vector<std::size_t> first(n + 1);  // [members] its first pair
    for (std::size_t i = 0; i < n; ++i) {
        first[i] = c.pairs.size();
        for (std::size_t j = i + 1; j < n; ++j) {
            if (!may_touch(c.members[i], c.members[j])) continue;
            ContactPair<Law> q;
            set_pair(g, static_cast<int>(i), static_cast<int>(j), c.members[i], c.members[j], q);
            if (c.gap(q) < 2.0 * largest_displacement_) c.pairs.push_back(q);
        }
        for (int axis = 0; axis < box_.dimension; ++axis)
            for (const bool high : {false, true})
                if (box_.has_walls(axis) && near_wall(g.body[i], box_.wall(axis, high)))
                    c.pairs.push_back(wall_pair(g, static_cast<int>(i), box_.wall(axis, high)));
    }
    first[n] = c.pairs.size();
    set_wall_pieces(g);
    const MemberIndex member(g.body);
    for (ActivePair& l : active) {
        const auto a = static_cast<int>(member(l.first)),
                   b = l.second < 0 ? -1 : static_cast<int>(member(l.second));
        const auto of = static_cast<std::size_t>(b < 0 ? a : std::min(a, b));
        for (std::size_t k = first[of]; k < first[of + 1]; ++k) {
            ContactPair<Law>& q = c.pairs[k];
            const bool same = (q.first == a && q.second == b) || (q.first == b && q.second == a);
            const bool same_wall = b >= 0 || l.pair.wall_id == q.wall_id;
            if (same && same_wall) carry_over(q, l.pair, c);
        }
    }
}

// Sets the motion of the walls near the members if one of them oscillates.
template <class Law>
void NewtonEvents<Law>::set_wall_pieces(Group& g) const {
    Cluster<Law>& c = g.cluster->before;
    const auto oscillates = [this](const ContactPair<Law>& q) {
        return q.second < 0 && box_.wall(q.wall_id).motion.oscillates();
    };
    if (!walled_ || !std::ranges::any_of(c.pairs, oscillates)) return;
    c.wall_pieces.resize(most_walls);
    for (const ContactPair<Law>& q : c.pairs)
        if (q.second < 0)
            c.wall_pieces[q.wall_id.index()] =
                box_.wall(q.wall_id).piece_from(now_, now_, g.origin[static_cast<std::size_t>(q.axis)]);
}

// Whether two members may be close enough to form a pair: a cheap test that most pairs of a large cluster fail.
template <class Law>
bool NewtonEvents<Law>::may_touch(const Member& a, const Member& b) const {
    double square = 0.0;
    if (box_.is_sheared()) {
        Vector3 r;
        for (std::size_t k = 0; k < 3; ++k) r[k] = b.position[k] - a.position[k];
        const BodyImage image = nearest_image(r);
        for (std::size_t k = 0; k < 3; ++k) r[k] -= image.motion.shift[k];
        square = dot(r, r);
    } else {
        for (int k = 0; k < 3; ++k) {
            const auto s = static_cast<std::size_t>(k);
            const double x = b.position[s] - a.position[s], r = x - nearest_period(x, k) * box_.edge[s];
            square += r * r;
        }
    }
    const double near = 1.001 * (a.radius + b.radius + 2.0 * largest_displacement_);
    return square < near * near;
}

template <class Law>
void NewtonEvents<Law>::carry_over(ContactPair<Law>& q, ContactPair<Law>& old, const Cluster<Law>& c) const {
    q.state = old.state;
    q.fresh = old.fresh;
    q.rooted = old.rooted;
    q.s = old.s;
    q.begin = old.begin;
    q.overlapped = old.overlapped;
    if (math::is_nan(old.impact_speed)) old.impact_speed = c.rate(q);
    q.impact_speed = old.impact_speed;
}

// Number of periods by which the nearest image of x is shifted.
template <class Law>
double NewtonEvents<Law>::nearest_period(double x, int axis) const {
    return math::round_small(x * query_.per_edge[axis]);
}

template <class Law>
void NewtonEvents<Law>::set_pair(const Group& g, int i, int j, const Member& a, const Member& b,
                                 ContactPair<Law>& q) const {
    q = {};
    q.first = i;
    q.second = j;
    if (box_.is_sheared()) {
        set_sheared_image(a, b, q);
    } else {
        for (int k = 0; k < 3; ++k) {
            const auto s = static_cast<std::size_t>(k);
            q.image[s] = -nearest_period(b.position[s] - a.position[s], k) * box_.edge[s];
        }
    }
    q.contact_distance = a.radius + b.radius;
    q.mass = effective(a.mass, b.mass);
    laws_.put(g.body[static_cast<std::size_t>(i)], g.body[static_cast<std::size_t>(j)], q.law);
}

template <class Law>
bool NewtonEvents<Law>::near_wall(int i, const Wall& wall) const {
    return wall_distance(i, wall) < radius(i) + largest_displacement_;
}

// Distance of a body's centre from a wall, at the start of its path [m].
template <class Law>
double NewtonEvents<Law>::wall_distance(int i, const Wall& wall) const {
    return wall.distance(particles_[i].position[wall.id.axis()], now_);
}

template <class Law>
ContactPair<Law> NewtonEvents<Law>::wall_pair(const Group& g, int i, const Wall& wall) const {
    const int body = g.body[static_cast<std::size_t>(i)];
    ContactPair<Law> q{};
    q.first = i;
    q.second = -1;
    q.wall_id = wall.id;
    q.axis = wall.id.axis();
    q.side = wall.inward();
    q.wall = wall.position(now_) - g.origin[static_cast<std::size_t>(q.axis)];
    q.wall_velocity = wall.velocity(now_);
    q.contact_distance = radius(body);
    q.mass = mass(body);
    q.law = law(body, -1);
    return q;
}

// Integration time of a cluster: until contacts like the present ones are over, but no longer than members take to
// cover largest_displacement_. Slack pairs open soon; a slow body in slack contact would need thousands of contact
// durations to cover this distance.
template <class Law>
double NewtonEvents<Law>::horizon_of(const Group& g) const {
    const Cluster<Law>& c = g.cluster->before;
    // A contact under Hertz's force lasts without end at zero speed: at least 1e-3 of the cluster's speed is used.
    constexpr double contacts = 1.5, contacts_without_force = 100.0;
    const double speed = c.speed();
    double closed = 0.0, slack = 0.0;
    for (const ContactPair<Law>& q : c.pairs) {
        if (q.state == ContactState::open) continue;
        double& longest = q.state == ContactState::closed ? closed : slack;
        longest = math::max(longest, q.law.duration(math::max(q.impact_speed, 1e-3 * speed), q.mass));
    }
    // A moving image counts half for each of its two bodies.
    const double farthest =
        math::min(time_to_cover(largest_displacement_, speed + 0.5 * c.image_speed(), c.near_a_wall()),
                  time_to_a_wall(g, speed));
    const double longest = closed > 0.0 ? contacts * closed : contacts_without_force * slack;
    return longest > 0.0 ? math::min(longest, farthest) : farthest;
}

// Lower bound on the time in which a member covers a distance, from its speed and, near walls, its weight.
template <class Law>
double NewtonEvents<Law>::time_to_cover(double distance, double speed, bool falls) const {
    const double pull = falls ? math::sqrt(dot(gravity_, gravity_)) : 0.0;
    return 2.0 * distance / (speed + math::sqrt(speed * speed + 2.0 * distance * pull));
}

// Lower bound on the time in which a member and a wall that forms no pair of the cluster meet. It includes the common
// motion of all members.
template <class Law>
double NewtonEvents<Law>::time_to_a_wall(const Group& g, double speed) const {
    double gap = math::infinity;
    for (const int i : g.body)
        for (int axis = 0; axis < box_.dimension; ++axis)
            for (const bool high : {false, true})
                if (const Wall wall = box_.wall(axis, high); box_.has_walls(axis) && !near_wall(i, wall))
                    gap = math::min(gap, wall_distance(i, wall) - radius(i));
    if (gap == math::infinity) return gap;
    const Vector3 drift = g.cluster->before.frame_velocity();
    return time_to_cover(gap, speed + math::sqrt(dot(drift, drift)) + box_.fastest_wall(), true);
}

// Sets c to the state of the group at its start.
template <class Law>
void NewtonEvents<Law>::initial_cluster(const Group& g, Cluster<Law>& c) const {
    if (!g.isolated) {
        c = g.cluster->before;
        return;
    }
    reset_cluster(c, g.isolated_contact.contact.begin);
    for (std::size_t m = 0; m < g.body.size(); ++m) c.members.push_back(g.isolated_contact.before[m]);
    c.pairs.push_back(g.isolated_contact.pair);
}

}  // namespace hardlimit::boxes
