// The law of any two bodies of a box.
#pragma once
#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "../contact/law.hpp"

namespace hardlimit::particles {

// Kinds of equal bodies have their laws in a table. Where there are many kinds, a law is made when two bodies touch.
template <class Law>
class PairLaws {
public:
    static constexpr std::size_t most_kinds = 64;

    PairLaws(int alternative, std::vector<double> parameters, const std::vector<double>& mass,
             const std::vector<double>& radius)
        : alternative_(alternative), parameters_(std::move(parameters)), kind_(mass.size()) {
        for (std::size_t i = 0; i < mass.size(); ++i) bodies_.push_back({mass[i], radius[i]});
        std::vector<Body> kinds = bodies_;
        std::sort(kinds.begin(), kinds.end());
        kinds.erase(std::unique(kinds.begin(), kinds.end()), kinds.end());
        if (kinds.size() > most_kinds) return;
        kinds_ = kinds.size();
        for (std::size_t i = 0; i < bodies_.size(); ++i)
            kind_[i] = static_cast<std::uint32_t>(std::lower_bound(kinds.begin(), kinds.end(), bodies_[i]) -
                                                  kinds.begin());
        for (const Body& a : kinds) {
            for (const Body& b : kinds) table_.push_back(make(a, b));
            table_.push_back(make(a, wall));
        }
    }

    // second < 0: a wall.
    Law operator()(std::int64_t first, std::int64_t second) const {
        const auto i = static_cast<std::size_t>(first), j = static_cast<std::size_t>(second);
        if (kinds_ == 0) return make(bodies_[i], second < 0 ? wall : bodies_[j]);
        return table_[kind_[i] * (kinds_ + 1) + (second < 0 ? kinds_ : kind_[j])];
    }
    double mass(std::size_t i) const { return bodies_[i].first; }
    double radius(std::size_t i) const { return bodies_[i].second; }

private:
    using Body = std::pair<double, double>;  // mass [kg], radius [m]
    static constexpr Body wall = {math::infinity, math::infinity};

    int alternative_;
    std::vector<double> parameters_;
    std::vector<Body> bodies_;
    std::vector<std::uint32_t> kind_;
    std::size_t kinds_ = 0;  // 0: too many for a table
    std::vector<Law> table_;

    Law make(const Body& a, const Body& b) const {
        const PairGeometry pair = {effective(a.first, b.first), effective(a.second, b.second)};
        return Law::from_parameters(alternative_, parameters_.data(), pair);
    }
};

}  // namespace hardlimit::particles
