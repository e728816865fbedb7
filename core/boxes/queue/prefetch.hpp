// Prefetches the data of upcoming events, since a large box would otherwise wait for memory at each event. The upcoming
// events come from the calendar queue; an event that is superseded before it is processed costs a useless fetch.
#pragma once
#include "../common/particle.hpp"
#include "../neighbours/cells.hpp"
#include "calendar_queue.hpp"

namespace hardlimit::boxes {

// level(id): grid of a body's cell. more(id): prefetches further data of a body with an event. beside(id): prefetches
// further data of a neighbour.
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

    // Called once per event: prefetches for the events at both distances ahead.
    void step() const {
        calendar.ahead(cells_ahead, [this](u32 id) { fetch_cells(id); });
        calendar.ahead(neighbours_ahead, [this](u32 id) { fetch_neighbours(id); });
    }
    // Prefetches for the first events of a bin, which step() has not covered.
    void enter_bin() const {
        calendar.fetch_next([this](u32 id) { prefetch(&pending[id]); });
        for (std::size_t k = 0; k < cells_ahead; ++k) calendar.ahead(k, [this](u32 id) { fetch_cells(id); });
        for (std::size_t k = 0; k < neighbours_ahead; ++k)
            calendar.ahead(k, [this](u32 id) { fetch_neighbours(id); });
    }

private:
    // Cells that a body will search at its next event.
    static typename Cells<d>::Stencil surroundings(const PendingEvents& e) {
        const SelfEvent own = static_cast<SelfEvent>(e.own);
        if (e.pair_time <= e.own_time || own == SelfEvent::rescan || own == SelfEvent::ends) return {};
        return Cells<d>::Stencil::beyond(axis_of(own), is_high(own));
    }
    // Prefetches those cells, the body, and its partner.
    void fetch_cells(u32 i) const {
        const PendingEvents& e = pending[i];
        prefetch(&bodies[i]);
        more(i);
        if (e.pair_time <= e.own_time) {
            prefetch(&bodies[e.partner]);
            prefetch(&pending[e.partner]);
            more(e.partner);
        }
        cells.fetch(level(i), e.cell, surroundings(e));
    }
    // Prefetches the bodies in those cells.
    void fetch_neighbours(u32 i) const {
        const PendingEvents& e = pending[i];
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
