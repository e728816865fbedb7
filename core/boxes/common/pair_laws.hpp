// The contact law of any two bodies of a box.
#pragma once
#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "law_choice.hpp"

namespace hardlimit::boxes {

// Bodies of equal mass and radius are of one kind. Up to most_kinds kinds, a table holds the laws of all pairs of
// kinds. With more kinds, the law of a pair is computed at each call.
template <class Law>
class PairLaws {
public:
    static constexpr std::size_t most_kinds = 64;

    PairLaws(const LawChoice& choice, const std::vector<double>& mass, const std::vector<double>& radius)
        : choice_(choice) {
        std::vector<Body> bodies;
        for (std::size_t i = 0; i < mass.size(); ++i) bodies.push_back({mass[i], radius[i]});
        kinds_ = bodies;
        std::sort(kinds_.begin(), kinds_.end());
        kinds_.erase(std::unique(kinds_.begin(), kinds_.end()), kinds_.end());
        if (kinds_.size() > most_kinds) {
            kinds_ = std::move(bodies);
            return;
        }
        kinds_.shrink_to_fit();
        if (kinds_.size() > 1)
            for (const Body& body : bodies)
                kind_.push_back(static_cast<std::uint32_t>(
                    std::lower_bound(kinds_.begin(), kinds_.end(), body) - kinds_.begin()));
        for (const Body& a : kinds_) {
            for (const Body& b : kinds_) table_.push_back(make(a, b));
            table_.push_back(make(a, wall));
        }
    }

    // Renumbers the bodies: body from[i] becomes body i.
    template <class Numbers>
    void reorder(const Numbers& from) {
        const auto follow = [&](auto& of) {
            auto moved = of;
            for (std::size_t i = 0; i < of.size(); ++i) moved[i] = of[from[i]];
            of = std::move(moved);
        };
        if (table_.empty()) follow(kinds_);
        follow(kind_);
    }

    // second < 0: a wall.
    Law operator()(std::int64_t first, std::int64_t second) const {
        Law law;
        put(first, second, law);
        return law;
    }
    // The same, written in place: a copy with loads wider than the preceding stores would stall (store forwarding).
    void put(std::int64_t first, std::int64_t second, Law& law) const {
        const std::size_t a = kind(static_cast<std::size_t>(first));
        const std::size_t b = second < 0 ? kinds_.size() : kind(static_cast<std::size_t>(second));
        if (!table_.empty())
            law = table_[a * (kinds_.size() + 1) + b];
        else
            law = make(kinds_[a], second < 0 ? wall : kinds_[b]);
    }
    double mass(std::size_t i) const { return kinds_[kind(i)].first; }
    double radius(std::size_t i) const { return kinds_[kind(i)].second; }

    // Mass and radius of all kinds, or of all bodies; and the kind of each body, empty with one kind or without.
    const std::vector<std::pair<double, double>>& kinds() const { return kinds_; }
    const std::vector<std::uint32_t>& kind_of_bodies() const { return kind_; }

    // Prefetches the entry of body i.
    void fetch(std::size_t i) const {
        if (table_.empty()) return prefetch(kinds_.data() + i);
        if (!kind_.empty()) prefetch(kind_.data() + i);
    }

private:
    using Body = std::pair<double, double>;  // mass [kg], radius [m]
    static constexpr Body wall = {math::infinity, math::infinity};

    LawChoice choice_;
    std::vector<Body> kinds_;          // all bodies, if there are more than most_kinds kinds
    std::vector<std::uint32_t> kind_;  // of each body; empty with one kind or without a table
    std::vector<Law> table_;

    // With a single kind no per-body data are read, which saves a cache line.
    std::size_t kind(std::size_t i) const {
        if (!kind_.empty()) return kind_[i];
        return kinds_.size() == 1 ? 0 : i;
    }

    HL_FN_APART Law make(const Body& a, const Body& b) const {
        const PairGeometry pair = {effective(a.first, b.first), effective(a.second, b.second)};
        return make_law<Law>(choice_, pair);
    }
};

}  // namespace hardlimit::boxes
