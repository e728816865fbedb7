// Elastic collisions of growing particles, which make random packings (growth.hpp). They are counted, nothing else.
#pragma once
#include "observe.hpp"

namespace hardlimit::boxes::spheres {

template <int d, bool mixed>
class GrowingCollisions {
public:
    GrowingCollisions(Particles<d, mixed>& particles, Totals<d, mixed>& totals)
        : particles_(particles), totals_(totals) {}

    void collide(u32 i, u32 j) {
        Particle<d>&p = particles_.paths[i], &q = particles_.paths[j];
        particles_.advance_to_now(i);
        particles_.advance_to_now(j);
        double r[d], v[d];
        const double image_velocity = particles_.to_nearest_image(i, j, r);
        for (int k = 0; k < d; ++k) v[k] = q.velocity[k] - p.velocity[k];
        if (image_velocity != 0.0) v[0] += image_velocity;
        const double distance = math::sqrt(dot(r, r)), speed = -dot(r, v) / distance;
        const double rate = (particles_.radius(i) + particles_.radius(j)) * growth_.rate;
        const double gain = (speed + math::max(speed, separation * rate)) / distance;
        const double mi = particles_.mass(i), mj = particles_.mass(j);
        const double reduced = mixed ? effective(mi, mj) : 0.5 * mi;
        for (int k = 0; k < d; ++k) {
            const double impulse = reduced * gain * r[k];
            p.velocity[k] -= impulse / mi;
            q.velocity[k] += impulse / mj;
        }
        ++totals_.so_far.pairs;
    }
    void collide_with_wall(u32 i, const Wall& wall) {
        Particle<d>& p = particles_.paths[i];
        const int axis = wall.id.axis();
        const double away = wall.inward(), now = particles_.now, radius = particles_.radius(i);
        particles_.advance_to_now(i);
        p.position[axis] = wall.position(now) + away * (radius * growth_.at(now));
        p.velocity[axis] = away * math::max(math::abs(p.velocity[axis]), separation * radius * growth_.rate);
        ++totals_.so_far.walls;
    }

private:
    // After a collision, growing particles separate at least this many times as fast as their radii grow.
    static constexpr double separation = 1.5;

    Particles<d, mixed>& particles_;
    Totals<d, mixed>& totals_;
    const Growth& growth_ = particles_.setting.growth;
};

}  // namespace hardlimit::boxes::spheres
