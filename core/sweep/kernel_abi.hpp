// Data exchanged between a map and a kernel compiled for one instruction set. Each instruction set compiles its own
// copy of the core in its own namespace, so that the linker does not mix them; these plain types are common to all.
#pragma once

namespace hardlimit_abi {

enum class Status : int { solved = 1, unsolved = 2, rests = 3 };  // unsolved: the scalar solver must solve it

// Drops of a batch in scaled units, one array for each quantity.
inline constexpr int batch_inputs = 10, batch_groups = 5, batch_outputs = 6;
struct Batch {
    int count;
    const double* in[batch_inputs];  // groups a1, a2, c1, c2, gravity; initial state u, du, w, dw; time t
    double* out[batch_outputs];  // n_contacts, t_first, t_end, t_floor_end, relative and separation velocity
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
    void (*damping_ratios)(double*, int);  // b from ε, in place
    void (*solve_viscoelastic)(const Batch&, double log2_tolerance);
    void (*leave)(const Ends&);
};

}  // namespace hardlimit_abi
