// Where a pair changes its state: the events of each pair, their surfaces, and the first of them in a step. The head
// of motions.hpp lists them.
#pragma once
#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "../../base/event_function.hpp"
#include "motions.hpp"

namespace hardlimit::column::newton {

enum class Event : unsigned char { none, begins, ends, opens, engages, parts };

// ---- without forces: closed forms --------------------------------------------------------------------------

// The earliest event of a flight.
struct Next {
    double dt = math::infinity;
    Event what = Event::none;
    int pair = 0;

    void consider(double at, Event kind, int j) {
        if (at < dt) *this = {at, kind, j};
    }
};

inline double time_to_close(double gap, double rate, double g) {
    if (gap > 0.0) {
        const double time = fall_time(gap, -rate, g);
        return math::is_nan(time) ? math::infinity : time;
    }
    if (rate > 0.0) return 0.0;
    return g > 0.0 ? -2.0 * rate / g : math::infinity;
}

// When a slack pair pushes again in free flight: first t >= 0 at which ξ(t) = depth + rate t + g t²/2 reaches the
// law's slack at the rate then, rate + g t; infinity if it comes apart first. A pair that has just been put on this
// surface (`fresh`) starts at zero distance. A law with a relaxation time has a closed form.
//
// For any other law: while the bodies separate, ξ and the slack both fall with time. Over a stretch of time their
// difference is therefore at most ξ at its beginning less the slack at its end. Where this is negative the stretch
// holds no zero; else it is halved, down to rounding, so that no zero is missed.
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

// Gaps between balls change at constant rates, the floor gap is a parabola. `fresh` says that the pair has just
// been put on a surface.
template <class Law>
void next_of_pair(const Motion<Law>& motion, const double* y, int j, bool fresh, Next& next) {
    const double gap = y[j], rate = motion.rate(j, y), g = j == 0 ? motion.column->gravity : 0.0;
    if (motion.pair[j] == Pair::open) {
        next.consider(time_to_close(gap, rate, g), Event::begins, j);
        return;
    }
    const double square = rate * rate + 2.0 * g * gap;
    if (rate < 0.0 && square >= 0.0) {
        next.consider(math::max(2.0 * gap / (rate - math::sqrt(square)), 0.0), Event::opens, j);
    }
    next.consider(time_to_engage(motion.column->contacts[j], -gap, rate, g, fresh), Event::engages, j);
}

// ---- under forces: zeros inside a step ---------------------------------------------------------------------

// A step from y to `end` and the search for events in it. States as in Motion; k, k_end are their derivatives.
template <class Law>
struct Step {
    Motion<Law> motion;
    double noise;  // depths up to this part of a contact's unit are rounding
    std::vector<double> y, k, end, k_end, trial, k_trial;
    std::vector<unsigned char> fresh;  // [N] the pair has just been put on a surface

    Step(const Column<Law>& c, double rounding)
        : motion(c),
          noise(rounding),
          y(motion.dimension(), 0.0),
          k(y),
          end(y),
          k_end(y),
          trial(y),
          k_trial(y),
          fresh(c.balls, 0) {
        std::copy(c.gaps.begin(), c.gaps.end(), y.begin());
        std::copy(c.velocity.begin(), c.velocity.end(), y.begin() + c.balls);
    }

    double tiny(int j) const { return noise * motion.scales.depth[j]; }

    std::array<Event, 2> events_of(int j) const {
        if (j == 0 && !motion.column->floor) return {Event::none, Event::none};
        switch (motion.pair[j]) {
            case Pair::open:
                return {Event::begins, Event::none};
            case Pair::pressed:
                return {Event::parts, Event::none};
            case Pair::slack:
                return {Event::opens, Event::engages};
            case Pair::closed:
                break;
        }
        return {Event::ends, Event::none};
    }

    Surface surface(int j, Event kind, const double* state, const double* slope) const {
        constexpr int p = Law::onset_power;
        const double rate = motion.rate(j, state), rate_slope = motion.rate(j, slope);
        const double at = state[j], change = slope[j];
        const double depth = -motion.gap(j, state);
        const double depth_slope = motion.rooted[j] ? p * power<p - 1>(at) * change : -change;
        const auto simple = [](double f, double df) { return Surface{f, df, f, df}; };
        if (kind == Event::begins) return simple(-depth, -depth_slope);
        if (kind == Event::opens) return simple(depth, depth_slope);
        if (kind == Event::parts) return simple(tiny(j) + depth, depth_slope);
        const Slack slack = motion.column->contacts[j].slack(rate);
        const double excess = depth - slack.depth, excess_slope = depth_slope - slack.slope * rate_slope;
        if (kind == Event::engages) return simple(-excess, -excess_slope);
        if (!motion.rooted[j]) return simple(excess, excess_slope);
        if (!(slack.depth > 0.0)) return {at, change, excess, excess_slope};
        const double least = onset_root<p>(slack.depth);
        const double share = slack.slope * rate / slack.depth;  // d ln depth/d ln rate
        return {at - least, change - least * rate_slope * share / (p * rate), excess, excess_slope};
    }

    // At the end of the step.
    bool still_fresh(int j) const {
        for (const Event kind : events_of(j)) {
            if (kind == Event::none) continue;
            if (!(surface(j, kind, end.data(), k_end.data()).value > 0.0)) return true;
        }
        return false;
    }

    void probe(double at) {
        motion.advance(y.data(), k.data(), at, trial.data());
        motion(trial.data(), k_trial.data());
    }

    // Looks for a zero of one surface in (0, length]; if there is one, `length` and `end` move to it.
    bool crosses(int j, Event kind, double& length) {
        const Surface a = surface(j, kind, y.data(), k.data());
        const Surface b = surface(j, kind, end.data(), k_end.data());
        double high = length;
        if (b.value > 0.0 || (fresh[j] && b.value == 0.0)) {
            if (!(a.smooth_slope < 0.0 && b.smooth_slope > 0.0)) return false;
            const auto at = [&](double x) {
                probe(x);
                return surface(j, kind, trial.data(), k_trial.data());
            };
            if (!dips(a, b, high, at)) return false;
        } else if (fresh[j] && a.smooth_slope >= 0.0 && b.smooth_slope >= 0.0) {
            return false;  // rising from the surface: rounding
        }
        locate(j, kind, high);
        length = high;
        end.swap(trial);
        k_end.swap(k_trial);
        return true;
    }

    // First zero in (0, high], the surface being below zero at `high`; leaves the state there in `trial`.
    void locate(int j, Event kind, double& high) {
        const Surface a = surface(j, kind, y.data(), k.data());
        double low = 0.0, up = high, at = 0.5 * high;
        if (!fresh[j] && a.smooth_slope < 0.0) at = math::min(-a.smooth / a.smooth_slope, at);
        for (int i = 0; i < 100; ++i) {
            probe(at);
            const Surface f = surface(j, kind, trial.data(), k_trial.data());
            (f.value > 0.0 ? low : up) = at;
            const double newton = at - f.value / f.slope;
            const double next = newton >= low && newton <= up && f.slope < 0.0 ? newton : 0.5 * (low + up);
            if (math::abs(next - at) <= 4.0 * math::epsilon * math::abs(at) || next == at) break;
            at = next;
        }
        high = at;
    }
};

}  // namespace hardlimit::column::newton
