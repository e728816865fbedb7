// Records of a cluster: its members, their contacts, what it has done, and the trajectory.
#pragma once
#include <cstddef>
#include <utility>
#include <vector>

#include "../../../contact/friction.hpp"
#include "../../common/box.hpp"
#include "../../common/symmetric_tensor.hpp"
#include "../../common/triangle.hpp"

namespace hardlimit::boxes {

struct Member {
    double mass, radius;  // [kg], [m]
    Vector3 position;     // from an origin near the cluster [m]
    Vector3 velocity;     // [m/s]
};

// How a member spins. Only with friction.
struct Rotation {
    double inertia;  // [kg m²]
    Vector3 spin;    // [rad/s]
};

enum class ContactState : unsigned char {
    open,    // the surfaces are apart
    slack,   // overlap without force
    closed,  // overlap with a force
};

// What a closed pair with friction keeps (surfaces.hpp).
template <class Law>
struct PairSurfaces {};
template <FrictionalLaw Law>
struct PairSurfaces<Law> {
    enum class Start : unsigned char { none, touch, jump };  // what decides whether they stick

    Vector3 memory{};   // T/a^m while they stick, the direction of the force while they slip
    Vector3 elastic{};  // T at the end of the last run, on the first body [N]
    Vector3 slip{};     // tangential velocity at the begin [m/s]
    Start start = Start::none;
    bool slips = false, slid = false;
    bool unloads = false;           // the compression falls
    bool frozen = false;            // the direction of slip keeps still, as F_n is tiny
    bool fresh = false;             // they have just begun to stick or to slip
    bool turned = false;            // the compression has just begun to rise or to fall
    int changes = 0;                // between stick and slip
    bool keeps_slipping = false;    // until time advances
    int repeats = 0;                // changes in a row at the same time
    double changed_at = math::nan;  // time of the last change [s]
    // The same pair with its bodies exchanged.
    void exchange_bodies() {
        for (Vector3* x : {&memory, &elastic, &slip})
            for (double& c : *x) c = -c;
    }
};

// Two members that may touch, or a member and a wall.
template <class Law>
struct ContactPair {
    int first, second;        // second < 0: a wall
    Vector3 image;            // shift to the nearest periodic image at `base`, added to x_second − x_first
    Vector3 image_velocity;   // of that image: a Lees–Edwards boundary lies between the two [m/s]
    bool image_moves;         // whether it is not 0
    WallId wall_id;           // of the wall, if any
    int axis;                 // of the wall's normal
    double side;              // +1 for a wall at the low end of the axis, −1 at the high end
    double wall;              // coordinate of the wall along the axis at `base`, from the cluster's origin
    double wall_velocity;     // along the axis at `base` [m/s]
    double contact_distance;  // R_first + R_second; at a wall R_first [m]
    double mass;              // effective mass [kg]
    Law law;
    ContactState state = ContactState::open;
    bool fresh = false;       // an event function is zero, as its event has just occurred
    bool rooted = false;      // s is integrated
    bool overlapped = false;  // shared a body with another contact while it lasted
    bool scaled = false;      // the scales below are set
    bool may_be_too_deep = false, may_be_deepest = false;  // the cluster's energy suffices
    double s = 0.0;                                        // if rooted
    double s_unit = 0.0, depth_unit = 0.0;                 // at the cluster's energy
    double begin = 0.0, impact_speed = 0.0;                // of the closed contact
    [[no_unique_address]] PairSurfaces<Law> surfaces{};

    // Where the bodies overlap without force, one may act at once.
    void velocity_jumped() {
        if (state == ContactState::slack) fresh = false;
        if constexpr (FrictionalLaw<Law>)
            if (state == ContactState::closed) surfaces.start = PairSurfaces<Law>::Start::jump;
    }
    // Of a wall that does not oscillate, t [s] after `base`.
    double wall_position(double t) const { return wall_velocity != 0.0 ? wall + wall_velocity * t : wall; }
};

struct EndedContact {
    int pair;
    double begin, end;
    double impact_speed, separation_speed;
    bool overlapped;
    // With friction; see ContactRecord.
    bool slid = false;
    double tangential_speed = math::nan, tangential_restitution = math::nan;
    int changes = 0;  // between stick and slip
};

// What a cluster has done: energy lost and given, virial, and its contacts.
struct Ledger {
    double dissipated = 0.0;  // including energies of slack pairs and of tangential springs [J]
    SymmetricTensor virial;   // ∫ Σ r⊗F dt over pairs of bodies [J s]
    double wall_work = 0.0;   // done by moving walls [J]
    WallSums walls;           // as `dissipated`
    double shear_work = 0.0;  // done on pairs whose image moves [J]
    double rubbed = 0.0;      // work taken by tangential forces, including the energy of their springs [J]
    long begun = 0;           // contacts since the start
    long begun_pairs = 0;     // of these, between two bodies
    std::vector<EndedContact> ended;
    double largest_compression = 0.0;  // in units of the smaller radius, including earlier clusters

    void add_compression(double part) { largest_compression = math::max(largest_compression, part); }
    void clear() {
        std::vector<EndedContact> storage = std::move(ended);
        storage.clear();
        *this = {};
        ended = std::move(storage);
    }
};

// States of the members after each step.
struct Trajectory {
    std::vector<double> time;
    std::vector<double> state;  // for each time positions, then velocities
    // [members] largest distance of the path from its chord since the last time; empty if unknown.
    std::vector<double> chord_deviation;

    void clear() {
        time.clear();
        state.clear();
        chord_deviation.clear();
    }
    // Adds a state vector, whose first components are positions and velocities.
    void add(const double* y, std::size_t members, double at, bool deviations_known) {
        time.push_back(at);
        state.insert(state.end(), y, y + 6 * members);
        if (deviations_known) chord_deviation.resize(time.size() * members);
    }
    // The chord deviations of the next state that is added.
    double* next_deviations(std::size_t members) {
        chord_deviation.resize((time.size() + 1) * members);
        return &chord_deviation[time.size() * members];
    }
};

}  // namespace hardlimit::boxes
