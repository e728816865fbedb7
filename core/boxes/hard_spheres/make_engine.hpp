// Creates or loads the hard-sphere engine for the dimension, and equal or different particles of a system.
#pragma once
#include <memory>

#include "engine.hpp"

namespace hardlimit::boxes {

// Returns f<d, mixed>() for the kind, or nullptr if there is none.
template <class F>
std::unique_ptr<Engine> with_kind(const Kind& kind, const F& f) {
    if (kind.dimension == 2)
        return kind.mixed ? f.template operator()<2, true>() : f.template operator()<2, false>();
    if (kind.dimension == 3)
        return kind.mixed ? f.template operator()<3, true>() : f.template operator()<3, false>();
    return nullptr;
}

inline Kind kind_of(const System& s) {
    Kind kind{s.box.dimension, false};
    for (std::size_t i = 1; i < s.n; ++i)
        kind.mixed = kind.mixed || s.radius[i] != s.radius[0] || s.mass[i] != s.mass[0];
    return kind;
}

// fault_of(s) must find no fault.
inline std::unique_ptr<Engine> make_hard_spheres(const System& s, const RuleChoice& rule, bool keep_log,
                                                 const hardlimit_abi::TouchKernels& kernels, Stop& stop) {
    return with_kind(kind_of(s), [&]<int d, bool mixed>() -> std::unique_ptr<Engine> {
        return std::make_unique<HardSpheres<d, mixed>>(s, rule, keep_log, kernels, stop);
    });
}

// Returns nullptr if the bytes are not a complete checkpoint of this engine.
inline std::unique_ptr<Engine> load_hard_spheres(const char* data, std::size_t n,
                                                 const hardlimit_abi::TouchKernels& kernels) {
    Reader reader(data, n);
    if (!reader.whole("hard_spheres")) return nullptr;
    Kind kind{};
    reader(kind);
    auto engine = with_kind(kind, [&]<int d, bool mixed>() -> std::unique_ptr<Engine> {
        return std::make_unique<HardSpheres<d, mixed>>(reader, kernels);
    });
    return reader.failed() ? nullptr : std::move(engine);
}

}  // namespace hardlimit::boxes
