// Events of a cluster's pairs: their functions, the location of zeros, and what changes there.
#pragma once
#include "cluster.hpp"

namespace hardlimit::boxes {

template <class Law>
Surface Cluster<Law>::event_function(int index, Event kind, const double* y, const double* dy) const {
    const ContactPair<Law>& q = pairs[static_cast<std::size_t>(index)];
    const Geometry g = geometry(q, y);
    const double gamma = dy[time_index()], depth_slope = gamma * g.rate;
    const auto simple = [](double f, double df) { return Surface{f, df, f, df}; };
    if (kind == Event::begins) return simple(-g.depth, -depth_slope);
    if (kind == Event::opens) return simple(g.depth, depth_slope);
    if (kind == Event::deepens) return simple(depth_left(q, g), -depth_slope);
    const Slack slack = q.law.slack(g.rate);
    const double rate_slope = acceleration(q, g, y, dy);
    const double excess = g.depth - slack.depth, excess_slope = depth_slope - slack.slope * rate_slope;
    if (kind == Event::engages) return simple(-excess, -excess_slope);
    if (!q.rooted) return simple(excess, excess_slope);
    const double at = y[slot_[static_cast<std::size_t>(index)]],
                 change = dy[slot_[static_cast<std::size_t>(index)]];
    if (!(slack.depth > 0.0)) return {at, change, excess, excess_slope};
    const double least = onset_root<p>(slack.depth), share = slack.slope * g.rate / slack.depth;
    return {at - least, change - least * rate_slope * share / (p * g.rate), excess, excess_slope};
}

// d(rate)/dτ
template <class Law>
double Cluster<Law>::acceleration(const ContactPair<Law>& q, const Geometry& g, const double* y,
                                  const double* dy) const {
    const double* a = dy + 3 * (count() + q.first);
    if (q.second < 0) return -q.side * a[q.axis];
    const double* b = dy + 3 * (count() + q.second);
    double along = 0.0;
    for (std::size_t i = 0; i < 3; ++i) along += (b[i] - a[i]) * g.normal[i];
    double speed2 = 0.0;
    for (int i = 0; i < 3; ++i) {
        const double v = y[3 * (count() + q.second) + i] - y[3 * (count() + q.first) + i];
        speed2 += v * v;
    }
    return -along - dy[time_index()] * (speed2 - g.rate * g.rate) / g.distance;
}

template <class Law>
bool Cluster<Law>::still_fresh(int q) const {
    for (const Event kind : events_of(pairs[static_cast<std::size_t>(q)]))
        if (kind != Event::none && !(event_function(q, kind, end_.data(), k_end_.data()).value > 0.0))
            return true;
    return false;
}

// Looks for a zero of one surface in (0, length]; if there is one, `length` and end_ move to it.
template <class Law>
bool Cluster<Law>::crosses(int q, Event kind, double& length) {
    const bool fresh = pairs[static_cast<std::size_t>(q)].fresh;
    const Surface a = event_function(q, kind, y_.data(), k_.data());
    const Surface b = event_function(q, kind, end_.data(), k_end_.data());
    double high = length;
    if (b.value > 0.0 || (fresh && b.value == 0.0)) {
        if (!(a.smooth_slope < 0.0 && b.smooth_slope > 0.0)) return false;
        const auto at = [&](double x) {
            probe(x);
            return event_function(q, kind, trial_.data(), k_trial_.data());
        };
        if (!dips(a, b, high, at)) return false;
    } else if (fresh && a.smooth_slope >= 0.0 && b.smooth_slope >= 0.0) {
        return false;  // rising from the surface: rounding
    } else if (fresh && kind == Event::begins && b.value > -rounding(pairs[static_cast<std::size_t>(q)])) {
        return false;
    }
    locate(q, kind, a, b, length, high);
    length = high;
    end_.swap(trial_);
    k_end_.swap(k_trial_);
    return true;
}

// First zero in (0, high], the surface being below zero at `high`; leaves the state there in trial_. Starts from
// the zero of the cubic through the two ends of the step. What is left of the way is soon so short that the
// midpoint rule, whose error is of the third order in it, goes it in two evaluations instead of twelve.
template <class Law>
void Cluster<Law>::locate(int q, Event kind, const Surface& a, const Surface& b, double length,
                          double& high) {
    double low = 0.0, up = high, at = first_guess(q, a, b, length, high);
    probe(at);
    for (int i = 0; i < 100; ++i) {
        const Surface f = event_function(q, kind, trial_.data(), k_trial_.data());
        (f.value > 0.0 ? low : up) = at;
        const double newton = at - f.value / f.slope;
        const double next = newton >= low && newton <= up && f.slope < 0.0 ? newton : 0.5 * (low + up);
        const bool close = math::abs(f.smooth) <= rounding(pairs[static_cast<std::size_t>(q)]) || next == at;
        if (close || math::abs(next - at) <= 1e-14 * length) break;
        if (math::abs(next - at) <= 1e-4 * length)
            midpoint_step(next - at);
        else
            probe(next);
        at = next;
    }
    high = at;
}

// Moves the state in trial_ on by a very short step.
template <class Law>
void Cluster<Law>::midpoint_step(double step) {
    const std::size_t n = trial_.size();
    for (std::size_t c = 0; c < n; ++c) stages_[c] = trial_[c] + 0.5 * step * k_trial_[c];
    derivative(stages_.data(), k_trial_.data());
    for (std::size_t c = 0; c < n; ++c) trial_[c] += step * k_trial_[c];
    derivative(trial_.data(), k_trial_.data());
}

template <class Law>
double Cluster<Law>::first_guess(int q, const Surface& a, const Surface& b, double length,
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

// A surface reached before this step begins, without being the one just left.
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
                pairs[i].fresh = true;  // touches without closing
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
        y_[loss_index()] -= q.law.energy(onset_root<p>(g.depth));
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
    y_[loss_index()] += q.law.energy(s);
    if (q.rooted) {
        std::vector<int> chosen;
        for (const int other : rooted_)
            if (other != index) chosen.push_back(other);
        rearrange(chosen);
    }
    // Without slack the end is at touch: what overlaps there is rounding.
    q.state = g.depth > 0.0 && q.law.slack(g.rate).depth > 0.0 ? ContactState::slack : ContactState::open;
}

}  // namespace hardlimit::boxes
