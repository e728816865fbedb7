// Threads that work on one computation together: start, barrier, progress, stop, exceptions.
#pragma once
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "stop.hpp"

namespace hardlimit {

// A barrier for phases of microseconds: threads spin first, then yield, then sleep.
class SpinBarrier {
public:
    explicit SpinBarrier(int threads) : threads_(threads), missing_(threads) {}

    // Waits for all threads. The last to arrive calls last() before the others go on. Returns false once abandoned.
    template <class Last>
    bool arrive_and_wait(const Last& last) {
        const unsigned phase = phase_.load(std::memory_order_relaxed);
        if (missing_.fetch_sub(1, std::memory_order_acq_rel) == 1) {
            last();
            missing_.store(threads_, std::memory_order_relaxed);
            phase_.store(phase + 1, std::memory_order_release);
            return true;
        }
        for (int turns = 0; phase_.load(std::memory_order_acquire) == phase; ++turns) {
            if (abandoned_.load(std::memory_order_relaxed)) return false;
            if (turns < spins)
                relax();
            else if (turns < yields)
                std::this_thread::yield();
            else
                std::this_thread::sleep_for(std::chrono::microseconds(50));
        }
        return true;
    }
    void abandon() { abandoned_.store(true, std::memory_order_relaxed); }

private:
    static constexpr int spins = 1000, yields = 1500;  // turns; a spin takes some 20 ns
    // Two cache lines apart, which the hardware fetches in pairs.
    static constexpr std::size_t apart = 128;
    const int threads_;
    alignas(apart) std::atomic<int> missing_;
    alignas(apart) std::atomic<unsigned> phase_{0};
    std::atomic<bool> abandoned_{false};
};

// What the first thread throws stops the others and is thrown to the caller.
class ThreadTeam {
public:
    // One thread of the team.
    class Member {
    public:
        int index, count;  // of the threads that have started
        Stop stop;

        // Waits for all members. The last one to arrive calls last() before the others go on.
        template <class Last>
        void sync(const Last& last) {
            if (!barrier_.arrive_and_wait(last)) throw Abandoned{};
        }
        void sync() {
            sync([] {});
        }
        // The part of 0 … n − 1 that belongs to this member: first, last.
        template <class N>
        std::pair<N, N> part_of(N n) const {
            const auto at = [&](int k) {
                return static_cast<N>(std::uint64_t{n} * static_cast<std::uint64_t>(k) /
                                      static_cast<std::uint64_t>(count));
            };
            return {at(index), at(index + 1)};
        }

    private:
        friend ThreadTeam;
        SpinBarrier& barrier_;
        Member(int i, int n, Stop s, SpinBarrier& barrier) : index(i), count(n), stop(s), barrier_(barrier) {}
    };

    // Calls work(member) on `threads` threads and `watch()` on this one every `period`, until all have returned.
    // `watch` returns whether to stop. If the system refuses to start some of the threads, the others do the work. If
    // it starts none, this thread works alone and calls `watch` whenever the work asks whether to stop.
    template <class Work, class Watch>
    void run(int threads, std::chrono::milliseconds period, const Work& work, const Watch& watch) {
        std::vector<std::jthread> pool = start(threads, work);
        if (pool.empty())
            run_alone(period, work, watch);
        else
            wait(period, watch);
        pool.clear();  // joins
        if (failure_) std::rethrow_exception(failure_);
    }

private:
    // Thrown to a member that waits for one which has failed.
    struct Abandoned {};

    std::atomic<bool> stop_{false};
    std::mutex guard_;  // of all that follows
    std::condition_variable changed_;
    int size_ = 0, working_ = 0;          // threads that have started, and those that have not returned
    std::exception_ptr failure_;          // the first
    std::optional<SpinBarrier> barrier_;  // once all have started

    static bool is_stopped(void* team) { return static_cast<ThreadTeam*>(team)->stop_; }

    template <class Action>
    void attempt(const Action& action) noexcept {
        try {
            action();
        } catch (const Abandoned&) {  // another member has failed
        } catch (...) {
            stop_ = true;
            const std::lock_guard lock(guard_);
            if (!failure_) failure_ = std::current_exception();
            if (barrier_) barrier_->abandon();
        }
    }

    // The threads begin to work once all have started, since each is told how many they are.
    template <class Work>
    std::vector<std::jthread> start(int threads, const Work& work) {
        std::vector<std::jthread> pool;
        pool.reserve(static_cast<std::size_t>(threads));
        const auto run_member = [this, &work](int index) {
            std::unique_lock lock(guard_);
            changed_.wait(lock, [this] { return barrier_.has_value(); });
            lock.unlock();
            attempt([&] {
                Member member(index, size_, Stop(&is_stopped, this), *barrier_);
                work(member);
            });
            lock.lock();
            if (--working_ == 0) changed_.notify_all();
        };
        try {
            for (; size_ < threads; ++size_) pool.emplace_back(run_member, size_);
        } catch (...) {  // no more threads or memory
        }
        const std::lock_guard lock(guard_);
        working_ = size_;
        barrier_.emplace(size_);
        changed_.notify_all();
        return pool;
    }

    template <class Watch>
    void wait(std::chrono::milliseconds period, const Watch& watch) {
        std::unique_lock lock(guard_);
        while (!changed_.wait_for(lock, period, [this] { return working_ == 0; })) {
            lock.unlock();
            if (!stop_)
                attempt([&] {
                    if (watch()) stop_ = true;
                });
            lock.lock();
        }
    }

    template <class Work, class Watch>
    void run_alone(std::chrono::milliseconds period, const Work& work, const Watch& watch) {
        using Clock = std::chrono::steady_clock;
        struct Context {
            const Watch& watch;
            std::chrono::milliseconds period;
            Clock::time_point next;
        } context{watch, period, Clock::now() + period};
        const auto ask = [](void* of) {
            Context& c = *static_cast<Context*>(of);
            if (Clock::now() < c.next) return false;
            c.next = Clock::now() + c.period;
            return c.watch();
        };
        barrier_.emplace(1);
        attempt([&] {
            Member member(0, 1, Stop(ask, &context), *barrier_);
            work(member);
        });
    }
};

}  // namespace hardlimit
