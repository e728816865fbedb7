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

// Recomputes energy and momentum: accumulated values lose their digits while a gas cools by many orders of magnitude.
template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::refresh_accumulators() {
    until_refresh_ = std::max<i64>(8192, 32 * static_cast<i64>(particles_.size()));
    Sum mass_sum, kinetic, momentum[d];
    for (const u32 i : in_original_order()) {
        const Particle<d>& p = particles_[i];
        double square = 0.0;
        for (int k = 0; k < d; ++k) {
            const double v = velocity_after<motion>(p, k, now_ - p.time, box_);
            square += v * v;
            momentum[k].add(mass(i) * v);
        }
        kinetic.add(0.5 * mass(i) * square);
        mass_sum.add(mass(i));
    }
    accumulators_.mass = mass_sum.value();
    for (int k = 0; k < d; ++k) accumulators_.gravity[k] = box_.gravity[k];
    accumulators_.advance(now_);
    accumulators_.kinetic = kinetic.value();
    for (int k = 0; k < d; ++k) accumulators_.momentum[k] = momentum[k].value();
}

template <int d, Motion motion, bool mixed>
Observation HardSpheres<d, motion, mixed>::observe() const {
    Observation o;
    Sum kinetic, potential, momentum[d];
    double velocity[3] = {};
    for (const u32 i : in_original_order()) {
        const Particle<d>& p = particles_[i];
        const double after = now_ - p.time, m = mass(i);
        const ImageMotion image = box_.image(image_flags_[i], now_);
        double square = 0.0;
        for (int k = 0; k < d; ++k) {
            const double v = velocity_after<motion>(p, k, after, box_);
            const double x = position_after<motion>(p, k, after, box_) + image.shift[k];
            square += v * v;
            velocity[k] = v;
            momentum[k].add(m * v);
            potential.add(-m * box_.gravity[k] * x);
        }
        kinetic.add(0.5 * m * square);
        o.kinetic_tensor.add_square(m, velocity);
    }
    o.kinetic_energy = kinetic.value();
    o.potential_energy = potential.value();
    for (int k = 0; k < d; ++k) o.momentum[k] = momentum[k].value();
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
