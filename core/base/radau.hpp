// One step of the implicit Runge-Kutta method Radau IIA of order 9 for an autonomous system dy/dτ = f(y): for slow
// motion of a stiff system, where stability would bound the step of an explicit method.
//   Y_i = y + h Σ_j a_ij f(Y_j),  y(h) = Y_5,   with Σ_j a_ij c_j^(k−1) = c_i^k/k for k = 1 … 5.
// The nodes c are the zeros of P_5(2c − 1) − P_4(2c − 1). L-stable: what decays quickly is gone after one step.
// The stages are found by Newton's method with the Jacobian at y. Source: Hairer & Wanner, Solving Ordinary
// Differential Equations II (2nd ed., 1996), Sec. IV.5, IV.8.
//
// There is no interpolant, as in dormand_prince.hpp: a state inside a step is the end of a shorter one.
#pragma once
#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "math.hpp"

namespace hardlimit {

class Radau {
public:
    static constexpr int stages = 5;
    static constexpr double a[stages][stages] = {
        {0.072998864317903324306, -0.026735331107945571878, 0.018676929763984354412, -0.012879106093306439854,
         0.0050428392338820152067},
        {0.15377523147918246867, 0.14621486784749350665, -0.036444568905128089527, 0.021233063119304719422,
         -0.0079355799027287775326},
        {0.14006304568480987151, 0.2989671294912834794, 0.16758507013524896344, -0.033969101686617746572,
         0.010944288744192252274},
        {0.14489430810953475754, 0.27650006876015922756, 0.32579792291042102998, 0.12875675325490976116,
         -0.015708917378805328388},
        {0.14371356079122594132, 0.28135601514946206019, 0.31182652297574125408, 0.2231039010835707444, 0.04},
    };

    struct Matrix {
        double at[stages][stages];
    };
    // The derivative at the nodes of the polynomial through 0 and its values there: the inverse of a.
    static constexpr Matrix derivative = [] {
        Matrix rest{}, inverse{};
        for (int i = 0; i < stages; ++i)
            for (int j = 0; j < stages; ++j) rest.at[i][j] = a[i][j], inverse.at[i][j] = i == j;
        for (int k = 0; k < stages; ++k) {
            const double pivot = rest.at[k][k];
            for (int j = 0; j < stages; ++j) rest.at[k][j] /= pivot, inverse.at[k][j] /= pivot;
            for (int i = 0; i < stages; ++i) {
                const double factor = rest.at[i][k];
                if (i == k) continue;
                for (int j = 0; j < stages; ++j)
                    rest.at[i][j] -= factor * rest.at[k][j], inverse.at[i][j] -= factor * inverse.at[k][j];
            }
        }
        return inverse;
    }();
    // Solves m x = b for one unknown at each node, in place of b; m is lost.
    static void solve(double (&m)[stages][stages], double (&x)[stages]) {
        for (int k = 0; k < stages; ++k) {
            int best = k;
            for (int i = k + 1; i < stages; ++i)
                if (math::abs(m[i][k]) > math::abs(m[best][k])) best = i;
            std::swap(m[k], m[best]);
            std::swap(x[k], x[best]);
            for (int i = k + 1; i < stages; ++i) {
                const double factor = m[i][k] / m[k][k];
                for (int j = k + 1; j < stages; ++j) m[i][j] -= factor * m[k][j];
                x[i] -= factor * x[k];
            }
        }
        for (int k = stages - 1; k >= 0; --k) {
            for (int j = k + 1; j < stages; ++j) x[k] -= m[k][j] * x[j];
            x[k] /= m[k][k];
        }
    }

    // out = y(h) for n components. f depends on the first `coupled` only; `unit` [coupled] are the units of their
    // changes. Returns whether Newton's method has converged. `out` must not alias `y`.
    template <class Rhs>
    bool step(const Rhs& f, const double* y, double h, int n, int coupled, const double* unit, double* out) {
        return step(Slope{&f, [](const void* rhs, const double* at,
                                 double* slope) { (*static_cast<const Rhs*>(rhs))(at, slope); }},
                    y, h, n, coupled, unit, out);
    }

    // Factor for the next step, from the difference to two steps of half the length in units of the tolerance.
    static double growth(double error) {
        if (!math::is_finite(error)) return 0.1;
        if (error < 1e-8) return 6.0;
        return math::clamp(0.9 * math::exp(-0.1 * math::log(error)), 0.1, 6.0);
    }

private:
    // f with its type erased: one copy of the code for all right-hand sides.
    struct Slope {
        const void* rhs;
        void (*call)(const void* rhs, const double* at, double* slope);
        void operator()(const double* at, double* slope) const { call(rhs, at, slope); }
    };

    int n_ = 0, m_ = 0;
    std::vector<double> jacobian_;  // [m × m] in units of the components
    std::vector<double> matrix_;    // [5m × 5m] 1 − h a ⊗ J, factorized
    std::vector<int> pivot_;        // [5m]
    std::vector<double> z_;         // [5 × m] stages less y, in units
    std::vector<double> change_;    // [5 × m]
    std::vector<double> slope_;     // [5 × n] f at the stages
    std::vector<double> at_, there_;

    bool step(const Slope& f, const double* y, double h, int n, int coupled, const double* unit,
              double* out) {
        resize(n, coupled);
        linearize(f, y, unit);
        factorize(h);
        const bool converged = solve_stages(f, y, h, unit);
        evaluate(f, y, unit);
        for (int c = 0; c < n; ++c) {
            double sum = 0.0;
            for (int i = 0; i < stages; ++i) sum += a[stages - 1][i] * slope_[i * n + c];
            out[c] = y[c] + (c < m_ ? unit[c] * z_[(stages - 1) * m_ + c] : h * sum);
        }
        return converged;
    }

    void resize(int n, int m) {
        n_ = n;
        m_ = m;
        const auto size = static_cast<std::size_t>(stages * m);
        jacobian_.resize(static_cast<std::size_t>(m) * static_cast<std::size_t>(m));
        matrix_.resize(size * size);
        pivot_.resize(size);
        z_.assign(size, 0.0);
        change_.resize(size);
        slope_.resize(static_cast<std::size_t>(stages * n));
        at_.resize(static_cast<std::size_t>(n));
        there_.resize(static_cast<std::size_t>(n));
    }

    // Jacobian by finite differences, which is accurate enough for Newton's method.
    void linearize(const Slope& f, const double* y, const double* unit) {
        std::copy(y, y + n_, at_.begin());
        f(at_.data(), slope_.data());
        for (int c = 0; c < m_; ++c) {
            const double difference = 1.5e-8 * unit[c];
            at_[c] = y[c] + difference;
            f(at_.data(), there_.data());
            const double exact = (at_[c] - y[c]) / unit[c];
            for (int r = 0; r < m_; ++r) jacobian_[r * m_ + c] = (there_[r] - slope_[r]) / (exact * unit[r]);
            at_[c] = y[c];
        }
    }

    double& element(int row, int column) { return matrix_[row * stages * m_ + column]; }

    void factorize(double h) {
        const int size = stages * m_;
        for (int row = 0; row < size; ++row)
            for (int column = 0; column < size; ++column)
                element(row, column) = (row == column ? 1.0 : 0.0) -
                                       h * a[row / m_][column / m_] * jacobian_[row % m_ * m_ + column % m_];
        for (int k = 0; k < size; ++k) {
            int best = k;
            for (int row = k + 1; row < size; ++row)
                if (math::abs(element(row, k)) > math::abs(element(best, k))) best = row;
            pivot_[k] = best;
            if (best != k)
                for (int column = 0; column < size; ++column)
                    std::swap(element(k, column), element(best, column));
            for (int row = k + 1; row < size; ++row) {
                const double factor = element(row, k) /= element(k, k);
                if (factor == 0.0) continue;
                for (int column = k + 1; column < size; ++column)
                    element(row, column) -= factor * element(k, column);
            }
        }
    }

    void solve(std::vector<double>& x) {
        const int size = stages * m_;
        for (int k = 0; k < size; ++k) std::swap(x[k], x[pivot_[k]]);
        for (int row = 1; row < size; ++row)
            for (int column = 0; column < row; ++column) x[row] -= element(row, column) * x[column];
        for (int row = size - 1; row >= 0; --row) {
            for (int column = row + 1; column < size; ++column) x[row] -= element(row, column) * x[column];
            x[row] /= element(row, row);
        }
    }

    void evaluate(const Slope& f, const double* y, const double* unit) {
        for (int i = 0; i < stages; ++i) {
            std::copy(y, y + n_, at_.begin());
            for (int c = 0; c < m_; ++c) at_[c] += unit[c] * z_[i * m_ + c];
            f(at_.data(), slope_.data() + i * n_);
        }
    }

    // Iterates down to rounding, where the changes no longer decrease.
    bool solve_stages(const Slope& f, const double* y, double h, const double* unit) {
        double last = math::infinity;
        for (int round = 0; round < 12; ++round) {
            evaluate(f, y, unit);
            for (int i = 0; i < stages; ++i) {
                for (int c = 0; c < m_; ++c) {
                    double sum = 0.0;
                    for (int j = 0; j < stages; ++j) sum += a[i][j] * slope_[j * n_ + c];
                    change_[i * m_ + c] = h * sum / unit[c] - z_[i * m_ + c];
                }
            }
            solve(change_);
            double largest = 0.0;
            for (std::size_t k = 0; k < z_.size(); ++k) {
                z_[k] += change_[k];
                if (!(math::abs(change_[k]) <= largest)) largest = math::abs(change_[k]);
            }
            if (!(largest < last)) break;
            last = largest;
            if (last < 1e-17) break;
        }
        return last < 1e-11;
    }
};

}  // namespace hardlimit
