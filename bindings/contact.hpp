// The Python type of one contact under any registered law.
#pragma once
#include <variant>

#include "contact/registry.hpp"

namespace hardlimit::bindings {

// std::variant of Of<Law> over all registered laws.
template <template <class> class Of>
struct OfEachLaw {
    template <class First, class... Rest>
    using WithoutFirst = std::variant<Rest...>;
#define HL_COMMA_OF(name) , Of<contact::name>
    using Variant = WithoutFirst<void HARDLIMIT_LAWS(HL_COMMA_OF)>;
#undef HL_COMMA_OF
};

template <class Law>
using Itself = Law;

struct Contact {
    OfEachLaw<Itself>::Variant law;
    PairGeometry pair;
};

}  // namespace hardlimit::bindings
