// Common interface to the results of all column solvers: the sequence, its contacts and the state at any time.
#pragma once
#include <vector>

#include "../base/stop.hpp"
#include "energies.hpp"
#include "sequence.hpp"

namespace hardlimit::column {

// States at n times.
struct States {
    std::size_t n, balls;
    double origin;                 // cradle: height of the first ball's centre at release [m]
    std::vector<double> position;  // [n × N] height of the centres [m]
    std::vector<double> gap;       // [n × N] pair 0 (floor) first [m]
    std::vector<double> velocity;  // [n × N] upwards [m/s]
    std::vector<double> force;     // [n × N] pair 0 (floor) first [N]
    std::vector<double> energy;    // [n × N] kinetic and potential energy of each ball [J]
    std::vector<Energies> total;   // [n] [J]

    States(std::size_t times, int n_balls, double from = 0.0)
        : n(times),
          balls(static_cast<std::size_t>(n_balls)),
          origin(from),
          position(n * balls),
          gap(n * balls),
          velocity(n * balls),
          force(n * balls),
          energy(n * balls),
          total(n) {}

    // Computes positions and energies of time i from its gaps and velocities. `displacement`: that of the first ball
    // of a cradle since release.
    template <class Law>
    void complete(const Column<Law>& c, std::size_t i, double displacement) {
        double z = c.floor ? 0.0 : origin + displacement;
        for (std::size_t j = 0; j < balls; ++j) {
            if (j > 0 || c.floor) z += (j > 0 ? c.radius[j - 1] : 0.0) + gap[i * balls + j] + c.radius[j];
            position[i * balls + j] = z;
        }
        mechanical_energies(c, &gap[i * balls], &velocity[i * balls], &energy[i * balls]);
    }
};

class Solution {
public:
    Sequence sequence;
    std::vector<Contact> contacts;
    double first = math::nan, last = math::nan;  // [s] recorded interval
    long steps = 0;
    double energy_error = math::nan;  // largest, relative to the initial energy; NaN unless integrated
    int too_deep = -1;                // pair that ended the run at deepest_compression; −1: none

    virtual ~Solution() = default;
    // Optional precomputation for sample(). It takes long for a long run; called separately, it can be stopped.
    virtual void prepare(Stop&) const {}
    // Writes the states at out.n times within [first, last]. Thread-safe.
    virtual void sample(const double* times, States& out) const = 0;
    // Writes the state at the end of a contact.
    virtual void sample_after(std::size_t contact, States& out) const {
        const double end = math::min(contacts[contact].end, last);  // rounding
        sample(&end, out);
    }
    // Largest compression of any contact over the smaller radius; NaN in a model without compressions.
    virtual double largest_compression() const { return math::nan; }
    // Whether the largest compression is at least `part`; an energy bound may decide it without computing the
    // compression.
    virtual bool presses_by(double part) const { return largest_compression() >= part; }
    // Times from first to last [s] between which no contact begins or ends and the motion is smooth.
    virtual std::vector<double> knots() const = 0;

protected:
    Solution() = default;
    Solution(const Solution&) = delete;
    Solution& operator=(const Solution&) = delete;
};

// Calls f(index, contact) for each contact that ended: those of the sequence, without the second floor contact, or with
// `until` all that began up to it.
template <class F>
void for_ended_contacts(const Solution& s, double until, F f) {
    bool met = false;  // the floor has been touched
    for (std::size_t k = 0; k < s.contacts.size(); ++k) {
        const Contact& now = s.contacts[k];
        const bool again = met && now.pair == 0 && now.begin >= s.sequence.t_second_touch;
        met = met || now.pair == 0;
        if (!math::is_nan(now.end) && !(math::is_nan(until) ? again : now.begin > until)) f(k, now);
    }
}

// Index of the contact that ended last; −1: none.
inline std::ptrdiff_t last_contact(const Solution& s, double until = math::nan) {
    std::ptrdiff_t found = -1;
    for_ended_contacts(s, until, [&](std::size_t k, const Contact& now) {
        if (found < 0 || now.end >= s.contacts[static_cast<std::size_t>(found)].end)
            found = static_cast<std::ptrdiff_t>(k);
    });
    return found;
}

// Velocities [N] at the end of the last contact. If that is after the second floor touch, the lowest ball's velocity is
// taken at the touch. NaN at rest, if no contact ended, or if a contact became too deep.
inline std::vector<double> final_velocities(const Solution& s, int balls, double until = math::nan) {
    States end(1, balls);
    const std::ptrdiff_t last = last_contact(s, until);
    const Outcome outcome = s.sequence.outcome;
    if (last < 0 || outcome == Outcome::at_rest || outcome == Outcome::too_deep)
        return std::vector<double>(end.balls, math::nan);
    s.sample_after(static_cast<std::size_t>(last), end);
    std::vector<double> found = std::move(end.velocity);
    if (math::is_nan(until) && s.contacts[static_cast<std::size_t>(last)].end > s.sequence.t_second_touch) {
        States again(1, balls);
        s.sample(&s.sequence.t_second_touch, again);
        found[0] = again.velocity[0];
    }
    return found;
}

}  // namespace hardlimit::column
