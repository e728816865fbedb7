// Set-up of clusters: their members, the pairs that may touch, and their state at the begin.
#pragma once
#include <algorithm>
#include <memory>
#include <vector>

#include "../kernels/interface.hpp"
#include "connected_parts.hpp"
#include "frames.hpp"

namespace hardlimit::boxes::events {

// How long a cluster may be integrated in advance.
template <class Law>
struct Horizon {
    const Paths<Law>& paths;
    double displacement;  // that members may cover [m]

    // Integration time of a cluster: until contacts like the present ones are over, but no longer than members take to
    // cover `displacement`. Slack pairs open soon; a slow body in slack contact would need thousands of contact
    // durations to cover this distance.
    double operator()(const ContactGroup<Law>& g) const {
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
            math::min(time_to_cover(displacement, speed + 0.5 * c.image_speed(), c.near_a_wall()),
                      time_to_a_wall(g, speed));
        const double longest = closed > 0.0 ? contacts * closed : contacts_without_force * slack;
        return longest > 0.0 ? math::min(longest, farthest) : farthest;
    }

    // Whether body i may touch a wall while its group lasts.
    bool near_wall(int i, const Wall& wall) const {
        return wall_distance(i, wall) < paths.radius(i) + displacement;
    }

private:
    // Distance of a body's centre from a wall, at the start of its path [m].
    double wall_distance(int i, const Wall& wall) const {
        return wall.distance(paths.particles[i].position[wall.id.axis()], paths.now);
    }
    // Lower bound on the time in which a member covers a distance, from its speed and, near walls, its weight.
    double time_to_cover(double distance, double speed, bool falls) const {
        const double pull = falls ? math::sqrt(dot(paths.box.gravity, paths.box.gravity)) : 0.0;
        return 2.0 * distance / (speed + math::sqrt(speed * speed + 2.0 * distance * pull));
    }
    // Lower bound on the time in which a member and a wall that forms no pair of the cluster meet. It includes the
    // common motion of all members.
    double time_to_a_wall(const ContactGroup<Law>& g, double speed) const {
        double gap = math::infinity;
        for (const int i : g.body)
            for (int axis = 0; axis < paths.box.dimension; ++axis)
                for (const bool high : {false, true})
                    if (const Wall wall = paths.box.wall(axis, high);
                        paths.box.has_walls(axis) && !near_wall(i, wall))
                        gap = math::min(gap, wall_distance(i, wall) - paths.radius(i));
        if (gap == math::infinity) return gap;
        const Vector3 drift = g.cluster->before.frame_velocity();
        return time_to_cover(gap, speed + math::sqrt(dot(drift, drift)) + paths.box.fastest_wall(), true);
    }
};

template <class Law>
struct Clusters {
    using Group = ContactGroup<Law>;

    // A large cluster is integrated for few steps: the cost of integrating a cluster for the duration of a contact
    // grows with the square of its members, because each contact that ends also ends a step of all of them, and any
    // body that comes near restarts the integration. With friction a step costs more: it may be implicit, and each
    // place at which an event is sought then costs another step.
    static constexpr bool rubs = FrictionalLaw<Law>;
    static constexpr std::size_t large_cluster = rubs ? 6 : 50;
    static constexpr long steps_of_large_cluster = rubs ? 8 : 64;
    // Only clusters that come to rest need so many steps. The limit lets a run be stopped between clusters.
    static constexpr long steps_of_small_cluster = rubs ? 500 : 10'000;

    const Paths<Law>& paths;
    const Frames<Law>& frames;
    Horizon<Law> horizon;
    const Observation& sums;  // of the run
    const hardlimit_abi::SeriesKernels& kernels;

    // Sets up the cluster of these bodies, which begins now. Returns how long it may be integrated [s].
    double open(Group& g, ClusterSeed<Law>& seed) const {
        g.alive = true;
        g.isolated = false;
        g.body.assign(seed.bodies);
        frames.open(g);
        if (!g.cluster) g.cluster = std::make_unique<ClusterStates<Law>>();
        Cluster<Law>& c = g.cluster->before;
        reset(c, paths.now);
        for (std::size_t m = 0; m < g.body.size(); ++m) frames.set_member(g, m, c.members.emplace_back());
        if constexpr (FrictionalLaw<Law>)
            for (const int i : g.body) c.rotations.push_back(paths.rotations[static_cast<std::size_t>(i)]);
        frames.begin_shear_work(g, [&](std::size_t m) { return c.members[m].velocity; });
        make_pairs(g, seed.pairs);
        double span = horizon(g);
        const double left = seed.until - paths.now;
        if (left > 1e-6 * span) span = math::min(span, left);  // less is the rounding error of times
        g.until = paths.now + span;
        return span;
    }
    // Integrates the cluster for this time [s], or until its last contact is over.
    void integrate(Group& g, double span) const {
        Cluster<Law>& after = g.cluster->after;
        after = g.cluster->before;
        after.record = true;
        Stop never;
        after.run(span, never,
                  g.body.size() < large_cluster ? steps_of_small_cluster : steps_of_large_cluster);
    }
    // Sets c to the state of the group at its start.
    void set_initial(const Group& g, Cluster<Law>& c) const {
        if (!g.isolated) {
            c = g.cluster->before;
            return;
        }
        reset(c, g.isolated_contact.contact.begin);
        for (std::size_t m = 0; m < g.body.size(); ++m) c.members.push_back(g.isolated_contact.before[m]);
        if constexpr (FrictionalLaw<Law>)
            for (const int i : g.body) c.rotations.push_back(paths.rotations[static_cast<std::size_t>(i)]);
        c.pairs.push_back(g.isolated_contact.pair);
    }
    // After reading a saved state.
    void attach_kernels(ClusterStates<Law>& states) const {
        states.before.kernels = states.after.kernels = &kernels;
    }

private:
    // Clears a cluster, and sets what does not depend on its members.
    void reset(Cluster<Law>& c, double base) const {
        c.clear();
        c.base = base;
        c.gravity = std::to_array(paths.box.gravity);
        c.planar = paths.box.dimension == 2;
        c.largest_coordinate = *std::ranges::max_element(paths.box.edge);
        c.largest_compression = sums.largest_compression;
        c.kernels = &kernels;
    }
    // Adds the pairs that may touch while the cluster lasts, and carries over the state of active pairs.
    void make_pairs(Group& g, ActivePairs<Law>& active) const {
        Cluster<Law>& c = g.cluster->before;
        const std::size_t n = g.body.size();
        std::vector<std::size_t> first(n + 1);  // [members] its first pair
        for (std::size_t i = 0; i < n; ++i) {
            first[i] = c.pairs.size();
            for (std::size_t j = i + 1; j < n; ++j) {
                if (!may_touch(c.members[i], c.members[j])) continue;
                ContactPair<Law> q;
                frames.set_pair(g, static_cast<int>(i), static_cast<int>(j), c.members[i], c.members[j], q);
                if (c.gap(q) < 2.0 * horizon.displacement) c.pairs.push_back(q);
            }
            for (int axis = 0; axis < paths.box.dimension; ++axis)
                for (const bool high : {false, true})
                    if (paths.box.has_walls(axis) && horizon.near_wall(g.body[i], paths.box.wall(axis, high)))
                        c.pairs.push_back(
                            frames.wall_pair(g, static_cast<int>(i), paths.box.wall(axis, high)));
        }
        first[n] = c.pairs.size();
        set_wall_pieces(g);
        const MemberIndex member(g.body);
        for (ActivePair<Law>& l : active) {
            const auto a = static_cast<int>(member(l.first)),
                       b = l.second < 0 ? -1 : static_cast<int>(member(l.second));
            const auto of = static_cast<std::size_t>(b < 0 ? a : std::min(a, b));
            for (std::size_t k = first[of]; k < first[of + 1]; ++k) {
                ContactPair<Law>& q = c.pairs[k];
                const bool same = (q.first == a && q.second == b) || (q.first == b && q.second == a);
                const bool same_wall = b >= 0 || l.pair.wall_id == q.wall_id;
                if constexpr (FrictionalLaw<Law>)
                    if (same && same_wall && q.first != a) l.pair.surfaces.exchange_bodies();
                if (same && same_wall) carry_over(q, l.pair, c);
            }
        }
    }
    // Sets the motion of the walls near the members if one of them oscillates.
    void set_wall_pieces(Group& g) const {
        Cluster<Law>& c = g.cluster->before;
        const auto oscillates = [this](const ContactPair<Law>& q) {
            return q.second < 0 && paths.box.wall(q.wall_id).motion.oscillates();
        };
        if (!paths.box.any_wall() || !std::ranges::any_of(c.pairs, oscillates)) return;
        c.wall_pieces.resize(most_walls);
        for (const ContactPair<Law>& q : c.pairs)
            if (q.second < 0)
                c.wall_pieces[q.wall_id.index()] = paths.box.wall(q.wall_id).piece_from(
                    paths.now, paths.now, g.origin[static_cast<std::size_t>(q.axis)]);
    }
    // Whether two members may be close enough to form a pair: a cheap test that most pairs of a large cluster fail.
    bool may_touch(const Member& a, const Member& b) const {
        Vector3 r;
        for (std::size_t k = 0; k < 3; ++k) r[k] = b.position[k] - a.position[k];
        r = frames.nearest(r);
        const double near = 1.001 * (a.radius + b.radius + 2.0 * horizon.displacement);
        return dot(r, r) < near * near;
    }
    static void carry_over(ContactPair<Law>& q, ContactPair<Law>& old, const Cluster<Law>& c) {
        q.state = old.state;
        q.fresh = old.fresh;
        q.rooted = old.rooted;
        q.s = old.s;
        q.begin = old.begin;
        q.overlapped = old.overlapped;
        q.surfaces = old.surfaces;
        if (math::is_nan(old.impact_speed)) old.impact_speed = c.rate(q);
        q.impact_speed = old.impact_speed;
    }
};

// Limit on the integration steps, summed over members, per body of the box and contact begun. Beyond it contacts are
// persistent: clusters are integrated again and again without a new contact, and time stepping is cheaper. Small
// clusters may use the steps of `fewest_bodies` bodies.
struct StepBudget {
    static constexpr double most_steps = 1e4, fewest_bodies = 1e3;

    double steps = 0.0;    // count towards the limit [steps of a body]
    u64 begun_before = 0;  // contacts at the last update of `steps`

    // Counts the steps of a cluster. `begun`: contacts so far.
    template <class Law>
    bool exceeded_by(const Cluster<Law>& c, int bodies_of_box, u64 begun) {
        const std::size_t members = c.members.size();
        const bool small = members < Clusters<Law>::large_cluster;
        if (small && c.steps() < Clusters<Law>::steps_of_small_cluster) return false;
        const auto bodies = static_cast<double>(bodies_of_box);
        const double most = most_steps * (small ? math::max(bodies, fewest_bodies) : bodies);
        steps = math::max(steps - most_steps * static_cast<double>(begun - begun_before), 0.0);
        begun_before = begun;
        steps += static_cast<double>(members) * static_cast<double>(c.steps());
        return steps > most;
    }
};

}  // namespace hardlimit::boxes::events
