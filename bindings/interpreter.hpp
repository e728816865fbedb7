// Releases the interpreter lock during a computation and checks for Ctrl-C meanwhile.
#pragma once
#include <nanobind/nanobind.h>

#include <chrono>
#include <thread>
#include <utility>

#include "base/stop.hpp"

namespace hardlimit::bindings {

// Releases the interpreter lock for its lifetime.
class Unlocked {
public:
    static constexpr std::chrono::milliseconds period{50};  // between two checks for signals

    Unlocked() : state_(PyEval_SaveThread()) {}
    ~Unlocked() {
        if (state_) lock();
    }
    Unlocked(const Unlocked&) = delete;
    Unlocked& operator=(const Unlocked&) = delete;

    // Before Python 3.14, a thread that acquires the lock during interpreter shutdown is terminated by stack unwinding,
    // which aborts in a C++ destructor. The thread sleeps until the process exits instead, as Python does from 3.14 on.
    void lock() {
        try {
            PyEval_RestoreThread(std::exchange(state_, nullptr));
        } catch (...) {
            for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
        }
    }
    void unlock() { state_ = PyEval_SaveThread(); }

    // Runs the signal handlers. Returns whether one raised an exception, which is then pending.
    bool signalled() {
        lock();
        const bool raised = PyErr_CheckSignals() != 0;
        unlock();
        return raised;
    }

    // A stop condition that a computation can check at every step.
    Stop stop() { return Stop(&ask, this); }

private:
    using Clock = std::chrono::steady_clock;
    PyThreadState* state_;
    Clock::time_point
        next_{};  // next check; set by the first call of ask, so that a short solve never reads the clock

    static bool ask(void* of) {
        Unlocked& self = *static_cast<Unlocked*>(of);
        const Clock::time_point now = Clock::now(), due = self.next_;
        if (due != Clock::time_point{} && now < due) return false;
        self.next_ = now + period;
        return due != Clock::time_point{} && self.signalled();
    }
};

// Calls f(stop) without the interpreter lock. Ctrl-C stops it and is rethrown as the Python exception.
template <class F>
auto unlocked(F&& f) {
    Unlocked open;
    Stop stop = open.stop();
    auto result = f(stop);
    open.lock();
    if (stop.stopped()) throw nanobind::python_error();
    return result;
}

}  // namespace hardlimit::bindings
