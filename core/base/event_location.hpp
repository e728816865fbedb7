// Location of events in an integration step: where a function of the state falls to zero.
#pragma once
#include "math.hpp"

namespace hardlimit {

// Value of an event function and its derivative in the step's variable; `smooth` has the same zero and is smooth
// everywhere.
struct EventFunction {
    double value, slope, smooth, smooth_slope;
};

// Whether a function falls below zero between two positive values, a at 0 and b at `high`: follows its minimum until
// that is decided, and moves `high` to a point where the function is negative. at(x): the function at x.
template <class At>
bool dips(EventFunction a, EventFunction b, double& high, const At& at) {
    double low = 0.0, up = high;
    for (int i = 0; i < 40; ++i) {
        const double width = up - low;
        const double chord = (b.smooth - a.smooth) / width;
        // Cubic Hermite interpolant a + a' x + c x² + d x³: where its slope vanishes from below.
        const double d = (a.smooth_slope + b.smooth_slope - 2.0 * chord) / (width * width);
        const double c = (3.0 * chord - 2.0 * a.smooth_slope - b.smooth_slope) / width;
        const double square = math::max(c * c - 3.0 * d * a.smooth_slope, 0.0);
        const double lowest = -a.smooth_slope / (c + math::sqrt(square));
        const double x = math::clamp(lowest, 0.01 * width, 0.99 * width);
        const double least = a.smooth + x * (a.smooth_slope + x * (c + x * d));
        const double margin = 0.1 * width * math::max(-a.smooth_slope, b.smooth_slope);
        if (!(least < margin)) return false;
        const EventFunction m = at(low + x);
        if (m.value <= 0.0) {
            high = low + x;
            return true;
        }
        (m.smooth_slope > 0.0 ? b : a) = m;
        (m.smooth_slope > 0.0 ? up : low) = low + x;
    }
    return false;
}

// Whether a function falls to zero in (0, high], from its values at both ends; `high` moves to a point where it is not
// positive. `disarmed`: the event has just occurred and the state at 0 was placed on the zero, so that a negative value
// of a function that rises is rounding error. at(x): the function at x.
template <class At>
bool falls_to_zero(const EventFunction& start, const EventFunction& end, bool disarmed, double& high,
                   const At& at) {
    if (end.value > 0.0 || (disarmed && end.value == 0.0))
        return start.smooth_slope < 0.0 && end.smooth_slope > 0.0 && dips(start, end, high, at);
    return !(disarmed && start.smooth_slope >= 0.0 && end.smooth_slope >= 0.0);
}

// The same with the function at `middle`, which may be an estimate.
template <class At>
bool falls_to_zero(const EventFunction& start, EventFunction between, const EventFunction& end, bool disarmed,
                   double middle, double& high, const At& at) {
    if (!(between.value > 0.0)) between = at(middle);
    double reached = middle;
    if (!falls_to_zero(start, between, disarmed, reached, at)) {
        reached = high - middle;
        const auto from_middle = [&](double x) { return at(middle + x); };
        if (!falls_to_zero(between, end, false, reached, from_middle)) return false;
        reached += middle;
    }
    high = reached;
    return true;
}

// First zero in (0, high], where the function is not positive at `high`: Newton's method in a bracket. The caller holds
// the state at `at`, whose function is value(); move(at, next) moves the state; close(f, at, next): whether the
// state is close enough to the zero. Returns where the state is.
//
// Close to the zero, rounding errors may make the steps alternate between the two ends of the bracket: a step leads
// back to the previous point, and the bracket no longer changes. The result is then the point of the last step.
template <class Value, class Close, class Move>
double locate_zero(double at, double high, const Value& value, const Close& close, const Move& move) {
    constexpr int most_steps = 100;
    double low = 0.0, previous = at;
    for (int i = 0; i < most_steps; ++i) {
        const EventFunction f = value();
        double& end = f.value > 0.0 ? low : high;
        const bool unchanged = end == at;
        end = at;
        const double newton = at - f.value / f.slope;
        const double next = newton >= low && newton <= high && f.slope < 0.0 ? newton : 0.5 * (low + high);
        if (next == at || close(f, at, next)) break;
        if (unchanged && next == previous) i = most_steps - 2 + i % 2;
        previous = at;
        move(at, next);
        at = next;
    }
    return at;
}

}  // namespace hardlimit
