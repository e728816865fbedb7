// Groups of bodies in contact: how they form, what they look like to others, how they end.
#pragma once
#include "engine.hpp"

namespace hardlimit::boxes {

// Whoever overlaps at the start, by more than rounding makes of touching, is in contact from then on if the bodies push
// each other.
template <class Law>
void NewtonEvents<Law>::begin_contacts() {
    std::vector<int> bodies;
    std::vector<char> known(paths_.size(), 0);
    std::vector<Live> live;
    const auto overlap = [&](int i, int j, int side, double depth, double rate) {
        if (!(depth > touching_depth * (j < 0 ? radius(i) : radius(i) + radius(j)))) return;
        Live pair = touching(i, j, side);
        if (depth > law(i, j).slack(rate).depth) {
            pair.pair.touch = Touch::closed;
            ++begun_;
            begun_pairs_ += j >= 0;
        } else {
            dissipated_ += law(i, j).energy(onset_root<Law::onset_power>(depth));
        }
        live.push_back(pair);
        for (const int k : {i, j})
            if (k >= 0 && !std::exchange(known[static_cast<std::size_t>(k)], 1)) bodies.push_back(k);
    };
    for (int i = 0; i < static_cast<int>(paths_.size()); ++i) {
        const Particle<3>& p = paths_[i];
        for_near(i, [&](int j, const Vector3& r) {
            if (j <= i) return;
            Vector3 v;
            for (std::size_t a = 0; a < 3; ++a) v[a] = paths_[j].velocity[a] - p.velocity[a];
            const double distance = math::sqrt(dot(r, r));
            overlap(i, j, 0, (radius(i) + radius(j)) - distance, -dot(r, v) / distance);
        });
        for (int axis = 0; axis < box_.dimension; ++axis) {
            const double x = p.position[axis], v = p.velocity[axis];
            if (!box_.walled(axis)) continue;
            overlap(i, -1, 2 * axis, radius(i) - x, -v);
            overlap(i, -1, 2 * axis + 1, radius(i) - (box_.edge[axis] - x), v);
        }
    }
    part(bodies, live);
    form_remnants();
}

// Bodies i and j touch; j < 0: body i touches the wall 2·axis + (1 at the far edge).
template <class Law>
void NewtonEvents<Law>::meet(int i, int j, int side) {
    stop_at_now(i);
    if (j >= 0) stop_at_now(j);
    ++begun_;
    begun_pairs_ += j >= 0;
    int intruder = -1;
    if (isolate(i, j, side, intruder)) return;
    Joined set{{i}, {touching(i, j, side)}};
    set.live[0].pair.touch = Touch::closed;
    set.live[0].pair.fresh = true;
    if (j >= 0) set.body.push_back(j);
    if (intruder >= 0) gather(intruder, set);
    form(set);
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
    Joined set;
    for (const int k : {i, j}) gather(k, set);
    form(set);
}

template <class Law>
void NewtonEvents<Law>::finish(int first) {
    const int index = pending_[first].group;
    if (ends_too_deep(index)) return;
    const Group& g = group(index);
    Joined set{{g.body.begin(), g.body.end()}, {}, g.until};
    const std::vector<int>& bodies = set.body;
    settle(index, true, set.live);
    if (bodies.size() >= large_group && now_ < set.until && !set.live.empty()) return form(set);
    part(bodies, set.live);
    form_remnants();
    for (const int i : bodies)
        if (free(i)) predict(i);
}

// The members are of their own size again. Their paths go on, and what they meet is known; but not which wall, nor,
// in a small box, which image of each other.
template <class Law>
void NewtonEvents<Law>::finish_isolated(int index) {
    const Isolated& l = group(index).lone;
    ++ended_;
    largest_compression_ = math::max(largest_compression_, l.compression);
    if (keep_log_) log_.push_back(row_of(group(index), l.pair, l.contact));
    dissipated_ += l.dissipated;
    virial_ += l.virial;
    const int first = l.body[0], second = l.body[1];
    const auto for_both = [&](const auto& f) {
        f(first);
        if (second >= 0) f(second);
    };
    for_both([&](int i) { set_free(i); });
    drop(index);
    if (images_) return for_both([&](int i) { predict(i); });
    if (!walled_) return;
    for_both([&](int i) {
        look(i);
        predict_own(i, cells_.place(level_, pending_[i].cell));
        schedule(i);
    });
}

template <class Law>
void NewtonEvents<Law>::form_remnants() {
    while (!remnants_.empty()) {
        Joined next = std::move(remnants_.back());
        remnants_.pop_back();
        form(next);
    }
}

// Bodies joined by contacts that go on become a remnant each.
template <class Law>
void NewtonEvents<Law>::part(const std::vector<int>& bodies, const std::vector<Live>& live) {
    const MemberOf member(bodies);
    std::vector<std::size_t> above(bodies.size());
    for (std::size_t m = 0; m < bodies.size(); ++m) above[m] = m;
    const auto root = [&](int body) {
        std::size_t m = member(body);
        while (above[m] != m) m = above[m] = above[above[m]];
        return m;
    };
    for (const Live& pair : live)
        if (pair.second >= 0) above[root(pair.second)] = root(pair.first);
    constexpr std::size_t none = ~std::size_t{0};
    std::vector<std::size_t> remnant(bodies.size(), none);
    for (const Live& pair : live) remnant[root(pair.first)] = 0;
    for (std::size_t& at : remnant) {
        if (at == none) continue;
        at = remnants_.size();
        remnants_.emplace_back();
    }
    for (const Live& pair : live) remnants_[remnant[root(pair.first)]].live.push_back(pair);
    for (const int body : bodies)
        if (const std::size_t at = remnant[root(body)]; at != none) remnants_[at].body.push_back(body);
}

// A contact that nothing disturbs, as far as is known now, is solved as a whole. Otherwise nothing changes, and
// `intruder` is a body that has come too near, if that is why.
template <class Law>
bool NewtonEvents<Law>::isolate(int i, int j, int side, int& intruder) {
    const int index = spare_group();
    Group& g = group(index);
    g.alive = g.isolated = true;
    const std::size_t members = j >= 0 ? 2 : 1;
    g.body.resize(members);
    g.body[0] = i;
    if (j >= 0) g.body[1] = j;
    std::copy_n(paths_[i].position, 3, g.origin.begin());
    g.offset.resize(members);
    Isolated& l = g.lone;
    Parted after;
    l.body[0] = i, l.body[1] = j;
    for (std::size_t m = 0; m < members; ++m) put_member(g, m, l.before[m]);
    if (j >= 0)
        put_pair(g, 0, 1, l.before[0], l.before[1], l.pair);
    else
        l.pair = wall_of(g, 0, side / 2, side % 2 != 0);
    l.pair.touch = Touch::closed;
    l.pair.fresh = true;
    l.pair.begin = now_;
    const bool solved = j >= 0 ? solve_pair(l, after) : solve_wall(l, after);
    if (solved) note_shares(l);
    if (!solved || !far_from_walls(g, after)) {
        drop(index);
        return false;
    }
    for (std::size_t m = 0; m < members; ++m) fly_on_from(index, m, after[m]);
    for (const int k : g.body) {
        find_but(k, members == 1 ? k : g.body[k == i ? 1 : 0]);
        if (pending_[k].pair_time > now_) continue;
        intruder = static_cast<int>(pending_[k].partner);
        release(index);
        return false;
    }
    for (const int k : g.body) schedule(k);
    endings_.push(pending_[i].end, i, index, by_name());
    return true;
}

// The set becomes a group, with all bodies that are so near that they may touch one of it.
template <class Law>
void NewtonEvents<Law>::form(Joined& set) {
    for (;;) {
        const int index = spare_group();
        build(index, set);
        const Cluster<Law>& after = group(index).cluster->after;
        if (after.unresolved || takes_too_long(after)) end_here(Outcome::unresolved, set.body);
        if (after.time == 0.0 && ends_too_deep(index)) return;
        std::vector<int> near;
        if (after.time > 0.0 && outcome_ == Outcome::ok)
            for (const int i : set.body) {
                find(i);
                if (!(pending_[i].pair_time > now_)) intruders(i, index, near);
            }
        if (near.empty()) return go_on_together(index);
        release(index);
        const std::size_t before = set.body.size();
        for (const int k : near) gather(k, set);
        if (set.body.size() > most_lasting) gather_touching(before, set);
    }
}

// Whoever touches the last of the set would be found at the next attempt, one after the other along a chain.
template <class Law>
void NewtonEvents<Law>::gather_touching(std::size_t last, Joined& set) {
    std::vector<int> near;
    for (; last < set.body.size(); ++last) {
        const int i = set.body[last];
        near.clear();
        for_near(i, [&](int j, const Vector3& r) {
            const double reach = (paths_[i].radius + paths_[j].radius) * (1.0 + rounding_of_touch);
            if (dot(r, r) < reach * reach) near.push_back(j);
        });
        std::sort(near.begin(), near.end());  // a saved run has lost the order within a cell
        for (const int k : near) gather(k, set);
    }
}

template <class Law>
void NewtonEvents<Law>::go_on_together(int index) {
    const auto& set = group(index).body;
    if (group(index).cluster->after.time == 0.0) {  // nothing is closed any more
        std::vector<Live> none;
        settle(index, true, none);
        for (const int i : set) predict(i);
        return;
    }
    largest_cluster_ = std::max(largest_cluster_, static_cast<int>(set.size()));
    for (const int i : set) schedule(i);
}

// Integrates the set from now on and makes its members busy.
template <class Law>
void NewtonEvents<Law>::build(int index, Joined& set) {
    Group& g = group(index);
    open_group(g, set.body);
    pair_up(g, set.live);
    const Cluster<Law>& before = g.cluster->before;
    Cluster<Law>& after = g.cluster->after;
    double horizon = horizon_of(g);
    const double left = set.until - now_;
    if (left > 1e-6 * horizon) horizon = math::min(horizon, left);
    g.until = now_ + horizon;
    for (;;) {
        after = before;
        after.record = true;
        Stop never;
        after.run(horizon, never,
                  set.body.size() < large_group ? steps_of_small_group : steps_of_large_group);
        if (margins(index) || after.time == 0.0 || after.unresolved) break;
        horizon = 0.5 * after.time;
    }
    after.trace.clear();
}

// Whether contacts last: groups are integrated on and on while none begins.
template <class Law>
bool NewtonEvents<Law>::takes_too_long(const Cluster<Law>& c) {
    const std::size_t members = c.members.size();
    const bool small = members < large_group;
    if (small && c.steps() < steps_of_small_group) return false;
    const auto bodies = static_cast<double>(paths_.size());
    const double most = most_work * (small ? math::max(bodies, fewest_bodies) : bodies);
    work_ = math::max(work_ - most_work * static_cast<double>(begun_ - begun_before_), 0.0);
    begun_before_ = begun_;
    work_ += static_cast<double>(members) * static_cast<double>(c.steps());
    return work_ > most;
}

// The run is over, at these bodies.
template <class Law>
void NewtonEvents<Law>::end_here(Outcome outcome, const std::vector<int>& bodies, i64 wall) {
    if (outcome_ != Outcome::ok) return;
    outcome_ = outcome;
    ended_at_wall_ = wall;
    for (const int i : bodies) ended_by_.push_back(pending_[i].name);
    std::sort(ended_by_.begin(), ended_by_.end());
}

// Whether a contact of the group has now reached the largest compression of its law. The group stays as it is.
template <class Law>
bool NewtonEvents<Law>::ends_too_deep(int index) {
    const Group& g = group(index);
    const Cluster<Law>& c = g.cluster->after;
    if (c.too_deep < 0) return false;
    const Touching<Law>& q = c.pairs[static_cast<std::size_t>(c.too_deep)];
    std::vector<int> bodies{g.body[static_cast<std::size_t>(q.first)]};
    if (q.second >= 0) bodies.push_back(g.body[static_cast<std::size_t>(q.second)]);
    end_here(Outcome::too_deep, bodies, q.second < 0 ? wall_number(q) : 0);
    return true;
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
    g.body.assign(set);
    std::copy_n(paths_[set[0]].position, 3, g.origin.begin());
    g.offset.resize(set.size());
    if (!g.cluster) g.cluster = std::make_unique<Ends>();
    Cluster<Law>& c = g.cluster->before;
    c.clear();
    c.base = now_;
    c.gravity = gravity_;
    c.largest_place = *std::ranges::max_element(box_.edge);
    c.largest_compression = largest_compression_;
    c.kernels = series_;
    for (std::size_t m = 0; m < set.size(); ++m) put_member(g, m, c.members.emplace_back());
}

// A member as it is now, by the image that is near the group's origin; notes which one that is. Written where it stays:
// what is copied in larger pieces than it was written in has to wait until it is in the cache.
template <class Law>
void NewtonEvents<Law>::put_member(Group& g, std::size_t m, Member& member) const {
    const int i = g.body[m];
    const Particle<3>& p = paths_[i];
    member.mass = mass(i);
    member.radius = radius(i);
    for (std::size_t a = 0; a < 3; ++a) {
        const double x = p.position[a] - g.origin[a];
        const double turn = nearest(x, static_cast<int>(a));
        member.position[a] = x - turn * box_.edge[a];
        member.velocity[a] = p.velocity[a];
        g.offset[m][a] = pending_[i].turns[a] + turn;
    }
}

// The pairs that can touch while the group lasts.
template <class Law>
void NewtonEvents<Law>::pair_up(Group& g, std::vector<Live>& live) const {
    Cluster<Law>& c = g.cluster->before;
    const std::size_t n = g.body.size();
    std::vector<std::size_t> first(n + 1);  // pair of a member
    for (std::size_t i = 0; i < n; ++i) {
        first[i] = c.pairs.size();
        for (std::size_t j = i + 1; j < n; ++j) {
            if (!may_touch(c.members[i], c.members[j])) continue;
            Touching<Law> q;
            put_pair(g, static_cast<int>(i), static_cast<int>(j), c.members[i], c.members[j], q);
            if (c.gap(q) < 2.0 * travel_) c.pairs.push_back(q);
        }
        for (int axis = 0; axis < box_.dimension; ++axis)
            for (const bool high : {false, true})
                if (box_.walled(axis) && near_wall(g.body[i], axis, high))
                    c.pairs.push_back(wall_of(g, static_cast<int>(i), axis, high));
    }
    first[n] = c.pairs.size();
    const MemberOf member(g.body);
    for (Live& l : live) {
        const auto a = static_cast<int>(member(l.first)),
                   b = l.second < 0 ? -1 : static_cast<int>(member(l.second));
        const auto of = static_cast<std::size_t>(b < 0 ? a : std::min(a, b));
        for (std::size_t k = first[of]; k < first[of + 1]; ++k) {
            Touching<Law>& q = c.pairs[k];
            const bool same = (q.first == a && q.second == b) || (q.first == b && q.second == a);
            const bool same_wall = b >= 0 || (l.pair.axis == q.axis && l.pair.side == q.side);
            if (same && same_wall) adopt(q, l.pair, c);
        }
    }
}

// Whether two members are so near that their gap may count: for most of a large group this is all that is asked.
template <class Law>
bool NewtonEvents<Law>::may_touch(const Member& a, const Member& b) const {
    double square = 0.0;
    for (int k = 0; k < 3; ++k) {
        const auto s = static_cast<std::size_t>(k);
        const double x = b.position[s] - a.position[s], r = x - nearest(x, k) * box_.edge[s];
        square += r * r;
    }
    const double near = 1.001 * (a.radius + b.radius + 2.0 * travel_);
    return square < near * near;
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
    return math::round_small(x * query_.per_edge[axis]);
}

template <class Law>
void NewtonEvents<Law>::put_pair(const Group& g, int i, int j, const Member& a, const Member& b,
                                 Touching<Law>& q) const {
    q = {};
    q.first = i;
    q.second = j;
    for (int k = 0; k < 3; ++k) {
        const auto s = static_cast<std::size_t>(k);
        q.image[s] = -nearest(b.position[s] - a.position[s], k) * box_.edge[s];
    }
    q.reach = a.radius + b.radius;
    q.mass = effective(a.mass, b.mass);
    laws_.put(g.body[static_cast<std::size_t>(i)], g.body[static_cast<std::size_t>(j)], q.law);
}

template <class Law>
bool NewtonEvents<Law>::near_wall(int i, int axis, bool high) const {
    return to_wall(i, axis, high) < radius(i) + travel_;
}

// Of a body's centre, at the begin of its path [m].
template <class Law>
double NewtonEvents<Law>::to_wall(int i, int axis, bool high) const {
    const double x = paths_[i].position[axis];
    return high ? box_.edge[axis] - x : x;
}

template <class Law>
Touching<Law> NewtonEvents<Law>::wall_of(const Group& g, int i, int axis, bool high) const {
    const int body = g.body[static_cast<std::size_t>(i)];
    Touching<Law> q{};
    q.first = i;
    q.second = -1;
    q.axis = axis;
    q.side = high ? -1.0 : 1.0;
    q.wall = (high ? box_.edge[axis] : 0.0) - g.origin[static_cast<std::size_t>(axis)];
    q.reach = radius(body);
    q.mass = mass(body);
    q.law = law(body, -1);
    return q;
}

// For how long a member can't get farther, by its speed and, where that counts, its weight.
template <class Law>
double NewtonEvents<Law>::time_to_cover(double distance, double speed, bool falls) const {
    const double pull = falls ? math::sqrt(dot(gravity_, gravity_)) : 0.0;
    return 2.0 * distance / (speed + math::sqrt(speed * speed + 2.0 * distance * pull));
}

// For how long no member can get to a wall that is none of the group's: they may all fly there together.
template <class Law>
double NewtonEvents<Law>::time_to_a_wall(const Group& g, double speed) const {
    double gap = math::infinity;
    for (const int i : g.body)
        for (int axis = 0; axis < box_.dimension; ++axis)
            for (const bool high : {false, true})
                if (box_.walled(axis) && !near_wall(i, axis, high))
                    gap = math::min(gap, to_wall(i, axis, high) - radius(i));
    if (gap == math::infinity) return gap;
    const Vector3 drift = g.cluster->before.drift();
    return time_to_cover(gap, speed + math::sqrt(dot(drift, drift)), true);
}

// Until contacts like those that last are over, if the members do not get far before. What overlaps without force is
// soon apart; a slow body that it is not apart from would get far in thousands of contacts only.
template <class Law>
double NewtonEvents<Law>::horizon_of(const Group& g) const {
    const Cluster<Law>& c = g.cluster->before;
    constexpr double contacts = 1.5, contacts_without_force = 100.0;
    const double speed = c.speed();
    double closed = 0.0, slack = 0.0;
    for (const Touching<Law>& q : c.pairs) {
        if (q.touch == Touch::open) continue;
        double& longest = q.touch == Touch::closed ? closed : slack;
        longest = math::max(longest, q.law.duration(math::max(q.impact_speed, 1e-3 * speed), q.mass));
    }
    const double farthest =
        math::min(time_to_cover(travel_, speed, c.near_a_wall()), time_to_a_wall(g, speed));
    const double longest = closed > 0.0 ? contacts * closed : contacts_without_force * slack;
    return longest > 0.0 ? math::min(longest, farthest) : farthest;
}

// Makes the members busy. Returns whether the cells are wide enough for their margins.
template <class Law>
bool NewtonEvents<Law>::margins(int index) {
    const Group& g = group(index);
    const Cluster<Law>&before = g.cluster->before, &after = g.cluster->after;
    bool fits = true;
    for (std::size_t m = 0; m < g.body.size(); ++m) {
        busy(index, m, before.members[m], after.members[m], after.time, 0.0);
        if (!(after.time > 0.0)) continue;
        const double margin = margin_of(g, m);
        make_room_for(g.body[m], margin);
        fits = fits && margin <= widest_margin_;
    }
    return fits;
}

// The most by which a member leaves its parabola. Where it is not known by how much more than at the ends of a step,
// its distance from there is close to a cubic, which rises above its ends by no more than a quarter of the step times
// the larger slope.
template <class Law>
double NewtonEvents<Law>::margin_of(const Group& g, std::size_t m) const {
    const std::size_t n = g.body.size();
    const Vector3& x0 = g.cluster->before.members[m].position;
    const double (&chord)[3] = paths_[g.body[m]].velocity;
    const Trace& trace = g.cluster->after.trace;
    double margin = 0.0, last = 0.0, last_rate = 0.0, last_time = 0.0;
    for (std::size_t k = 0; k < trace.time.size(); ++k) {
        const double t = trace.time[k];
        const double *x = &trace.state[6 * n * k + 3 * m], *v = x + 3 * n;
        double off = 0.0, rate = 0.0;
        for (std::size_t a = 0; a < 3; ++a) {
            const double gt = box_.gravity[a] * t;
            const double e = x[a] - (x0[a] + t * (chord[a] + 0.5 * gt));
            const double d = v[a] - (chord[a] + gt);
            off += e * e;
            rate += d * d;
        }
        off = math::sqrt(off);
        rate = math::sqrt(rate);
        const bool known = !trace.bulge.empty();
        const double bulge =
            known ? trace.bulge[n * k + m] : 0.3 * (t - last_time) * math::max(rate, last_rate);
        margin = math::max(margin, math::max(off, last) + bulge);
        last = off;
        last_rate = rate;
        last_time = t;
    }
    return 1.01 * margin;
}

// Until its group ends, a member is a larger body on the parabola between its two ends.
template <class Law>
void NewtonEvents<Law>::busy(int index, std::size_t m, const Member& before, const Member& after, double span,
                             double margin) {
    const int i = group(index).body[m];
    join(i, index, m, span);
    make_room_for(i, margin);
    if (!(span > 0.0)) return;
    for (std::size_t a = 0; a < 3; ++a)
        paths_[i].velocity[a] =
            (after.position[a] - before.position[a]) / span - 0.5 * span * box_.gravity[a];
}

template <class Law>
void NewtonEvents<Law>::join(int i, int index, std::size_t m, double span) {
    Held& e = pending_[i];
    e.group = index;
    e.end = now_ + span;
    e.first = m == 0;
    e.clustered = !group(index).isolated;
}

// Of what happens to the relative path, what happens to a member's own.
template <class Law>
void NewtonEvents<Law>::note_shares(Isolated& l) const {
    const Member(&b)[2] = l.before;
    for (std::size_t m = 0; m < 2; ++m) {
        l.share[m] = l.body[1] < 0 ? 1.0 : b[1 - m].mass / (b[0].mass + b[1].mass);
        l.room[m] = l.share[m] * l.margin * l.turn;
    }
}

// Until its contact ends, a member is a larger body on the path on which it flies on.
template <class Law>
void NewtonEvents<Law>::fly_on_from(int index, std::size_t m, const Member& after) {
    const Isolated& l = group(index).lone;
    const int i = l.body[m];
    join(i, index, m, l.span);
    make_room_for(i, l.share[m] * l.margin);
    for (std::size_t a = 0; a < 3; ++a) {
        const double v = after.velocity[a] - l.span * box_.gravity[a];
        const double x = after.position[a] - l.span * (v + 0.5 * l.span * box_.gravity[a]);
        paths_[i].velocity[a] = v;
        paths_[i].position[a] += x - l.before[m].position[a];
    }
}

// More than overlap must be to count as such.
template <class Law>
void NewtonEvents<Law>::make_room_for(int i, double margin) {
    paths_[i].radius = (radius(i) + margin) * (1.0 + rounding_of_touch);
}

template <class Law>
void NewtonEvents<Law>::intruders(int i, int index, std::vector<int>& near) const {
    for_near(i, [&](int j, const Vector3& r) {
        const double reach = paths_[i].radius + paths_[j].radius;
        if (pending_[j].group != index && dot(r, r) < reach * reach &&
            std::find(near.begin(), near.end(), j) == near.end())
            near.push_back(j);
    });
    std::sort(near.begin(), near.end());  // a saved run has lost the order within a cell
}

// The body's parabola starts here.
template <class Law>
void NewtonEvents<Law>::stop_at_now(int i) {
    if (!free(i)) return;
    Particle<3>& p = paths_[i];
    const double s = now_ - p.time;
    for (int a = 0; a < 3; ++a) {
        p.position[a] += s * (p.velocity[a] + 0.5 * s * box_.gravity[a]);
        p.velocity[a] += s * box_.gravity[a];
    }
    p.time = now_;
    ++pending_[i].count;
}

// A body becomes part of the set, with all of its group and whatever it is still in contact with.
template <class Law>
void NewtonEvents<Law>::gather(int i, Joined& set) {
    if (std::find(set.body.begin(), set.body.end(), i) != set.body.end()) return;
    if (!free(i)) {
        const int index = pending_[i].group;
        const auto& bodies = group(index).body;
        if (bodies.size() > most_lasting) set.until = math::min(set.until, group(index).until);
        settle(index, false, set.live);
        set.body.insert(set.body.end(), bodies.begin(), bodies.end());
        return;
    }
    for (Joined& r : remnants_) {
        if (std::find(r.body.begin(), r.body.end(), i) == r.body.end()) continue;
        set.body.insert(set.body.end(), r.body.begin(), r.body.end());
        set.live.insert(set.live.end(), r.live.begin(), r.live.end());
        std::swap(r, remnants_.back());
        remnants_.pop_back();
        return;
    }
    stop_at_now(i);
    set.body.push_back(i);
}

// Ends a group now: its members are on their own again, at their true places.
template <class Law>
void NewtonEvents<Law>::settle(int index, bool at_end, std::vector<Live>& live) {
    Group& g = group(index);
    if (!g.cluster) g.cluster = std::make_unique<Ends>();
    if (!at_end) {
        start(g, g.cluster->after);
        g.cluster->after.run_through(now_ - g.cluster->after.base);
        if (g.cluster->after.unresolved) end_here(Outcome::unresolved, {g.body.begin(), g.body.end()});
    }
    const Cluster<Law>& c = g.cluster->after;
    dissipated_ += c.dissipated;
    virial_ += c.virial;
    largest_compression_ = math::max(largest_compression_, c.largest_compression);
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

// The next group to be is this one again, soon.
template <class Law>
void NewtonEvents<Law>::drop(int index) {
    Group& g = group(index);
    g.alive = false;
    spare_.push_back(index);
    if (!fetches_) return;
    for (std::size_t k = 0; k < sizeof g; k += 64) prefetch(reinterpret_cast<const char*>(&g) + k);
}

template <class Law>
void NewtonEvents<Law>::log(const Group& g, const Touching<Law>& q, const EndedContact& e) {
    ++ended_;
    overlapped_ += e.overlapped;
    if (keep_log_) log_.push_back(row_of(g, q, e));
}

// Undoes build: the members are free bodies at their places now.
template <class Law>
void NewtonEvents<Law>::release(int index) {
    Group& g = group(index);
    for (std::size_t m = 0; m < g.body.size(); ++m) {
        const int i = g.body[m];
        const Member& before = g.isolated ? g.lone.before[m] : g.cluster->before.members[m];
        const Vector3 x = place(g, m, before.position);
        set_free(i);
        std::copy_n(x.data(), 3, paths_[i].position);
        std::copy_n(before.velocity.data(), 3, paths_[i].velocity);
    }
    drop(index);
}

template <class Law>
void NewtonEvents<Law>::set_free(int i) {
    Held& e = pending_[i];
    e.group = -1;
    e.end = math::infinity;
    e.first = e.clustered = false;
    paths_[i].radius = radius(i);
}

// A member is on its own again, at its true place.
template <class Law>
void NewtonEvents<Law>::put(const Group& g, std::size_t m, const Member& at) {
    const int i = g.body[m];
    Particle<3>& p = paths_[i];
    const Vector3 x = place(g, m, at.position);
    std::copy_n(x.data(), 3, p.position);
    std::copy_n(at.velocity.data(), 3, p.velocity);
    p.time = now_;
    set_free(i);
    ++pending_[i].count;
}

// A member's place in the frame of its body's cell.
template <class Law>
Vector3 NewtonEvents<Law>::place(const Group& g, std::size_t m, Vector3 x) const {
    const std::array<int, 3>& turns = pending_[g.body[m]].turns;
    for (std::size_t a = 0; a < 3; ++a) x[a] += g.origin[a] + (g.offset[m][a] - turns[a]) * box_.edge[a];
    return x;
}

// The group at its begin, ready to be integrated, into c.
template <class Law>
void NewtonEvents<Law>::start(const Group& g, Cluster<Law>& c) const {
    if (!g.isolated) {
        c = g.cluster->before;
        return;
    }
    c.clear();
    c.base = g.lone.contact.begin;
    c.gravity = gravity_;
    c.largest_place = *std::ranges::max_element(box_.edge);
    c.largest_compression = largest_compression_;
    c.kernels = series_;
    for (std::size_t m = 0; m < g.body.size(); ++m) c.members.push_back(g.lone.before[m]);
    c.pairs.push_back(g.lone.pair);
}

template <class Law>
typename NewtonEvents<Law>::Row NewtonEvents<Law>::row_of(const Group& g, const Touching<Law>& q,
                                                          const EndedContact& e) const {
    const auto name = [&](int member) {
        return static_cast<int>(pending_[g.body[static_cast<std::size_t>(member)]].name);
    };
    int first = name(q.first), second = q.second >= 0 ? name(q.second) : wall_number(q);
    if (second >= 0 && second < first) std::swap(first, second);
    return {e.begin, e.end, first, second, e.impact_speed, e.separation_speed, e.overlapped};
}

}  // namespace hardlimit::boxes
