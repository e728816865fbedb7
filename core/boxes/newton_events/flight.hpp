// How a body flies: cells, the next event of a body, and what happens when its time has come.
#pragma once
#include "engine.hpp"

namespace hardlimit::boxes {

template <class Law>
Vector3 NewtonEvents<Law>::position(int i, double t) const {
    const Particle<3>& p = paths_[i];
    const double s = t - p.time;
    Vector3 x;
    for (std::size_t a = 0; a < 3; ++a)
        x[a] = p.position[a] + s * (p.velocity[a] + 0.5 * s * box_.gravity[a]);
    return x;
}

template <class Law>
Vector3 NewtonEvents<Law>::velocity(int i, double t) const {
    const Particle<3>& p = paths_[i];
    Vector3 v;
    for (std::size_t a = 0; a < 3; ++a) v[a] = p.velocity[a] + (t - p.time) * box_.gravity[a];
    return v;
}

// ---- the start -------------------------------------------------------------------------------------------------

template <class Law>
void NewtonEvents<Law>::note_radii(std::size_t n) {
    for (std::size_t i = 0; i < n; ++i) {
        largest_ = math::max(largest_, laws_.radius(i));
        smallest_ = math::min(smallest_, laws_.radius(i));
    }
}

// Several times as far as bodies of the speeds at the start compress each other; the wider the cells, the more bodies
// there are to look at. Bodies that fall grow faster.
template <class Law>
double NewtonEvents<Law>::usual_margin(const std::vector<double>& velocity) const {
    const double most = 0.1 * largest_;
    if (dot(gravity_, gravity_) > 0.0) return most;
    double square = 0.0;
    std::size_t at = 0;
    for (const double v : velocity) square += v * v;
    const std::size_t n = velocity.size() / 3;
    for (std::size_t i = 0; i < n; ++i)
        if (laws_.radius(i) == largest_) at = i;
    const double speed = math::sqrt(square / static_cast<double>(n));
    if (!(speed > 0.0)) return most;
    const auto body = static_cast<std::int64_t>(at);
    const double duration = laws_(body, body).duration(speed, 0.5 * laws_.mass(at));
    return math::clamp(2.0 * speed * duration, 0.005 * largest_, most);
}

// All bodies lie in one grid. While it is in contact, a body's place on the path on which it will fly on may lie
// outside of its cell by the margin.
template <class Law>
void NewtonEvents<Law>::make_cells(std::size_t n, const hardlimit_abi::TouchKernels& kernels) {
    series_ = &kernels.series;
    touch_ = kernels.reach[dot(gravity_, gravity_) > 0.0 ? 1 : 0];
    const double most = 2.001 * (largest_ + 2.0 * widest_margin_);
    query_.others = 1.0;
    for (int a = 0; a < 3; ++a) {
        const bool used = a < box_.dimension;
        cell_box_.edge[a] = used ? box_.edge[a] : most;
        cell_box_.boundary[a] = box_.boundary[a];
        query_.edge[a] = box_.edge[a];
        query_.per_edge[a] = cell_box_.wraps(a) ? 1.0 / box_.edge[a] : 0.0;
        query_.gravity[a] = box_.gravity[a];
        query_.half_gravity[a] = 0.5 * box_.gravity[a];
    }
    cells_ = Cells<3>(cell_box_, n, most, most);
    level_ = cells_.level_for(most);
    fetches_ = n > most_in_caches;
    // In a small box no second image of a body may come near.
    travel_ = math::min(0.25 * smallest_, 0.22 * smallest_edge() - 0.9 * largest_);
    const Grid<3>& g = cells_.grids()[static_cast<std::size_t>(level_)];
    for (int a = 0; a < box_.dimension; ++a) {
        images_ = images_ || (box_.wraps(a) && g.cells[a] < 4);
        walled_ = walled_ || box_.walled(a);
    }
}

// In the order of the cells: neighbours in space are neighbours in memory.
template <class Law>
void NewtonEvents<Law>::take(const std::vector<double>& position, const std::vector<double>& velocity) {
    const auto n = static_cast<u32>(position.size() / 3);
    std::vector<u32> cell(n), order(n);
    for (u32 i = 0; i < n; ++i) {
        double x[3];
        std::copy_n(position.data() + 3 * std::size_t{i}, 3, x);
        cell[i] = cells_.number(level_, cells_.place_of(level_, x));
        order[i] = i;
    }
    std::stable_sort(order.begin(), order.end(), [&](u32 a, u32 b) { return cell[a] < cell[b]; });
    paths_.resize(n);
    pending_.resize(n);
    laws_.reorder(order);
    for (u32 i = 0; i < n; ++i) {
        const u32 from = order[i];
        Particle<3>& p = paths_[i];
        std::copy_n(position.data() + 3 * std::size_t{from}, 3, p.position);
        std::copy_n(velocity.data() + 3 * std::size_t{from}, 3, p.velocity);
        p.time = 0.0;
        p.radius = radius(static_cast<int>(i));
        pending_[i].name = from;
        pending_[i].cell = cell[from] & (most_cells - 1);
    }
    put_into_cells();
}

template <class Law>
void NewtonEvents<Law>::put_into_cells() {
    cells_.clear();
    for (u32 i = 0; i < size32(); ++i) cells_.insert(pending_[i].cell, i);
}

template <class Law>
void NewtonEvents<Law>::restart_calendar() {
    calendar_.rebuild(
        size32(), [this](u32 id) { return pending_[id].time(); },
        [this](u32 id) { return pending_[id].name; });
}

// ---- the next event --------------------------------------------------------------------------------------------

template <class Law>
void NewtonEvents<Law>::schedule(int i) {
    const u32 id = static_cast<u32>(i);
    calendar_.push(id, pending_[i].time(), [this](u32 id) { return pending_[id].name; });
}

template <class Law>
void NewtonEvents<Law>::predict(int i) {
    find(i);
    schedule(i);
}

// All events of a body anew.
template <class Law>
void NewtonEvents<Law>::find(int i) {
    Pending& e = pending_[i];
    e.pair_time = math::infinity;
    e.partner = nobody;
    look(i);
    const Place<3> at = cells_.place(level_, e.cell);
    search(i, around(at));
    predict_own(i, at);
}

// The same without a partner that would be found first and does not count: who is nowhere is not touched.
template <class Law>
void NewtonEvents<Law>::find_but(int i, int other) {
    if (i == other) return find(i);
    const double time = std::exchange(paths_[other].time, math::nan);
    find(i);
    paths_[other].time = time;
}

// The body that is to be met by the others. After an undisturbed contact it is of its own size again.
template <class Law>
void NewtonEvents<Law>::look(int i) {
    const Particle<3>& p = paths_[i];
    const Held& e = pending_[i];
    const double s = now_ - p.time;
    const bool shrinks = e.group >= 0 && !e.clustered;
    query_.now = now_;
    query_.radius = shrinks ? radius(i) : p.radius;
    query_.space = p.radius;
    query_.span = shrinks ? e.end - now_ : 0.0;
    settled_ = shrinks ? now_ + query_.span : (e.clustered ? math::infinity : -math::infinity);
    for (int a = 0; a < 3; ++a) {
        query_.position[a] = p.position[a] + s * (p.velocity[a] + 0.5 * s * box_.gravity[a]);
        query_.velocity[a] = p.velocity[a] + s * box_.gravity[a];
    }
}

template <class Law>
void NewtonEvents<Law>::make_room_for_candidates() const {
    if (times_.size() >= cells_.room()) return;
    times_.resize(cells_.room());
    candidates_.resize(cells_.room());
}

// Written number by number: a copy in larger pieces would have to wait for the numbers.
template <class Law>
typename NewtonEvents<Law>::Block NewtonEvents<Law>::around(const Place<3>& at) const {
    const int deep = box_.dimension == 3 ? 1 : 0;
    return {{at[0] - 1, at[1] - 1, at[2] - deep}, {at[0] + 1, at[1] + 1, at[2] + deep}};
}

template <class Law>
void NewtonEvents<Law>::search(int i, const Block& in) {
    make_room_for_candidates();
    const auto self = static_cast<unsigned>(i);
    if (images_) {
        cells_.for_block(cell_box_, level_, in.from, in.to, [&](u32 cell, const double (&shift)[3]) {
            std::copy_n(shift, 3, query_.shift);
            const std::size_t n = cells_.collect(cell, candidates_, 0);
            examine(i, touch_.listed(query_, paths_.data(), self, candidates_.data(), times_.data(), n));
        });
        return;
    }
    hardlimit_abi::CellBlock block;
    const auto touch =
        cells_.lay_block(block, cell_box_, level_, in.from, in.to) ? touch_.across : touch_.near;
    examine(i, touch(query_, paths_.data(), self, candidates_.data(), times_.data(), block));
}

// What is touched first among the candidates. The kernel's times are lower bounds for whoever is busy. Simultaneous
// ones are told apart by the user's numbers.
template <class Law>
void NewtonEvents<Law>::examine(int i, const hardlimit_abi::Touched& touched) {
    const Pending& e = pending_[i];
    if (now_ + touched.time > e.pair_time || touched.time == math::infinity) return;
    consider(i, touched.id, now_ + touched.time);
    if (!touched.several && (now_ + touched.next > e.pair_time || touched.next == math::infinity)) return;
    double last = e.pair_time;
    for (std::size_t k = 0; k < touched.n; ++k) {
        if (now_ + times_[k] > last || times_[k] == math::infinity || candidates_[k] == touched.id) continue;
        consider(i, candidates_[k], now_ + times_[k]);
        last = e.pair_time;
    }
}

// Takes another body as the next partner, if it is met first. `grown`: see meeting().
template <class Law>
void NewtonEvents<Law>::consider(int i, u32 id, double grown) {
    Pending& e = pending_[i];
    const bool known = pending_[id].group < 0 && grown > settled_;
    const double time = known ? grown : meeting(i, static_cast<int>(id), grown);
    if (time > e.pair_time || time == math::infinity) return;
    if (time == e.pair_time && e.partner != nobody && pending_[e.partner].name < pending_[id].name) return;
    e.pair_time = time;
    e.partner = id;
    e.partner_count = pending_[id].count;
}

// When the body that looks, i, meets body j, one of them busy at least; they would at `grown` if neither ever shrank to
// its own size. Beyond the end of a cluster nothing is known of its members: what they meet then, they are told then.
// Members of one group do not meet here.
template <class Law>
double NewtonEvents<Law>::meeting(int i, int j, double grown) const {
    if (pending_[i].group == pending_[j].group) return math::infinity;
    const bool i_first = free(j) || (!free(i) && pending_[i].end < pending_[j].end);
    const int first = i_first ? i : j, last = i_first ? j : i;
    if (grown < pending_[first].end) {
        const Relative r = relative(j);
        const bool apart =
            passes(r, i, first, now_, paths_[last].radius) || passes(r, i, last, now_, paths_[first].radius);
        if (!apart) return grown;
    }
    if (clustered(first)) return math::infinity;
    if (!free(last)) {
        const double time = touch_time(j, radius(first) + paths_[last].radius);
        if (time < pending_[last].end && !passes(relative(j), i, last, pending_[first].end, radius(first)))
            return math::max(time, pending_[first].end);
        if (clustered(last)) return math::infinity;
    }
    return touch_time(j, radius(i) + radius(j));
}

// From the body that looks to body j, now.
template <class Law>
typename NewtonEvents<Law>::Relative NewtonEvents<Law>::relative(int j) const {
    const Vector3 x = position(j, now_), v = velocity(j, now_);
    Relative between;
    for (std::size_t k = 0; k < 3; ++k) {
        const double r = x[k] - query_.position[k];
        between.place[k] =
            r + (images_ ? query_.shift[k] : -query_.edge[k] * math::round_small(r * query_.per_edge[k]));
        between.velocity[k] = v[k] - query_.velocity[k];
    }
    return between;
}

// Whether a member of an undisturbed contact, body i or j, is out of reach of the other one from then until its group
// ends. How far its true path is off the one on which it flies on, b(s) ≤ ∫_s^∞ (t − s) |a| dt, is convex in s and zero
// at the end, so that it is at most a share (T − s)/T of what it is at touch; and it leads away from the partner, up to
// the angle by which the line of centres turns. So the true places, seen from the other body, lie in a triangle: its
// corners are the two ends of that path, and the true place at its begin.
template <class Law>
bool NewtonEvents<Law>::passes(const Relative& between, int i, int member, double from,
                               double other_radius) const {
    if (free(member) || clustered(member)) return false;
    const Held& e = pending_[member];
    const Isolated& l = group(e.group).lone;
    const std::size_t m = e.first ? 0 : 1;
    const double share = l.share[m], left = e.end - from, sign = member == i ? 1.0 : -1.0;
    const double off = (m == 0 ? -share : share) * math::clamp(left / l.span, 0.0, 1.0);
    Vector3 begin, away, along;
    for (std::size_t k = 0; k < 3; ++k) {
        begin[k] = sign * (between.place[k] + (from - now_) * between.velocity[k]);
        along[k] = sign * left * between.velocity[k];
        away[k] = -off * l.off[k];
    }
    const double reach = radius(member) + other_radius + l.room[m];
    return square_to_triangle(begin, away, along) > reach * reach * (1.0 + rounding_of_touch);
}

// When the paths of the body that looks and of body j come so near to each other.
template <class Law>
double NewtonEvents<Law>::touch_time(int j, double reach) const {
    const Relative between = relative(j);
    const double a = dot(between.velocity, between.velocity), b = dot(between.place, between.velocity);
    const double c = dot(between.place, between.place) - reach * reach, discriminant = b * b - a * c;
    if (!(b < 0.0 && discriminant > 0.0)) return math::infinity;
    return now_ + math::max(c, 0.0) / (math::sqrt(discriminant) - b);
}

// Where the path of the body that looks leaves its cell, which is at this place, or where a free body meets a wall, or
// the end of a cluster of its first member. Which border is the first, no processor can foresee: few branches.
template <class Law>
void NewtonEvents<Law>::predict_own(int i, const Place<3>& at) {
    Held& e = pending_[i];
    const Grid<3>& g = cells_.grids()[static_cast<std::size_t>(level_)];
    const bool is_free = free(i);
    double in = math::infinity;
    Own which = Own::low_x;
    const auto consider = [&](double time, int axis, bool up) {
        const auto sooner = 0u - static_cast<u32>(time < in);  // a mask: gcc would make a branch of a choice
        which = static_cast<Own>((static_cast<u32>(own_event(axis, up)) & sooner) |
                                 (static_cast<u32>(which) & ~sooner));
        in = math::min(in, time);
    };
    HL_UNROLL
    for (int a = 0; a < 3; ++a) {
        if (a == box_.dimension) break;
        const double x = query_.position[a], v = query_.velocity[a], pull = box_.gravity[a];
        double low = at[a] * g.edge[a], high = (at[a] + 1) * g.edge[a];
        if (walled_ && !box_.wraps(a)) {
            if (at[a] == 0) low = is_free ? query_.radius : -math::infinity;
            if (at[a] == g.cells[a] - 1) high = is_free ? box_.edge[a] - query_.radius : math::infinity;
        }
        if (pull == 0.0) {
            const double borders[2] = {low, high};
            const bool up = v > 0.0;
            consider(time_to(borders[up] - x, v), a, up);
        } else {
            consider(time_below(x, v, pull, high), a, true);
            consider(time_below(-x, -v, -pull, -low), a, false);
        }
    }
    e.own_time = now_ + in;
    e.own = static_cast<u32>(which) & 7u;
    if (!e.first || !e.clustered || e.end > e.own_time) return;
    e.own_time = e.end;
    e.own = static_cast<u32>(Own::ends) & 7u;
}

// f(j, r) for the images of bodies in the cells around body i's: r leads from i to j, now.
template <class Law>
template <class F>
void NewtonEvents<Law>::for_near(int i, const F& f) const {
    make_room_for_candidates();
    const Block near = around(cells_.place(level_, pending_[i].cell));
    const Vector3 x = position(i, now_);
    cells_.for_block(cell_box_, level_, near.from, near.to, [&](u32 cell, const double (&shift)[3]) {
        const std::size_t n = cells_.collect(cell, candidates_, 0);
        for (std::size_t k = 0; k < n; ++k) {
            const int j = static_cast<int>(candidates_[k]);
            if (j == i) continue;
            Vector3 r = position(j, now_);
            for (std::size_t a = 0; a < 3; ++a) r[a] = (r[a] + shift[a]) - x[a];
            f(j, r);
        }
    });
}

// ---- events ----------------------------------------------------------------------------------------------------

template <class Law>
void NewtonEvents<Law>::happen(int i) {
    const Pending& e = pending_[i];
    if (e.pair_time <= e.own_time) {
        if (pending_[e.partner].count != e.partner_count) return predict(i);
        const int j = static_cast<int>(e.partner);
        return free(i) && free(j) ? meet(i, j, 0) : conflict(i, j);
    }
    const Own own = static_cast<Own>(e.own);
    if (own == Own::ends) return finish(i);
    const int axis = axis_of(own);
    const int last = is_high(own) ? cells_.grids()[static_cast<std::size_t>(level_)].cells[axis] - 1 : 0;
    if (box_.walled(axis) && cells_.place(level_, e.cell)[axis] == last)
        return meet(i, -1, 2 * axis + (is_high(own) ? 1 : 0));
    leave_cell(i);
}

// Looks into the cells that have become neighbours.
template <class Law>
void NewtonEvents<Law>::leave_cell(int i) {
    Pending& e = pending_[i];
    const Own own = static_cast<Own>(e.own);
    const int axis = axis_of(own), step = is_high(own) ? 1 : -1;
    const Grid<3>& g = cells_.grids()[static_cast<std::size_t>(level_)];
    Place<3> at = cells_.place(level_, e.cell);
    cells_.remove(e.cell, static_cast<u32>(i));
    at[axis] += step;
    if (at[axis] < 0 || at[axis] == g.cells[axis]) {
        at[axis] -= step * g.cells[axis];
        paths_[i].position[axis] -= step * box_.edge[axis];
        pending_[i].turns[static_cast<std::size_t>(axis)] += step;
    }
    e.cell = cells_.number(level_, at) & (most_cells - 1);
    cells_.insert(e.cell, static_cast<u32>(i));
    Block beyond = around(at);
    beyond.from[axis] = beyond.to[axis] = at[axis] + step;
    look(i);
    search(i, beyond);
    predict_own(i, at);
    schedule(i);
}

}  // namespace hardlimit::boxes
