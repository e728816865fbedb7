// Threads that go through one phase of tasks after the other together.
#pragma once
#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

#include "../../stop.hpp"

namespace hardlimit::particles::steps {

// Any number of threads may join, also late, and one alone does all the work: a phase is over when its tasks are,
// not when threads have arrived. Who ends the last task of a phase calls next(stop), which returns the number of
// tasks of the next phase, 0 at the end.
//
// Tasks are dealt out in shares, the same part of all tasks in every phase. A thread takes those of its own share
// first, so that what it needs is still in its cache, and then helps the others.
class Crew {
public:
    Crew(int shares, std::uint32_t first) : shares_(static_cast<std::size_t>(shares)) { begin(first); }

    template <class Next, class Task>
    void work(Stop& stop, const Next& next, const Task& task) {
        const std::size_t own = joined_.fetch_add(1, std::memory_order_relaxed) % shares_.size();
        for (std::uint64_t phase = phase_.load(std::memory_order_acquire); !over_;) {
            for (std::size_t k = 0; k < shares_.size(); ++k) {
                Share& share = shares_[(own + k) % shares_.size()];
                for (std::uint32_t index; share.take(index);) {
                    task(index);
                    if (left_.fetch_sub(1, std::memory_order_acq_rel) == 1) begin(next(stop));
                }
            }
            if (!changed(phase, stop)) return;
            phase = phase_.load(std::memory_order_acquire);
        }
    }

private:
    // The next task and the end of the share, in one number, so that nobody takes a task of another phase.
    struct alignas(64) Share {
        std::atomic<std::uint64_t> tickets{0};

        void deal(std::uint32_t first, std::uint32_t last) {
            tickets.store(std::uint64_t{last} << 32 | first, std::memory_order_release);
        }
        bool take(std::uint32_t& index) {
            std::uint64_t ticket = tickets.load(std::memory_order_acquire);
            while (static_cast<std::uint32_t>(ticket) < ticket >> 32)
                if (tickets.compare_exchange_weak(ticket, ticket + 1, std::memory_order_acq_rel)) {
                    index = static_cast<std::uint32_t>(ticket);
                    return true;
                }
            return false;
        }
    };

    std::vector<Share> shares_;
    std::atomic<std::size_t> joined_{0};
    alignas(64) std::atomic<std::uint32_t> left_{0};
    alignas(64) std::atomic<std::uint64_t> phase_{0};
    std::atomic<bool> over_{false};

    void begin(std::uint32_t tasks) {
        left_.store(tasks, std::memory_order_relaxed);
        if (tasks == 0) over_ = true;
        const std::uint64_t n = shares_.size();
        for (std::uint64_t k = 0; k < n; ++k)
            shares_[k].deal(static_cast<std::uint32_t>(tasks * k / n),
                            static_cast<std::uint32_t>(tasks * (k + 1) / n));
        phase_.fetch_add(1, std::memory_order_release);
    }

    // Waits for the next phase; false where the work is given up. Those who have tasks end it without this thread.
    bool changed(std::uint64_t phase, Stop& stop) const {
        constexpr int spins = 4000;  // some microseconds, longer than most phases
        for (int turn = 0; phase_.load(std::memory_order_acquire) == phase; ++turn) {
            if (turn < spins) continue;
            if (stop.now()) return false;
            std::this_thread::yield();
        }
        return true;
    }
};

}  // namespace hardlimit::particles::steps
