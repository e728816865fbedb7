// C interface of the SIMD kernels for boxes. The kernels are compiled once for each instruction set.
#pragma once
#include <cstddef>

namespace hardlimit_abi {

// Input of a prediction: present state of the particle whose collisions are predicted, and the box.
struct ContactQuery {
    double now;             // [s]
    double position[3];     // [m]
    double velocity[3];     // [m/s]
    double radius, others;  // contact distance: radius + others · (radius of the other) [m]
    double enlarged_radius,
        enlarged_span;                   // if `enlarged`: a larger radius [m] and how long it is valid [s]
    double shift[3];                     // added to the positions of all neighbours [m]
    double edge[3];                      // L [m]
    double per_edge[3];                  // 1/L for minimum images, otherwise 0
    double half_gravity[3], gravity[3];  // g/2 and g [m/s²]
    double radius_factor,
        growth_rate;  // factor of all radii at `now`, its growth rate [1/s]; 1, 0 without growth
};

// A block of cells as rows along the first axis, in two parts if the block crosses a periodic boundary. A cell has four
// words: up to three ids, padded with no_particle, then their number. If there are more ids, the fourth word is 4 + the
// index in `spilled` of the cell with the rest. Sixteen words can be read from any cell.
struct CellBlock {
    const void *cells, *spilled;
    const unsigned* row;           // first cell of each row
    unsigned rows, parts;          // number of rows, number of parts
    unsigned begin[2], length[2];  // first cell and length of each part, within a row
    unsigned own_rows[9];          // storage for `row`
};

// Earliest contact of a particle with its neighbours. `several`: more than one neighbour touches at this time.
struct EarliestContact {
    double time;  // from now [s]; infinity: none
    double next;  // time of the second contact, if `enlarged` and not `several`
    unsigned id;
    unsigned several;
    std::size_t n;  // number of particles examined
};

// Predicts the contacts of particle `self` with n particles of these ids, or with all particles of a block, whose ids
// are then written. Writes the time until each contact, infinity if never. Both lists need room for sixteen more
// entries. `particles`: array of Particle, one cache line each.
using PredictListed = EarliestContact (*)(const ContactQuery& query, const void* particles, unsigned self,
                                          unsigned* ids, double* times, std::size_t n);
using PredictBlock = EarliestContact (*)(const ContactQuery& query, const void* particles, unsigned self,
                                         unsigned* ids, double* times, const CellBlock& block);

// Kernels of power_series.hpp. `paths` [bodies] and `contacts` [n] are arrays of series::Path and series::Contact;
// body_order [bodies]: first the `in_contact` bodies in contact, then the others; gravity [4]; chord_deviation [bodies]
// or null; state: positions, then velocities [bodies, 3]. Adds to the dissipated energy and to the virial [6],
// ∫ Σ r⊗F dt of pairs of bodies in LAMMPS' order.
struct SeriesKernels {
    void (*expand)(void* paths, int bodies, void* contacts, int n, const double* gravity, double unit);
    double (*last_terms)(const void* paths, const int* body_order, int in_contact);
    void (*travel)(const void* paths, const int* body_order, int in_contact, int bodies, double at,
                   double* out);
    // Series of the squared distance of two paths; image [3].
    void (*square)(const void* first, const void* second, const double* image, double* out);
    double (*first_zero)(const double* series, double end);
    double (*next_zero)(const double* series, double end, double step, double rounding);
    void (*move)(const void* paths, const int* body_order, int in_contact, int bodies, const void* contacts,
                 int n, double at, double unit, const double* gravity, double* state, double* dissipated,
                 double* virial, double* chord_deviation);
};

// An isolated contact of two bodies under a linear law (open_contacts.hpp). Units: the distance of their centres at the
// start, and the time from there, negative if the series goes back from the end of the force.
struct OpenContact {
    // At the start: k/m and γ/m; speeds along the line of centres, x, and across; force.
    double spring, damper, radial_speed, tangential_speed, force;
    // Then: r, distance − 1, its rate, dr/dt, ∫ rate² dt, ∫ r⊗F dt; the largest of the last two terms of the series.
    double x, y, stretched, rate, speed_x, speed_y, rate_square, virial_xx, virial_xy, virial_yy, last_term;
};

// Mass and radius of body i: entries 2 k and 2 k + 1 with k = kind[i], or k = step · i without kinds.
struct BodyKinds {
    const double* mass_and_radius;
    const unsigned* kind;
    std::size_t step;
};

// Kernels for samples; see open_contacts.hpp and velocity_sums.hpp.
struct SampleKernels {
    void (*solve)(OpenContact* contacts, std::size_t n);
    void (*sum_velocities)(const void* particles, std::size_t n, const BodyKinds& kinds, double* momentum,
                           double* tensor);
};

struct TouchKernels {
    const char* name;
    // of[dimension − 2][motion]. near: no periodic images; across: minimum images.
    struct Of {
        PredictListed listed;
        PredictBlock near, across;
    } of[2][3];
    Of enlarged[2];  // three dimensions, by motion: straight or falling
    SeriesKernels series;
    void (*read_cell)(const void* cell, const double* x, double* values);  // of tabulated_contact.hpp
    SampleKernels samples;
};

}  // namespace hardlimit_abi

namespace hardlimit::boxes {

// Largest overlap that counts as rounding error, relative to the squared contact distance.
inline constexpr double rounding_of_touch = 4e-9;

}  // namespace hardlimit::boxes
