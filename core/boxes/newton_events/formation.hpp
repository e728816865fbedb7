// Formation, merging and splitting of clusters.
#pragma once
#include <algorithm>
#include <utility>
#include <vector>

#include "connected_parts.hpp"
#include "membership.hpp"
#include "predict.hpp"
#include "schedule.hpp"

namespace hardlimit::boxes::events {

template <class Law>
struct Formation {
    using Group = ContactGroup<Law>;
    using Seed = ClusterSeed<Law>;
    using Pairs = ActivePairs<Law>;

    // Largest cluster that is integrated for a full horizon again when another body joins it. A larger one keeps its
    // time of end, and then splits into connected parts. Otherwise bodies that separated long ago would stay members,
    // and in a large gas a cluster would grow without bound.
    static constexpr std::size_t largest_renewed_cluster = 8;

    Paths<Law>& paths;
    const BodyCells<Law>& cells;
    Groups<Law>& groups;
    const Clusters<Law>& clusters;
    Membership<Law>& members;
    Predictor<Law>& predictor;
    Schedule<Law>& schedule;
    Ledger<Law>& ledger;
    StepBudget budget{};
    std::vector<Seed> parts{};  // of ended clusters, still in contact; empty between events

    // Forms a cluster of the bodies in the seed and of all others that may touch one of them.
    void form(Seed& seed) {
        for (;;) {
            const int index = groups.add();
            build(index, seed);
            const Cluster<Law>& after = groups[index].cluster->after;
            if (after.unresolved || budget.exceeded_by(after, paths.size(), ledger.sums.begun))
                ledger.end_run(Outcome::unresolved, seed.bodies);
            if (after.time == 0.0 && ends_too_deep(index)) return;
            const std::vector<int> near = third_bodies(index);
            if (near.empty()) return schedule_cluster(index);
            members.revert(index);
            const std::size_t before = seed.bodies.size();
            for (const int k : near) absorb(k, seed);
            if (seed.bodies.size() > largest_renewed_cluster) absorb_touching(before, seed);
        }
    }
    // Forms a cluster of each part of these bodies that is connected by active pairs.
    void form_parts(const std::vector<int>& bodies, const Pairs& active) {
        parts = connected_parts(bodies, active);
        while (!parts.empty()) {
            Seed next = std::move(parts.back());
            parts.pop_back();
            form(next);
        }
    }
    // Adds a body to the seed, with its whole group and with all bodies it is still in contact with.
    void absorb(int i, Seed& seed) {
        if (std::find(seed.bodies.begin(), seed.bodies.end(), i) != seed.bodies.end()) return;
        if (!paths.free(i)) {
            const int index = paths.pending[i].group;
            const auto& bodies = groups[index].body;
            if (bodies.size() > largest_renewed_cluster)
                seed.until = math::min(seed.until, groups[index].until);
            members.dissolve(index, false, seed.pairs);
            seed.bodies.insert(seed.bodies.end(), bodies.begin(), bodies.end());
            return;
        }
        for (Seed& r : parts) {
            if (std::find(r.bodies.begin(), r.bodies.end(), i) == r.bodies.end()) continue;
            seed.bodies.insert(seed.bodies.end(), r.bodies.begin(), r.bodies.end());
            seed.pairs.insert(seed.pairs.end(), r.pairs.begin(), r.pairs.end());
            std::swap(r, parts.back());
            parts.pop_back();
            return;
        }
        paths.restart(i);
        seed.bodies.push_back(i);
    }
    // Ends a cluster at the end of its integration.
    void end_cluster(int index) {
        if (ends_too_deep(index)) return;
        const Group& g = groups[index];
        Seed seed{{g.body.begin(), g.body.end()}, {}, g.until};
        const std::vector<int>& bodies = seed.bodies;
        members.dissolve(index, true, seed.pairs);
        if (bodies.size() >= Clusters<Law>::large_cluster && paths.now < seed.until && !seed.pairs.empty())
            return form(seed);
        form_parts(bodies, seed.pairs);
        for (const int i : bodies)
            if (paths.free(i)) schedule.renew(i);
    }
    // Ends all groups at the current time, changes the velocities of all bodies, and forms the groups again.
    template <class Change>
    void interrupt(const Change& change) {
        Seed seed;
        groups.for_all([&](int index, const Group& g) {
            seed.bodies.insert(seed.bodies.end(), g.body.begin(), g.body.end());
            members.dissolve(index, false, seed.pairs);
        });
        for (ActivePair<Law>& active : seed.pairs) active.pair.velocity_jumped();
        change();
        form_parts(seed.bodies, seed.pairs);
        for (int i = 0; i < paths.size(); ++i)
            if (paths.free(i)) schedule.renew(i);
    }

private:
    // Integrates a cluster of these bodies from the current time, and makes its members busy. The time is halved until
    // the cells are wide enough for the safety radii.
    void build(int index, Seed& seed) {
        Group& g = groups[index];
        double horizon = clusters.open(g, seed);
        const Cluster<Law>& after = g.cluster->after;
        for (;;) {
            clusters.integrate(g, horizon);
            if (members.connect_ends(index) || after.time == 0.0 || after.unresolved) break;
            horizon = 0.5 * after.time;
        }
        g.cluster->after.trajectory.clear();
    }
    // Predicts the events of a new cluster's members. Returns the bodies that already touch one of them.
    std::vector<int> third_bodies(int index) {
        std::vector<int> near;
        const Group& g = groups[index];
        if (!(g.cluster->after.time > 0.0) || ledger.outcome != Outcome::ok) return near;
        for (const int i : g.body) {
            predictor.predict(i);
            if (paths.pending[i].pair_time > paths.now) continue;
            cells.for_neighbours(i, [&](int j, const Vector3& r, const double (&)[3]) {
                const double reach = paths.particles[i].radius + paths.particles[j].radius;
                if (paths.pending[j].group != index && dot(r, r) < reach * reach &&
                    std::find(near.begin(), near.end(), j) == near.end())
                    near.push_back(j);
            });
            std::sort(near.begin(), near.end());  // the order within a cell is not saved
        }
        return near;
    }
    // Adds all bodies that touch those of the seed from index `last` on. form() would find them as well, but with one
    // attempt per body along a chain of contacts.
    void absorb_touching(std::size_t last, Seed& seed) {
        std::vector<int> near;
        for (; last < seed.bodies.size(); ++last) {
            const int i = seed.bodies[last];
            near.clear();
            cells.for_neighbours(i, [&](int j, const Vector3& r, const double (&)[3]) {
                const double reach =
                    (paths.particles[i].radius + paths.particles[j].radius) * (1.0 + rounding_of_touch);
                if (dot(r, r) < reach * reach) near.push_back(j);
            });
            std::sort(near.begin(), near.end());  // the order within a cell is not saved
            for (const int k : near) absorb(k, seed);
        }
    }
    void schedule_cluster(int index) {
        const auto& bodies = groups[index].body;
        if (groups[index].cluster->after.time == 0.0) {  // no pair is closed
            Pairs none;
            members.dissolve(index, true, none);
            for (const int i : bodies) schedule.renew(i);
            return;
        }
        ledger.largest_cluster = std::max(ledger.largest_cluster, static_cast<int>(bodies.size()));
        for (const int i : bodies) schedule.push(i);
    }
    // Ends the run if a contact of the group has reached the largest compression of its law. Does not change the group.
    bool ends_too_deep(int index) {
        const Group& g = groups[index];
        const Cluster<Law>& c = g.cluster->after;
        if (c.too_deep < 0) return false;
        const ContactPair<Law>& q = c.pairs[static_cast<std::size_t>(c.too_deep)];
        std::vector<int> bodies{g.body[static_cast<std::size_t>(q.first)]};
        if (q.second >= 0) bodies.push_back(g.body[static_cast<std::size_t>(q.second)]);
        ledger.end_run(Outcome::too_deep, bodies, q.wall_id);
        return true;
    }
};

}  // namespace hardlimit::boxes::events
