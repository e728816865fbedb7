// One step of slipping surfaces whose direction of slip relaxes quickly: near F_n = 0, or where the slip is fast, its
// rate h/(μ F_n) would bound the steps of an explicit method. Radau IIA of order 9 (base/radau.hpp), of which only the
// equation of the direction z is implicit:
//   μ F_n dz/dτ = (1 + z²) h_⊥(z)/2,
// which becomes algebraic where F_n = 0. Newton's method solves it at the five nodes. All other components depend on z
// only weakly and follow by iteration.
#pragma once
#include "../../base/radau.hpp"

namespace hardlimit::boxes {

template <class Motion>
class ImplicitSlip {
public:
    // out = y(h) by two steps of half the length. Returns the largest difference from one whole step in units of
    // `scale`, or infinity if the iteration has not converged.
    static double step(const Motion& motion, const double* y, double h, const double* scale, double* out) {
        double whole[n], half[n];
        const bool converged = single(motion, y, h, whole) && single(motion, y, 0.5 * h, half) &&
                               single(motion, half, 0.5 * h, out);
        if (!converged) return math::infinity;
        double largest = 0.0;
        for (int c = 0; c < Motion::turn; ++c) {
            const double difference = math::abs(whole[c] - out[c]) / scale[c];
            if (math::is_nan(difference)) return math::infinity;
            largest = math::max(largest, difference);
        }
        return largest;
    }

private:
    static constexpr int n = Motion::dimension, m = Motion::coupled, stages = Radau::stages;
    static constexpr int most_iterations = 30;

    static bool single(const Motion& motion, const double* y, double h, double* out) {
        double node[stages][n], slope[stages][n];
        motion.slip_rates(y, slope[0]);
        for (int i = 0; i < stages; ++i) {
            double at = 0.0;
            for (int j = 0; j < stages; ++j) at += Radau::a[i][j];
            for (int c = 0; c < n; ++c) node[i][c] = y[c] + at * h * slope[0][c];
        }
        double last = math::infinity;
        for (int round = 0; round < most_iterations; ++round) {
            const double turned = turn_directions(motion, y, h, node, slope);
            const double moved = move_others(y, h, node, slope);
            const double largest = math::max(turned, moved);
            if (!(largest < math::infinity)) return false;
            if (largest < 1e-16 || (largest >= last && largest < 1e-13)) break;
            last = largest;
            if (round == most_iterations - 1) return false;
        }
        for (int c = 0; c < n; ++c) {
            double sum = 0.0;
            for (int j = 0; j < stages; ++j) sum += Radau::a[stages - 1][j] * slope[j][c];
            out[c] = c < m ? node[stages - 1][c] : y[c] + h * sum;
        }
        return true;
    }

    // One step of Newton's method for z at the nodes; computes the slopes of the rest. Returns the largest change of z.
    static double turn_directions(const Motion& motion, const double* y, double h, double (&node)[stages][n],
                                  double (&slope)[stages][n]) {
        double matrix[stages][stages], change[stages];
        for (int i = 0; i < stages; ++i) {
            const double* at = node[i];
            const auto drive = motion.slip_rates(at, slope[i]);
            const double limit = math::max(motion.limit(motion.now(at)), 0.0), z = at[Motion::memory];
            double rate = 0.0;
            for (int j = 0; j < stages; ++j) {
                const double d = Radau::derivative.at[i][j] / h;
                rate += d * (node[j][Motion::memory] - y[Motion::memory]);
                matrix[i][j] = limit * d;
            }
            change[i] = 0.5 * (1.0 + z * z) * drive.across - limit * rate;
            matrix[i][i] += drive.along - z * drive.across;
        }
        Radau::solve(matrix, change);
        double largest = 0.0;
        for (int i = 0; i < stages; ++i) {
            node[i][Motion::memory] += change[i];
            if (!(math::abs(change[i]) <= largest)) largest = math::abs(change[i]);
        }
        return largest;
    }

    // The other components from their slopes. Returns the largest change.
    static double move_others(const double* y, double h, double (&node)[stages][n],
                              const double (&slope)[stages][n]) {
        double largest = 0.0;
        for (int c = 0; c < m; ++c) {
            if (c == Motion::memory || c == Motion::memory + 1) continue;
            for (int i = 0; i < stages; ++i) {
                double sum = 0.0;
                for (int j = 0; j < stages; ++j) sum += Radau::a[i][j] * slope[j][c];
                const double next = y[c] + h * sum;
                const double change = math::abs(next - node[i][c]) / (1.0 + math::abs(next));
                if (!(change <= largest)) largest = change;
                node[i][c] = next;
            }
        }
        return largest;
    }
};

}  // namespace hardlimit::boxes
