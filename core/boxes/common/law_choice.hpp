// Choice of the contact law at run time.
#pragma once
#include "../../contact/registry.hpp"

namespace hardlimit::boxes {

struct LawChoice {
    int law = -1;         // index in the registry of laws; −1: none
    int alternative = 0;  // index of the parameter set
    double parameters[max_parameters] = {};

    explicit operator bool() const { return law >= 0; }
};

// Returns visit.operator()<Law>() for the law at this index of the registry, or Result{} if there is none.
template <class Result, class Visit>
Result with_law(int place, const Visit& visit) {
#define HL_VISIT(Law) \
    if (place-- == 0) return visit.template operator()<contact::Law>();
    HARDLIMIT_LAWS(HL_VISIT)
#undef HL_VISIT
    return Result{};
}

// The law of one pair.
template <class Law>
Law make_law(const LawChoice& choice, PairGeometry pair) {
    return Law::from_parameters(choice.alternative, choice.parameters, pair);
}

}  // namespace hardlimit::boxes
