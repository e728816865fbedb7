// What a solver found, in the same words for every solver: the sequence, its contacts and the state at any time.
#pragma once
#include <vector>

#include "../stop.hpp"
#include "energies.hpp"
#include "sequence.hpp"

namespace hardlimit::column {

// States at n times.
struct States {
    std::size_t n, balls;
    double origin;                 // of a cradle: where the centre of its first ball is released [m]
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

    // Fills in what follows from gaps and velocities. `way`: of the first ball of a cradle since its release.
    template <class Law>
    void complete(const Column<Law>& c, std::size_t i, double way) {
        double z = c.floor ? 0.0 : origin + way;
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
    double first = math::nan, last = math::nan;  // [s] what was recorded
    long steps = 0;
    double energy_error = math::nan;  // largest, relative to the initial energy; NaN unless integrated
    int too_deep = -1;                // pair that ended the run at deepest_compression; −1: none

    virtual ~Solution() = default;
    // What sample() computes once for all times. After a long run that takes long, hence apart: it may be stopped.
    virtual void prepare(Stop&) const {}
    // The states at out.n times within [first, last]. Safe to call from several threads at once.
    virtual void sample(const double* times, States& out) const = 0;
    // Greatest compression of all contacts over the smaller radius; NaN in a model without compressions.
    virtual double largest_compression() const { return math::nan; }
    // Whether it is at least this one: a bound may say so without it.
    virtual bool presses_by(double part) const { return largest_compression() >= part; }
    // Times from first to last [s] between which nothing begins or ends.
    virtual std::vector<double> knots() const = 0;

protected:
    Solution() = default;
    Solution(const Solution&) = delete;
    Solution& operator=(const Solution&) = delete;
};

// Velocities [N] after the last contact that ended, of those that began up to `until` (NaN: of all). NaN at rest, and
// where no contact ended or one became too deep.
inline std::vector<double> final_velocities(const Solution& s, int balls, double until = math::nan) {
    States end(1, balls);
    double after = -math::infinity;
    for (const Contact& k : s.contacts)
        if (k.end > after && !(k.begin > until)) after = k.end;
    const Outcome outcome = s.sequence.outcome;
    if (after == -math::infinity || outcome == Outcome::at_rest || outcome == Outcome::too_deep)
        return std::vector<double>(end.balls, math::nan);
    after = math::min(after, s.last);  // rounding
    s.sample(&after, end);
    return end.velocity;
}

}  // namespace hardlimit::column
