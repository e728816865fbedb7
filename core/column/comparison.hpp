// Compares independent collisions with Newton's equations for a column: do they agree to a tolerance, and if not, why.
//
// Two balls on a floor are compared by their separation velocity, relative to that of Newton's equations. All other
// columns are compared by the velocity of each ball after its last contact, relative to the impact speed (cradle: the
// largest difference of the velocities at release).
#pragma once
#include <numeric>

#include "effective_restitution.hpp"
#include "rebound.hpp"

namespace hardlimit::column {

enum class Answer { yes, by_luck, no, undecided };
inline constexpr const char* answer_names[] = {"yes", "by luck", "no", "undecided"};

// What the answer follows from.
enum class Ground {
    numbers,         // the difference of the velocities
    newton_unclear,  // the outcome of Newton's equations has no velocities
    independent_unclear,
    no_contact,      // the balls meet in neither model
    newton_at_rest,  // a contact never ends
    collapse,        // infinitely many collisions in a finite time
    independent_at_rest,
    only_newton_meets,
    only_independent_meets,
    newton_touches_again,  // the second floor contact begins before the balls separate
    independent_touches_again,
};
inline constexpr const char* ground_names[] = {
    "numbers",
    "newton_unclear",
    "independent_unclear",
    "no_contact",
    "newton_at_rest",
    "collapse",
    "independent_at_rest",
    "only_newton_meets",
    "only_independent_meets",
    "newton_touches_again",
    "independent_touches_again",
};

struct Comparison {
    Answer answer = Answer::undecided;
    Ground ground = Ground::numbers;
    int overlapping = 0;       // ball–ball contacts of the sequence that overlap another contact in time
    double error = math::nan;  // relative difference; NaN: a model has no such velocity
    double independent = math::nan, newton = math::nan;  // the velocities compared [m/s]
    int ball = -1;       // whose final velocity is compared; −1: the separation velocity
    bool later = false;  // contacts of the upper balls after the second floor contact count
};

namespace compare {

// Indices of the ball–ball contacts of the sequence.
inline std::vector<std::size_t> contacts_of_balls(const Solution& s) {
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < s.contacts.size(); ++i)
        if (s.contacts[i].pair > 0 && static_cast<int>(found.size()) < s.sequence.n_contacts)
            found.push_back(i);
    return found;
}

// In order of begin, a contact overlaps another one if the next one begins before its end, or an earlier one ends after
// its begin.
inline int overlapping(const Solution& s) {
    const auto end = [&](std::size_t i) {
        return math::is_nan(s.contacts[i].end) ? math::infinity : s.contacts[i].end;
    };
    std::vector<bool> counts(s.contacts.size(), false);
    for (const std::size_t i : contacts_of_balls(s)) counts[i] = true;
    std::vector<std::size_t> order(s.contacts.size());
    std::iota(order.begin(), order.end(), 0u);
    std::ranges::stable_sort(order, {}, [&](std::size_t i) { return s.contacts[i].begin; });
    int count = 0;
    double latest = -math::infinity;  // end of the contacts before
    for (std::size_t k = 0; k < order.size(); ++k) {
        const std::size_t i = order[k];
        const bool next = k + 1 < order.size() && s.contacts[order[k + 1]].begin < end(i);
        count += counts[i] && (next || latest > s.contacts[i].begin);
        latest = math::max(latest, end(i));
    }
    return count;
}

// Contacts of the sequence for each pair above the lowest ball.
inline std::vector<int> upper_contacts(const Solution& s, std::size_t balls) {
    std::vector<int> count(balls, 0);
    for (const std::size_t i : contacts_of_balls(s)) ++count[static_cast<std::size_t>(s.contacts[i].pair)];
    count.erase(count.begin(), count.begin() + std::min<std::ptrdiff_t>(2, std::ssize(count)));
    return count;
}

inline void set_error(Comparison& c, double scale) {
    const double apart = math::abs(c.independent - c.newton);
    c.error = c.independent == c.newton ? 0.0 : scale > 0.0 ? apart / scale : math::infinity;
}

// Compares the velocities of the ball that differs most, in the frame in free fall: a delay of the last contact does
// not count. `missing`: see parting().
template <class Law>
void compare_velocities(SharedColumn<Law> c, const SolveOptions& o, const Solution& newton,
                        const Solution& independent, const std::vector<int>& newton_missing,
                        const std::vector<int>& independent_missing, Comparison& found) {
    const Parting a = parting(c, Model::newton, o, newton, newton_missing);
    const Parting b = parting(c, Model::independent, o, independent, independent_missing);
    double greatest = -1.0, apart = math::nan;
    for (std::size_t j = 0; j < c->mass.size(); ++j) {
        double delay = b.since[j] - a.since[j];
        if (math::is_nan(delay)) delay = 0.0;
        const double difference = b.velocity[j] - a.velocity[j] - c->gravity * delay;
        const double size = math::is_nan(difference) ? math::infinity : math::abs(difference);
        if (size <= greatest) continue;
        greatest = size;
        apart = difference;
        found.ball = static_cast<int>(j);
    }
    found.newton = final_velocities(newton, c->balls)[static_cast<std::size_t>(found.ball)];
    found.independent = found.newton + apart;
    const auto [slowest, fastest] = std::minmax_element(c->velocity.begin(), c->velocity.end());
    set_error(found, c->floor ? impact_speed(c->gaps[0], c->velocity[0], c->gravity) : *fastest - *slowest);
}

template <class Law>
void compare_numbers(SharedColumn<Law> c, const SolveOptions& o, const Solution& newton,
                     const Solution& independent, double tolerance, Comparison& found) {
    if (c->balls == 2 && c->floor) {
        found.newton = newton.sequence.separation_velocity;
        found.independent = independent.sequence.separation_velocity;
        if (math::is_nan(found.newton))
            found.ground = Ground::newton_touches_again;
        else if (math::is_nan(found.independent))
            found.ground = Ground::independent_touches_again;
        else
            set_error(found, math::abs(found.newton));
        return;
    }
    compare_velocities(c, o, newton, independent, {}, {}, found);
    const std::vector<int> a = upper_contacts(newton, c->mass.size()),
                           b = upper_contacts(independent, c->mass.size());
    if (found.error <= tolerance || a == b) return;
    std::vector<int> a_missing(a.size()), b_missing(a.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
        a_missing[i] = std::max(b[i] - a[i], 0);
        b_missing[i] = std::max(a[i] - b[i], 0);
    }
    Comparison later = found;
    compare_velocities(c, o, newton, independent, a_missing, b_missing, later);
    later.later = true;
    if (later.error <= tolerance) found = later;
}

inline bool unclear(Outcome o) {
    return o == Outcome::invalid || o == Outcome::unresolved || o == Outcome::never_lands ||
           o == Outcome::too_deep;
}

// The answer that the outcomes give; Ground::numbers if both models reach the end of the sequence.
inline Ground ground_of(Outcome newton, Outcome independent, int balls) {
    if (unclear(newton)) return Ground::newton_unclear;
    if (unclear(independent)) return Ground::independent_unclear;
    if (balls > 1 && newton == Outcome::no_contact && independent == Outcome::no_contact)
        return Ground::no_contact;
    if (newton == Outcome::at_rest) return Ground::newton_at_rest;
    if (independent == Outcome::collapse) return Ground::collapse;
    if (independent == Outcome::at_rest) return Ground::independent_at_rest;
    return Ground::numbers;
}

}  // namespace compare

// `newton` and `independent` are the solutions of the column without `until`.
template <class Law>
Comparison compare_models(SharedColumn<Law> c, const SolveOptions& o, const Solution& newton,
                          const Solution& independent, double tolerance) {
    Comparison found;
    found.ground = compare::ground_of(newton.sequence.outcome, independent.sequence.outcome, c->balls);
    if (found.ground != Ground::numbers) {
        const bool known = found.ground > Ground::no_contact;
        found.answer = known ? Answer::no : Answer::undecided;
        return found;
    }
    compare::compare_numbers(c, o, newton, independent, tolerance, found);
    const bool agree = found.error <= tolerance;
    const int n = newton.sequence.n_contacts, m = independent.sequence.n_contacts;
    if (!agree && (n == 0) != (m == 0))
        found.ground = n > 0 ? Ground::only_newton_meets : Ground::only_independent_meets;
    found.overlapping = compare::overlapping(newton);
    found.answer = !agree ? Answer::no : found.overlapping > 0 ? Answer::by_luck : Answer::yes;
    return found;
}

}  // namespace hardlimit::column
