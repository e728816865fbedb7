// Flight of a cluster's members while no pair exerts a force, in closed form up to the next event of a pair.
#pragma once
#include "events.hpp"

namespace hardlimit::boxes {

// Times from now until the events of a pair in flight. Between two bodies common gravity drops out; a body and a wall
// approach on a parabola.
template <class Law>
class PairFlight {
public:
    PairFlight(const Snapshot<Law>& now, const ContactPair<Law>& q) : now_(now), q_(q), g_(now.geometry(q)) {
        if (q.second >= 0) return;
        const double wall = now.network.wall_acceleration(q, now.time());
        towards_ = -q.side * (now.network.gravity[static_cast<std::size_t>(q.axis)] - wall);
    }

    // First t at which the distance falls to the contact distance.
    double time_to_touch() const {
        if (q_.second < 0) {
            const double gap = q_.fresh ? 0.0 : math::max(-g_.depth, 0.0);
            if (gap == 0.0 && g_.rate > 0.0) return 0.0;
            if (gap == 0.0) return towards_ > 0.0 ? -2.0 * g_.rate / towards_ : math::infinity;
            const double square = g_.rate * g_.rate + 2.0 * towards_ * gap;
            if (square < 0.0 || (g_.rate <= 0.0 && towards_ <= 0.0)) return math::infinity;
            if (g_.rate > 0.0) return 2.0 * gap / (g_.rate + math::sqrt(square));
            return (math::sqrt(square) - g_.rate) / towards_;
        }
        if (!(g_.rate > 0.0)) return math::infinity;
        const double b = g_.rate * g_.distance;
        const double c = -g_.depth * (g_.distance + q_.contact_distance);  // r² − σ²
        if (c <= 0.0) return 0.0;
        const double square = b * b - now_.relative_speed_squared(q_) * c;
        return square < 0.0 ? math::infinity : c / (b + math::sqrt(square));
    }

    double time_to_open() const {
        if (q_.second < 0) {
            const double square = g_.rate * g_.rate - 2.0 * towards_ * g_.depth;
            if (g_.depth <= 0.0) return 0.0;
            if (square < 0.0 || (g_.rate >= 0.0 && towards_ >= 0.0)) return math::infinity;
            if (g_.rate <= 0.0) return 2.0 * g_.depth / (math::sqrt(square) - g_.rate);
            return -(g_.rate + math::sqrt(square)) / towards_;
        }
        const double speed2 = now_.relative_speed_squared(q_);
        const double b = -g_.rate * g_.distance;
        const double c = g_.depth * (g_.distance + q_.contact_distance);  // σ² − r²
        if (c <= 0.0) return 0.0;
        if (speed2 == 0.0) return math::infinity;
        const double root = math::sqrt(b * b + speed2 * c);
        return b > 0.0 ? c / (b + root) : (root - b) / speed2;
    }

    // Two bodies that separate on straight lines never engage by themselves: ξ decreases and the slack grows.
    double time_to_engage() const {
        if (!q_.fresh && is_pressed()) return 0.0;
        if (q_.second >= 0) return g_.rate > 0.0 ? 0.0 : math::infinity;
        return hardlimit::time_to_engage(q_.law, g_.depth, g_.rate, towards_, q_.fresh);
    }

    // Whether the force of a slack pair is repulsive: after a jump of a velocity, or by rounding just after its end.
    bool is_pressed() const {
        return q_.state == ContactState::slack && g_.depth > q_.law.slack(g_.rate).depth;
    }

private:
    const Snapshot<Law> now_;
    const ContactPair<Law>& q_;
    const ContactGeometry g_;
    double towards_ = 0.0;  // d(rate)/dt at a wall
};

// Moves all members to the next event of a pair, or to `until`.
template <class Law>
PairEvent fly(ContactNetwork<Law>& network, StateVector& state, double until) {
    double least = until - state.time();
    PairEvent next;
    const auto consider = [&](double t, ContactEvent kind, int pair) {
        if (t < least) least = math::max(t, 0.0), next = {kind, pair};
    };
    for (int i = 0; i < static_cast<int>(network.pairs.size()); ++i) {
        const ContactPair<Law>& q = network.pairs[i];
        const PairFlight<Law> flight(state.at(network), q);
        if (q.state == ContactState::open) {
            consider(flight.time_to_touch(), ContactEvent::begins, i);
        } else {
            consider(flight.time_to_open(), ContactEvent::opens, i);
            consider(flight.time_to_engage(), ContactEvent::engages, i);
        }
    }
    for (int i = 0; i < state.layout.members(); ++i) {
        double *x = &state.y[state.layout.position(i)], *v = &state.y[state.layout.velocity(i)];
        for (std::size_t a = 0; a < 3; ++a) {
            x[a] += least * (v[a] + 0.5 * network.gravity[a] * least);
            v[a] += network.gravity[a] * least;
        }
    }
    state.time() = next ? state.time() + least : until;
    if (least > 0.0)
        for (ContactPair<Law>& q : network.pairs)
            q.fresh = q.fresh && PairFlight<Law>(state.at(network), q).is_pressed();
    return next;
}

}  // namespace hardlimit::boxes
