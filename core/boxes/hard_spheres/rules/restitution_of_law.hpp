// Collision rule "law": the coefficient of restitution ε(v) of the contact law for the colliding pair.
#pragma once
#include <vector>

#include "../../binary_contact/restitution_table.hpp"
#include "rule.hpp"

namespace hardlimit::boxes::rules {

class RestitutionOfLaw {
public:
    static constexpr RuleRecord record = {.name = "law",
                                          .meaning = "ε(v) of `law.between(i, j)`",
                                          .assumes = "contacts take no time",
                                          .takes_law = true,
                                          .error = "constant"};
    static std::unique_ptr<Rule> make(const RuleChoice& choice, const TypicalParticle& typical) {
        return with_law<std::unique_ptr<Rule>>(choice.law.law, [&]<class Law>() -> std::unique_ptr<Rule> {
            return std::make_unique<Of<Law>>(choice.law, typical);
        });
    }

private:
    // Uses tables if all particles are alike; otherwise evaluates the law.
    template <class Law>
    class Of final : public Rule {
    public:
        Of(const LawChoice& choice, const TypicalParticle& typical) : choice_(choice) {
            if (!typical.alike) return;
            for (const PairGeometry pair : {typical.pair(), typical.at_wall()})
                known_.push_back({pair, {make_law<Law>(choice_, pair), pair.effective_mass}});
        }

        Rebound rebound(const Impact& impact, DeepestImpact& deepest) override {
            const PairGeometry pair = impact.pair;
            const double speed = impact.approach.normal_speed;
            const Approach head_on{pair.effective_mass, math::infinity, speed};
            for (Known& k : known_)
                if (k.pair.effective_mass == pair.effective_mass &&
                    k.pair.effective_radius == pair.effective_radius) {
                    note_impact(deepest, k.restitution.law(), head_on, impact.smaller_radius);
                    return {k.restitution(speed)};
                }
            const Law law = make_law<Law>(choice_, pair);
            note_impact(deepest, law, head_on, impact.smaller_radius);
            return {law.restitution(speed, pair.effective_mass)};
        }

    private:
        struct Known {
            PairGeometry pair;
            RestitutionTable<Law> restitution;
        };
        LawChoice choice_;
        std::vector<Known> known_;
    };
};

}  // namespace hardlimit::boxes::rules
