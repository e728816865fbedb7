// Event detection for the general column solver: the next event in free flight, the first event in a step.
#pragma once
#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "../../base/event_location.hpp"
#include "../../contact/events.hpp"
#include "../flight.hpp"
#include "motions.hpp"

namespace hardlimit::column::newton {

using Event = ContactEvent;

// ---- free flight: closed forms --------------------------------------------------------------------------------

// The earliest event in free flight: time until it, kind, pair.
struct NextEvent {
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

// Considers the next event of pair j in free flight. Gaps between balls are linear in time, the floor gap is quadratic.
// `disarmed`: the last event left the state exactly on the zero of its event function.
template <class Law>
void next_event_of_pair(const Motion<Law>& motion, const double* y, int j, bool disarmed, NextEvent& next) {
    const double gap = y[j], rate = motion.rate(j, y), g = j == 0 ? motion.column->gravity : 0.0;
    if (motion.pair[j] == Pair::open) {
        next.consider(time_to_close(gap, rate, g), Event::begins, j);
        return;
    }
    const double square = rate * rate + 2.0 * g * gap;
    if (rate < 0.0 && square >= 0.0) {
        next.consider(math::max(2.0 * gap / (rate - math::sqrt(square)), 0.0), Event::opens, j);
    }
    next.consider(time_to_engage(motion.column->contacts[j], -gap, rate, g, disarmed), Event::engages, j);
}

// ---- with forces: zeros inside a step ----------------------------------------------------------------------

// One integration step from y to `end`, with event location. States as in Motion; k and k_end are their derivatives.
template <class Law>
struct Step {
    Motion<Law> motion;
    double noise;  // compressions below noise × scales.depth are rounding error
    std::vector<double> y, k, end, k_end, trial, k_trial;
    std::vector<unsigned char>
        disarmed;  // [N] the last event left the pair on the zero of its event function

    Step(const Column<Law>& c, double rounding)
        : motion(c),
          noise(rounding),
          y(motion.dimension(), 0.0),
          k(y),
          end(y),
          k_end(y),
          trial(y),
          k_trial(y),
          disarmed(c.balls, 0) {
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

    EventFunction function(int j, Event kind, const double* state, const double* slope) const {
        constexpr int p = Law::onset_power;
        const double at = state[j], change = slope[j];
        const double depth = -motion.gap(j, state);
        const double depth_slope = motion.uses_root[j] ? p * math::power<p - 1>(at) * change : -change;
        if (kind == Event::parts) return {tiny(j) + depth, depth_slope, tiny(j) + depth, depth_slope};
        return event_function(motion.column->contacts[j], kind,
                              {depth, depth_slope, motion.rate(j, state), motion.rate(j, slope),
                               static_cast<bool>(motion.uses_root[j]), at, change});
    }

    // Whether an event function of the pair is still not positive at the end of the step.
    bool still_disarmed(int j) const {
        for (const Event kind : events_of(j)) {
            if (kind == Event::none) continue;
            if (!(function(j, kind, end.data(), k_end.data()).value > 0.0)) return true;
        }
        return false;
    }

    void probe(double at) {
        motion.advance(y.data(), k.data(), at, trial.data());
        motion(trial.data(), k_trial.data());
    }

    // Returns whether this event of pair j occurs in (0, length]. If so, shortens the step to its first occurrence.
    bool crosses(int j, Event kind, double& length) {
        const EventFunction a = function(j, kind, y.data(), k.data());
        const EventFunction b = function(j, kind, end.data(), k_end.data());
        const auto at_trial = [&] { return function(j, kind, trial.data(), k_trial.data()); };
        const auto at = [&](double x) {
            probe(x);
            return at_trial();
        };
        double high = length;
        if (!falls_to_zero(a, b, disarmed[j], high, at)) return false;
        double guess = 0.5 * high;
        if (!disarmed[j] && a.smooth_slope < 0.0) guess = math::min(-a.smooth / a.smooth_slope, guess);
        probe(guess);
        const auto close = [](const EventFunction&, double x, double next) {
            return math::abs(next - x) <= 4.0 * math::epsilon * math::abs(x);
        };
        length = locate_zero(guess, high, at_trial, close, [this](double, double next) { probe(next); });
        end.swap(trial);
        k_end.swap(k_trial);
        return true;
    }
};

}  // namespace hardlimit::column::newton
