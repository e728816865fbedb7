// Records of the event-driven engine for Newton's equations: bodies, their contacts and groups.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "../common/engine.hpp"
#include "../common/particle.hpp"
#include "../common/storage.hpp"
#include "cluster/cluster.hpp"

namespace hardlimit::boxes {

// Event bookkeeping of one body (64 bytes); its path is in `Particle`. `count`: changes of the path so far.
struct alignas(64) BodyEvents : PendingEvents {
    double end = math::infinity;       // end of its group [s]
    int group = -1;                    // −1: none
    std::array<int, 3> image_flags{};  // net crossings of the periodic boundary along each axis
    u32 original_index = 0;
    bool first = false;      // first member of its group; the end of a cluster is its self event
    bool clustered = false;  // member of a cluster: its path ends with the group
    std::uint16_t unused = 0;
};
static_assert(sizeof(BodyEvents) == 64);

// What an isolated contact with friction keeps.
template <class Law>
struct IsolatedSurfaces {};
template <FrictionalLaw Law>
struct IsolatedSurfaces<Law> {
    Vector3 spin[2];  // of the members at the end [rad/s]
    double rubbed;    // taken by the tangential force [J]
};

// A contact that no third body disturbs. In a large box each cache line read waits for memory. The first line holds the
// data for the end of the contact, the second the data needed when another body comes near.
template <class Law>
struct IsolatedContact {
    int body[2];              // second < 0: a wall
    double dissipated;        // [J]
    SymmetricTensor virial;   // ∫ r⊗F dt; 0 at a wall [J s]
    alignas(64) double span;  // time from touch until the surfaces separate [s]
    double share[2];          // each member's part of the relative displacement: m_other/(m_1 + m_2)
    double safety_radius[2];  // by which a member's path can leave the triangle of stays_clear() [m]
    Vector3 initial_offset;   // at touch: true relative position minus that on the outgoing path [m]
    double deviation;         // its length, the largest deviation from the outgoing path [m]
    double rotation;          // of the line of centres [rad]
    Member before[2];
    ContactPair<Law> pair;
    EndedContact contact;
    [[no_unique_address]] IsolatedSurfaces<Law> surfaces;
};

template <class Law>
struct ClusterStates {
    Cluster<Law> before, after;
};

// Bodies in contact that are solved together: one isolated contact or a cluster.
template <class Law>
struct ContactGroup {
    IsolatedContact<Law> isolated_contact{};  // if isolated
    bool alive = false, isolated = false;
    double compression = 0.0;     // of an isolated contact: largest, in units of the smaller radius
    double wall_impulse = 0.0;    // of an isolated contact with a wall: momentum that it gets [N s]
    double until = 0.0;           // latest end of a large cluster [s]
    double sheared_energy = 0.0;  // sheared_energy() at the begin [J]
    Vector3 origin{};
    SmallVector<int, 2> body;
    SmallVector<Vector3, 2> image_offset;         // [members] image flags of the member's position
    std::unique_ptr<ClusterStates<Law>> cluster;  // if not isolated
};

// A closed or slack pair, and the indices of its bodies.
template <class Law>
struct ActivePair {
    int first, second;
    ContactPair<Law> pair;
};

// A pair that starts to overlap at a time [s].
template <class Law>
ActivePair<Law> new_pair(int first, int second, WallId wall, double time) {
    ActivePair<Law> active{};
    active.first = first;
    active.second = second;
    active.pair.state = ContactState::slack;
    active.pair.wall_id = wall;
    active.pair.begin = time;
    active.pair.impact_speed = math::nan;
    return active;
}

template <class Law>
using ActivePairs = std::vector<ActivePair<Law>>;

// Bodies that are to form a group, their active pairs, and the latest end of the group.
template <class Law>
struct ClusterSeed {
    std::vector<int> bodies;
    ActivePairs<Law> pairs;
    double until = math::infinity;  // [s]
};

}  // namespace hardlimit::boxes
