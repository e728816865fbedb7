// Events of a cluster's pairs: those that may occur, their event functions, and the changes that they cause.
//
// A pair is `fresh` if an event has just occurred, so that an event function is zero. The function is ignored until it
// has become positive; a negative value while it rises is rounding error.
#pragma once
#include <array>
#include <vector>

#include "../../../contact/events.hpp"
#include "equations.hpp"
#include "scales.hpp"

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

// Those of the surfaces of a pair with friction.
template <FrictionalLaw Law>
std::array<ContactEvent, 2> next_surface_events(const ContactPair<Law>& q) {
    if (q.state != ContactState::closed) return {ContactEvent::none, ContactEvent::none};
    const FrictionTerms& f = q.law.friction;
    const bool keeps_slipping = q.surfaces.slips && (q.surfaces.frozen || q.surfaces.keeps_slipping);
    const bool changes = f.coefficient < math::infinity && !keeps_slipping;
    return {f.loading != f.unloading ? ContactEvent::turns : ContactEvent::none, !changes ? ContactEvent::none
                                                                                 : q.surfaces.slips
                                                                                     ? ContactEvent::sticks
                                                                                     : ContactEvent::slips};
}
template <FrictionalLaw Law>
bool& is_fresh(ContactPair<Law>& q, ContactEvent kind) {
    return kind == ContactEvent::turns ? q.surfaces.turned : q.surfaces.fresh;
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

// Event function of the surfaces of a pair at a state with the derivative dy.
template <FrictionalLaw Law>
double surface_value(const Snapshot<Law>& now, const double* dy, int pair, ContactEvent kind) {
    const SurfacePair<Law> at(now, pair);
    if (kind == ContactEvent::turns) return now.network.pairs[pair].surfaces.unloads ? -at.g.rate : at.g.rate;
    return kind == ContactEvent::slips ? at.grip() : at.slipping(dy);
}
// The same, and a smooth function of the same sign. If the contact `begins`, all forces may begin at zero, and the
// latter is divided by powers of the normal force.
struct SurfaceValue {
    double value, smooth;
};
template <FrictionalLaw Law>
SurfaceValue surface_values(const Snapshot<Law>& now, const double* dy, int pair, ContactEvent kind,
                            bool begins) {
    const double value = surface_value(now, dy, pair, kind);
    if (kind == ContactEvent::turns) return {value, value};
    const SurfacePair<Law> at(now, pair);
    const double limit = at.limit();
    begins = begins && limit > 0.0;
    if (kind == ContactEvent::sticks) return {value, begins ? value * at.s / limit : value};
    const Vector3 force = at.limited();
    const double square = limit * limit, smooth = square - dot(force, force);
    return {value, begins ? smooth / square : smooth};
}

// Decides whether the surfaces of a pair stick when its contact begins, or after a jump of a velocity.
template <FrictionalLaw Law>
class SurfaceStart {
public:
    SurfaceStart(ContactNetwork<Law>& network, StateVector& state, int pair)
        : network_(network), state_(state), pair_(pair), q_(network.pairs[pair]) {}

    // At touch, from the forces to leading order in ξ; where a force begins in a pair that overlaps, F_n = 0 as well.
    void decide(bool at_touch) {
        const SurfacePair<Law> now(state_.at(network_), pair_);
        const double size = length(now.slip),
                     force = at_touch ? math::max(q_.law.force(0.0, now.g.rate), 0.0) : 0.0;
        q_.surfaces = {};
        q_.surfaces.slip = now.slip;
        q_.surfaces.fresh = true;
        q_.surfaces.unloads = !(now.g.rate > 0.0);
        q_.surfaces.turned = true;
        keep({});
        const FrictionTerms& f = now.friction();
        if (now.never_slips() || size == 0.0) return;
        if (at_touch && sticks_at_touch(now, size)) return;
        slip_along(now.slip);
        if (!now.has_spring()) return;
        const double damping = f.damping.power == 0 && !now.limits_spring() ? f.damping.factor : 0.0;
        const WorkVector<double> before = copy();
        if (p > 1 && at_touch) compress(now);
        if (force == 0.0 && f.damping.power == 0) align();
        bool slips = excess() > 0.0;
        if (!slips && p > 1 && at_touch && now.history() > 0) {
            slip_along(-1.0 * now.slip);  // a history that grows with the radius may drive the surfaces
            slips = excess() > 0.0;
        }
        Vector3 memory =
            (force > 0.0 ? q_.law.friction.coefficient * force / size - damping : -damping) * now.slip;
        if (!slips && p > 1 && at_touch && now.history() > 0) {  // T/a^m, which does not vanish at touch
            slip_along(now.slip);
            const SurfacePair<Law> near(state_.at(network_), pair_);
            memory = (1.0 / near.radius_power()) * near.elastic();
        }
        for (std::size_t c = 0; c < before.size(); ++c)
            if (c < from() || c >= from() + 4) state_.y[c] = before[c];
        if (slips) return;
        q_.surfaces.slips = q_.surfaces.slid = false;
        keep(memory);
    }
    // T is known, and the force or the velocities have changed.
    void continue_after_jump(const Vector3& elastic) {
        q_.surfaces.slips = q_.surfaces.frozen = false;
        q_.surfaces.fresh = q_.surfaces.turned = false;
        const SurfacePair<Law> now(state_.at(network_), pair_);
        q_.surfaces.unloads = !(now.g.rate > 0.0);
        if (q_.surfaces.slip == Vector3{}) q_.surfaces.slip = now.slip;
        const double scale = now.radius_power();
        keep(scale > 0.0 ? (1.0 / scale) * elastic : Vector3{});
        if (!now.never_slips() && now.grip() < 0.0) slip_along(now.limited());
    }
    void begin_slip() {
        const SurfacePair<Law> now(state_.at(network_), pair_);
        slip_along(now.limited());
        count();
    }
    void begin_stick() {
        const SurfacePair<Law> now(state_.at(network_), pair_);
        const double scale = now.radius_power();
        const Vector3 elastic = now.elastic();
        q_.surfaces.slips = q_.surfaces.frozen = false;
        keep(scale > 0.0 ? (1.0 / scale) * elastic : Vector3{});
        count();
    }
    // The compression begins to rise or to fall.
    void turn() {
        const SurfacePair<Law> now(state_.at(network_), pair_);
        const Vector3 elastic = now.elastic();
        q_.surfaces.unloads = !q_.surfaces.unloads;
        const double scale = now.radius_power();
        if (!q_.surfaces.slips) keep(scale > 0.0 ? (1.0 / scale) * elastic : Vector3{});
    }
    // Makes e the direction of slip, and z = 0. Returns whether anything changes.
    bool renew_direction() {
        const SurfacePair<Law> now(state_.at(network_), pair_);
        if (!q_.surfaces.slips || !now.has_spring()) return false;
        const bool turned = state_.y[from() + 3] != 0.0;
        keep(now.direction());
        return turned;
    }

private:
    static constexpr int p = Law::onset_power;

    ContactNetwork<Law>& network_;
    StateVector& state_;
    const int pair_;
    ContactPair<Law>& q_;

    std::size_t from() const { return static_cast<std::size_t>(state_.layout.surface(pair_)); }
    void count() {
        q_.surfaces.fresh = true;
        ++q_.surfaces.changes;
    }
    void keep(const Vector3& memory) {
        std::ranges::copy(memory, &state_.y[from()]);
        state_.y[from() + 3] = 0.0;
    }
    void slip_along(const Vector3& direction) {
        q_.surfaces.slips = q_.surfaces.slid = true;
        keep(SurfacePair<Law>::unit(direction));
    }
    WorkVector<double> copy() const {
        WorkVector<double> y;
        y.assign(state_.y.begin(), state_.y.end());
        return y;
    }
    bool sticks_at_touch(const SurfacePair<Law>& now, double slip) const {
        const FrictionTerms& f = now.friction();
        const double least = 1e-30 * q_.depth_unit, rate = now.g.rate;
        if (!(rate > 0.0)) return true;
        const double normal = q_.law.force(onset_root<p>(least), rate),
                     exponent = 0.25 * f.stiffness.power + 1.0;
        const double elastic = f.stiffness(least) * least / (exponent - 0.5 * f.loading) * (slip / rate);
        const double viscous = now.limits_spring() ? 0.0 : f.damping(least) * slip;
        return elastic + viscous <= f.coefficient * normal;
    }
    // Moves the first body a little into the contact.
    void compress(const SurfacePair<Law>& now) {
        const double depth = 1e-6 * q_.depth_unit - now.g.depth;
        for (std::size_t k = 0; k < 3; ++k)
            state_.y[static_cast<std::size_t>(state_.layout.position(q_.first)) + k] +=
                depth * now.g.normal[k];
    }
    auto drive() const {
        WorkVector<double> dy;
        dy.resize(state_.y.size());
        Equations<Law>{network_, state_.layout, true}(state_.y.data(), dy.data());
        return SurfacePair<Law>(state_.at(network_), pair_).drive(dy.data());
    }
    double excess() const { return drive().excess; }
    // F_n = 0: f is the direction of h.
    void align() {
        for (int i = 0; i < 3; ++i) {
            const SurfacePair<Law> now(state_.at(network_), pair_);
            slip_along(now.in_surface(drive().h));
        }
    }
};

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
// The same for the surfaces.
template <FrictionalLaw Law>
PairEvent surface_event_at_start(ContactNetwork<Law>& network, const StateVector& state, const double* dy) {
    for (int i = 0; i < static_cast<int>(network.pairs.size()); ++i) {
        ContactPair<Law>& q = network.pairs[i];
        for (const ContactEvent kind : next_surface_events(q))
            if (kind != ContactEvent::none && !is_fresh(q, kind) &&
                !(surface_value(state.at(network), dy, i, kind) >= 0.0))
                return {kind, i};
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
        if constexpr (FrictionalLaw<Law>)
            if (event.what >= ContactEvent::turns) return apply_to_surfaces(event);
        const ContactGeometry g = state.at(network).geometry(q);
        q.fresh = true;
        if (event.what == ContactEvent::engages)
            state.add_loss(q, -q.law.energy(onset_root<Law::onset_power>(g.depth)));
        if (event.what == ContactEvent::begins || event.what == ContactEvent::engages) begin(q, g);
        if constexpr (FrictionalLaw<Law>) start_friction(event);
        if (event.what == ContactEvent::ends) end(event.pair, g);
        if (event.what == ContactEvent::opens) q.state = ContactState::open;
    }

    // After loading: pairs whose contact begins with the run, or goes on after a jump.
    void start_friction()
        requires FrictionalLaw<Law>
    {
        using Start = typename PairSurfaces<Law>::Start;
        for (int i = 0; i < static_cast<int>(network.pairs.size()); ++i) {
            ContactPair<Law>& q = network.pairs[i];
            const Start start = std::exchange(q.surfaces.start, Start::none);
            if (q.state != ContactState::closed || start == Start::none) continue;
            scales.set(q, network, ledger.largest_compression);
            SurfaceStart<Law> surfaces(network, state, i);
            if (start == Start::touch)
                surfaces.decide(true);
            else
                surfaces.continue_after_jump(q.surfaces.elastic);
        }
    }

private:
    void start_friction(PairEvent event)
        requires FrictionalLaw<Law>
    {
        if (event.what == ContactEvent::begins || event.what == ContactEvent::engages)
            SurfaceStart<Law>(network, state, event.pair).decide(event.what == ContactEvent::begins);
        for (ContactPair<Law>& other : network.pairs)  // a force may have jumped
            if (&other != &network.pairs[event.pair]) other.surfaces.fresh = false;
    }
    void apply_to_surfaces(PairEvent event)
        requires FrictionalLaw<Law>
    {
        if (event.what != ContactEvent::turns && repeats(event)) return;
        SurfaceStart<Law> surfaces(network, state, event.pair);
        if (event.what == ContactEvent::turns) surfaces.turn();
        if (event.what == ContactEvent::slips) surfaces.begin_slip();
        if (event.what == ContactEvent::sticks) surfaces.begin_stick();
        if (event.what == ContactEvent::turns) network.pairs[event.pair].surfaces.turned = true;
    }
    // Where many contacts begin at once, with hardly a force, surfaces could stick and slip without end at one time.
    // Then they slip until time advances.
    bool repeats(PairEvent event)
        requires FrictionalLaw<Law>
    {
        constexpr int most = 2;
        PairSurfaces<Law>& surfaces = network.pairs[event.pair].surfaces;
        surfaces.repeats = surfaces.changed_at == state.time() ? surfaces.repeats + 1 : 0;
        surfaces.changed_at = state.time();
        if (event.what != ContactEvent::sticks || surfaces.repeats < most) return false;
        return surfaces.keeps_slipping = true;
    }
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
        if constexpr (FrictionalLaw<Law>) end_friction(pair);
        state.add_loss(q, q.law.energy(math::max(state.at(network).depth_root(pair, g), 0.0)));
        if (q.rooted) {
            std::vector<int> others = state.layout.rooted();
            std::erase(others, pair);
            state.choose_roots(network, others);
        }
        // A law without slack ends at touch: a remaining overlap is rounding.
        q.state = g.depth > 0.0 && q.law.slack(g.rate).depth > 0.0 ? ContactState::slack : ContactState::open;
    }

    void end_friction(int pair)
        requires FrictionalLaw<Law>
    {
        PairSurfaces<Law>& surfaces = network.pairs[pair].surfaces;
        const double before = length(surfaces.slip);
        const double after = dot(SurfacePair<Law>(state.at(network), pair).slip, surfaces.slip);
        EndedContact& e = ledger.ended.back();
        e.slid = surfaces.slid;
        e.changes = surfaces.changes;
        e.tangential_speed = before;
        e.tangential_restitution = before > 0.0 ? -after / (before * before) : math::nan;
        surfaces = {};
        std::fill_n(&state.y[state.layout.surface(pair)], 4, 0.0);
    }

    static bool share_a_body(const ContactPair<Law>& a, const ContactPair<Law>& b) {
        return a.first == b.first || a.first == b.second ||
               (a.second >= 0 && (a.second == b.first || a.second == b.second));
    }
};

}  // namespace hardlimit::boxes
