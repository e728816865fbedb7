// Collision rule "tc": elastic if either partner has had any collision less than t_c ago (S. Luding and S. McNamara,
// Granular Matter 1, 113 (1998)).
#pragma once
#include "constant.hpp"
#include "restitution_of_law.hpp"

namespace hardlimit::boxes::rules {

class Tc final : public Rule {
public:
    static constexpr RuleRecord record = {
        .name = "tc",
        .meaning =
            "elastic and without friction where a partner has collided less than t_c ago, with anything; else as "
            "constant or law",
        .assumes = "contacts of many particles lose little energy",
        .source = "Luding & McNamara, Granular Matter 1, 113 (1998)",
        .takes_restitution = true,
        .takes_law = true,
        .knows_duration = true,
        .error = "tc",
        .n_counts = 2,
        .counts = {"n_elastic_by_tc", "elastic_share"},
        .share = "made elastic by tc",
        .n_parameters = 1,
        .parameters = {{"contact_duration", "s", "t_c, within which a second collision is elastic"}}};
    static std::unique_ptr<Rule> make(const RuleChoice& choice, const TypicalParticle& typical) {
        return std::make_unique<Tc>(choice.parameters[0], choice.law ? RestitutionOfLaw::make(choice, typical)
                                                                     : Constant::make(choice, typical));
    }

    Tc(double contact_duration, std::unique_ptr<Rule> otherwise)
        : contact_duration_(contact_duration), otherwise_(std::move(otherwise)) {}
    Rebound rebound(const Impact& impact, DeepestImpact& deepest) override {
        if (impact.since_last < contact_duration_) return {1.0, true};
        return otherwise_->rebound(impact, deepest);
    }
    bool can_collapse() const override { return false; }

private:
    double contact_duration_;  // t_c [s]
    std::unique_ptr<Rule> otherwise_;
};

}  // namespace hardlimit::boxes::rules
