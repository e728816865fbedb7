// What a run has added up and logged so far, and why it ended.
#pragma once
#include <algorithm>
#include <utility>
#include <vector>

#include "../../base/outcome.hpp"
#include "paths.hpp"

namespace hardlimit::boxes::events {

// Adds what has happened in a cluster. `dissipated`, `to_walls`: with or without the energies that slack pairs and
// tangential springs store.
// `shear_work`: of the boundary on the group.
template <class Law>
void add_cluster(Observation& sums, const Cluster<Law>& c, double dissipated, const WallSums& to_walls,
                 double shear_work) {
    sums.dissipated_energy += dissipated;
    sums.virial += c.virial;
    sums.wall_work += c.wall_work;
    sums.walls += to_walls;
    sums.shear_work += c.shear_work + shear_work;
    sums.friction_loss += c.rubbed;
    sums.largest_compression = math::max(sums.largest_compression, c.largest_compression);
    sums.begun += static_cast<u64>(c.begun);
    sums.pairs += static_cast<u64>(c.begun_pairs);
}
inline void count_end(Observation& sums, const EndedContact& e) {
    ++sums.ended;
    sums.overlapped += e.overlapped;
}

template <class Law>
class Ledger {
public:
    using Group = ContactGroup<Law>;

    // Without unfinished groups and the motion of the bodies. Dissipated energies include the elastic energies that
    // slack pairs and tangential springs still store.
    Observation sums;
    double clustered = 0.0;   // time that bodies have spent in clusters [s]
    int largest_cluster = 0;  // number of its members
    std::vector<ContactRecord> rows;
    Outcome outcome = Outcome::ok;
    std::vector<i64> ended_by;  // original indices, ascending
    WallId ended_at;

    Ledger(const Paths<Law>& paths, bool logs) : paths_(paths), logs_(logs) {
        sums.largest_compression = 0.0;
    }

    void begin_contact(bool of_two_bodies) {
        ++sums.begun;
        sums.pairs += of_two_bodies;
    }
    void end_contact(const Group& g, const ContactPair<Law>& q, const EndedContact& e) {
        count_end(sums, e);
        if (logs_) rows.push_back(row(g, q, e));
    }
    ContactRecord row(const Group& g, const ContactPair<Law>& q, const EndedContact& e) const {
        const auto index = [&](int member) {
            return static_cast<int>(paths_.pending[g.body[static_cast<std::size_t>(member)]].original_index);
        };
        int first = index(q.first), second = q.second >= 0 ? index(q.second) : q.wall_id.number;
        if (second >= 0 && second < first) std::swap(first, second);
        return {e.begin,
                e.end,
                first,
                second,
                e.impact_speed,
                e.separation_speed,
                e.overlapped,
                e.slid,
                e.tangential_speed,
                e.tangential_restitution};
    }
    // Ends the run at these bodies. Only the first call counts.
    template <class Bodies>
    void end_run(Outcome why, const Bodies& bodies, WallId wall = {}) {
        if (outcome != Outcome::ok) return;
        outcome = why;
        ended_at = wall;
        for (const int i : bodies) ended_by.push_back(paths_.pending[i].original_index);
        std::sort(ended_by.begin(), ended_by.end());
    }

private:
    const Paths<Law>& paths_;
    const bool logs_;
};

}  // namespace hardlimit::boxes::events
