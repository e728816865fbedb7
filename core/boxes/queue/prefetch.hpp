// What the coming events will need is fetched while others are dealt with: a large box is otherwise a chain of waits
// for memory. The calendar knows the events to come; those that are superseded meanwhile cost a useless fetch.
#pragma once
#include "../common/particle.hpp"
#include "../neighbours/cells.hpp"
#include "calendar_queue.hpp"

namespace hardlimit::boxes {

// level(id): the grid of a body's cell. more(id): fetches what else is read of a body that has an event; beside(id):
// and of its neighbours, besides where they are.
template <int d, class Held, class Level, class More, class Beside>
struct Prefetcher {
    const CalendarQueue& calendar;
    const Cells<d>& cells;
    const Held* pending;  // records of Pending, and what may be held beside it
    const Particle<d>* bodies;
    Level level;
    More more;
    Beside beside;

    static constexpr std::size_t cells_ahead = 14, neighbours_ahead = 6;  // events before theirs

    // Called once for each event: those that come somewhat later move on by one stage.
    void step() const {
        calendar.ahead(cells_ahead, [this](u32 id) { fetch_cells(id); });
        calendar.ahead(neighbours_ahead, [this](u32 id) { fetch_neighbours(id); });
    }
    // The first events of a bin have had no others before them.
    void enter_bin() const {
        calendar.fetch_next([this](u32 id) { prefetch(&pending[id]); });
        for (std::size_t k = 0; k < cells_ahead; ++k) calendar.ahead(k, [this](u32 id) { fetch_cells(id); });
        for (std::size_t k = 0; k < neighbours_ahead; ++k)
            calendar.ahead(k, [this](u32 id) { fetch_neighbours(id); });
    }

private:
    // Where a body will look at its next event.
    static typename Cells<d>::Surroundings surroundings(const Pending& e) {
        const SelfEvent own = static_cast<SelfEvent>(e.own);
        if (e.pair_time <= e.own_time || own == SelfEvent::rescan || own == SelfEvent::ends) return {};
        return Cells<d>::Surroundings::beyond(axis_of(own), is_high(own));
    }
    // The cells there, the body, and the one it meets.
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
    // The bodies in those cells.
    void fetch_neighbours(u32 i) const {
        const Pending& e = pending[i];
        cells.for_inline(level(i), e.cell, surroundings(e), [this](u32 id) {
            prefetch(&bodies[id]);
            beside(id);
        });
    }
};
template <int d, class Held, class Level, class More, class Beside>
Prefetcher(const CalendarQueue&, const Cells<d>&, const Held*, const Particle<d>*, Level, More, Beside)
    -> Prefetcher<d, Held, Level, More, Beside>;

}  // namespace hardlimit::boxes
