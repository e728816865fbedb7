// The forces of one step: who touches, what pushes whom, and what begins or ends between two steps.
#pragma once
#include <algorithm>
#include <cstdint>
#include <vector>

#include "../common/pair_laws.hpp"
#include "../neighbours/neighbour_list.hpp"
#include "schedule.hpp"
#include "touches.hpp"

namespace hardlimit::boxes::steps {

// An impulse over the mass, beside the accelerations [m/s].
struct Jolt {
    std::uint32_t body;
    Four change;
};

// A share of the bodies, and everything that one task writes when it works on their pairs.
template <class Law>
struct alignas(64) Slab {
    std::uint32_t first_body, last_body, first_cell, last_cell;
    std::vector<Pair> pairs;
    std::vector<AtWall> walls;
    std::vector<std::int32_t> touch_of_pair, touch_of_wall;  // place in touches, −1: none
    std::vector<Touch<Law>> touches;
    std::vector<std::int32_t> vacant, vacated;  // places in touches: free, and free after this step
    std::vector<std::uint32_t> pushed_here, pushed_beyond;  // bodies of this slab and of the next
    std::vector<Jolt> jolts;                                // of both
    std::vector<Change> changes;
    double dissipated = 0.0, virial = 0.0;  // [J] since the list was made
    double farthest = 0.0, fastest = 0.0;   // squares [m²], [m²/s²]
    double largest_compression = 0.0;       // since the list was made, over the smaller radius
    std::int32_t deepest[2] = {-1, -1};     // whose it was: as first and second of a Record

    bool holds(std::uint32_t body) const { return body >= first_body && body < last_body; }
    void clear_step() { pushed_here.clear(), pushed_beyond.clear(), jolts.clear(); }
    template <class Archive>
    void exchange(Archive& archive) {
        archive(first_body), archive(last_body), archive(first_cell), archive(last_cell);
        archive(pairs), archive(walls), archive(touch_of_pair), archive(touch_of_wall);
        archive(touches), archive(vacant), archive(pushed_here), archive(pushed_beyond);
        archive(dissipated), archive(virial);
        archive(largest_compression), archive(deepest);
    }
};

// Where a slab of one thread reaches into one of another thread: copies of the places there that its pairs need, by
// the owner. The places themselves stay in the owner's cache.
struct alignas(apart) Border {
    bool open = false;
    std::vector<std::uint32_t> bodies;
    Records<Four> place;  // of these
    // [pairs] the second body: among these if marked, or among all.
    std::vector<std::uint32_t> seen;

    static constexpr std::uint32_t mark = 0x80000000u;

    // `next` owns first … last − 1.
    void set(const std::vector<Pair>& pairs, std::uint32_t first, std::uint32_t last, const Bodies& of) {
        std::vector<std::uint32_t> where(last - first);
        const auto beyond = [&](Pair p) { return p.second() >= first && p.second() < last; };
        for (const Pair p : pairs)
            if (beyond(p)) where[p.second() - first] = mark;
        bodies.clear(), seen.clear();
        for (std::uint32_t i = first; i < last; ++i) {
            if (where[i - first] == 0) continue;
            where[i - first] |= static_cast<std::uint32_t>(bodies.size());
            bodies.push_back(i);
        }
        for (const Pair p : pairs) seen.push_back(beyond(p) ? where[p.second() - first] : p.second());
        place.resize(bodies.size());
        update(of);
        open = true;
    }
    void update(const Bodies& of) {
        for (std::size_t k = 0; k < bodies.size(); ++k) place[k] = of.place[bodies[k]];
    }
};

// The instant at which forces are asked for.
struct Instant {
    std::uint64_t step;  // counts on for ever, from 2
    double time;         // [s]
    double h;            // the step that led here [s]
    double ahead;        // how far velocities are behind [s]: h/2, at the start 0
    double weight;       // the share of time that this step stands for in integrals [s]: h, at an end h/2
    bool closing;        // the velocities are wanted at this instant
};

template <class Law>
class Forces {
public:
    Forces(const Box& box, const Grid& grid, Bodies& bodies, const PairLaws<Law>& laws, Instant now)
        : box_(box), grid_(grid), bodies_(bodies), laws_(laws), now_(now) {}

    void of(Slab<Law>& slab, const Border& border) {
        slab.clear_step();
        if (border.open)
            of_pairs(slab, [here = numbers(bodies_.place), beyond = numbers(border.place),
                            seen = border.seen.data()](std::size_t k, Pair) {
                return (seen[k] & Border::mark ? beyond : here) + 4 * std::size_t{seen[k] & ~Border::mark};
            });
        else
            of_pairs(slab, [here = numbers(bodies_.place)](std::size_t, Pair p) {
                return here + 4 * std::size_t{p.second()};
            });
        of_walls(slab);
    }

    // What the half step after an instant with known forces misses of contacts that were new then.
    static void go_on(Slab<Law>& slab, const Bodies& bodies, double h) {
        slab.jolts.clear();
        for (const Touch<Law>& t : slab.touches) {
            if (t.at_first == nobody) continue;
            const bool pair = t.at_second != nobody;
            double impulse = 0.0;
            if (t.fresh && t.force > 0.0) {
                const auto force = force_sets_in(t.law, t.onset.rate);
                impulse = 0.5 * h * t.force + force.missed(t.onset, h) - force.reached(t.onset, t.force);
                jolt(slab, bodies, t, impulse);
            }
            if (pair) slab.virial += (0.5 * h * t.force + impulse) * t.distance;
        }
    }

private:
    const Box& box_;
    const Grid& grid_;
    Bodies& bodies_;
    const PairLaws<Law>& laws_;
    Instant now_;

    // Two bodies as they are seen from the first: the second, or the wall.
    struct Meeting {
        std::uint32_t first, second;  // second: none at a wall
        std::int32_t number;          // of the second, or the wall's
        std::uint32_t image;
        Four normal;
        double distance, reach;  // reach: at touch [m]
        Four relative;           // velocity of the second [m/s], `ahead` before now
        Four acceleration;       // of the second, at the step before [m/s²]
        double compression() const { return reach - distance; }
    };

    // place_of(k, p): of the second body of pair k.
    template <class PlaceOf>
    void of_pairs(Slab<Law>& slab, const PlaceOf& place_of) {
        const double* place = numbers(bodies_.place);
        const Four* shift = grid_.shifts();
        const std::size_t count = slab.pairs.size();
        for (std::size_t k = 0; k < count; ++k) {
            const Pair p = slab.pairs[k];
            const double *a = place + 4 * std::size_t{p.first}, *b = place_of(k, p);
            const Four& s = shift[p.image()];
            const double x = b[0] - a[0] + s[0], y = b[1] - a[1] + s[1], z = b[2] - a[2] + s[2];
            const double reach = a[3] + b[3], squared = (x * x + y * y) + z * z;
            if (squared < reach * reach || slab.touch_of_pair[k] >= 0) [[unlikely]]
                meet_body(slab, slab.touch_of_pair[k], p, four(x, y, z, 0.0), reach);
        }
    }
    void of_walls(Slab<Law>& slab) {
        for (std::size_t k = 0; k < slab.walls.size(); ++k) {
            const AtWall w = slab.walls[k];
            const Four place = bodies_.place[w.body];
            const double x = place[static_cast<int>(w.wall / 2)];
            const double distance = w.wall % 2 == 0 ? x : box_.edge[w.wall / 2] - x;
            if (distance < place[3] || slab.touch_of_wall[k] >= 0)
                meet_wall(slab, slab.touch_of_wall[k], w, distance);
        }
    }

    HL_FN_APART void meet_body(Slab<Law>& slab, std::int32_t& slot, Pair p, Four apart, double reach) {
        const std::uint32_t i = p.first, j = p.second();
        const double distance = math::sqrt(dot(apart, apart));
        const Four normal = apart * (1.0 / distance), v = bodies_.motion[j] - bodies_.motion[i];
        const Four a = bodies_.push[j].preceding(now_.step) - bodies_.push[i].preceding(now_.step);
        const auto number = static_cast<std::int32_t>(bodies_.label[j].number);
        meet(slab, slot, {i, j, number, p.image(), normal, distance, reach, v, a}, apart);
    }
    HL_FN_APART void meet_wall(Slab<Law>& slab, std::int32_t& slot, AtWall w, double distance) {
        const int axis = static_cast<int>(w.wall / 2);
        Four normal{};
        normal[axis] = w.wall % 2 == 0 ? -1.0 : 1.0;
        const Four a = -bodies_.push[w.body].preceding(now_.step) - pull(box_);
        const std::int32_t number = -1 - static_cast<std::int32_t>(w.wall);
        const Meeting m = {w.body,
                           nobody,
                           number,
                           no_image,
                           normal,
                           distance,
                           bodies_.place[w.body][3],
                           -bodies_.motion[w.body],
                           a};
        meet(slab, slot, m, normal * distance);
    }

    void meet(Slab<Law>& slab, std::int32_t& slot, const Meeting& m, Four apart) {
        const bool fresh = slot < 0 && now_.ahead > 0.0;
        if (slot < 0) {
            slot = vacancy(slab);
            slab.touches[static_cast<std::size_t>(slot)] = begin(m, apart);
        }
        Touch<Law>& t = slab.touches[static_cast<std::size_t>(slot)];
        // The others' forces are those of the step before, its own is not known yet.
        const double own = inverse_mass(m) * now_.ahead, compression = m.compression();
        const double rate = own * t.force - dot(m.normal, m.relative + m.acceleration * now_.ahead);
        const Strength p = fresh ? strength_at_onset(t.law, compression, rate, inverse_mass(m), t.onset)
                                 : strength_of(t.law, compression, rate, own);
        const double margin = compression - math::max(0.0, t.law.slack(p.rate).depth);
        if ((p.force > 0.0) != t.closed) {
            note(slab, slot, t, m, margin, fresh);
            t.closed = p.force > 0.0;
        }
        if (now_.ahead > 0.0)
            slab.dissipated += fresh ? dissipated_at_onset(t.law, p, t.onset) : dissipated(t, p, m);
        t.at_first = m.first, t.at_second = m.second;
        t.normal = m.normal, t.distance = m.distance;
        t.margin = margin, t.fresh = fresh, t.compression = compression;
        static_cast<Strength&>(t) = p;
        note_depth(slab, t, m);
        act(slab, t);
        if (!(compression > 0.0)) {
            t.at_first = nobody;
            slab.vacated.push_back(slot);
            slot = -1;
        }
    }

    double inverse_mass(const Meeting& m) const {  // of the relative motion
        return bodies_.motion[m.first][3] + (m.second != nobody ? bodies_.motion[m.second][3] : 0.0);
    }
    // Since the last step; t is as it was then. With the forces of others the rate of that step is known only now, and
    // what was dissipated until then is put right.
    double dissipated(Touch<Law>& t, const Strength& p, const Meeting& m) const {
        Strength before = t;
        if (!t.fresh) before.rate = -dot(t.normal, m.relative - m.acceleration * now_.ahead);
        const double late = 0.5 * t.damped * (before.rate - t.rate);
        if (!(m.compression() > 0.0)) return late + dissipated_at_end(t.law, before, t.compression);
        t.damped = damped(before, p, now_.h);
        if (t.fresh) t.damped += missed_damping(t.law, before, t.onset, now_.h);
        return late + dissipated_between(before, p, now_.h, inverse_mass(m), t.damped);
    }

    void note_depth(Slab<Law>& slab, const Touch<Law>& t, const Meeting& m) const {
        const double first = bodies_.place[m.first][3];
        const double part = t.compression / (m.second == nobody ? first : math::min(first, m.reach - first));
        if (!(part > slab.largest_compression)) return;
        slab.largest_compression = part;
        slab.deepest[0] = t.first, slab.deepest[1] = t.second;
    }

    static std::int32_t vacancy(Slab<Law>& slab) {
        if (slab.vacant.empty()) {
            slab.touches.emplace_back();
            return static_cast<std::int32_t>(slab.touches.size()) - 1;
        }
        const std::int32_t slot = slab.vacant.back();
        slab.vacant.pop_back();
        return slot;
    }

    // Bodies that overlap for the first time. Between the steps they moved straight; where they began to touch
    // follows from the compressions at both, the rate there from the curvature of the distance.
    Touch<Law> begin(const Meeting& m, Four apart) const {
        Touch<Law> t{};
        t.first = static_cast<std::int32_t>(bodies_.label[m.first].number);
        t.second = m.number;
        t.news = -1;
        t.law = laws_(t.first, m.second == nobody ? -1 : m.number);
        if (m.second != nobody) t.turns = unfolded(Pair::of(m.first, m.second, m.image), bodies_.label);
        t.begin = now_.time;
        t.impact_speed = -dot(m.normal, m.relative);
        if (!(now_.ahead > 0.0)) return t;
        const Four before = apart - m.relative * now_.h;
        const double was = m.second == nobody ? dot(before, m.normal) : math::sqrt(dot(before, before));
        const double grown = math::max(was - m.distance, 1e-300);
        const double share = math::min(1.0, m.compression() / grown);
        t.onset = {share * now_.h, grown / now_.h};
        t.begin -= t.onset.since;
        t.impact_speed = math::max(0.0, rate_at(t.begin, m, grown, 0.0));
        if (t.impact_speed > 0.0) t.onset.rate = t.impact_speed;
        return t;
    }

    // dξ/dt [m/s] at a time between the last two steps, ξ having grown by `grown`. `own` [N]: the force of this
    // contact at the step before, which counts no more.
    double rate_at(double time, const Meeting& m, double grown, double own) const {
        const bool pair = m.second != nobody;
        const double along = dot(m.normal, m.relative);
        const double turning = pair ? (dot(m.relative, m.relative) - along * along) / m.distance : 0.0;
        const double bend = own * inverse_mass(m) - dot(m.normal, m.acceleration) - turning;
        return grown / now_.h + bend * (time - (now_.time - 0.5 * now_.h));
    }

    // A contact begins or ends. Other than at touch that is where the margin passes through zero.
    void note(Slab<Law>& slab, std::int32_t slot, Touch<Law>& t, const Meeting& m, double margin,
              bool fresh) const {
        const bool begins = !t.closed, known = begins && (fresh || !(now_.ahead > 0.0));
        const double span = t.margin - margin;
        const double share = span != 0.0 ? math::clamp(t.margin / span, 0.0, 1.0) : 1.0;
        const double time = known ? t.begin : now_.time - (1.0 - share) * now_.h;
        const double rate =
            known ? t.impact_speed : rate_at(time, m, m.compression() - t.compression, t.force);
        if (begins) t.begin = time, t.impact_speed = rate;
        const std::int32_t since = begins ? -1 : t.news;
        if (begins) t.news = static_cast<std::int32_t>(slab.changes.size());
        slab.changes.push_back({t, now_.step, time, slot, begins, -rate, since});
    }

    void act(Slab<Law>& slab, const Touch<Law>& t) {
        double impulse = 0.0;
        if (t.fresh && t.force > 0.0) {
            const auto force = force_sets_in(t.law, t.onset.rate);
            impulse = now_.closing ? force.reached(t.onset, t.force) - now_.weight * t.force
                                   : force.missed(t.onset, now_.h);
            jolt(slab, bodies_, t, impulse);
        }
        if (t.at_second != nobody) slab.virial += (now_.weight * t.force + impulse) * t.distance;
        if (!(t.force > 0.0)) return;
        push(slab, t.at_first, t.normal * (-t.force * bodies_.motion[t.at_first][3]));
        if (t.at_second != nobody)
            push(slab, t.at_second, t.normal * (t.force * bodies_.motion[t.at_second][3]));
    }
    void push(Slab<Law>& slab, std::uint32_t body, Four acceleration) {
        if (bodies_.push[body].add(now_.step, acceleration))
            (slab.holds(body) ? slab.pushed_here : slab.pushed_beyond).push_back(body);
    }
    static void jolt(Slab<Law>& slab, const Bodies& bodies, const Touch<Law>& t, double impulse) {
        slab.jolts.push_back({t.at_first, t.normal * (-impulse * bodies.motion[t.at_first][3])});
        if (t.at_second != nobody)
            slab.jolts.push_back({t.at_second, t.normal * (impulse * bodies.motion[t.at_second][3])});
    }
};

}  // namespace hardlimit::boxes::steps
