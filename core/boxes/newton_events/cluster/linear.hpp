// A step of a cluster under a linear law: a power series in time (kernels/power_series.hpp), with events at zeros of
// polynomials.
#pragma once
#include <utility>

#include "cluster.hpp"

namespace hardlimit::boxes {

template <class Law>
void Cluster<Law>::series_step(double until) {
    const bool in_contact = any(ContactState::closed);
    for (ContactPair<Law>& q : pairs)
        if (q.state == ContactState::closed || !in_contact) set_scales(q);
    if (event_at_start([this](int q, Event kind) { return event_value(pairs[q], kind); })) return;
    const double unit = series_unit();
    expand_series(unit);
    const double rest = (until - y_[time_index()]) / unit, step = longest_step();
    step_ = math::min(step, 1.0);
    StepEvent found{math::min(step, rest)};
    const bool last = rest <= step;
    for (const series::Contact& f : contacts_) predict_end(f, found);
    if (contacts_.size() < pairs.size()) predict_begins(unit, found);
    for (const series::Contact& f : contacts_) record_compressions(f, found.at);
    advance_series(found.at, unit);
    if (last && found.what == Event::none) y_[time_index()] = until;
    time = y_[time_index()];
    open_pairs(found);
    for (std::size_t q = 0; q < pairs.size(); ++q)
        if (pairs[q].fresh && (found.what == Event::none || found.which != static_cast<int>(q)))
            pairs[q].fresh = lies_on_surface(pairs[q]);
    record_state();
    if (found.what != Event::none) apply(found.what, found.which);
}

template <class Law>
bool Cluster<Law>::move_to(double end) {
    constexpr int most_steps = 8;
    load_state();
    for (ContactPair<Law>& q : pairs) set_scales(q);
    for (int i = 0; i < most_steps && time != end; ++i) {
        const double unit = series_unit(), rest = (end - time) / unit;
        expand_series(unit);
        const double step = longest_step();
        advance_series(math::clamp(rest, -step, step), unit);
        if (math::abs(rest) <= step) y_[time_index()] = end;
        time = y_[time_index()];
    }
    store_state();
    return time == end;
}

// Unit of time: of the fastest contact or sine.
template <class Law>
double Cluster<Law>::series_unit() const {
    double square = 0.0;
    for (const ContactPair<Law>& q : pairs)
        if (q.state == ContactState::closed) square = math::max(square, q.law.elastic_force(1.0) / q.mass);
    for (const WallPiece& p : wall_pieces) square = math::max(square, p.omega * p.omega);
    return 1.0 / math::sqrt(square);
}

// Value of an event function at the present state.
template <class Law>
double Cluster<Law>::event_value(const ContactPair<Law>& q, Event kind) const {
    const Geometry g = geometry(q, y_.data());
    if (kind == Event::begins) return -g.depth;
    if (kind == Event::opens) return g.depth;
    if (kind == Event::deepens) return depth_left(q, g);
    const double excess = g.depth - q.law.slack(g.rate).depth;
    return kind == Event::ends ? excess : -excess;
}

template <class Law>
bool Cluster<Law>::lies_on_surface(const ContactPair<Law>& q) const {
    for (const Event kind : events_of(q))
        if (kind != Event::none && !(event_value(q, kind) > 0.0)) return true;
    return false;
}

// Expands the motion of all members and of all overlapping pairs in time.
template <class Law>
void Cluster<Law>::expand_series(double unit) {
    series_.resize(members.size());
    travel_.resize(members.size());
    for (int i = 0; i < count(); ++i) {
        const double *x = &y_[3 * i], *v = &y_[3 * (count() + i)];
        series_[i][0] = series::Four{x[0], x[1], x[2], 0.0};
        series_[i][1] = series::Four{v[0], v[1], v[2], 0.0} * unit;
    }
    contacts_.clear();
    for (std::size_t q = 0; q < pairs.size(); ++q)
        if (pairs[q].state != ContactState::open) add_contact(static_cast<int>(q), unit);
    order_bodies();
    kernels->expand(series_.data(), count(), contacts_.data(), static_cast<int>(contacts_.size()),
                    gravity4().data(), unit);
}

// Orders the members: those in contact, then the others.
template <class Law>
void Cluster<Law>::order_bodies() {
    body_order_.clear();
    is_ordered_.assign(members.size(), 0);
    const auto add = [&](int body) {
        if (!std::exchange(is_ordered_[body], 1)) body_order_.push_back(body);
    };
    for (const series::Contact& f : contacts_) {
        add(f.first);
        if (f.second >= 0) add(f.second);
    }
    in_contact_ = static_cast<int>(body_order_.size());
    if (in_contact_ == count()) return;
    for (int i = 0; i < count(); ++i) add(i);
}

template <class Law>
void Cluster<Law>::add_contact(int index, double unit) {
    const ContactPair<Law>& q = pairs[static_cast<std::size_t>(index)];
    contacts_.emplace_back();
    series::Contact& f = contacts_.back();
    f.pair = index;
    f.first = q.first;
    f.second = q.second;
    f.axis = q.axis;
    f.closed = q.state == ContactState::closed;
    f.side = q.side;
    if (q.second < 0) expand_wall(q, unit, f.wall);
    f.image = series::Four{q.image[0], q.image[1], q.image[2], 0.0};
    f.contact_distance = f.bodies.contact_distance = q.contact_distance;
    f.spring = f.bodies.spring = q.law.elastic_force(1.0);
    f.damper = f.bodies.damper = q.law.force(0.0, 1.0) / unit;
    f.per_mass[0] = 1.0 / members[q.first].mass;
    f.per_mass[1] = q.second < 0 ? 0.0 : 1.0 / members[q.second].mass;
}

template <class Law>
void Cluster<Law>::expand_wall(const ContactPair<Law>& q, double unit, series::Terms& wall) const {
    const double now = y_[time_index()];
    if (boxes_move && !wall_pieces.empty()) return piece(q).expand(now, unit, series::order, wall.of);
    wall = {{q.wall_position(now), q.wall_velocity * unit}};
}

// Step for which the last two terms of the series are about as small as the tolerance.
template <class Law>
double Cluster<Law>::longest_step() const {
    static_assert(series::order == 16);
    double depth = math::infinity, far = 0.0;
    for (const ContactPair<Law>& q : pairs)
        if (q.state == ContactState::closed) depth = math::min(depth, q.depth_unit);
    for (const series::Path& x : series_) far = math::max(far, series::largest(x[0]));
    const double allowed = math::max(0.1 * tolerance * depth, math::epsilon * far);
    const double most = kernels->last_terms(series_.data(), body_order_.data(), in_contact_);
    return most > 0.0 ? math::sqrt(math::sqrt(math::sqrt(math::sqrt(allowed / most)))) : math::infinity;
}

// Predicts when a closed contact ends or a slack pair engages. The instant at which a slack pair opens does not matter,
// as it exerts no force.
template <class Law>
void Cluster<Law>::predict_end(const series::Contact& f, StepEvent& found) const {
    const ContactPair<Law>& q = pairs[static_cast<std::size_t>(f.pair)];
    if (q.state == ContactState::closed) {
        consider(f.pair, Event::ends, f.force_series(), f.spring, found);
        return predict_deepest(f, found);
    }
    series::Terms force = f.force_series();
    for (double& x : force.of) x = -x;
    consider(f.pair, Event::engages, force, f.spring, found);
}

// Predicts when the largest compression of the law is reached.
template <class Law>
void Cluster<Law>::predict_deepest(const series::Contact& f, StepEvent& found) const {
    const ContactPair<Law>& q = pairs[static_cast<std::size_t>(f.pair)];
    if (!q.may_be_too_deep) return;
    series::Terms left = f.second < 0 ? f.depth : f.bodies.distance;
    if (f.second < 0)
        for (double& x : left.of) x = -x;
    left[0] = depth_left(q, geometry(q, y_.data()));
    consider(f.pair, Event::deepens, left, 1.0, found);
}

// Updates the largest compression of a pair up to a time within the step. If its rate falls through zero, Newton's
// method finds the maximum.
template <class Law>
void Cluster<Law>::record_compressions(const series::Contact& f, double at) {
    const ContactPair<Law>& q = pairs[static_cast<std::size_t>(f.pair)];
    if (!f.closed || !q.may_be_deepest) return;
    const series::Terms& shape = f.second < 0 ? f.depth : f.bodies.distance;
    const double sign = f.second < 0 ? 1.0 : -1.0, whole = f.second < 0 ? 0.0 : f.contact_distance;
    struct Depth {
        double value, rate, bend;
    };
    const auto depth = [&](double t) {
        double value = 0.0, rate = 0.0, bend = 0.0;
        for (int k = series::order; k >= 0; --k) {
            bend = bend * t + 2.0 * rate;
            rate = rate * t + value;
            value = value * t + shape[static_cast<std::size_t>(k)];
        }
        return Depth{whole + sign * value, sign * rate, sign * bend};
    };
    const Depth first = depth(0.0), last = depth(at);
    record_compression(q, math::max(first.value, last.value));
    if (!(first.rate > 0.0 && last.rate < 0.0)) return;
    double t = at * (first.rate / (first.rate - last.rate));
    for (int i = 0; i < 8; ++i) {
        const Depth here = depth(t);
        record_compression(q, here.value);
        const double next = math::clamp(t - here.rate / here.bend, 0.0, at);
        if (!(math::abs(next - t) > 1e-7 * at)) break;
        t = next;
    }
}

// Opens slack pairs that are apart after the step, even if one was predicted to engage at that instant.
template <class Law>
void Cluster<Law>::open_pairs(StepEvent& found) {
    for (const series::Contact& f : contacts_) {
        ContactPair<Law>& q = pairs[static_cast<std::size_t>(f.pair)];
        if (q.state != ContactState::slack || geometry(q, y_.data()).depth > 0.0) continue;
        q.state = ContactState::open;
        q.fresh = false;
        if (found.which == f.pair) found.what = Event::none;
    }
}

template <class Law>
void Cluster<Law>::predict_begins(double unit, StepEvent& found) {
    kernels->travel(series_.data(), body_order_.data(), in_contact_, count(), found.at, travel_.data());
    for (std::size_t q = 0; q < pairs.size(); ++q)
        if (pairs[q].state == ContactState::open) predict_begin(static_cast<int>(q), unit, found);
}

template <class Law>
void Cluster<Law>::predict_begin(int index, double unit, StepEvent& found) {
    const ContactPair<Law>& q = pairs[static_cast<std::size_t>(index)];
    const Geometry g = geometry(q, y_.data());
    series::Terms gap;
    if (q.second < 0) {
        expand_wall(q, unit, gap);
        double covered = 0.0;  // at most by the wall
        for (int n = series::order; n >= 1; --n)
            covered = (covered + math::abs(gap[static_cast<std::size_t>(n)])) * found.at;
        if (-g.depth > travel_[q.first] + covered) return;
        for (std::size_t n = 0; n < series::length; ++n)
            gap[n] = q.side * (series_[q.first][n][q.axis] - gap[n]);
        gap[0] = -g.depth;
    } else {
        if (-g.depth > travel_[q.first] + travel_[q.second]) return;
        kernels->square(&series_[q.first], &series_[q.second], q.image.data(), gap.of);
        gap[0] = -g.depth * (g.distance + q.contact_distance);
    }
    consider(index, Event::begins, gap, q.second < 0 ? 1.0 : q.contact_distance, found);
}

// Keeps the first zero of f if it is the earliest event so far. `unit`: change of f per distance.
template <class Law>
void Cluster<Law>::consider(int index, Event kind, const series::Terms& f, double unit,
                            StepEvent& found) const {
    const ContactPair<Law>& q = pairs[static_cast<std::size_t>(index)];
    // The event function of a fresh pair differs from zero by the rounding error of the positions, which is large in a
    // large box or far from the origin of a large cluster.
    double far =
        math::max(math::max(q.contact_distance, largest_coordinate), series::largest(series_[q.first][0]));
    if (q.second >= 0) far = math::max(far, series::largest(series_[q.second][0]));
    const double rounding = 4.0 * math::epsilon * far * unit;
    double zero =
        q.fresh ? kernels->next_zero(f.of, found.at, step_, rounding) : kernels->first_zero(f.of, found.at);
    // A force that is pure rounding may fall through damping without an end of the contact: without damping it would
    // rise at once.
    if (zero == 0.0 && kind != Event::begins && f[0] > 0.0) zero = kernels->first_zero(f.of, found.at);
    if (zero <= found.at) found = {zero, kind, index};
}

// ∫ F dx_wall up to a time within the step, in units of the series.
template <class Law>
double Cluster<Law>::work_on_wall(const series::Contact& f, double at) {
    double sum = 0.0;
    for (int n = series::order; n >= 0; --n) {
        double term = 0.0;
        for (int k = 0; k < n; ++k)
            term += f.force[static_cast<std::size_t>(n - 1 - k)] * (k + 1) *
                    f.wall[static_cast<std::size_t>(k + 1)];
        sum = sum * at + (n > 0 ? term / n : 0.0);
    }
    return sum;
}

// Advances the state to a time within the step.
template <class Law>
void Cluster<Law>::advance_series(double at, double unit) {
    double* chord_deviation = nullptr;
    if (record) {
        trajectory.chord_deviation.resize(trajectory.chord_deviation.size() + members.size());
        chord_deviation =
            trajectory.chord_deviation.data() + (trajectory.chord_deviation.size() - members.size());
    }
    kernels->move(series_.data(), body_order_.data(), in_contact_, count(), contacts_.data(),
                  static_cast<int>(contacts_.size()), at, unit, gravity4().data(), y_.data(),
                  &y_[loss_index()], &y_[virial_index()], chord_deviation);
    for (const series::Contact& f : contacts_) {
        if (!f.closed || f.second >= 0) continue;
        double impulse = 0.0, lost = 0.0;  // of the force on the body, over the unit of time; dissipated
        for (int k = series::order; k >= 0; --k)
            impulse = (impulse + f.force[static_cast<std::size_t>(k)] / (k + 1)) * at;
        const double work = f.side * (wall_pieces.empty() ? impulse * f.wall[1] : work_on_wall(f, at));
        if (walls_move_) y_[wall_work_index()] += work;
        series::add_integrals(f, at, unit, &lost, nullptr);
        const int given = wall_sums_index(pairs[f.pair].wall_id);
        y_[given] += impulse * unit, y_[given + 1] += lost - work;
    }
    y_[time_index()] += at * unit;
}

}  // namespace hardlimit::boxes
