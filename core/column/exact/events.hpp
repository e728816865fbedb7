// Switches of the exact two-ball solver: which contact begins, ends or opens next.
#pragma once
#include "motions.hpp"

namespace hardlimit::column::exact {

enum class Switch { none, floor_begins, floor_ends, floor_opens, pair_begins, pair_ends, pair_opens };

struct Next {
    double at = never;  // θ within a piece, or time in motion A
    Switch what = Switch::none;
    HL_FN void consider(double when, Switch candidate) {
        if (when < at) {
            at = when;
            what = candidate;
        }
    }
};

// Which event functions the last switch put exactly on zero.
struct OnSurface {
    bool u = false, w = false, l1 = false, l2 = false;
};

// A contact that is not closed is either open (gap >= 0) or overlaps with its force clipped to zero.
struct Phase {
    bool floor = false, pair = false;          // force acts
    bool floor_open = true, pair_open = true;  // gap >= 0
};

HL_FN Next next_in_flight(const TwoBall& s, const Gaps& x, const Phase& p) {
    Next next;
    if (p.floor_open) {
        next.consider(first_fall(x.u, x.du, s.gravity), Switch::floor_begins);
    } else {
        next.consider(first_rise(x.u, x.du, s.gravity), Switch::floor_opens);
        next.consider(first_fall(x.u + s.c1 * x.du, x.du - s.c1 * s.gravity, s.gravity),
                      Switch::floor_begins);
    }
    if (p.pair_open)
        next.consider(first_fall(x.w, x.dw, 0.0), Switch::pair_begins);
    else
        next.consider(first_rise(x.w, x.dw, 0.0), Switch::pair_opens);
    return next;
}

HL_FN Next next_in_piece(const Piece& piece, const Phase& p, const OnSurface& on) {
    Next next;
    if (p.floor) {
        next.consider(first_crossing<order - 1>(piece.l1, 1.0, on.l1), Switch::floor_ends);
    } else if (p.floor_open) {
        next.consider(first_crossing<order>(piece.u, -1.0, on.u), Switch::floor_begins);
    } else {
        next.consider(first_crossing<order>(piece.u, 1.0, on.u), Switch::floor_opens);
        next.consider(first_crossing<order - 1>(piece.l1, -1.0, on.l1), Switch::floor_begins);
    }
    if (p.pair) {
        next.consider(first_crossing<order - 1>(piece.l2, 1.0, on.l2), Switch::pair_ends);
    } else if (p.pair_open) {
        next.consider(first_crossing<order>(piece.w, -1.0, on.w), Switch::pair_begins);
    } else {
        next.consider(first_crossing<order>(piece.w, 1.0, on.w), Switch::pair_opens);
        next.consider(first_crossing<order - 1>(piece.l2, -1.0, on.l2), Switch::pair_begins);
    }
    return next;
}

}  // namespace hardlimit::column::exact
