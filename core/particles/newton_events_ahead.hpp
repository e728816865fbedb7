// What the coming events will need is fetched while others are dealt with, as in a large box of hard spheres
// (hard_spheres_ahead.hpp).
#pragma once
#include "newton_events.hpp"

namespace hardlimit::particles {

// Called once for each event: those that come somewhat later move on by one stage.
template <class Law>
void NewtonEvents<Law>::look_ahead() const {
    if (!fetches_) return;
    calendar_.ahead(cells_ahead, [this](u32 id) { fetch_cells(id); });
    calendar_.ahead(neighbours_ahead, [this](u32 id) { fetch_neighbours(id); });
}

// The first events of a bin have had no others before them.
template <class Law>
void NewtonEvents<Law>::look_into_bin() const {
    if (!fetches_) return;
    calendar_.fetch_next([this](u32 id) { prefetch(&pending_[id]); });
    for (std::size_t k = 0; k < cells_ahead; ++k) calendar_.ahead(k, [this](u32 id) { fetch_cells(id); });
    for (std::size_t k = 0; k < neighbours_ahead; ++k)
        calendar_.ahead(k, [this](u32 id) { fetch_neighbours(id); });
}

// Where a body will look at its next event.
template <class Law>
Cells<3>::Surroundings NewtonEvents<Law>::surroundings(const Pending& e) {
    const Own own = static_cast<Own>(e.own);
    if (e.pair_time <= e.own_time || own == Own::ends) return {};
    return Cells<3>::Surroundings::beyond(axis_of(own), is_high(own));
}

// The cells there, the body, and the one it meets.
template <class Law>
void NewtonEvents<Law>::fetch_cells(u32 i) const {
    const Pending& e = pending_[i];
    prefetch(&paths_[i]);
    prefetch(&group_[i]);
    prefetch(&names_[i]);
    if (e.pair_time <= e.own_time) {
        prefetch(&paths_[e.partner]);
        prefetch(&pending_[e.partner]);
        prefetch(&group_[e.partner]);
    }
    cells_.fetch(level_, e.cell, surroundings(e));
}

// The bodies in those cells.
template <class Law>
void NewtonEvents<Law>::fetch_neighbours(u32 i) const {
    const Pending& e = pending_[i];
    cells_.for_inline(level_, e.cell, surroundings(e), [this](u32 id) { prefetch(&paths_[id]); });
}

}  // namespace hardlimit::particles
