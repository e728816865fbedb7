// Collision rule for test_recipes.py: restitution ε at impacts faster than a threshold, elastic at slower ones.
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
        return std::make_unique<Threshold>(choice.restitution);
    }

    explicit Threshold(double restitution) : restitution_(restitution) {}
    Rebound rebound(const Impact& impact, DeepestImpact&) override {
        return {impact.approach.normal_speed < 0.01 ? 1.0 : restitution_};
    }
    bool can_collapse() const override { return false; }

private:
    double restitution_;
};

}  // namespace hardlimit::boxes::rules
