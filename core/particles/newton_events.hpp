// Newton's equations for a box of spheres or disks, from event to event.
//
// Between contacts bodies fly on parabolas, known exactly. Bodies in contact form groups. A group is integrated
// (cluster.hpp) from its `begin` to an `end` at which all its contacts are over, or for a while. Until then its members are
// busy: to the others, each is a body on the parabola through the two ends of its path, with a radius larger by the
// `margin`, the most by which its true path leaves that parabola. As long as no other body comes so near, nothing can act
// on the group and its end stands. When one does (a conflict), the group is integrated again, up to now, and goes on
// together with that body. So no contact is missed, and nothing is done that a later event could change.
//
// Every body keeps its earliest event alone; it is dropped when the partner has been deflected since (`version`).
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <queue>
#include <vector>

#include "cluster.hpp"
#include "planar_contact.hpp"

namespace hardlimit::particles {

struct Box {
    int dimension;
    Vector3 edge;                  // [m]
    std::array<bool, 3> periodic;  // else walls at 0 and at the edge
    Vector3 gravity;               // [m/s²]
};

// One contact of the log.
struct LoggedContact {
    double begin, end;  // [s]; end is NaN for a contact still open
    int first, second;  // second < 0: −1 − 2·axis for the wall at 0, −2 − 2·axis at the far edge
    double impact_speed, separation_speed;
    bool overlapped;
};

template <class Law>
class NewtonEvents {
public:
    // law(i, j): the contact of bodies i and j; law(i, −1): of body i and a wall.
    template <class LawOf>
    NewtonEvents(const Box& box, const std::vector<Vector3>& position, const std::vector<Vector3>& velocity,
                 const std::vector<double>& radius, const std::vector<double>& mass, LawOf law_of)
        : box_(box), law_of_(std::move(law_of)) {
        const std::size_t n = radius.size();
        bodies_.resize(n);
        for (std::size_t i = 0; i < n; ++i) {
            Body& b = bodies_[i];
            b.position = position[i];
            b.velocity = velocity[i];
            b.radius = radius[i];
            b.mass = mass[i];
            largest_ = math::max(largest_, radius[i]);
            smallest_ = math::min(smallest_, radius[i]);
        }
        make_cells();
        for (std::size_t i = 0; i < n; ++i) insert(static_cast<int>(i));
        for (std::size_t i = 0; i < n; ++i) predict(static_cast<int>(i));
    }

    void advance(double until, Stop& stop) {
        while (!queue_.empty() && !stop()) {
            const Entry next = queue_.top();
            if (next.time > until) break;
            queue_.pop();
            if (next.body >= 0) {
                Body& b = bodies_[static_cast<std::size_t>(next.body)];
                if (b.event != next.serial) continue;
                now_ = next.time;
                happen(next.body);
            } else {
                Group& g = groups_[static_cast<std::size_t>(~next.body)];
                if (!g.alive || g.serial != next.serial) continue;
                now_ = next.time;
                ++events_;
                finish(~next.body);
            }
        }
        if (!stop.stopped()) now_ = until;
    }

    double time() const { return now_; }
    std::int64_t contacts_begun() const { return begun_; }
    std::int64_t contacts_overlapped() const { return overlapped_; }
    std::int64_t conflicts() const { return conflicts_; }
    std::int64_t clusters() const { return clusters_; }
    int largest_cluster() const { return largest_cluster_; }
    const std::vector<LoggedContact>& log() const { return log_; }

    struct State {
        std::vector<Vector3> position, velocity;  // unwrapped paths
        double kinetic, potential, contact, dissipated;
    };

    // The physical state now. Groups are integrated on the side; nothing changes.
    State state() {
        State s;
        s.contact = 0.0;
        s.dissipated = dissipated_;
        const std::size_t n = bodies_.size();
        s.position.resize(n);
        s.velocity.resize(n);
        for (std::size_t i = 0; i < n; ++i) {
            if (bodies_[i].group >= 0) continue;
            s.position[i] = unwrapped(bodies_[i], position(bodies_[i], now_));
            s.velocity[i] = velocity(bodies_[i], now_);
        }
        for (Group& g : groups_) {
            if (!g.alive) continue;
            Cluster<Law> c = start_of(g);
            Stop never;
            c.run(now_ - c.base, never);
            s.contact += c.contact_energy();
            s.dissipated += c.dissipated;
            for (std::size_t m = 0; m < c.members.size(); ++m) {
                const auto i = static_cast<std::size_t>(g.body[m]);
                s.position[i] = unwrapped(bodies_[i], place(g, m, c.members[m].position));
                s.velocity[i] = c.members[m].velocity;
            }
        }
        s.kinetic = s.potential = 0.0;
        for (std::size_t i = 0; i < n; ++i) {
            s.kinetic += 0.5 * bodies_[i].mass * dot(s.velocity[i], s.velocity[i]);
            s.potential -= bodies_[i].mass * dot(box_.gravity, s.position[i]);
        }
        return s;
    }

private:
    enum class What : unsigned char { none, meets, wall, crosses };

    struct Body {
        Vector3 position, velocity;  // of the parabola at `from`, in the cell's frame
        double from = 0.0;
        double radius, mass;
        double margin = 0.0;  // of a busy body
        double end = math::infinity;
        int group = -1;
        std::array<int, 3> cell{};
        std::array<int, 3> turns{};  // how often the path has left the box through an edge
        int next = -1, previous = -1;
        std::uint32_t version = 0, event = 0;
        double when = math::infinity;
        What what = What::none;
        int partner = -1;  // body, or 2·axis + (1 at the far edge)
        std::uint32_t partner_version = 0;
    };
    // A contact with which nothing interferes: its two ends.
    struct Isolated {
        Touching<Law> pair;
        Member before[2], after[2];
        double span, dissipated;
        EndedContact contact;
    };
    struct Group {
        bool isolated = false;
        Isolated lone;               // if isolated
        Cluster<Law> before, after;  // else
        std::vector<int> body;
        Vector3 origin;
        std::vector<Vector3> offset;  // [members] turns of the frame in which the member's place is given
        bool alive = false;
        std::uint32_t serial = 0;
    };
    struct Entry {
        double time;
        int body;  // or ~group
        std::uint32_t serial;
        bool operator<(const Entry& o) const { return time > o.time || (time == o.time && body > o.body); }
    };

    Box box_;
    std::function<Law(int, int)> law_of_;
    std::vector<Body> bodies_;
    std::vector<Group> groups_;
    std::vector<int> spare_;
    std::priority_queue<Entry> queue_;
    std::vector<int> head_;
    std::array<int, 3> cells_{1, 1, 1};
    Vector3 cell_edge_{};
    double largest_ = 0.0, smallest_ = math::infinity, slack_ = 0.0, now_ = 0.0, dissipated_ = 0.0;
    std::int64_t begun_ = 0, overlapped_ = 0, conflicts_ = 0, clusters_ = 0, events_ = 0;
    int largest_cluster_ = 0;
    std::vector<LoggedContact> log_;

    // ---- paths --------------------------------------------------------------------------------------------

    Vector3 position(const Body& b, double t) const {
        const double s = t - b.from;
        Vector3 x = b.position;
        for (std::size_t a = 0; a < 3; ++a) x[a] += s * (b.velocity[a] + 0.5 * s * box_.gravity[a]);
        return x;
    }
    Vector3 velocity(const Body& b, double t) const {
        Vector3 v = b.velocity;
        for (std::size_t a = 0; a < 3; ++a) v[a] += (t - b.from) * box_.gravity[a];
        return v;
    }
    Vector3 unwrapped(const Body& b, Vector3 x) const {
        for (std::size_t a = 0; a < 3; ++a) x[a] += b.turns[a] * box_.edge[a];
        return x;
    }

    // ---- cells --------------------------------------------------------------------------------------------

    void make_cells() {
        // Fat bodies fit: a margin is at most `slack_`.
        slack_ = 0.1 * largest_;
        const double least = 2.0 * (largest_ + slack_);
        std::size_t total = 1;
        for (int a = 0; a < box_.dimension; ++a) {
            const double most = math::max(1.0, box_.edge[a] / least);
            cells_[a] = static_cast<int>(math::min(most, 200.0));
            cell_edge_[a] = box_.edge[a] / cells_[a];
            total *= static_cast<std::size_t>(cells_[a]);
        }
        head_.assign(total, -1);
    }
    std::size_t index(const std::array<int, 3>& c) const {
        return static_cast<std::size_t>((c[2] * cells_[1] + c[1]) * cells_[0] + c[0]);
    }
    void insert(int i) {
        Body& b = bodies_[static_cast<std::size_t>(i)];
        for (int a = 0; a < box_.dimension; ++a)
            b.cell[a] = std::clamp(static_cast<int>(b.position[a] / cell_edge_[a]), 0, cells_[a] - 1);
        link(i);
    }
    void link(int i) {
        Body& b = bodies_[static_cast<std::size_t>(i)];
        int& head = head_[index(b.cell)];
        b.previous = -1;
        b.next = head;
        if (head >= 0) bodies_[static_cast<std::size_t>(head)].previous = i;
        head = i;
    }
    void unlink(int i) {
        Body& b = bodies_[static_cast<std::size_t>(i)];
        if (b.next >= 0) bodies_[static_cast<std::size_t>(b.next)].previous = b.previous;
        (b.previous >= 0 ? bodies_[static_cast<std::size_t>(b.previous)].next : head_[index(b.cell)]) =
            b.next;
    }

    // f(j, shift) for every body j in the cells around b, with what is added to its position.
    template <class F>
    void around(const std::array<int, 3>& cell, const F& f) const {
        std::array<int, 3> from{}, to{};
        for (int a = 0; a < box_.dimension; ++a) from[a] = -1, to[a] = 1;
        for (int dz = from[2]; dz <= to[2]; ++dz)
            for (int dy = from[1]; dy <= to[1]; ++dy)
                for (int dx = from[0]; dx <= to[0]; ++dx) {
                    std::array<int, 3> c{cell[0] + dx, cell[1] + dy, cell[2] + dz};
                    Vector3 shift{};
                    bool inside = true;
                    for (int a = 0; a < box_.dimension; ++a) {
                        if (c[a] >= 0 && c[a] < cells_[a]) continue;
                        inside = inside && box_.periodic[a];
                        shift[a] = c[a] < 0 ? -box_.edge[a] : box_.edge[a];
                        c[a] += c[a] < 0 ? cells_[a] : -cells_[a];
                    }
                    if (!inside) continue;
                    for (int j = head_[index(c)]; j >= 0; j = bodies_[static_cast<std::size_t>(j)].next)
                        f(j, shift);
                }
    }

    // ---- prediction ---------------------------------------------------------------------------------------

    void predict(int i) {
        Body& b = bodies_[static_cast<std::size_t>(i)];
        b.when = math::infinity;
        b.what = What::none;
        const Vector3 x = position(b, now_), v = velocity(b, now_);
        around(b.cell, [&](int j, const Vector3& shift) {
            const Body& o = bodies_[static_cast<std::size_t>(j)];
            if (j == i || (b.group >= 0 && b.group == o.group)) return;
            const Vector3 xo = position(o, now_), vo = velocity(o, now_);
            Vector3 r, u;
            for (std::size_t a = 0; a < 3; ++a) {
                r[a] = (xo[a] + shift[a]) - x[a];
                u[a] = vo[a] - v[a];
            }
            const double reach = (b.radius + b.margin) + (o.radius + o.margin);
            const double closing = -dot(r, u), beyond = dot(r, r) - reach * reach;
            if (!(closing > 0.0) && !(beyond < 0.0 && (b.group >= 0 || o.group >= 0))) return;
            double t = now_;
            if (beyond > 0.0) {
                const double square = closing * closing - dot(u, u) * beyond;
                if (square < 0.0) return;
                t = now_ + beyond / (closing + math::sqrt(square));
            }
            if (t >= b.when || t > b.end || t > o.end) return;
            b.when = t;
            b.what = What::meets;
            b.partner = j;
            b.partner_version = o.version;
        });
        for (int a = 0; a < box_.dimension; ++a) {
            if (!box_.periodic[a] && b.group < 0) predict_wall(b, a, x[a], v[a]);
            predict_crossing(b, a, x[a], v[a]);
        }
        queue_.push({b.when, i, ++b.event});
    }

    void predict_wall(Body& b, int a, double x, double v) {
        for (int far = 0; far < 2; ++far) {
            const double gap = (far ? box_.edge[a] - x : x) - b.radius;
            const double rate = far ? v : -v, towards = far ? box_.gravity[a] : -box_.gravity[a];
            double t = math::infinity;
            const double square = rate * rate + 2.0 * towards * math::max(gap, 0.0);
            if (gap <= 0.0 && rate > 0.0)
                t = 0.0;
            else if (gap <= 0.0)
                t = towards > 0.0 ? -2.0 * rate / towards : math::infinity;
            else if (square >= 0.0 && rate > 0.0)
                t = 2.0 * gap / (rate + math::sqrt(square));
            else if (square >= 0.0 && towards > 0.0)
                t = (math::sqrt(square) - rate) / towards;
            if (now_ + t >= b.when) continue;
            b.when = now_ + t;
            b.what = What::wall;
            b.partner = 2 * a + far;
        }
    }

    // When the parabola leaves the cell along axis a.
    void predict_crossing(Body& b, int a, double x, double v) {
        const double g = box_.gravity[a];
        for (int up = 0; up < 2; ++up) {
            if (!box_.periodic[a] && (up ? b.cell[a] == cells_[a] - 1 : b.cell[a] == 0)) continue;
            const double border = cell_edge_[a] * (b.cell[a] + up);
            const double gap = math::max(up ? border - x : x - border, 0.0);
            const double rate = up ? v : -v, towards = up ? g : -g;
            const double square = rate * rate + 2.0 * towards * gap;
            double t = math::infinity;
            if (square >= 0.0 && rate > 0.0)
                t = 2.0 * gap / (rate + math::sqrt(square));
            else if (square >= 0.0 && towards > 0.0)
                t = (math::sqrt(square) - rate) / towards;
            if (now_ + t >= b.when) continue;
            b.when = now_ + t;
            b.what = What::crosses;
            b.partner = 2 * a + up;
        }
    }

    // ---- events -------------------------------------------------------------------------------------------

    void happen(int i) {
        Body& b = bodies_[static_cast<std::size_t>(i)];
        ++events_;
        if (b.what == What::crosses) return cross(i);
        if (b.what == What::wall) return touch(i, -1, b.partner);
        const Body& o = bodies_[static_cast<std::size_t>(b.partner)];
        if (o.version != b.partner_version) return predict(i);
        const int j = b.partner;
        if (b.group < 0 && o.group < 0) return touch(i, j, 0);
        ++conflicts_;
        conflict(i, j);
    }

    void cross(int i) {
        Body& b = bodies_[static_cast<std::size_t>(i)];
        const int a = b.partner / 2, up = b.partner % 2;
        unlink(i);
        b.cell[a] += up ? 1 : -1;
        if (b.cell[a] < 0 || b.cell[a] >= cells_[a]) {
            b.cell[a] += up ? -cells_[a] : cells_[a];
            b.position[a] += up ? -box_.edge[a] : box_.edge[a];
            b.turns[a] += up ? 1 : -1;
        }
        link(i);
        predict(i);
    }

    // ---- groups -------------------------------------------------------------------------------------------

    // The pair of a group that is not open, by its bodies.
    struct Live {
        int first, second;
        Touching<Law> pair;
    };

    // Ends a group now: its members are on their own again, at their true places.
    void settle(int index, bool at_end, std::vector<Live>& live) {
        Group& g = groups_[static_cast<std::size_t>(index)];
        if (g.isolated && at_end) return settle_isolated(index);
        if (!at_end) {
            g.after = start_of(g);
            Stop never;
            g.after.run(now_ - g.after.base, never);
        }
        const Cluster<Law>& c = g.after;
        dissipated_ += c.dissipated;
        begun_ += c.begun;
        for (const EndedContact& e : c.ended) {
            const auto [first, second] = names(g, c.pairs[static_cast<std::size_t>(e.pair)]);
            overlapped_ += e.overlapped;
            log_.push_back({e.begin, e.end, first, second, e.impact_speed, e.separation_speed, e.overlapped});
        }
        for (std::size_t m = 0; m < g.body.size(); ++m) put(g, m, c.members[m]);
        for (const Touching<Law>& q : c.pairs) {
            if (q.touch == Touch::open) continue;
            const int second = q.second < 0 ? -1 : g.body[static_cast<std::size_t>(q.second)];
            live.push_back({g.body[static_cast<std::size_t>(q.first)], second, q});
        }
        g.alive = false;
        spare_.push_back(index);
    }

    void settle_isolated(int index) {
        Group& g = groups_[static_cast<std::size_t>(index)];
        const auto [first, second] = names(g, g.lone.pair);
        const EndedContact& e = g.lone.contact;
        log_.push_back({e.begin, e.end, first, second, e.impact_speed, e.separation_speed, false});
        dissipated_ += g.lone.dissipated;
        for (std::size_t m = 0; m < g.body.size(); ++m) put(g, m, g.lone.after[m]);
        g.alive = false;
        spare_.push_back(index);
    }

    // A member is on its own again, at its true place.
    void put(const Group& g, std::size_t m, const Member& at) {
        Body& b = bodies_[static_cast<std::size_t>(g.body[m])];
        b.position = place(g, m, at.position);
        b.velocity = at.velocity;
        b.from = now_;
        b.margin = 0.0;
        b.end = math::infinity;
        b.group = -1;
        ++b.version;
    }

    // The group at its begin, ready to be integrated.
    Cluster<Law> start_of(const Group& g) const {
        if (!g.isolated) return g.before;
        Cluster<Law> c;
        c.base = g.lone.contact.begin;
        c.gravity = box_.gravity;
        for (std::size_t m = 0; m < g.body.size(); ++m) c.members.push_back(g.lone.before[m]);
        c.pairs.push_back(g.lone.pair);
        return c;
    }

    std::pair<int, int> names(const Group& g, const Touching<Law>& q) const {
        const int i = g.body[static_cast<std::size_t>(q.first)];
        if (q.second < 0) return {i, q.side > 0.0 ? -1 - 2 * q.axis : -2 - 2 * q.axis};
        const int j = g.body[static_cast<std::size_t>(q.second)];
        return {std::min(i, j), std::max(i, j)};
    }

    // A member's place in the frame of its body's cell.
    Vector3 place(const Group& g, std::size_t m, Vector3 x) const {
        const Body& b = bodies_[static_cast<std::size_t>(g.body[m])];
        for (std::size_t a = 0; a < 3; ++a)
            x[a] += g.origin[a] + (g.offset[m][a] - b.turns[a]) * box_.edge[a];
        return x;
    }

    void finish(int index) {
        std::vector<Live> live;
        settle(index, true, live);
        const std::vector<int> bodies = groups_[static_cast<std::size_t>(index)].body;
        std::vector<int> part(bodies.size());
        for (std::size_t m = 0; m < bodies.size(); ++m) part[m] = static_cast<int>(m);
        const auto member = [&](int body) {
            return std::find(bodies.begin(), bodies.end(), body) - bodies.begin();
        };
        for (const Live& pair : live) {
            if (pair.second < 0) continue;
            const int a = part[static_cast<std::size_t>(member(pair.first))];
            const int b = part[static_cast<std::size_t>(member(pair.second))];
            for (int& p : part)
                if (p == b) p = a;
        }
        // First those that go on in contact, so that the others see them as they are.
        std::vector<unsigned char> held(bodies.size(), 0);
        for (const Live& pair : live)
            held[static_cast<std::size_t>(part[static_cast<std::size_t>(member(pair.first))])] = 1;
        std::vector<int> alone;
        for (std::size_t m = 0; m < bodies.size(); ++m)
            if (!held[static_cast<std::size_t>(part[m])]) alone.push_back(bodies[m]);
        for (std::size_t root = 0; root < bodies.size(); ++root) {
            if (!held[root]) continue;
            std::vector<int> set;
            for (std::size_t m = 0; m < bodies.size(); ++m)
                if (part[m] == static_cast<int>(root) &&
                    bodies_[static_cast<std::size_t>(bodies[m])].group < 0)
                    set.push_back(bodies[m]);
            if (set.empty()) continue;
            std::vector<Live> own;
            for (const Live& pair : live)
                if (std::find(set.begin(), set.end(), pair.first) != set.end()) own.push_back(pair);
            form(set, own);
        }
        for (const int i : alone)
            if (bodies_[static_cast<std::size_t>(i)].group < 0) predict(i);
    }

    void touch(int i, int j, int wall) {
        std::vector<Live> live(1);
        live[0].first = i;
        live[0].second = j;
        Touching<Law>& q = live[0].pair;
        q.touch = Touch::closed;
        q.axis = wall / 2;
        q.side = wall % 2 ? -1.0 : 1.0;
        q.fresh = true;
        q.begin = now_;
        q.impact_speed = math::nan;  // until the pair's geometry is known
        std::vector<int> set{i};
        if (j >= 0) set.push_back(j);
        for (const int k : set) stop_at_now(k);
        if (isolate(set, live)) return;
        ++begun_;
        form(set, live);
    }

    // A contact that nothing disturbs as far as is known now is solved as a whole. Otherwise nothing changes, but that
    // bodies so near that they may touch join the set.
    bool isolate(std::vector<int>& set, std::vector<Live>& live) {
        const int index = spare_group();
        Group& g = groups_[static_cast<std::size_t>(index)];
        open_group(g, set);
        Isolated& l = g.lone;
        const Touching<Law>& asked = live[0].pair;
        for (std::size_t m = 0; m < set.size(); ++m) l.before[m] = g.before.members[m];
        l.pair = set.size() == 2 ? pair_of(g, 0, 1) : wall_of(g, 0, asked.axis, asked.side < 0.0);
        l.pair.touch = Touch::closed;
        l.pair.fresh = true;
        l.pair.begin = now_;
        const bool solved = (set.size() == 2 ? solve_pair(l) : solve_wall(l)) && far_from_walls(g, l);
        if (solved) {
            g.isolated = true;
            for (std::size_t m = 0; m < set.size(); ++m)
                busy(g, index, m, l.after[m], l.span, l.pair.depth_unit);
            std::vector<int> near;
            for (const int i : set) intruders(i, index, near);
            if (near.empty()) {
                ++begun_;
                for (const int i : set) predict(i);
                queue_.push({now_ + l.span, ~index, ++g.serial});
                return true;
            }
            release(index);
            for (const int k : near) take(k, set, live);
            return false;
        }
        g.alive = false;
        spare_.push_back(index);
        return false;
    }

    // In the plane of approach, then on straight lines until the pair has come apart. depth_unit of the pair becomes what
    // the first body's margin is for a share of 1.
    bool solve_pair(Isolated& l) const {
        Touching<Law>& q = l.pair;
        const Member &a = l.before[0], &b = l.before[1];
        Vector3 n, v;
        for (std::size_t k = 0; k < 3; ++k) {
            n[k] = (b.position[k] - a.position[k]) + q.image[k];
            v[k] = b.velocity[k] - a.velocity[k];
        }
        const double distance = math::sqrt(dot(n, n));
        for (double& x : n) x /= distance;
        const double approach = -dot(n, v);
        Vector3 across;
        for (std::size_t k = 0; k < 3; ++k) across[k] = v[k] + approach * n[k];
        const double sideways = math::sqrt(dot(across, across));
        if (!(approach > 0.0)) return false;
        if (sideways > 0.0)
            for (double& x : across) x /= sideways;
        const PlanarContact end = solve_planar_contact(q.law, Approach{q.mass, distance, approach, sideways});
        if (end.outcome != Outcome::ok) return false;
        const auto turn = math::sincos(end.turn);
        const double r = distance - end.compression, out = end.radial_speed, swing = end.tangential_speed;
        const double left = end.compression * (distance + r), b2 = r * out;
        const double opening =
            left > 0.0 ? left / (b2 + math::sqrt(b2 * b2 + (out * out + swing * swing) * left)) : 0.0;
        l.span = end.duration + opening;
        const double vn = out * turn.cos - swing * turn.sin, vt = out * turn.sin + swing * turn.cos;
        const double rn = r * turn.cos + vn * opening, rt = r * turn.sin + vt * opening;
        const double total = a.mass + b.mass;
        for (std::size_t m = 0; m < 2; ++m) {
            const Member& from = l.before[m];
            Member& to = l.after[m] = from;
            const double share = m == 0 ? -b.mass / total : a.mass / total;
            for (std::size_t k = 0; k < 3; ++k) {
                const double mean = (a.mass * a.velocity[k] + b.mass * b.velocity[k]) / total,
                             g = box_.gravity[k];
                to.position[k] +=
                    l.span * (mean + 0.5 * g * l.span) + share * ((rn - distance) * n[k] + rt * across[k]);
                to.velocity[k] = mean + g * l.span + share * (vn * n[k] + vt * across[k]);
            }
        }
        l.dissipated =
            0.5 * q.mass * (end.speed_loss * (approach + out) + (sideways - swing) * (sideways + swing));
        l.contact = {0, now_, now_ + end.duration, approach, out, false};
        q.impact_speed = approach;
        const double deepest = 0.5 * approach * end.duration;
        const double angle = end.turn + opening * swing / r;
        q.depth_unit = 1.1 * (deepest * (1.0 + 2.5 * angle) + 0.25 * distance * angle * angle);
        return l.span * (approach + sideways) <= travel() && q.depth_unit <= slack_;
    }

    bool solve_wall(Isolated& l) const {
        Touching<Law>& q = l.pair;
        const auto axis = static_cast<std::size_t>(q.axis);
        const Member& a = l.before[0];
        const double approach = -q.side * a.velocity[axis], weight = -q.side * box_.gravity[axis];
        if (!(approach > 0.0)) return false;
        const PlanarContact end =
            solve_planar_contact(q.law, Approach{q.mass, math::infinity, approach, 0.0, weight});
        if (end.outcome != Outcome::ok) return false;
        const double square = end.radial_speed * end.radial_speed - 2.0 * weight * end.compression;
        if (square < 0.0) return false;
        const double opening =
            end.compression > 0.0 ? 2.0 * end.compression / (end.radial_speed + math::sqrt(square)) : 0.0;
        l.span = end.duration + opening;
        Member& to = l.after[0] = a;
        for (std::size_t k = 0; k < 3; ++k) {
            to.position[k] += l.span * (a.velocity[k] + 0.5 * box_.gravity[k] * l.span);
            to.velocity[k] += box_.gravity[k] * l.span;
        }
        to.position[axis] = q.wall + q.side * q.reach;
        to.velocity[axis] = q.side * (end.radial_speed - weight * opening);
        l.dissipated =
            q.mass * (0.5 * end.speed_loss * (approach + end.radial_speed) + weight * end.compression);
        l.contact = {0, now_, now_ + end.duration, approach, end.radial_speed, false};
        q.impact_speed = approach;
        q.depth_unit = 1.1 * (0.5 * approach + math::abs(weight) * l.span) * l.span;
        return l.span * math::sqrt(dot(a.velocity, a.velocity)) <= travel() && q.depth_unit <= slack_;
    }

    // Whether the members stay away from all walls but that of the contact.
    bool far_from_walls(const Group& g, const Isolated& l) const {
        for (std::size_t m = 0; m < g.body.size(); ++m)
            for (int a = 0; a < box_.dimension; ++a)
                for (int far = 0; far < 2; ++far) {
                    const bool own =
                        l.pair.second < 0 && l.pair.axis == a && (l.pair.side < 0.0) == (far == 1);
                    if (!box_.periodic[static_cast<std::size_t>(a)] && !own &&
                        near_wall(g, static_cast<int>(m), a, far))
                        return false;
                }
        return true;
    }

    // Until it ends, a member of a group is a fat body on the parabola between its two ends.
    void busy(const Group& g, int index, std::size_t m, const Member& after, double span, double margin) {
        Body& b = bodies_[static_cast<std::size_t>(g.body[m])];
        b.group = index;
        b.end = now_ + span;
        const Member& before = g.before.members[m];
        for (std::size_t a = 0; a < 3; ++a)
            b.velocity[a] = (after.position[a] - before.position[a]) / span - 0.5 * span * box_.gravity[a];
        b.margin = margin;
    }

    int spare_group() {
        if (spare_.empty()) {
            groups_.emplace_back();
            return static_cast<int>(groups_.size()) - 1;
        }
        const int index = spare_.back();
        spare_.pop_back();
        return index;
    }

    // The body's parabola starts here.
    void stop_at_now(int i) {
        Body& b = bodies_[static_cast<std::size_t>(i)];
        if (b.group >= 0) return;
        b.position = position(b, now_);
        b.velocity = velocity(b, now_);
        b.from = now_;
        ++b.version;
    }

    void conflict(int i, int j) {
        std::vector<int> set;
        std::vector<Live> live;
        for (const int k : {i, j}) take(k, set, live);
        form(set, live);
    }

    // A body, with all of its group, becomes part of the set.
    void take(int i, std::vector<int>& set, std::vector<Live>& live) {
        if (std::find(set.begin(), set.end(), i) != set.end()) return;
        const int group = bodies_[static_cast<std::size_t>(i)].group;
        if (group < 0) {
            stop_at_now(i);
            set.push_back(i);
            return;
        }
        settle(group, false, live);
        for (const int k : groups_[static_cast<std::size_t>(group)].body) set.push_back(k);
    }

    void form(std::vector<int> set, std::vector<Live> live) {
        int index = 0;
        for (;;) {
            index = spare_group();
            build(index, set, live);
            if (groups_[static_cast<std::size_t>(index)].after.time == 0.0)
                break;  // nothing is closed any more
            const std::size_t before = set.size();
            const std::vector<int> inside = set;
            std::vector<int> near;
            for (const int i : inside) intruders(i, index, near);
            if (near.empty()) break;
            release(index);
            for (const int k : near) take(k, set, live);
            if (set.size() == before) break;
        }
        Group& g = groups_[static_cast<std::size_t>(index)];
        if (g.after.time == 0.0) {
            std::vector<Live> none;
            settle(index, true, none);
            for (const int i : set) predict(i);
            return;
        }
        clusters_ += set.size() > 2 || g.before.pairs.size() > 1;
        largest_cluster_ = std::max(largest_cluster_, static_cast<int>(set.size()));
        for (const int i : set) predict(i);
        queue_.push({g.before.base + g.after.time, ~index, ++g.serial});
    }

    // Undoes build: the members are free bodies at their places now.
    void release(int index) {
        Group& g = groups_[static_cast<std::size_t>(index)];
        for (std::size_t m = 0; m < g.body.size(); ++m) {
            Body& b = bodies_[static_cast<std::size_t>(g.body[m])];
            b.group = -1;
            b.margin = 0.0;
            b.end = math::infinity;
            b.velocity = g.before.members[m].velocity;
        }
        g.alive = false;
        spare_.push_back(index);
    }

    void intruders(int i, int index, std::vector<int>& near) const {
        const Body& b = bodies_[static_cast<std::size_t>(i)];
        const Vector3 x = position(b, now_);
        around(b.cell, [&](int j, const Vector3& shift) {
            const Body& o = bodies_[static_cast<std::size_t>(j)];
            if (j == i || o.group == index) return;
            const Vector3 xo = position(o, now_);
            Vector3 r;
            for (std::size_t a = 0; a < 3; ++a) r[a] = (xo[a] + shift[a]) - x[a];
            const double reach = (b.radius + b.margin) + (o.radius + o.margin);
            if (dot(r, r) < reach * reach && std::find(near.begin(), near.end(), j) == near.end())
                near.push_back(j);
        });
    }

    // Integrates the set from now on and makes its members busy.
    void build(int index, const std::vector<int>& set, std::vector<Live>& live) {
        Group& g = groups_[static_cast<std::size_t>(index)];
        open_group(g, set);
        Cluster<Law>& c = g.before;
        pair_up(g, live);
        double horizon = horizon_of(c);
        for (;;) {
            g.after = c;
            g.after.record = true;
            Stop never;
            g.after.run(horizon, never);
            if (margins(g) || g.after.time == 0.0) break;
            horizon = 0.5 * g.after.time;
        }
        g.after.trace.clear();
    }

    // The members as they are now, without pairs.
    void open_group(Group& g, const std::vector<int>& set) const {
        g.alive = true;
        g.isolated = false;
        g.body = set;
        g.origin = bodies_[static_cast<std::size_t>(set[0])].position;
        g.offset.assign(set.size(), {});
        Cluster<Law>& c = g.before;
        c = Cluster<Law>{};
        c.base = now_;
        c.gravity = box_.gravity;
        for (std::size_t m = 0; m < set.size(); ++m) {
            const Body& b = bodies_[static_cast<std::size_t>(set[m])];
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

    double nearest(double x, int a) const {
        if (a >= box_.dimension || !box_.periodic[a]) return 0.0;
        return math::round_small(x / box_.edge[a]);
    }

    void pair_up(Group& g, std::vector<Live>& live) {
        Cluster<Law>& c = g.before;
        const int n = static_cast<int>(g.body.size());
        for (int i = 0; i < n; ++i) {
            for (int j = i + 1; j < n; ++j) c.pairs.push_back(pair_of(g, i, j));
            for (int a = 0; a < box_.dimension; ++a)
                for (int far = 0; far < 2; ++far)
                    if (!box_.periodic[a] && near_wall(g, i, a, far))
                        c.pairs.push_back(wall_of(g, i, a, far));
        }
        for (Live& l : live)
            for (Touching<Law>& q : c.pairs) {
                const bool walls =
                    l.second < 0 && q.second < 0 && l.pair.axis == q.axis && l.pair.side == q.side;
                const int first = g.body[static_cast<std::size_t>(q.first)];
                const int second = q.second < 0 ? -1 : g.body[static_cast<std::size_t>(q.second)];
                const bool same =
                    (first == l.first && second == l.second) || (first == l.second && second == l.first);
                if (!same || (second < 0 && !walls)) continue;
                adopt(q, l.pair, c);
            }
    }

    void adopt(Touching<Law>& q, Touching<Law>& old, const Cluster<Law>& c) const {
        q.touch = old.touch;
        q.fresh = old.fresh;
        q.rooted = old.rooted;
        q.s = old.s;
        q.begin = old.begin;
        q.overlapped = old.overlapped;
        if (math::is_nan(old.impact_speed)) old.impact_speed = c.rate(q);
        q.impact_speed = old.impact_speed;
    }

    Touching<Law> pair_of(const Group& g, int i, int j) const {
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
        q.law = law_of_(g.body[static_cast<std::size_t>(i)], g.body[static_cast<std::size_t>(j)]);
        return q;
    }
    bool near_wall(const Group& g, int i, int a, int far) const {
        const Body& b = bodies_[static_cast<std::size_t>(g.body[static_cast<std::size_t>(i)])];
        const double x = b.position[static_cast<std::size_t>(a)];
        return (far ? box_.edge[static_cast<std::size_t>(a)] - x : x) < b.radius + travel();
    }
    Touching<Law> wall_of(const Group& g, int i, int a, int far) const {
        const auto s = static_cast<std::size_t>(a);
        Touching<Law> q{};
        q.first = i;
        q.second = -1;
        q.axis = a;
        q.side = far ? -1.0 : 1.0;
        q.wall = (far ? box_.edge[s] : 0.0) - g.origin[s];
        q.reach = g.before.members[static_cast<std::size_t>(i)].radius;
        q.mass = g.before.members[static_cast<std::size_t>(i)].mass;
        q.law = law_of_(g.body[static_cast<std::size_t>(i)], -1);
        return q;
    }

    // How far a member may go while its group lasts.
    double travel() const { return 0.25 * smallest_; }

    double horizon_of(const Cluster<Law>& c) const {
        double longest = 0.0;
        for (const Touching<Law>& q : c.pairs)
            if (q.touch == Touch::closed)
                longest = math::max(
                    longest, 1.5 * q.law.duration(math::max(q.impact_speed, 1e-3 * c.speed()), q.mass));
        const double farthest = travel() / c.speed();
        return longest > 0.0 ? math::min(longest, farthest) : farthest;
    }

    // The parabolas of the members, and how far they leave them. Returns whether the cells allow it.
    bool margins(Group& g) {
        const double span = g.after.time;
        const std::size_t n = g.body.size();
        const int index = static_cast<int>(&g - groups_.data());
        bool fits = true;
        for (std::size_t m = 0; m < n; ++m) {
            Body& b = bodies_[static_cast<std::size_t>(g.body[m])];
            b.group = index;
            b.end = now_ + span;
            if (span == 0.0) continue;
            busy(g, index, m, g.after.members[m], span, 0.0);
            const Vector3& x0 = g.before.members[m].position;
            double margin = 0.0, last = 0.0, last_rate = 0.0, last_time = 0.0;
            for (const Knot& k : g.after.trace) {
                double off = 0.0, rate = 0.0;
                for (std::size_t a = 0; a < 3; ++a) {
                    const double t = k.time, at = x0[a] + t * (b.velocity[a] + 0.5 * t * box_.gravity[a]);
                    const double e = k.state[3 * m + a] - at;
                    const double d = k.state[3 * (n + m) + a] - (b.velocity[a] + t * box_.gravity[a]);
                    off += e * e;
                    rate += d * d;
                }
                off = math::sqrt(off);
                rate = math::sqrt(rate);
                const double bulge = 0.26 * (k.time - last_time) * math::max(rate, last_rate);
                margin = math::max(margin, math::max(off, last) + bulge);
                last = off;
                last_rate = rate;
                last_time = k.time;
            }
            b.margin = 1.01 * margin;
            fits = fits && b.margin <= slack_;
        }
        return fits;
    }
};

}  // namespace hardlimit::particles
