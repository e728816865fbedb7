// Program for test_event_location.py: functions with one minimum between two positive values, in steps and units of any
// size. Prints how many were tried; how many that fall below zero were missed; in how many that stay positive a zero
// was seen; and the largest |f| at the first zeros, in the unit of f.
#include <cmath>
#include <cstdio>
#include <initializer_list>

#include "base/event_location.hpp"

namespace {

using hardlimit::EventFunction;

struct Counts {
    int tried = 0, missed = 0, seen = 0;
    double largest = 0.0;
};

// f = unit (u² + skew (e^{2u} − 1 − 2u) − depth) with u = x/step − place: its minimum is −unit depth, at u = 0.
struct Dip {
    double step, unit, place, skew, depth;

    EventFunction operator()(double x) const {
        const double u = x / step - place, grown = std::expm1(2.0 * u);
        const double value = unit * (u * u + skew * (grown - 2.0 * u) - depth);
        const double slope = unit * (2.0 * u + skew * 2.0 * grown) / step;
        return {value, slope, value, slope};
    }
};

void locate(const Dip& f, Counts& counts) {
    const EventFunction start = f(0.0), end = f(f.step);
    if (!(start.value > 0.0 && end.value > 0.0)) return;
    ++counts.tried;
    double high = f.step;
    const bool falls = hardlimit::falls_to_zero(start, end, false, high, f);
    counts.missed += !falls && f.depth > 0.0;
    counts.seen += falls && f.depth < 0.0;
    if (!falls) return;
    double x = 0.5 * high;
    const auto close = [](EventFunction, double at, double next) {
        return std::abs(next - at) <= 1e-15 * at;
    };
    x = hardlimit::locate_zero(x, high, [&] { return f(x); }, close, [&](double, double next) { x = next; });
    const double off = x <= f.place * f.step ? std::abs(f(x).value) / f.unit : hardlimit::math::infinity;
    counts.largest = hardlimit::math::max(counts.largest, off);
}

}  // namespace

int main() {
    Counts counts;
    for (const double step : {1e-6, 1.0, 1e3})
        for (const double unit : {1e-9, 1.0, 1e6})
            for (const double place : {0.01, 0.1, 0.3, 0.5, 0.8, 0.99})
                for (const double skew : {0.0, 0.1, 10.0})
                    for (double depth = 1e-12; depth < 1.0; depth *= 10.0)
                        for (const double sign : {1.0, -1.0})
                            locate({step, unit, place, skew, sign * depth}, counts);
    std::printf("%d %d %d %g\n", counts.tried, counts.missed, counts.seen, counts.largest);
}
