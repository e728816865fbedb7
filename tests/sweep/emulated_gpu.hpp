// Emulates a block of GPU threads on the CPU, for core/sweep/kernel.cu. Each thread has its own context; the threads
// run one after the other from one exchange between them to the next. Included before the kernel with -include.
#pragma once
#include <ucontext.h>

#include <functional>
#include <memory>

#define __global__
#define __device__
#define __shared__ extern  // defined by emulated_gpu.cpp, which fills it with an invalid bit pattern
#define __launch_bounds__(...)

namespace emulated {

struct Place {
    unsigned x;
};

inline constexpr int warp = 32;                 // threads
inline constexpr int most_exchanges = 500'000;  // five times as many as the tests take

struct Block {
    static constexpr int size = 4 * warp;
    static constexpr int stack = 1 << 18;
    ucontext_t scheduler, thread[size];
    std::unique_ptr<char[]> stacks[size];
    bool done[size];
    unsigned long long said[size], heard[size];
    int at = 0;  // the thread that runs
    std::function<void()> body;
};
inline Block block;
inline void (*at_exchange)() = nullptr;  // hook for tests

inline void enter() {
    block.body();
    block.done[block.at] = true;
}

// Sends a value and returns the values of the warp's threads at this exchange.
inline const unsigned long long* exchange(unsigned long long mine) {
    block.said[block.at] = mine;
    swapcontext(&block.thread[block.at], &block.scheduler);
    return block.heard + block.at / warp * warp;
}

// Runs a kernel in one block of threads. Returns whether they stayed synchronous to their end, which must come.
template <class Task>
bool run(void (*kernel)(Task*), Task* task) {
    block.body = [=] { kernel(task); };
    for (int i = 0; i < Block::size; ++i) {
        block.stacks[i] = std::make_unique<char[]>(Block::stack);
        block.done[i] = false;
        getcontext(&block.thread[i]);
        block.thread[i].uc_stack = {.ss_sp = block.stacks[i].get(), .ss_flags = 0, .ss_size = Block::stack};
        block.thread[i].uc_link = &block.scheduler;
        makecontext(&block.thread[i], enter, 0);
    }
    for (int exchanges = 0; exchanges < most_exchanges; ++exchanges) {
        int finished = 0;
        for (block.at = 0; block.at < Block::size; ++block.at) {
            swapcontext(&block.scheduler, &block.thread[block.at]);
            finished += block.done[block.at];
        }
        if (finished > 0) return finished == Block::size;
        if (at_exchange) at_exchange();
        for (int i = 0; i < Block::size; ++i) block.heard[i] = block.said[i];
    }
    return false;
}

}  // namespace emulated

// CUDA built-in variables.
struct EmulatedThread {
    operator unsigned() const { return static_cast<unsigned>(emulated::block.at); }
};
inline struct {
    EmulatedThread x;
} threadIdx;
inline constexpr emulated::Place blockIdx{0}, blockDim{emulated::Block::size}, gridDim{1};

inline unsigned __ballot_sync(unsigned, bool mine) {
    const unsigned long long* said = emulated::exchange(mine);
    unsigned all = 0;
    for (int i = 0; i < emulated::warp; ++i) all |= static_cast<unsigned>(said[i] != 0) << i;
    return all;
}
inline unsigned long long __shfl_sync(unsigned, unsigned long long mine, int lane) {
    return emulated::exchange(mine)[lane];
}
inline void __syncthreads() { emulated::exchange(0); }
template <class T>
inline T atomicAdd(T* to, T n) {
    const T before = *to;
    *to += n;
    return before;
}
inline int __popc(unsigned x) { return __builtin_popcount(x); }
