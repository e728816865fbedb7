// Contacts of finite duration as equivalent collisions: the path of each particle after the contact, a straight line or
// at a wall a parabola, is extrapolated back to the instant of touch, and the particle is moved there.
#pragma once
#include "cell_assignment.hpp"
#include "collision_log.hpp"
#include "last_contacts.hpp"
#include "rules/rule.hpp"

namespace hardlimit::boxes::spheres {

// Two particles at touch, at the present positions and velocities.
template <int d>
struct Touch {
    u32 i, j;
    double r[d], v[d];  // position and velocity of the image of j that i touches, relative to i [m], [m/s]
    double distance, speed;  // |r| [m], speed of approach [m/s]
    double image_velocity;   // of that image, on which a sheared boundary does work [m/s]

    // Returns the square of the tangential velocity.
    double tangential(double (&across)[d]) const {
        double square = 0.0;
        for (int k = 0; k < d; ++k) {
            across[k] = v[k] + speed / distance * r[k];
            square += across[k] * across[k];
        }
        return square;
    }
};

// Arrival of a particle at a wall, in the frame of the wall.
struct WallArrival {
    double speed;                  // of the particle, where it is found [m/s]
    double gained = 0.0;           // by gravity from there to the surface [J/kg]
    double surface_speed = speed;  // speed at the surface [m/s]
};

// What friction adds to the equivalent collision of a particle with a wall: velocity, shift, energy lost.
template <int d>
struct Sliding {
    double velocity[d] = {}, shift[d] = {}, lost = 0.0;
};

template <int d, bool mixed>
class SoftContacts {
public:
    SoftContacts(Particles<d, mixed>& particles, Totals<d, mixed>& totals, CellAssignment<d, mixed>& cells,
                 LastContacts<d>& contacts)
        : particles_(particles), totals_(totals), cells_(cells), contacts_(contacts) {}

    // Gives both particles their paths after the contact.
    //
    // Virial: d/dt (m r⊗v) = m v⊗v + r⊗F, with the effective mass m. The equivalent collision takes the pair from r⊗v
    // to (r + shift)⊗v' at the instant of touch, and the states after the contact are exact. So the virial
    //   W = m ((r + shift)⊗v' − r⊗v)
    // plus the time integral of m v⊗v along the straight paths is exact over the whole contact. W is symmetric, since
    // the angular momentum is conserved; with friction its symmetric part counts. If a third body takes part, W is as
    // inexact as the states.
    CollisionResult of_pair(const Touch<d>& t, const PairGeometry& pair, const SoftContact& contact) {
        const EquivalentCollision& end = contact.collision;
        double across[d];
        const double square = t.tangential(across), tangential = math::sqrt(square);
        double change[d], shift[d];
        for (int k = 0; k < d; ++k) {
            const double normal = t.r[k] / t.distance,
                         along = tangential > 0.0 ? across[k] / tangential : 0.0;
            change[k] = end.normal_velocity * normal + end.tangential_velocity * along - t.v[k];
            shift[k] = end.normal_shift * normal + end.tangential_shift * along;
        }
        const double before = dot(t.v, t.v), after = end.normal_velocity * end.normal_velocity +
                                                     end.tangential_velocity * end.tangential_velocity;
        displace(t, pair, change, shift, contact.duration);
        // Angular momentum is conserved: at equal distances the tangential speed is the same.
        return {math::sqrt(math::max(0.0, after - square)), 0.5 * pair.effective_mass * (before - after)};
    }
    // The same with friction.
    CollisionResult of_rough_pair(const Touch<d>& t, const PairGeometry& pair, const TurningContact& end) {
        double change[d], shift[d], after = 0.0, separation = 0.0;
        for (std::size_t k = 0; k < d; ++k) {
            change[k] = end.velocity[k] - t.v[k];
            shift[k] = end.shift[k] - end.duration * end.velocity[k];
            after += end.velocity[k] * end.velocity[k];
            separation += end.velocity[k] * end.normal[k];
        }
        displace(t, pair, change, shift, end.duration);
        return {separation, 0.5 * pair.effective_mass * (dot(t.v, t.v) - after)};
    }
    // The same for a particle at a wall, in the frame of the wall. pressing: acceleration towards the wall. The
    // acceleration of the wall is taken as constant during the contact. The parabola of the equivalent
    // collision is in the frame of the wall; the flight after the contact is one in the laboratory. An oscillating wall
    // therefore needs the state at the end, extrapolated back there.
    // `sliding`: motion along the wall by friction.
    CollisionResult at_wall(u32 i, const Wall& wall, const WallArrival& arrival, double pressing,
                            const SoftContact& contact, const Sliding<d>& sliding = {}) {
        const EquivalentCollision& end = contact.collision;
        const int axis = wall.id.axis();
        const double now = particles_.now, g = particles_.box.gravity[axis];
        const double away = wall.inward(), m = particles_.mass(i);
        double change[d], shift[d];
        std::copy_n(sliding.velocity, d, change);
        std::copy_n(sliding.shift, d, shift);
        const double speed = arrival.surface_speed;
        change[axis] = away * (end.normal_velocity + arrival.speed);
        shift[axis] = away * end.normal_shift;
        const double lost = 0.5 * m * (speed - end.normal_velocity) * (speed + end.normal_velocity);
        const double dissipated = lost - m * pressing * end.normal_shift;
        double work = m * change[axis] * wall.velocity(now);
        if (wall.motion.oscillates()) {
            const double t = contact.duration, before = particles_.paths[i].velocity[axis];
            const double opening = end.normal_velocity - pressing * t;
            const double beyond = end.normal_shift + t * (end.normal_velocity - 0.5 * pressing * t);
            const double after = wall.velocity(now + t) + away * opening - g * t;
            const double moved = wall.position(now + t) - wall.position(now);
            change[axis] = after - before;
            shift[axis] = moved + away * beyond - t * (after + 0.5 * g * t);
            work = 0.5 * m * change[axis] * (after + before) - m * (g * shift[axis] + arrival.gained) +
                   dissipated;
        }
        const double separation = math::sqrt(math::max(0.0, speed * speed - 2.0 * dissipated / m));
        totals_.so_far.add_wall(wall.id, m * away * change[axis], work, dissipated + sliding.lost);
        displace(i, 1.0, change, shift);
        contacts_.add(i, wall.id, now, contact.duration);
        return {separation, dissipated + sliding.lost};
    }
    // The pair touches, without a collision.
    void touch(u32 i, u32 j) { contacts_.touch(i, j, particles_.now); }

private:
    Particles<d, mixed>& particles_;
    Totals<d, mixed>& totals_;
    CellAssignment<d, mixed>& cells_;
    LastContacts<d>& contacts_;

    void displace(const Touch<d>& t, const PairGeometry& pair, const double (&change)[d],
                  const double (&shift)[d], double duration) {
        double departing[d];
        for (int k = 0; k < d; ++k) departing[k] = t.v[k] + change[k];
        Accumulators<d>& sums = totals_.so_far;
        sums.add_virial(pair.effective_mass, t.r, change);
        sums.add_virial(pair.effective_mass, shift, departing);
        if (t.image_velocity != 0.0)
            sums.shear_work.add(-(pair.effective_mass * change[0]) * t.image_velocity);
        const double whole = particles_.mass(t.i) + particles_.mass(t.j);
        displace(t.i, -particles_.mass(t.j) / whole, change, shift);
        displace(t.j, particles_.mass(t.i) / whole, change, shift);
        contacts_.add(t.i, t.j, particles_.now, duration);
    }
    void displace(u32 i, double share, const double (&velocity)[d], const double (&shift)[d]) {
        totals_.displace(i, share, velocity, shift);
        cells_.update(i);
    }
};

}  // namespace hardlimit::boxes::spheres
