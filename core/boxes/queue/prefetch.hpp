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

    // Events ahead at which the cells around a body, those around its partner, and the bodies in both are fetched.
    static constexpr std::size_t cells_ahead = 12, partner_ahead = 8, neighbours_ahead = 4;

    // Called once per event: prefetches for the events at these distances ahead.
    void step() const {
        calendar.ahead(cells_ahead, [this](u32 id) { fetch_cells(id); });
        calendar.ahead(partner_ahead, [this](u32 id) { fetch_cells_of_partner(id); });
        calendar.ahead(neighbours_ahead, [this](u32 id) { fetch_neighbours(id); });
    }
    // Prefetches for the first events of a bin, which step() has not covered.
    void enter_bin() const {
        calendar.fetch_next([this](u32 id) { prefetch(&pending[id]); });
        for (std::size_t k = 0; k < cells_ahead; ++k) calendar.ahead(k, [this](u32 id) { fetch_cells(id); });
        for (std::size_t k = 0; k < partner_ahead; ++k)
            calendar.ahead(k, [this](u32 id) { fetch_cells_of_partner(id); });
        for (std::size_t k = 0; k < neighbours_ahead; ++k)
            calendar.ahead(k, [this](u32 id) { fetch_neighbours(id); });
    }

private:
    using Stencil = typename Cells<d>::Stencil;

    static bool collides(const PendingEvents& e) {
        return e.pair_time <= e.own_time && e.partner != no_particle;
    }
    // Cells that a body will search at its next event.
    static Stencil surroundings(const PendingEvents& e) {
        const SelfEvent own = static_cast<SelfEvent>(e.own);
        if (collides(e) || own == SelfEvent::rescan || own == SelfEvent::ends) return {};
        return Stencil::beyond(axis_of(own), is_high(own));
    }
    // Prefetches those cells, the body, and its partner.
    void fetch_cells(u32 i) const {
        const PendingEvents& e = pending[i];
        prefetch(&bodies[i]);
        more(i);
        if (collides(e)) {
            prefetch(&bodies[e.partner]);
            prefetch(&pending[e.partner]);
            more(e.partner);
        }
        cells.fetch(level(i), e.cell, surroundings(e));
    }
    void fetch_cells_of_partner(u32 i) const {
        const PendingEvents& e = pending[i];
        if (collides(e)) cells.fetch(level(e.partner), pending[e.partner].cell, Stencil{});
    }
    // Prefetches the bodies in the cells of both.
    void fetch_neighbours(u32 i) const {
        const PendingEvents& e = pending[i];
        fetch_bodies(i, surroundings(e));
        if (collides(e)) fetch_bodies(e.partner, Stencil{});
    }
    void fetch_bodies(u32 i, const Stencil& s) const {
        cells.for_inline(level(i), pending[i].cell, s, [this](u32 id) {
            prefetch(&bodies[id]);
            beside(id);
        });
    }
};
template <int d, class Events, class Level, class More, class Beside>
Prefetcher(const CalendarQueue&, const Cells<d>&, const Events*, const Particle<d>*, Level, More, Beside)
    -> Prefetcher<d, Events, Level, More, Beside>;

}  // namespace hardlimit::boxes
