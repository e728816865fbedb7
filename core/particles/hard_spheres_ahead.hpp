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

// Where a particle will look at its next event.
template <int d, Motion motion, bool mixed>
auto HardSpheres<d, motion, mixed>::surroundings(const Pending& e) -> typename Cells<d>::Surroundings {
    const Own own = static_cast<Own>(e.own);
    if (e.pair_time <= e.own_time || own == Own::rescan) return {};
    return Cells<d>::Surroundings::beyond(axis_of(own), is_high(own));
}

// The cells there, the particle, and the one it meets.
template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::fetch_cells(u32 i) const {
    const Pending& e = pending_[i];
    prefetch(&particles_[i]);
    if (e.pair_time <= e.own_time) {
        prefetch(&particles_[e.partner]);
        prefetch(&pending_[e.partner]);
    }
    cells_.fetch(level(i), e.cell, surroundings(e));
}

// The particles in those cells.
template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::fetch_neighbours(u32 i) const {
    const Pending& e = pending_[i];
    cells_.for_inline(level(i), e.cell, surroundings(e), [this](u32 id) { prefetch(&particles_[id]); });
}

}  // namespace hardlimit::particles
