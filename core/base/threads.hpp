// Threads that work on one computation: start, progress, stop, exceptions.
#pragma once
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "stop.hpp"

namespace hardlimit {

// The first exception of a thread stops the others and is thrown to the caller.
class ThreadPool {
public:
    // Calls work(stop) on `threads` threads and `watch()` on this one every `period`, until all have returned. `watch`
    // returns whether to stop. If the system cannot start some of the threads, the others do the work. If it starts
    // none, this thread works alone and calls `watch` when the work asks whether to stop.
    template <class Work, class Watch>
    void run(int threads, std::chrono::milliseconds period, const Work& work, const Watch& watch) {
        start(threads, work);
        if (pool_.empty())
            alone(period, work, watch);
        else
            wait(period, watch);
        pool_.clear();  // joins
        if (failure_) std::rethrow_exception(failure_);
    }

private:
    std::atomic<bool> stop_{false};
    std::mutex guard_;
    std::condition_variable ended_;
    int working_ = 0;             // threads; guarded
    std::exception_ptr failure_;  // the first; guarded
    std::vector<std::jthread> pool_;

    static bool asked(void* pool) { return static_cast<ThreadPool*>(pool)->stop_; }

    template <class Action>
    void attempt(const Action& action) noexcept {
        try {
            action();
        } catch (...) {
            stop_ = true;
            const std::lock_guard lock(guard_);
            if (!failure_) failure_ = std::current_exception();
        }
    }

    template <class Work>
    void start(int threads, const Work& work) {
        pool_.reserve(static_cast<std::size_t>(threads));
        for (int i = 0; i < threads; ++i) {
            {
                const std::lock_guard lock(guard_);
                ++working_;
            }
            try {
                pool_.emplace_back([this, &work] {
                    attempt([&] {
                        Stop stop(&asked, this);
                        work(stop);
                    });
                    const std::lock_guard lock(guard_);
                    if (--working_ == 0) ended_.notify_one();
                });
            } catch (...) {  // no more threads or memory
                const std::lock_guard lock(guard_);
                --working_;
                break;
            }
        }
    }

    template <class Watch>
    void wait(std::chrono::milliseconds period, const Watch& watch) {
        std::unique_lock lock(guard_);
        while (!ended_.wait_for(lock, period, [this] { return working_ == 0; })) {
            lock.unlock();
            if (!stop_)
                attempt([&] {
                    if (watch()) stop_ = true;
                });
            lock.lock();
        }
    }

    template <class Work, class Watch>
    void alone(std::chrono::milliseconds period, const Work& work, const Watch& watch) {
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
        attempt([&] {
            Stop stop(ask, &context);
            work(stop);
        });
    }
};

}  // namespace hardlimit
