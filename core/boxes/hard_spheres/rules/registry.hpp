// Registry of the collision rules. A new rule is one header and one line here: it then appears in Python and in the
// documentation. Checkpoints hold the index of a rule, so that a new one goes to the end.
//
// One source file of a program includes this header, since it defines a function that is not inline: every rule is
// compiled for every law, which takes time.
#pragma once
#include <iterator>

#include "constant.hpp"
#include "restitution_of_law.hpp"
#include "soft.hpp"
#include "tc.hpp"

#define HARDLIMIT_RULES(X) \
    X(Constant)            \
    X(Tc)                  \
    X(RestitutionOfLaw)    \
    X(Soft)

namespace hardlimit::boxes {

std::unique_ptr<Rule> make_rule(const RuleChoice& choice, const TypicalParticle& typical) {
    int place = choice.rule;
#define HL_MAKE_RULE(Name) \
    if (place-- == 0) return rules::Name::make(choice, typical);
    HARDLIMIT_RULES(HL_MAKE_RULE)
#undef HL_MAKE_RULE
    return nullptr;
}

inline constexpr RuleRecord rule_records[] = {
#define HL_RULE_RECORD(Name) rules::Name::record,
    HARDLIMIT_RULES(HL_RULE_RECORD)
#undef HL_RULE_RECORD
};
inline constexpr int rule_count = static_cast<int>(std::size(rule_records));

}  // namespace hardlimit::boxes
