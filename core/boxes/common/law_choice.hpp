// Choice of the contact law at run time.
#pragma once
#include "../../contact/friction.hpp"
#include "../../contact/registry.hpp"

namespace hardlimit::boxes {

// A module of smooth particles defines HARDLIMIT_SMOOTH, and is smaller.
#ifdef HARDLIMIT_SMOOTH
inline constexpr bool particles_rub = false;
#else
inline constexpr bool particles_rub = true;
#endif

struct LawChoice {
    int law = -1;         // index in the registry of laws; −1: none
    int alternative = 0;  // index of the parameter set
    double parameters[max_parameters] = {};
    Friction friction{};  // of all contacts; none if its coefficient is 0

    bool has_friction() const { return particles_rub && friction.coefficient > 0.0; }
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

// The same for the chosen law, WithFriction<Law> if there is friction.
template <class Result, class Visit>
Result with_contact_law(const LawChoice& choice, const Visit& visit) {
    return with_law<Result>(choice.law, [&]<class Law>() -> Result {
        if constexpr (particles_rub)
            if (choice.has_friction()) return visit.template operator()<WithFriction<Law>>();
        return visit.template operator()<Law>();
    });
}

// The law of one pair.
template <class Law>
Law make_law(const LawChoice& choice, PairGeometry pair) {
    if constexpr (FrictionalLaw<Law>) {
        const auto normal = make_law<typename Law::Frictionless>(choice, pair);
        return {{normal}, friction_terms(choice.friction, Law::record.powers, normal.coefficients())};
    } else {
        return Law::from_parameters(choice.alternative, choice.parameters, pair);
    }
}

}  // namespace hardlimit::boxes
