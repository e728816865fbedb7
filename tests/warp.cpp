// core/sweep/kernel.cu in the emulated warp of warp.hpp, for tests/test_cuda.py.
#include "kernel.cu"

namespace {
struct Call {
    void (*kernel)(Task*);
    Task* task;
};
// 0 if the threads stayed in step to the end.
int emulate(void (*kernel)(Task*), Task* task) {
    Call call{kernel, task};
    const auto body = [](void* c) { static_cast<Call*>(c)->kernel(static_cast<Call*>(c)->task); };
    return emulated::run(body, &call) < 0;
}
}  // namespace

extern "C" int emulate_solve(Task* task) { return emulate(solve, task); }
extern "C" int emulate_damping_ratios(Task* task) { return emulate(damping_ratios, task); }
