// Records of a cluster: its members, their contacts, contacts that have ended, and the trajectory.
#pragma once
#include <vector>

#include "../../common/box.hpp"
#include "../../common/triangle.hpp"

namespace hardlimit::boxes {

struct Member {
    double mass, radius;  // [kg], [m]
    Vector3 position;     // from an origin near the cluster [m]
    Vector3 velocity;     // [m/s]
};

enum class ContactState : unsigned char {
    open,    // the surfaces are apart
    slack,   // overlap without force
    closed,  // overlap with a force
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

    // Where the bodies overlap without force, one may act at once.
    void velocity_jumped() {
        if (state == ContactState::slack) fresh = false;
    }
    // Of a wall that does not oscillate, t [s] after `base`.
    double wall_position(double t) const { return wall_velocity != 0.0 ? wall + wall_velocity * t : wall; }
};

struct EndedContact {
    int pair;
    double begin, end;
    double impact_speed, separation_speed;
    bool overlapped;
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
};

}  // namespace hardlimit::boxes
