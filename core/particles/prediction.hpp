// When two particles touch, and when one meets a wall or leaves its cell.
//
// Two particles are apart by r, move apart at the rate v, and touch at the distance σ, which grows at the rate s (0 but
// for growing radii). With a = v² − s², b = r·v − σ s, c = r² − σ²:
//   |r + v τ| = σ + s τ   ⇔   a τ² + 2 b τ + c = 0,
// whose first root is c/(−b + √(b² − a c)) where b < 0, a form that neither cancels nor leads into the past. Where c ≤ 0,
// by rounding or because positions are drawn back, a pair that approaches collides now (Bannerman, Strobl, Formella &
// Pöschel, Comput. Part. Mech. 1, 191 (2014)).
#pragma once
#include "box.hpp"

namespace hardlimit::particles {

struct Approach {
    double a, b, c;

    double discriminant() const { return b * b - a * c; }
};

// Time until touch, given that there is one.
HL_FN double time_to_touch(double b, double c, double discriminant) {
    return c <= 0.0 ? 0.0 : c / (-b + math::sqrt(discriminant));
}
// The same for growing radii, where a pair may part more slowly than its radii grow (b ≥ 0, a < 0).
HL_FN double time_to_touch_growing(const Approach& p, double discriminant) {
    if (p.c <= 0.0) return 0.0;
    const double root = math::sqrt(discriminant);
    return p.b < 0.0 ? p.c / (-p.b + root) : (p.b + root) / -p.a;
}
HL_FN bool will_touch(const Approach& p, double discriminant) {
    return (p.b < 0.0 && discriminant > 0.0) || (p.c > 0.0 && p.a < 0.0);
}

// Time for which x + v τ stays at or below `high`.
HL_FN double time_below(double x, double v, double high) {
    return v > 0.0 ? math::max(0.0, (high - x) / v) : math::infinity;
}

// Time for which x + v τ + g τ²/2 stays at or below `high`, where x ≤ high but for rounding. The last crossing upwards for
// g > 0, the first for g < 0, each in the form that does not cancel.
HL_FN double time_below(double x, double v, double g, double high) {
    if (g == 0.0) return time_below(x, v, high);
    const double room = math::max(0.0, high - x);
    if (g > 0.0) {
        const double root = math::sqrt(v * v + 2.0 * g * room);
        return v > 0.0 ? 2.0 * room / (v + root) : (root - v) / g;
    }
    const double square = v * v + 2.0 * g * room;
    return v > 0.0 && square >= 0.0 ? 2.0 * room / (v + math::sqrt(square)) : math::infinity;
}

}  // namespace hardlimit::particles
