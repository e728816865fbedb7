// Open contacts of the time-stepping engine, and the events that begin and end them.
#pragma once
#include <array>
#include <cstdint>
#include <tuple>

#include "../common/bodies.hpp"
#include "friction_force.hpp"

namespace hardlimit::boxes::steps {

inline constexpr std::uint32_t no_body = 0xffffffffu;

// Data of the begin of a contact, for the log.
struct ContactBegin {
    std::int32_t first, second;                     // original indices; second as in ContactRecord
    double begin, impact_speed;                     // [s], [m/s]
    bool overlapped;                                // a body had another contact at the begin
    std::uint32_t overlaps_first, overlaps_second;  // overlap counts at the begin (ContactLog)
};

// Friction of a contact, for the log.
struct Sliding {
    bool slid = false;
    double speed = math::nan, restitution = math::nan;  // as in ContactRecord
};

// Two bodies, or a body and a wall, that overlap. They are in contact while their force is repulsive.
template <class Law>
struct Contact : ContactBegin, ContactForce {  // the force of the last step
    Law law;
    std::array<std::int32_t, 3> image;        // image of the second body, unfolded, in units of the edges
    std::uint32_t index_first, index_second;  // in Bodies; no_body: a free slot (first), a wall (second)
    Double4 normal;                           // unit vector from the first to the second
    double distance;                          // of the centres, or to the wall [m]
    double wall_velocity;                     // of a wall, inwards [m/s]; 0 for two bodies
    double image_velocity;                    // of the image of the second body, along the first axis [m/s]
    double compression;                       // at the last step [m]
    double damped;                            // impulse of the damping during the last step [N s]
    double excess;                            // of the compression over the slack of the law [m]
    Onset onset;
    bool is_new;  // the last step was its first
    bool in_contact;
    std::int32_t begin_event;  // index of its begin in Slab::events; −1 once logged
    [[no_unique_address]] ContactFriction<Law> friction;
};

// Friction of a contact that ends with this tangential velocity of its surfaces [m/s], or lasts.
template <class Law>
Sliding sliding(const Contact<Law>& c, Double4 last = Double4{math::nan, math::nan, math::nan, 0.0}) {
    if constexpr (FrictionalLaw<Law>) {
        const Double4 first = c.friction.first_velocity;
        const double square = dot(first, first);
        return {c.friction.slid, math::sqrt(square), -dot(first, last) / square};
    } else {
        return {};
    }
}

// The begin or the end of a contact between two steps. It is logged after several steps, when the slot of the contact
// may have been reused.
struct ContactEvent {
    ContactBegin contact;
    std::uint64_t step;  // at which it was detected
    double time;         // [s]
    std::int32_t slot;
    bool begins;
    double separation_speed;   // [m/s]
    std::int32_t begin_event;  // of an end: index of the begin among the events, −1 if already logged
    Sliding sliding{};         // of an end

    std::tuple<std::uint64_t, double, std::int32_t, std::int32_t> order() const {
        return {step, time, contact.first, contact.second};
    }
};

}  // namespace hardlimit::boxes::steps
