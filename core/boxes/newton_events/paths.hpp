// The bodies: their paths, which are parabolas between events, and the events and groups that they have.
#pragma once
#include <algorithm>
#include <vector>

#include "../common/newton_setting.hpp"
#include "records.hpp"

namespace hardlimit::boxes::events {

// Bodies are numbered by their place in memory, where neighbours in space are neighbours. A body is free, or busy as a
// member of a group.
template <class Law>
class Paths {
public:
    const Box& box;
    double now = 0.0;  // [s]
    // A path is a parabola that starts at `time`, in the frame of the cell; the radius includes the safety radius.
    Records<Particle<3>> particles;
    Records<BodyEvents> pending;
    std::vector<Rotation> rotations;  // with friction, otherwise empty; only contacts change spins

    explicit Paths(const NewtonSetting& setting) : box(setting.box), laws_(setting.laws<Law>()) {}

    // Stores the bodies in this order: body order[i] of the user becomes body i.
    void sort_in(const NewtonSetting& setting, const System& s, const std::vector<u32>& order) {
        particles.resize(order.size());
        pending.resize(order.size());
        laws_.reorder(order);
        for (std::size_t i = 0; i < order.size(); ++i) {
            setting.in_three(s.position, order[i], particles[i].position);
            setting.in_three(s.velocity, order[i], particles[i].velocity);
            particles[i].time = 0.0;
            particles[i].radius = laws_.radius(i);
            pending[i].original_index = order[i];
        }
        if constexpr (FrictionalLaw<Law>) {
            rotations.resize(order.size());
            for (std::size_t i = 0; i < order.size(); ++i) {
                rotations[i].inertia = setting.inertia(order[i]);
                if (s.angular_velocity)
                    std::copy_n(s.angular_velocity + 3 * order[i], 3, rotations[i].spin.begin());
            }
        }
    }
    // After reading a saved state: restores the order of the bodies' properties.
    void sort_properties() {
        std::vector<u32> order;
        for (const BodyEvents& e : pending) order.push_back(e.original_index);
        laws_.reorder(order);
    }

    int size() const { return static_cast<int>(particles.size()); }
    double radius(int i) const { return laws_.radius(static_cast<std::size_t>(i)); }
    double mass(int i) const { return laws_.mass(static_cast<std::size_t>(i)); }
    const PairLaws<Law>& laws() const { return laws_; }
    auto by_original_index() const {
        return [this](auto id) { return pending[id].original_index; };
    }

    bool free(int i) const { return pending[i].group < 0; }
    bool clustered(int i) const { return pending[i].clustered; }

    Vector3 position(int i, double t) const {
        const Particle<3>& p = particles[i];
        const double after = t - p.time;
        return {position_after(p, 0, after, box), position_after(p, 1, after, box),
                position_after(p, 2, after, box)};
    }
    Vector3 velocity(int i, double t) const {
        const Particle<3>& p = particles[i];
        const double after = t - p.time;
        return {velocity_after(p, 0, after, box), velocity_after(p, 1, after, box),
                velocity_after(p, 2, after, box)};
    }

    // Starts a new parabola of a free body at the current time.
    void restart(int i) {
        if (!free(i)) return;
        advance(particles[i], now, box);
        ++pending[i].count;
    }
    // Makes a body busy until a time.
    void join(int i, int group, bool first, bool clustered, double end) {
        BodyEvents& e = pending[i];
        e.group = group;
        e.end = end;
        e.first = first;
        e.clustered = clustered;
    }
    // Frees a body, which stays on its path.
    void release(int i) {
        BodyEvents& e = pending[i];
        e.group = -1;
        e.end = math::infinity;
        e.first = e.clustered = false;
        particles[i].radius = radius(i);
    }
    // Frees a body at a position and velocity at the current time.
    void release(int i, const Vector3& position, const Vector3& velocity) {
        Particle<3>& p = particles[i];
        std::copy_n(position.data(), 3, p.position);
        std::copy_n(velocity.data(), 3, p.velocity);
        p.time = now;
        release(i);
    }
    // Sets a radius above the own one: with the safety radius, and with the overlap that counts as rounding error.
    void set_safety_radius(int i, double safety_radius) {
        particles[i].radius = (radius(i) + safety_radius) * (1.0 + rounding_of_touch);
    }

    // Gives all bodies, which must be free, new velocities at the current time: n·d values by original index. Returns
    // what this adds to the work of the shear [J]: beyond a sheared side, the work of the crossing is counted in
    // advance, and depends on the velocity.
    double set_velocities(const double* velocity) {
        const auto d = static_cast<std::size_t>(box.dimension);
        double work = 0.0;
        for (int i = 0; i < size(); ++i) {
            restart(i);
            Particle<3>& p = particles[i];
            const double before = p.velocity[0];
            std::copy_n(velocity + d * std::size_t{pending[i].original_index}, d, p.velocity);
            p.velocity[0] -= box.image(pending[i].image_flags, now).velocity[0];
            if (box.is_sheared())
                work += box.turns(p.position[box.gradient], box.gradient) * box.image_velocity() *
                        (p.velocity[0] - before) * mass(i);
        }
        return work;
    }

    // The same for spins: 3 n values.
    void set_spins(const double* spin) {
        for (std::size_t i = 0; i < rotations.size(); ++i)
            std::copy_n(spin + 3 * std::size_t{pending[i].original_index}, 3, rotations[i].spin.begin());
    }

    std::size_t bytes() const {
        return particles.capacity() * sizeof(Particle<3>) + pending.capacity() * sizeof(BodyEvents) +
               rotations.capacity() * sizeof(Rotation);
    }

private:
    PairLaws<Law> laws_;
};

}  // namespace hardlimit::boxes::events
