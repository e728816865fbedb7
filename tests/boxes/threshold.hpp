// Collision rules for test_recipes.py: restitution ε at impacts faster than a threshold, elastic at slower ones.
#pragma once
#include "rule.hpp"

namespace hardlimit::boxes::rules {

class Threshold final : public Rule {
public:
    static constexpr RuleRecord record = {.name = "threshold",
                                          .meaning = "restitution ε, elastic at impacts below 10 mm/s",
                                          .assumes = "slow impacts lose nothing",
                                          .takes_restitution = true};
    static std::unique_ptr<Rule> make(const RuleChoice& choice, const TypicalParticle&) {
        return std::make_unique<Threshold>(choice.restitution, 0.01);
    }

    Threshold(double restitution, double speed) : restitution_(restitution), speed_(speed) {}
    Rebound rebound(const Impact& impact, DeepestImpact&) override {
        return {impact.approach.normal_speed < speed_ ? 1.0 : restitution_};
    }
    bool can_collapse() const override { return false; }

private:
    double restitution_, speed_;
};

class AdjustableThreshold final {
public:
    static constexpr RuleRecord record = {
        .name = "adjustable",
        .meaning = "restitution ε, elastic at impacts below the threshold speed",
        .assumes = "slow impacts lose nothing",
        .takes_restitution = true,
        .n_parameters = 1,
        .parameters = {{"threshold_speed", "m/s", "normal speed below which a collision is elastic"}}};
    static std::unique_ptr<Rule> make(const RuleChoice& choice, const TypicalParticle&) {
        return std::make_unique<Threshold>(choice.restitution, choice.parameters[0]);
    }
};

}  // namespace hardlimit::boxes::rules
