// Distance of a triangle from the origin.
#pragma once
#include <array>
#include <cstddef>

#include "../../base/math.hpp"

namespace hardlimit::boxes {

using Vector3 = std::array<double, 3>;  // disks use the first two components

inline double dot(const Vector3& a, const Vector3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

inline Vector3 cross(const Vector3& a, const Vector3& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// Minimum of |corner + t side|² for t in [0, 1].
inline double square_to_segment(const Vector3& corner, const Vector3& side) {
    const double length2 = dot(side, side);
    const double t = length2 > 0.0 ? math::clamp(-dot(corner, side) / length2, 0.0, 1.0) : 0.0;
    const Vector3 at = {corner[0] + t * side[0], corner[1] + t * side[1], corner[2] + t * side[2]};
    return dot(at, at);
}

// Minimum of |corner + t first + u second|² for t, u >= 0 with t + u <= 1. It is on a side, or inside, where the
// gradient vanishes.
inline double square_to_triangle(const Vector3& corner, const Vector3& first, const Vector3& second) {
    Vector3 other, third;
    for (std::size_t k = 0; k < 3; ++k) other[k] = corner[k] + first[k], third[k] = second[k] - first[k];
    const double sides =
        math::min(square_to_segment(corner, first),
                  math::min(square_to_segment(corner, second), square_to_segment(other, third)));
    const double aa = dot(first, first), ab = dot(first, second), bb = dot(second, second);
    const double a = -dot(corner, first), b = -dot(corner, second), det = aa * bb - ab * ab;
    const double t = a * bb - b * ab, u = b * aa - a * ab;
    if (!(det > 0.0 && t > 0.0 && u > 0.0 && t + u < det)) return sides;
    Vector3 inside;
    for (std::size_t k = 0; k < 3; ++k) inside[k] = corner[k] + (t * first[k] + u * second[k]) / det;
    return math::min(sides, dot(inside, inside));
}

}  // namespace hardlimit::boxes
