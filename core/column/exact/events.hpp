// Event detection for the exact two-ball solver: which contact begins, ends or opens next.
#pragma once
#include "motions.hpp"

namespace hardlimit::column::exact {

enum class Event { none, floor_begins, floor_ends, floor_opens, pair_begins, pair_ends, pair_opens };

struct NextEvent {
    double at = never;  // θ within a piece; time in free flight (motion A)
    Event what = Event::none;
    HL_FN void consider(double when, Event candidate) {
        if (when < at) {
            at = when;
            what = candidate;
        }
    }
};

// Event functions that the last event set exactly to zero: u, w, L1, L2.
struct OnSurface {
    bool u = false, w = false, l1 = false, l2 = false;
};

// A contact that is not closed is either open (gap >= 0) or overlaps with its force clipped to zero.
struct Phase {
    bool floor = false, pair = false;          // force acts
    bool floor_open = true, pair_open = true;  // gap >= 0
};

HL_FN NextEvent next_in_flight(const TwoBall& s, const Gaps& x, const Phase& p) {
    NextEvent next;
    if (p.floor_open) {
        next.consider(first_fall(x.u, x.du, s.gravity), Event::floor_begins);
    } else {
        next.consider(first_rise(x.u, x.du, s.gravity), Event::floor_opens);
        next.consider(first_fall(x.u + s.c1 * x.du, x.du - s.c1 * s.gravity, s.gravity), Event::floor_begins);
    }
    if (p.pair_open)
        next.consider(first_fall(x.w, x.dw, 0.0), Event::pair_begins);
    else
        next.consider(first_rise(x.w, x.dw, 0.0), Event::pair_opens);
    return next;
}

HL_FN NextEvent next_in_piece(const Piece& piece, const Phase& p, const OnSurface& on) {
    NextEvent next;
    if (p.floor) {
        next.consider(first_crossing<order - 1>(piece.l1, 1.0, on.l1), Event::floor_ends);
    } else if (p.floor_open) {
        next.consider(first_crossing<order>(piece.u, -1.0, on.u), Event::floor_begins);
    } else {
        next.consider(first_crossing<order>(piece.u, 1.0, on.u), Event::floor_opens);
        next.consider(first_crossing<order - 1>(piece.l1, -1.0, on.l1), Event::floor_begins);
    }
    if (p.pair) {
        next.consider(first_crossing<order - 1>(piece.l2, 1.0, on.l2), Event::pair_ends);
    } else if (p.pair_open) {
        next.consider(first_crossing<order>(piece.w, -1.0, on.w), Event::pair_begins);
    } else {
        next.consider(first_crossing<order>(piece.w, 1.0, on.w), Event::pair_opens);
        next.consider(first_crossing<order - 1>(piece.l2, -1.0, on.l2), Event::pair_begins);
    }
    return next;
}

}  // namespace hardlimit::column::exact
