// Library for tests/sweep/test_cuda.py: runs core/sweep/kernel.cu in the emulated block of emulated_gpu.hpp.
#include <cstring>

#include "kernel.cu"

static_assert(hardlimit::sweep::block == emulated::Block::size);
unsigned long long room[sizeof(hardlimit::sweep::Pool) / 8 + 1];

// Each returns 0 if the threads stayed synchronous to the end.
extern "C" int emulate_solve(Task* task) {
    std::memset(room, 0xa5, sizeof room);
    return !emulated::run(solve, task);
}
extern "C" int emulate_damping_ratios(Task* task) { return !emulated::run(damping_ratios, task); }
