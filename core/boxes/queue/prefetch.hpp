// Prefetches the data of coming events while others are processed: a large box would otherwise wait for memory at each
// event. The calendar queue knows the coming events; those superseded meanwhile cost a useless fetch.
#pragma once
#include "../common/particle.hpp"
#include "../neighbours/cells.hpp"
#include "calendar_queue.hpp"

namespace hardlimit::boxes {

// level(id): grid of a body's cell. more(id): fetches further data of a body that has an event; beside(id): further
// data of its neighbours.
template <int d, class Events, class Level, class More, class Beside>
struct Prefetcher {
    const CalendarQueue& calendar;
    const Cells<d>& cells;
    const Events* pending;  // records derived from Pending
    const Particle<d>* bodies;
    Level level;
    More more;
    Beside beside;

    static constexpr std::size_t cells_ahead = 14, neighbours_ahead = 6;  // events ahead

    // Called once per event: fetches for the events at both distances ahead.
    void step() const {
        calendar.ahead(cells_ahead, [this](u32 id) { fetch_cells(id); });
        calendar.ahead(neighbours_ahead, [this](u32 id) { fetch_neighbours(id); });
    }
    // Fetches for the first events of a bin, which no earlier events have announced.
    void enter_bin() const {
        calendar.fetch_next([this](u32 id) { prefetch(&pending[id]); });
        for (std::size_t k = 0; k < cells_ahead; ++k) calendar.ahead(k, [this](u32 id) { fetch_cells(id); });
        for (std::size_t k = 0; k < neighbours_ahead; ++k)
            calendar.ahead(k, [this](u32 id) { fetch_neighbours(id); });
    }

private:
    // Cells that a body will search at its next event.
    static typename Cells<d>::Surroundings surroundings(const Pending& e) {
        const SelfEvent own = static_cast<SelfEvent>(e.own);
        if (e.pair_time <= e.own_time || own == SelfEvent::rescan || own == SelfEvent::ends) return {};
        return Cells<d>::Surroundings::beyond(axis_of(own), is_high(own));
    }
    // Fetches those cells, the body, and its partner.
    void fetch_cells(u32 i) const {
        const Pending& e = pending[i];
        prefetch(&bodies[i]);
        more(i);
        if (e.pair_time <= e.own_time) {
            prefetch(&bodies[e.partner]);
            prefetch(&pending[e.partner]);
            more(e.partner);
        }
        cells.fetch(level(i), e.cell, surroundings(e));
    }
    // Fetches the bodies in those cells.
    void fetch_neighbours(u32 i) const {
        const Pending& e = pending[i];
        cells.for_inline(level(i), e.cell, surroundings(e), [this](u32 id) {
            prefetch(&bodies[id]);
            beside(id);
        });
    }
};
template <int d, class Events, class Level, class More, class Beside>
Prefetcher(const CalendarQueue&, const Cells<d>&, const Events*, const Particle<d>*, Level, More, Beside)
    -> Prefetcher<d, Events, Level, More, Beside>;

}  // namespace hardlimit::boxes
