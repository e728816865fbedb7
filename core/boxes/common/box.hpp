// Simulation box: edges, boundary conditions, gravity, and the motion of walls and periodic images.
#pragma once
#include <cstdint>
#include <vector>

#include "../../base/math.hpp"
#include "wall.hpp"

namespace hardlimit::boxes {

enum class Boundary : int {
    none,  // no such axis
    periodic,
    wall,
    lees_edwards,  // the images along this axis slide along the first one
};

// What a periodic image adds to the particle itself: unfolded minus folded position and velocity.
struct ImageMotion {
    double shift[3], velocity[3];  // [m], [m/s]
};

// The box extends from 0 to L along each axis; these are the rest places of walls that move.
struct Box {
    int dimension = 3;
    double edge[3] = {};  // L [m]; 0 along an axis that does not exist
    Boundary boundary[3] = {};
    double gravity[3] = {};             // acceleration [m/s²]
    WallMotion wall_motion[3][2] = {};  // of the walls at 0 and at L
    bool walls_move[3] = {};            // whether one of the two moves
    // Lees–Edwards boundary (J. Phys. C 5, 1921 (1972)): mean flow v_x = shear rate · (y − L/2) along the first axis,
    // which is periodic. The images beyond the far side of the gradient axis y move with shear rate · L.
    int gradient = 0;                 // axis of the gradient; 0: no such boundary
    double shear_rate = 0.0;          // [1/s]
    double shear_displacement = 0.0;  // of the images beyond the far side, along the first axis at time 0 [m]

    // Whether the images along an axis are at rest.
    bool is_periodic(int axis) const { return boundary[axis] == Boundary::periodic; }
    // Whether a particle that leaves through one side comes back through the other.
    bool wraps(int axis) const { return is_periodic(axis) || boundary[axis] == Boundary::lees_edwards; }
    bool is_sheared() const { return boxes_move && gradient != 0; }
    // Whether the images along an axis slide along the first one.
    bool slides(int axis) const { return is_sheared() && axis == gradient; }
    bool has_walls(int axis) const { return boundary[axis] == Boundary::wall; }
    bool any_wall() const { return has_walls(0) || has_walls(1) || has_walls(2); }
    bool falls() const { return gravity[0] != 0.0 || gravity[1] != 0.0 || gravity[2] != 0.0; }
    double volume() const {
        double product = 1.0;
        for (int k = 0; k < dimension; ++k) product *= edge[k];
        return product;
    }

    bool has_moving_walls(int axis) const { return boxes_move && walls_move[axis]; }
    void move_wall(WallId id, const WallMotion& motion) {
        wall_motion[id.axis()][id.high()] = motion;
        walls_move[id.axis()] = walls_move[id.axis()] || motion.moves() || motion.offset != 0.0;
    }
    void stop_walls() {
        for (auto& axis : wall_motion) axis[0] = axis[1] = {};
        for (bool& moves : walls_move) moves = false;
    }
    // The largest value of f(motion) of all walls.
    template <class F>
    double most_of_walls(const F& f) const {
        double most = 0.0;
        for (const auto& axis : wall_motion)
            for (const WallMotion& m : axis) most = math::max(most, f(m));
        return most;
    }
    // Largest speed of a wall [m/s], and largest acceleration, without jumps of the velocity [m/s²].
    double fastest_wall() const {
        return most_of_walls([](const WallMotion& m) { return math::abs(m.velocity) + m.fastest(); });
    }
    // Bound on the distance of a wall from its rest place up to a time [m].
    double farthest_wall(double time) const {
        return most_of_walls([=](const WallMotion& m) {
            return math::abs(m.offset) + m.amplitude + math::abs(m.velocity) * time;
        });
    }

    // The wall at one end of an axis that has walls.
    Wall wall(int axis, bool high) const {
        return {WallId::at(axis, high), high ? edge[axis] : 0.0, wall_motion[axis][high ? 1 : 0]};
    }
    Wall wall(WallId id) const { return wall(id.axis(), id.high()); }
    std::vector<Wall> walls() const {
        std::vector<Wall> all;
        for (int axis = 0; axis < dimension; ++axis)
            if (has_walls(axis)) all.push_back(wall(axis, false)), all.push_back(wall(axis, true));
        return all;
    }

    void shear(int axis, double rate, double displacement) {
        gradient = axis, shear_rate = rate, shear_displacement = displacement;
    }
    // Velocity of the images beyond the far side of a sheared box [m/s], and their displacement [m], both along the
    // first axis.
    double image_velocity() const { return shear_rate * edge[gradient]; }
    double image_displacement(double time) const { return shear_displacement + image_velocity() * time; }
    // The same displacement in [0, L] of the first axis.
    double image_offset(double time) const {
        const double displaced = image_displacement(time);
        return math::clamp(displaced - edge[0] * math::floor_small(displaced / edge[0]), 0.0, edge[0]);
    }
    // Velocity of the mean flow at a position [m/s]; 0 without shear.
    template <class Position>
    double mean_flow(const Position& x) const {
        if (!is_sheared()) return 0.0;
        return shear_rate * (x[static_cast<std::size_t>(gradient)] - 0.5 * edge[gradient]);
    }

    // The layer of boxes along the gradient in which the image with these flags lies; 0 without shear.
    template <class Flags>
    int layer(const Flags& flags) const {
        return is_sheared() ? static_cast<int>(flags[gradient]) : 0;
    }
    // The image with these flags, one for each axis. A flag counts crossings of the far side (+1) and of the side at 0
    // (−1). In a sheared box, position + shift and velocity + image velocity are the path in the infinite system, also
    // beyond a crossing.
    template <class Flags>
    ImageMotion image(const Flags& flags, double time) const {
        ImageMotion of{};
        for (int k = 0; k < dimension; ++k) of.shift[k] = static_cast<int>(flags[k]) * edge[k];
        if (const int crossed = layer(flags)) {
            of.shift[0] += crossed * image_displacement(time);
            of.velocity[0] = crossed * image_velocity();
        }
        return of;
    }
    // Moves a particle that has left through a side, the far one (step 1) or that at 0 (−1), to its image in the box.
    // `time`: that of the position. Beyond a sheared side, the particle may have to be wrapped along the first axis as
    // well: by turns(x, 0).
    template <class Position, class Velocity, class Flags>
    void wrap(Position& x, Velocity& v, Flags& flags, int axis, int step, double time) const {
        int crossed[3] = {};
        crossed[axis] = step;
        const ImageMotion left = image(crossed, time);
        for (int k = 0; k < dimension; ++k) x[k] -= left.shift[k], v[k] -= left.velocity[k];
        flags[axis] += step;
    }
    // Number of edges by which a coordinate lies beyond the box: 0 in the box, −1 below it.
    int turns(double x, int axis) const { return static_cast<int>(math::floor_small(x / edge[axis])); }
    // Minimum image of a coordinate difference along a periodic axis [m].
    double minimum_image(double distance, int axis) const {
        return distance - edge[axis] * math::round_small(distance / edge[axis]);
    }
    // Replaces the vector between two particles by the one to the nearest image of the second particle, and returns the
    // velocity of this image relative to the particle, along the first axis [m/s].
    template <class Vector>
    double to_minimum_image(Vector& r, double time) const {
        const double velocity = to_nearest_layer(r, time);
        for (int k = 0; k < dimension; ++k)
            if (is_periodic(k)) r[k] = minimum_image(r[k], k);
        return velocity;
    }
    // The same along the gradient axis of a sheared box only.
    template <class Vector>
    double to_nearest_layer(Vector& r, double time) const {
        if (!is_sheared()) return 0.0;
        const double count = -math::round_small(r[gradient] / edge[gradient]);
        if (count == 0.0) return 0.0;
        r[gradient] += count * edge[gradient];
        r[0] += count * image_offset(time);
        return count * image_velocity();
    }
    // Folds an unfolded coordinate along a periodic axis into the box [m].
    double folded(double x, int axis) const {
        if (!is_periodic(axis)) return x;
        x = minimum_image(x, axis);
        return x < 0.0 ? math::min(x + edge[axis], edge[axis]) : x;
    }
};

// Kinetic energy that a particle gains with a change of its velocity along the axis [J].
HL_FN double gained_energy(double mass, double velocity, double change) {
    return 0.5 * mass * change * (2.0 * velocity + change);
}

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
