// Emulates a warp of 32 GPU threads on the CPU, for core/sweep/kernel.cu. Each thread has its own context; the threads
// run one after the other from one exchange between them to the next. Included before the kernel with -include.
#pragma once
#include <ucontext.h>

#include <memory>

#define __global__
#define __device__
#define __shared__ extern  // defined by warp.cpp, which fills it with an invalid bit pattern
#define __launch_bounds__(n)

namespace emulated {

struct Place {
    unsigned x;
};

struct Warp {
    static constexpr int size = 32;
    static constexpr int stack = 1 << 18;
    ucontext_t scheduler, thread[size];
    std::unique_ptr<char[]> stacks[size];
    bool done[size];
    unsigned long long said[size], heard[size];
    int lane = 0;
    long exchanges = 0;
    void (*body)(void*);
    void* argument;
};
inline Warp w;
inline void (*at_exchange)() = nullptr;  // hook for tests

inline void enter() {
    w.body(w.argument);
    w.done[w.lane] = true;
}

// Sends a value and returns the values of all threads of the warp at this exchange.
inline const unsigned long long* exchange(unsigned long long mine) {
    w.said[w.lane] = mine;
    swapcontext(&w.thread[w.lane], &w.scheduler);
    return w.heard;
}

// Runs the threads of one warp to their end. Returns the number of exchanges, or −1 if they did not stay synchronous.
inline long run(void (*body)(void*), void* argument) {
    w.body = body;
    w.argument = argument;
    w.exchanges = 0;
    for (int i = 0; i < Warp::size; ++i) {
        w.stacks[i] = std::make_unique<char[]>(Warp::stack);
        w.done[i] = false;
        getcontext(&w.thread[i]);
        w.thread[i].uc_stack = {.ss_sp = w.stacks[i].get(), .ss_flags = 0, .ss_size = Warp::stack};
        w.thread[i].uc_link = &w.scheduler;
        makecontext(&w.thread[i], enter, 0);
    }
    for (;;) {
        int finished = 0;
        for (w.lane = 0; w.lane < Warp::size; ++w.lane) {
            swapcontext(&w.scheduler, &w.thread[w.lane]);
            finished += w.done[w.lane];
        }
        if (finished == Warp::size) return w.exchanges;
        if (finished > 0) return -1;
        ++w.exchanges;
        if (at_exchange) at_exchange();
        for (int i = 0; i < Warp::size; ++i) w.heard[i] = w.said[i];
    }
}

}  // namespace emulated

// CUDA built-in variables.
struct EmulatedLane {
    operator unsigned() const { return static_cast<unsigned>(emulated::w.lane); }
};
inline struct {
    EmulatedLane x;
} threadIdx;
inline constexpr emulated::Place blockIdx{0}, blockDim{emulated::Warp::size}, gridDim{1};

inline unsigned __ballot_sync(unsigned, bool mine) {
    const unsigned long long* said = emulated::exchange(mine);
    unsigned all = 0;
    for (int i = 0; i < emulated::Warp::size; ++i) all |= static_cast<unsigned>(said[i] != 0) << i;
    return all;
}
inline unsigned long long __shfl_sync(unsigned, unsigned long long mine, int lane) {
    return emulated::exchange(mine)[lane];
}
inline void __syncwarp() { emulated::exchange(0); }
inline unsigned long long atomicAdd(unsigned long long* to, unsigned long long n) {
    const unsigned long long before = *to;
    *to += n;
    return before;
}
inline int __popc(unsigned x) { return __builtin_popcount(x); }
