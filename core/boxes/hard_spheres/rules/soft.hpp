// The soft rule for any law: what a contact that takes time does to two bodies, or to a body and a wall.
#pragma once
#include <memory>

#include "../../../contact/registry.hpp"
#include "../../binary_contact/equivalent_collision.hpp"
#include "../../binary_contact/tabulated_contact.hpp"
#include "rules.hpp"

namespace hardlimit::boxes {

struct SoftImpact {
    Outcome outcome;
    DrawnBack drawn_back;
    double duration;  // [s]
};

class SoftRule {
public:
    virtual ~SoftRule() = default;
    // `radius`: the smaller one, for the deepest impact [m].
    virtual SoftImpact operator()(const Approach& approach, PairGeometry pair, double radius,
                                  DeepestImpact& deepest) = 0;
};

template <class Law>
class SoftRuleOf final : public SoftRule {
public:
    // The usual pair, at the distance of its touch; `alike`: there is no other kind.
    SoftRuleOf(const RuleChoice& choice, PairGeometry usual, double distance, bool alike)
        : choice_(choice),
          usual_(usual),
          law_(law_of(usual)),
          alike_(alike),
          contacts_(law_, usual.effective_mass, distance, !alike) {}

    SoftImpact operator()(const Approach& approach, PairGeometry pair, double radius,
                          DeepestImpact& deepest) override {
        const bool usual = alike_ && pair.effective_mass == usual_.effective_mass &&
                           pair.effective_radius == usual_.effective_radius;
        const Law law = usual ? law_ : law_of(pair);
        note_impact(deepest, law, approach, radius);
        if (deepest.too_deep) return {Outcome::too_deep, {}, 0.0};
        const PlanarContact end = contacts_(law, approach);
        return {end.outcome, draw_back(approach, end), end.duration};
    }

private:
    RuleChoice choice_;
    PairGeometry usual_;
    Law law_;
    bool alike_;
    SoftContacts<Law> contacts_;

    Law law_of(PairGeometry pair) const {
        return Law::from_parameters(choice_.alternative, choice_.parameters, pair);
    }
};

inline std::unique_ptr<SoftRule> soft_rule(const RuleChoice& choice, PairGeometry usual, double distance,
                                           bool alike) {
    int place = choice.law;
#define HL_SOFT_RULE_OF(Law) \
    if (place-- == 0) return std::make_unique<SoftRuleOf<contact::Law>>(choice, usual, distance, alike);
    HARDLIMIT_LAWS(HL_SOFT_RULE_OF)
#undef HL_SOFT_RULE_OF
    return nullptr;
}

}  // namespace hardlimit::boxes
