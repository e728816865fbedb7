// Which contact law a run has, chosen while it runs.
#pragma once
#include "../../contact/registry.hpp"

namespace hardlimit::boxes {

struct LawChoice {
    int law = -1;         // place in the registry of laws; −1: none
    int alternative = 0;  // which set of parameters
    double parameters[max_parameters] = {};

    explicit operator bool() const { return law >= 0; }
};

// visit.operator()<Law>() for the law at this place in the registry; a default value where there is none.
template <class Result, class Visit>
Result with_law(int place, const Visit& visit) {
#define HL_VISIT(Law) \
    if (place-- == 0) return visit.template operator()<contact::Law>();
    HARDLIMIT_LAWS(HL_VISIT)
#undef HL_VISIT
    return Result{};
}

// The law of one contact.
template <class Law>
Law make_law(const LawChoice& choice, PairGeometry pair) {
    return Law::from_parameters(choice.alternative, choice.parameters, pair);
}

}  // namespace hardlimit::boxes
