// Largest compressions of floor and pair over the nodes of the exact solver.
#pragma once
#include "glide.hpp"

namespace hardlimit::column {

namespace drop {

// State a time dt after a node.
inline Gaps state_at(const TwoBall& s, const Node& n, double dt) {
    if (dt == 0.0) return n.x;
    if (!n.floor && !n.pair) return exact::free_motion<double>(s, n.x, dt);
    if (n.floor && !n.pair) return exact::floor_motion(s, n.x, dt);
    exact::Piece piece;
    const double h = exact::piece_length(s, n.floor, n.pair);
    if (n.floor && dt > 8.0 * h) return exact::double_contact_motion(s, n.x, dt);
    if (!n.floor && dt > 100.0 * h) return exact::pair_motion(s, n.x, dt);
    Gaps x = n.x;
    for (; dt > h; dt -= h) {
        exact::expand(s, x, n.floor, n.pair, h, piece);
        x = exact::evaluate(piece, 1.0);
    }
    exact::expand(s, x, n.floor, n.pair, dt, piece);
    return exact::evaluate(piece, 1.0);
}

// Tracks the largest compressions and detects the instant a contact reaches its limit. Scaled units.
class Compressions {
public:
    double greatest[2] = {0.0, 0.0};  // of floor and pair
    int too_deep = -1;                // contact that reached its limit; −1: none
    double at = exact::never;         // when it did
    Node there{};                     // state then

    explicit Compressions(const TwoBall& groups, double floor = exact::never, double pair = exact::never)
        : s(groups), limit{floor, pair} {}

    // Follows the motion for dt, possibly infinite, after a node. A gap has at most one extremum in a quarter of a
    // piece. After 4 pieces the step grows: by then a contact oscillates about its rest position or creeps.
    void track(const Node& n, double dt) {
        if (too_deep >= 0 || !(n.floor || n.pair)) return;
        const double least = 0.25 * exact::piece_length(s, n.floor, n.pair);
        dt = math::min(dt, 0x1p50 * least);
        Gaps from = n.x;
        for (double t = 0.0; t < dt && too_deep < 0;) {
            const double next = math::min(t + math::max(least, 0.0625 * t), dt);
            const Gaps to = state_at(s, n, next);
            double first = next;
            if (n.floor) compare(0, n, t, next, {from.u, from.du}, {to.u, to.du}, first);
            if (n.pair) compare(1, n, t, next, {from.w, from.dw}, {to.w, to.dw}, first);
            const bool still = same(from.u, to.u) && same(from.w, to.w) && n.floor && n.pair;
            if (still && t > 64.0 * least) break;  // at rest
            t = next;
            from = to;
        }
    }

private:
    struct Gap {
        double gap, rate;
    };
    TwoBall s;
    double limit[2];

    static bool same(double a, double b) { return math::abs(a - b) <= 4.0 * math::epsilon * math::abs(a); }
    Gap of(int j, const Node& n, double t) const {
        const Gaps x = state_at(s, n, t);
        return j == 0 ? Gap{x.u, x.du} : Gap{x.w, x.dw};
    }

    // Examines contact j between t and next. `first`: instant at which the other contact reaches its limit, or next.
    void compare(int j, const Node& n, double t, double next, Gap from, Gap to, double& first) {
        double deepest = math::min(from.gap, to.gap), turn = next;
        if (from.rate < 0.0 && to.rate > 0.0) {
            const auto closing = [&](double x) { return -of(j, n, x).rate; };
            turn = roots::falling_zero(closing, t, -from.rate, next, -to.rate, 1e-14 * (to.rate - from.rate));
            deepest = math::min(deepest, of(j, n, turn).gap);
        }
        greatest[j] = math::max(greatest[j], -deepest);
        const double left = limit[j] + from.gap, then = limit[j] + deepest;
        if (then > 0.0) return;
        const auto room = [&](double x) { return limit[j] + of(j, n, x).gap; };
        const double when = left > 0.0 ? roots::falling_zero(room, t, left, turn, then, 1e-15 * limit[j]) : t;
        if (too_deep >= 0 && !(when < first)) return;
        too_deep = j;
        first = when;
        greatest[j] = limit[j];
        at = n.t + when;
        there = {at, state_at(s, n, when), n.floor, n.pair};
    }
};

}  // namespace drop

}  // namespace hardlimit::column
