// Order of particles by cell.
#pragma once
#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

namespace hardlimit::boxes {

// Indices of the particles in the order of their cells, and within a cell in their own order (counting sort).
inline std::vector<std::uint32_t> order_by_cell(const std::vector<std::uint32_t>& cell) {
    std::vector<std::uint32_t> place(*std::ranges::max_element(cell) + std::size_t{2}), order(cell.size());
    for (const std::uint32_t c : cell) ++place[c + 1];
    std::partial_sum(place.begin(), place.end(), place.begin());
    for (std::uint32_t i = 0; i < cell.size(); ++i) order[place[cell[i]]++] = i;
    return order;
}

}  // namespace hardlimit::boxes
