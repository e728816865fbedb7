// Random packings without overlap: small particles are inserted at random, then move and collide while their radii grow
// to the requested size (B. D. Lubachevsky and F. H. Stillinger, J. Stat. Phys. 60, 561 (1990)).
//
// The growth slows down as the packing gets dense, and again if collisions accumulate, so that the particles have time
// to rearrange. The radii grow to 1 + 1e-10 times the requested size, so that rounding of the positions causes no
// overlap.
#pragma once
#include <algorithm>
#include <memory>
#include <vector>

#include "../common/random.hpp"
#include "engine.hpp"

namespace hardlimit::boxes {

// Random sequential insertion, the largest particles first.
template <int d>
class RandomInsertion {
public:
    RandomInsertion(const System& s, const Box& box, Random& random) : s_(s), box_(box), random_(random) {
        order_.resize(s.n);
        for (u32 i = 0; i < order_.size(); ++i) order_[i] = i;
        std::sort(order_.begin(), order_.end(), [&](u32 a, u32 b) {
            return s.radius[a] != s.radius[b] ? s.radius[a] > s.radius[b] : a < b;
        });
        alike_ = s.radius[order_.front()] == s.radius[order_.back()];
    }

    // Finds positions for radii that are `share` of the final ones. Returns false if there is none for a particle.
    bool place(double share, std::vector<double>& position, Stop& stop) {
        const double smallest = 2.0 * share * s_.radius[order_.back()];
        const double largest = 2.0 * share * s_.radius[order_.front()];
        cells_ = Cells<d>(box_, s_.n, smallest, largest);
        cells_ahead_ = neighbours_ahead_ = random_;
        for (int draw = 0; draw < 2 * draws_ahead * d; ++draw) (void)cells_ahead_.uniform();
        for (int draw = 0; draw < draws_ahead * d; ++draw) (void)neighbours_ahead_.uniform();
        for (const u32 i : order_) {
            if (stop()) return true;
            if (!insert(i, share, position)) return false;
        }
        return true;
    }

private:
    static constexpr int most_attempts = 2'000, draws_ahead = 8;

    const System& s_;
    const Box& box_;
    Random& random_;
    // Copies of the generator that run ahead, to prefetch what later attempts will read from memory.
    Random cells_ahead_{0}, neighbours_ahead_{0};
    std::vector<u32> order_;
    bool alike_ = false;
    Cells<d> cells_;
    Scratch<u32> list_ = Scratch<u32>(256);

    bool insert(u32 i, double share, std::vector<double>& position) {
        const double radius = share * s_.radius[i];
        const int level = cells_.level_for(2.0 * radius);
        for (int attempt = 0; attempt < most_attempts; ++attempt) {
            fetch(level, radius, position);
            double x[d];
            const u32 cell = draw(random_, level, radius, x);
            if (!is_free(x, radius, share, level, cell, position)) continue;
            cells_.insert(cell, i);
            for (int k = 0; k < d; ++k) position[std::size_t{i} * d + static_cast<std::size_t>(k)] = x[k];
            return true;
        }
        return false;
    }
    // Draws a position; returns its cell.
    u32 draw(Random& random, int level, double radius, double (&x)[d]) const {
        for (int k = 0; k < d; ++k) {
            const double room = box_.is_periodic(k) ? 0.0 : radius;
            x[k] = room + (box_.edge[k] - 2.0 * room) * random.uniform();
        }
        return cells_.number(level, cells_.place_of(level, x));
    }
    void fetch(int level, double radius, const std::vector<double>& position) {
        double x[d];
        cells_.fetch(level, draw(cells_ahead_, level, radius, x), {});
        cells_.for_inline(level, draw(neighbours_ahead_, level, radius, x), {},
                          [&](u32 j) { prefetch(&position[std::size_t{j} * d]); });
    }
    bool is_free(const double (&x)[d], double radius, double share, int level, u32 cell,
                 const std::vector<double>& position) {
        bool free = true;
        cells_.for_stencils(
            level, cells_.place(level, cell), [&](int at, const Place<d>& from, const Place<d>& to) {
                cells_.for_block(box_, at, from, to, [&](u32 other, const double (&shift)[d]) {
                    if (!free) return;
                    const std::size_t n = cells_.collect(other, list_, 0);
                    for (std::size_t c = 0; c < n; ++c) {
                        const u32 j = list_[c];
                        const double touch = radius + (alike_ ? radius : share * s_.radius[j]);
                        double square = 0.0;
                        for (int k = 0; k < d; ++k) {
                            const double r =
                                position[std::size_t{j} * d + static_cast<std::size_t>(k)] + shift[k] - x[k];
                            square += r * r;
                        }
                        free = free && square > touch * touch;
                    }
                });
            });
        return free;
    }
};

// Progress: the share of the final radii reached, and the collisions so far.
struct GrowthReport {
    double share;
    u64 collisions;
};

// `mixed`: radii may differ.
template <int d, bool mixed = true>
class PackingGrowth {
public:
    // Velocities, masses, positions and gravity of the system are not used, and walls stay where they start.
    PackingGrowth(const System& s, u64 seed)
        : s_(s), random_(seed), position_(s.n * d), velocity_(s.n * d), mass_(s.n, 1.0) {
        s_.position = position_.data();
        s_.velocity = velocity_.data();
        s_.mass = mass_.data();
        for (double& g : s_.box.gravity) g = 0.0;
        s_.box.stop_walls();
        fraction_ = s.packing_fraction();
        diameter_ = 2.0 * *std::max_element(s.radius, s.radius + s.n);
    }

    // Returns whether the radii reached the requested size. Calls report(GrowthReport) after each step, which returns
    // whether to continue. After a stop it calls nothing: an exception may be pending.
    template <class Report>
    bool run(const hardlimit_abi::TouchKernels& kernels, Stop& stop, const Report& report) {
        double share = insert(stop), slowness = 1.0;
        u64 collisions = 0;
        if (stop.stopped()) return false;
        for (int step = 0; share < 1.0 + beyond; ++step) {
            if (step == most_steps) return false;
            const Pace pace = pace_at(fraction_at(share));
            const double target = std::min(1.0 + beyond, share_at(std::min(pace.until, fraction_ * 2.0)));
            const double reached = grow(share, target, pace.rate * slowness, kernels, stop, collisions);
            if (reached < target) slowness *= 0.5;
            share = reached;
            if (stop.stopped() || !report(GrowthReport{share, collisions})) return false;
        }
        return true;
    }

    // Positions, folded into the box.
    std::vector<double> positions() && {
        fold();
        return std::move(position_);
    }

private:
    static constexpr double beyond = 1e-10;
    static constexpr int most_steps = 60;
    static constexpr double inserted_fraction = d == 3 ? 0.15 : 0.3;
    static constexpr u64 most_collisions = 400;  // per particle and step, approximately

    // Growth rate [1/s] below the packing fraction `until`; the thermal speed is one diameter per second.
    struct Pace {
        double until, rate;
    };

    System s_;
    Random random_;
    std::vector<double> position_, velocity_, mass_;
    double fraction_, diameter_;

    void fold() {
        for (std::size_t at = 0; at < position_.size(); ++at)
            position_[at] = s_.box.folded(position_[at], static_cast<int>(at % d));
    }
    double fraction_at(double share) const {
        return fraction_ * (d == 3 ? share * share * share : share * share);
    }
    double share_at(double fraction) const { return math::pow(fraction / fraction_, 1.0 / d); }
    static Pace pace_at(double fraction) {
        constexpr Pace spheres[] = {{0.35, 0.5}, {0.5, 0.1}, {0.57, 0.03}, {2.0, 0.01}};
        constexpr Pace disks[] = {{0.5, 0.5}, {0.68, 0.1}, {0.76, 0.03}, {2.0, 0.01}};
        const Pace* pace = d == 3 ? spheres : disks;
        while (fraction >= pace->until * (1.0 - 1e-12)) ++pace;
        return *pace;
    }

    // Inserts the particles, with radii that leave enough space. Returns their share of the final radii.
    double insert(Stop& stop) {
        double share = std::min(1.0 + beyond, share_at(inserted_fraction));
        RandomInsertion<d> insertion(s_, s_.box, random_);
        while (!insertion.place(share, position_, stop)) share *= 0.9;
        return share;
    }

    std::unique_ptr<Engine> make(spheres::Growth growth, const hardlimit_abi::TouchKernels& kernels,
                                 Stop& stop) const {
        const RuleChoice elastic;
        if constexpr (mixed)
            if (*std::min_element(s_.radius, s_.radius + s_.n) * 2.0 != diameter_)
                return std::make_unique<HardSpheres<d, true>>(s_, elastic, false, kernels, stop, growth);
        return std::make_unique<HardSpheres<d, false>>(s_, elastic, false, kernels, stop, growth);
    }

    // Grows the radii from one share to another, or until collisions accumulate. Returns the share reached.
    double grow(double from, double to, double rate, const hardlimit_abi::TouchKernels& kernels, Stop& stop,
                u64& collisions) {
        for (double& v : velocity_) v = diameter_ * random_.normal();
        fold();
        const spheres::Growth growth{from, rate};
        const auto engine = make(growth, kernels, stop);
        if (stop.stopped()) return from;
        const u64 most = most_collisions * s_.n + 10'000;
        engine->advance((to - from) / rate, most, 1, stop);
        engine->state(position_.data(), velocity_.data());
        collisions += engine->contacts();
        // The share reached at this time, less a rounding error.
        return engine->contacts() >= most ? from + rate * engine->time() * (1.0 - 1e-14) : to;
    }
};

}  // namespace hardlimit::boxes
