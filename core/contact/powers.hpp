// One head-on collision under the normal forces of particle codes, F = K ξ^p + C ξ^q ξ̇ with p and q multiples of 1/4,
// either with the attraction at the end of the contact or cut off at zero.
//
// With X = ξ/L and time in units of L/v, where K L^(p+1) = m v², the only parameter is c = C L^(q+1)/(m v):
//   X'' + X^p + c X^q X' = 0, X(0) = 0, X'(0) = 1, until X = 0 or, if cut off, until X^p + c X^q X' = 0.
// Fractional powers make this singular at touch. X = s⁴, dt = s³ dτ give a polynomial system,
//   ds/dτ = V/4,  dV/dτ = −s³ (s^4p + c s^4q V),  dt/dτ = s³,
// integrated at order 8. The laws of registry.hpp are special cases with other solutions; the tests compare both.
#pragma once
#include "../base/dormand_prince.hpp"
#include "law.hpp"

namespace hardlimit::contact {

// Result of a collision: ε (0 if the bodies stay together), duration [L/v], largest compression [L], largest force
// [m v²/L].
struct PowerCollision {
    double restitution, duration, compression, force;
};

namespace powers {

HL_FN double whole_power(double x, int n) {
    double product = 1.0;
    for (int i = 0; i < n; ++i) product *= x;
    return product;
}

class Motion {
public:
    HL_FN Motion(Powers of, double c) : of_(of), c_(c) {}

    HL_FN PowerCollision run() {
        PowerCollision found{0.0, math::infinity, 0.0, of_.damping == 0 ? c_ : 0.0};
        // A collision that has not ended after most_steps moves only by rounding error.
        for (int i = 0; i < most_steps; ++i) {
            const double h = step();
            const bool over = ending(next_) <= 0.0 && next_[1] < 0.0;
            note_peaks(h, found);
            if (over) {
                double end[size];
                at(crossing(h, [&](const double* y) { return ending(y); }), end);
                found.restitution = math::max(0.0, -end[1]);
                found.duration = end[2];
                return found;
            }
            for (int k = 0; k < size; ++k) state_[k] = next_[k];
            if (state_[1] < 0.0 && -state_[1] < negligible) break;
        }
        return found;
    }

private:
    static constexpr int size = 3;  // s, V, t
    static constexpr int most_steps = 20000;
    static constexpr double negligible = 1e-12;

    HL_FN double force(const double* y) const {
        return whole_power(y[0], of_.elastic) + c_ * whole_power(y[0], of_.damping) * y[1];
    }

    HL_FN void rates(const double* y, double* out) const {
        const double cube = y[0] * y[0] * y[0];
        out[0] = 0.25 * y[1];
        out[1] = -cube * force(y);
        out[2] = cube;
    }

    // Event function: positive until the contact ends, with a simple zero there also without damping.
    HL_FN double ending(const double* y) const {
        if (of_.attracts || y[1] >= 0.0) return y[0];
        const double push = whole_power(y[0], of_.elastic - of_.damping - 1) * y[0];
        return y[0] <= 0.0 ? y[0] : push + c_ * y[1];
    }

    // dF/dτ divided by a positive factor.
    HL_FN double force_growth(const double* y) const {
        double rate[size];
        rates(y, rate);
        double grown = of_.elastic * whole_power(y[0], of_.elastic - 1) * rate[0];
        grown += c_ * whole_power(y[0], of_.damping) * rate[1];
        if (of_.damping > 0) grown += c_ * of_.damping * whole_power(y[0], of_.damping - 1) * rate[0] * y[1];
        return grown;
    }

    HL_FN void at(double h, double* out) {
        const auto f = [&](const double* y, double* dy) { rates(y, dy); };
        rates(state_, stages_);
        DormandPrince::step(f, state_, h, size, stages_, out);
    }

    // Takes one step from state_ to next_, with error control; returns its length.
    HL_FN double step() {
        for (;;) {
            at(length_, next_);
            double scale[size];
            for (int k = 0; k < size; ++k)
                scale[k] = tolerance * (math::abs(state_[k]) + math::abs(next_[k]) + floor_of_scale);
            const double error = DormandPrince::error(stages_, length_, size, scale);
            const double taken = length_;
            length_ *= DormandPrince::growth(error);
            if (error <= 1.0) return taken;
        }
    }

    // Position within a step of length h at which a function of the state, positive at the start, falls to zero.
    template <class Function>
    HL_FN double crossing(double h, const Function& g) {
        double low = 0.0, high = h, middle[size];
        for (int i = 0; i < 60 && high - low > 2.0 * math::epsilon * high; ++i) {
            const double between = 0.5 * (low + high);
            at(between, middle);
            (g(middle) > 0.0 ? low : high) = between;
        }
        return high;
    }

    HL_FN void note_peaks(double h, PowerCollision& found) {
        double y[size];
        if (state_[1] > 0.0 && next_[1] <= 0.0) {
            at(crossing(h, [](const double* z) { return z[1]; }), y);
            found.compression = whole_power(y[0], 4);
        }
        if (force_growth(state_) > 0.0 && force_growth(next_) <= 0.0) {
            at(crossing(h, [&](const double* z) { return force_growth(z); }), y);
            found.force = math::max(found.force, force(y));
        }
        if (next_[0] > 0.0) found.force = math::max(found.force, force(next_));
    }

    static constexpr double tolerance = 1e-14, floor_of_scale = 1e-3;
    Powers of_;
    double c_;
    double state_[size] = {0.0, 1.0, 0.0}, next_[size], stages_[DormandPrince::stages * size];
    double length_ = 1e-2;
};

}  // namespace powers

// One collision at damping c >= 0, to about 1e-12.
HL_FN PowerCollision power_collision(Powers of, double c) { return powers::Motion(of, c).run(); }

// The damping c that gives this coefficient of restitution, which decreases with c.
HL_FN double power_damping(Powers of, double restitution) {
    if (restitution >= 1.0) return 0.0;
    double low = 0.0, high = 1.0;
    while (power_collision(of, high).restitution > restitution) {
        low = high;
        high *= 2.0;
    }
    for (int i = 0; i < 200 && high - low > 4.0 * math::epsilon * high; ++i) {
        const double middle = 0.5 * (low + high);
        (power_collision(of, middle).restitution > restitution ? low : high) = middle;
    }
    return 0.5 * (low + high);
}

}  // namespace hardlimit::contact
