// Flight of a cluster's members while no pair exerts a force, in closed form up to the next event of a pair.
#pragma once
#include "cluster.hpp"

namespace hardlimit::boxes {

// Advances the time of a cluster at rest.
template <class Law>
void Cluster<Law>::rest_until(double until) {
    time = y_[time_index()] = until;
    record_state();
}

// Moves all members to the next event of a pair, or to `until`.
template <class Law>
void Cluster<Law>::fly(double until) {
    double least = until - y_[time_index()];
    Event what = Event::none;
    int which = 0;
    const auto consider = [&](double t, Event kind, int q) {
        if (t < least) {
            least = math::max(t, 0.0);
            what = kind;
            which = q;
        }
    };
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        const ContactPair<Law>& q = pairs[i];
        const int index = static_cast<int>(i);
        if (q.state == ContactState::open) {
            consider(time_to_touch(q), Event::begins, index);
        } else {
            consider(time_to_open(q), Event::opens, index);
            consider(time_to_engage(q), Event::engages, index);
        }
    }
    for (int i = 0; i < count(); ++i)
        for (int a = 0; a < 3; ++a) {
            double &x = y_[3 * i + a], &v = y_[3 * (count() + i) + a];
            const double g = gravity[static_cast<std::size_t>(a)];
            x += least * (v + 0.5 * g * least);
            v += g * least;
        }
    y_[time_index()] = what == Event::none ? until : y_[time_index()] + least;
    time = y_[time_index()];
    known_ = false;
    if (least > 0.0)
        for (ContactPair<Law>& q : pairs) q.fresh = q.fresh && is_pressed(q);
    record_state();
    if (what != Event::none) apply(what, which);
}

// First t at which the distance falls to the contact distance; at a wall the path is a parabola.
template <class Law>
double Cluster<Law>::time_to_touch(const ContactPair<Law>& q) const {
    const Geometry g = geometry(q, y_.data());
    if (q.second < 0) {
        const double gap = q.fresh ? 0.0 : math::max(-g.depth, 0.0), towards = approach_acceleration(q);
        if (gap == 0.0 && g.rate > 0.0) return 0.0;
        if (gap == 0.0) return towards > 0.0 ? -2.0 * g.rate / towards : math::infinity;
        const double square = g.rate * g.rate + 2.0 * towards * gap;
        if (square < 0.0 || (g.rate <= 0.0 && towards <= 0.0)) return math::infinity;
        if (g.rate > 0.0) return 2.0 * gap / (g.rate + math::sqrt(square));
        return (math::sqrt(square) - g.rate) / towards;
    }
    if (!(g.rate > 0.0)) return math::infinity;
    const double speed2 = relative_speed_squared(q, y_.data());
    const double b = g.rate * g.distance,
                 c = -g.depth * (g.distance + q.contact_distance);  // c = r² − σ²
    if (c <= 0.0) return 0.0;
    const double square = b * b - speed2 * c;
    return square < 0.0 ? math::infinity : c / (b + math::sqrt(square));
}

template <class Law>
double Cluster<Law>::time_to_open(const ContactPair<Law>& q) const {
    const Geometry g = geometry(q, y_.data());
    if (q.second < 0) {
        const double towards = approach_acceleration(q), square = g.rate * g.rate - 2.0 * towards * g.depth;
        if (g.depth <= 0.0) return 0.0;
        if (square < 0.0 || (g.rate >= 0.0 && towards >= 0.0)) return math::infinity;
        if (g.rate <= 0.0) return 2.0 * g.depth / (math::sqrt(square) - g.rate);
        return -(g.rate + math::sqrt(square)) / towards;
    }
    const double speed2 = relative_speed_squared(q, y_.data());
    const double b = -g.rate * g.distance, c = g.depth * (g.distance + q.contact_distance);  // σ² − r²
    if (c <= 0.0) return 0.0;
    if (speed2 == 0.0) return math::infinity;
    return b > 0.0 ? c / (b + math::sqrt(b * b + speed2 * c)) : (math::sqrt(b * b + speed2 * c) - b) / speed2;
}

// Whether the force of a slack pair is repulsive: after a jump of a velocity, or by rounding when it has just ended.
template <class Law>
bool Cluster<Law>::is_pressed(const ContactPair<Law>& q) const {
    if (q.state != ContactState::slack) return false;
    const Geometry g = geometry(q, y_.data());
    return g.depth > q.law.slack(g.rate).depth;
}

// Two bodies that separate on straight lines never engage by themselves: ξ decreases and the slack grows.
template <class Law>
double Cluster<Law>::time_to_engage(const ContactPair<Law>& q) const {
    if (!q.fresh && is_pressed(q)) return 0.0;
    const Geometry g = geometry(q, y_.data());
    if (q.second >= 0) return g.rate > 0.0 ? 0.0 : math::infinity;
    return hardlimit::time_to_engage(q.law, g.depth, g.rate, approach_acceleration(q), q.fresh);
}

template <class Law>
double Cluster<Law>::relative_speed_squared(const ContactPair<Law>& q, const double* y) const {
    double sum = 0.0;
    for (int a = 0; a < 3; ++a) {
        double v = y[3 * (count() + q.second) + a] - y[3 * (count() + q.first) + a];
        if (q.image_moves) v += q.image_velocity[static_cast<std::size_t>(a)];
        sum += v * v;
    }
    return sum;
}

}  // namespace hardlimit::boxes
