// Emulates a block of GPU threads on the CPU, for core/sweep/kernel.cu. Each thread has its own context; the threads
// run one after the other from one exchange between them to the next. Included before the kernel with -include.
#pragma once
#include <ucontext.h>

#include <memory>

#define __global__
#define __device__
#define __shared__ extern  // defined by emulated_gpu.cpp, which fills it with an invalid bit pattern
#define __launch_bounds__(...)

namespace emulated {

struct Place {
    unsigned x;
};

inline constexpr int warp = 32;  // threads

struct Block {
    static constexpr int size = 4 * warp;
    static constexpr int stack = 1 << 18;
    ucontext_t scheduler, thread[size];
    std::unique_ptr<char[]> stacks[size];
    bool done[size];
    unsigned long long said[size], heard[size];
    int at = 0;  // the thread that runs
    long exchanges = 0;
    void (*body)(void*);
    void* argument;
};
inline Block block;
inline void (*at_exchange)() = nullptr;  // hook for tests

inline void enter() {
    block.body(block.argument);
    block.done[block.at] = true;
}

// Sends a value and returns the values of the warp's threads at this exchange.
inline const unsigned long long* exchange(unsigned long long mine) {
    block.said[block.at] = mine;
    swapcontext(&block.thread[block.at], &block.scheduler);
    return block.heard + block.at / warp * warp;
}

// Runs the threads of one block to their end. Returns the number of exchanges, or −1 if they did not stay synchronous.
inline long run(void (*body)(void*), void* argument) {
    block.body = body;
    block.argument = argument;
    block.exchanges = 0;
    for (int i = 0; i < Block::size; ++i) {
        block.stacks[i] = std::make_unique<char[]>(Block::stack);
        block.done[i] = false;
        getcontext(&block.thread[i]);
        block.thread[i].uc_stack = {.ss_sp = block.stacks[i].get(), .ss_flags = 0, .ss_size = Block::stack};
        block.thread[i].uc_link = &block.scheduler;
        makecontext(&block.thread[i], enter, 0);
    }
    for (;;) {
        int finished = 0;
        for (block.at = 0; block.at < Block::size; ++block.at) {
            swapcontext(&block.scheduler, &block.thread[block.at]);
            finished += block.done[block.at];
        }
        if (finished == Block::size) return block.exchanges;
        if (finished > 0) return -1;
        ++block.exchanges;
        if (at_exchange) at_exchange();
        for (int i = 0; i < Block::size; ++i) block.heard[i] = block.said[i];
    }
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
