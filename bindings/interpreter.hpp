// The interpreter's lock around a computation: given up, taken back, and Ctrl-C noticed in between.
#pragma once
#include <nanobind/nanobind.h>

#include <chrono>
#include <thread>
#include <utility>

#include "base/stop.hpp"

namespace hardlimit::bindings {

// The interpreter runs other threads while this object lives.
class Unlocked {
public:
    static constexpr std::chrono::milliseconds period{50};  // between two looks at the signals

    Unlocked() : state_(PyEval_SaveThread()) {}
    ~Unlocked() {
        if (state_) lock();
    }
    Unlocked(const Unlocked&) = delete;
    Unlocked& operator=(const Unlocked&) = delete;

    // Before Python 3.14 a thread that asks for the lock while the interpreter shuts down is ended by unwinding its
    // stack, which no C++ destructor survives. It sleeps instead until the process is gone, as from 3.14 on.
    void lock() {
        try {
            PyEval_RestoreThread(std::exchange(state_, nullptr));
        } catch (...) {
            for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
        }
    }
    void unlock() { state_ = PyEval_SaveThread(); }

    // Lets the signal handlers run; whether one has raised an exception, which then waits to be thrown.
    bool signalled() {
        lock();
        const bool raised = PyErr_CheckSignals() != 0;
        unlock();
        return raised;
    }

    // For a computation that asks at every step.
    Stop stop() { return Stop(&ask, this); }

private:
    using Clock = std::chrono::steady_clock;
    PyThreadState* state_;
    Clock::time_point next_{};  // not before the first question: a short solve never reads the clock

    static bool ask(void* of) {
        Unlocked& self = *static_cast<Unlocked*>(of);
        const Clock::time_point now = Clock::now(), due = self.next_;
        if (due != Clock::time_point{} && now < due) return false;
        self.next_ = now + period;
        return due != Clock::time_point{} && self.signalled();
    }
};

// f(stop) with the interpreter unlocked. Ctrl-C makes it give up, and is thrown.
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
