// Table of the column parameters that can be swept, used by Python, the GPU tasks and the web page.
//
// A point of a map of N balls is a row of numbers: the fields below in their order, each once per column, ball or gap
// (counted from below), then max_parameters numbers for each contact, the floor first. For two balls this is the layout
// of Parameters.
#pragma once
#include <cstddef>

#include "parameters.hpp"

namespace hardlimit::sweep {

// Meaning of a number in that row. matter: mass or density of a ball, as given by the user. radius_ratio: unless NaN,
// it determines the lowest radius.
enum class Field : int { radius, radius_ratio, matter, gap, height, velocity, gravity };

// Whether a field occurs once per column, per ball or per gap.
enum class Per : int { column, ball, gap };

// A parameter that can be swept. Two names with the same field exclude each other.
struct SweptRecord {
    const char* name;
    Field field;
    const char *unit, *meaning;
    double lowest;  // -∞: no bound
    bool lowest_allowed;
};

inline constexpr SweptRecord swept_records[] = {
    {"gap", Field::gap, "m", "gap between neighbouring balls Δh", 0.0, true},
    {"radius_ratio", Field::radius_ratio, "1", "R1/R2 (changes the lower radius)", 0.0, false},
    {"radius", Field::radius, "m", "radius R", 0.0, false},
    {"density", Field::matter, "kg/m3", "density", 0.0, false},
    {"mass", Field::matter, "kg", "mass m", 0.0, false},
    {"height", Field::height, "m", "height of the lowest centre at release z1(0)", 0.0, false},
    {"velocity", Field::velocity, "m/s", "velocity at release, upwards", -math::infinity, false},
    {"gravity", Field::gravity, "m/s2", "gravity g", 0.0, true},
};

constexpr Per per(Field field) {
    switch (field) {
        case Field::radius:
        case Field::matter:
        case Field::velocity:
            return Per::ball;
        case Field::gap:
            return Per::gap;
        case Field::radius_ratio:
        case Field::height:
        case Field::gravity:
            break;
    }
    return Per::column;
}

constexpr int count_of(Field field, int balls) {
    return per(field) == Per::ball ? balls : per(field) == Per::gap ? balls - 1 : 1;
}

// Index of the first number of a field.
constexpr int first_of(Field field, int balls) {
    int at = 0;
    for (int i = 0; i < static_cast<int>(field); ++i) at += count_of(static_cast<Field>(i), balls);
    return at;
}

// Index of the first law parameter of a contact, 0 = floor. For contact = balls, the length of the row.
constexpr int law_of(int contact, int balls) {
    return first_of(Field::gravity, balls) + 1 + contact * max_parameters;
}

// For two balls the row has the layout of Parameters, the input of the two-ball kernels.
static_assert(first_of(Field::radius, 2) == offsetof(Parameters, radius_1) / sizeof(double));
static_assert(first_of(Field::radius_ratio, 2) == offsetof(Parameters, radius_ratio) / sizeof(double));
static_assert(first_of(Field::matter, 2) == offsetof(Parameters, matter_1) / sizeof(double));
static_assert(first_of(Field::gap, 2) == offsetof(Parameters, gap) / sizeof(double));
static_assert(first_of(Field::height, 2) == offsetof(Parameters, height) / sizeof(double));
static_assert(first_of(Field::velocity, 2) == offsetof(Parameters, velocity_1) / sizeof(double));
static_assert(first_of(Field::gravity, 2) == offsetof(Parameters, gravity) / sizeof(double));
static_assert(law_of(0, 2) == offsetof(Parameters, floor_law) / sizeof(double));
static_assert(law_of(1, 2) == offsetof(Parameters, pair_law) / sizeof(double));
static_assert(law_of(2, 2) == parameter_count);

}  // namespace hardlimit::sweep
