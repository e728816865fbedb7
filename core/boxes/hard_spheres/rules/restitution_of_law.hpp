// Collision rule "law": the coefficient of restitution ε(v) of the contact law for the colliding pair, with friction
// also β of its contact with a fixed normal (T. Schwager, V. Becker & T. Pöschel, Eur. Phys. J. E 27, 107 (2008)).
#pragma once
#include <array>
#include <map>
#include <vector>

#include "../../binary_contact/restitution_table.hpp"
#include "../../binary_contact/tangential_surface.hpp"
#include "rule.hpp"

namespace hardlimit::boxes::rules {

class RestitutionOfLaw {
public:
    static constexpr RuleRecord record = {.name = "law",
                                          .meaning = "ε(v) of `law.between(i, j)`, with friction also β",
                                          .assumes = "contacts take no time",
                                          .takes_law = true,
                                          .error = "constant"};
    static std::unique_ptr<Rule> make(const RuleChoice& choice, const TypicalParticle& typical) {
        return with_contact_law<std::unique_ptr<Rule>>(choice.law, [&]<class Law>() -> std::unique_ptr<Rule> {
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

    // Tables of β, of each pair of kinds if they are few.
    template <FrictionalLaw Law>
    class Of<Law> final : public Rule {
    public:
        using Normal = typename Law::Frictionless;
        Of(const LawChoice& choice, const TypicalParticle& typical)
            : choice_(choice), kinds_(typical.kinds), normal_(choice, typical) {}

        Rebound rebound(const Impact& impact, DeepestImpact& deepest) override {
            Rebound r = normal_.rebound(impact, deepest);
            const TangentialResult t = tangential(impact);
            r.tangential_gain = t.gain, r.slid = t.slid;
            return r;
        }

    private:
        using Key = std::array<double, 3>;
        LawChoice choice_;
        Kinds kinds_;
        Of<Normal> normal_;
        std::map<Key, TangentialTable> tables_;
        Key last_{};
        TangentialTable* table_ = nullptr;  // of last_
        TangentialSurfaces surfaces_;

        TangentialResult tangential(const Impact& c) {
            const double speed = c.approach.normal_speed;
            if (kinds_ != Kinds::few) {
                const contact::FrictionalContact contact = contact_of(c);
                if (kinds_ == Kinds::many || !ContactFamily::is_proportional(contact))
                    return solve_tangential(contact, speed, c.slip_speed);
                return surfaces_(contact, c.pair, c.rotational_ratio, speed, c.slip_speed, c.collisions);
            }
            TangentialTable& known = table(c);
            if (known.is_tabulated()) return known(speed, c.slip_speed);
            return surfaces_(known.contact(), c.pair, c.rotational_ratio, speed, c.slip_speed, c.collisions);
        }
        TangentialTable& table(const Impact& c) {
            const Key key{c.pair.effective_mass, c.pair.effective_radius, c.rotational_ratio};
            if (table_ && key == last_) return *table_;
            auto place = tables_.find(key);
            if (place == tables_.end()) place = tables_.emplace(key, TangentialTable(contact_of(c))).first;
            last_ = key, table_ = &place->second;
            return *table_;
        }
        contact::FrictionalContact contact_of(const Impact& c) const {
            const Law law = make_law<Law>(choice_, c.pair);
            const double mass = c.pair.effective_mass, tangential = mass / (1.0 + c.rotational_ratio);
            return {Law::record.powers, law.coefficients(), mass, tangential, law.friction};
        }
    };
};

}  // namespace hardlimit::boxes::rules
