// The law of the error: how much faster event-driven simulation cools a gas than Newton's equations at equal energies.
//
// The relative error of d√(E(0)/E)/dt is a t_c ν for t_c ν → 0. docs/error_law.md derives and measures a.
//
// Notation: d diameter, D dimension, T = ⟨v_x²⟩, χ(φ) = g(d⁺) pair correlation at contact, s = −g'(d⁺) d/χ,
// x = 1 − ε², U(ξ) ∝ ξ^q elastic energy, C(ξ) ∝ ξ^c damping (force C dξ/dt), and ν = D 2^D φ χ √(T/π)/d, Enskog's rate.
#pragma once
#include "../../base/math.hpp"

namespace hardlimit::boxes::error_law {

// By dimension − 2: packing fractions and the smallest restitution at which the law was measured.
struct MeasuredRange {
    double thinnest, densest, restitution;
};
inline constexpr MeasuredRange measured[2] = {{0.05, 0.7, 0.6}, {0.02, 0.5, 0.4}};
inline constexpr MeasuredRange measured_hertz[2] = {{0.4, 0.6, 0.8}, {0.05, 0.5, 0.6}};  // laws with q = 5/2
inline constexpr double measured_tc_nu = 0.3;        // largest t_c ν at which the law was measured
inline constexpr double nearly_elastic_from = 0.99;  // from this ε on the theory has no free parameter

// Structure of the hard-sphere fluid at a packing fraction.
struct Fluid {
    int dimension;
    double packing_fraction;
    double contact_value;  // χ
    double growth;         // D φ χ'/χ
    double slope;          // s

    // D 2^D φ χ: t_c ν of particles whose mean greatest compression is the diameter.
    double density() const {
        return static_cast<double>(dimension << dimension) * packing_fraction * contact_value;
    }
    // Enskog's rate ν [1/s] of particles of this diameter [m] at the temperature T [m²/s²].
    double collision_rate(double diameter, double temperature) const {
        return density() * math::sqrt(temperature / math::pi) / diameter;
    }
};

// χ of Carnahan & Starling (spheres) and Henderson (disks). s of spheres is a fit to snapshots of hard spheres, whose
// first factor is that of Percus and Yevick; Percus and Yevick's s itself is less than half of the measured one at
// φ = 0.5. s of disks has the exact slope 2.205 φ at φ → 0 and is 1.45 ± 0.2, 3.25 ± 0.13, 6.95 ± 0.17 in snapshots at
// φ = 0.3, 0.5, 0.65.
inline Fluid fluid(int dimension, double phi) {
    const double free = 1.0 - phi, square = phi * phi;
    if (dimension == 3) {
        const double slope =
            9.0 * phi * (1.0 + phi) / (2.0 - phi) * (1.0 + 2.9 * square + 3.4 * square * phi);
        const double growth = 3.0 / free - 0.5 / (1.0 - 0.5 * phi);
        return {3, phi, (1.0 - 0.5 * phi) / (free * free * free), 3.0 * phi * growth, slope};
    }
    const double growth = 2.0 / free - 0.4375 / (1.0 - 0.4375 * phi);
    return {2, phi, (1.0 - 0.4375 * phi) / (free * free), 2.0 * phi * growth,
            2.205 * phi * (1.0 + 1.05 * phi) / free};
}

// Exponents of a contact law at small compressions, and two means that follow from them.
struct LawShape {
    double energy = 2.0, damping = 0.0;        // q, c
    double mean_compression = 2.0 / math::pi;  // M, mean ξ over C e^{−U/mT} over ∫ e^{−U/mT} dξ
    double mean_duration = 1.0;                // mean t_c over collisions/t_c at the mean impact speed √(πT)
};

// a for ε → 1, per mean t_c ν. Exact to first order in t_c ν.
//
// a = [1 + (c + 1)/q]/(Dq) + [(D − 1)M + s(1 − M) + Dφχ'/χ]/(D 2^D φ χ). The first term: particles are slower by the
// energy that contacts store. The others: an oblique contact turns its normal and ends early; the neighbours press a
// touching pair together; soft spheres exclude less volume.
inline double nearly_elastic(const Fluid& gas, const LawShape& law) {
    const double q = law.energy, c = law.damping, m = law.mean_compression, dimension = gas.dimension;
    const double stored = (1.0 + (c + 1.0) / q) / (dimension * q);
    return stored + ((dimension - 1.0) * m + gas.slope * (1.0 - m) + gas.growth) / gas.density();
}

// a at x, without correlations of the velocities: its difference from the value at x = 0 for the exponent q, and all
// of it for q = 2.
//
// (3/4 − bx)/D + {(D − 1)(2/π)c + f[(1 − 2/π)s + Dφχ'/χ]}/(D 2^D φ χ). c is the effect of damping on the turn of
// the normal, a fit to isolated contacts. b and f contain third particles that touch one of a pair in contact. b is
// 0.87 for the linear law; for Hertz' laws, q = 5/2, it is a fit: 0.35 ± 0.03 from 44 measured values of 16 gases.
inline double inelastic(const Fluid& gas, double x, double q = 2.0) {
    const double m = LawShape{}.mean_compression, dimension = gas.dimension, cube = x * x * x;
    const double turn = 1.0 - 0.05 * x - 0.08 * cube;
    const double third = 1.0 + (gas.dimension == 3 ? 0.07 * x + 0.26 * cube : 0.09 * x);
    const double shape = (dimension - 1.0) * m * turn + third * ((1.0 - m) * gas.slope + gas.growth);
    return (0.75 - (0.87 - 1.03 * (q - 2.0)) * x) / dimension + shape / gas.density();
}

// h: cooling of hard spheres over Enskog's, 3 to 9 collisions per particle after an elastic equilibrium.
//
// A fit to the measured values, within 0.012 (spheres) and 0.015 (disks) rms. h falls as the velocities of neighbours
// become correlated. The last coefficient is the error of Henderson's χ of dense disks.
inline double correlations(const Fluid& gas, double x) {
    constexpr double coefficients[2][5] = {{2.35, 5.2, -5.65, -0.36, 2.2}, {1.78, 0.34, -7.27, 5.0, 0.0}};
    const double (&c)[5] = coefficients[gas.dimension - 2];
    const double phi = gas.packing_fraction, square = x * x;
    const double slowed = phi * square * (c[0] + c[1] * square + (c[2] + c[3] * square) * phi * phi);
    return 1.0 / (1.0 + slowed + c[4] * math::power<8>(phi));
}

// k for ε → 1: under the rule tc the cooling falls as e^{−2k t_c ν}, as collisions soon after others are elastic.
//
// 1.123 is the value of independent collisions of spheres: the collision rate of the partners, weighted by the loss,
// over ν. It is the first term of the cooling of Luding & Goldshtein, Granular Matter 5, 159 (2003),
// exp(−1.268X + …) with X = √π t_c ν. The second term, a fit: the partner shields a particle from third ones. At
// finite ε the measured k is h² times this. Disks have the same k within the errors.
inline double elastic_by_tc(const Fluid& gas) {
    return 1.123 - 0.083 * (gas.slope + gas.growth) / (12.0 * gas.packing_fraction * gas.contact_value);
}

// a of the rule soft, a fit without a theory: the rule ignores third particles and the energy in contacts.
inline double left_by_soft(const Fluid& gas, double x) {
    return (1.0 - x * x) * (0.07 + 0.14 / (1.0 + gas.packing_fraction / 0.06));
}

// Relative standard error of a inside the range of the measurements.
inline double uncertainty(const Fluid& gas, double x) {
    // For ε → 1, its growth with x, and what is added at the largest measured φ.
    constexpr double of[2][3] = {{0.02, 0.25, 0.15}, {0.03, 0.1, 0.04}};
    const double (&u)[3] = of[gas.dimension - 2];
    const double filled = gas.packing_fraction / measured[gas.dimension - 2].densest;
    const double one = u[0] + u[1] * x, dense = u[2] * math::power<6>(filled);
    return math::sqrt(one * one + dense * dense);
}

// Factor by which the error grows outside the range of the measurements; 1 inside.
inline double widened(const Fluid& gas, double restitution, const MeasuredRange& in) {
    const double phi = gas.packing_fraction;
    return 1.0 + math::max(0.0, math::log(in.thinnest / phi)) +
           10.0 * math::max(0.0, phi / in.densest - 1.0) +
           10.0 * math::max(0.0, in.restitution - restitution);
}

enum class Rule { constant, tc, soft };

struct ErrorLaw {
    double coefficient;        // a
    double coefficient_error;  // its standard error
    double decay = 0.0;        // 2k of the rule tc; 0 for other rules

    // Relative error of the cooling: a t_c ν; for the rule tc (1 + (a + 2k) t_c ν) e^{−2k t_c ν} − 1.
    double error(double tc_nu) const {
        return (1.0 + (coefficient + decay) * tc_nu) * math::exp(-decay * tc_nu) - 1.0;
    }
    // Standard error of error(). Above the largest measured t_c ν it grows with the excess.
    double error_bar(double tc_nu) const {
        const double beyond = math::max(0.0, tc_nu / measured_tc_nu - 1.0);
        const double one = coefficient_error * tc_nu, other = beyond * error(tc_nu);
        return math::sqrt(one * one + other * other);
    }
    // The largest t_c ν up to which the size of the error is at most `limit`; at most the largest measured.
    double largest_tc_nu(double limit) const {
        constexpr int steps = 300;
        for (int i = 0; i < steps; ++i) {  // the first crossing; under the rule tc the error may turn back
            double low = measured_tc_nu * i / steps, high = measured_tc_nu * (i + 1) / steps;
            if (!(math::abs(error(high)) > limit)) continue;
            for (int k = 0; k < 60; ++k) {
                const double middle = 0.5 * (low + high);
                (math::abs(error(middle)) > limit ? high : low) = middle;
            }
            return low;
        }
        return measured_tc_nu;
    }
};

inline ErrorLaw make(const Fluid& gas, double restitution, Rule rule, const LawShape& law = {}) {
    const double x = 1.0 - restitution * restitution, h = correlations(gas, x);
    const bool linear = math::abs(law.energy - 2.0) < 1e-3;
    const MeasuredRange& in = (linear ? measured : measured_hertz)[gas.dimension - 2];
    const double relative = uncertainty(gas, x), wider = widened(gas, restitution, in);
    if (rule == Rule::soft) {
        const double a = left_by_soft(gas, x);
        return {a, (0.03 + 0.5 * a * x) * wider};
    }
    const double a = (nearly_elastic(gas, law) + inelastic(gas, x, law.energy) - inelastic(gas, 0.0)) * h *
                     law.mean_duration;
    if (rule == Rule::constant) return {a, relative * math::abs(a) * wider};
    const double decay = 2.0 * elastic_by_tc(gas) * h * h;
    return {a - decay, relative * math::sqrt(a * a + decay * decay) * wider, decay};
}

}  // namespace hardlimit::boxes::error_law
