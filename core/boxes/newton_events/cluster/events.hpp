// Events of a cluster's pairs: those that may occur, their event functions, and the changes that they cause.
//
// A pair is `fresh` if an event has just occurred, so that an event function is zero. The function is ignored until it
// has become positive; a negative value while it rises is rounding error.
#pragma once
#include <array>
#include <vector>

#include "../../../contact/events.hpp"
#include "scales.hpp"
#include "state.hpp"

namespace hardlimit::boxes {

struct PairEvent {
    ContactEvent what = ContactEvent::none;
    int pair = 0;

    explicit operator bool() const { return what != ContactEvent::none; }
};

// What a step has done. An event changes the state when it is applied; without `moved` it is one at the present state.
struct Progress {
    bool moved = false, failed = false;
    PairEvent event{};
};

// The events that may occur next to a pair; the second may be `none`.
template <class Law>
HL_FN_INLINE std::array<ContactEvent, 2> next_events(const ContactPair<Law>& q) {
    if (q.state == ContactState::open) return {ContactEvent::begins, ContactEvent::none};
    if (q.state == ContactState::slack) return {ContactEvent::opens, ContactEvent::engages};
    return {ContactEvent::ends, q.may_be_too_deep ? ContactEvent::deepens : ContactEvent::none};
}

// Rounding error of a compression, the difference of positions [m]. While others are in contact, a pair that moves by
// less does not begin a contact.
template <class Law>
double rounding(const ContactPair<Law>& q) {
    return 2.0 * math::epsilon * q.contact_distance;
}

// Compression left until the largest of the law [m].
template <class Law>
double depth_left(const ContactNetwork<Law>& network, const ContactPair<Law>& q, const ContactGeometry& g) {
    return deepest_compression * network.smaller_radius(q) - g.depth;
}

// Value of an event function that depends on the positions only.
template <class Law>
double event_value(const Snapshot<Law>& now, const ContactPair<Law>& q, ContactEvent kind) {
    const ContactGeometry g = now.geometry(q);
    if (kind == ContactEvent::begins) return -g.depth;
    if (kind == ContactEvent::opens) return g.depth;
    if (kind == ContactEvent::deepens) return depth_left(now.network, q, g);
    const double excess = g.depth - q.law.slack(g.rate).depth;
    return kind == ContactEvent::ends ? excess : -excess;
}

// d(rate)/dτ of a pair, from the derivative dy of the state.
template <class Law>
double acceleration(const Snapshot<Law>& now, const double* dy, const ContactPair<Law>& q,
                    const ContactGeometry& g) {
    const StateLayout& at = now.layout;
    const double *a = dy + at.velocity(q.first), clock = dy[at.time()];
    if (q.second < 0) return -q.side * (a[q.axis] - clock * now.network.wall_acceleration(q, now.time()));
    const double* b = dy + at.velocity(q.second);
    double along = 0.0;
    for (std::size_t i = 0; i < 3; ++i) along += (b[i] - a[i]) * g.normal[i];
    return -along - clock * (now.relative_speed_squared(q) - g.rate * g.rate) / g.distance;
}

// An event function of a pair and its derivative d/dτ, from the state and its derivative dy.
template <class Law>
EventFunction event_function(const Snapshot<Law>& now, const double* dy, int pair, ContactEvent kind) {
    const ContactPair<Law>& q = now.network.pairs[pair];
    const ContactGeometry g = now.geometry(q);
    const double depth_slope = dy[now.layout.time()] * g.rate;
    if (kind == ContactEvent::deepens) {
        const double left = depth_left(now.network, q, g);
        return {left, -depth_slope, left, -depth_slope};
    }
    PairMotion m{g.depth, depth_slope, g.rate, 0.0, q.rooted, 0.0, 0.0};
    if (kind == ContactEvent::ends || kind == ContactEvent::engages)
        m.rate_slope = acceleration(now, dy, q, g);
    if (q.rooted) m.s = now.y[now.layout.root(pair)], m.s_slope = dy[now.layout.root(pair)];
    return hardlimit::event_function(q.law, kind, m);
}

// The first event whose function is not positive at the start of a step, unless the pair is fresh. value(pair, kind):
// the event function.
template <class Law, class Value>
PairEvent event_at_start(ContactNetwork<Law>& network, const StateVector& state, const Scales& scales,
                         const Value& value) {
    for (int i = 0; i < static_cast<int>(network.pairs.size()); ++i) {
        ContactPair<Law>& q = network.pairs[i];
        if (q.fresh) continue;
        for (const ContactEvent kind : next_events(q)) {
            if (kind == ContactEvent::none || value(i, kind) > 0.0) continue;
            const auto moves = [&] {
                return state.at(network).geometry(q).rate * scales.time(network) > rounding(q);
            };
            if (kind != ContactEvent::begins || moves()) return {kind, i};
            q.fresh = true;  // touches without a contact
        }
    }
    return {};
}

// Changes the state of a pair when an event occurs.
template <class Law>
struct EventChange {
    ContactNetwork<Law>& network;
    StateVector& state;
    const Scales& scales;
    Ledger& ledger;

    void apply(PairEvent event) {
        ContactPair<Law>& q = network.pairs[event.pair];
        const ContactGeometry g = state.at(network).geometry(q);
        q.fresh = true;
        if (event.what == ContactEvent::engages)
            state.add_loss(q, -q.law.energy(onset_root<Law::onset_power>(g.depth)));
        if (event.what == ContactEvent::begins || event.what == ContactEvent::engages) begin(q, g);
        if (event.what == ContactEvent::ends) end(event.pair, g);
        if (event.what == ContactEvent::opens) q.state = ContactState::open;
    }

private:
    void begin(ContactPair<Law>& q, const ContactGeometry& g) {
        ++ledger.begun;
        ledger.begun_pairs += q.second >= 0;
        q.state = ContactState::closed;
        scales.set(q, network, ledger.largest_compression);
        q.begin = network.base + state.time();
        q.impact_speed = g.rate;
        q.overlapped = false;
        for (ContactPair<Law>& other : network.pairs) {
            if (&other == &q || other.state != ContactState::closed || !share_a_body(q, other)) continue;
            q.overlapped = other.overlapped = true;
        }
    }

    void end(int pair, const ContactGeometry& g) {
        ContactPair<Law>& q = network.pairs[pair];
        ledger.ended.push_back(
            {pair, q.begin, network.base + state.time(), q.impact_speed, -g.rate, q.overlapped});
        state.add_loss(q, q.law.energy(math::max(state.at(network).depth_root(pair, g), 0.0)));
        if (q.rooted) {
            std::vector<int> others = state.layout.rooted();
            std::erase(others, pair);
            state.choose_roots(network, others);
        }
        // A law without slack ends at touch: a remaining overlap is rounding.
        q.state = g.depth > 0.0 && q.law.slack(g.rate).depth > 0.0 ? ContactState::slack : ContactState::open;
    }

    static bool share_a_body(const ContactPair<Law>& a, const ContactPair<Law>& b) {
        return a.first == b.first || a.first == b.second ||
               (a.second >= 0 && (a.second == b.first || a.second == b.second));
    }
};

}  // namespace hardlimit::boxes
