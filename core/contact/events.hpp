// Events of a pair of bodies: when a contact begins and ends, and when a pair that overlaps without force engages.
//
// A pair is open, closed (a force acts) or slack (overlap without force). Each event has a function that falls to zero
// there (d = depth of the law's slack at the present rate):
//   begins   open → closed     −ξ                       opens     slack → open     ξ
//   ends     closed → slack    s − max(d, 0)^{1/p}      engages   slack → closed   −(ξ − d)   (a new contact)
// That of `ends` is ξ − d, written so that its zero is simple even for d → 0, where ξ − d has a multiple zero.
#pragma once
#include "../base/event_location.hpp"
#include "law.hpp"

namespace hardlimit {

enum class ContactEvent : unsigned char {
    none,
    begins,
    ends,
    opens,
    engages,
    parts,    // of a column: a pressed pair separates
    deepens,  // the largest compression of the law is reached
};

// Motion of a pair within a step; slopes are derivatives in the step's variable.
struct PairMotion {
    double depth, depth_slope;  // ξ
    double rate, rate_slope;    // dξ/dt; the slope counts for `ends` and `engages` only
    bool rooted;                // s = ξ^{1/p} is integrated
    double s, s_slope;          // if rooted
};

// The function of `begins`, `ends`, `opens` or `engages`.
template <class Law>
EventFunction event_function(const Law& law, ContactEvent kind, const PairMotion& m) {
    constexpr int p = Law::onset_power;
    const auto simple = [](double f, double slope) { return EventFunction{f, slope, f, slope}; };
    if (kind == ContactEvent::begins) return simple(-m.depth, -m.depth_slope);
    if (kind == ContactEvent::opens) return simple(m.depth, m.depth_slope);
    const Slack slack = law.slack(m.rate);
    const double excess = m.depth - slack.depth, excess_slope = m.depth_slope - slack.slope * m.rate_slope;
    if (kind == ContactEvent::engages) return simple(-excess, -excess_slope);
    if (!m.rooted) return simple(excess, excess_slope);
    if (!(slack.depth > 0.0)) return {m.s, m.s_slope, excess, excess_slope};
    const double least = onset_root<p>(slack.depth);
    const double exponent = slack.slope * m.rate / slack.depth;  // d ln depth/d ln rate
    return {m.s - least, m.s_slope - least * m.rate_slope * exponent / (p * m.rate), excess, excess_slope};
}

// When a slack pair engages in free flight: first t >= 0 at which ξ(t) = depth + rate t + g t²/2 reaches the law's
// slack at the rate then, rate + g t; infinity if the pair opens first. `fresh`: the pair was just placed on this zero.
// A law with a relaxation time has a closed form.
//
// For any other law: while the bodies separate, ξ and the slack both fall with time. Within an interval of time their
// difference is therefore at most ξ at its begin minus the slack at its end. If this is negative, the interval holds no
// zero; otherwise the interval is halved, down to rounding, so that no zero is missed.
template <class Law>
double time_to_engage(const Law& law, double depth, double rate, double g, bool fresh) {
    if constexpr (requires { law.relaxation_time(); }) {
        // ξ + τ_r rate = −missing now, growing as (rate + τ_r g) t + g t²/2.
        const double relaxation = law.relaxation_time(), speed = rate + relaxation * g;
        const double missing = fresh ? 0.0 : math::max(-depth - relaxation * rate, 0.0);
        const double grown = math::sqrt(speed * speed + 2.0 * g * missing);
        if (speed > 0.0) return 2.0 * missing / (speed + grown);
        return g > 0.0 ? (grown - speed) / g : math::infinity;
    }
    if (rate >= 0.0) return rate > 0.0 || g > 0.0 ? 0.0 : math::infinity;
    if (!(g > 0.0)) return math::infinity;
    const auto compression = [&](double t) { return depth + t * (rate + 0.5 * g * t); };
    const auto slack = [&](double t) { return law.slack(rate + g * t).depth; };
    const double turn = -rate / g;  // the bodies stop separating, and push if they still overlap
    const double square = rate * rate - 2.0 * g * depth;
    const double last = square > 0.0 ? 2.0 * depth / (math::sqrt(square) - rate) : turn;
    const double finest = 2.0 * math::epsilon * last;
    double t = 0.0, stretch = last;
    if (fresh) {
        if (rate - law.slack(rate).slope * g >= 0.0) return 0.0;
        for (t = last; compression(t) >= slack(t); t *= 0.5)
            if (t <= finest) return 0.0;
        stretch = math::min(t, last - t);
    }
    while (t < last) {
        const double next = math::min(t + stretch, last);
        if (compression(t) < slack(next)) {
            t = next;
            stretch *= 2.0;
        } else if (stretch <= finest) {
            return next;
        } else {
            stretch *= 0.5;
        }
    }
    return square > 0.0 ? math::infinity : turn;
}

}  // namespace hardlimit
