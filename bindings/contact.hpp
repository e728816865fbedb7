// The Python type of one contact under any registered law, and the laws by name.
#pragma once
#include <string>
#include <variant>

#include "arrays.hpp"
#include "boxes/common/law_choice.hpp"
#include "contact/friction.hpp"

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
    FrictionTerms friction{};
};

#define HL_RECORD(Law) &contact::Law::record,
inline constexpr const LawRecord* law_records[] = {HARDLIMIT_LAWS(HL_RECORD)};
#undef HL_RECORD

inline int law_index(const std::string& name) {
    for (int i = 0; i < static_cast<int>(std::size(law_records)); ++i)
        if (name == law_records[i]->name) return i;
    throw value_error("law: got " + name + ", must be a registered law");
}
inline void require_alternative(const LawRecord& law, int alternative) {
    require(alternative >= 0 && alternative < law.n_alternatives,
            "alternative: got " + std::to_string(alternative) + ", must be a set of parameters of the law");
}
// Checks a law given by name, parameter set and parameters.
inline boxes::LawChoice law_choice(const std::string& name, int alternative,
                                   const std::vector<double>& parameters) {
    boxes::LawChoice choice{law_index(name), alternative, {}};
    const LawRecord& law = *law_records[choice.law];
    require_alternative(law, alternative);
    const int wanted = law.n_common + law.n_in_alternative[alternative];
    require_values("parameters", parameters.size(), static_cast<std::size_t>(wanted), "those of the law");
    std::copy(parameters.begin(), parameters.end(), choice.parameters);
    return choice;
}

}  // namespace hardlimit::bindings
