// The engine for a system: dimension, gravity and whether all particles are alike are decided once.
#pragma once
#include <memory>

#include "engine.hpp"

namespace hardlimit::boxes {

// f<d, motion, mixed>() for the kind; nothing where there is none.
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

inline Kind kind_of(const Setting& s) {
    Kind kind{s.dimension, Motion::straight, false};
    for (int k = 0; k < s.dimension; ++k)
        if (s.gravity[k] != 0.0) kind.motion = Motion::falling;
    for (std::size_t i = 1; i < s.n; ++i)
        kind.mixed = kind.mixed || s.radius[i] != s.radius[0] || s.mass[i] != s.mass[0];
    return kind;
}

// Of a system that fault_of() has no objection to.
inline std::unique_ptr<Engine> make_engine(const Setting& s, const RuleChoice& rule, bool keep_log,
                                           Stop& stop) {
    return with_kind(kind_of(s), [&]<int d, Motion motion, bool mixed>() -> std::unique_ptr<Engine> {
        return std::make_unique<HardSpheres<d, motion, mixed>>(s, rule, keep_log, stop);
    });
}

// Nothing where the bytes are not a whole archive.
inline std::unique_ptr<Engine> load_engine(const char* data, std::size_t n,
                                           const hardlimit_abi::TouchKernels& kernels) {
    Reader reader(data, n);
    Kind kind{};
    if (!reader.whole()) return nullptr;
    reader(kind);
    auto engine = with_kind(kind, [&]<int d, Motion motion, bool mixed>() -> std::unique_ptr<Engine> {
        return std::make_unique<HardSpheres<d, motion, mixed>>(reader, kernels);
    });
    return reader.failed() ? nullptr : std::move(engine);
}

}  // namespace hardlimit::boxes
