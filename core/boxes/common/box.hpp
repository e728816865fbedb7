// Simulation box: edges, boundary conditions, gravity, and the motion of walls and periodic images.
#pragma once
#include <cstdint>
#include <vector>

#include "../../base/math.hpp"

namespace hardlimit::boxes {

// Number of a wall in logs and results: −1 − 2·axis at 0, −2 − 2·axis at L; 0: no wall. The second partner of a contact
// is a particle (≥ 0) or a wall (< 0).
struct WallId {
    std::int32_t number = 0;

    static constexpr WallId at(int axis, bool high) { return {-1 - 2 * axis - (high ? 1 : 0)}; }
    // The wall that is the second partner of a contact; no wall if that partner is a particle.
    static constexpr WallId of(i64 second) { return {second < 0 ? static_cast<std::int32_t>(second) : 0}; }
    constexpr explicit operator bool() const { return number < 0; }
    constexpr int axis() const { return (-1 - number) / 2; }
    constexpr bool high() const { return (-1 - number) % 2 != 0; }
    constexpr bool operator==(const WallId&) const = default;
};

enum class Boundary : int {
    none,  // no such axis
    periodic,
    wall,
};

// A wall at rest or with a constant velocity. wall_contact_time() (queue/prediction.hpp) locates collisions with it.
struct Wall {
    WallId id;
    double start;        // coordinate at time 0 [m]
    double speed = 0.0;  // velocity along the axis [m/s]

    constexpr bool moves() const { return speed != 0.0; }
    constexpr double position(double time) const { return moves() ? start + speed * time : start; }
    constexpr double velocity(double /*time*/) const { return speed; }
    // Sign of the inward normal along the axis, and distance of a coordinate inside the box from the wall [m].
    constexpr double inward() const { return id.high() ? -1.0 : 1.0; }
    constexpr double distance(double x, double time) const {
        return id.high() ? position(time) - x : x - position(time);
    }
    // The smallest distance between two times.
    double least_distance(double x, double from, double until) const {
        return math::min(distance(x, from), distance(x, until));
    }
};

// What a periodic image adds to the particle itself: unfolded minus folded position and velocity.
struct ImageMotion {
    double shift[3], velocity[3];  // [m], [m/s]
};

// The box extends from 0 to L along each axis, at time 0 if its walls move.
struct Box {
    int dimension = 3;
    double edge[3] = {};  // L [m]; 0 along an axis that does not exist
    Boundary boundary[3] = {};
    double gravity[3] = {};           // acceleration [m/s²]
    double wall_velocity[3][2] = {};  // along the axis, of the walls at 0 and at L [m/s]

    bool is_periodic(int axis) const { return boundary[axis] == Boundary::periodic; }
    bool has_walls(int axis) const { return boundary[axis] == Boundary::wall; }
    bool any_wall() const { return has_walls(0) || has_walls(1) || has_walls(2); }
    bool falls() const { return gravity[0] != 0.0 || gravity[1] != 0.0 || gravity[2] != 0.0; }
    double volume() const {
        double product = 1.0;
        for (int k = 0; k < dimension; ++k) product *= edge[k];
        return product;
    }

    bool has_moving_walls(int axis) const {
        return wall_velocity[axis][0] != 0.0 || wall_velocity[axis][1] != 0.0;
    }
    // Largest speed of a wall [m/s].
    double fastest_wall() const {
        double most = 0.0;
        for (const auto& axis : wall_velocity)
            for (const double v : axis) most = math::max(most, math::abs(v));
        return most;
    }

    // The wall at one end of an axis that has walls.
    constexpr Wall wall(int axis, bool high) const {
        return {WallId::at(axis, high), high ? edge[axis] : 0.0, wall_velocity[axis][high ? 1 : 0]};
    }
    constexpr Wall wall(WallId id) const { return wall(id.axis(), id.high()); }
    std::vector<Wall> walls() const {
        std::vector<Wall> all;
        for (int axis = 0; axis < dimension; ++axis)
            if (has_walls(axis)) all.push_back(wall(axis, false)), all.push_back(wall(axis, true));
        return all;
    }

    // The image with these flags, one for each axis. A flag counts crossings of the far side (+1) and of the side at 0
    // (−1). Cells, kernels and clusters use only shifts that are constant. A boundary whose images move must be refused
    // in fault_of_sizes() (system_check.hpp) by engines that do not add its velocity there.
    template <class Flags>
    ImageMotion image(const Flags& flags, double /*time*/) const {
        ImageMotion of{};
        for (int k = 0; k < dimension; ++k) of.shift[k] = static_cast<int>(flags[k]) * edge[k];
        return of;
    }
    // Moves a particle that has left through a periodic side, the far one (step 1) or that at 0 (−1), to its image in
    // the box.
    template <class Position, class Velocity, class Flags>
    void wrap(Position& x, Velocity& v, Flags& flags, int axis, int step, double time) const {
        int crossed[3] = {};
        crossed[axis] = step;
        const ImageMotion left = image(crossed, time);
        for (int k = 0; k < dimension; ++k) x[k] -= left.shift[k], v[k] -= left.velocity[k];
        flags[axis] += step;
    }
    // Minimum image of a coordinate difference along a periodic axis [m].
    double minimum_image(double distance, int axis) const {
        return distance - edge[axis] * math::round_small(distance / edge[axis]);
    }
    // Folds an unfolded coordinate into the box [m].
    double folded(double x, int axis) const {
        if (!is_periodic(axis)) return x;
        x = minimum_image(x, axis);
        return x < 0.0 ? math::min(x + edge[axis], edge[axis]) : x;
    }
};

HL_FN int floor_to_int(double x) {
    const int toward_zero = static_cast<int>(x);
    return toward_zero - (x < toward_zero ? 1 : 0);
}

template <int d>
double dot(const double (&a)[d], const double (&b)[d]) {
    double sum = a[0] * b[0];
    for (int k = 1; k < d; ++k) sum += a[k] * b[k];
    return sum;
}

}  // namespace hardlimit::boxes
