// Two balls in SI units through the exact solver: start of the drop, recording, sampling anywhere.
#pragma once
#include "../state.hpp"
#include "run.hpp"
#include "scaling.hpp"

namespace hardlimit::column {

using LinearColumn = Column<contact::LinearDashpot>;

// What a recorded run keeps.
struct Recorder {
    std::vector<Node> nodes;
    std::vector<Contact> contacts;
    long open[2] = {-1, -1};

    void node(const Node& n) { nodes.push_back(n); }
    void clock_restarts(double t) {
        for (Node& n : nodes) n.t -= t;
        for (Contact& k : contacts) k = {k.pair, k.begin - t, k.end - t};
    }
    void begins(int pair, double t) {
        open[pair] = static_cast<long>(contacts.size());
        contacts.push_back({pair, t, math::nan});
    }
    void ends(int pair, double t) { contacts[static_cast<std::size_t>(open[pair])].end = t; }
};

struct Drop {
    Start start;
    Sequence sequence;               // SI
    std::vector<Contact> contacts;   // SI
    std::vector<Node> nodes;         // scaled, times from the first floor touch
    std::vector<double> dissipated;  // [J] up to each node
};

// One state on the way, in SI units.
struct DropSample {
    double u, w, du, dw;                            // gaps [m] and their rates [m/s]
    double force_floor, force_pair;                 // [N]
    double kinetic, potential, stored, dissipated;  // [J]; potential is zero when both gaps are
};

namespace drop {

inline Gaps state_at(const TwoBall& s, const Node& n, double dt) {
    if (dt == 0.0) return n.x;
    if (!n.floor && !n.pair) return exact::fly<double>(s, n.x, dt);
    if (n.floor && !n.pair) return exact::lie_on_floor(s, n.x, dt);
    exact::Piece piece;
    const double h = exact::piece_length(s, n.floor, n.pair);
    if (n.floor && dt > 8.0 * h) return exact::lie_together(s, n.x, dt);
    Gaps x = n.x;
    for (; dt > h; dt -= h) {
        exact::expand(s, x, n.floor, n.pair, h, piece);
        x = exact::evaluate(piece, 1.0);
    }
    exact::expand(s, x, n.floor, n.pair, dt, piece);
    return exact::evaluate(piece, 1.0);
}

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

// Work done by the dashpots, and energy that a contact still stores when its clipped force vanishes, from the node
// over dt: an eight-point Gauss rule on half pieces is exact to rounding. A force-free overlap gives its stored
// energy away. Over a long rest it is what the mechanical energy loses.
inline double dissipated_over(const LinearColumn& c, const Start& s, const Node& n, double dt) {
    static constexpr double at[4] = {0.18343464249564980494, 0.52553240991632898582, 0.79666647741362673959,
                                     0.96028985649753623168};
    static constexpr double weight[4] = {0.36268378337836198297, 0.31370664587788728734,
                                         0.22238103445337447054, 0.10122853629037625915};
    const double speed2 = s.units.speed * s.units.speed;
    const auto power = [&](const Gaps& x) {
        return ((n.floor ? c.contacts[0].damping * x.du * x.du : 0.0) +
                (n.pair ? c.contacts[1].damping * x.dw * x.dw : 0.0)) *
               speed2 / s.units.rate;
    };
    double work = 0.0;
    if (n.floor || n.pair) {
        const double h = exact::piece_length(s.groups, n.floor, n.pair);
        if (dt > 100.0 * h) {
            return mechanical_energy(c, s.units, n.x).sum() -
                   mechanical_energy(c, s.units, state_at(s.groups, n, dt)).sum();
        }
        const int pieces = static_cast<int>(dt / (0.5 * h)) + 1;
        const double half = 0.5 * dt / pieces;
        for (int i = 0; i < pieces; ++i)
            for (int j = 0; j < 4; ++j)
                work += half * weight[j] *
                        (power(state_at(s.groups, n, half * (2 * i + 1 - at[j]))) +
                         power(state_at(s.groups, n, half * (2 * i + 1 + at[j]))));
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

}  // namespace drop

inline Drop solve_drop(const LinearColumn& c, Coupling coupling, double until) {
    Drop d;
    d.start = start_two_ball(c.contacts[0], c.contacts[1], c.mass[0], c.mass[1], c.gravity,
                             {c.gaps[0], c.velocity[0], c.gaps[1], c.velocity[1] - c.velocity[0]}, coupling);
    d.sequence.outcome = d.start.outcome;
    if (d.start.outcome != Outcome::ok) return d;
    const Units units = d.start.units;
    Recorder record;
    if (d.start.t == 0.0 && d.start.fall > 0.0) record.node({-d.start.fall, d.start.released, false, false});
    const double end = math::is_nan(until) ? -math::infinity : until * units.rate;
    d.sequence = run_two_ball(d.start.groups, d.start.first, d.start.t, end, record);
    const double t0 = math::is_nan(d.sequence.t_first_touch) ? 0.0 : d.sequence.t_first_touch;
    for (Contact& k : record.contacts) k = {k.pair, (k.begin - t0) / units.rate, (k.end - t0) / units.rate};
    for (Node& n : record.nodes) n.t -= t0;
    to_si(d.sequence, units);
    d.contacts = std::move(record.contacts);
    d.nodes = std::move(record.nodes);
    return d;
}

// State, forces and energies at time t [s after the first floor touch], within the recorded span.
inline DropSample sample_drop(const LinearColumn& c, Drop& d, double t) {
    const TwoBall& s = d.start.groups;
    const Units units = d.start.units;
    if (d.dissipated.empty()) {
        d.dissipated.push_back(0.0);
        for (std::size_t i = 0; i + 1 < d.nodes.size(); ++i)
            d.dissipated.push_back(d.dissipated[i] + drop::dissipated_over(c, d.start, d.nodes[i],
                                                                           d.nodes[i + 1].t - d.nodes[i].t));
    }
    const double at = t * units.rate;
    std::size_t lo = 0, hi = d.nodes.size();
    while (hi - lo > 1) {
        const std::size_t mid = (lo + hi) / 2;
        (d.nodes[mid].t <= at ? lo : hi) = mid;
    }
    const Node& n = d.nodes[lo];
    const Gaps x = drop::state_at(s, n, at - n.t);
    const double length = units.speed / units.rate;
    const drop::Mechanical energy = drop::mechanical_energy(c, units, x);
    DropSample r{x.u * length, x.w * length,   x.du * units.speed, x.dw * units.speed, 0.0,
                 0.0,          energy.kinetic, energy.potential,   energy.stored,      0.0};
    if (n.floor) r.force_floor = math::max(0.0, c.contacts[0].force(-r.u, -r.du));
    if (n.pair) r.force_pair = math::max(0.0, c.contacts[1].force(-r.w, -r.dw));
    r.dissipated = d.dissipated[lo] + drop::dissipated_over(c, d.start, n, at - n.t);
    return r;
}

}  // namespace hardlimit::column
