// What the coming events will need is fetched while others are dealt with: a large system is otherwise a chain of
// waits for memory. The calendar knows the events to come; those that are superseded meanwhile cost a useless fetch.
#pragma once
#include "hard_spheres.hpp"

namespace hardlimit::particles {

// Called once for each event: those that come somewhat later move on by one stage.
template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::look_ahead() {
    if (!fetches_) return;
    calendar_.ahead(cells_ahead, [this](u32 id) { fetch_cells(id); });
    calendar_.ahead(neighbours_ahead, [this](u32 id) { fetch_neighbours(id); });
}

// The first events of a bin have had no others before them.
template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::look_into_bin() {
    if (!fetches_) return;
    calendar_.fetch_next([this](u32 id) { prefetch(&pending_[id]); });
    for (std::size_t k = 0; k < cells_ahead; ++k) calendar_.ahead(k, [this](u32 id) { fetch_cells(id); });
    for (std::size_t k = 0; k < neighbours_ahead; ++k)
        calendar_.ahead(k, [this](u32 id) { fetch_neighbours(id); });
}

// The cells around a particle, the particle, and the one it meets.
template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::fetch_cells(u32 i) const {
    const Pending& e = pending_[i];
    prefetch(&particles_[i]);
    if (e.partner != nobody) {
        prefetch(&particles_[e.partner]);
        prefetch(&pending_[e.partner]);
    }
    cells_.fetch_around(level(i), e.cell);
}

// The particles in those cells.
template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::fetch_neighbours(u32 i) const {
    cells_.for_inline_around(level(i), pending_[i].cell, [this](u32 id) { prefetch(&particles_[id]); });
}

}  // namespace hardlimit::particles
