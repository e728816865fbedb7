// A particle in free flight, and its pending events.
#pragma once
#include <cstdint>

#include "../../base/math.hpp"
#include "box.hpp"

namespace hardlimit::boxes {

using u32 = std::uint32_t;
inline constexpr u32 no_particle = 0xffffffffu;

// State of a particle after its last collision, in one cache line. It is not advanced before the next collision.
template <int d>
struct alignas(64) Particle {
    double position[d];  // [m] at `time`; folded when the particle crosses a periodic boundary
    double velocity[d];  // [m/s] at `time`
    double time;         // of the last collision [s]; 0 before the first
    double radius;       // [m]; if all radii are equal, the collision counter instead (below)
};
static_assert(sizeof(Particle<3>) == 64 && sizeof(Particle<2>) == 64);

// Collision counter in the low 32 bits of a double that starts as 1. It shares the cache line that a prediction reads
// anyway, and the kernels may load it as an ordinary number.
inline constexpr double collision_count = 1.0;
HL_FN u32 collisions_in(double count) { return static_cast<u32>(bits_of(count)); }
HL_FN double increment_collision_count(double count) {
    const u64 bits = bits_of(count), low = 0xffffffff;
    return real_of<double>((bits & ~low) | ((bits + 1) & low));
}

// An event of a single particle.
enum class SelfEvent : u32 {
    low_x,
    high_x,
    low_y,
    high_y,
    low_z,
    high_z,       // leaves its cell on that side
    rescan,       // searches again for smaller particles
    ends,         // its cluster ends
    at_wall = 8,  // added to a side: meets the wall there
};
constexpr SelfEvent self_event(int axis, bool high, bool wall) {
    return static_cast<SelfEvent>(2 * axis + (high ? 1 : 0) + (wall ? 8 : 0));
}
constexpr int axis_of(SelfEvent own) { return (static_cast<int>(own) & 7) / 2; }
constexpr bool is_high(SelfEvent own) { return (static_cast<u32>(own) & 1u) != 0; }
constexpr bool is_wall(SelfEvent own) { return (static_cast<u32>(own) & 8u) != 0; }
constexpr WallId wall_at(SelfEvent own) { return WallId::at(axis_of(own), is_high(own)); }

// Earliest predicted collision and earliest single-particle event. The collision is stale if the partner's collision
// count has changed; pair_time is then a lower bound on the particle's next collision.
struct PendingEvents {
    double pair_time = math::infinity;  // [s]
    double own_time = math::infinity;   // [s]
    u32 partner = no_particle;
    u32 partner_count = 0;  // collisions of the partner at the time of the prediction
    u32 count = 0;          // collisions of the particle, unless counted in Particle::radius
    u32 cell : 28 = 0;      // cell of the particle
    u32 own : 4 = 0;        // SelfEvent

    double time() const { return math::min(pair_time, own_time); }
};
static_assert(sizeof(PendingEvents) == 32);
inline constexpr u32 most_cells = 1u << 28;

// How particles move between collisions.
enum class Motion {
    straight,
    falling,  // all under the same gravity: relative motion is uniform
    growing,  // straight, while all radii grow
};

// Position [m] and velocity [m/s] along axis k, a time `after` [s] after the last collision.
template <int d>
double position_after(const Particle<d>& p, int k, double after, const Box& box) {
    return p.position[k] + after * (p.velocity[k] + (0.5 * box.gravity[k]) * after);
}
template <int d>
double velocity_after(const Particle<d>& p, int k, double after, const Box& box) {
    return p.velocity[k] + box.gravity[k] * after;
}

template <int d>
void advance(Particle<d>& p, double time, const Box& box) {
    const double after = time - p.time;
    for (int k = 0; k < d; ++k) {
        p.position[k] = position_after(p, k, after, box);
        p.velocity[k] = velocity_after(p, k, after, box);
    }
    p.time = time;
}

}  // namespace hardlimit::boxes
