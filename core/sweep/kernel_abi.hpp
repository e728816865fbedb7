// Data exchanged between a map and a kernel compiled for one instruction set. Each instruction set compiles its own
// copy of the core in its own namespace, so that the linker does not mix them; these plain types are common to all.
#pragma once

namespace hardlimit_abi {

enum class Status : int {
    running = 0,
    done = 1,
    left = 2,
    rests = 3
};  // left: not solved, left to the scalar solver

// Drops of a batch, one array for each quantity. Input: groups, initial state and time t; output: the sequence. Scaled
// units.
struct Batch {
    int count;
    const double *a1, *a2, *c1, *c2, *gravity, *u, *du, *w, *dw, *t;
    double *contacts, *t_first, *t_end, *t_floor_end, *relative, *separation;
    int* status;
};

// Results of a batch, one array for each quantity, padded to a whole number of vectors. Kernel::leave converts them to
// SI units in place and computes the coefficients of restitution.
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
