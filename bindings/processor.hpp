// The kernels compiled for each instruction set, and the set that is used. All give identical results.
#pragma once
#include <cstdlib>
#include <string>

#include "arrays.hpp"
#include "boxes/kernels/interface.hpp"
#include "sweep/kernel_abi.hpp"

extern const hardlimit_abi::Kernel hardlimit_kernel_base, hardlimit_kernel_avx2, hardlimit_kernel_avx512;
extern const hardlimit_abi::TouchKernels hardlimit_touch_base, hardlimit_touch_avx2, hardlimit_touch_avx512;

namespace hardlimit::bindings {

#if defined(HARDLIMIT_X86)
inline constexpr const hardlimit_abi::Kernel* sweep_kernels[] = {
    &hardlimit_kernel_base, &hardlimit_kernel_avx2, &hardlimit_kernel_avx512};
inline constexpr const hardlimit_abi::TouchKernels* touch_kernel_sets[] = {
    &hardlimit_touch_base, &hardlimit_touch_avx2, &hardlimit_touch_avx512};
#else
inline constexpr const hardlimit_abi::Kernel* sweep_kernels[] = {&hardlimit_kernel_base};
inline constexpr const hardlimit_abi::TouchKernels* touch_kernel_sets[] = {&hardlimit_touch_base};
#endif

// Index into these tables.
inline int widest_instruction_set() {
#if defined(HARDLIMIT_X86)
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw"))
        return 2;
    if (__builtin_cpu_supports("avx2")) return 1;
#endif
    return 0;
}
// The widest set, or that which the environment variable HARDLIMIT_LANES names, for tests and benchmarks.
inline int instruction_set() {
    const char* const name = std::getenv("HARDLIMIT_LANES");
    const int widest = widest_instruction_set();
    if (!name || !*name) return widest;
    std::string names;
    for (int set = 0; set <= widest; ++set) {
        if (std::string(name) == sweep_kernels[set]->name) return set;
        names += (set > 0 ? ", " : "") + std::string(sweep_kernels[set]->name);
    }
    throw value_error("HARDLIMIT_LANES: got " + std::string(name) + ", this processor has " + names);
}
inline const hardlimit_abi::TouchKernels& touch_kernels() { return *touch_kernel_sets[instruction_set()]; }

}  // namespace hardlimit::bindings
