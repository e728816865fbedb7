// Splits the bodies of an ended cluster into parts that are still in contact.
#pragma once
#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "records.hpp"

namespace hardlimit::boxes::events {

// Index of a body among the members of a group.
class MemberIndex {
public:
    explicit MemberIndex(std::span<const int> bodies) : bodies_(bodies) {
        if (bodies.size() < few) return;
        for (std::size_t m = 0; m < bodies.size(); ++m) sorted_.emplace_back(bodies[m], m);
        std::sort(sorted_.begin(), sorted_.end());
    }
    std::size_t operator()(int body) const {
        if (sorted_.empty())
            return static_cast<std::size_t>(std::find(bodies_.begin(), bodies_.end(), body) -
                                            bodies_.begin());
        return std::lower_bound(sorted_.begin(), sorted_.end(), std::pair{body, std::size_t{0}})->second;
    }

private:
    static constexpr std::size_t few = 16;
    std::span<const int> bodies_;
    std::vector<std::pair<int, std::size_t>> sorted_;
};

// Parts connected by active pairs. Bodies without an active pair are in none.
template <class Law>
std::vector<ClusterSeed<Law>> connected_parts(const std::vector<int>& bodies,
                                              const ActivePairs<Law>& active) {
    std::vector<ClusterSeed<Law>> parts;
    const MemberIndex member(bodies);
    std::vector<std::size_t> above(bodies.size());
    for (std::size_t m = 0; m < bodies.size(); ++m) above[m] = m;
    const auto root = [&](int body) {
        std::size_t m = member(body);
        while (above[m] != m) m = above[m] = above[above[m]];
        return m;
    };
    for (const ActivePair<Law>& pair : active)
        if (pair.second >= 0) above[root(pair.second)] = root(pair.first);
    constexpr std::size_t none = ~std::size_t{0};
    std::vector<std::size_t> part_of(bodies.size(), none);
    for (const ActivePair<Law>& pair : active) part_of[root(pair.first)] = 0;
    for (std::size_t& at : part_of) {
        if (at == none) continue;
        at = parts.size();
        parts.emplace_back();
    }
    for (const ActivePair<Law>& pair : active) parts[part_of[root(pair.first)]].pairs.push_back(pair);
    for (const int body : bodies)
        if (const std::size_t at = part_of[root(body)]; at != none) parts[at].bodies.push_back(body);
    return parts;
}

}  // namespace hardlimit::boxes::events
