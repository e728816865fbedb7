// Creates or loads the hard-sphere engine for the dimension, gravity, and equal or different particles of a system.
#pragma once
#include <memory>

#include "engine.hpp"

namespace hardlimit::boxes {

// Returns f<d, motion, mixed>() for the kind, or nullptr if there is none.
template <class F>
std::unique_ptr<Engine> with_kind(const Kind& kind, const F& f) {
#define HL_KIND(d, motion_, mixed_)                                                    \
    if (kind.dimension == d && kind.motion == Motion::motion_ && kind.mixed == mixed_) \
        return f.template operator()<d, Motion::motion_, mixed_>();
    HL_KIND(2, straight, false)
    HL_KIND(2, straight, true)
    HL_KIND(2, falling, false)
    HL_KIND(2, falling, true)
    HL_KIND(3, straight, false)
    HL_KIND(3, straight, true)
    HL_KIND(3, falling, false)
    HL_KIND(3, falling, true)
#undef HL_KIND
    return nullptr;
}

inline Kind kind_of(const System& s) {
    Kind kind{s.box.dimension, s.box.falls() ? Motion::falling : Motion::straight, false};
    for (std::size_t i = 1; i < s.n; ++i)
        kind.mixed = kind.mixed || s.radius[i] != s.radius[0] || s.mass[i] != s.mass[0];
    return kind;
}

// fault_of(s) must find no fault.
inline std::unique_ptr<Engine> make_hard_spheres(const System& s, const RuleChoice& rule, bool keep_log,
                                                 const hardlimit_abi::TouchKernels& kernels, Stop& stop) {
    return with_kind(kind_of(s), [&]<int d, Motion motion, bool mixed>() -> std::unique_ptr<Engine> {
        return std::make_unique<HardSpheres<d, motion, mixed>>(s, rule, keep_log, kernels, stop);
    });
}

// Returns nullptr if the bytes are not a complete checkpoint of this engine.
inline std::unique_ptr<Engine> load_hard_spheres(const char* data, std::size_t n,
                                                 const hardlimit_abi::TouchKernels& kernels) {
    Reader reader(data, n);
    if (!reader.whole("hard_spheres")) return nullptr;
    Kind kind{};
    reader(kind);
    auto engine = with_kind(kind, [&]<int d, Motion motion, bool mixed>() -> std::unique_ptr<Engine> {
        return std::make_unique<HardSpheres<d, motion, mixed>>(reader, kernels);
    });
    return reader.failed() ? nullptr : std::move(engine);
}

}  // namespace hardlimit::boxes
