// 1 + β of exact contacts with a fixed normal that depend on two numbers, from a table; beside tangential_table.hpp.
//
// The first number is x = M/(1 + M) there. The second, y, is the speed, or for contacts that are alike but for their
// damping (k_t and γ_t in proportion to the stiffness and damping of the normal force) the scaled damping of the normal
// force: then pairs of all sizes have the same table. Each octave of y has a tree of cells that are halved in x or in y
// until polynomials of degree 12 in x and 6 in y (Chebyshev) have converged: the smallest are those at kinks. A cell is
// filled when a collision first falls into it, with 91 contacts; its numbers do not depend on the order of the
// collisions. In a cell that may not be halved in x again, and at x < 2^-17, the contact itself is solved. The error of
// β is below 1e-7 but in cells that a kink touches unseen, where up to 1e-6 was seen.
#pragma once
#include <array>
#include <map>

#include "tangential_table.hpp"

namespace hardlimit::boxes {

// Contacts that differ by one number.
class ContactFamily {
public:
    // Whether k_t and γ_t are in proportion to the stiffness and damping of the normal force.
    static bool is_proportional(const contact::FrictionalContact& c) {
        const FrictionTerms& f = c.friction;
        return (f.stiffness.factor == 0.0 || f.stiffness.power == c.powers.elastic - 4) &&
               (f.damping.factor == 0.0 || f.damping.power == c.powers.damping);
    }
    explicit ContactFamily(const contact::FrictionalContact& c)
        : contact_(c), by_damping_(is_proportional(c)), base_(c.scaled(1.0, 1.0)) {
        const double damping = base_.normal_damping;
        damping_ratio_ = damping > 0.0 ? rounded(base_.damping.factor / damping) : 0.0;
        if (by_damping_) base_.stiffness.factor = rounded(base_.stiffness.factor);
    }
    // Contacts of one family have the same: pairs of all sizes, or this pair only.
    std::array<double, 3> key(const PairGeometry& pair, double rotational_ratio) const {
        if (by_damping_) return {base_.stiffness.factor, damping_ratio_, -1.0};
        return {pair.effective_mass, pair.effective_radius, rotational_ratio};
    }
    // y at this speed.
    double coordinate(double speed) const {
        if (!by_damping_) return speed;
        return is_damped() ? contact_.scaled(speed, 1.0).normal_damping : 1.0;
    }
    contact::ScaledImpact at(double y) const {
        if (!by_damping_) return contact_.scaled(y, 1.0);
        contact::ScaledImpact scaled = base_;
        if (is_damped()) scaled.normal_damping = y, scaled.damping.factor = damping_ratio_ * y;
        return scaled;
    }
    const PowerTerm& stiffness() const { return contact_.friction.stiffness; }

private:
    contact::FrictionalContact contact_;
    bool by_damping_;
    contact::ScaledImpact base_;
    double damping_ratio_;

    bool is_damped() const { return base_.normal_damping > 0.0; }
    // To 2^-32, so that pairs whose numbers differ by rounding are of one family.
    static double rounded(double x) {
        return real_of<double>((bits_of<double>(x) + (1ULL << 19)) >> 20 << 20);
    }
};

class TangentialSurface {
public:
    explicit TangentialSurface(const ContactFamily& family) : family_(family) {}

    // NaN if this contact is to be solved.
    TangentialResult operator()(double x, double y) {
        const u64 bits = bits_of<double>(y);
        std::vector<Cell>& cells = octaves_[static_cast<int>(bits >> 52)];
        if (cells.empty()) cells.resize(1);
        Range at_x{lowest, 1.0}, at_y{real_of<double>(bits >> 52 << 52), 0.0};
        at_y.high = 2.0 * at_y.low;
        for (std::size_t at = 0;;) {
            if (cells[at].kind == Kind::unknown) fill(cells, at, at_x, at_y);
            const Cell& cell = cells[at];
            if (cell.kind == Kind::solved) return {math::nan, false};
            if (cell.kind == Kind::series)
                return limited({x * value(cell, at_x.scaled(x), at_y.scaled(y)), cell.slid},
                               family_.stiffness());
            const bool upper = cell.kind == Kind::halved_in_x ? at_x.halve(x) : at_y.halve(y);
            at = cell.part + upper;
        }
    }
    static bool covers(double x, double y) { return x >= lowest && y > 1e-300 && y < 1e300; }

private:
    static constexpr int n = 12, m = 6;
    static constexpr double lowest = 1.0 / (1 << 17), narrowest_x = 1.0 / 256, narrowest_y = 1.0 / 128,
                            tolerance = 1e-7;
    enum class Kind : unsigned char { unknown, halved_in_x, halved_in_y, series, solved };
    struct Cell {
        Kind kind = Kind::unknown;
        bool slid = false;
        std::size_t part = 0;  // of two halves the lower; of a series its place
    };
    struct Range {
        double low, high;
        double scaled(double x) const { return 2.0 * ((x - low) / (high - low)) - 1.0; }
        double node(double cosine) const { return 0.5 * ((high + low) + (high - low) * cosine); }
        // To the half that x is in; whether that is the upper one.
        bool halve(double x) {
            const double middle = 0.5 * (low + high);
            (x < middle ? high : low) = middle;
            return !(x < middle);
        }
    };
    struct Series {
        double c[m + 1][n + 1];
    };

    ContactFamily family_;
    std::map<int, std::vector<Cell>> octaves_;
    std::vector<Series> series_;

    double value(const Cell& cell, double x, double y) const {
        double c[m + 1];
        for (int j = 0; j <= m; ++j) c[j] = chebyshev_sum<n>(series_[cell.part].c[j], x);
        return chebyshev_sum<m>(c, y);
    }
    void fill(std::vector<Cell>& cells, std::size_t at, Range x, Range y) {
        Series of;
        int slipping = 0;
        for (int j = 0; j <= m; ++j) {
            contact::ScaledImpact scaled = family_.at(y.node(math::cos(math::pi * j / m)));
            for (int k = 0; k <= n; ++k) {
                const double xk = x.node(math::cos(math::pi * k / n));
                scaled.coefficient = xk < 1.0 ? xk / (1.0 - xk) : math::infinity;
                const TangentialResult r = solve_tangential(scaled);
                of.c[j][k] = r.gain / xk, slipping += r.slid;
            }
            to_chebyshev<n>(of.c[j]);
        }
        for (int k = 0; k <= n; ++k) to_chebyshev<m>(&of.c[0][k], n + 1);
        double tail_x = 0.0, tail_y = 0.0;
        for (const auto& row : of.c)
            for (int k = n - 2; k <= n; ++k) tail_x += math::abs(row[k]);
        for (int j = m - 1; j <= m; ++j)
            for (const double c : of.c[j]) tail_y += math::abs(c);
        Cell cell;
        cell.slid = 2 * slipping > (m + 1) * (n + 1);
        if (x.high * math::max(tail_x, tail_y) <= tolerance) {
            cell.kind = Kind::series, cell.part = series_.size();
            series_.push_back(of);
        } else if (!(x.high - x.low > narrowest_x)) {
            cell.kind = Kind::solved;
        } else {
            const bool may_halve_y = y.high - y.low > narrowest_y * y.low;
            cell.kind = tail_x >= tail_y || !may_halve_y ? Kind::halved_in_x : Kind::halved_in_y;
            cell.part = cells.size();
        }
        cells[at] = cell;
        if (cell.kind < Kind::series) cells.resize(cells.size() + 2);
    }
};

// β of the contacts of a box for which there is no TangentialTable.
class TangentialSurfaces {
public:
    // A table costs as much as some ten thousand contacts: the first collisions of a box are solved.
    static constexpr u64 without_table = 30000;

    TangentialResult operator()(const contact::FrictionalContact& c, const PairGeometry& pair,
                                double rotational_ratio, double speed, double slip, u64 collisions) {
        const contact::ScaledImpact scaled = c.scaled(speed, slip);
        const double x =
            scaled.coefficient < math::infinity ? scaled.coefficient / (1.0 + scaled.coefficient) : 1.0;
        if (collisions >= without_table && !contact::LinearImpact::solves(scaled)) {  // that is fast
            const ContactFamily family(c);
            const double y = family.coordinate(speed);
            if (TangentialSurface::covers(x, y)) {
                const auto key = family.key(pair, rotational_ratio);
                const TangentialResult r = surfaces_.try_emplace(key, family).first->second(x, y);
                if (r.gain == r.gain) return r;
            }
        }
        return limited(solve_tangential(scaled), c.friction.stiffness);
    }

private:
    std::map<std::array<double, 3>, TangentialSurface> surfaces_;
};

}  // namespace hardlimit::boxes
