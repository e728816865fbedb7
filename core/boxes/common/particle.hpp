// What is held of one particle, and the events that lie before it.
#pragma once
#include <cstdint>

#include "../../base/math.hpp"

namespace hardlimit::boxes {

using u32 = std::uint32_t;
inline constexpr u32 no_particle = 0xffffffffu;

// One cache line. A particle keeps the state of its last collision: nothing is advanced before the next one.
template <int d>
struct alignas(64) Particle {
    double position[d];  // [m] at `time`; folded into the box when a border of the box is crossed
    double velocity[d];  // [m/s] at `time`
    double time;         // of the last collision [s]; 0 before the first
    double radius;       // [m]; of equal particles, whose radius is held once, a `collision_count`
};
static_assert(sizeof(Particle<3>) == 64 && sizeof(Particle<2>) == 64);

// A number of collisions as a double that is as good as any: the last 32 bits of one that begins as 1. It lies where a
// search reads anyway.
inline constexpr double collision_count = 1.0;
HL_FN u32 collisions_in(double count) { return static_cast<u32>(bits_of(count)); }
HL_FN double one_more_collision(double count) {
    const u64 bits = bits_of(count), low = 0xffffffff;
    return real_of<double>((bits & ~low) | ((bits + 1) & low));
}

// What a particle does by itself.
enum class SelfEvent : u32 {
    low_x,
    high_x,
    low_y,
    high_y,
    low_z,
    high_z,  // leaves its cell, or meets a wall, on that side
    rescan,  // looks for smaller particles anew
    ends,    // its group of bodies in contact ends
};
constexpr SelfEvent own_event(int axis, bool high) {
    return static_cast<SelfEvent>(2 * axis + (high ? 1 : 0));
}
// The user's number of the wall that is met: −1 − 2·axis at 0, −2 − 2·axis at the edge.
constexpr i64 wall_number(SelfEvent own) { return -1 - static_cast<i64>(own); }
constexpr int axis_of(SelfEvent own) { return static_cast<int>(own) / 2; }
constexpr bool is_high(SelfEvent own) { return (static_cast<u32>(own) & 1u) != 0; }

// The earliest collision found and the earliest event of the particle's own. `partner` has collided since if its
// number of collisions is no longer `partner_count`: then pair_time is only a time before which nothing happens.
struct Pending {
    double pair_time = math::infinity;  // [s]
    double own_time = math::infinity;   // [s]
    u32 partner = no_particle;
    u32 partner_count = 0;
    u32 count = 0;      // collisions so far, unless they are counted beside the place
    u32 cell : 29 = 0;  // that the particle is in
    u32 own : 3 = 0;

    double time() const { return math::min(pair_time, own_time); }
};
static_assert(sizeof(Pending) == 32);
inline constexpr u32 most_cells = 1u << 29;

// How particles move between collisions.
enum class Motion {
    straight,
    falling,  // all under the same gravity: relative paths stay straight
    growing,  // straight, while all radii grow
};

}  // namespace hardlimit::boxes
