// Groups of bodies in contact: how they form, what they look like to others, how they end.
#pragma once
#include "newton_events.hpp"

namespace hardlimit::particles {

// Whoever overlaps at the start, by more than rounding makes of touching, is in contact from then on if the bodies push
// each other.
template <class Law>
void NewtonEvents<Law>::begin_contacts() {
    std::vector<int> bodies;
    std::vector<Live> live;
    const auto overlap = [&](int i, int j, int side, double depth, double rate) {
        if (!(depth > touching_depth * (j < 0 ? body(i).radius : body(i).radius + body(j).radius))) return;
        Live pair = touching(i, j, side);
        if (depth > laws_(i, j).slack(rate).depth) {
            pair.pair.touch = Touch::closed;
            ++begun_;
            begun_pairs_ += j >= 0;
        }
        live.push_back(pair);
        for (const int k : {i, j})
            if (k >= 0 && std::find(bodies.begin(), bodies.end(), k) == bodies.end()) bodies.push_back(k);
    };
    for (int i = 0; i < static_cast<int>(bodies_.size()); ++i) {
        const Body& b = body(i);
        around(b.cell, [&](int j, const Vector3& shift) {
            if (j <= i) return;
            const Body& o = body(j);
            Vector3 r, v;
            for (std::size_t a = 0; a < 3; ++a) {
                r[a] = (o.position[a] + shift[a]) - b.position[a];
                v[a] = o.velocity[a] - b.velocity[a];
            }
            const double distance = math::sqrt(dot(r, r));
            overlap(i, j, 0, (b.radius + o.radius) - distance, -dot(r, v) / distance);
        });
        for (int axis = 0; axis < box_.dimension; ++axis) {
            const double x = b.position[static_cast<std::size_t>(axis)];
            const double v = b.velocity[static_cast<std::size_t>(axis)];
            if (!box_.walled(axis)) continue;
            overlap(i, -1, 2 * axis, b.radius - x, -v);
            overlap(i, -1, 2 * axis + 1, b.radius - (box_.edge[axis] - x), v);
        }
    }
    part(bodies, live);
    form_remnants();
}

// Bodies i and j touch; j < 0: body i touches the wall 2·axis + (1 at the far edge).
template <class Law>
void NewtonEvents<Law>::meet(int i, int j, int side) {
    std::vector<Live> live{touching(i, j, side)};
    live[0].pair.touch = Touch::closed;
    live[0].pair.fresh = true;
    std::vector<int> set{i};
    if (j >= 0) set.push_back(j);
    for (const int k : set) stop_at_now(k);
    ++begun_;
    begun_pairs_ += j >= 0;
    if (isolate(set, live)) return;
    form(set, live);
}

// A pair that overlaps from now on.
template <class Law>
typename NewtonEvents<Law>::Live NewtonEvents<Law>::touching(int i, int j, int side) const {
    Live live{};
    live.first = i;
    live.second = j;
    live.pair.touch = Touch::slack;
    live.pair.axis = side / 2;
    live.pair.side = side % 2 ? -1.0 : 1.0;
    live.pair.begin = now_;
    live.pair.impact_speed = math::nan;
    return live;
}

template <class Law>
void NewtonEvents<Law>::conflict(int i, int j) {
    std::vector<int> set;
    std::vector<Live> live;
    for (const int k : {i, j}) take(k, set, live);
    form(set, live);
}

template <class Law>
void NewtonEvents<Law>::finish(int index) {
    std::vector<Live> live;
    settle(index, true, live);
    const std::vector<int> bodies = group(index).body;
    part(bodies, live);
    form_remnants();
    for (const int i : bodies)
        if (body(i).group < 0) predict(i);
}

template <class Law>
void NewtonEvents<Law>::form_remnants() {
    while (!remnants_.empty()) {
        const Remnant next = std::move(remnants_.back());
        remnants_.pop_back();
        form(next.body, next.live);
    }
}

// Bodies joined by contacts that go on become a remnant each.
template <class Law>
void NewtonEvents<Law>::part(const std::vector<int>& bodies, const std::vector<Live>& live) {
    std::vector<std::size_t> root(bodies.size());
    for (std::size_t m = 0; m < bodies.size(); ++m) root[m] = m;
    const auto member = [&](int body) {
        return static_cast<std::size_t>(std::find(bodies.begin(), bodies.end(), body) - bodies.begin());
    };
    for (const Live& pair : live) {
        if (pair.second < 0) continue;
        const std::size_t from = root[member(pair.second)], to = root[member(pair.first)];
        std::replace(root.begin(), root.end(), from, to);
    }
    for (std::size_t r = 0; r < bodies.size(); ++r) {
        Remnant remnant;
        for (const Live& pair : live)
            if (root[member(pair.first)] == r) remnant.live.push_back(pair);
        if (remnant.live.empty()) continue;
        for (std::size_t m = 0; m < bodies.size(); ++m)
            if (root[m] == r) remnant.body.push_back(bodies[m]);
        remnants_.push_back(std::move(remnant));
    }
}

// A contact that nothing disturbs, as far as is known now, is solved as a whole. Otherwise nothing changes, but that
// bodies so near that they may touch join the set.
template <class Law>
bool NewtonEvents<Law>::isolate(std::vector<int>& set, std::vector<Live>& live) {
    const int index = spare_group();
    Group& g = group(index);
    open_group(g, set);
    Isolated& l = g.lone;
    for (std::size_t m = 0; m < set.size(); ++m) l.before[m] = g.before.members[m];
    const Touching<Law>& asked = live[0].pair;
    l.pair = set.size() == 2 ? pair_of(g, 0, 1) : wall_of(g, 0, asked.axis, asked.side < 0.0);
    l.pair.touch = Touch::closed;
    l.pair.fresh = true;
    l.pair.begin = now_;
    if (!(set.size() == 2 ? solve_pair(l) : solve_wall(l)) || !far_from_walls(g, l)) {
        drop(index);
        return false;
    }
    g.isolated = true;
    for (std::size_t m = 0; m < set.size(); ++m) {
        const double share =
            set.size() == 1 ? 1.0 : l.before[1 - m].mass / (l.before[0].mass + l.before[1].mass);
        busy(index, m, l.after[m], l.span, share * l.margin);
    }
    std::vector<int> near;
    for (const int i : set) intruders(i, index, near);
    if (!near.empty()) {
        release(index);
        for (const int k : near) take(k, set, live);
        return false;
    }
    for (const int i : set) predict(i);
    queue_.push({now_ + l.span, ~index, ++g.serial});
    return true;
}

// The set becomes a group, with all bodies that are so near that they may touch one of it.
template <class Law>
void NewtonEvents<Law>::form(std::vector<int> set, std::vector<Live> live) {
    for (;;) {
        const int index = spare_group();
        build(index, set, live);
        if (set.size() > most_members || group(index).after.unresolved) outcome_ = Outcome::unresolved;
        std::vector<int> near;
        if (group(index).after.time > 0.0 && outcome_ == Outcome::ok)
            for (const int i : set) intruders(i, index, near);
        if (near.empty()) return go_on_together(index);
        release(index);
        for (const int k : near) take(k, set, live);
    }
}

template <class Law>
void NewtonEvents<Law>::go_on_together(int index) {
    const std::vector<int> set = group(index).body;
    if (group(index).after.time == 0.0) {  // nothing is closed any more
        std::vector<Live> none;
        settle(index, true, none);
    } else {
        Group& g = group(index);
        largest_cluster_ = std::max(largest_cluster_, static_cast<int>(set.size()));
        queue_.push({g.before.base + g.after.time, ~index, ++g.serial});
    }
    for (const int i : set) predict(i);
}

// Integrates the set from now on and makes its members busy.
template <class Law>
void NewtonEvents<Law>::build(int index, const std::vector<int>& set, std::vector<Live>& live) {
    Group& g = group(index);
    open_group(g, set);
    pair_up(g, live);
    double horizon = horizon_of(g.before);
    for (;;) {
        g.after = g.before;
        g.after.record = true;
        Stop never;
        g.after.run(horizon, never);
        if (margins(index) || g.after.time == 0.0 || g.after.unresolved) break;
        horizon = 0.5 * g.after.time;
    }
    g.after.trace.clear();
}

template <class Law>
int NewtonEvents<Law>::spare_group() {
    if (spare_.empty()) {
        groups_.emplace_back();
        return static_cast<int>(groups_.size()) - 1;
    }
    const int index = spare_.back();
    spare_.pop_back();
    return index;
}

// The members as they are now, without pairs.
template <class Law>
void NewtonEvents<Law>::open_group(Group& g, const std::vector<int>& set) const {
    g.alive = true;
    g.isolated = false;
    g.body = set;
    g.origin = body(set[0]).position;
    g.offset.assign(set.size(), {});
    Cluster<Law>& c = g.before;
    c = Cluster<Law>{};
    c.base = now_;
    c.gravity = gravity_;
    for (std::size_t m = 0; m < set.size(); ++m) {
        const Body& b = body(set[m]);
        Vector3 x;
        for (std::size_t a = 0; a < 3; ++a) {
            x[a] = b.position[a] - g.origin[a];
            const double turn = nearest(x[a], static_cast<int>(a));
            x[a] -= turn * box_.edge[a];
            g.offset[m][a] = b.turns[a] + turn;
        }
        c.members.push_back({b.mass, b.radius, x, b.velocity});
    }
}

// The pairs that can touch while the group lasts.
template <class Law>
void NewtonEvents<Law>::pair_up(Group& g, std::vector<Live>& live) const {
    Cluster<Law>& c = g.before;
    const int n = static_cast<int>(g.body.size());
    for (int i = 0; i < n; ++i) {
        for (int j = i + 1; j < n; ++j) {
            const Touching<Law> q = pair_of(g, i, j);
            if (c.gap(q) < 2.0 * travel()) c.pairs.push_back(q);
        }
        for (int axis = 0; axis < box_.dimension; ++axis)
            for (const bool high : {false, true})
                if (box_.walled(axis) && near_wall(g, i, axis, high))
                    c.pairs.push_back(wall_of(g, i, axis, high));
    }
    for (Live& l : live)
        for (Touching<Law>& q : c.pairs) {
            const int first = g.body[static_cast<std::size_t>(q.first)];
            const int second = q.second < 0 ? -1 : g.body[static_cast<std::size_t>(q.second)];
            const bool same =
                (first == l.first && second == l.second) || (first == l.second && second == l.first);
            const bool same_wall = second >= 0 || (l.pair.axis == q.axis && l.pair.side == q.side);
            if (same && same_wall) adopt(q, l.pair, c);
        }
}

template <class Law>
void NewtonEvents<Law>::adopt(Touching<Law>& q, Touching<Law>& old, const Cluster<Law>& c) const {
    q.touch = old.touch;
    q.fresh = old.fresh;
    q.rooted = old.rooted;
    q.s = old.s;
    q.begin = old.begin;
    q.overlapped = old.overlapped;
    if (math::is_nan(old.impact_speed)) old.impact_speed = c.rate(q);
    q.impact_speed = old.impact_speed;
}

template <class Law>
double NewtonEvents<Law>::nearest(double x, int axis) const {
    return box_.wraps(axis) ? math::round_small(x / box_.edge[axis]) : 0.0;
}

template <class Law>
Touching<Law> NewtonEvents<Law>::pair_of(const Group& g, int i, int j) const {
    const Member &a = g.before.members[static_cast<std::size_t>(i)],
                 &b = g.before.members[static_cast<std::size_t>(j)];
    Touching<Law> q{};
    q.first = i;
    q.second = j;
    for (int k = 0; k < 3; ++k) {
        const auto s = static_cast<std::size_t>(k);
        q.image[s] = -nearest(b.position[s] - a.position[s], k) * box_.edge[s];
    }
    q.reach = a.radius + b.radius;
    q.mass = effective(a.mass, b.mass);
    q.law = laws_(g.body[static_cast<std::size_t>(i)], g.body[static_cast<std::size_t>(j)]);
    return q;
}

template <class Law>
bool NewtonEvents<Law>::near_wall(const Group& g, int i, int axis, bool high) const {
    const Body& b = body(g.body[static_cast<std::size_t>(i)]);
    const double x = b.position[static_cast<std::size_t>(axis)];
    return (high ? box_.edge[axis] - x : x) < b.radius + travel();
}

template <class Law>
Touching<Law> NewtonEvents<Law>::wall_of(const Group& g, int i, int axis, bool high) const {
    const Member& a = g.before.members[static_cast<std::size_t>(i)];
    Touching<Law> q{};
    q.first = i;
    q.second = -1;
    q.axis = axis;
    q.side = high ? -1.0 : 1.0;
    q.wall = (high ? box_.edge[axis] : 0.0) - g.origin[static_cast<std::size_t>(axis)];
    q.reach = a.radius;
    q.mass = a.mass;
    q.law = laws_(g.body[static_cast<std::size_t>(i)], -1);
    return q;
}

// Until contacts like those that last are over, if the members do not get far before.
template <class Law>
double NewtonEvents<Law>::horizon_of(const Cluster<Law>& c) const {
    const double speed = c.speed();
    double longest = 0.0;
    for (const Touching<Law>& q : c.pairs)
        if (q.touch == Touch::closed)
            longest =
                math::max(longest, 1.5 * q.law.duration(math::max(q.impact_speed, 1e-3 * speed), q.mass));
    const double farthest = travel() / speed;
    return longest > 0.0 ? math::min(longest, farthest) : farthest;
}

// Makes the members busy. Returns whether the cells are wide enough for their margins.
template <class Law>
bool NewtonEvents<Law>::margins(int index) {
    const Group& g = group(index);
    bool fits = true;
    for (std::size_t m = 0; m < g.body.size(); ++m) {
        busy(index, m, g.after.members[m], g.after.time, 0.0);
        Body& b = body(g.body[m]);
        if (g.after.time > 0.0) b.margin = margin_of(g, m);
        fits = fits && b.margin <= widest_margin();
    }
    return fits;
}

// The most by which a member leaves its parabola. Between two ends of steps its distance from there is close to a
// cubic, which rises above its ends by no more than a quarter of the step times the larger slope.
template <class Law>
double NewtonEvents<Law>::margin_of(const Group& g, std::size_t m) const {
    const std::size_t n = g.body.size();
    const Vector3 &x0 = g.before.members[m].position, &chord = body(g.body[m]).velocity;
    double margin = 0.0, last = 0.0, last_rate = 0.0, last_time = 0.0;
    for (const Knot& k : g.after.trace) {
        double off = 0.0, rate = 0.0;
        for (std::size_t a = 0; a < 3; ++a) {
            const double t = k.time, gt = box_.gravity[a] * t;
            const double e = k.state[3 * m + a] - (x0[a] + t * (chord[a] + 0.5 * gt));
            const double d = k.state[3 * (n + m) + a] - (chord[a] + gt);
            off += e * e;
            rate += d * d;
        }
        off = math::sqrt(off);
        rate = math::sqrt(rate);
        const double bulge = 0.3 * (k.time - last_time) * math::max(rate, last_rate);
        margin = math::max(margin, math::max(off, last) + bulge);
        last = off;
        last_rate = rate;
        last_time = k.time;
    }
    return 1.01 * margin;
}

// Until its group ends, a member is a larger body on the parabola between its two ends.
template <class Law>
void NewtonEvents<Law>::busy(int index, std::size_t m, const Member& after, double span, double margin) {
    const Group& g = group(index);
    Body& b = body(g.body[m]);
    b.group = index;
    b.end = now_ + span;
    b.margin = margin;
    if (!(span > 0.0)) return;
    const Member& before = g.before.members[m];
    for (std::size_t a = 0; a < 3; ++a)
        b.velocity[a] = (after.position[a] - before.position[a]) / span - 0.5 * span * box_.gravity[a];
}

template <class Law>
void NewtonEvents<Law>::intruders(int i, int index, std::vector<int>& near) const {
    const Body& b = body(i);
    const Vector3 x = position(b, now_);
    around(b.cell, [&](int j, const Vector3& shift) {
        const Body& o = body(j);
        if (j == i || o.group == index) return;
        const Vector3 xo = position(o, now_);
        Vector3 r;
        for (std::size_t a = 0; a < 3; ++a) r[a] = (xo[a] + shift[a]) - x[a];
        const double reach = (b.radius + b.margin) + (o.radius + o.margin);
        if (dot(r, r) < reach * reach && std::find(near.begin(), near.end(), j) == near.end())
            near.push_back(j);
    });
}

// The body's parabola starts here.
template <class Law>
void NewtonEvents<Law>::stop_at_now(int i) {
    Body& b = body(i);
    if (b.group >= 0) return;
    b.position = position(b, now_);
    b.velocity = velocity(b, now_);
    b.from = now_;
    ++b.version;
}

// A body becomes part of the set, with all of its group and whatever it is still in contact with.
template <class Law>
void NewtonEvents<Law>::take(int i, std::vector<int>& set, std::vector<Live>& live) {
    if (std::find(set.begin(), set.end(), i) != set.end()) return;
    if (body(i).group >= 0) {
        const int index = body(i).group;
        settle(index, false, live);
        set.insert(set.end(), group(index).body.begin(), group(index).body.end());
        return;
    }
    for (Remnant& r : remnants_) {
        if (std::find(r.body.begin(), r.body.end(), i) == r.body.end()) continue;
        set.insert(set.end(), r.body.begin(), r.body.end());
        live.insert(live.end(), r.live.begin(), r.live.end());
        std::swap(r, remnants_.back());
        remnants_.pop_back();
        return;
    }
    stop_at_now(i);
    set.push_back(i);
}

// Ends a group now: its members are on their own again, at their true places.
template <class Law>
void NewtonEvents<Law>::settle(int index, bool at_end, std::vector<Live>& live) {
    Group& g = group(index);
    if (g.isolated && at_end) return settle_isolated(index);
    if (!at_end) {
        g.after = start_of(g);
        Stop never;
        g.after.run(now_ - g.after.base, never);
    }
    const Cluster<Law>& c = g.after;
    dissipated_ += c.dissipated;
    virial_ += c.virial;
    begun_ += static_cast<std::uint64_t>(c.begun);
    begun_pairs_ += static_cast<std::uint64_t>(c.begun_pairs);
    if (!g.isolated) clustered_ += (now_ - c.base) * static_cast<double>(g.body.size());
    for (const EndedContact& e : c.ended) log(g, c.pairs[static_cast<std::size_t>(e.pair)], e);
    for (std::size_t m = 0; m < g.body.size(); ++m) put(g, m, c.members[m]);
    for (const Touching<Law>& q : c.pairs) {
        if (q.touch == Touch::open) continue;
        const int second = q.second < 0 ? -1 : g.body[static_cast<std::size_t>(q.second)];
        live.push_back({g.body[static_cast<std::size_t>(q.first)], second, q});
    }
    drop(index);
}

template <class Law>
void NewtonEvents<Law>::drop(int index) {
    group(index).alive = false;
    spare_.push_back(index);
}

template <class Law>
void NewtonEvents<Law>::log(const Group& g, const Touching<Law>& q, const EndedContact& e) {
    ++ended_;
    overlapped_ += e.overlapped;
    if (keep_log_)
        log_.push_back(row_of(g, q, e.begin, e.end, e.impact_speed, e.separation_speed, e.overlapped));
}

template <class Law>
void NewtonEvents<Law>::settle_isolated(int index) {
    const Group& g = group(index);
    log(g, g.lone.pair, g.lone.contact);
    dissipated_ += g.lone.dissipated;
    virial_ += g.lone.virial;
    for (std::size_t m = 0; m < g.body.size(); ++m) put(g, m, g.lone.after[m]);
    drop(index);
}

// Undoes build: the members are free bodies at their places now.
template <class Law>
void NewtonEvents<Law>::release(int index) {
    Group& g = group(index);
    for (std::size_t m = 0; m < g.body.size(); ++m) {
        Body& b = body(g.body[m]);
        b.group = -1;
        b.margin = 0.0;
        b.end = math::infinity;
        b.velocity = g.before.members[m].velocity;
    }
    drop(index);
}

// A member is on its own again, at its true place.
template <class Law>
void NewtonEvents<Law>::put(const Group& g, std::size_t m, const Member& at) {
    Body& b = body(g.body[m]);
    b.position = place(g, m, at.position);
    b.velocity = at.velocity;
    b.from = now_;
    b.margin = 0.0;
    b.end = math::infinity;
    b.group = -1;
    ++b.version;
}

// A member's place in the frame of its body's cell.
template <class Law>
Vector3 NewtonEvents<Law>::place(const Group& g, std::size_t m, Vector3 x) const {
    const Body& b = body(g.body[m]);
    for (std::size_t a = 0; a < 3; ++a) x[a] += g.origin[a] + (g.offset[m][a] - b.turns[a]) * box_.edge[a];
    return x;
}

// The group at its begin, ready to be integrated.
template <class Law>
Cluster<Law> NewtonEvents<Law>::start_of(const Group& g) const {
    if (!g.isolated) return g.before;
    Cluster<Law> c;
    c.base = g.lone.contact.begin;
    c.gravity = gravity_;
    for (std::size_t m = 0; m < g.body.size(); ++m) c.members.push_back(g.lone.before[m]);
    c.pairs.push_back(g.lone.pair);
    return c;
}

template <class Law>
typename NewtonEvents<Law>::Row NewtonEvents<Law>::row_of(const Group& g, const Touching<Law>& q,
                                                          double begin, double end, double impact,
                                                          double separation, bool overlapped) const {
    int first = g.body[static_cast<std::size_t>(q.first)];
    int second =
        q.second >= 0 ? g.body[static_cast<std::size_t>(q.second)] : (q.side > 0.0 ? -1 : -2) - 2 * q.axis;
    if (second >= 0 && second < first) std::swap(first, second);
    return {begin, end, first, second, impact, separation, overlapped};
}

}  // namespace hardlimit::particles
