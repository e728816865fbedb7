// The next events of all particles in the order of their times.
#pragma once
#include "../queue/calendar_queue.hpp"
#include "../queue/prefetch.hpp"
#include "cell_assignment.hpp"

namespace hardlimit::boxes::spheres {

template <int d, bool mixed>
class Schedule {
public:
    Schedule(const Particles<d, mixed>& particles, const CellAssignment<d, mixed>& cells)
        : particles_(particles), cells_(cells) {}

    void rebuild() {
        large_ = particles_.size() > most_in_caches;
        calendar_.rebuild(particles_.size(), time(), by_original_index());
    }
    void push(u32 i) { calendar_.push(i, particles_.pending[i].time(), by_original_index()); }
    // The next event, or nullptr. It stays until pop().
    const QueuedEvent* next() {
        return calendar_.next(time(), by_original_index(), [this] {
            if (large_) ahead().enter_bin();
        });
    }
    // Removes the event that next() returned, and prefetches the data of later ones.
    void pop() {
        calendar_.pop();
        if (large_)
            ahead().step();
        else if (particles_.rotates())
            calendar_.ahead(spins_ahead, [this](u32 id) { fetch_spins(id); });
    }
    // Whether the particles are more than the caches hold.
    bool large() const { return large_; }
    std::size_t bytes() const { return calendar_.bytes(); }

private:
    const Particles<d, mixed>& particles_;
    const CellAssignment<d, mixed>& cells_;
    CalendarQueue calendar_;
    bool large_ = false;
    // Events ahead at which spins are fetched: only collisions read them, so that they leave the small caches.
    static constexpr std::size_t spins_ahead = 2;

    void fetch_spins(u32 id) const {
        const u32 partner = particles_.pending[id].partner;
        prefetch_near(&particles_.spins[id]);
        if (partner != no_particle) prefetch_near(&particles_.spins[partner]);
    }
    auto time() const {
        return [this](u32 id) { return particles_.pending[id].time(); };
    }
    auto by_original_index() const {
        return [this](u32 id) { return particles_.original_index[id]; };
    }
    auto ahead() const {
        return Prefetcher{calendar_,
                          cells_.cells(),
                          particles_.pending.data(),
                          particles_.paths.data(),
                          [this](u32 id) { return cells_.level(id); },
                          [this](u32 id) {
                              if (particles_.rotates()) prefetch(&particles_.spins[id]);
                          },
                          [this](u32 id) {
                              if (mixed) prefetch(&particles_.pending[id]);
                          }};
    }
};

}  // namespace hardlimit::boxes::spheres
