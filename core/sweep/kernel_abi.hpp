// Data exchanged between a map and the kernel compiled for one instruction set. Each instruction set has its own copy
// of the core under its own namespace (or the linker would mix them); these plain types belong to all.
#pragma once

namespace hardlimit_abi {

enum class Status : int { running = 0, done = 1, left = 2, rests = 3 };  // left: for the scalar solver

// Drops of a batch, one array each: groups and start in, sequence out (scaled units, times on the clock of t).
struct Batch {
    int count;
    const double *a1, *a2, *c1, *c2, *gravity, *u, *du, *w, *dw, *t;
    double *contacts, *t_first, *t_end, *t_floor_end, *relative, *separation;
    int* status;
};

// Sequences of a batch on the way out, one array each, of room for a whole number of vectors: scaled units become SI
// units in place, and the coefficients of restitution are filled in.
struct Ends {
    int count;
    const double *speed, *rate;  // the units
    const double* restitution;   // ε of both contacts; NaN: different or not given
    const double* t_first;
    double *t_end, *t_floor_end, *relative, *separation, *effective_restitution, *restitution_ratio;
};

struct Kernel {
    const char* name;
    void (*solve)(const Batch&);
    void (*damping_ratios)(double*, int);  // b from −ln ε, in place
    void (*solve_viscoelastic)(const Batch&, double log2_tolerance);
    void (*leave)(const Ends&);
};

}  // namespace hardlimit_abi
