// Totals over all collisions: counts, dissipated energy, virial, and the time integral of the kinetic energy.
//
// Between collisions the momentum P changes by M g and the kinetic energy E by g·P per unit time. So
// Σ m v'² = 2E − P²/M, v' relative to the mean velocity, is constant, and its integral needs few operations at each
// collision.
#pragma once
#include <algorithm>

#include "../common/particle.hpp"
#include "../common/wall.hpp"

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

// Sums over all particles at one instant: full sums, which follow each change of a velocity and the common fall. The
// rounding error is that of the largest values since the start.
template <int d>
class ParticleSums {
public:
    static constexpr int size = d * (d + 1) / 2;

    // Adds a particle of mass m [kg].
    void add(double m, const double (&velocity)[d]) { change(m, {}, velocity); }
    // Adds potential energy [J].
    void add_potential(double energy) {
        potential_.add(energy);
        largest_[d] = math::max(largest_[d], math::abs(potential_.value()));
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
        for (int k = 0; k < d; ++k) largest_[k] = math::max(largest_[k], products_.value(k));
    }
    // All particles, of total mass m [kg], fall for a time [s] under gravity [m/s²].
    void fall(double m, const double (&gravity)[d], double time) {
        double products[size], gained[d], energy = 0.0;
        int mixed = d;
        for (int i = 0; i < d; ++i) {
            const double p = momentum(i), v = gravity[i] * time;
            gained[i] = m * v;
            products[i] = v * (2.0 * p + gained[i]);
            energy += 0.5 * products[i];
            for (int j = i + 1; j < d; ++j)
                products[mixed++] = v * momentum(j) + gravity[j] * time * (p + gained[i]);
        }
        momentum_.add(gained);
        products_.add(products);
        add_potential(-energy);
        for (int k = 0; k < d; ++k) largest_[k] = math::max(largest_[k], products_.value(k));
    }
    // All particles move for a time [s] in a mean flow of this rate [1/s] with a gradient along the axis. Velocities c
    // are relative to it, so that dc_x/dt = −rate · c_y.
    void shear(double rate, int axis, double time) {
        constexpr int of_pair[3][3] = {{0, d, d + 1}, {d, 1, d + 2}, {d + 1, d + 2, 2}};
        const double angle = rate * time, square = products_.value(axis);
        double products[size] = {}, gained[d] = {};
        gained[0] = -angle * momentum(axis);
        products[0] = angle * (angle * square - 2.0 * products_.value(of_pair[0][axis]));
        products[of_pair[0][axis]] = -angle * square;
        for (int k = 1; k < d; ++k)
            if (k != axis) products[of_pair[0][k]] = -angle * products_.value(of_pair[axis][k]);
        momentum_.add(gained);
        products_.add(products);
        largest_[0] = math::max(largest_[0], products_.value(0));
    }
    // Whether the sums have not lost digits by falling to a small part of their largest value.
    bool are_exact() const {
        bool exact = math::abs(potential_.value()) >= small * largest_[d];
        for (int k = 0; k < d; ++k) exact = exact && products_.value(k) >= small * largest_[k];
        return exact;
    }

    // ∫ Σ m c'² dt over a time [s], c' relative to the mean, in a mean flow as for shear(); m: total mass [kg].
    double sheared_integral(double m, double rate, int axis, double time) const {
        double squares = 0.0;
        for (int k = 0; k < d; ++k) squares += momentum(k) * momentum(k);
        const double angle = rate * time, p = momentum(axis);
        const double along = products_.value(axis) - p * p / m;
        const double across = products_.value(axis == 1 ? d : d + 1) - momentum(0) * p / m;
        return time * ((twice_kinetic() - squares / m) + angle * (angle * along / 3.0 - across));
    }

    double product(int k) const { return products_.value(k); }   // of Σ m v⊗v [J]: xx, yy, (zz,) xy, (xz, yz)
    double momentum(int k) const { return momentum_.value(k); }  // Σ m v [kg m/s]
    double potential() const { return potential_.value(); }      // −Σ m g·x along unfolded paths [J]
    double twice_kinetic() const {
        double sum = 0.0;
        for (int k = 0; k < d; ++k) sum += product(k);
        return sum;
    }

private:
    static constexpr double small = 1.0 / 16.0;

    Sums<size> products_;
    Sums<d> momentum_;
    Sum potential_;
    double largest_[d + 1] = {};  // of Σ m v_k² and of the potential energy [J]
};

template <int d>
struct Accumulators {
    u64 pairs = 0, walls = 0;  // collisions
    u64 elastic_by_tc = 0;
    Sum dissipated;              // energy lost in collisions, friction included [J]
    Sum friction_loss;           // by tangential impulses [J]
    Sums<d*(d + 1) / 2> virial;  // Σ r⊗Δp of pair collisions, components xx, yy, (zz,) xy, (xz, yz) [J s]
    Sum wall_work;               // done by moving walls [J]
    Sum shear_work;              // done by a Lees–Edwards boundary [J]
    double mass = 0.0;           // M [kg]
    double gravity[d] = {};
    double time = 0.0;  // at which the sums are valid [s]
    ParticleSums<d> sums;
    int gradient = 0;           // axis of the gradient in a sheared box, or 0
    double shear_rate = 0.0;    // [1/s]
    ParticleSums<d> from_flow;  // those of the velocities relative to the mean flow, in a sheared box
    Sum kinetic_integral;       // ∫ Σ m v'² dt [J s]
    Sum wall_impulse[most_walls], wall_energy[most_walls];  // as in WallSums [N s], [J]

    u64 collisions() const { return pairs + walls; }
    bool is_sheared() const { return boxes_move && gradient != 0; }

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
        for (int k = 0; k < d; ++k) square += sums.momentum(k) * sums.momentum(k);
        return sums.twice_kinetic() - square / mass;
    }
    // The integral up to a later time. Common gravity does not change v'.
    double integral_until(double until) const {
        return kinetic_integral.value() + thermal_integral(until - time);
    }
    double thermal_integral(double step) const {
        return !is_sheared() ? thermal() * step
                             : from_flow.sheared_integral(mass, shear_rate, gradient, step);
    }
    // Whether no sum has lost digits.
    bool are_exact() const { return sums.are_exact() && (!is_sheared() || from_flow.are_exact()); }
    void advance(double until) {
        const double step = until - time;
        if (step == 0.0) return;
        kinetic_integral.add(thermal_integral(step));
        const bool falls = std::any_of(gravity, gravity + d, [](double g) { return g != 0.0; });
        if (falls) sums.fall(mass, gravity, step);
        if (is_sheared()) {
            if (falls) from_flow.fall(mass, gravity, step);
            from_flow.shear(shear_rate, gradient, step);
        }
        time = until;
    }
    // Collision with a wall, which gets this momentum and does this work; `lost`: dissipated [N s], [J].
    void add_wall(WallId wall, double impulse, double work, double lost) {
        ++walls;
        wall_work.add(work);
        wall_impulse[wall.index()].add(impulse);
        wall_energy[wall.index()].add(lost - work);
    }
    WallSums of_walls() const {
        WallSums sums;
        for (int k = 0; k < most_walls; ++k)
            sums.impulse[k] = wall_impulse[k].value(), sums.energy[k] = wall_energy[k].value();
        return sums;
    }
};

}  // namespace hardlimit::boxes
