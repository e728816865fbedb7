// Records of the event-driven engine for Newton's equations: bodies, their contacts and groups.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
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

// Bodies that are to form a group, their active pairs, and the latest end of the group.
template <class Law>
struct ClusterSeed {
    std::vector<int> bodies;
    std::vector<ActivePair<Law>> pairs;
    double until = math::infinity;  // [s]
};

// Index of a body among the members of a group.
class MemberIndex {
public:
    explicit MemberIndex(std::span<const int> bodies) : bodies_(bodies) {
        if (bodies.size() < few) return;
        for (std::size_t m = 0; m < bodies.size(); ++m) sorted_.emplace_back(bodies[m], m);
        std::sort(sorted_.begin(), sorted_.end());
    }
    std::size_t operator()(int body) const {
        if (sorted_.empty())
            return static_cast<std::size_t>(std::find(bodies_.begin(), bodies_.end(), body) -
                                            bodies_.begin());
        return std::lower_bound(sorted_.begin(), sorted_.end(), std::pair{body, std::size_t{0}})->second;
    }

private:
    static constexpr std::size_t few = 16;
    std::span<const int> bodies_;
    std::vector<std::pair<int, std::size_t>> sorted_;
};

// All groups, integrated up to the current time.
struct GroupsAtPresent {
    struct Body {
        int index;
        Vector3 position, velocity;  // in the frame of its cell
    };
    Observation sums;  // over the whole run, without the motion of the bodies
    std::vector<Body> bodies;
    std::vector<ContactRecord> open;  // open contacts, and ended contacts of unfinished groups
};

}  // namespace hardlimit::boxes
