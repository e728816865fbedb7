// Totals over all collisions: counts, dissipated energy, virial, and the time integral of the kinetic energy.
//
// Between collisions the momentum P changes by M g and the kinetic energy E by g·P per unit time. So
// Σ m v'² = 2E − P²/M, v' relative to the mean velocity, is constant, and its integral needs few operations at each
// collision.
#pragma once
#include "../common/particle.hpp"
#include "../common/symmetric_tensor.hpp"

namespace hardlimit::boxes {

// Compensated sum, which keeps the digits of small terms (A. Neumaier, Z. Angew. Math. Mech. 54, 39 (1974)).
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

// Several compensated sums. Has no branches, so that a compiler can use vectors (O. Møller's error of a sum, BIT 5, 37
// (1965)).
template <int n>
class Sums {
public:
    void add(const double (&x)[n]) {
        for (int k = 0; k < n; ++k) {
            const double next = sum_[k] + x[k], added = next - sum_[k];
            lost_[k] += (sum_[k] - (next - added)) + (x[k] - added);
            sum_[k] = next;
        }
    }
    double value(int k) const { return sum_[k] + lost_[k]; }

private:
    double sum_[n] = {}, lost_[n] = {};
};

// Sums over the velocities of all particles at one instant.
struct VelocitySums {
    double kinetic = 0.0;      // Σ m v²/2 [J]
    double momentum[3] = {};   // Σ m v [kg m/s]
    SymmetricTensor products;  // Σ m v⊗v [J]
};

// The same sums while collisions change velocities: those at the last full sum, and the changes since, computed from
// the velocities before and after each collision. The error is of the order of one rounding of the largest value since
// the full sum.
template <int d>
class RunningVelocitySums {
public:
    void restart(const VelocitySums& full) {
        full_ = full;
        products_ = {};
        momentum_ = {};
        largest_ = full.kinetic;
    }
    // The velocity of a particle of mass m [kg] has changed.
    void change(double m, const double (&before)[d], const double (&after)[d]) {
        double products[size], momentum[d];
        int mixed = d;
        for (int i = 0; i < d; ++i) {
            momentum[i] = m * (after[i] - before[i]);
            products[i] = m * (after[i] * after[i] - before[i] * before[i]);
            for (int j = i + 1; j < d; ++j)
                products[mixed++] = m * (after[i] * after[j] - before[i] * before[j]);
        }
        momentum_.add(momentum);
        products_.add(products);
        largest_ = math::max(largest_, kinetic());
    }
    double kinetic() const {
        double trace = 0.0;
        for (int k = 0; k < d; ++k) trace += products_.value(k);
        return full_.kinetic + 0.5 * trace;
    }
    // Whether the energy has fallen so far that the sums lose digits.
    bool are_inexact() const { return kinetic() < 0.25 * largest_; }
    VelocitySums value() const {
        VelocitySums now = full_;
        now.kinetic = kinetic();
        for (int k = 0; k < d; ++k) now.momentum[k] += momentum_.value(k);
        int k = 0;
        for (std::size_t c = 0; c < SymmetricTensor::size; ++c)
            if (SymmetricTensor::column[c] < d) now.products.component[c] += products_.value(k++);
        return now;
    }

private:
    static constexpr int size = d * (d + 1) / 2;

    VelocitySums full_;
    Sums<size> products_;  // components xx, yy, (zz,) xy, (xz, yz)
    Sums<d> momentum_;
    double largest_ = 0.0;  // kinetic energy since the full sum [J]
};

template <int d>
struct Accumulators {
    u64 pairs = 0, walls = 0;  // collisions
    u64 elastic_by_tc = 0;
    Sum dissipated;              // energy lost in collisions [J]
    Sums<d*(d + 1) / 2> virial;  // Σ r⊗Δp of pair collisions, components xx, yy, (zz,) xy, (xz, yz) [J s]
    Sum wall_work;               // done by moving walls [J]
    double mass = 0.0;           // M [kg]
    double gravity[d] = {};
    double time = 0.0;     // at which kinetic energy and momentum are valid [s]
    double kinetic = 0.0;  // E [J]
    double momentum[d] = {};
    Sum kinetic_integral;               // ∫ Σ m v'² dt [J s]
    RunningVelocitySums<d> velocities;  // without gravity

    u64 collisions() const { return pairs + walls; }

    // Adds factor · (a⊗b + b⊗a)/2 to the virial.
    void add_virial(double factor, const double (&a)[d], const double (&b)[d]) {
        double x[d * (d + 1) / 2];
        int mixed = d;
        for (int i = 0; i < d; ++i) {
            x[i] = factor * (a[i] * b[i]);
            for (int j = i + 1; j < d; ++j) x[mixed++] = (0.5 * factor) * (a[i] * b[j] + a[j] * b[i]);
        }
        virial.add(x);
    }

    // Σ m v'² [J]
    double thermal() const {
        double square = 0.0;
        for (int k = 0; k < d; ++k) square += momentum[k] * momentum[k];
        return 2.0 * kinetic - square / mass;
    }
    // The integral up to a later time. Common gravity does not change v'.
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
    // Collision with a wall at `time`; `lost`: kinetic energy lost in the frame of the wall [J].
    void add_wall(int axis, double impulse, double lost, const Wall& wall) {
        ++walls;
        kinetic -= lost;
        momentum[axis] += impulse;
        if (!wall.moves()) return;
        kinetic += impulse * wall.velocity(time);
        wall_work.add(impulse * wall.velocity(time));
    }
};

}  // namespace hardlimit::boxes
