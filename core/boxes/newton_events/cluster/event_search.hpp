// Location of events within an integrated step.
#pragma once
#include <vector>

#include "equations.hpp"
#include "events.hpp"
#include "integrator.hpp"

namespace hardlimit::boxes {

template <class Law>
struct EventSearch {
    const ContactNetwork<Law>& network;
    const StateVector& state;
    Integrator& integrator;
    const double speed;  // of the cluster [m/s]
    const Equations<Law> f{network, state.layout};

    // Whether an event of the pair occurs in (0, length]; if so, moves `length` and the end of the step to the first.
    bool locate(int pair, ContactEvent kind, double& length) {
        Integrator& in = integrator;
        const ContactPair<Law>& q = network.pairs[pair];
        const EventFunction a = function(pair, kind, state.y, in.slope);
        const EventFunction b = function(pair, kind, in.end, in.end_slope);
        const double noise = rounding(q);
        if (q.fresh && kind == ContactEvent::begins && b.value < 0.0 && b.value > -noise) return false;
        const auto at_trial = [&] { return function(pair, kind, in.trial, in.trial_slope); };
        const auto at = [&](double x) {
            in.probe(f, state, x);
            return at_trial();
        };
        double high = length;
        if (!falls_to_zero(a, b, q.fresh, high, at)) return false;
        const double whole = length, guess = q.fresh ? 0.5 * high : first_guess(a, b, whole, high);
        in.probe(f, state, guess);
        const auto close = [=](const EventFunction& value, double x, double next) {
            return math::abs(value.smooth) <= noise || math::abs(next - x) <= 1e-14 * whole;
        };
        // Close to the zero the midpoint rule suffices, whose error is third order in the remaining distance. It needs
        // two evaluations instead of twelve.
        const auto move = [&](double x, double next) {
            if (math::abs(next - x) <= 1e-4 * whole && in.explicit_step())
                in.nudge(f, next - x);
            else
                in.probe(f, state, next);
        };
        length = locate_zero(guess, high, at_trial, close, move);
        in.end_at_trial();
        return true;
    }

    // The same for an event of the pair's surfaces.
    bool locate_in_surfaces(int pair, ContactEvent kind, double& length)
        requires FrictionalLaw<Law>
    {
        Integrator& in = integrator;
        const bool fresh = is_fresh(const_cast<ContactPair<Law>&>(network.pairs[pair]), kind);
        EventFunction a = in_surfaces(pair, kind, state.y, in.slope, length);
        const EventFunction b = in_surfaces(pair, kind, in.end, in.end_slope, length);
        const bool changes = kind != ContactEvent::turns;
        if (changes && begins(pair))  // all forces may begin at zero
            if (const EventFunction soon = estimate(pair, kind, 1e-3, length); soon.value > 0.0) a = soon;
        const EventFunction between = changes ? estimate(pair, kind, 0.5, length) : b;
        // Where surfaces begin to stick, the force is at its limit and as steep: a fall from there is rounding.
        if (fresh && kind == ContactEvent::slips && !begins(pair) && between.value > 0.0)
            a.smooth_slope = math::max(a.smooth_slope, 0.0);
        const auto at_trial = [&] { return in_surfaces(pair, kind, in.trial, in.trial_slope, length); };
        const auto at = [&](double x) {
            in.probe(f, state, x);
            return at_trial();
        };
        double high = length;
        if (!falls_to_zero(a, between, b, fresh, 0.5 * length, high, at)) return false;
        const double whole = length, guess = fresh ? 0.5 * high : first_guess(a, b, whole, high);
        in.probe(f, state, guess);
        // Within the rounding error of the positions the forces are not resolved.
        const auto time = static_cast<std::size_t>(state.layout.time());
        const double clock = math::max(in.slope[time], in.end_slope[time]),
                     noise = rounding(network.pairs[pair]) / (speed * clock);
        const auto close = [=](const EventFunction&, double x, double next) {
            return math::abs(next - x) <= math::max(noise, 4.0 * math::epsilon * whole);
        };
        const auto move = [&](double x, double next) {
            if (math::abs(next - x) <= 1e-5 * whole && in.explicit_step())
                in.nudge(f, next - x);
            else
                in.probe(f, state, next);
        };
        length = locate_zero(guess, high, at_trial, close, move);
        in.end_at_trial();
        return true;
    }
    bool still_fresh_in_surfaces(int pair, ContactEvent kind) const
        requires FrictionalLaw<Law>
    {
        const Snapshot<Law> end{network, state.layout, integrator.end.data()};
        return !(surface_value(end, integrator.end_slope.data(), pair, kind) > 0.0);
    }

    // Whether an event function of a fresh pair is not yet positive at the end of the step.
    bool still_fresh(int pair) const {
        for (const ContactEvent kind : next_events(network.pairs[pair]))
            if (kind != ContactEvent::none &&
                !(function(pair, kind, integrator.end, integrator.end_slope).value > 0.0))
                return true;
        return false;
    }

private:
    EventFunction function(int pair, ContactEvent kind, const std::vector<double>& y,
                           const std::vector<double>& slope) const {
        return event_function(Snapshot<Law>{network, state.layout, y.data()}, slope.data(), pair, kind);
    }

    // The slopes are those of differences.
    EventFunction in_surfaces(int pair, ContactEvent kind, const WorkVector<double>& y,
                              const WorkVector<double>& slope, double length) const
        requires FrictionalLaw<Law>
    {
        const SurfaceValue here = value_in_surfaces(pair, kind, y, slope);
        const double little = 1e-5 * length;
        auto &near = integrator.near, &near_slope = integrator.near_slope;
        near.resize(y.size()), near_slope.resize(y.size());
        for (std::size_t c = 0; c < y.size(); ++c) near[c] = y[c] + little * slope[c];
        if (kind == ContactEvent::sticks) f(near.data(), near_slope.data());
        return between(here, value_in_surfaces(pair, kind, near, near_slope), little);
    }
    // The same at a part of the step, from the cubic polynomials of the state.
    EventFunction estimate(int pair, ContactEvent kind, double part, double length) const
        requires FrictionalLaw<Law>
    {
        const double little = 1e-5;
        const auto at = [&](double x) {
            const double rest = 1.0 - x, moved = x * x * (3.0 - 2.0 * x), fast = 6.0 * x * rest / length;
            const double first = rest * rest * x * length, last = -x * x * rest * length;
            const double first_rate = rest * (1.0 - 3.0 * x), last_rate = x * (3.0 * x - 2.0);
            const Integrator& in = integrator;
            auto &near = integrator.near, &near_slope = integrator.near_slope;
            for (std::size_t c = 0; c < near.size(); ++c) {
                const double change = in.end[c] - state.y[c];
                near[c] = state.y[c] + moved * change + first * in.slope[c] + last * in.end_slope[c];
                near_slope[c] = fast * change + first_rate * in.slope[c] + last_rate * in.end_slope[c];
            }
            return value_in_surfaces(pair, kind, near, near_slope);
        };
        return between(at(part), at(part + little), little * length);
    }
    SurfaceValue value_in_surfaces(int pair, ContactEvent kind, const WorkVector<double>& y,
                                   const WorkVector<double>& slope) const
        requires FrictionalLaw<Law>
    {
        return surface_values(Snapshot<Law>{network, state.layout, y.data()}, slope.data(), pair, kind,
                              begins(pair));
    }
    static EventFunction between(SurfaceValue a, SurfaceValue b, double apart) {
        return {a.value, (b.value - a.value) / apart, a.smooth, (b.smooth - a.smooth) / apart};
    }
    bool begins(int pair) const
        requires FrictionalLaw<Law>
    {
        const auto& surfaces = network.pairs[pair].surfaces;
        return surfaces.fresh && surfaces.changes == 0;
    }

    // Zero of the cubic Hermite polynomial through both ends of the step, or high/2 if there is none below `high`.
    static double first_guess(const EventFunction& a, const EventFunction& b, double length, double high) {
        if (!(a.smooth > 0.0 && b.smooth < 0.0)) return 0.5 * high;
        const double chord = (b.smooth - a.smooth) / length;
        const double d = (a.smooth_slope + b.smooth_slope - 2.0 * chord) / (length * length);
        const double c = (3.0 * chord - 2.0 * a.smooth_slope - b.smooth_slope) / length;
        double low = 0.0, up = length, x = length * (a.smooth / (a.smooth - b.smooth));
        for (int i = 0; i < 20; ++i) {
            const double value = a.smooth + x * (a.smooth_slope + x * (c + x * d));
            const double slope = a.smooth_slope + x * (2.0 * c + 3.0 * x * d);
            (value > 0.0 ? low : up) = x;
            const double newton = x - value / slope;
            const double next = slope < 0.0 && newton > low && newton < up ? newton : 0.5 * (low + up);
            if (math::abs(next - x) <= 1e-6 * length) break;
            x = next;
        }
        return x < high ? x : 0.5 * high;
    }
};

}  // namespace hardlimit::boxes
