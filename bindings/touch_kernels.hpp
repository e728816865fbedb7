// The kernels of boxes for the processor at hand.
#pragma once
#include "boxes/kernels/interface.hpp"

extern const hardlimit_abi::TouchKernels hardlimit_touch_base, hardlimit_touch_avx2, hardlimit_touch_avx512;

namespace hardlimit::bindings {

// Those for the widest registers that it has. Which, changes the speed, never the result.
inline const hardlimit_abi::TouchKernels& touch_kernels() {
#if defined(HARDLIMIT_X86)
    static const bool wide = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                             __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw");
    if (wide) return hardlimit_touch_avx512;
    if (__builtin_cpu_supports("avx2")) return hardlimit_touch_avx2;
#endif
    return hardlimit_touch_base;
}

}  // namespace hardlimit::bindings
