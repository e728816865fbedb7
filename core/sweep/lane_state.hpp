// Code common to the vector kernels of all contact laws: the state with one drop in each lane, the events of
// column/sequence.hpp, free flight, loading a drop into a lane and storing its result.
#pragma once
#include "../column/exact/run.hpp"
#include "kernel_abi.hpp"

namespace hardlimit::sweep {

using hardlimit_abi::Batch;
using hardlimit_abi::Status;

namespace lanes {

using column::GapState;
using column::Groups;
using column::exact::never;

template <class R>
struct State {
    using M = Mask<R>;
    Groups<R> s;
    GapState<R> x;
    R t, t_first, t_end, t_floor_end, relative, separation, contacts, pieces;
    // Contacts that are closed; contacts that are open (gap >= 0); event functions that are exactly zero.
    M floor, pair, floor_open, pair_open, on_u, on_w, on_l1, on_l2;
    M opened, second_floor_contact, counted, active, unsolved;
    M large_step_tried;  // large_step() has already been applied to the current pair contact
    M floor_may_end;     // the floor contact may end before the pair contact
    R pair_end;          // time until the first zero of L2; valid if `floor_may_end`
};

template <class R>
HL_FN R constant(double x) {
    return broadcast<R>(x);
}

template <class R>
HL_FN void assign(Mask<R> m, R& to, R value) {
    to = select<R>(m, value, to);
}
template <class R>
HL_FN void assign(Mask<R> m, GapState<R>& to, const GapState<R>& value) {
    assign<R>(m, to.u, value.u);
    assign<R>(m, to.du, value.du);
    assign<R>(m, to.w, value.w);
    assign<R>(m, to.dw, value.dw);
}

template <class M>
HL_FN void set(M& flag, Same<M> where, Same<M> value) {
    flag = (flag & negation(where)) | (value & where);
}
template <class M>
HL_FN void raise(M& flag, Same<M> where) {
    flag = flag | where;
}
template <class M>
HL_FN void clear(M& flag, Same<M> where) {
    flag = flag & negation(where);
}

// ---- events: the definitions of column/sequence.hpp, lane by lane ---------------------------------------------
// This is a second implementation of column::Sequence. The scalar one branches and counts the open contacts of any
// number of pairs; a lane holds two balls, needs only one bit for that count, and cannot branch.
// tests/column/test_sequence_rules.py compares the two over random events.

template <class R>
HL_FN void finish(State<R>& q, Mask<R> m) {
    clear(q.active, m);
}

template <class R>
HL_FN void floor_begins(State<R>& q, Mask<R> m) {
    if (!any(m)) return;
    const Mask<R> fresh = m & q.floor_open, again = m & negation(q.floor_open);
    assign<R>(fresh, q.x.u, R{});
    assign<R>(again, q.x.u, -q.s.c1 * q.x.du);
    set(q.on_u, m, fresh);
    set(q.on_l1, m, again | (fresh & ((q.s.c1 == 0.0) | (q.x.du == 0.0))));
    raise(q.floor, m);
    clear(q.floor_open, m);
    const Mask<R> first = m & math::is_nan(q.t_first), second = m & negation(first) & q.opened;
    // The first floor touch becomes the origin of time.
    assign<R>(first, q.t_end, q.t_end - q.t);
    assign<R>(first, q.t_first, R{});
    assign<R>(first, q.t, R{});
    raise(q.second_floor_contact, second);
    finish<R>(q, second & negation(q.counted));
}

template <class R>
HL_FN void floor_ends(State<R>& q, Mask<R> m) {
    if (!any(m)) return;
    assign<R>(m, q.x.u, -q.s.c1 * q.x.du);
    raise(q.on_l1, m);
    clear(q.floor, m);
    const Mask<R> open = q.s.c1 == 0.0;
    set(q.floor_open, m, open);
    set(q.on_u, m, open);
    assign<R>(m & math::is_nan(q.t_floor_end), q.t_floor_end, q.t);
    raise(q.opened, m & open);
}

template <class R>
HL_FN void floor_opens(State<R>& q, Mask<R> m) {
    assign<R>(m, q.x.u, R{});
    raise(q.on_u, m);
    raise(q.floor_open, m);
    raise(q.opened, m);
}

template <class R>
HL_FN void pair_begins(State<R>& q, Mask<R> m) {
    if (!any(m)) return;
    const Mask<R> fresh = m & q.pair_open, again = m & negation(q.pair_open);
    assign<R>(fresh, q.x.w, R{});
    assign<R>(again, q.x.w, -q.s.c2 * q.x.dw);
    set(q.on_w, m, fresh);
    set(q.on_l2, m, again | (fresh & ((q.s.c2 == 0.0) | (q.x.dw == 0.0))));
    raise(q.pair, m);
    clear(q.pair_open, m);
    clear(q.large_step_tried, m);
    const Mask<R> belongs = m & negation(q.second_floor_contact);
    set(q.counted, m, belongs);
    assign<R>(belongs, q.contacts, q.contacts + 1.0);
    const R unknown = constant<R>(math::nan);
    assign<R>(belongs, q.relative, unknown);
    assign<R>(belongs, q.separation, unknown);
    assign<R>(belongs, q.t_end, unknown);
}

template <class R>
HL_FN void pair_ends(State<R>& q, Mask<R> m) {
    if (!any(m)) return;
    assign<R>(m, q.x.w, -q.s.c2 * q.x.dw);
    raise(q.on_l2, m);
    clear(q.pair, m);
    const Mask<R> open = q.s.c2 == 0.0;
    set(q.pair_open, m, open);
    set(q.on_w, m, open);
    const Mask<R> belongs = m & q.counted;
    assign<R>(belongs, q.t_end, q.t);
    assign<R>(belongs, q.relative, q.x.dw);
    clear(q.counted, m);
    finish<R>(q, belongs & q.second_floor_contact);
}

template <class R>
HL_FN void pair_opens(State<R>& q, Mask<R> m) {
    assign<R>(m, q.x.w, R{});
    raise(q.on_w, m);
    raise(q.pair_open, m);
}

template <class R>
HL_FN void moves_freely(State<R>& q, Mask<R> m) {
    const Mask<R> apart = m & (q.x.dw >= 0.0);
    assign<R>(apart & (q.contacts > 0.0) & math::is_nan(q.separation), q.separation, q.x.dw);
    finish<R>(q, apart & q.opened & q.floor_open);
}

// Advances the lanes of m by dt to the state y; for dt > 0 no event function remains exactly zero.
template <class R>
HL_FN void advance(State<R>& q, Mask<R> m, R dt, const GapState<R>& y) {
    const Mask<R> moved = m & (dt > 0.0);
    assign<R>(moved, q.x, y);
    assign<R>(moved, q.t, q.t + dt);
    clear(q.floor_may_end, m);
    clear(q.on_u, moved);
    clear(q.on_w, moved);
    clear(q.on_l1, moved);
    clear(q.on_l2, moved);
}

// ---- free flight (motion A)
// -----------------------------------------------------------------------------------------------

// Vector form of column::exact::first_fall.
template <class R>
HL_FN R first_fall(R v, R s, R g) {
    const R root = math::sqrt<R>(s * s + 2.0 * g * v);
    const R rising = select<R>(g > 0.0, (s + root) / g, constant<R>(never));
    const R falling = select<R>(root - s > 0.0, 2.0 * v / (root - s), constant<R>(never));
    const R on_zero = select<R>((s < 0.0) | ((s == 0.0) & (g > 0.0)), R{},
                                select<R>(g > 0.0, 2.0 * s / g, constant<R>(never)));
    return select<R>(v <= 0.0, on_zero, select<R>(s > 0.0, rising, falling));
}
template <class R>
HL_FN R first_rise(R v, R s, R g) {
    const R square = s * s + 2.0 * g * v;
    const R t = -2.0 * v / (s + math::sqrt<R>(math::max<R>(square, R{})));
    return select<R>((s > 0.0) & (square >= 0.0), t, constant<R>(never));
}

template <class R>
HL_FN void free_motion(State<R>& q, Mask<R> m) {
    moves_freely<R>(q, m);
    m = m & q.active;
    if (!any(m)) return;
    const R G = q.s.gravity;
    const R down = first_fall<R>(q.x.u, q.x.du, G), up = first_rise<R>(q.x.u, q.x.du, G);
    const R press = first_fall<R>(q.x.u + q.s.c1 * q.x.du, q.x.du - q.s.c1 * G, G);
    const R floor_at = select<R>(q.floor_open, down, press);
    const R opens_at = select<R>(q.floor_open, constant<R>(never), up);
    const R pair_at = select<R>(q.pair_open, first_fall<R>(q.x.w, q.x.dw, R{}), constant<R>(never));
    const R parts_at = select<R>(q.pair_open, constant<R>(never), first_rise<R>(q.x.w, q.x.dw, R{}));
    const R first = math::min<R>(math::min<R>(floor_at, opens_at), math::min<R>(pair_at, parts_at));
    raise(q.unsolved, m & (first == never));  // never lands
    finish<R>(q, m & (first == never));
    m = m & q.active;
    const Mask<R> a = m & (opens_at == first), b = m & negation(a) & (floor_at == first);
    const Mask<R> c = m & negation(a | b) & (pair_at == first), d = m & negation(a | b | c);
    advance<R>(q, m, first, column::exact::free_motion<R>(q.s, q.x, select<R>(m, first, R{})));
    floor_opens<R>(q, a);
    floor_begins<R>(q, b);
    pair_begins<R>(q, c);
    pair_opens<R>(q, d);
}

// ---- batch -------------------------------------------------------------------------------------------------------

template <class M>
HL_FN void set_flag(M& to, int lane, bool value) {
    if constexpr (sizeof(M) == sizeof(bool))
        to = value;
    else
        set_lane(to, lane, value ? -1 : 0);
}

template <class M>
HL_FN int count(const M& m) {
    return bit_count(lane_bits(m));
}

// Whether the groups of drop i equal those of the previous one to a relative difference of `tolerance`.
HL_FN bool alike(const Batch& b, int i, double tolerance) {
    bool all = i > 0;
    for (int k = 0; k < hardlimit_abi::batch_groups && all; ++k)
        all = math::abs(b.in[k][i] - b.in[k][i - 1]) <= tolerance * math::abs(b.in[k][i]);
    return all;
}

// Number of idle lanes at which the next drops are loaded: a few, or `most` if the drops are similar, as neighbours in
// a map are. Similar drops take the same steps, and stay synchronous if loaded together.
template <class R>
HL_FN int due(const Batch& b, int next, int most) {
    return next < b.count && alike(b, next, 0.1) ? most : (Lanes<R>::count + 7) / 8;
}

// Loads the groups of drop i, or drop i of the batch, into a lane; start() initializes the rest of the state.
template <class R>
HL_FN void load(Groups<R>& s, int lane, const Batch& b, int i) {
    R* const to[] = {&s.a1, &s.a2, &s.c1, &s.c2, &s.gravity};
    for (int k = 0; k < hardlimit_abi::batch_groups; ++k) set_lane(*to[k], lane, b.in[k][i]);
}
template <class R>
HL_FN void load(State<R>& q, int lane, const Batch& b, int i) {
    load(q.s, lane, b, i);
    R* const to[] = {&q.x.u, &q.x.du, &q.x.w, &q.x.dw, &q.t};
    for (int k = hardlimit_abi::batch_groups; k < hardlimit_abi::batch_inputs; ++k)
        set_lane(*to[k - hardlimit_abi::batch_groups], lane, b.in[k][i]);
}

// Starts the drops just loaded into the lanes of m: in flight, or with the floor contact if it begins at once.
template <class R>
HL_FN void start(State<R>& q, Mask<R> m) {
    R* const unknown[] = {&q.t_first, &q.t_end, &q.t_floor_end, &q.relative, &q.separation};
    for (R* value : unknown) assign<R>(m, *value, constant<R>(math::nan));
    assign<R>(m, q.contacts, R{});
    assign<R>(m, q.pieces, R{});
    Mask<R>* const no[] = {&q.floor,        &q.pair,     &q.on_l1,
                           &q.on_l2,        &q.opened,   &q.second_floor_contact,
                           &q.counted,      &q.unsolved, &q.large_step_tried,
                           &q.floor_may_end};
    for (Mask<R>* flag : no) clear(*flag, m);
    Mask<R>* const yes[] = {&q.floor_open, &q.pair_open, &q.active};
    for (Mask<R>* flag : yes) raise(*flag, m);
    set(q.on_u, m, q.x.u == 0.0);
    set(q.on_w, m, q.x.w == 0.0);
    // Left to the scalar solver: a light lower ball (the momentum of the upper one would lose digits), and large
    // gravity (squares would overflow).
    const Mask<R> extreme =
        m & ((1.0 - q.s.a2 < column::light_below) | (q.s.gravity > column::strongest_gravity));
    raise(q.unsolved, extreme);
    finish<R>(q, extreme);
    floor_begins<R>(q, m & (q.x.u == 0.0) & (q.x.du < 0.0));
}

// Stores the result of a lane as drop i of the batch.
template <class R>
HL_FN void store(const State<R>& q, int lane, const Batch& b, int i) {
    const R* const from[] = {&q.contacts, &q.t_first, &q.t_end, &q.t_floor_end, &q.relative, &q.separation};
    for (int k = 0; k < hardlimit_abi::batch_outputs; ++k) b.out[k][i] = lane_of(*from[k], lane);
    b.status[i] = static_cast<int>(lane_of(q.unsolved, lane) ? Status::unsolved : Status::solved);
}

}  // namespace lanes

}  // namespace hardlimit::sweep
