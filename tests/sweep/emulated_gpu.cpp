// Library for tests/sweep/test_cuda.py: runs core/sweep/kernel.cu in the emulated block of emulated_gpu.hpp.
#include <cstring>

#include "kernel.cu"

static_assert(hardlimit::sweep::block == emulated::Block::size);
unsigned long long room[sizeof(hardlimit::sweep::Pool) / 8 + 1];

namespace {
struct Call {
    void (*kernel)(Task*);
    Task* task;
};
// Returns 0 if the threads stayed synchronous to the end.
int emulate(void (*kernel)(Task*), Task* task) {
    std::memset(room, 0xa5, sizeof room);
    Call call{kernel, task};
    const auto body = [](void* c) { static_cast<Call*>(c)->kernel(static_cast<Call*>(c)->task); };
    return emulated::run(body, &call) < 0;
}
}  // namespace

extern "C" int emulate_solve(Task* task) { return emulate(solve, task); }
extern "C" int emulate_damping_ratios(Task* task) { return emulate(damping_ratios, task); }
