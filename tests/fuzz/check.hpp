// Assertion and choice of a random law for the fuzz targets.
#pragma once
#include <cstdio>
#include <cstdlib>

#include "contact/registry.hpp"
#include "draw.hpp"

namespace hardlimit::fuzz {

// Aborts if the condition does not hold; the fuzzer then keeps the input.
inline void require(bool holds, const char* what) {
    if (holds) return;
    std::fprintf(stderr, "does not hold: %s\n", what);
    std::abort();
}

// Calls f<Law>() for a randomly drawn registered law.
template <class Source, class F>
void with_some_law(Draw<Source>& draw, const F& f) {
    int count = 0;
#define HL_COUNT(Law) ++count;
    HARDLIMIT_LAWS(HL_COUNT)
#undef HL_COUNT
    int place = draw.below(count);
#define HL_CALL(Law) \
    if (place-- == 0) return f.template operator()<contact::Law>();
    HARDLIMIT_LAWS(HL_CALL)
#undef HL_CALL
}

}  // namespace hardlimit::fuzz
