// What collisions have done so far, and the integral over time of the kinetic energy.
//
// Between collisions the momentum P changes by M g and the kinetic energy E by g·P per unit time. So Σ m v'², v'
// relative to the mean velocity, is 2E − P²/M of polynomials in time, and its integral needs a few operations at
// each collision.
#pragma once
#include "../common/particle.hpp"

namespace hardlimit::boxes {

// A sum that does not lose what is small beside it (Neumaier).
class Sum {
public:
    void add(double x) {
        const double next = sum_ + x;
        lost_ += math::abs(sum_) >= math::abs(x) ? (sum_ - next) + x : (x - next) + sum_;
        sum_ = next;
    }
    double value() const { return sum_ + lost_; }

private:
    double sum_ = 0.0, lost_ = 0.0;
};

template <int d>
struct Tally {
    i64 pairs = 0, walls = 0;
    i64 elastic_by_tc = 0;
    Sum dissipated;     // energy lost in collisions [J]
    Sum virial;         // Σ r·Δp of pair collisions [J s]
    double mass = 0.0;  // M [kg]
    double gravity[d] = {};
    double time = 0.0;     // to which the following belong [s]
    double kinetic = 0.0;  // E [J]
    double momentum[d] = {};
    Sum kinetic_integral;  // ∫ Σ m v'² dt [J s]

    i64 rows() const { return pairs + walls; }

    // Σ m v'² [J]
    double thermal() const {
        double square = 0.0;
        for (int k = 0; k < d; ++k) square += momentum[k] * momentum[k];
        return 2.0 * kinetic - square / mass;
    }
    // ∫ Σ m v'² dt from `time` to `until`: gravity common to all does nothing to v'.
    double integral_until(double until) const {
        return kinetic_integral.value() + thermal() * (until - time);
    }
    void advance(double until) {
        const double step = until - time;
        kinetic_integral.add(thermal() * step);
        for (int k = 0; k < d; ++k) {
            const double gain = mass * gravity[k] * step;
            kinetic += gravity[k] * step * (momentum[k] + 0.5 * gain);
            momentum[k] += gain;
        }
        time = until;
    }
};

}  // namespace hardlimit::boxes
