// The last contact of each particle, under a rule with contacts of finite duration.
#pragma once
#include <utility>
#include <vector>

#include "particles.hpp"

namespace hardlimit::boxes::spheres {

template <int d>
class LastContacts {
public:
    u64 contacts = 0, third_body = 0;  // of these, contacts that a third body disturbed

    // Without particles under other rules.
    void begin(std::size_t n) { last_.assign(n, {}); }

    // Stores the contact of i with j, or with a wall. If a particle is hit before its last contact is over, a third
    // body takes part, which the rule does not describe; such contacts are counted.
    void add(u32 i, u32 j, double now, double duration) {
        count(now < last_[i].until || now < last_[j].until);
        set(i, j, now + duration);
    }
    void add(u32 i, WallId wall, double now, double duration) {
        Last& last = last_[i];
        const auto axis = static_cast<std::size_t>(wall.axis());
        count(now < last.until);
        last.until = last.wall_until[axis] = now + duration;
        last.partner = no_particle, last.wall[axis] = wall;
    }
    // The pair touches, without a collision.
    void touch(u32 i, u32 j, double now) { set(i, j, now); }

    // The particle with which this one must not collide, or no_particle: not before one of the two has another
    // collision, although their equivalent collision may leave them overlapping and approaching.
    u32 excluded_partner(u32 i) const {
        if (last_.empty()) return no_particle;
        const u32 j = last_[i].partner;
        return j != no_particle && last_[j].partner == i ? j : no_particle;
    }
    // Earliest time at which a particle may meet this wall: not before its contact with this wall is over. Until then,
    // the parabola of the equivalent collision may lie behind the wall and lead further into it, if gravity pulls the
    // particle off the wall (a ceiling that it just reaches).
    double wall_blocked_until(u32 i, WallId wall, double now) const {
        if (last_.empty()) return now;
        const Last& last = last_[i];
        const auto axis = static_cast<std::size_t>(wall.axis());
        return last.wall[axis] == wall ? math::max(now, last.wall_until[axis]) : now;
    }

    // Ends the contacts of a particle with walls now. Behind a wall, where the parabola of an equivalent collision may
    // lead, the particle is moved to its surface. Returns the energy that it gains there [J].
    template <bool mixed>
    double end_wall_contacts(Particles<d, mixed>& particles, u32 i) {
        const Box& box = particles.box;
        const double now = particles.now, radius = particles.radius(i);
        double gained = 0.0;
        for (int k = 0; k < d; ++k) {
            const WallId id = std::exchange(last_[i].wall[k], WallId{});
            if (!id || last_[i].wall_until[k] <= now) continue;
            const Wall wall = box.wall(id);
            double& x = particles.paths[i].position[k];
            if (!(wall.distance(x, now) < radius)) continue;
            const double surface = wall.position(now) + wall.inward() * radius;
            gained -= particles.mass(i) * box.gravity[k] * (surface - x);
            x = surface;
        }
        return gained;
    }
    // Lets a particle whose contact is over collide with the same partner again.
    void release(u32 i, double now) {
        if (last_[i].until <= now) last_[i].partner = no_particle;
    }

    // now_at[i]: new index of the particle with index i; from: its inverse.
    void reorder(const std::vector<u32>& from, const std::vector<u32>& now_at) {
        if (last_.empty()) return;
        permute(last_, from);
        for (Last& last : last_)
            if (last.partner != no_particle) last.partner = now_at[last.partner];
    }
    std::size_t bytes() const { return last_.capacity() * sizeof(Last); }
    template <class Archive>
    void exchange(Archive& a) {
        a(last_), a(contacts), a(third_body);
    }

private:
    // Contacts with walls of different axes are independent.
    struct Last {
        double until = -math::infinity;  // [s]
        u32 partner = no_particle;       // no_particle: a wall, or none yet
        WallId wall[d] = {};             // the wall met along each axis, if that contact was not cut short
        double wall_until[d] = {};       // end of that contact [s]
    };
    Records<Last> last_;

    void count(bool third) { ++contacts, third_body += third; }
    void set(u32 i, u32 j, double until) {
        last_[i] = {until, j};
        last_[j] = {until, i};
    }
};

}  // namespace hardlimit::boxes::spheres
