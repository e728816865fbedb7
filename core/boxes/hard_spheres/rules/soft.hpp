// Collision rule "soft": a contact takes time and turns the line of centres according to the contact law (P. Müller and
// T. Pöschel, Phys. Rev. E 87, 033301 (2013)).
#pragma once
#include "../../binary_contact/tabulated_contact.hpp"
#include "rule.hpp"

namespace hardlimit::boxes::rules {

class Soft {
public:
    static constexpr RuleRecord record = {
        .name = "soft",
        .meaning = "takes the time of a contact and turns the normal, as the law says",
        .assumes = "no third body touches meanwhile",
        .source = "Müller & Pöschel, Phys. Rev. E 87, 033301 (2013)",
        .takes_law = true,
        .knows_duration = true,
        .error = "soft",
        .n_counts = 3,
        .counts = {"n_soft", "n_soft_third_body", "third_body_share"},
        .share = "with a third body in reach"};
    static std::unique_ptr<Rule> make(const RuleChoice& choice, const TypicalParticle& typical) {
        return with_contact_law<std::unique_ptr<Rule>>(choice.law, [&]<class Law>() -> std::unique_ptr<Rule> {
            return std::make_unique<Of<Law>>(choice.law, typical);
        });
    }

private:
    // Uses a table made for the typical pair.
    template <class Law>
    class Of final : public Rule {
    public:
        Of(const LawChoice& choice, const TypicalParticle& typical)
            : choice_(choice),
              usual_(typical.pair()),
              law_(make_law<Law>(choice, usual_)),
              alike_(typical.alike),
              contacts_(law_, usual_.effective_mass, 2.0 * typical.radius, !alike_) {}

        bool takes_time() const override { return true; }
        SoftContact contact(const Impact& impact, DeepestImpact& deepest) override {
            const PairGeometry pair = impact.pair;
            const bool usual = alike_ && pair.effective_mass == usual_.effective_mass &&
                               pair.effective_radius == usual_.effective_radius;
            const Law law = usual ? law_ : make_law<Law>(choice_, pair);
            note_impact(deepest, law, impact.approach, impact.smaller_radius);
            if (deepest.too_deep) return {Outcome::too_deep};
            const PlanarContact end = contacts_(law, impact.approach);
            return {end.outcome, equivalent_collision(impact.approach, end), end.duration};
        }

    private:
        LawChoice choice_;
        PairGeometry usual_;
        Law law_;
        bool alike_;
        TabulatedContacts<Law> contacts_;
    };

    // Solves each contact.
    template <FrictionalLaw Law>
    class Of<Law> final : public Rule {
    public:
        using Normal = typename Law::Frictionless;
        Of(const LawChoice& choice, const TypicalParticle& typical)
            : choice_(choice), normal_(choice, typical) {}

        bool takes_time() const override { return true; }
        SoftContact contact(const Impact& impact, DeepestImpact& deepest) override {
            return normal_.contact(impact, deepest);
        }
        TurningContact turning_contact(const TurningApproach& touch, const Impact& impact,
                                       DeepestImpact& deepest) override {
            const Law law = make_law<Law>(choice_, impact.pair);
            note_impact(deepest, static_cast<const Normal&>(law), impact.approach, impact.smaller_radius);
            if (deepest.too_deep) return {.outcome = Outcome::too_deep};
            return solve_turning_contact(law, touch);
        }

    private:
        LawChoice choice_;
        Of<Normal> normal_;
    };
};

}  // namespace hardlimit::boxes::rules
