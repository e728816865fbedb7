// What a collision does: the coefficient of restitution that a rule gives it.
//
//   constant  the same ε always
//   law       ε(v) of the contact law, for the two bodies that meet
//   tc        elastic where either partner collided, with anything, less than t_c ago, else as the two above
//             (Luding & McNamara, Granular Matter 1, 113 (1998))
//   soft      see rules/soft.hpp
#pragma once
#include <memory>
#include <vector>

#include "../../../contact/registry.hpp"
#include "../../binary_contact/deepest_impact.hpp"
#include "../../common/particle.hpp"

namespace hardlimit::boxes {

// ε of one contact as a function of speed, from polynomials between the few speeds for which the law is asked. An
// octave of speeds is cut into eight; with nine nodes on each piece the error is rounding, 1e-15 for a smooth ε(v).
template <class Law>
class TabledRestitution {
public:
    TabledRestitution(const Law& law, double mass) : law_(law), mass_(mass), pieces_(octaves * per_octave) {}

    const Law& law() const { return law_; }

    double operator()(double speed) {
        const u64 bits = bits_of<double>(speed);
        const u64 piece = (bits >> 49) - (static_cast<u64>(1023 - octaves / 2) << 3);
        if (!(speed > 0.0) || piece >= pieces_.size()) return law_.restitution(speed, mass_);
        Piece& p = pieces_[piece];
        // From −1 to 1 on the piece: the bits below the three that choose it.
        const double x =
            real_of<double>((bits & 0x0001ffffffffffffULL) << 3 | 0x3ff0000000000000ULL) * 2.0 - 3.0;
        if (!p.known) fill(p, real_of<double>((bits >> 49) << 49));
        double sum = p.c[nodes - 1];
        for (int k = nodes - 2; k >= 0; --k) sum = sum * x + p.c[k];
        return sum;
    }

private:
    static constexpr int octaves = 200, per_octave = 8, nodes = 9;
    struct Piece {
        double c[nodes];
        bool known = false;
    };
    Law law_;
    double mass_;
    std::vector<Piece> pieces_;

    // Newton's divided differences at Chebyshev's nodes, multiplied out.
    void fill(Piece& p, double low) {
        const double high = real_of<double>(bits_of<double>(low) + (1ULL << 49));
        double x[nodes], f[nodes];
        for (int k = 0; k < nodes; ++k) {
            x[k] = math::cos(math::pi * (k + 0.5) / nodes);
            f[k] = law_.restitution(0.5 * ((high + low) + (high - low) * x[k]), mass_);
        }
        for (int j = 1; j < nodes; ++j)
            for (int k = nodes - 1; k >= j; --k) f[k] = (f[k] - f[k - 1]) / (x[k] - x[k - j]);
        for (double& c : p.c) c = 0.0;
        for (int k = nodes - 1; k >= 0; --k) {
            for (int j = nodes - 1; j > 0; --j) p.c[j] = p.c[j - 1] - x[k] * p.c[j];
            p.c[0] = f[k] - x[k] * p.c[0];
        }
        p.known = true;
    }
};

// ε(v) under a law that the engine does not know. `radius`: the smaller one, for the deepest impact [m].
class LawRestitution {
public:
    virtual ~LawRestitution() = default;
    virtual double operator()(double speed, PairGeometry pair, double radius, DeepestImpact& deepest) = 0;
};

// How Python and files choose a rule.
struct RuleChoice {
    double restitution = 1.0;        // without a law
    double contact_duration = -1.0;  // t_c [s]; negative: the rule is not tc
    int law = -1;                    // place in the registry; −1: none
    bool soft = false;               // the rule is soft: with a law
    int alternative = 0;             // which set of parameters
    double parameters[max_parameters] = {};
};

// The same for each pair that meets, where particles differ; from tables for the pairs stated, where all are alike.
template <class Law>
class RestitutionOf final : public LawRestitution {
public:
    RestitutionOf(const RuleChoice& choice, const std::vector<PairGeometry>& alike) : choice_(choice) {
        for (const PairGeometry& pair : alike)
            known_.push_back({pair, TabledRestitution<Law>(law_of(pair), pair.effective_mass)});
    }

    double operator()(double speed, PairGeometry pair, double radius, DeepestImpact& deepest) override {
        const Approach head_on{pair.effective_mass, math::infinity, speed};
        for (Known& k : known_)
            if (k.pair.effective_mass == pair.effective_mass &&
                k.pair.effective_radius == pair.effective_radius) {
                note_impact(deepest, k.restitution.law(), head_on, radius);
                return k.restitution(speed);
            }
        const Law law = law_of(pair);
        note_impact(deepest, law, head_on, radius);
        return law.restitution(speed, pair.effective_mass);
    }

private:
    struct Known {
        PairGeometry pair;
        TabledRestitution<Law> restitution;
    };
    RuleChoice choice_;
    std::vector<Known> known_;

    Law law_of(PairGeometry pair) const {
        return Law::from_parameters(choice_.alternative, choice_.parameters, pair);
    }
};

inline std::unique_ptr<LawRestitution> law_restitution(const RuleChoice& choice,
                                                       const std::vector<PairGeometry>& alike) {
    int place = choice.law;
#define HL_RESTITUTION_OF(Law) \
    if (place-- == 0) return std::make_unique<RestitutionOf<contact::Law>>(choice, alike);
    HARDLIMIT_LAWS(HL_RESTITUTION_OF)
#undef HL_RESTITUTION_OF
    return nullptr;
}

class Rule {
public:
    explicit Rule(const RuleChoice& choice = {}, const std::vector<PairGeometry>& alike = {})
        : choice_(choice), law_(law_restitution(choice, alike)) {}

    const RuleChoice& choice() const { return choice_; }
    bool elastic_always() const { return !law_ && choice_.restitution == 1.0; }
    bool is_tc() const { return choice_.contact_duration >= 0.0; }
    double contact_duration() const { return choice_.contact_duration; }
    double restitution(double speed, PairGeometry pair, double radius, DeepestImpact& deepest) const {
        return law_ ? (*law_)(speed, pair, radius, deepest) : choice_.restitution;
    }

private:
    RuleChoice choice_;
    std::unique_ptr<LawRestitution> law_;
};

}  // namespace hardlimit::boxes
