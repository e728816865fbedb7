// An event function: a function of the state that falls to zero at the event.
#pragma once
#include "math.hpp"

namespace hardlimit {

// Distance to an event, and its derivative in the step's variable; `smooth` has the same zero and is smooth
// everywhere.
struct Surface {
    double value, slope, smooth, smooth_slope;
};

// Locates the minimum of an event function between two positive values, a at 0 and b at `high`, and decides whether
// it is negative; `high` then becomes an argument where it is. at(x): the event function at x.
template <class At>
bool dips(Surface a, Surface b, double& high, const At& at) {
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
        const Surface m = at(low + x);
        if (m.value <= 0.0) {
            high = low + x;
            return true;
        }
        (m.smooth_slope > 0.0 ? b : a) = m;
        (m.smooth_slope > 0.0 ? up : low) = low + x;
    }
    return false;
}

}  // namespace hardlimit
