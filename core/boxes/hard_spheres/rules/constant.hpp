// Collision rule "constant": the same coefficient of restitution in all collisions, and the same tangential one
// unless the surfaces slide (O. R. Walton, in Particulate Two-Phase Flow, ed. M. C. Roco, 884 (1993)): then the
// tangential impulse is μ times the normal one,
//   1 + β = min{1 + β0, (m/m_t) μ (1 + ε)/tan γ}.
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
        return std::make_unique<Constant>(choice);
    }

    explicit Constant(const RuleChoice& choice)
        : restitution_(choice.restitution),
          coefficient_(choice.friction),
          gain_(choice.has_friction() ? 1.0 + choice.tangential_restitution : 0.0) {}
    Rebound rebound(const Impact& c, DeepestImpact&) override {
        if (gain_ == 0.0) return {restitution_};
        const double limit =
            coefficient_ * (1.0 + c.rotational_ratio) * (1.0 + restitution_) * c.approach.normal_speed;
        const bool slides = limit < gain_ * c.slip_speed;
        return {restitution_, false, slides ? limit / c.slip_speed : gain_, slides};
    }
    bool can_collapse() const override { return restitution_ != 1.0 || gain_ != 0.0; }

private:
    double restitution_, coefficient_, gain_;  // ε, μ, 1 + β0
};

}  // namespace hardlimit::boxes::rules
