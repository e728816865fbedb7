// Interface of the vector kernels of boxes, in plain numbers: they are compiled once for each instruction set.
#pragma once
#include <cstddef>

namespace hardlimit_abi {

// The particle that looks, now, and where.
struct TouchQuery {
    double now;             // [s]
    double position[3];     // [m]
    double velocity[3];     // [m/s]
    double radius, others;  // touches at this distance and `others` radii of the other [m]
    double space, span;     // where `reach` is asked for: not less than `radius`, for so long [m, s]
    double shift[3];        // of all neighbours [m]
    double edge[3];         // L [m]
    double per_edge[3];     // 1/L where the nearest image is meant, else 0
    double half_gravity[3], gravity[3];  // g/2 and g [m/s²]
    double share, rate;  // of the radii now, and its growth [1/s]: 1 and 0 but for growing radii
};

// A block of cells: rows along the first axis, which are whole, or in two parts where the block reaches across a border
// of the box. A cell is of four words: up to three ids, the others nobody's, then their number, or where there are more
// four more than the index in `spilled` of the cell that holds the rest. Sixteen words can be read from any cell.
struct CellBlock {
    const void *cells, *spilled;
    const unsigned* row;           // the first cell of each row
    unsigned rows, parts;          // how many
    unsigned begin[2], length[2];  // of the parts, in a row
    unsigned own_rows[9];          // room for `row`
};

// What of a number of particles is touched first. `several`: more than one is touched at this time.
struct Touched {
    double time;  // from now [s]; infinity: nothing is
    double next;  // until another one is, where `reach` is asked for and there are not several
    unsigned id;
    unsigned several;
    std::size_t n;  // particles examined
};

// Examines n particles with these ids, or all in a block, whose ids are then written. The times at which each is
// touched, from now, infinity where it is not, are written too. The lists of ids and of times have room for sixteen
// more.
// `particles` is an array of cache lines.
using TouchListed = Touched (*)(const TouchQuery& query, const void* particles, unsigned self, unsigned* ids,
                                double* times, std::size_t n);
using TouchNear = Touched (*)(const TouchQuery& query, const void* particles, unsigned self, unsigned* ids,
                              double* times, const CellBlock& block);

// What takes the time of a step, compiled once for each instruction set. `paths` [bodies] and `contacts` [n] are
// arrays of series::Path and series::Followed; order [bodies]: the bodies, the first `pushed` of them those in the
// contacts, while the others fly; gravity [4]; bulge [bodies] or none; state: places, then velocities [bodies, 3];
// sums: what is lost, and ∫ Σ r·F dt.
struct SeriesKernels {
    void (*expand)(void* paths, int bodies, void* contacts, int n, const double* gravity, double unit);
    double (*last_terms)(const void* paths, const int* body_order, int in_contact);
    void (*travel)(const void* paths, const int* body_order, int in_contact, int bodies, double at,
                   double* out);
    // Of the distance of two paths; image [3].
    void (*square)(const void* first, const void* second, const double* image, double* out);
    double (*first_zero)(const double* series, double end);
    double (*next_zero)(const double* series, double end, double step, double rounding);
    void (*move)(const void* paths, const int* body_order, int in_contact, int bodies, const void* contacts,
                 int n, double at, double unit, const double* gravity, double* state, double* sums,
                 double* chord_deviation);
};

struct TouchKernels {
    const char* name;
    // By dimension − 2 and motion. near: of places as they are; across: of nearest images.
    struct Of {
        TouchListed listed;
        TouchNear near, across;
    } of[2][3];
    Of reach[2];  // in three dimensions, by motion: straight or falling
    SeriesKernels series;
    void (*read_cell)(const void* cell, const double* x, double* values);  // of contacts that are tabled
};

}  // namespace hardlimit_abi

namespace hardlimit::boxes {

// Part of the square of the distance up to which overlap is rounding.
inline constexpr double rounding_of_touch = 4e-9;

}  // namespace hardlimit::boxes
