// Table entries of the particle engines, each compiled in its own file, and choice of the kernels for this processor.
#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "boxes/common/engine.hpp"
#include "boxes/hard_spheres/rules/rule.hpp"
#include "boxes/kernels/interface.hpp"

extern const hardlimit_abi::TouchKernels hardlimit_touch_base, hardlimit_touch_avx2, hardlimit_touch_avx512;

namespace hardlimit::bindings {

// Arguments of an engine in addition to the system.
struct EngineArguments {
    boxes::RuleChoice rule;  // contains the contact law; engines other than hard_spheres use only that
    double time_step = 0.0;  // for newton_steps [s]
    bool log = false;
};

struct EngineRecord {
    const char* name;
    std::unique_ptr<boxes::Engine> (*make)(const boxes::System&, const EngineArguments&, Stop&);
    std::unique_ptr<boxes::Engine> (*load)(const char* data,
                                           std::size_t n);  // nullptr if the data are damaged
};
// Random positions without overlap; empty if there was not enough space. report(fraction of the final radii,
// collisions) returns whether to continue.
std::optional<std::vector<double>> grow_packing(const boxes::System& s, u64 seed, Stop& stop,
                                                const std::function<bool(double, u64)>& report);

extern const EngineRecord hard_spheres_engine, newton_events_engine, newton_steps_engine;

// Kernels for the widest registers of the processor. All give identical results.
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
