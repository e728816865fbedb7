// Outcome codes. A failed case of a map is a value in the result, never an exception.
#pragma once
#include "portable.hpp"

namespace hardlimit {

enum class Outcome : int {
    ok = 0,
    no_contact = 1,
    at_rest = 2,
    invalid = 3,
    collapse = 4,
    unresolved = 5,
    never_lands = 6,
    too_deep = 7,
};
inline constexpr int outcome_count = 8;

struct OutcomeRecord {
    const char* name;
    const char* message;
};

inline constexpr OutcomeRecord outcome_records[outcome_count] = {
    {"ok", "ok"},
    {"no_contact", "no ball–ball contact before the floor is met again"},
    {"at_rest", "at rest: a contact never ends because gravity holds it closed"},
    {"invalid", "invalid parameters: outside the range of the model"},
    {"collapse",
     "inelastic collapse: the collisions of the independent-collisions model accumulate in a finite time"},
    {"unresolved", "not resolved: the limit on the number of steps or events was reached"},
    {"never_lands", "the lowest ball never reaches the floor"},
    {"too_deep",
     "too deep: a contact was compressed by half of the smaller radius, beyond the range of any contact law"},
};

HL_FN const char* message(Outcome o) { return outcome_records[static_cast<int>(o)].message; }

}  // namespace hardlimit
