// Event functions of a pair of bodies: begin and end of a contact, and onset of force in a pair that overlaps.
//
// A pair is open, closed (a force acts) or slack (overlap without force). Each event occurs where its event function
// falls to zero (d = depth of the law's slack at the current rate):
//   begins   open → closed     −ξ                       opens     slack → open     ξ
//   ends     closed → slack    s − max(d, 0)^{1/p}      engages   slack → closed   −(ξ − d)   (a new contact)
// The function of `ends` has the zero of ξ − d, but a simple one even for d → 0, where that of ξ − d is multiple.
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
    parts,    // column only: a pressed pair separates
    deepens,  // the law's largest admissible compression is reached
    turns,  // with friction: the compression begins to rise or to fall, and the history of the force changes
    slips,  // the surfaces begin to slip
    sticks,
};

// State of a pair within a step; slopes are derivatives with respect to the integration variable.
struct PairMotion {
    double depth, depth_slope;  // ξ
    double rate, rate_slope;    // dξ/dt; the slope is used for `ends` and `engages` only
    bool uses_root;             // the integrated coordinate is s = ξ^{1/p}
    double s, s_slope;          // if rooted
};

// Event function of `begins`, `ends`, `opens` or `engages`.
template <class Law>
EventFunction event_function(const Law& law, ContactEvent kind, const PairMotion& m) {
    constexpr int p = Law::onset_power;
    const auto simple = [](double f, double slope) { return EventFunction{f, slope, f, slope}; };
    if (kind == ContactEvent::begins) return simple(-m.depth, -m.depth_slope);
    if (kind == ContactEvent::opens) return simple(m.depth, m.depth_slope);
    const Slack slack = law.slack(m.rate);
    const double excess = m.depth - slack.depth, excess_slope = m.depth_slope - slack.slope * m.rate_slope;
    if (kind == ContactEvent::engages) return simple(-excess, -excess_slope);
    if (!m.uses_root) return simple(excess, excess_slope);
    if (!(slack.depth > 0.0)) return {m.s, m.s_slope, excess, excess_slope};
    const double least = onset_root<p>(slack.depth);
    const double exponent = slack.slope * m.rate / slack.depth;  // d ln depth/d ln rate
    return {m.s - least, m.s_slope - least * m.rate_slope * exponent / (p * m.rate), excess, excess_slope};
}

// Time until a slack pair engages in free flight: the first t >= 0 at which ξ(t) = depth + rate t + g t²/2 reaches the
// law's slack at the rate rate + g t; infinity if the pair opens first. `disarmed`: the state is exactly on this zero
// after an event. For a law with a relaxation time there is a closed form.
//
// For any other law: while the bodies separate, ξ and the slack both decrease. Within a time interval their difference
// is therefore at most ξ at its start minus the slack at its end. If this is negative, the interval contains no zero;
// otherwise it is halved, down to rounding, so that no zero is missed.
template <class Law>
double time_to_engage(const Law& law, double depth, double rate, double g, bool disarmed) {
    if constexpr (requires { law.relaxation_time(); }) {
        // ξ + τ_r rate is −missing now and grows by (rate + τ_r g) t + g t²/2.
        const double relaxation = law.relaxation_time(), speed = rate + relaxation * g;
        const double missing = disarmed ? 0.0 : math::max(-depth - relaxation * rate, 0.0);
        const double grown = math::sqrt(speed * speed + 2.0 * g * missing);
        if (speed > 0.0) return 2.0 * missing / (speed + grown);
        return g > 0.0 ? (grown - speed) / g : math::infinity;
    }
    if (rate >= 0.0) return rate > 0.0 || g > 0.0 ? 0.0 : math::infinity;
    if (!(g > 0.0)) return math::infinity;
    const auto compression = [&](double t) { return depth + t * (rate + 0.5 * g * t); };
    const auto slack = [&](double t) { return law.slack(rate + g * t).depth; };
    const double turn = -rate / g;  // the separation stops; a force sets in if they still overlap
    const double square = rate * rate - 2.0 * g * depth;
    const double last = square > 0.0 ? 2.0 * depth / (math::sqrt(square) - rate) : turn;
    const double finest = 2.0 * math::epsilon * last;
    double t = 0.0, stretch = last;
    if (disarmed) {
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
