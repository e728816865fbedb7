// Table of the column parameters that can be swept, used by Python, the GPU tasks and the web page.
//
// A point of a map of N balls is a row of numbers: the places below in their order, each once per column, ball or gap
// (counted from below), then max_parameters numbers for each contact, the floor first. For two balls this is the layout
// of Parameters.
#pragma once
#include <cstddef>

#include "parameters.hpp"

namespace hardlimit::sweep {

// Meaning of a number in that row. matter: mass or density of a ball, as given by the user. radius_ratio: unless NaN,
// it determines the lowest radius.
enum class Place : int { radius, radius_ratio, matter, gap, height, velocity, gravity };
inline constexpr int place_count = 7;

// Whether a place occurs once per column, per ball or per gap.
enum class Per : int { column, ball, gap };

// A parameter that can be swept. Two names with the same place exclude each other.
struct SweptRecord {
    const char* name;
    Place place;
    const char *unit, *meaning;
    double lowest;  // -∞: no bound
    bool lowest_allowed;
};

inline constexpr SweptRecord swept_records[] = {
    {"gap", Place::gap, "m", "gap between neighbouring balls Δh", 0.0, true},
    {"radius_ratio", Place::radius_ratio, "1", "R1/R2 (changes the lower radius)", 0.0, false},
    {"radius", Place::radius, "m", "radius R", 0.0, false},
    {"density", Place::matter, "kg/m3", "density", 0.0, false},
    {"mass", Place::matter, "kg", "mass m", 0.0, false},
    {"height", Place::height, "m", "height of the lowest centre at release z1(0)", 0.0, false},
    {"velocity", Place::velocity, "m/s", "velocity at release, upwards", -math::infinity, false},
    {"gravity", Place::gravity, "m/s2", "gravity g", 0.0, true},
};

constexpr Per per(Place place) {
    switch (place) {
        case Place::radius:
        case Place::matter:
        case Place::velocity:
            return Per::ball;
        case Place::gap:
            return Per::gap;
        case Place::radius_ratio:
        case Place::height:
        case Place::gravity:
            break;
    }
    return Per::column;
}

constexpr int count_of(Place place, int balls) {
    return per(place) == Per::ball ? balls : per(place) == Per::gap ? balls - 1 : 1;
}

// Index of the first number of a place.
constexpr int first_of(Place place, int balls) {
    int at = 0;
    for (int i = 0; i < static_cast<int>(place); ++i) at += count_of(static_cast<Place>(i), balls);
    return at;
}

// Index of the first law parameter of a contact, 0 = floor. For contact = balls, the length of the row.
constexpr int law_of(int contact, int balls) {
    return first_of(Place::gravity, balls) + 1 + contact * max_parameters;
}

// For two balls the row has the layout of Parameters, the input of the two-ball kernels.
static_assert(first_of(Place::radius, 2) == offsetof(Parameters, radius_1) / sizeof(double));
static_assert(first_of(Place::radius_ratio, 2) == offsetof(Parameters, radius_ratio) / sizeof(double));
static_assert(first_of(Place::matter, 2) == offsetof(Parameters, matter_1) / sizeof(double));
static_assert(first_of(Place::gap, 2) == offsetof(Parameters, gap) / sizeof(double));
static_assert(first_of(Place::height, 2) == offsetof(Parameters, height) / sizeof(double));
static_assert(first_of(Place::velocity, 2) == offsetof(Parameters, velocity_1) / sizeof(double));
static_assert(first_of(Place::gravity, 2) == offsetof(Parameters, gravity) / sizeof(double));
static_assert(law_of(0, 2) == offsetof(Parameters, floor_law) / sizeof(double));
static_assert(law_of(1, 2) == offsetof(Parameters, pair_law) / sizeof(double));
static_assert(law_of(2, 2) == parameter_count);

}  // namespace hardlimit::sweep
