// Polynomial interpolation of several functions at once over a square or cube, from as many points as terms.
//
// The points are a grid of Leja points whose indices add up to at most `degree`. Each Leja point maximizes the product
// of its distances from those before it. They are scaled down slightly, because not every function has a value on the
// edge. Divided differences along one axis after the other give Newton's form of the unique polynomial of this total
// degree through all values.
#pragma once
#include "../../base/math.hpp"

namespace hardlimit::boxes {

// Four or eight functions of `dims` variables x in [−1, 1], as polynomials of total degree `degree`.
template <int dims, int degree, int width = 4>
class PolynomialCell {
    static_assert((dims == 2 || dims == 3) && degree <= 10);

public:
    static constexpr int dimensions = dims, functions = width, side = degree + 1;
    static constexpr int grid = dims == 2 ? side * side : side * side * side;
    using Values = typename Vector<functions>::Real;

    // Whether point i of the grid is used, and its coordinates. The first variable runs fastest.
    static bool wanted(int i) { return index_sum(i) <= degree; }
    static double coordinate(int i, int dim) { return leja[digit(i, dim)]; }

    // Interpolates the values [grid] at the used points, and overwrites them.
    static PolynomialCell through(Values* values) {
        for (int d = 0; d < dims; ++d) for_each_line(values, d, divided_differences);
        for (int d = 0; d < dims; ++d) for_each_line(values, d, powers);
        PolynomialCell cell;
        int next = 0;
        for (int i = 0; i < grid; ++i) {
            if (wanted(i)) cell.terms_[next++] = values[i];
        }
        return cell;
    }

    Values operator()(const double* x) const {
        const Values* term = terms_;
        if constexpr (dims == 2) return plane<degree>(term, x);
        Values part[side];
        planes<0>(term, x, part);
        return horner<degree>(part, x[dims - 1]);
    }

private:
    static constexpr double leja[11] = {0.0,     0.98,     -0.98,   0.56546, -0.64582, 0.82222,
                                        -0.8526, -0.29988, 0.31556, 0.92414, -0.93394};
    static constexpr int count = dims == 2 ? side * (side + 1) / 2 : side * (side + 1) * (side + 2) / 6;
    alignas(sizeof(Values)) Values terms_[count];  // same alignment on every processor: kernels read it

    static int digit(int i, int dim) {
        for (int d = 0; d < dim; ++d) i /= side;
        return i % side;
    }
    static int index_sum(int i) {
        int sum = 0;
        for (int d = 0; d < dims; ++d) sum += digit(i, d);
        return sum;
    }

    // Applies change(line, top) to the values on each line of used points along one axis; top: the last index.
    template <class Change>
    static void for_each_line(Values* values, int dim, const Change& change) {
        int stride = 1;
        for (int d = 0; d < dim; ++d) stride *= side;
        for (int start = 0; start < grid; ++start) {
            if (digit(start, dim) != 0 || !wanted(start)) continue;
            const int top = degree - index_sum(start);
            Values line[side];
            for (int k = 0; k <= top; ++k) line[k] = values[start + k * stride];
            change(line, top);
            for (int k = 0; k <= top; ++k) values[start + k * stride] = line[k];
        }
    }
    static void divided_differences(Values* line, int top) {
        for (int j = 1; j <= top; ++j) {
            for (int k = top; k >= j; --k) line[k] = (line[k] - line[k - 1]) / (leja[k] - leja[k - j]);
        }
    }
    // Converts Newton's form to powers of x.
    static void powers(Values* line, int top) {
        for (int k = top - 1; k >= 0; --k) {
            for (int j = k; j < top; ++j) line[j] -= leja[k] * line[j + 1];
        }
    }

    template <int top>
    static Values horner(const Values* a, double x) {
        Values sum = a[top];
        HL_UNROLL
        for (int i = top - 1; i >= 0; --i) sum = sum * x + a[i];
        return sum;
    }
    // Σ x_1^i x_0^j over i + j <= top, stored by i. Advances `term` past these terms.
    template <int top>
    static Values plane(const Values*& term, const double* x) {
        Values row[top + 1];
        rows<top, 0>(term, x[0], row);
        return horner<top>(row, x[1]);
    }
    template <int top, int i>
    static void rows(const Values*& term, double x, Values* row) {
        if constexpr (i <= top) {
            row[i] = horner<top - i>(term, x);
            term += top - i + 1;
            rows<top, i + 1>(term, x, row);
        }
    }
    // Coefficients of x_2^i.
    template <int i>
    static void planes(const Values*& term, const double* x, Values* part) {
        if constexpr (i <= degree) {
            part[i] = plane<degree - i>(term, x);
            planes<i + 1>(term, x, part);
        }
    }
};

// Cells of eight functions are also evaluated by kernels, compiled once for each instruction set.
using WideCell = PolynomialCell<2, 8, 8>;
inline void read_wide_cell(const void* cell, const double* x, double* values) {
    store_lanes(values, (*static_cast<const WideCell*>(cell))(x));
}

}  // namespace hardlimit::boxes
