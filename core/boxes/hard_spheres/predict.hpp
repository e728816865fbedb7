// Prediction of a particle's next events: collisions, walls, cell crossings.
#pragma once
#include "../queue/self_event.hpp"
#include "collision_search.hpp"
#include "last_contacts.hpp"

namespace hardlimit::boxes::spheres {

// The path of a particle since its last collision, for next_self_event(). A fall is followed from now on: a face
// crossed on the way up must not be found again. A moving wall is rare and kept apart, so that the rest is inlined.
template <int d, bool mixed>
struct Flight {
    const Particles<d, mixed>& particles;
    const LastContacts<d>& contacts;
    u32 i;
    const Setting& setting = particles.setting;
    const Particle<d>& path = particles.paths[i];
    double radius = particles.radius(i);
    static constexpr int axes = d;

    bool falls(int) const { return setting.falls(); }
    bool meets_walls() const { return true; }
    bool walls_move(int axis) const { return setting.grows() || setting.box.has_moving_walls(axis); }
    AxisState at(int axis, double time) const {
        const double since = time - path.time;
        return {since, position_after(path, axis, since, setting.box),
                velocity_after(path, axis, since, setting.box)};
    }
    AxisState at_present(int axis) const { return at(axis, particles.now); }
    AxisState from(int axis, bool high, bool wall) const {
        if (setting.falls()) return falling(axis, high, wall);
        return {0.0, path.position[axis], path.velocity[axis]};
    }
    AxisState falling(int axis, bool high, bool wall) const {
        return at(axis, wall ? contacts.wall_blocked_until(i, WallId::at(axis, high), particles.now)
                             : particles.now);
    }
    HL_FN_APART double until_wall(const Wall& wall, double end) const {
        const int axis = wall.id.axis();
        if (setting.grows()) {
            const double touch = radius * setting.growth.at(path.time), out = -wall.inward();
            return time_below(touch + out * path.position[axis],
                              radius * setting.growth.rate + out * path.velocity[axis], wall.start);
        }
        const double begin = contacts.wall_blocked_until(i, wall.id, particles.now);
        const AxisState s = at(axis, begin);
        return s.since +
               wall_contact_time(wall, begin, s.x, s.v, setting.box.gravity[axis], radius, end - s.since);
    }
};

// Writes the events to Particles::pending.
template <int d, bool mixed>
class Predictor {
public:
    Predictor(Particles<d, mixed>& particles, const CellAssignment<d, mixed>& assignment,
              const LastContacts<d>& contacts, const hardlimit_abi::TouchKernels& kernels)
        : particles_(particles),
          assignment_(assignment),
          contacts_(contacts),
          search_(particles, assignment, kernels) {}

    // Predicts all events of a particle. It does not collide with `except` as long as they touch.
    void predict(u32 i, u32 except) {
        PendingEvents& e = particles_.pending[i];
        const int own = assignment_.level(i);
        const Place<d> at = assignment_.cells().place(own, e.cell);
        NextCollision next = search_.begin(i, except);
        search_.search_around(next, own, at);
        e.pair_time = math::infinity;
        e.partner = no_particle;
        if constexpr (mixed)
            if (own > 0) particles_.rescans[i] = search_.search_finer(next, own);
        store(next);
        predict_self_event(i, at);
    }
    // The same for a particle that has entered the cell `at`; its pending collision stays.
    void predict_beyond(u32 i, const Place<d>& at, int axis, int step, u32 except) {
        NextCollision next = search_.begin(i, except);
        search_.search_beyond(next, assignment_.level(i), at, axis, step);
        store(next);
        predict_self_event(i, at);
    }
    void predict_self_event(u32 i, const Place<d>& at) {
        PendingEvents& e = particles_.pending[i];
        const int own = assignment_.level(i);
        const NextSelfEvent next =
            next_self_event(particles_.box, assignment_.cells(), own, at, particles_.now,
                            Flight<d, mixed>{particles_, contacts_, i});
        e.own_time = math::max(particles_.now, particles_.paths[i].time + next.in);
        e.own = static_cast<u32>(next.which) & 15u;
        if constexpr (mixed)
            if (own > 0 && particles_.rescans[i] < e.own_time) {
                e.own_time = particles_.rescans[i];
                e.own = static_cast<u32>(SelfEvent::rescan) & 15u;
            }
    }
    std::size_t bytes() const { return search_.bytes(); }

private:
    Particles<d, mixed>& particles_;
    const CellAssignment<d, mixed>& assignment_;
    const LastContacts<d>& contacts_;
    CollisionSearch<d, mixed> search_;

    // Stores the collision if it is earlier than the one that is pending.
    void store(const NextCollision& next) {
        PendingEvents& e = particles_.pending[next.id];
        const double time = particles_.now + next.in;
        if (next.partner == no_particle || time > e.pair_time) return;
        if (time == e.pair_time && e.partner != no_particle &&
            particles_.original_index[e.partner] < particles_.original_index[next.partner])
            return;
        e.pair_time = time;
        e.partner = next.partner;
        e.partner_count = particles_.collisions(next.partner);
    }
};

}  // namespace hardlimit::boxes::spheres
