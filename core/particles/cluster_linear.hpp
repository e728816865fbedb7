// A step of a cluster under a linear law: a power series in time (cluster_series.hpp), in which contacts begin and end
// at zeros of polynomials.
#pragma once
#include "cluster.hpp"

namespace hardlimit::particles {

template <class Law>
void Cluster<Law>::follow(double until) {
    for (Touching<Law>& q : pairs)
        if (q.touch == Touch::closed) scale(q);
    if (on_surface()) return;
    const double unit = series_unit();
    expand(unit);
    const double rest = (until - y_[clock()]) / unit, step = longest_step();
    Found found{math::min(step, rest)};
    const bool last = rest <= step;
    for (int i = 0; i < count(); ++i) travel_[i] = series::travel(paths_[i], found.at);
    for (const Followed& f : followed_) find_end(f, found);
    for (std::size_t q = 0; q < pairs.size(); ++q)
        if (pairs[q].touch == Touch::open) find_begin(static_cast<int>(q), found);
    move(found.at, unit);
    if (last && found.what == Event::none) y_[clock()] = until;
    time = y_[clock()];
    open_pairs(found);
    for (std::size_t q = 0; q < pairs.size(); ++q)
        if (pairs[q].fresh && (found.what == Event::none || found.which != static_cast<int>(q)))
            pairs[q].fresh = lies_on_surface(pairs[q]);
    keep();
    if (found.what != Event::none) apply(found.what, found.which);
}

template <class Law>
double Cluster<Law>::series_unit() const {
    double square = 0.0;
    for (const Touching<Law>& q : pairs)
        if (q.touch == Touch::closed) square = math::max(square, q.law.elastic_force(1.0) / q.mass);
    return 1.0 / math::sqrt(square);
}

// What falls to zero at an event, by the state now.
template <class Law>
double Cluster<Law>::height(const Touching<Law>& q, Event kind) const {
    const Geometry g = geometry(q, y_.data());
    if (kind == Event::begins) return -g.depth;
    if (kind == Event::opens) return g.depth;
    const double excess = g.depth - q.law.slack(g.rate).depth;
    return kind == Event::ends ? excess : -excess;
}

template <class Law>
bool Cluster<Law>::lies_on_surface(const Touching<Law>& q) const {
    for (const Event kind : events_of(q))
        if (kind != Event::none && !(height(q, kind) > 0.0)) return true;
    return false;
}

template <class Law>
bool Cluster<Law>::on_surface() {
    return at_surface([this](int q, Event kind) { return height(pairs[q], kind); });
}

// The series of all members, and of all pairs that overlap.
template <class Law>
void Cluster<Law>::expand(double unit) {
    paths_.resize(members.size());
    push_.resize(members.size());
    travel_.resize(members.size());
    for (int i = 0; i < count(); ++i) {
        const double *x = &y_[3 * i], *v = &y_[3 * (count() + i)];
        paths_[i][0] = series::Four{x[0], x[1], x[2], 0.0};
        paths_[i][1] = series::Four{v[0], v[1], v[2], 0.0} * unit;
    }
    followed_.clear();
    for (std::size_t q = 0; q < pairs.size(); ++q)
        if (pairs[q].touch != Touch::open) take_up(static_cast<int>(q), unit);
    expand_from<0>(unit);
}

// The terms from order n + 2 on.
template <class Law>
template <int n>
void Cluster<Law>::expand_from(double unit) {
    if constexpr (n + 2 > series::order) {
        for (Followed& f : followed_) {
            approach<n + 1>(f);
            push_of<n>(f);
        }
    } else {
        for (int i = 0; i < count(); ++i)
            push_[i] = n == 0 ? series::Four{gravity[0], gravity[1], gravity[2], 0.0} : series::Four{};
        for (Followed& f : followed_) press<n>(f);
        const double share = unit * unit / ((n + 1) * (n + 2));
        for (int i = 0; i < count(); ++i) paths_[i][n + 2] = share * push_[i];
        expand_from<n + 1>(unit);
    }
}

template <class Law>
void Cluster<Law>::take_up(int index, double unit) {
    const Touching<Law>& q = pairs[static_cast<std::size_t>(index)];
    followed_.emplace_back();
    Followed& f = followed_.back();
    f.pair = index;
    f.spring = f.bodies.spring = q.law.elastic_force(1.0);
    f.damper = f.bodies.damper = q.law.force(0.0, 1.0) / unit;
    f.bodies.touch = q.reach;
    f.per_mass[0] = 1.0 / members[q.first].mass;
    f.per_mass[1] = q.second < 0 ? 0.0 : 1.0 / members[q.second].mass;
    f.force[series::order] = f.bodies.force[series::order] = 0.0;
    approach<0>(f);
}

template <class Law>
template <int n>
void Cluster<Law>::approach(Followed& f) {
    const Touching<Law>& q = pairs[static_cast<std::size_t>(f.pair)];
    const series::Four& first = paths_[q.first][n];
    if (q.second < 0) {
        f.depth[n] = n == 0 ? q.reach - q.side * (first[q.axis] - q.wall) : -q.side * first[q.axis];
        return;
    }
    series::Four r = paths_[q.second][n] - first;
    if constexpr (n == 0) r += series::Four{q.image[0], q.image[1], q.image[2], 0.0};
    f.bodies.template approach<n>(r);
}

template <class Law>
template <int n>
void Cluster<Law>::push_of(Followed& f) {
    if (pairs[static_cast<std::size_t>(f.pair)].second >= 0)
        f.bodies.template push<n>();
    else
        f.force[n] = f.spring * f.depth[n] + f.damper * (n + 1) * f.depth[n + 1];
}

// Adds to the accelerations of order n what a pair does.
template <class Law>
template <int n>
void Cluster<Law>::press(Followed& f) {
    const Touching<Law>& q = pairs[static_cast<std::size_t>(f.pair)];
    approach<n + 1>(f);
    if (q.touch != Touch::closed) return push_of<n>(f);
    if (q.second < 0) {
        push_of<n>(f);
        push_[q.first][q.axis] += q.side * f.force[n] / members[q.first].mass;
        return;
    }
    const series::Four apart = f.bodies.template apart<n>();
    push_[q.first] -= apart * f.per_mass[0];
    push_[q.second] += apart * f.per_mass[1];
}

// Up to which the last two terms are about as small as the tolerance.
template <class Law>
double Cluster<Law>::longest_step() const {
    double depth = math::infinity, far = 0.0, last[2] = {0.0, 0.0};
    for (const Touching<Law>& q : pairs)
        if (q.touch == Touch::closed) depth = math::min(depth, q.depth_unit);
    for (const series::Path& x : paths_) {
        far = math::max(far, series::largest(x[0]));
        for (int k : {0, 1}) last[k] = math::max(last[k], series::largest(x[series::order - k]));
    }
    const double allowed = math::max(0.1 * tolerance * depth, math::epsilon * far);
    static_assert(series::order == 16);
    const double most = math::max(last[0], last[1]);
    return most > 0.0 ? math::sqrt(math::sqrt(math::sqrt(math::sqrt(allowed / most)))) : math::infinity;
}

// The end of a contact, or the begin of another one. A pair that overlaps without force does nothing until
// then: the instant at which it opens is none of interest.
template <class Law>
void Cluster<Law>::find_end(const Followed& f, Found& found) const {
    const Touching<Law>& q = pairs[static_cast<std::size_t>(f.pair)];
    series::Terms force = q.second < 0 ? f.force : f.bodies.force;
    if (q.touch == Touch::closed) return consider(f.pair, Event::ends, force, f.spring, found);
    for (double& x : force) x = -x;
    consider(f.pair, Event::engages, force, f.spring, found);
}

// Whether a pair that has overlapped is apart after the step. Where it would push again it may be apart as well.
template <class Law>
void Cluster<Law>::open_pairs(Found& found) {
    for (const Followed& f : followed_) {
        Touching<Law>& q = pairs[static_cast<std::size_t>(f.pair)];
        if (q.touch != Touch::slack || geometry(q, y_.data()).depth > 0.0) continue;
        q.touch = Touch::open;
        q.fresh = false;
        if (found.which == f.pair) found.what = Event::none;
    }
}

template <class Law>
void Cluster<Law>::find_begin(int index, Found& found) {
    const Touching<Law>& q = pairs[static_cast<std::size_t>(index)];
    const Geometry g = geometry(q, y_.data());
    const double both = travel_[q.first] + (q.second < 0 ? 0.0 : travel_[q.second]);
    if (-g.depth > both) return;
    series::Terms gap;
    if (q.second < 0) {
        for (std::size_t n = 0; n < gap.size(); ++n) gap[n] = q.side * paths_[q.first][n][q.axis];
        gap[0] = -g.depth;
    } else {
        gap = series::square(paths_[q.first], paths_[q.second], q.image);
        gap[0] = -g.depth * (g.distance + q.reach);
    }
    consider(index, Event::begins, gap, q.second < 0 ? 1.0 : q.reach, found);
}

// `unit`: of f, by the sum of the radii.
template <class Law>
void Cluster<Law>::consider(int index, Event kind, const series::Terms& f, double unit, Found& found) const {
    const Touching<Law>& q = pairs[static_cast<std::size_t>(index)];
    const double rounding = 4.0 * math::epsilon * q.reach * unit;
    const double zero = q.fresh ? series::next_zero(f, found.at, rounding) : series::first_zero(f, found.at);
    if (zero <= found.at) found = {zero, kind, index};
}

// To a place in the step.
template <class Law>
void Cluster<Law>::move(double at, double unit) {
    for (const Followed& f : followed_) {
        const Touching<Law>& q = pairs[static_cast<std::size_t>(f.pair)];
        if (q.touch != Touch::closed) continue;
        const series::Terms& shape = q.second < 0 ? f.depth : f.bodies.distance;
        const auto sum = series::integrals(shape, at, f.spring, f.damper, q.reach);
        y_[loss()] += f.damper * sum.square;
        if (q.second >= 0) y_[work()] += unit * sum.product;
    }
    if (record)
        for (const series::Path& x : paths_) trace.bulge.push_back(series::bulge(x, at, fall_in(unit)));
    put_at(at, unit);
    y_[clock()] += at * unit;
}

template <class Law>
series::Four Cluster<Law>::fall_in(double unit) const {
    return series::Four{gravity[0], gravity[1], gravity[2], 0.0} * (unit * unit);
}

template <class Law>
void Cluster<Law>::put_at(double at, double unit) {
    for (int i = 0; i < count(); ++i) {
        const series::State s = series::state(paths_[i], at);
        for (int a = 0; a < 3; ++a) {
            y_[3 * i + a] = s.place[a];
            y_[3 * (count() + i) + a] = s.velocity[a] / unit;
        }
    }
}

}  // namespace hardlimit::particles
