// Threads that go through one phase of tasks after the other together.
#pragma once
#include <atomic>
#include <cstdint>
#include <thread>

#include "../../stop.hpp"

namespace hardlimit::particles::steps {

// Any number of threads may join, also late, and one alone does all the work: a phase is over when its tasks are, not when
// threads have arrived. Who ends the last task of a phase calls next(stop), which returns the number of tasks of
// the next phase, 0 at the end.
class Crew {
public:
    explicit Crew(std::uint32_t first) { begin(0, first); }

    template <class Next, class Task>
    void work(Stop& stop, const Next& next, const Task& task) {
        for (;;) {
            const std::uint64_t ticket = tickets_.fetch_add(1, std::memory_order_acq_rel);
            const std::uint64_t tasks = ticket >> 20 & mask, index = ticket & mask;
            if (tasks == 0) return;
            if (index < tasks) {
                task(static_cast<std::uint32_t>(index));
                if (left_.fetch_sub(1, std::memory_order_acq_rel) == 1) begin((ticket >> 40) + 1, next(stop));
            } else if (!changed(ticket >> 40, stop)) {
                return;
            }
        }
    }

private:
    static constexpr std::uint64_t mask = (1u << 20) - 1;
    // phase · 2⁴⁰ + its tasks · 2²⁰ + the next one: one number, so that nobody takes a task of another phase.
    alignas(64) std::atomic<std::uint64_t> tickets_{0};
    alignas(64) std::atomic<std::uint32_t> left_{0};

    void begin(std::uint64_t phase, std::uint32_t tasks) {
        left_.store(tasks, std::memory_order_relaxed);
        tickets_.store(phase << 40 | std::uint64_t{tasks} << 20, std::memory_order_release);
    }

    // Waits for the next phase; false where the work is given up. Those who have tasks end it without this thread.
    bool changed(std::uint64_t phase, Stop& stop) const {
        constexpr int spins = 4000;  // some microseconds, longer than most phases
        for (int turn = 0; tickets_.load(std::memory_order_acquire) >> 40 == phase; ++turn) {
            if (turn < spins) continue;
            if (stop.now()) return false;
            std::this_thread::yield();
        }
        return true;
    }
};

}  // namespace hardlimit::particles::steps
