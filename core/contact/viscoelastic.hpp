// Viscoelastic spheres: F = max(0, ρ ξ^{3/2} + (3/2) ρ A √ξ ξ̇), ρ = 2Y√R_eff/(3(1 − ν²)) (Eqs. B1–B2, written
// as a force). A is a time; A = 0 gives Hertz' law.
//
// One collision depends only on x = (3/2) A k^{2/5} v^{1/5}, k = ρ/m. With X = ξ in units of (v²/k)^{2/5}:
//   X'' + X^{3/2} + x √X X' = 0, X(0) = 0, X'(0) = 1, end at X + x X' = 0, ε = −X'(end).
// The √X makes the equation singular at touch; X = s², dt = s dτ turn it into a polynomial system,
//   ds/dτ = V/2,  dV/dτ = −s⁴ − x s² V,  dt/dτ = s,
// integrated here by Taylor series to rounding error. For x > 1, s is scaled by x^{−1/3} so that no coefficient grows
// with x: dV/dθ = −q σ⁴ − σ² V with q = x^{−5/3}.
#pragma once
#include "hertz.hpp"

namespace hardlimit::contact {

// Result of a collision in the units above.
struct UniversalCollision {
    double restitution;
    double loss;      // 1 − ε, accurate also when ε is near 1
    double duration;  // t_c k^{2/5} v^{1/5}
};

namespace universal {

inline constexpr int order = 26;

struct Series {
    double s[order + 1], v[order + 1], t[order + 1], d[order + 1];
};

// Taylor coefficients of (σ, V, t, dissipated energy) about the current state, for dV/dθ = −p σ⁴ − r σ² V.
HL_FN void expand(double sigma, double velocity, double p, double r, Series& c) {
    double a[order + 1], av[order + 1];  // σ², σ²V
    c.s[0] = sigma;
    c.v[0] = velocity;
    c.t[0] = 0.0;
    c.d[0] = 0.0;
    for (int n = 0; n < order; ++n) {
        double square = 0.0;
        for (int i = 0; i <= n; ++i) square += c.s[i] * c.s[n - i];
        a[n] = square;
        double fourth = 0.0, product = 0.0;
        for (int i = 0; i <= n; ++i) {
            fourth += a[i] * a[n - i];
            product += a[i] * c.v[n - i];
        }
        av[n] = product;
        double power = 0.0;  // σ² V²
        for (int i = 0; i <= n; ++i) power += av[i] * c.v[n - i];
        const double inverse = 1.0 / (n + 1);
        c.t[n + 1] = c.s[n] * inverse;
        c.s[n + 1] = 0.5 * c.v[n] * inverse;
        c.v[n + 1] = -(p * fourth + r * product) * inverse;
        c.d[n + 1] = r * power * inverse;
    }
}

HL_FN double evaluate(const double* c, double h) {
    double sum = c[order];
    for (int n = order - 1; n >= 0; --n) sum = sum * h + c[n];
    return sum;
}

// Step for which the last two terms of σ and V are below rounding. The final |V| is ε, which may be tiny, so the terms
// of V are compared with V or, where V passes through zero, with the speed p σ² at the end of the contact.
HL_FN double step_size(const Series& c, double p) {
    const double speed = math::max(math::abs(c.v[0]), p * c.s[0] * c.s[0]);
    double h = 4.0;  // longer than any step; used if the terms underflow
    for (int n = order - 1; n <= order; ++n) {
        const double largest = math::max(math::abs(c.s[n]), math::abs(c.v[n]) / speed);
        if (largest > 0.0) h = math::min(h, math::exp(math::log(1e-18 / largest) / n));
    }
    return h;
}

}  // namespace universal

// ε, 1 − ε and t_c of the universal problem for x >= 0, to about 1e-15.
HL_FN UniversalCollision viscoelastic_collision(double x) {
    using namespace universal;
    const bool strong = x > 1.0;
    const double cube_root = strong ? math::pow(x, -1.0 / 3.0) : 1.0;  // length unit of s
    const double p = strong ? math::pow(x, -5.0 / 3.0) : 1.0;
    const double r = strong ? 1.0 : x;
    double sigma = 0.0, velocity = 1.0, time = 0.0, lost = 0.0;
    Series c;
    for (int step = 0; step < 1000; ++step) {
        expand(sigma, velocity, p, r, c);
        double h = step_size(c, p);
        // The contact ends at the zero of g = σ − √(−r V/p), simple also at x = 0, where that of pσ² + rV is double.
        const auto g = [&](double at) {
            const double s1 = evaluate(c.s, at), v1 = evaluate(c.v, at);
            return v1 > 0.0 ? 1.0 : s1 - math::sqrt(-r * v1 / p);
        };
        const bool last = g(h) <= 0.0;
        if (last) {
            double lo = 0.0, hi = h, g_lo = g(lo), g_hi = g(hi);
            for (int i = 0; i < 100 && hi - lo > 2.0 * math::epsilon * hi; ++i) {  // Illinois rule
                double mid = (i % 3 == 2) ? 0.5 * (lo + hi) : hi - g_hi * ((hi - lo) / (g_hi - g_lo));
                if (!(mid > lo && mid < hi)) mid = 0.5 * (lo + hi);
                if (mid == lo || mid == hi) break;
                const double g_mid = g(mid);
                if (g_mid > 0.0) {
                    lo = mid;
                    g_lo = g_mid;
                } else {
                    hi = mid;
                    g_hi = g_mid;
                    if (g_mid == 0.0) break;
                }
            }
            h = hi;
        }
        time += evaluate(c.t, h);
        lost += evaluate(c.d, h);
        sigma = evaluate(c.s, h);
        velocity = evaluate(c.v, h);
        if (last) break;
    }
    const double restitution = -velocity;
    // Energy balance: 1 − ε² = 2 (dissipated) + (4/5) X_end^{5/2}; a sum of positive terms.
    const double root = cube_root * math::max(sigma, 0.0);
    const double stored = 0.8 * root * root * root * root * root;
    const double loss = (2.0 * lost + stored) / (1.0 + restitution);
    return {loss < 0.5 ? 1.0 - loss : restitution, loss, time * cube_root * cube_root};
}

// Inverse: x from L = −ln ε. ln L is linear in ln x for small x and nearly so for large x, so the bracketed secant
// method in these variables needs about eight evaluations.
HL_FN double viscoelastic_argument(double loss_exponent) {
    if (!(loss_exponent > 0.0)) return 0.0;
    const auto residual = [&](double log_x) {
        const UniversalCollision c = viscoelastic_collision(math::exp(log_x));
        const double exponent = c.loss < 0.5 ? -math::log1p(-c.loss) : -math::log(c.restitution);
        return math::log(exponent / loss_exponent);
    };
    // L <= 1.1535 x and L >= (5/3) ln x − 0.2704 bound x on both sides.
    double lo = math::log(loss_exponent / 1.2), hi = 0.6 * loss_exponent + 0.7;
    if (loss_exponent < 1.0) hi = math::log(loss_exponent * 2.0);
    double f_lo = residual(lo), f_hi = residual(hi);
    if (f_lo >= 0.0) return math::exp(lo);
    double best = hi;
    int side = 0;
    for (int i = 0; i < 80; ++i) {
        double mid = hi - f_hi * ((hi - lo) / (f_hi - f_lo));
        if (!(mid > lo && mid < hi)) mid = 0.5 * (lo + hi);
        const double f = residual(mid);
        best = mid;
        if (math::abs(f) < 2.0 * math::epsilon || hi - lo < 4.0 * math::epsilon) break;
        if (f > 0.0) {
            hi = mid;
            f_hi = f;
            if (side == 1) f_lo *= 0.5;
            side = 1;
        } else {
            lo = mid;
            f_lo = f;
            if (side == -1) f_hi *= 0.5;
            side = -1;
        }
    }
    return math::exp(best);
}

// Coefficients h_k of ε = Σ h_k x^{k/2} (Eq. B3), k = 0 … 9: Schwager & Pöschel, Phys. Rev. E 78, 051304 (2008),
// to more digits. The series is asymptotic in practice and useless above x ≈ 0.6.
inline constexpr int series_terms = 10;
inline constexpr double series_coefficients[series_terms] = {1.0,
                                                             0.0,
                                                             -1.153448858095289,
                                                             0.0,
                                                             0.798266560944795,
                                                             4.0 / 15.0,
                                                             -0.522882568088415,
                                                             -0.461379543238116,
                                                             0.348742675260386,
                                                             0.45235105120205};

struct Viscoelastic {
    double elastic_prefactor;  // ρ [N/m^{3/2}]
    double dissipative_time;   // A [s]

    static constexpr int onset_power = 2;
    static constexpr LawRecord record = {
        "viscoelastic",
        "Viscoelastic",
        "Viscoelastic spheres: F = max(0, ρ ξ^(3/2) + (3/2) ρ A √ξ dξ/dt), ρ = 2Y√R_eff/(3(1 − ν²)). A = 0 is Hertz.",
        "Müller & Pöschel, Phys. Rev. E 83, 041304 (2011), Eqs. B1–B3; "
        "Brilliantov et al., Phys. Rev. E 53, 5382 (1996)",
        2,
        {youngs_modulus, poisson_ratio},
        2,
        {1, 2},
        {{not_negative("dissipative_time", "s",
                       "material constant A, the same for every contact (Appendix C)")},
         {fraction("restitution",
                   "coefficient of restitution ε at impact_speed; every contact gets the A that yields it"),
          positive("impact_speed", "m/s", "speed of approach at which ε is given")}},
        2,
        {{"elastic_prefactor", "N/m^1.5", "ρ"}, {"dissipative_time", "s", "A"}},
        {6, 2}};

    void values(double* out) const {
        out[0] = elastic_prefactor;
        out[1] = dissipative_time;
    }
    Coefficients coefficients() const {
        return {elastic_prefactor, 1.5 * elastic_prefactor * dissipative_time};
    }

    static Viscoelastic from_parameters(int alternative, const double* p, PairGeometry pair) {
        const double rho = hertz_prefactor(p[0], p[1], pair.effective_radius);
        if (alternative == 0) return {rho, p[2]};
        const double x = viscoelastic_argument(-math::log(p[2]));
        return {rho, x / argument_per_time(rho, pair.effective_mass, p[3])};
    }

    // x/A = (3/2) (ρ/m)^{2/5} v^{1/5}.
    static double argument_per_time(double rho, double mass, double speed) {
        return 1.5 * math::pow(rho / mass, 0.4) * math::pow(speed, 0.2);
    }

    template <class T>
    T force(T s, T rate) const {
        return elastic_prefactor * (s * (s * s + 1.5 * dissipative_time * rate));
    }
    template <class T>
    T elastic_force(T s) const {
        return elastic_prefactor * (s * s * s);
    }
    template <class T>
    T energy(T s) const {
        return 0.4 * elastic_prefactor * (s * s) * (s * s) * s;
    }
    // The force ends at ξ + (3/2) A ξ̇ = 0.
    Slack slack(double rate) const { return {-relaxation_time() * rate, -relaxation_time()}; }
    double relaxation_time() const { return 1.5 * dissipative_time; }

    UniversalCollision collision(double speed, double mass) const {
        return viscoelastic_collision(dissipative_time * argument_per_time(elastic_prefactor, mass, speed));
    }
    double restitution(double speed, double mass) const { return collision(speed, mass).restitution; }
    double duration(double speed, double mass) const {
        return collision(speed, mass).duration /
               (math::pow(elastic_prefactor / mass, 0.4) * math::pow(speed, 0.2));
    }
};

}  // namespace hardlimit::contact
