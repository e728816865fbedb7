// Body arrays of the time-stepping engine for Newton's equations, and their vector type.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "../../base/math.hpp"
#include "box.hpp"
#include "storage.hpp"

namespace hardlimit::boxes {

using Double4 = Vector<4>::Real;

// A function, because gcc then keeps x and y of a computed vector in one register.
inline constexpr Double4 double4(double x, double y, double z, double w) { return Double4{x, y, z, w}; }

// Dot and cross product of the first three components.
inline double dot(Double4 a, Double4 b) { return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]; }
inline Double4 cross(Double4 a, Double4 b) {
    return Double4{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0], 0.0};
}

inline std::array<double, 3> first_three(Double4 a) { return {a[0], a[1], a[2]}; }
inline Double4 double4(const double* three) { return Double4{three[0], three[1], three[2], 0.0}; }

// The array as doubles, four for each element.
inline double* as_doubles(Records<Double4>& of) { return reinterpret_cast<double*>(of.data()); }
inline const double* as_doubles(const Records<Double4>& of) {
    return reinterpret_cast<const double*>(of.data());
}

inline Double4 gravity_of(const Box& box) {
    return Double4{box.gravity[0], box.gravity[1], box.gravity[2], 0.0};
}

// Acceleration of a body by its contacts at the last two steps. Few bodies are in contact at a time, so entries are not
// cleared: an entry is valid at step `step`, and as the previous acceleration at step `step` + 1.
struct ContactAcceleration {
    double now[3] = {};  // [m/s²] at step `step`
    std::uint64_t step = 0;
    double before[3] = {};  // [m/s²] at step `step` − 1
    std::uint64_t unused = 0;

    // Three components; a compiler would pass a vector that depends on a condition through memory.
    const double* at(std::uint64_t wanted) const { return step == wanted ? now : none; }
    // Acceleration at the step before `current`, whether or not contacts of step `current` have been added.
    const double* previous(std::uint64_t current) const { return step == current ? before : at(current - 1); }
    // Returns whether this is the first contribution at this step.
    bool add(std::uint64_t current, Double4 acceleration) {
        const bool first = step != current;
        if (first) {
            const double* last = at(current - 1);
            for (int axis = 0; axis < 3; ++axis) before[axis] = last[axis], now[axis] = 0.0;
            step = current;
        }
        for (int axis = 0; axis < 3; ++axis) now[axis] += acceleration[axis];
        return first;
    }

private:
    static constexpr double none[3] = {};
};

struct BodyTag {
    std::uint32_t original_index;  // in the user's arrays
    std::int32_t image_flags[3];   // how many times the body has crossed the box along each periodic axis
};

// Bodies, sorted by cell. The arrays for rotation are empty without friction.
struct Bodies {
    Records<Double4> position;                  // [N] x, y, z [m] in the box, radius [m]
    Records<Double4> velocity;                  // [N] velocity [m/s], 1/mass [1/kg]
    Records<BodyTag> tag;                       // [N]
    Records<ContactAcceleration> acceleration;  // [N]

    Records<Double4> spin;  // angular velocity [rad/s], 1/moment of inertia [1/(kg m²)]
    Records<ContactAcceleration> angular_acceleration;  // [rad/s²]

    std::size_t count() const { return position.size(); }
};

// Velocity of a body relative to the mean flow of a sheared box [m/s].
inline Double4 velocity_from_flow(const Box& box, const Bodies& bodies, std::size_t i) {
    Double4 v = bodies.velocity[i];
    v[0] -= box.mean_flow(bodies.position[i]);
    return v;
}

}  // namespace hardlimit::boxes
