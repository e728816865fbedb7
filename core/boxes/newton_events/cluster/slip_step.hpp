// One step of a cluster in which directions of slip relax quickly, by Radau IIA of order 9 (base/radau.hpp). As in one
// contact (binary_contact/implicit_slip.hpp), only the equations of the directions z are implicit, and they become
// algebraic where F_n = 0. All other components depend on z only weakly, and follow by iteration.
#pragma once
#include <utility>
#include <vector>

#include "../../../base/radau.hpp"
#include "equations.hpp"

namespace hardlimit::boxes {

// Working storage, used again by every step.
struct SlipStages {
    std::vector<int> pairs;           // whose directions are implicit
    std::vector<double> node, slope;  // [5 × components]
    std::vector<double> whole, half;  // ends of steps
};

template <FrictionalLaw Law>
class SlipStep {
public:
    // Units of the changes: `tolerance`, infinite where a component has none.
    SlipStep(const Equations<Law>& f, const double* tolerance, SlipStages& stages)
        : f_(f), tolerance_(tolerance), at_(stages), n_(f.layout.size()), coupled_(f.layout.virial()) {
        at_.pairs.clear();
        for (int q = 0; q < static_cast<int>(f.network.pairs.size()); ++q)
            if (f.turns(q)) at_.pairs.push_back(q);
        const auto size = static_cast<std::size_t>(n_);
        for (auto* x : {&at_.node, &at_.slope}) x->resize(Radau::stages * size);
        for (auto* x : {&at_.whole, &at_.half}) x->resize(size);
        turning_.resize(Radau::stages * at_.pairs.size());
    }

    // out = y(h) by two steps of half the length. Returns the largest difference from one whole step in units of the
    // tolerance, or infinity if the iteration has not converged.
    double take(const double* y, double h, double* out) {
        const bool converged = single(y, h, at_.whole.data()) && single(y, 0.5 * h, at_.half.data()) &&
                               single(at_.half.data(), 0.5 * h, out);
        if (!converged) return math::infinity;
        double largest = 0.0;
        for (int c = 0; c < coupled_; ++c) {
            const double difference = math::abs(at_.whole[c] - out[c]) / tolerance_[c];
            if (math::is_nan(difference)) return math::infinity;
            largest = math::max(largest, difference);
        }
        return largest;
    }

private:
    static constexpr int most_rounds = 30;
    static constexpr std::size_t most_idle = 6;
    static constexpr double little = 1e-2;  // change with which the iteration ends, in units of the tolerance

    const Equations<Law>& f_;
    const double* tolerance_;
    SlipStages& at_;
    const int n_, coupled_;
    std::vector<typename SurfacesNow<Law>::Turning> turning_;  // [5 × pairs]

    double* node(int i) { return &at_.node[static_cast<std::size_t>(i * n_)]; }
    double* slope(int i) { return &at_.slope[static_cast<std::size_t>(i * n_)]; }
    int direction(int pair) const { return f_.layout.surface(pair) + 3; }

    bool single(const double* y, double h, double* out) {
        f_(y, slope(0));
        for (const int q : at_.pairs) slope(0)[direction(q)] = 0.0;
        for (int i = Radau::stages - 1; i >= 0; --i) {
            double part = 0.0;
            for (int j = 0; j < Radau::stages; ++j) part += Radau::a[i][j];
            for (int c = 0; c < n_; ++c) node(i)[c] = y[c] + part * h * slope(0)[c];
        }
        double last = math::infinity;
        for (int round = 0;; ++round) {
            const std::size_t count = at_.pairs.size();
            for (std::size_t i = 0; i < Radau::stages; ++i) {
                f_(node(static_cast<int>(i)), slope(static_cast<int>(i)));
                std::copy_n(f_.surfaces.turning.begin(), count, &turning_[i * count]);
            }
            double largest = 0.0;
            for (std::size_t k = 0; k < count; ++k) largest = math::max(largest, turn(k, y, h));
            largest = math::max(largest, move_others(y, h));
            if (!(largest < math::infinity)) return false;
            if (round == most_rounds) {
                if (largest < 10.0 * little) break;  // rounding of the forces
                return false;
            }
            if (largest < little && (largest < 1e-4 * little || largest >= 0.1 * last)) break;
            last = largest;
        }
        for (int c = 0; c < n_; ++c) {
            double sum = 0.0;
            for (int j = 0; j < Radau::stages; ++j) sum += Radau::a[Radau::stages - 1][j] * slope(j)[c];
            out[c] = c < coupled_ ? node(Radau::stages - 1)[c] : y[c] + h * sum;
        }
        return true;
    }

    // One step of Newton's method for the direction of the kth pair at the nodes. Returns the largest change.
    double turn(std::size_t k, const double* y, double h) {
        double matrix[Radau::stages][Radau::stages], change[Radau::stages];
        const int z = direction(at_.pairs[k]);
        for (int i = 0; i < Radau::stages; ++i) {
            const auto& turning = turning_[static_cast<std::size_t>(i) * at_.pairs.size() + k];
            const auto& drive = turning.drive;
            const double limit = math::max(turning.limit, 0.0), at = node(i)[z];
            double rate = 0.0;
            for (int j = 0; j < Radau::stages; ++j) {
                const double d = Radau::derivative.at[i][j] / h;
                rate += d * (node(j)[z] - y[z]);
                matrix[i][j] = limit * d;
            }
            change[i] = 0.5 * (1.0 + at * at) * drive.across - limit * rate;
            const double pull = drive.along - at * drive.across;
            // A second contact that begins at the same instant keeps its direction. Where many do, their events take
            // steps without end, and the run ends here.
            const bool idle = limit == 0.0 && pull == 0.0 && at_.pairs.size() <= most_idle;
            matrix[i][i] += idle ? 1.0 : pull;
        }
        Radau::solve(matrix, change);
        double largest = 0.0;
        for (int i = 0; i < Radau::stages; ++i) {
            node(i)[z] += change[i];
            const double size = math::abs(change[i]) / tolerance_[z];
            if (!(size <= largest)) largest = size;
        }
        return largest;
    }

    // The other components from their slopes. Returns the largest change.
    double move_others(const double* y, double h) {
        double largest = 0.0;
        for (int c = 0; c < coupled_; ++c) {
            if (is_direction(c)) continue;
            for (int i = 0; i < Radau::stages; ++i) {
                double sum = 0.0;
                for (int j = 0; j < Radau::stages; ++j) sum += Radau::a[i][j] * slope(j)[c];
                const double next = y[c] + h * sum, size = math::abs(next - node(i)[c]) / tolerance_[c];
                if (!(size <= largest)) largest = size;
                node(i)[c] = next;
            }
        }
        return largest;
    }
    bool is_direction(int component) const {
        for (const int q : at_.pairs)
            if (direction(q) == component) return true;
        return false;
    }
};

}  // namespace hardlimit::boxes
