// Observables as sums over all particles, and the refresh of the accumulators.
#pragma once
#include "engine.hpp"

namespace hardlimit::boxes {

// Index in memory of each particle, by original index. Sums in this order do not depend on the storage.
template <int d, bool mixed>
std::vector<u32> HardSpheres<d, mixed>::in_original_order() const {
    std::vector<u32> place(size32());
    for (u32 i = 0; i < size32(); ++i) place[original_index_[i]] = i;
    return place;
}

// The sums from the state of each particle, whose data are prefetched: particles are stored by cell. `from_flow`: those
// of the velocities relative to the mean flow of a sheared box.
template <int d, bool mixed>
ParticleSums<d> HardSpheres<d, mixed>::full_sums(bool from_flow) const {
    constexpr std::size_t ahead = 24;
    ParticleSums<d> sums;
    const std::vector<u32> place = in_original_order();
    for (std::size_t at = 0; at < place.size(); ++at) {
        const u32 i = place[at], next = place[std::min(at + ahead, place.size() - 1)];
        prefetch(&particles_[next]);
        if (falls()) prefetch(&image_flags_[next]);
        if constexpr (mixed) prefetch(&masses_[next]);
        const Particle<d>& p = particles_[i];
        const double after = now_ - p.time;
        double velocity[d], potential = 0.0;
        for (int k = 0; k < d; ++k) velocity[k] = velocity_after(p, k, after, box_);
        if (from_flow) velocity[0] -= box_.mean_flow(position_after(p, box_.gradient, after, box_));
        sums.add(mass(i), velocity);
        if (!falls()) continue;
        const ImageMotion image = box_.image(image_flags_[i], now_);
        for (int k = 0; k < d; ++k)
            potential -= box_.gravity[k] * (position_after(p, k, after, box_) + image.shift[k]);
        sums.add_potential(mass(i) * potential);
    }
    return sums;
}

template <int d, bool mixed>
ParticleSums<d> HardSpheres<d, mixed>::present_sums(bool from_flow) const {
    if (grows() || !accumulators_.are_exact()) return full_sums(from_flow);
    Accumulators<d> now = accumulators_;
    now.advance(now_);
    return from_flow ? now.from_flow : now.sums;
}

// Recomputes the sums: the errors of many changes add up, and a gas cools by many orders of magnitude.
template <int d, bool mixed>
void HardSpheres<d, mixed>::refresh_accumulators() {
    until_refresh_ = changes_between_refreshes();
    accumulators_.advance(now_);
    accumulators_.sums = full_sums(false);
    if (box_.is_sheared()) accumulators_.from_flow = full_sums(true);
}

template <int d, bool mixed>
Observation HardSpheres<d, mixed>::observe() const {
    Observation o;
    const ParticleSums<d> sums = present_sums(false);
    const ParticleSums<d> relative = box_.is_sheared() ? present_sums(true) : sums;
    o.kinetic_energy = 0.5 * sums.twice_kinetic();
    o.potential_energy = sums.potential();
    for (int k = 0; k < d; ++k) o.momentum[k] = sums.momentum(k);
    o.dissipated_energy = accumulators_.dissipated.value();
    int k = 0;
    for (std::size_t c = 0; c < SymmetricTensor::size; ++c)
        if (SymmetricTensor::column[c] < d) {
            o.kinetic_tensor.component[c] = relative.product(k);
            o.virial.component[c] = accumulators_.virial.value(k++);
        }
    o.flow_momentum = sums.momentum(0) - relative.momentum(0);
    o.shear_work = accumulators_.shear_work.value();
    o.wall_work = accumulators_.wall_work.value();
    o.walls = accumulators_.of_walls();
    o.kinetic_integral = accumulators_.integral_until(now_);
    o.largest_compression = deepest_.compression;
    o.begun = o.ended = accumulators_.collisions();
    o.pairs = accumulators_.pairs;
    return o;
}

template <int d, bool mixed>
std::vector<Statistic> HardSpheres<d, mixed>::statistics() const {
    return {{"n_events", static_cast<double>(events_)},
            {"n_pairs", static_cast<double>(accumulators_.pairs)},
            {"n_walls", static_cast<double>(accumulators_.walls)},
            {"n_elastic_by_tc", static_cast<double>(accumulators_.elastic_by_tc)},
            {"n_soft", static_cast<double>(soft_contacts_)},
            {"n_soft_third_body", static_cast<double>(soft_third_body_)}};
}

template <int d, bool mixed>
std::size_t HardSpheres<d, mixed>::bytes() const {
    const auto of = [](const auto& v) { return v.capacity() * sizeof(v[0]); };
    return sizeof(*this) + of(particles_) + of(pending_) + of(image_flags_) + of(original_index_) +
           of(masses_) + of(rescans_) + of(last_contacts_) + of(candidates_) + cells_.bytes() +
           calendar_.bytes();
}

}  // namespace hardlimit::boxes
