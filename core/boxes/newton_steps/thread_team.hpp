// Threads that go through one phase of tasks after the other together.
#pragma once
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <thread>
#include <vector>

#include "../../base/portable.hpp"
#include "../../base/stop.hpp"
#include "schedule.hpp"

namespace hardlimit::boxes::steps {

// Waiting: at first as attentive as can be, since most phases take microseconds, then ever less at others' expense.
class Wait {
public:
    // Whether to look after those who are waited for: once soon, and whenever they are late.
    bool looks() const { return turns_ == soon || late(); }
    bool late() const { return turns_ >= lateness; }
    // false: the work is given up.
    bool turn(Stop& stop) {
        if (++turns_ < eager) return true;
        if (turns_ < lateness) return relax(), true;
        if (stop.now()) return false;
        if (turns_ < drowsy)
            std::this_thread::yield();
        else
            std::this_thread::sleep_for(std::chrono::microseconds(50));
        return true;
    }

private:
    // In turns, which take some 20 ns each: the eager ones less, later ones more.
    static constexpr int eager = 16, soon = 50, lateness = 1000, drowsy = 1500;
    int turns_ = 0;
};

// Any number of threads may join, also late, and one alone does all the work: a phase is over when its tasks are,
// not when threads have arrived.
//
// Tasks are dealt out in shares, one for each thread. Each keeps to its own, so that what it needs stays in its cache,
// unless the owner of another one does not come or is late: the system may have given its processor to somebody else.
//
// The job is asked
//   next(stop)            to begin the next phase, by who has ended one
//   tasks(share)          how many tasks there are in this phase; at the end none in all shares
//   ready(share, task)    whether those that it needs are done; the first of a share needs none
//   perform(share, task)
class Crew {
public:
    explicit Crew(int shares) : shares_(static_cast<std::size_t>(shares)) {}

    template <class Job>
    void begin(Job& job) {
        std::uint32_t tasks = 0, last = 0;
        for (std::uint32_t k = 0; k < count(); ++k)
            if (job.tasks(k) > 0) tasks += job.tasks(k), last = k;
        if (tasks == 0) {
            over_ = true;
            return;
        }
        left_.store(tasks, std::memory_order_release);
        const std::uint64_t phase = ++phase_ << bits;
        // Once the last of them is dealt out, others may end the phase and begin the next one.
        for (std::uint32_t k = 0; k <= last; ++k)
            if (job.tasks(k) > 0) shares_[k].offered.store(phase | job.tasks(k), std::memory_order_release);
    }

    template <class Job>
    void work(Stop& stop, Job& job) {
        const std::uint32_t own = joined_.fetch_add(1, std::memory_order_relaxed) % count();
        // How far others' shares were when this thread left them.
        std::vector<std::uint64_t> left(count(), stale);
        for (Wait wait; !over_.load(std::memory_order_acquire);) {
            const bool stands_in =
                std::ranges::any_of(left, [](std::uint64_t taken) { return taken != stale; });
            if (takes_part(own, stands_in ? 1 : attentive, stop, job) || helps(own, wait, left, stop, job))
                wait = {};
            else if (!wait.turn(stop))
                return;
        }
    }

private:
    static constexpr int bits = 20;       // of a number of tasks
    static constexpr int attentive = 50;  // turns
    static constexpr std::uint64_t most = (std::uint64_t{1} << bits) - 1;
    // Both with the phase in the upper bits, so that nobody takes a task of another one. Who has waited reads the
    // first, written by another thread, and writes the second, which usually no other thread has had.
    struct Share {
        alignas(apart) std::atomic<std::uint64_t> offered{0};  // how many tasks
        alignas(apart) std::atomic<std::uint64_t> taken{0};
    };

    std::vector<Share> shares_;
    std::atomic<std::uint32_t> joined_{0};
    alignas(apart) std::atomic<bool> over_{false};
    alignas(apart) std::atomic<std::uint32_t> left_{0};  // tasks to be reported as done, and guests
    std::uint64_t phase_ = 0;                            // counts on; of who begins one

    std::uint32_t count() const { return static_cast<std::uint32_t>(shares_.size()); }

    // Where nobody has come, or somebody is late. Who has helped goes on at once until the owner is back.
    template <class Job>
    bool helps(std::uint32_t own, const Wait& wait, std::vector<std::uint64_t>& left, Stop& stop, Job& job) {
        for (std::uint32_t k = 1; k < count(); ++k) {
            const std::uint32_t share = (own + k) % count();
            const auto taken = [&] { return shares_[share].taken.load(std::memory_order_acquire); };
            if (left[share] != stale && left[share] != taken()) left[share] = stale;
            const bool stands_in = left[share] != stale;
            if (!stands_in && !wait.late() && !(wait.looks() && next_of(share) == 0)) continue;
            if (!takes_part(share, 1, stop, job)) continue;
            left[share] = taken();
            return true;
        }
        return false;
    }

    // The next task, of the phase of the offer; none where that is over already.
    static constexpr std::uint64_t stale = ~std::uint64_t{0};
    static std::uint64_t task_of(std::uint64_t offered, std::uint64_t taken) {
        if (taken >> bits == offered >> bits) return taken & most;
        return taken < offered ? 0 : stale;
    }
    std::uint64_t next_of(std::uint32_t share) const {
        const std::uint64_t offered = shares_[share].offered.load(std::memory_order_acquire);
        return task_of(offered, shares_[share].taken.load(std::memory_order_acquire));
    }

    // Does the tasks of a share until none is ready, and ends the phase after its last task; whether it did any. The
    // job may be asked what is ready only while the phase lasts: before a task is reported as done, or by a guest.
    template <class Job>
    bool takes_part(std::uint32_t share, int patience, Stop& stop, Job& job) {
        const std::uint64_t offered = shares_[share].offered.load(std::memory_order_acquire);
        std::atomic<std::uint64_t>& taken_by_all = shares_[share].taken;
        std::uint64_t taken = taken_by_all.load(std::memory_order_acquire);
        std::uint32_t reports = 0;
        const auto task = [&] { return task_of(offered, taken); };
        const auto any = [&] { return task() < (offered & most); };
        const auto take = [&] {
            const std::uint64_t now = task(), then = (offered & ~most) | (now + 1);
            if (!taken_by_all.compare_exchange_strong(taken, then, std::memory_order_acq_rel)) return;
            job.perform(share, static_cast<std::uint32_t>(now));
            taken = then, ++reports;
        };
        if (!any()) return false;
        if (task() == 0) take();
        const bool guest = reports == 0;
        if (guest) {
            if (!enters()) return false;
            ++reports;
            taken = taken_by_all.load(std::memory_order_acquire);
        }
        // Who has worked so far waits a little: what is missing comes soon, unless another thread is late.
        const auto ready = [&] {
            for (int turns = reports > guest ? patience : 1;; relax()) {
                if (job.ready(share, static_cast<std::uint32_t>(task()))) return true;
                if (--turns == 0) return false;
            }
        };
        while (any() && ready()) take();
        if (left_.fetch_sub(reports, std::memory_order_acq_rel) == reports) {
            job.next(stop);
            begin(job);
        }
        return !guest || reports > 1;
    }
    bool enters() {
        std::uint32_t left = left_.load(std::memory_order_relaxed);
        while (left > 0)
            if (left_.compare_exchange_weak(left, left + 1, std::memory_order_acq_rel)) return true;
        return false;
    }
};

}  // namespace hardlimit::boxes::steps
