// Observables as sums over all particles, and the refresh of the accumulators.
#pragma once
#include "engine.hpp"

namespace hardlimit::boxes {

// Index in memory of each particle, by original index. Sums in this order do not depend on the storage.
template <int d, Motion motion, bool mixed>
std::vector<u32> HardSpheres<d, motion, mixed>::in_original_order() const {
    std::vector<u32> place(size32());
    for (u32 i = 0; i < size32(); ++i) place[original_index_[i]] = i;
    return place;
}

// Calls f(particle) in the original order, and prefetches the particles, which are stored by cell.
template <int d, Motion motion, bool mixed>
template <class F>
void HardSpheres<d, motion, mixed>::for_original_order(const F& f) const {
    constexpr std::size_t ahead = 24;
    const std::vector<u32> place = in_original_order();
    for (std::size_t at = 0; at < place.size(); ++at) {
        const u32 next = place[std::min(at + ahead, place.size() - 1)];
        prefetch(&particles_[next]);
        if constexpr (motion == Motion::falling) prefetch(&image_flags_[next]);
        if constexpr (mixed) prefetch(&masses_[next]);
        f(place[at]);
    }
}

template <int d, Motion motion, bool mixed>
VelocitySums HardSpheres<d, motion, mixed>::velocity_sums() const {
    VelocitySums sums;
    Sum kinetic, momentum[d];
    double velocity[3] = {};
    for_original_order([&](u32 i) {
        const Particle<d>& p = particles_[i];
        const double m = mass(i);
        double square = 0.0;
        for (int k = 0; k < d; ++k) {
            velocity[k] = velocity_after<motion>(p, k, now_ - p.time, box_);
            square += velocity[k] * velocity[k];
            momentum[k].add(m * velocity[k]);
        }
        kinetic.add(0.5 * m * square);
        sums.products.add_square(m, velocity);
    });
    sums.kinetic = kinetic.value();
    for (int k = 0; k < d; ++k) sums.momentum[k] = momentum[k].value();
    return sums;
}

// Energy in the field of gravity [J], along unfolded paths.
template <int d, Motion motion, bool mixed>
double HardSpheres<d, motion, mixed>::potential_energy() const {
    if constexpr (motion != Motion::falling) return 0.0;
    Sum potential;
    for_original_order([&](u32 i) {
        const ImageMotion image = box_.image(image_flags_[i], now_);
        for (int k = 0; k < d; ++k) {
            const double x = position_after<motion>(particles_[i], k, now_ - particles_[i].time, box_);
            potential.add(-mass(i) * box_.gravity[k] * (x + image.shift[k]));
        }
    });
    return potential.value();
}

// Recomputes energy and momentum: accumulated values lose their digits while a gas cools by many orders of magnitude.
template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::refresh_accumulators() {
    until_refresh_ = std::max<i64>(8192, 32 * static_cast<i64>(particles_.size()));
    const VelocitySums sums = velocity_sums();
    accumulators_.advance(now_);
    accumulators_.kinetic = sums.kinetic;
    std::copy_n(sums.momentum, d, accumulators_.momentum);
    accumulators_.velocities.restart(sums);
}

template <int d, Motion motion, bool mixed>
Observation HardSpheres<d, motion, mixed>::observe() const {
    Observation o;
    const VelocitySums sums = motion == Motion::straight ? accumulators_.velocities.value() : velocity_sums();
    o.kinetic_energy = sums.kinetic;
    o.potential_energy = potential_energy();
    std::copy_n(sums.momentum, d, o.momentum);
    o.kinetic_tensor = sums.products;
    o.dissipated_energy = accumulators_.dissipated.value();
    int k = 0;
    for (std::size_t c = 0; c < SymmetricTensor::size; ++c)
        if (SymmetricTensor::column[c] < d) o.virial.component[c] = accumulators_.virial.value(k++);
    o.wall_work = accumulators_.wall_work.value();
    o.kinetic_integral = accumulators_.integral_until(now_);
    o.largest_compression = deepest_.compression;
    o.begun = o.ended = accumulators_.collisions();
    o.pairs = accumulators_.pairs;
    return o;
}

template <int d, Motion motion, bool mixed>
std::vector<Statistic> HardSpheres<d, motion, mixed>::statistics() const {
    return {{"n_events", static_cast<double>(events_)},
            {"n_pairs", static_cast<double>(accumulators_.pairs)},
            {"n_walls", static_cast<double>(accumulators_.walls)},
            {"n_elastic_by_tc", static_cast<double>(accumulators_.elastic_by_tc)},
            {"n_soft", static_cast<double>(soft_contacts_)},
            {"n_soft_third_body", static_cast<double>(soft_third_body_)}};
}

template <int d, Motion motion, bool mixed>
std::size_t HardSpheres<d, motion, mixed>::bytes() const {
    const auto of = [](const auto& v) { return v.capacity() * sizeof(v[0]); };
    return sizeof(*this) + of(particles_) + of(pending_) + of(image_flags_) + of(original_index_) +
           of(masses_) + of(rescans_) + of(last_contacts_) + of(candidates_) + cells_.bytes() +
           calendar_.bytes();
}

}  // namespace hardlimit::boxes
