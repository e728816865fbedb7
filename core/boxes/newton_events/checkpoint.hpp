// Checkpoints of the event-driven engine. A loaded run continues bit for bit.
#pragma once
#include <memory>
#include <vector>

#include "../common/archive.hpp"
#include "formation.hpp"

namespace hardlimit::boxes::events {

template <class Archive, class Law>
void exchange(Archive& archive, Cluster<Law>& c) {
    archive(c.members), archive(c.pairs), archive(c.wall_pieces), archive(c.gravity),
        archive(c.largest_coordinate), archive(c.base), archive(c.time);
    archive(c.dissipated), archive(c.virial), archive(c.wall_work), archive(c.shear_work), archive(c.walls),
        archive(c.rubbed), archive(c.rotations), archive(c.planar), archive(c.begun), archive(c.begun_pairs),
        archive(c.ended), archive(c.unresolved), archive(c.too_deep), archive(c.largest_compression);
}

template <class Archive, class T, std::size_t most_in_place>
void exchange(Archive& archive, SmallVector<T, most_in_place>& list) {
    std::vector<T> elements(list.begin(), list.end());
    archive(elements);
    list.assign(elements);
}

template <class Archive, class Law>
void exchange(Archive& archive, ContactGroup<Law>& g) {
    archive(g.alive), archive(g.isolated), archive(g.compression), archive(g.wall_impulse), archive(g.until);
    archive(g.origin), archive(g.sheared_energy);
    exchange(archive, g.body);
    exchange(archive, g.image_offset);
    if (!g.alive) return;
    if (g.isolated) return archive(g.isolated_contact);
    if (!g.cluster) g.cluster = std::make_unique<ClusterStates<Law>>();
    for (Cluster<Law>* c : {&g.cluster->before, &g.cluster->after}) exchange(archive, *c);
}

// Everything except the groups. The queues are rebuilt from bodies and groups.
template <class Archive, class Law>
void exchange(Archive& archive, Paths<Law>& paths, Groups<Law>& groups, Ledger<Law>& ledger,
              StepBudget& budget, u64& events, bool& paused) {
    Observation& sums = ledger.sums;
    archive(paths.particles), archive(paths.pending), archive(paths.rotations), archive(groups.unused()),
        archive(ledger.rows);
    archive(paths.now), archive(sums.dissipated_energy), archive(sums.virial), archive(sums.wall_work),
        archive(sums.shear_work), archive(sums.friction_loss), archive(sums.walls), archive(ledger.clustered);
    archive(sums.begun), archive(sums.pairs), archive(sums.ended), archive(sums.overlapped), archive(events);
    archive(ledger.largest_cluster), archive(budget.steps), archive(budget.begun_before), archive(paused),
        archive(ledger.outcome);
    archive(ledger.ended_by), archive(ledger.ended_at), archive(sums.largest_compression);
}

}  // namespace hardlimit::boxes::events
