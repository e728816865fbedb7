// Correction of the impulse of a contact that begins between two steps, to second order.
//
// A force evaluated at equal steps h gives a trapezoidal sum of the true impulse. From the instant of touch on, F(τ) =
// Σ_j c_j (V τ)^{j/p} + O(τ), where V is the approach speed, u = (V τ)^{1/p} the coordinate of the law, and j < p. With
// the first step in contact at τ = s h, 0 < s <= 1, the sum exceeds the integral by
//   Σ_j c_j V^{j/p} h^{1 + j/p} ζ(−j/p, s) + O(h²)
// (generalised Euler–Maclaurin formula, ζ is Hurwitz' function; I. Navot, J. Math. Phys. 40, 271 (1961)). For a
// dashpot, whose force jumps at touch (j = 0, ζ(0, s) = 1/2 − s), the excess is of first order in h, and so is the
// error of ε that it causes. It is therefore subtracted as an impulse. The c_j of any law come from its own force(s,
// rate), called with polynomials in u truncated at u^p.
//
// The end of a contact needs no correction: there the force falls to zero continuously.
#pragma once
#include "../../contact/law.hpp"

namespace hardlimit::boxes::steps {

// ζ(−q, a) for 0 <= q < 1 and a > 0, by the Euler–Maclaurin formula, accurate to 1e-10.
HL_FN double hurwitz_zeta(double q, double a) {
    constexpr int terms = 8;
    const double z = a + terms, power = math::pow(z, q), w = 1.0 / (z * z);
    double sum = 0.0;
    for (int k = 0; k < terms; ++k) sum += math::pow(a + k, q);
    const double third = q * (1.0 - q) * (2.0 - q), fifth = third * (3.0 - q) * (4.0 - q);
    const double tail = -q / 12.0 + w * (third / 720.0 - w * fifth / 30240.0);
    return sum + power * (0.5 - z / (q + 1.0) + tail / z);
}

// Σ_j c_j u^j, truncated at u^p.
template <int p>
struct LeadingTerms {
    double c[p];
};
template <int p>
HL_FN LeadingTerms<p> operator+(LeadingTerms<p> a, const LeadingTerms<p>& b) {
    for (int j = 0; j < p; ++j) a.c[j] += b.c[j];
    return a;
}
template <int p>
HL_FN LeadingTerms<p> operator*(LeadingTerms<p> a, double b) {
    for (int j = 0; j < p; ++j) a.c[j] *= b;
    return a;
}
template <int p>
HL_FN LeadingTerms<p> operator*(double a, const LeadingTerms<p>& b) {
    return b * a;
}
template <int p>
HL_FN LeadingTerms<p> operator-(const LeadingTerms<p>& a, const LeadingTerms<p>& b) {
    return a + b * -1.0;
}
template <int p>
HL_FN LeadingTerms<p> operator*(const LeadingTerms<p>& a, const LeadingTerms<p>& b) {
    LeadingTerms<p> product{};
    for (int i = 0; i < p; ++i)
        for (int j = 0; i + j < p; ++j) product.c[i + j] += a.c[i] * b.c[j];
    return product;
}

// Touch, as seen from the first step in contact.
struct Onset {
    double since;  // time in contact at that step [s]
    double rate;   // approach speed [m/s]
};

// Leading terms of a force after touch [N].
template <int p>
struct OnsetForce {
    LeadingTerms<p> terms;

    // Impulse that equal steps h miss if the first one counts in full [N s].
    double missed_impulse(Onset at, double h) const {
        double sum = 0.0;
        const double depth = at.rate * h, s = at.since / h;
        for (int j = 0; j < p; ++j)
            if (terms.c[j] != 0.0) sum += terms.c[j] * power(depth, j) * hurwitz_zeta(double(j) / p, s);
        return -sum * h;
    }
    // Impulse from touch to the first step in contact, where the force is `value` [N s].
    double impulse_until_step(Onset at, double value) const {
        double sum = 0.0, rest = value;
        for (int j = 0; j < p; ++j) {
            if (terms.c[j] == 0.0) continue;
            const double term = terms.c[j] * power(at.rate * at.since, j);
            sum += term / (1.0 + double(j) / p);
            rest -= term;
        }
        return (sum + 0.5 * rest) * at.since;
    }

private:
    static double power(double depth, int j) { return j == 0 ? 1.0 : math::pow(depth, double(j) / p); }
};

// Leading terms of the force of a law.
template <class Law>
OnsetForce<Law::onset_power> onset_force(const Law& law, double rate) {
    constexpr int p = Law::onset_power;
    LeadingTerms<p> s{}, speed{};
    if constexpr (p > 1) s.c[1] = 1.0;
    speed.c[0] = rate;
    return {law.force(s, speed)};
}
// Leading terms of its damping force.
template <class Law>
OnsetForce<Law::onset_power> onset_damping(const Law& law, double rate) {
    constexpr int p = Law::onset_power;
    LeadingTerms<p> s{};
    if constexpr (p > 1) s.c[1] = 1.0;
    return {onset_force(law, rate).terms - law.elastic_force(s)};
}

}  // namespace hardlimit::boxes::steps
