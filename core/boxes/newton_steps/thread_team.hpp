// Team of threads that work together through a sequence of phases.
#pragma once
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <thread>
#include <vector>

#include "../../base/portable.hpp"
#include "../../base/stop.hpp"

namespace hardlimit::boxes::steps {

// Each phase has one task per partition of the work, and is over when all its tasks are done. Any number of threads may
// join, even late; a single thread does all the work. A thread keeps to its own partition, whose data stay in its
// cache. It takes over another partition if the owner is late, since the system may have preempted the owner.
//
// The work provides
//   perform(partition)   one task of the current phase
//   next(stop)           begins the next phase, called by one thread between two phases; false ends the work
class ThreadTeam {
public:
    explicit ThreadTeam(std::uint32_t partitions) : taken_(partitions), left_(partitions) {}

    std::uint32_t partitions() const { return static_cast<std::uint32_t>(taken_.size()); }

    // Main loop of each thread. It returns early only if asked to stop.
    template <class Work>
    void work(Stop& stop, Work& work) {
        const std::uint32_t own = joined_.fetch_add(1, std::memory_order_relaxed) % partitions();
        std::vector<std::uint64_t> helped(
            partitions());  // last phase in which this thread took over a partition
        int turns = 0;      // of waiting
        while (!over_.load(std::memory_order_acquire)) {
            const std::uint64_t phase = phase_.load(std::memory_order_acquire);
            std::uint32_t k = own;
            bool taken = take(own, phase);
            for (std::uint32_t j = 1; j < partitions() && !taken; ++j) {
                k = (own + j) % partitions();
                // A helper keeps a partition until its owner returns.
                taken = (turns >= late || helped[k] + 1 == phase) && take(k, phase);
                if (taken) helped[k] = phase;
            }
            if (!taken) {
                if (!wait(++turns, stop)) return;
                continue;
            }
            turns = 0;
            work.perform(k);
            if (left_.fetch_sub(1, std::memory_order_acq_rel) > 1) continue;
            left_.store(partitions(), std::memory_order_relaxed);
            if (work.next(stop))
                phase_.store(phase + 1, std::memory_order_release);
            else
                over_.store(true, std::memory_order_release);
        }
    }

private:
    // Limits in turns of about 20 ns. Most phases take microseconds, so a thread spins before it yields its processor.
    static constexpr int late = 1000, yields = 1500;
    static constexpr std::size_t apart = 128;  // two cache lines, which the hardware fetches in pairs
    struct alignas(apart) Taken {
        std::atomic<std::uint64_t> phase{
            0};  // the last one in which a thread took the task of this partition
    };

    std::vector<Taken> taken_;
    std::atomic<std::uint32_t> joined_{0};
    alignas(apart) std::atomic<std::uint32_t> left_;  // tasks of this phase that are not done
    alignas(apart) std::atomic<std::uint64_t> phase_{1};
    std::atomic<bool> over_{false};

    // A phase ends only once all its tasks have been taken, so a thread that still sees an earlier phase gets none.
    bool take(std::uint32_t partition, std::uint64_t phase) {
        std::atomic<std::uint64_t>& taken = taken_[partition].phase;
        std::uint64_t before = phase - 1;
        return taken.load(std::memory_order_relaxed) == before &&
               taken.compare_exchange_strong(before, phase, std::memory_order_acq_rel);
    }
    static bool wait(int turns, Stop& stop) {
        if (turns < late) return relax(), true;
        if (stop.now()) return false;
        if (turns < yields)
            std::this_thread::yield();
        else
            std::this_thread::sleep_for(std::chrono::microseconds(50));
        return true;
    }
};

}  // namespace hardlimit::boxes::steps
