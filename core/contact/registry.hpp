// List of all contact laws. A new law needs one header and one line here; it then appears in Python, on the command
// line, in the solvers and in the generic tests. A module that needs few laws defines a shorter list before.
#pragma once
#include "linear_dashpot.hpp"
#include "tsuji.hpp"
#include "viscoelastic.hpp"

#ifndef HARDLIMIT_LAWS
#define HARDLIMIT_LAWS(X) \
    X(LinearDashpot)      \
    X(Viscoelastic)       \
    X(Tsuji)
#endif
