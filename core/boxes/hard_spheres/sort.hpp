// Particles wander off, and with them what lies together in memory: from time to time they are sorted along the
// cells anew. Nothing but the speed depends on when.
#pragma once
#include "engine.hpp"

namespace hardlimit::boxes {

// records[i] = records[from[i]], in place, one cycle of the permutation after the other.
template <class T>
void permute(Records<T>& records, const std::vector<u32>& from) {
    std::vector<bool> done(from.size());
    for (u32 start = 0; start < from.size(); ++start) {
        if (done[start] || from[start] == start) continue;
        const T first = records[start];
        u32 at = start;
        for (; from[at] != start; at = from[at]) {
            records[at] = records[from[at]];
            done[at] = true;
        }
        records[at] = first;
        done[at] = true;
    }
}

template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::sort_along_cells() {
    next_sort_ = tally_.rows() + collisions_between_sorts * static_cast<i64>(particles_.size());
    const u32 n = size32();
    std::vector<u32> from(n);
    for (u32 i = 0; i < n; ++i) from[i] = i;
    std::sort(from.begin(), from.end(), [this](u32 a, u32 b) {
        return pending_[a].cell != pending_[b].cell ? pending_[a].cell < pending_[b].cell : a < b;
    });
    permute(particles_, from);
    permute(pending_, from);
    permute(periods_, from);
    permute(names_, from);
    if (!masses_.empty()) permute(masses_, from);
    if (!rescans_.empty()) permute(rescans_, from);
    if (!softs_.empty()) permute(softs_, from);
    std::vector<u32> now_at(n);
    for (u32 i = 0; i < n; ++i) now_at[from[i]] = i;
    const auto follow = [&](u32& partner) {
        if (partner != no_particle) partner = now_at[partner];
    };
    for (Pending& e : pending_) follow(e.partner);
    for (SoftContact& s : softs_) follow(s.partner);
    put_into_cells();
    restart_calendar();
}

}  // namespace hardlimit::boxes
