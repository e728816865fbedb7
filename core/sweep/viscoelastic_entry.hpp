// Conversion of a point from physical parameters to the scaled drop that viscoelastic_kernel.hpp solves.
#pragma once
#include "parameters.hpp"
#include "viscoelastic_scaling.hpp"

namespace hardlimit::sweep {

// Table for the argument x of the universal collision as a function of the loss exponent L = −ln ε. Faster than
// contact::viscoelastic_argument, which solves about eight collisions for each value. ln L is a smooth, nearly linear
// function of ln x; it is interpolated at Chebyshev points of equal panels and inverted by Newton's method.
class LossTable {
public:
    static const LossTable& shared() {
        static const LossTable table;
        return table;
    }

    // Accurate to about 1e-14, like contact::viscoelastic_argument.
    double argument(double loss_exponent) const {
        if (!(loss_exponent > 0.0)) return 0.0;
        const double wanted = math::log(loss_exponent);
        if (!(wanted < edge[panels])) return contact::viscoelastic_argument(loss_exponent);
        if (wanted <= edge[0]) return weak(loss_exponent);
        int low = 0, high = panels;
        while (high - low > 1) {
            const int middle = (low + high) / 2;
            (edge[middle] <= wanted ? low : high) = middle;
        }
        double y =
            2.0 * ((wanted - edge[low]) / (edge[high] - edge[low])) - 1.0;  // place in the panel, −1 … 1
        for (int i = 0; i < 6; ++i) {
            double slope;
            const double step = (wanted - value(low, y, slope)) / slope;
            y = math::clamp(y + step, -1.1, 1.1);
            if (math::abs(step) < 1e-9) break;  // converges quadratically
        }
        return math::exp(lowest + width * (low + 0.5 * (1.0 + y)));
    }

private:
    static constexpr int panels = 24, terms = 16;
    static constexpr double lowest = -9.0, width = 0.625;  // of ln x; x = 1.2e-4 … 403, ε = 0.99986 … 6e-5
    double coefficient[panels][terms], edge[panels + 1];

    LossTable() {
        for (int i = 0; i < panels; ++i) {
            double sample[terms];
            for (int k = 0; k < terms; ++k) sample[k] = log_loss(i + 0.5 * (1.0 + node(k)));
            for (int j = 0; j < terms; ++j) {
                double sum = 0.0;
                for (int k = 0; k < terms; ++k)
                    sum += sample[k] * math::cos(math::pi * j * (k + 0.5) / terms);
                coefficient[i][j] = sum * ((j == 0 ? 1.0 : 2.0) / terms);
            }
        }
        double slope;
        for (int i = 0; i < panels; ++i) edge[i] = value(i, -1.0, slope);
        edge[panels] = value(panels - 1, 1.0, slope);
    }

    static double node(int k) { return math::cos(math::pi * (k + 0.5) / terms); }

    static double log_loss(double panel) {
        const contact::UniversalCollision c =
            contact::viscoelastic_collision(math::exp(lowest + width * panel));
        return math::log(c.loss < 0.5 ? -math::log1p(-c.loss) : -math::log(c.restitution));
    }

    // The interpolant and its slope, by Clenshaw's recurrence.
    double value(int panel, double y, double& slope) const {
        double b1 = 0.0, b2 = 0.0, d1 = 0.0, d2 = 0.0;
        for (int j = terms - 1; j > 0; --j) {
            const double d = 2.0 * (b1 + y * d1) - d2;
            d2 = d1;
            d1 = d;
            const double b = (coefficient[panel][j] + 2.0 * y * b1) - b2;
            b2 = b1;
            b1 = b;
        }
        slope = (b1 + y * d1) - d2;
        return (coefficient[panel][0] + y * b1) - b2;
    }

    // Below the range of the table the series of Eq. B3 is accurate to rounding.
    static double weak(double loss_exponent) {
        double x = loss_exponent / -contact::series_coefficients[2];
        for (int i = 0; i < 8; ++i) {
            const double y = math::sqrt(x);
            double loss = 0.0;
            for (int k = contact::series_terms - 1; k > 0; --k)
                loss = (loss + contact::series_coefficients[k]) * y;
            x *= loss_exponent / -math::log1p(loss);
        }
        return x;
    }
};

// Cache of the last results of column::viscoelastic_rate. Neighbours in a map often have the same balls, and the six
// calls of pow cost as much as the rest of the conversion.
class Rates {
    struct Entry {
        double prefactor = math::nan, mass = math::nan, speed = math::nan, rate;
    };
    Entry entries[4];
    int next = 0;

public:
    double operator()(double prefactor, double mass, double speed) {
        for (const Entry& e : entries)
            if (e.prefactor == prefactor && e.mass == mass && e.speed == speed) return e.rate;
        next = (next + 1) % 4;
        entries[next] = {prefactor, mass, speed, column::viscoelastic_rate(prefactor, mass, speed)};
        return entries[next].rate;
    }
};

// Converts a point to a drop for the kernel; false if the kernel cannot solve it. The arguments x of the universal
// collision at impact_speed are used if the law is specified by ε.
inline bool enter_viscoelastic(const Setting& setting, Parameters& q, double floor_argument,
                               double pair_argument, Rates& rate, column::Start& s) {
    using contact::Viscoelastic;
    Bodies b;
    if (!measure(setting, q, b)) return false;
    const auto law = [&](const double* p, double argument, PairGeometry pair) {
        const double elastic[3] = {p[0], p[1], p[2]};
        Viscoelastic v = Viscoelastic::from_parameters(0, elastic, pair);
        if (setting.restitution_at >= 0)
            v.dissipative_time = argument / (1.5 * rate(v.elastic_prefactor, pair.effective_mass, p[3]));
        return v;
    };
    const double reduced = effective(b.m1, b.m2);
    const Viscoelastic floor = law(q.floor_law, floor_argument, {b.m1, q.radius_1});
    const Viscoelastic pair = law(q.pair_law, pair_argument, {reduced, effective(q.radius_1, q.radius_2)});
    const double speed = column::impact_speed(b.height, q.velocity_1, q.gravity);
    s = column::start_two_ball(floor, pair, released(q, b),
                               {speed, rate(pair.elastic_prefactor, reduced, speed)});
    const column::TwoBall& g = s.groups;
    return s.outcome == Outcome::ok &&
           math::is_finite((g.a1 + g.a2) + (g.c1 + g.c2) + (g.gravity + s.first.w));
}

// Bound on the compressions of a point that enter_viscoelastic() accepted.
inline column::CompressionBound viscoelastic_bound(const Setting& setting, Parameters q) {
    using contact::Viscoelastic;
    Bodies b;
    measure(setting, q, b);
    const auto law = [](const double* p, PairGeometry pair) {
        const double elastic[3] = {p[0], p[1], 0.0};
        return Viscoelastic::from_parameters(0, elastic, pair);
    };
    return bound_of(setting, q, b, law(q.floor_law, {b.m1, q.radius_1}),
                    law(q.pair_law, {effective(b.m1, b.m2), effective(q.radius_1, q.radius_2)}));
}

}  // namespace hardlimit::sweep
