// Integration of a cluster's equations of motion: one step of order 8.
#pragma once
#include "cluster.hpp"

namespace hardlimit::boxes {

// Returns γ, and stores γ (ℓ/s)^{p−1} of each rooted contact in factor_.
template <class Law>
double Cluster<Law>::clock_rate(const double* y) const {
    if constexpr (p == 1) return 1.0;
    const auto for_rooted = [this](const auto& f) {
        for (const int q : rooted_) f(q);
    };
    for_rooted([&](int q) { factor_[q] = math::power<p - 1>(y[slot_[q]] / pairs[q].s_unit); });
    return smooth_time_rate(for_rooted, factor_.data());
}

template <class Law>
void Cluster<Law>::derivative(const double* y, double* dy) const {
    const int n = count();
    const double gamma = clock_rate(y);
    for (int i = 0; i < 3 * n; ++i) dy[i] = gamma * y[3 * n + i];
    for (int i = 3 * n; i < 6 * n; i += 3)
        for (std::size_t a = 0; a < 3; ++a) dy[static_cast<std::size_t>(i) + a] = gravity[a];
    double loss_rate = 0.0, power = 0.0, shear_power = 0.0;
    SymmetricTensor pressing;           // Σ r⊗F
    double given[2 * most_walls] = {};  // force on each wall of the pairs, and power that it gets
    for (std::size_t q = 0; q < pairs.size(); ++q) {
        const ContactPair<Law>& pair = pairs[q];
        if (pair.state != ContactState::closed) continue;
        const Geometry g = geometry(pair, y);
        const double s = depth_root(static_cast<int>(q), g, y);
        const double force = pair.law.force(s, g.rate);
        const double lost = (force - pair.law.elastic_force(s)) * g.rate;
        loss_rate += lost;
        if (pair.second >= 0) pressing.add_square(force * g.distance, g.normal);
        if (pair.image_moves) shear_power -= force * dot(g.normal, pair.image_velocity);
        if (pair.second < 0) {
            const double work = force * pair.side * wall_velocity(pair, y[time_index()]);
            power += work;
            double* const of_wall = given + 2 * wall_slot_[pair.wall_id.index()];
            of_wall[0] += force, of_wall[1] += lost - work;
        }
        for (int a = 0; a < 3; ++a) {
            const double along = force * g.normal[static_cast<std::size_t>(a)];
            dy[3 * (n + pair.first) + a] -= along / members[pair.first].mass;
            if (pair.second >= 0) dy[3 * (n + pair.second) + a] += along / members[pair.second].mass;
        }
        if (pair.rooted) dy[slot_[q]] = g.rate / p * factor_[q] / math::power<p - 1>(pair.s_unit);
    }
    if constexpr (p > 1)
        for (int i = 3 * n; i < 6 * n; ++i) dy[i] *= gamma;
    dy[time_index()] = gamma;
    dy[loss_index()] = gamma * loss_rate;
    if (walls_move_) dy[wall_work_index()] = gamma * power;
    if (images_move_) dy[shear_work_index()] = gamma * shear_power;
    for (std::size_t k = 0; k < SymmetricTensor::size; ++k)
        dy[static_cast<std::size_t>(virial_index()) + k] = gamma * pressing.component[k];
    for (int k = 0; k < 2 * touched_walls_; ++k) dy[wall_sums_index() + k] = gamma * given[k];
}

// Chooses the coordinate of each closed contact: s if it is compressed or approaches fast, otherwise the positions. s
// is kept if the compression is lost in the rounding error of the positions. It is not used for a contact that has
// hardly begun and hardly moves, which would stop the scaled time of all others.
template <class Law>
void Cluster<Law>::choose_coordinates() {
    if constexpr (p == 1) return;
    bool changed = false, at_zero = false;
    const double unit = time_unit();
    std::vector<int> chosen;
    for (std::size_t q = 0; q < pairs.size(); ++q) {
        ContactPair<Law>& pair = pairs[q];
        bool use = false;
        if (pair.state == ContactState::closed) {
            const Geometry g = geometry(pair, y_.data());
            const double sigma = depth_root(static_cast<int>(q), g, y_.data()) / pair.s_unit;
            const bool earnest = sigma > 0.1 || math::abs(g.rate) > sigma * speed_unit_;
            const bool lost = pair.rooted && g.depth < resolved_depth * pair.contact_distance;
            const bool still = sigma < 0.01 && !(math::abs(g.rate) * unit > rounding(pair));
            use = (earnest || lost) && !still && !(sigma <= 0.0 && at_zero);
            at_zero = at_zero || (use && sigma <= 0.0);
        }
        if (use) chosen.push_back(static_cast<int>(q));
        changed = changed || use != pair.rooted;
    }
    if (changed) rearrange(chosen);
}

template <class Law>
void Cluster<Law>::rearrange(const std::vector<int>& chosen) {
    Scratch<double> y;
    y.assign(y_.begin(), y_.begin() + first_root_index());
    for (const int q : chosen) y.push_back(depth_root(q, geometry(pairs[q], y_.data()), y_.data()));
    y.insert(y.end(), y_.begin() + virial_index(), y_.end());
    for (ContactPair<Law>& q : pairs) q.rooted = false;
    rooted_.assign(chosen.begin(), chosen.end());
    for (std::size_t i = 0; i < chosen.size(); ++i) {
        pairs[chosen[i]].rooted = true;
        slot_[chosen[i]] = first_root_index() + static_cast<int>(i);
    }
    y_.swap(y);
    known_ = false;
    resize();
    h_ = math::min(h_, 0.25 * time_unit());
}

template <class Law>
void Cluster<Law>::integration_step(double until) {
    const bool in_contact = any(ContactState::closed);
    for (ContactPair<Law>& q : pairs)
        if (q.state == ContactState::closed || !in_contact) set_scales(q);
    choose_coordinates();
    if (!(h_ > 0.0)) h_ = 0.25 * time_unit();
    if (!known_) derivative(y_.data(), k_.data());
    known_ = true;
    if (event_at_start([this](int q, Event kind) { return event_at(q, kind, y_.data(), k_.data()).value; }))
        return;
    double length = h_;
    bool last = false;
    if constexpr (p == 1) {
        last = length >= until - y_[time_index()];
        if (last) length = until - y_[time_index()];
    }
    if (try_step(length, last)) end_step(until, length, last);
}

// Computes a step of this length into end_, and sets the length of the next one. Returns whether the error is accepted.
template <class Law>
bool Cluster<Law>::try_step(double length, bool last) {
    advance(length, end_.data());
    set_tolerance(length);
    // The virial has no tolerance of its own, but counts as one component.
    const int used = virial_index();
    const double error =
        DormandPrince::error(stages_.data(), length, dimension(), tolerance_.data(), used, used + 1);
    const double growth = DormandPrince::growth(error);
    const bool accepted = error <= 1.0;
    if (!accepted || !last || growth < 1.0) h_ = length * growth;
    if (!accepted && h_ < 1e-20 * time_unit()) unresolved = true;
    return accepted;
}

// Takes the step up to the first event or to `until`.
template <class Law>
void Cluster<Law>::end_step(double until, double length, bool last) {
    derivative(end_.data(), k_end_.data());
    if (end_[time_index()] > until) {
        length = shorten_to_time(until, length);
        last = true;
    }
    Event what = Event::none;
    int which = 0;
    for (std::size_t q = 0; q < pairs.size(); ++q)
        for (const Event kind : events_of(pairs[q]))
            if (kind != Event::none && crosses(static_cast<int>(q), kind, length)) {
                what = kind;
                which = static_cast<int>(q);
                last = false;
            }
    if (ends_within_rounding()) return;
    if (what != Event::none && end_[time_index()] > until) {  // time would have run backwards beyond touch
        length = shorten_to_time(until, length);
        last = true;
        what = Event::none;
    }
    for (std::size_t q = 0; q < pairs.size(); ++q)
        if (pairs[q].fresh && (what == Event::none || which != static_cast<int>(q)))
            pairs[q].fresh = still_fresh(static_cast<int>(q));
    record_compressions(length);
    y_.swap(end_);
    k_.swap(k_end_);
    if (last) y_[time_index()] = until;
    time = y_[time_index()];
    record_state();
    if (what != Event::none) apply(what, which);
}

// Updates the largest compression from the step y_ to end_. If the rate falls through zero, one more state near that
// point and a parabola give the maximum.
template <class Law>
void Cluster<Law>::record_compressions(double length) {
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        const ContactPair<Law>& q = pairs[i];
        if (q.state != ContactState::closed || !q.may_be_deepest) continue;
        const Geometry a = geometry(q, y_.data()), b = geometry(q, end_.data());
        record_compression(q, math::max(a.depth, b.depth));
        if (!(a.rate > 0.0 && b.rate < 0.0)) continue;
        probe(length * (a.rate / (a.rate - b.rate)));
        const Geometry near = geometry(q, trial_.data());
        const double slope = acceleration(q, near, trial_.data(), k_trial_.data());
        const double beyond = k_trial_[time_index()] * near.rate * near.rate / (-2.0 * slope);
        record_compression(q, near.depth + (slope < 0.0 ? beyond : 0.0));
    }
}

// Ends a contact that began within rounding of touch and separates: for s < 0, γ < 0 and time would run backwards.
template <class Law>
bool Cluster<Law>::ends_within_rounding() {
    if (!(end_[time_index()] < y_[time_index()])) return false;
    for (const int q : rooted_)
        if (end_[slot_[q]] < 0.0) {
            apply(Event::ends, q);
            return true;
        }
    return false;
}

// Shortens the step to end at `until`, and leaves the state there in end_.
template <class Law>
double Cluster<Law>::shorten_to_time(double until, double length) {
    double low = 0.0, high = length,
           at = length * (until - y_[time_index()]) / (end_[time_index()] - y_[time_index()]);
    for (int i = 0; i < 80; ++i) {
        probe(at);
        const double excess = trial_[time_index()] - until;
        (excess > 0.0 ? high : low) = at;
        const double next = at - excess / k_trial_[time_index()], previous = at;
        at = next > low && next < high ? next : 0.5 * (low + high);
        if (math::abs(at - previous) <= 4.0 * math::epsilon * length) break;
    }
    probe(at);
    end_.swap(trial_);
    k_end_.swap(k_trial_);
    return at;
}

template <class Law>
void Cluster<Law>::set_tolerance(double length) {
    const int n = count();
    double depth = math::infinity, force = 0.0;
    for (std::size_t q = 0; q < pairs.size(); ++q) {
        if (pairs[q].state != ContactState::closed) continue;
        depth = math::min(depth, pairs[q].depth_unit);
        const Geometry g = geometry(pairs[q], y_.data());
        force = math::max(
            force, math::abs(pairs[q].law.force(depth_root(static_cast<int>(q), g, y_.data()), g.rate)));
    }
    for (int i = 0; i < n; ++i) {
        // Rounding of the forces is not an error of the step, and a shorter step would not reduce it.
        const double rounding = 0.25 * math::epsilon * length * force / members[i].mass;
        const double fastest =
            speed_unit_ * math::sqrt(lightest_ / members[i].mass);  // with all energy of the cluster
        for (int a = 0; a < 3; ++a) {
            tolerance_[3 * i + a] =
                math::max(tolerance * depth, 4.0 * math::epsilon * math::abs(y_[3 * i + a]));
            tolerance_[3 * (n + i) + a] = math::max(tolerance * fastest, rounding);
        }
    }
    tolerance_[time_index()] = tolerance * time_unit();
    tolerance_[loss_index()] = tolerance * math::max(energy_unit(), math::abs(y_[loss_index()] - dissipated));
    if (walls_move_) tolerance_[wall_work_index()] = math::infinity;
    if (images_move_) tolerance_[shear_work_index()] = math::infinity;
    for (const int q : rooted_)
        tolerance_[slot_[q]] = tolerance * (math::abs(y_[slot_[q]]) + pairs[q].s_unit);
}

}  // namespace hardlimit::boxes
