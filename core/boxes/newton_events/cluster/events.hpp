// Events of a cluster's pairs: event functions, location within a step, and the changes they cause.
#pragma once
#include "cluster.hpp"

namespace hardlimit::boxes {

template <class Law>
EventFunction Cluster<Law>::event_at(int index, Event kind, const double* y, const double* dy) const {
    const ContactPair<Law>& q = pairs[static_cast<std::size_t>(index)];
    const Geometry g = geometry(q, y);
    const double depth_slope = dy[time_index()] * g.rate;
    if (kind == Event::deepens) {
        const double left = depth_left(q, g);
        return {left, -depth_slope, left, -depth_slope};
    }
    PairMotion m{g.depth, depth_slope, g.rate, 0.0, q.rooted, 0.0, 0.0};
    if (kind == Event::ends || kind == Event::engages) m.rate_slope = acceleration(q, g, y, dy);
    if (q.rooted) {
        m.s = y[slot_[static_cast<std::size_t>(index)]];
        m.s_slope = dy[slot_[static_cast<std::size_t>(index)]];
    }
    return event_function(q.law, kind, m);
}

// d(rate)/dτ
template <class Law>
double Cluster<Law>::acceleration(const ContactPair<Law>& q, const Geometry& g, const double* y,
                                  const double* dy) const {
    const double* a = dy + 3 * (count() + q.first);
    if (q.second < 0) return -q.side * (a[q.axis] - dy[time_index()] * wall_acceleration(q, y[time_index()]));
    const double* b = dy + 3 * (count() + q.second);
    double along = 0.0;
    for (std::size_t i = 0; i < 3; ++i) along += (b[i] - a[i]) * g.normal[i];
    const double speed2 = relative_speed_squared(q, y);
    return -along - dy[time_index()] * (speed2 - g.rate * g.rate) / g.distance;
}

template <class Law>
bool Cluster<Law>::still_fresh(int q) const {
    for (const Event kind : events_of(pairs[static_cast<std::size_t>(q)]))
        if (kind != Event::none && !(event_at(q, kind, end_.data(), k_end_.data()).value > 0.0)) return true;
    return false;
}

// Whether an event of the pair occurs in (0, length]; if so, moves `length` and end_ to the first one.
template <class Law>
bool Cluster<Law>::crosses(int q, Event kind, double& length) {
    const ContactPair<Law>& pair = pairs[static_cast<std::size_t>(q)];
    const EventFunction a = event_at(q, kind, y_.data(), k_.data());
    const EventFunction b = event_at(q, kind, end_.data(), k_end_.data());
    const double noise = rounding(pair);
    if (pair.fresh && kind == Event::begins && b.value < 0.0 && b.value > -noise) return false;
    const auto at_trial = [&] { return event_at(q, kind, trial_.data(), k_trial_.data()); };
    const auto at = [&](double x) {
        probe(x);
        return at_trial();
    };
    double high = length;
    if (!falls_to_zero(a, b, pair.fresh, high, at)) return false;
    const double whole = length, guess = first_guess(q, a, b, whole, high);
    probe(guess);
    const auto close = [=](const EventFunction& f, double x, double next) {
        return math::abs(f.smooth) <= noise || math::abs(next - x) <= 1e-14 * whole;
    };
    // Close to the zero the midpoint rule suffices, whose error is third order in the remaining distance. It needs two
    // evaluations instead of twelve.
    const auto move = [&](double x, double next) {
        if (math::abs(next - x) <= 1e-4 * whole)
            midpoint_step(next - x);
        else
            probe(next);
    };
    length = locate_zero(guess, high, at_trial, close, move);
    end_.swap(trial_);
    k_end_.swap(k_trial_);
    return true;
}

// Advances the state in trial_ by a very short step.
template <class Law>
void Cluster<Law>::midpoint_step(double step) {
    const std::size_t n = trial_.size();
    for (std::size_t c = 0; c < n; ++c) stages_[c] = trial_[c] + 0.5 * step * k_trial_[c];
    derivative(stages_.data(), k_trial_.data());
    for (std::size_t c = 0; c < n; ++c) trial_[c] += step * k_trial_[c];
    derivative(trial_.data(), k_trial_.data());
}

// Zero of the cubic Hermite polynomial through both ends of the step, or high/2 if there is none below `high`.
template <class Law>
double Cluster<Law>::first_guess(int q, const EventFunction& a, const EventFunction& b, double length,
                                 double high) const {
    if (pairs[static_cast<std::size_t>(q)].fresh || !(a.smooth > 0.0 && b.smooth < 0.0)) return 0.5 * high;
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

// Applies an event whose function is not positive at the start of the step, unless the pair is fresh. Returns whether
// there is one.
template <class Law>
template <class Value>
bool Cluster<Law>::event_at_start(const Value& value) {
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        if (pairs[i].fresh) continue;
        const int q = static_cast<int>(i);
        for (const Event kind : events_of(pairs[i])) {
            if (kind == Event::none || value(q, kind) > 0.0) continue;
            if (kind == Event::begins &&
                !(geometry(pairs[i], y_.data()).rate * time_unit() > rounding(pairs[i]))) {
                pairs[i].fresh = true;  // touches without a contact
                continue;
            }
            apply(kind, q);
            return true;
        }
    }
    return false;
}

template <class Law>
void Cluster<Law>::apply(Event what, int index) {
    known_ = false;
    ContactPair<Law>& q = pairs[static_cast<std::size_t>(index)];
    const Geometry g = geometry(q, y_.data());
    q.fresh = true;
    if (what == Event::begins) {
        begin_contact(index, g);
    } else if (what == Event::engages) {
        add_loss(q, -q.law.energy(onset_root<p>(g.depth)));
        begin_contact(index, g);
    } else if (what == Event::ends) {
        end_contact(index, g);
    } else if (what == Event::deepens) {
        too_deep = index;
    } else {
        q.state = ContactState::open;
    }
    h_ = 0.0;
}

template <class Law>
void Cluster<Law>::begin_contact(int index, const Geometry& g) {
    ContactPair<Law>& q = pairs[static_cast<std::size_t>(index)];
    ++begun;
    begun_pairs += q.second >= 0;
    q.state = ContactState::closed;
    set_scales(q);
    q.begin = base + y_[time_index()];
    q.impact_speed = g.rate;
    q.overlapped = false;
    for (ContactPair<Law>& other : pairs) {
        if (&other == &q || other.state != ContactState::closed || !share_a_body(q, other)) continue;
        q.overlapped = other.overlapped = true;
    }
}

template <class Law>
bool Cluster<Law>::share_a_body(const ContactPair<Law>& a, const ContactPair<Law>& b) {
    return a.first == b.first || a.first == b.second ||
           (a.second >= 0 && (a.second == b.first || a.second == b.second));
}

template <class Law>
void Cluster<Law>::end_contact(int index, const Geometry& g) {
    ContactPair<Law>& q = pairs[static_cast<std::size_t>(index)];
    ended.push_back({index, q.begin, base + y_[time_index()], q.impact_speed, -g.rate, q.overlapped});
    const double s = math::max(depth_root(index, g, y_.data()), 0.0);
    add_loss(q, q.law.energy(s));
    if (q.rooted) {
        std::vector<int> chosen;
        for (const int other : rooted_)
            if (other != index) chosen.push_back(other);
        rearrange(chosen);
    }
    // A law without slack ends at touch: a remaining overlap is rounding.
    q.state = g.depth > 0.0 && q.law.slack(g.rate).depth > 0.0 ? ContactState::slack : ContactState::open;
}

}  // namespace hardlimit::boxes
