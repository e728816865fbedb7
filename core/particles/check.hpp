// What is wrong with a system, if anything: numbers out of range, particles beside the box, in a wall or in each other.
#pragma once
#include <algorithm>
#include <vector>

#include "cells.hpp"
#include "engine.hpp"

namespace hardlimit::particles {

struct Fault {
    enum Kind { none, not_finite, radius, mass, box, outside, in_wall, overlap } kind = none;
    std::size_t first = 0, second = 0;  // particles
    int axis = 0;
    double value = 0.0;  // what was found, or by how much it is too little
};

// Share of the sum of two radii by which positions may come too close: what rounding makes of touching particles.
inline constexpr double touching = 1e-9;

template <int d>
class Check {
public:
    explicit Check(const Setting& s) : s_(s) {
        for (int k = 0; k < d; ++k) {
            box_.edge[k] = s.edge[k];
            box_.periodic[k] = s.periodic[k];
        }
    }

    Fault fault() const {
        Fault f = of_sizes();
        if (f.kind == Fault::none) f = of_numbers();
        if (f.kind == Fault::none) f = of_places();
        if (f.kind == Fault::none) f = of_pairs();
        return f;
    }

    // Of radii and box alone.
    Fault of_sizes() const {
        for (std::size_t i = 0; i < s_.n; ++i)
            if (!(s_.radius[i] > 0.0 && math::is_finite(s_.radius[i])))
                return {Fault::radius, i, 0, 0, s_.radius[i]};
        const double diameter = 2.0 * *std::max_element(s_.radius, s_.radius + s_.n);
        for (int k = 0; k < d; ++k)
            if (!(box_.edge[k] >= diameter && math::is_finite(box_.edge[k])))
                return {Fault::box, 0, 0, k, diameter};
        return {};
    }

private:
    const Setting& s_;
    Box<d> box_{};

    double position(std::size_t i, int k) const { return s_.position[i * d + static_cast<std::size_t>(k)]; }

    Fault of_numbers() const {
        for (std::size_t i = 0; i < s_.n; ++i) {
            if (!(s_.mass[i] > 0.0 && math::is_finite(s_.mass[i]))) return {Fault::mass, i, 0, 0, s_.mass[i]};
            for (int k = 0; k < d; ++k)
                if (!math::is_finite(position(i, k)) ||
                    !math::is_finite(s_.velocity[i * d + static_cast<std::size_t>(k)]))
                    return {Fault::not_finite, i, 0, k, 0.0};
        }
        return {};
    }
    Fault of_places() const {
        for (std::size_t i = 0; i < s_.n; ++i)
            for (int k = 0; k < d; ++k) {
                const double x = position(i, k),
                             room = box_.periodic[k] ? 0.0 : s_.radius[i] * (1.0 - touching);
                if (!(x >= 0.0 && x <= box_.edge[k])) return {Fault::outside, i, 0, k, x};
                if (x < room || x > box_.edge[k] - room) return {Fault::in_wall, i, 0, k, x};
            }
        return {};
    }
    Fault of_pairs() const {
        const auto [smallest, largest] = std::minmax_element(s_.radius, s_.radius + s_.n);
        Cells<d> cells(box_, s_.n, 2.0 * *smallest, 2.0 * *largest);
        std::vector<u32> list(256);
        for (const bool look : {false, true})
            for (std::size_t i = 0; i < s_.n; ++i) {
                double x[d];
                for (int k = 0; k < d; ++k) x[k] = position(i, k);
                const int level = cells.level_for(2.0 * s_.radius[i]);
                const u32 cell = cells.number(level, cells.place_of(level, x));
                if (!look) cells.insert(cell, static_cast<u32>(i));
                if (!look) continue;
                const Fault f = overlap_of(i, x, level, cell, cells, list);
                if (f.kind != Fault::none) return f;
            }
        return {};
    }
    Fault overlap_of(std::size_t i, const double (&x)[d], int level, u32 cell, const Cells<d>& cells,
                     std::vector<u32>& list) const {
        Fault f;
        cells.for_neighbourhoods(level, cell, [&](int at, const Place<d>& from, const Place<d>& to) {
            cells.for_block(box_, at, from, to, [&](u32 other, const double (&shift)[d]) {
                const std::size_t n = cells.collect(other, list, 0);
                for (std::size_t c = 0; c < n; ++c) {
                    const std::size_t j = list[c];
                    if (j == i) continue;
                    double square = 0.0;
                    for (int k = 0; k < d; ++k) {
                        const double r = position(j, k) + shift[k] - x[k];
                        square += r * r;
                    }
                    const double touch = s_.radius[i] + s_.radius[j], least = touch * (1.0 - touching);
                    if (square < least * least)
                        f = {Fault::overlap, std::min(i, j), std::max(i, j), 0, touch - math::sqrt(square)};
                }
            });
        });
        return f;
    }
};

inline Fault fault_of(const Setting& s) {
    return s.dimension == 2 ? Check<2>(s).fault() : Check<3>(s).fault();
}

inline Fault fault_of_sizes(const Setting& s) {
    return s.dimension == 2 ? Check<2>(s).of_sizes() : Check<3>(s).of_sizes();
}

}  // namespace hardlimit::particles
