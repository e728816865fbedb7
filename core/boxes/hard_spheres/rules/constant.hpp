// Collision rule "constant": the same coefficient of restitution in all collisions.
#pragma once
#include "rule.hpp"

namespace hardlimit::boxes::rules {

class Constant final : public Rule {
public:
    static constexpr RuleRecord record = {.name = "constant",
                                          .meaning = "restitution ε",
                                          .assumes = "ε depends on nothing",
                                          .takes_restitution = true,
                                          .error = "constant"};
    static std::unique_ptr<Rule> make(const RuleChoice& choice, const TypicalParticle&) {
        return std::make_unique<Constant>(choice.restitution);
    }

    explicit Constant(double restitution) : restitution_(restitution) {}
    Rebound rebound(const Impact&, DeepestImpact&) override { return {restitution_}; }
    bool can_collapse() const override { return restitution_ != 1.0; }

private:
    double restitution_;
};

}  // namespace hardlimit::boxes::rules
