// A step of a cluster that is integrated at order 8, up to the first event of a pair.
#pragma once
#include <utility>
#include <vector>

#include "../../binary_contact/slip_closing.hpp"
#include "event_search.hpp"
#include "turning_step.hpp"

namespace hardlimit::boxes {

// Smallest compression that the positions resolve, relative to the contact distance.
inline constexpr double resolved_depth = 1e-12;

// Chooses the coordinate of each closed contact: s if it is compressed or approaches fast, otherwise the positions.
// s is kept if the compression is lost in the rounding error of the positions. It is not used for a contact that
// has hardly begun and hardly moves, which would stop the scaled time of all others. Returns whether a choice changes.
template <class Law>
bool choose_coordinates(ContactNetwork<Law>& network, StateVector& state, const Scales& scales) {
    bool changed = false, at_zero = false;
    const double unit = scales.time(network);
    const Snapshot<Law> now = state.at(network);
    std::vector<int> chosen;
    for (int i = 0; i < static_cast<int>(network.pairs.size()); ++i) {
        const ContactPair<Law>& q = network.pairs[i];
        bool use = false;
        if (q.state == ContactState::closed) {
            const ContactGeometry g = now.geometry(q);
            const double sigma = now.depth_root(i, g) / q.s_unit;
            const bool earnest = sigma > 0.1 || math::abs(g.rate) > sigma * scales.speed;
            const bool lost = q.rooted && g.depth < resolved_depth * q.contact_distance;
            const bool still = sigma < 0.01 && !(math::abs(g.rate) * unit > rounding(q));
            use = (earnest || lost) && !still && !(sigma <= 0.0 && at_zero);
            at_zero = at_zero || (use && sigma <= 0.0);
        }
        if (use) chosen.push_back(i);
        changed = changed || use != q.rooted;
    }
    if (changed) state.choose_roots(network, chosen);
    return changed;
}

// Those of spins and of surfaces. An error of the direction of slip counts in proportion to the force.
template <FrictionalLaw Law>
void set_tolerances_of_surfaces(const Snapshot<Law>& now, const Scales& scales, double relative, double lost,
                                WorkVector<double>& of) {
    const StateLayout& at = now.layout;
    of[at.rubbed()] = relative * math::max(scales.energy(), math::abs(lost));
    const double time = scales.time(now.network);
    for (int i = 0; i < at.members(); ++i) {
        const double inertia = now.network.rotations[i].inertia;
        std::fill_n(&of[at.spin(i)], 3, relative * math::sqrt(2.0 * scales.energy() / inertia));
    }
    for (int i = 0; i < static_cast<int>(now.network.pairs.size()); ++i) {
        std::fill_n(&of[at.surface(i)], 4, math::infinity);
        const ContactPair<Law>& q = now.network.pairs[i];
        if (q.state != ContactState::closed) continue;
        const SurfacePair<Law> surfaces(now, i);
        const double force = q.mass * scales.speed / time;
        if (q.surfaces.slips) {
            const double part = math::clamp(surfaces.limit() / force, 1e-5, 1.0);
            std::fill_n(&of[at.surface(i)], 4, relative / (part * part));
        } else if (surfaces.has_spring()) {
            const double unit = whole_power(q.s_unit, Law::onset_power * surfaces.history() / 2);
            std::fill_n(&of[at.surface(i)], 3, relative * force / unit);
        }
    }
}

// Sets the tolerance of each component that is under error control, in a step of this length. `relative`: to the units
// of length, speed and energy; `lost`: dissipated since the start.
template <class Law>
void set_tolerances(const Snapshot<Law>& now, const Scales& scales, double length, double relative,
                    double lost, WorkVector<double>& of) {
    const StateLayout& at = now.layout;
    double depth = math::infinity, force = 0.0;
    for (int i = 0; i < static_cast<int>(now.network.pairs.size()); ++i) {
        const ContactPair<Law>& q = now.network.pairs[i];
        if (q.state != ContactState::closed) continue;
        depth = math::min(depth, q.depth_unit);
        const ContactGeometry g = now.geometry(q);
        force = math::max(force, math::abs(q.law.force(now.depth_root(i, g), g.rate)));
    }
    for (int i = 0; i < at.members(); ++i) {
        const double mass = now.network.members[i].mass;
        // Rounding of the forces is not an error of the step, and a shorter step would not reduce it.
        const double rounding = 0.25 * math::epsilon * length * force / mass;
        const double fastest = scales.speed * math::sqrt(scales.mass / mass);  // with all energy
        for (int a = 0; a < 3; ++a) {
            const int x = at.position(i) + a;
            of[x] = math::max(relative * depth, 4.0 * math::epsilon * math::abs(now.y[x]));
            of[at.velocity(i) + a] = math::max(relative * fastest, rounding);
        }
    }
    of[at.time()] = relative * scales.time(now.network);
    of[at.loss()] = relative * math::max(scales.energy(), math::abs(lost));
    if (at.walls_move()) of[at.wall_work()] = math::infinity;
    if (at.images_move()) of[at.shear_work()] = math::infinity;
    if constexpr (FrictionalLaw<Law>) set_tolerances_of_surfaces(now, scales, relative, lost, of);
    for (const int q : at.rooted())
        of[at.root(q)] = relative * (math::abs(now.y[at.root(q)]) + now.network.pairs[q].s_unit);
}

template <class Law>
struct IntegratedStep {
    static constexpr int p = Law::onset_power;

    ContactNetwork<Law>& network;
    StateVector& state;
    const Scales& scales;
    Ledger& ledger;
    Integrator& integrator;
    const double tolerance;  // of a step, relative to the units of length, speed and time
    const Equations<Law> f{network, state.layout};
    int closes = -1;  // the pair that the step is to end, or −1

    Progress take(double until) {
        scales.set_active(network, ledger.largest_compression);
        Integrator& in = integrator;
        const double longest = 0.25 * scales.time(network);
        if (p > 1 && choose_coordinates(network, state, scales)) {
            in.forget();
            in.length = math::min(in.length, longest);
        }
        if (!(in.length > 0.0)) in.length = longest;
        in.begin(f, state);
        double bound = math::infinity;
        in.implicit = false, in.converged = true;
        if constexpr (FrictionalLaw<Law>)
            if (!network.planar) bound = choose_method(longest);
        const Snapshot<Law> start = state.at(network);
        const auto value = [&](int q, ContactEvent kind) {
            return event_function(start, in.slope.data(), q, kind).value;
        };
        if (const PairEvent now = event_at_start(network, state, scales, value)) return {.event = now};
        if constexpr (FrictionalLaw<Law>)
            if (const PairEvent now = surface_event_at_start(network, state, in.slope.data()))
                return {.event = now};
        if constexpr (FrictionalLaw<Law> && p == 1)
            if (in.implicit || bound < math::infinity)
                if (const Progress closed = close(until); closed.moved) return closed;
        if constexpr (FrictionalLaw<Law> && p == 1)
            if (const int pair = TurningStep<Law>::pair_of(network); pair >= 0)
                if (const Progress moved = by_series(pair, until, 2.0 * longest); moved.moved) return moved;
        double& next = in.implicit ? in.implicit_length : in.length;
        if (!(next > 0.0)) next = longest;
        double length = math::min(next, bound);
        bool last = false;
        if constexpr (p == 1) {
            last = length >= until - state.time();
            if (last) length = until - state.time();
        }
        if (in.implicit) set_tolerances(state.at(network), scales, length, tolerance, 0.0, in.tolerance);
        in.advance(f, state, length);
        const double lost = state.y[state.layout.loss()] - ledger.dissipated;
        set_tolerances(state.at(network), scales, length, tolerance, lost, in.tolerance);
        const double error = in.error(state, length);
        const double growth = in.implicit ? Radau::growth(error) : DormandPrince::growth(error);
        const bool accepted = error <= 1.0;
        if (!accepted || (!last && length == next) || growth < 1.0) next = length * growth;
        if (accepted) {
            if (const Progress done = end_step(until, length, last); done.moved || done.event) return done;
            next = 0.25 * length;
        }
        return {.failed = next < 1e-20 * scales.time(network)};
    }

private:
    // Chooses the method of the step, and returns a bound of its length. A direction that relaxes quickly is implicit.
    // One that relaxes slowly at the end of its contact is followed by steps in proportion to F_n, until the rest of
    // the impulse is negligible, and then keeps still.
    double choose_method(double longest)
        requires FrictionalLaw<Law>
    {
        constexpr double mild = 3.0, negligible = 1e-14;
        double bound = math::infinity;
        bool freezes = false;
        for (int i = 0; i < static_cast<int>(network.pairs.size()); ++i) {
            PairSurfaces<Law>& surfaces = network.pairs[i].surfaces;
            if (!f.turns(i) && !surfaces.frozen) continue;
            const SurfacePair<Law> at(state.at(network), i);
            const auto drive = at.drive(integrator.slope.data());
            const double limit = math::max(at.limit(), 0.0), step = math::min(integrator.length, longest);
            const double pull = math::sqrt(drive.along * drive.along + drive.across * drive.across);
            const bool stiff = !(pull * step < mild * limit);
            if (!(drive.growth < 0.0)) {
                surfaces.frozen = false;
                integrator.implicit = integrator.implicit || stiff;
                continue;
            }
            const double left = limit / -drive.growth,
                         rest = integrator.slope[state.layout.time()] * limit * left;
            if (surfaces.frozen || rest < negligible * network.pairs[i].mass * scales.speed) {
                freezes = freezes || !surfaces.frozen;
                surfaces.frozen = true;
            } else if (pull * left < mild * limit) {
                bound = math::min(bound, 0.45 * left);
            } else {
                integrator.implicit = integrator.implicit || stiff;
            }
        }
        if (freezes) {
            integrator.forget();
            integrator.begin(f, state);
        }
        return bound;
    }
    // A step to the end of a contact whose surfaces slip, in which the mean of the direction replaces it
    // (binary_contact/slip_closing.hpp). Does nothing if no contact ends so soon, or another event comes before.
    Progress close(double until)
        requires FrictionalLaw<Law>
    {
        Integrator& in = integrator;
        const double longest = math::min(in.length, until - state.time()) / 1.3;
        for (int i = 0; i < static_cast<int>(network.pairs.size()); ++i) {
            const ContactPair<Law>& q = network.pairs[i];
            if (!f.turns(i) || q.law.friction.damping.power != 0 || q.law.friction.stiffness.power != 0)
                continue;
            const SurfacePair<Law> at(state.at(network), i);
            const FallingForce force = falling(at, i);
            if (!(force.fall > 0.0 && force.limit > 0.0 && force.left() < longest)) continue;
            const Vector3 &along = at.direction(), across = cross(at.g.normal, along);
            const auto seen = [&](const Vector3& x) { return SlipVector{dot(x, along), dot(x, across)}; };
            const SlipVector slowed{force.mobility * force.limit, 0.0};
            const SlipClosing closing(force, seen(at.slip), seen(at.slip_change(in.slope.data())) + slowed);
            if (!closing.is_within(tolerance * q.mass * scales.speed, force)) continue;
            const SlipVector mean = closing.mean();
            return close(i, mean.along * along + mean.across * across, 1.2 * force.left());
        }
        return {};
    }
    FallingForce falling(const auto& at, int pair) const
        requires FrictionalLaw<Law>
    {
        const ContactPair<Law>& q = network.pairs[pair];
        const double* slope = integrator.slope.data();
        const auto mobility = [&](int member, double arm) {
            return 1.0 / network.members[member].mass + arm * arm / network.rotations[member].inertia;
        };
        const double mu = q.law.friction.coefficient, fall = -at.drive(slope).growth;
        const double bend =
            mu * q.law.coefficients().elastic * acceleration(state.at(network), slope, q, at.g) +
            q.law.coefficients().damping * fall / q.mass;
        return {.stiffness = q.law.friction.stiffness.factor,
                .dashpot = at.limits_spring() ? 0.0 : at.damping(),
                .mobility = mobility(q.first, at.first_arm) +
                            (q.second < 0 ? 0.0 : mobility(q.second, at.second_arm)),
                .limit = at.limit(),
                .fall = fall,
                .bend = bend,
                .turning = length(at.turn) + length(at.spin) / (at.first_arm + at.second_arm),
                .others = 1.0 / scales.time(network)};
    }
    Progress close(int pair, const Vector3& mean, double length)
        requires FrictionalLaw<Law>
    {
        Integrator& in = integrator;
        PairSurfaces<Law>& surfaces = network.pairs[pair].surfaces;
        double* const memory = &state.y[state.layout.surface(pair)];
        const Vector3 direction = vector_at(memory);
        const bool implicit = std::exchange(in.implicit, false);
        const auto replace = [&](const Vector3& x, bool frozen) {
            std::ranges::copy(x, memory);
            surfaces.frozen = frozen;
            in.forget();
            in.begin(f, state);
        };
        replace(mean, true);
        closes = pair;
        Progress done{};
        if (TurningStep<Law>::pair_of(network) == pair) {
            done = by_series(pair, math::infinity, length);
        } else {
            in.advance(f, state, length);
            set_tolerances(state.at(network), scales, length, tolerance, 0.0, in.tolerance);
            if (in.error(state, length) <= 1.0) done = end_step(math::infinity, length, false);
        }
        closes = -1;
        if (done.moved) return done;
        replace(direction, false);
        in.implicit = implicit;
        return done;
    }
    // A step by power series, if they converge in more than a very short one. `pair`: the only one in contact.
    Progress by_series(int pair, double until, double longest)
        requires FrictionalLaw<Law>
    {
        constexpr double least = 5e-4;  // of the longest
        Integrator& in = integrator;
        if (!(SurfacePair<Law>(state.at(network), pair).force > 0.0)) return {};
        TurningStep<Law> step(network, state, pair, 0.01 * tolerance);
        PairEvent event{};
        const double left = until - state.time();
        const double length = step.bound(math::min(longest, left), event);
        if (!(length > least * longest)) return {};
        const bool implicit = std::exchange(in.implicit, false);
        in.series = &step;
        in.advance(f, state, length);
        const Progress done = end_step(until, length, length == left && !event, event);
        in.series = nullptr;
        in.implicit = implicit;
        return done;
    }
    // Takes the step up to the first event or to `until`. Does nothing if a part of the step does not converge.
    // `event`: of the pair of a series, at the end of the step.
    Progress end_step(double until, double length, bool last, PairEvent event = {}) {
        Integrator& in = integrator;
        const auto end = [&] { return in.end[state.layout.time()]; };
        f(in.end.data(), in.end_slope.data());
        const auto end_at_time = [&] {
            length = in.end_at_time(f, state, until, length);
            last = true;
        };
        if (end() > until) end_at_time();
        EventSearch<Law> search{network, state, in, scales.speed};
        for (int q = 0; q < static_cast<int>(network.pairs.size()); ++q)
            for (const ContactEvent kind : next_events(network.pairs[q]))
                if (kind != ContactEvent::none && !(in.series && kind == ContactEvent::ends) &&
                    search.locate(q, kind, length))
                    event = {kind, q}, last = false;
        if constexpr (FrictionalLaw<Law>)
            for (int q = 0; q < static_cast<int>(network.pairs.size()) && !in.series; ++q)
                for (const ContactEvent kind : next_surface_events(network.pairs[q]))
                    if (kind != ContactEvent::none && search.locate_in_surfaces(q, kind, length))
                        event = {kind, q}, last = false;
        if (closes >= 0 && !(event.pair == closes && event.what == ContactEvent::ends)) return {};
        if (event && end() > until) {  // time would have run backwards beyond touch
            end_at_time();
            event = {};
        }
        if (!in.converged) return {};
        if (const PairEvent now = ends_within_rounding()) return {.event = now};
        for (int q = 0; q < static_cast<int>(network.pairs.size()); ++q)
            if (network.pairs[q].fresh && !(event && event.pair == q))
                network.pairs[q].fresh = search.still_fresh(q);
        if constexpr (FrictionalLaw<Law>) refresh_surfaces(search, event);
        record_compressions(length);
        if (in.series) in.series->add_sums(in.end[state.layout.time()] - state.time(), in.end.data());
        in.accept(state);
        if constexpr (FrictionalLaw<Law>) renew_directions();
        if (last) state.time() = until;
        return {.moved = true, .event = event};
    }

    void refresh_surfaces(const EventSearch<Law>& search, PairEvent event)
        requires FrictionalLaw<Law>
    {
        for (int i = 0; i < static_cast<int>(network.pairs.size()); ++i) {
            ContactPair<Law>& q = network.pairs[i];
            for (const ContactEvent kind : next_surface_events(q))
                if (kind != ContactEvent::none && is_fresh(q, kind) &&
                    !(event.pair == i && event.what == kind))
                    is_fresh(q, kind) = search.still_fresh_in_surfaces(i, kind);
        }
    }
    void renew_directions()
        requires FrictionalLaw<Law>
    {
        for (int i = 0; i < static_cast<int>(network.pairs.size()); ++i)
            if (network.pairs[i].state == ContactState::closed &&
                SurfaceStart<Law>(network, state, i).renew_direction())
                integrator.forget();
    }
    // The end of a contact that began within rounding of touch and separates: for s < 0, γ < 0 and time would run
    // backwards.
    PairEvent ends_within_rounding() const {
        const StateLayout& at = state.layout;
        const WorkVector<double>& end = integrator.end;
        if (end[at.time()] < state.time())
            for (const int q : at.rooted())
                if (end[at.root(q)] < 0.0) return {ContactEvent::ends, q};
        return {};
    }

    // Updates the largest compression within the step. If the rate of a pair falls through zero, one more state near
    // that point and a parabola give the maximum.
    void record_compressions(double length) {
        const auto geometry = [&](const WorkVector<double>& y, const ContactPair<Law>& q) {
            return Snapshot<Law>{network, state.layout, y.data()}.geometry(q);
        };
        for (const ContactPair<Law>& q : network.pairs) {
            if (q.state != ContactState::closed || !q.may_be_deepest) continue;
            const ContactGeometry a = geometry(state.y, q), b = geometry(integrator.end, q);
            const double radius = network.smaller_radius(q);
            ledger.add_compression(math::max(a.depth, b.depth) / radius);
            if (!(a.rate > 0.0 && b.rate < 0.0)) continue;
            integrator.probe(f, state, length * (a.rate / (a.rate - b.rate)));
            if (!integrator.converged) continue;
            const Snapshot<Law> trial{network, state.layout, integrator.trial.data()};
            const double* slope = integrator.trial_slope.data();
            const ContactGeometry near = trial.geometry(q);
            const double bend = acceleration(trial, slope, q, near);
            const double beyond = slope[state.layout.time()] * near.rate * near.rate / (-2.0 * bend);
            ledger.add_compression((near.depth + (bend < 0.0 ? beyond : 0.0)) / radius);
        }
    }
};

}  // namespace hardlimit::boxes
