// 1 + β of the exact contact of one pair with a fixed normal (core/contact/frictional_impact.hpp), from a table.
//
// If the scaled contact does not depend on the speed, 1 + β is a function of M = κ μ v/g alone (scaled_impact.hpp).
// With x = M/(1 + M) in [0, 1], (1 + β)/x is finite at both ends and analytic but for kinks, where the sequence of
// stick and slip changes. Intervals of x are halved until polynomials of degree 15 (Chebyshev) have converged: the
// smallest are those at kinks. An interval is filled when a collision first falls into it; its numbers do not depend on
// the order of the collisions. The error of β is at most 1e-10; where halving does not reach this, and at x < 2^-17,
// the contact itself is solved. tangential_surface.hpp has the contacts that depend on the speed.
#pragma once
#include <vector>

#include "../../contact/frictional_impact.hpp"

namespace hardlimit::boxes {

// What friction does in one collision.
struct TangentialResult {
    double gain;  // 1 + β; NaN if not solved
    bool slid;    // the surfaces have slipped
};

// Whether the scaled contact depends on the speed.
inline bool depends_on_speed(const contact::FrictionalContact& c) {
    const FrictionTerms& f = c.friction;
    const auto damps = [&](double factor, int power) {
        return factor != 0.0 && c.powers.elastic != 2 * power + 4;
    };
    return damps(c.normal.damping, c.powers.damping) || damps(f.damping.factor, f.damping.power) ||
           (f.stiffness.factor != 0.0 && f.stiffness.power != c.powers.elastic - 4);
}

// Whether the surfaces slip for more than rounding.
struct SlipObserver {
    bool slid = false;
    template <class At>
    void operator()(contact::Surfaces surfaces, double begin, double end, const At&) {
        slid = slid || (surfaces == contact::Surfaces::slip && end - begin > 1e-12 * end);
    }
};

// The same without a table.
inline TangentialResult solve_tangential(const contact::ScaledImpact& scaled) {
    return contact::with_solution(scaled, [](auto& motion) -> TangentialResult {
        SlipObserver observer;
        if (!motion.run(observer)) return {math::nan, false};
        return {1.0 - motion.state().slip, observer.slid};
    });
}

// A spring of constant stiffness cannot give back more than it got.
inline TangentialResult limited(TangentialResult r, const PowerTerm& stiffness) {
    if (stiffness.power == 0) r.gain = math::clamp(r.gain, 0.0, 2.0);
    return r;
}

inline TangentialResult solve_tangential(const contact::FrictionalContact& c, double speed, double slip) {
    return limited(solve_tangential(c.scaled(speed, slip)), c.friction.stiffness);
}

// Coefficients of the polynomial of degree n through f[k] at y = cos(π k/n), in Chebyshev's polynomials of y; in place,
// with this stride.
template <int n>
void to_chebyshev(double* f, std::size_t stride = 1) {
    double c[n + 1];
    for (int j = 0; j <= n; ++j) {
        double sum = 0.5 * (f[0] + (j % 2 == 0 ? f[n * stride] : -f[n * stride]));
        for (int k = 1; k < n; ++k)
            sum += f[static_cast<std::size_t>(k) * stride] * math::cos(math::pi * j * k / n);
        c[j] = (j == 0 || j == n ? 1.0 : 2.0) / n * sum;
    }
    for (int j = 0; j <= n; ++j) f[static_cast<std::size_t>(j) * stride] = c[j];
}

// The polynomial with these coefficients.
template <int n>
double chebyshev_sum(const double* c, double y) {
    double next = 0.0, sum = 0.0;
    for (int k = n; k > 0; --k) {
        const double now = c[k] + 2.0 * y * sum - next;
        next = sum, sum = now;
    }
    return c[0] + y * sum - next;
}

class TangentialTable {
public:
    explicit TangentialTable(const contact::FrictionalContact& contact)
        : contact_(contact), tabulated_(!depends_on_speed(contact)) {}

    TangentialResult operator()(double speed, double slip) {
        const double strength =
            contact_.friction.coefficient * (contact_.mass / contact_.tangential_mass) * speed;
        const double x = strength < math::infinity ? strength / (slip + strength) : 1.0;
        if (!tabulated_ || !(x >= lowest)) return solve_tangential(contact_, speed, slip);
        if (nodes_.empty()) nodes_.resize(1);
        double low = lowest, high = 1.0;
        for (std::size_t at = 0;;) {
            if (nodes_[at].kind == Kind::unknown) fill(at, low, high);
            const Node& node = nodes_[at];
            if (node.kind == Kind::solved) return solve_tangential(contact_, speed, slip);
            if (node.kind == Kind::series) return value(node, x, low, high);
            const double middle = 0.5 * (low + high);
            (x < middle ? high : low) = middle;
            at = node.lower + (x < middle ? 0 : 1);
        }
    }
    bool is_tabulated() const { return tabulated_; }
    const contact::FrictionalContact& contact() const { return contact_; }

private:
    static constexpr int order = 16;
    static constexpr double lowest = 1.0 / (1 << 17), narrowest = 1e-13, tolerance = 1e-12;
    enum class Kind : unsigned char { unknown, halved, series, solved };
    struct Node {
        Kind kind = Kind::unknown;
        bool slid = false;
        std::size_t lower = 0;  // of the two halves
        double c[order] = {};   // of Chebyshev's polynomials
    };

    contact::FrictionalContact contact_;
    bool tabulated_;
    std::vector<Node> nodes_;

    TangentialResult value(const Node& node, double x, double low, double high) const {
        const double y = 2.0 * ((x - low) / (high - low)) - 1.0;
        return limited({x * chebyshev_sum<order - 1>(node.c, y), node.slid}, contact_.friction.stiffness);
    }
    // Chebyshev series through the extrema of the highest polynomial, both ends included.
    void fill(std::size_t at, double low, double high) {
        constexpr int n = order - 1;
        contact::ScaledImpact scaled = contact_.scaled(1.0, 1.0);
        Node node;
        int slipping = 0;
        for (int k = 0; k <= n; ++k) {
            const double x = 0.5 * ((high + low) + (high - low) * math::cos(math::pi * k / n));
            scaled.coefficient = x < 1.0 ? x / (1.0 - x) : math::infinity;
            const TangentialResult r = solve_tangential(scaled);
            node.c[k] = r.gain / x, slipping += r.slid;
        }
        node.slid = 2 * slipping > n;
        to_chebyshev<n>(node.c);
        const double tail = math::abs(node.c[n]) + math::abs(node.c[n - 1]) + math::abs(node.c[n - 2]);
        if (high * tail <= tolerance)
            node.kind = Kind::series;
        else if (high - low > narrowest)
            node.kind = Kind::halved, node.lower = nodes_.size();
        else
            node.kind = Kind::solved;
        nodes_[at] = node;
        if (node.kind == Kind::halved) nodes_.resize(nodes_.size() + 2);
    }
};

}  // namespace hardlimit::boxes
