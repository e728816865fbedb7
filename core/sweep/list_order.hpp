// Order in which the points of a list are solved. Drops with similar parameters take the same steps, so the lanes of a
// vector kernel wait less for each other if neighbours in the order have similar parameters.
#pragma once
#include <algorithm>
#include <cstddef>
#include <functional>
#include <vector>

#include "../base/portable.hpp"

namespace hardlimit::sweep {

class ListOrder {
public:
    static constexpr int most = 16384;  // points

    ListOrder() = default;

    // Points 0 … count − 1 in the order of the cells of a grid over their parameters; empty if all parameters are
    // monotonic. The path through the grid turns at its edges, so that consecutive cells are neighbours.
    ListOrder(const std::vector<const double*>& parameters, int count) {
        const auto monotonic = [count](const double* value) {
            return std::is_sorted(value, value + count) ||
                   std::is_sorted(value, value + count, std::greater<double>());
        };
        if (std::all_of(parameters.begin(), parameters.end(), monotonic)) return;
        cell_.resize(static_cast<std::size_t>(count));
        const int swept = static_cast<int>(parameters.size());
        const int bits = std::max(1, cell_bits / std::max(1, swept));
        for (int k = 0; k < swept && (k + 1) * bits <= cell_bits; ++k)
            divide(parameters[static_cast<std::size_t>(k)], bits);
        sort();
    }
    bool empty() const { return points_.empty(); }
    const int* points() const { return points_.data(); }

private:
    static constexpr int cell_bits = 12;
    std::vector<unsigned> cell_;  // of each point
    std::vector<int> points_;

    // Divides each cell along one parameter: on a logarithmic scale (the bits of a double are nearly its logarithm), if
    // all values are positive, otherwise on a linear one.
    void divide(const double* value, int bits) {
        const auto [least, greatest] = std::minmax_element(value, value + cell_.size());
        const bool logarithmic = *least > 0.0;
        const auto along = [logarithmic](double x) {
            return logarithmic ? static_cast<double>(static_cast<i64>(bits_of<double>(x))) : x;
        };
        const double parts = static_cast<double>(1 << bits), from = along(*least);
        const double per_part = parts / (along(*greatest) - from);
        for (std::size_t i = 0; i < cell_.size(); ++i) {
            const double at = (along(value[i]) - from) * per_part;  // NaN if all values are equal
            unsigned part = at > 0.0 ? static_cast<unsigned>(std::min(at, parts - 1.0)) : 0;
            if (cell_[i] & 1) part = (1u << bits) - 1 - part;
            cell_[i] = cell_[i] << bits | part;
        }
    }

    void sort() {
        std::vector<int> begin((std::size_t{1} << cell_bits) + 1);  // of each cell in the order
        for (const unsigned c : cell_) ++begin[c + 1];
        for (std::size_t c = 1; c < begin.size(); ++c) begin[c] += begin[c - 1];
        points_.resize(cell_.size());
        for (std::size_t i = 0; i < cell_.size(); ++i)
            points_[static_cast<std::size_t>(begin[cell_[i]]++)] = static_cast<int>(i);
    }
};

}  // namespace hardlimit::sweep
