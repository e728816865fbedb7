// Interface of the exact solver in SI units: solves a two-ball drop, records it and samples it at any time.
#pragma once
#include <algorithm>

#include "../../base/stop.hpp"
#include "../compression.hpp"
#include "../energies.hpp"
#include "../state.hpp"
#include "compressions.hpp"
#include "run.hpp"
#include "scaling.hpp"

namespace hardlimit::column {

using LinearColumn = Column<contact::LinearDashpot>;

// Observer that records the contacts of a run and, if keep_nodes, its nodes (at most max_pieces).
struct Recorder {
    bool keep_nodes = true;
    Stop* stop = nullptr;
    drop::Compressions* watched = nullptr;  // ends the run where a contact reaches its limit
    std::vector<Node> nodes{};
    std::vector<Contact> contacts{};
    long open[2] = {-1, -1};
    Node last{};
    double released = math::nan;  // time of the first node

    void node(const Node& n) {
        if (keep_nodes) nodes.push_back(n);
        if (math::is_nan(released))
            released = n.t;
        else if (watched)
            watched->track(last, n.t - last.t);
        last = n;
    }
    bool stopped() const { return (watched && watched->too_deep >= 0) || (stop && (*stop)()); }
    void clock_restarts(double t) { shift(t); }
    void begins(int pair, double t) {
        open[pair] = static_cast<long>(contacts.size());
        contacts.push_back({pair, t, math::nan});
    }
    void ends(int pair, double t) { contacts[static_cast<std::size_t>(open[pair])].end = t; }

    // Sets the origin of time to t.
    void shift(double t) {
        last.t -= t;
        released -= t;
        for (Node& n : nodes) n.t -= t;
        for (Contact& k : contacts) k = {k.pair, k.begin - t, k.end - t};
    }
};

// A solved drop.
struct Drop {
    Start start;
    Sequence sequence;              // SI
    std::vector<Contact> contacts;  // SI
    std::vector<Node> nodes;        // scaled, times from the first floor touch
    int too_deep = -1;              // pair that was compressed too much; −1: none
};

// State at one time in SI units: gaps and forces of floor and pair, velocities of lower and upper ball.
struct DropSample {
    double gap[2], velocity[2], force[2];
    Energies energies;
};

namespace drop {

struct Mechanical {
    double kinetic, potential, stored;
    double sum() const { return kinetic + potential + stored; }
};

inline Mechanical mechanical_energy(const LinearColumn& c, const Units& units, const Gaps& x) {
    const double length = units.speed / units.rate, m1 = c.mass[0], m2 = c.mass[1];
    const double v1 = x.du * units.speed, v2 = v1 + x.dw * units.speed;
    return {0.5 * (m1 * v1 * v1 + m2 * v2 * v2), c.gravity * length * ((m1 + m2) * x.u + m2 * x.w),
            c.contacts[0].energy(math::max(0.0, -x.u * length)) +
                c.contacts[1].energy(math::max(0.0, -x.w * length))};
}

// Abscissae and weights of the eight-point Gauss rule on [−1, 1].
inline constexpr double gauss_at[4] = {0.18343464249564980494, 0.52553240991632898582, 0.79666647741362673959,
                                       0.96028985649753623168};
inline constexpr double gauss_weight[4] = {0.36268378337836198297, 0.31370664587788728734,
                                           0.22238103445337447054, 0.10122853629037625915};

// Energy dissipated by the dashpots in motion C of the adiabatic model. It is not the loss of mechanical energy,
// because the model neglects the work of the reaction. Over a time t it is a quadratic form W(t) of the state, with
// W(2t) = W(t) + Φᵀ W(t) Φ, Φ = exp(M t).
inline double double_contact_work(const LinearColumn& c, const Start& s, const Gaps& x, double t) {
    const TwoBall& groups = s.groups;
    const double half_piece = 0.5 * exact::piece_length(groups, true, true);
    int doublings = 0;
    for (; t > half_piece && doublings < exact::most_doublings; ++doublings) t *= 0.5;
    double form[4][4] = {};
    for (int j = 0; j < 8; ++j) {
        const double at = 0.5 * t * (1.0 + (j < 4 ? -gauss_at[j] : gauss_at[j - 4]));
        const exact::Propagator p = exact::Propagator::of(groups, at);
        for (int a = 0; a < 4; ++a)
            for (int b = 0; b < 4; ++b)
                form[a][b] += 0.5 * t * gauss_weight[j % 4] *
                              (c.contacts[0].damping * p.at(1, a) * p.at(1, b) +
                               c.contacts[1].damping * p.at(3, a) * p.at(3, b));
    }
    for (exact::Propagator p = exact::Propagator::of(groups, t); doublings > 0; --doublings, p = p.squared())
        p.double_form(form);
    const double w0 = -groups.gravity / groups.b2;
    const double from[4] = {x.u - w0 / groups.a1, x.du, x.w - w0, x.dw};
    double work = 0.0;
    for (int a = 0; a < 4; ++a)
        for (int b = 0; b < 4; ++b) work += from[a] * form[a][b] * from[b];
    return work * s.units.speed * s.units.speed / s.units.rate;
}

// Energy dissipated within dt after a node: by the dashpots, and by overlaps without force, whose stored energy is lost
// as they open. The eight-point Gauss rule on half pieces is exact to rounding. Over many pieces the result is the loss
// of mechanical energy.
inline double dissipated_over(const LinearColumn& c, const Start& s, const Node& n, double dt) {
    const double speed2 = s.units.speed * s.units.speed;
    const auto power = [&](const Gaps& x) {
        return ((n.floor ? c.contacts[0].damping * x.du * x.du : 0.0) +
                (n.pair ? c.contacts[1].damping * x.dw * x.dw : 0.0)) *
               speed2 / s.units.rate;
    };
    double work = 0.0;
    if ((n.floor && c.contacts[0].damping > 0.0) || (n.pair && c.contacts[1].damping > 0.0)) {
        const double h = exact::piece_length(s.groups, n.floor, n.pair);
        const bool together = n.floor && n.pair;
        if (together && !(s.groups.a2 > 0.0) && dt > 8.0 * h) return double_contact_work(c, s, n.x, dt);
        if (dt > (together ? 8.0 : 100.0) * h) {
            return mechanical_energy(c, s.units, n.x).sum() -
                   mechanical_energy(c, s.units, state_at(s.groups, n, dt)).sum();
        }
        const int pieces = static_cast<int>(dt / (0.5 * h)) + 1;
        const double half = 0.5 * dt / pieces;
        for (int i = 0; i < pieces; ++i)
            for (int j = 0; j < 4; ++j)
                work += half * gauss_weight[j] *
                        (power(state_at(s.groups, n, half * (2 * i + 1 - gauss_at[j]))) +
                         power(state_at(s.groups, n, half * (2 * i + 1 + gauss_at[j]))));
    }
    const double length = s.units.speed / s.units.rate;
    const Gaps end = state_at(s.groups, n, dt);
    const auto lost = [&](const contact::LinearDashpot& k, double before, double after) {
        return k.energy(math::max(0.0, -before * length)) - k.energy(math::max(0.0, -after * length));
    };
    if (!n.floor) work += lost(c.contacts[0], n.x.u, end.u);
    if (!n.pair) work += lost(c.contacts[1], n.x.w, end.w);
    return work;
}

inline CompressionBound bound_of(const LinearColumn& c, Coupling coupling, double part) {
    return CompressionBound{.m1 = c.mass[0],
                            .m2 = c.mass[1],
                            .gravity = c.gravity,
                            .height = c.gaps[0],
                            .v1 = c.velocity[0],
                            .v2 = c.velocity[1],
                            .coupled = coupling == Coupling::full}
        .within(part, c.radius[0], c.radius[1], c.contacts[0], c.contacts[1]);
}

// Time up to which contacts may last: infinity at rest unless `until` is given, otherwise `last`.
inline double lasts(const Sequence& q, double last, double span) {
    return q.outcome == Outcome::at_rest && span == -math::infinity ? math::infinity : last;
}

// Runs the solver, tracks the compressions and ends the run where one reaches its limit.
inline Sequence run_watched(const Start& s, const CompressionBound& bound, double span, Recorder& record,
                            Compressions& watch) {
    watch = Compressions(s.groups, bound.floor * s.per_metre, bound.pair * s.per_metre);
    record.watched = &watch;
    Sequence q = run_two_ball(s.groups, s.first, s.t, span, record);
    if (lasts(q, 0.0, span) > 0.0) watch.track(record.last, exact::never);
    if (watch.too_deep < 0) return q;
    // The run may have applied one event after that instant.
    const auto later = [&](const Contact& k) { return k.begin > watch.at; };
    if (!q.second_floor_contact && !q.finished)
        q.n_contacts -=
            static_cast<int>(std::count_if(record.contacts.begin(), record.contacts.end(),
                                           [&](const Contact& k) { return k.pair == 1 && later(k); }));
    std::erase_if(record.contacts, later);
    for (Contact& k : record.contacts)
        if (k.end > watch.at) k.end = math::nan;
    std::erase_if(record.nodes, [&](const Node& n) { return n.t > watch.at; });
    q.goes_too_deep(watch.at);
    if (record.keep_nodes) record.nodes.push_back(watch.there);
    if (watch.at < 0.0) {  // the floor was not touched: time counts from release
        q.t_first_touch = math::nan;
        record.shift(record.released);
    }
    return q;
}

// Solves the sequence, in scaled units.
inline Sequence sequence_of(const Start& s, const CompressionBound& bound, double gap, double span,
                            Stop* stop) {
    const DropBound sure = DropBound::of(bound, gap, s.units.speed);
    if (sure.holds(0.0)) {
        NoRecorder none{stop};
        const Sequence q = run_two_ball(s.groups, s.first, s.t, span, none);
        const bool given_up = stop && stop->stopped();
        if (given_up || sure.holds(lasts(q, none.last, span) / s.units.rate)) return q;
    }
    Recorder record{.keep_nodes = false, .stop = stop};
    Compressions watch(s.groups);
    return run_watched(s, bound, span, record, watch);
}

inline TwoBalls two_balls(const LinearColumn& c) {
    return {.m1 = c.mass[0],
            .m2 = c.mass[1],
            .gravity = c.gravity,
            .released = {c.gaps[0], c.velocity[0], c.gaps[1], c.velocity[1] - c.velocity[0]}};
}
inline Start start_drop(const LinearColumn& c, Coupling coupling) {
    return start_two_ball(c.contacts[0], c.contacts[1], two_balls(c), coupling);
}

// `until` [s] in scaled time, at most 2^52: beyond that, doubles cannot resolve a contact.
inline double scaled_span(double until, const Units& units) {
    return math::is_nan(until) ? -math::infinity : math::min(until * units.rate, 0x1p52);
}

// Whether the energies at the last node exclude the compressions of `bound` at all later times.
inline bool settles(const LinearColumn& c, const Drop& d, CompressionBound bound) {
    const Units& units = d.start.units;
    const Gaps& x = d.nodes.back().x;
    const double metre = units.speed / units.rate;
    bound.height = x.u * metre;
    bound.v1 = x.du * units.speed;
    bound.v2 = (x.du + x.dw) * units.speed;
    bound.stored = mechanical_energy(c, units, x).stored;
    return bound.excluded_until(x.w * metre) == math::infinity;
}

}  // namespace drop

// Solves only the sequence, in SI units.
inline Sequence solve_drop_sequence(const LinearColumn& c, Coupling coupling, double until, Stop* stop) {
    const Start s = drop::start_drop(c, coupling);
    Sequence q;
    q.outcome = s.outcome;
    if (s.outcome != Outcome::ok) return q;
    q = drop::sequence_of(s, drop::bound_of(c, coupling, deepest_compression), c.gaps[1],
                          drop::scaled_span(until, s.units), stop);
    to_si(q, s.units);
    return q;
}

inline Drop solve_drop(const LinearColumn& c, Coupling coupling, double until, bool keep_nodes, Stop* stop) {
    Drop d;
    d.start = drop::start_drop(c, coupling);
    d.sequence.outcome = d.start.outcome;
    if (d.start.outcome != Outcome::ok) return d;
    const Start& start = d.start;
    const Units units = start.units;
    const CompressionBound bound = drop::bound_of(c, coupling, deepest_compression);
    const double span = drop::scaled_span(until, units);
    drop::Compressions watch(start.groups);
    Recorder record;
    const auto restart = [&] {
        record = {.keep_nodes = keep_nodes, .stop = stop};
        if (start.t == 0.0 && start.fall > 0.0) record.node({-start.fall, start.released, false, false});
    };
    const DropBound sure = DropBound::of(bound, c.gaps[1], units.speed);
    bool shallow = sure.holds(0.0);
    if (shallow) {
        restart();
        d.sequence = run_two_ball(start.groups, start.first, start.t, span, record);
        const double end = drop::lasts(d.sequence, record.last.t, span) / units.rate;
        shallow = sure.holds(end) || (stop && stop->stopped());
    }
    if (!shallow) {
        restart();
        d.sequence = drop::run_watched(start, bound, span, record, watch);
        d.too_deep = watch.too_deep;
    }
    const double t0 = math::is_nan(d.sequence.t_first_touch) ? 0.0 : d.sequence.t_first_touch;
    for (Contact& k : record.contacts) k = {k.pair, (k.begin - t0) / units.rate, (k.end - t0) / units.rate};
    for (Node& n : record.nodes) n.t -= t0;
    to_si(d.sequence, units);
    d.contacts = std::move(record.contacts);
    d.nodes = std::move(record.nodes);
    return d;
}

// Dissipated energy up to each node [J]; incomplete if stopped.
inline std::vector<double> dissipated_energy(const LinearColumn& c, const Drop& d, Stop& stop) {
    std::vector<double> sum{0.0};
    for (std::size_t i = 0; i + 1 < d.nodes.size() && !stop(); ++i)
        sum.push_back(sum[i] +
                      drop::dissipated_over(c, d.start, d.nodes[i], d.nodes[i + 1].t - d.nodes[i].t));
    return sum;
}

// State, forces and energies at time t [s after the first floor touch], within the recorded span. `dissipated` is the
// result of dissipated_energy().
inline DropSample sample_drop(const LinearColumn& c, const Drop& d, const std::vector<double>& dissipated,
                              double t) {
    const TwoBall& s = d.start.groups;
    const Units units = d.start.units;
    const double at = t * units.rate, length = units.speed / units.rate;
    const auto after = std::upper_bound(d.nodes.begin() + 1, d.nodes.end(), at,
                                        [](double time, const Node& n) { return time < n.t; });
    const std::size_t lo = static_cast<std::size_t>(after - d.nodes.begin()) - 1;
    const Node& n = d.nodes[lo];
    const Gaps x = drop::state_at(s, n, at - n.t);
    const drop::Mechanical energy = drop::mechanical_energy(c, units, x);
    const double u = x.u * length, w = x.w * length, du = x.du * units.speed, dw = x.dw * units.speed;
    return {{u, w},
            {du, du + dw},
            {n.floor ? math::max(0.0, c.contacts[0].force(-u, -du)) : 0.0,
             n.pair ? math::max(0.0, c.contacts[1].force(-w, -dw)) : 0.0},
            {energy.kinetic, energy.potential, energy.stored,
             dissipated[lo] + drop::dissipated_over(c, d.start, n, at - n.t)}};
}

}  // namespace hardlimit::column
