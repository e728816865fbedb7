// Program for test_newton_events.py: compares the distances of random triangles from the origin with the nearest of
// many of their points. Prints the number of triangles, and the largest amounts by which the nearest point is closer
// and farther, in units of the size of the triangle.
#include "boxes/common/triangle.hpp"

#include <cmath>
#include <cstdio>
#include <random>

int main() {
    using hardlimit::boxes::Vector3;
    std::mt19937 engine(1);
    std::normal_distribution<double> normal(0.0, 1.0);
    constexpr int triangles = 2000, points = 200;
    double nearer = 0.0, farther = 0.0;
    for (int i = 0; i < triangles; ++i) {
        const double place = std::pow(10.0, i % 3 - 1), thin = i % 5 == 0 ? 1e-6 : 1.0;
        Vector3 corner, first, second;
        for (std::size_t k = 0; k < 3; ++k) {
            corner[k] = place * normal(engine);
            first[k] = normal(engine);
            second[k] = i % 7 == 0 ? 0.3 * first[k] : thin * normal(engine);
        }
        const double found = std::sqrt(hardlimit::boxes::square_to_triangle(corner, first, second));
        double best = INFINITY, side = 0.0;
        for (int a = 0; a <= points; ++a)
            for (int b = 0; a + b <= points; ++b) {
                double square = 0.0;
                for (std::size_t k = 0; k < 3; ++k) {
                    const double x = corner[k] + (a * first[k] + b * second[k]) / points;
                    square += x * x;
                }
                best = std::fmin(best, std::sqrt(square));
            }
        for (std::size_t k = 0; k < 3; ++k) side += first[k] * first[k] + second[k] * second[k];
        side = std::sqrt(side);
        nearer = std::fmax(nearer, (found - best) / side);
        farther = std::fmax(farther, (best - found) / side);
    }
    std::printf("%d %g %g\n", triangles, nearer, farther);
}
