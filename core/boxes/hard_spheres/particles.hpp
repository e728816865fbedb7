// The particles: their paths since their last collisions, in one array per kind of data.
//
// Particles are sorted in memory by cell. Results do not depend on this order: sums and simultaneous events are ordered
// by the original index, the index in the user's arrays.
#pragma once
#include <algorithm>
#include <array>
#include <vector>

#include "../common/storage.hpp"
#include "setting.hpp"

namespace hardlimit::boxes::spheres {

// Sets records[i] = records[from[i]] in place, one cycle of the permutation after the other.
template <class T>
void permute(Records<T>& records, const std::vector<u32>& from) {
    std::vector<bool> done(from.size());
    for (u32 start = 0; start < from.size(); ++start) {
        if (done[start] || from[start] == start) continue;
        const T first = records[start];
        u32 at = start;
        for (; from[at] != start; at = from[at]) {
            records[at] = records[from[at]];
            done[at] = true;
        }
        records[at] = first;
        done[at] = true;
    }
}

// `mixed`: radii or masses differ.
template <int d, bool mixed>
class Particles {
public:
    const Setting& setting;
    const Box& box = setting.box;
    double now = 0.0;  // [s]
    // By index in memory.
    Records<Particle<d>> paths;
    Records<PendingEvents> pending;
    Records<std::array<int, d>> image_flags;  // how often each has left the box through a periodic side
    Records<u32> original_index;              // index in the user's arrays
    Records<double> rescans;                  // time of the next search for smaller particles [s]; or empty
    Records<Spin> spins;                      // empty without friction

    explicit Particles(const Setting& setting) : setting(setting) {}

    u32 size() const { return static_cast<u32>(paths.size()); }
    bool rotates() const { return !spins.empty(); }
    double mass(u32 i) const {
        if constexpr (mixed) return masses_[i];
        return setting.mass;
    }
    double radius(u32 i) const {
        if constexpr (mixed) return paths[i].radius;
        return setting.largest_radius;
    }
    u32 collisions(u32 i) const {
        if constexpr (mixed) return pending[i].count;
        return collisions_in(paths[i].radius);
    }
    void count_collision(u32 i) {
        if constexpr (mixed)
            ++pending[i].count;
        else
            paths[i].radius = increment_collision_count(paths[i].radius);
    }

    // Position [m] and velocity [m/s] now.
    double position(u32 i, int k) const { return position_after(paths[i], k, now - paths[i].time, box); }
    double velocity(u32 i, int k) const { return velocity_after(paths[i], k, now - paths[i].time, box); }
    void advance_to_now(u32 i) { boxes::advance(paths[i], now, box); }
    void wrap(u32 i, int axis, int turns) {
        Particle<d>& p = paths[i];
        box.wrap(p.position, p.velocity, image_flags[i], axis, turns, p.time);
    }
    // Gives a particle another velocity [m/s], that of its image outside of the box; it is advanced to now.
    void set_velocity(u32 i, const double* velocity) {
        const ImageMotion image = box.image(image_flags[i], now);
        for (int k = 0; k < d; ++k) paths[i].velocity[k] = velocity[k] - image.velocity[k];
        note_speed(paths[i].velocity);
    }
    // Vector from i to the image of j that i touches; both are advanced to now. Returns the velocity of this image
    // along the first axis [m/s].
    double to_nearest_image(u32 i, u32 j, double (&r)[d]) const {
        const Particle<d>&p = paths[i], &q = paths[j];
        for (int k = 0; k < d; ++k) r[k] = q.position[k] - p.position[k];
        const double image_velocity = box.to_nearest_layer(r, now);
        for (int k = 0; k < d; ++k) {
            const double edge = box.edge[k];
            if (math::abs(r[k]) < 0.499 * edge || !box.is_periodic(k)) continue;
            r[k] = box.minimum_image(r[k], k);
            // If both images may touch, the approaching one does.
            const double other = r[k] > 0.0 ? r[k] - edge : r[k] + edge;
            const double v = q.velocity[k] - p.velocity[k] + (k == 0 ? image_velocity : 0.0);
            if (math::abs(r[k]) > 0.499999 * edge && r[k] * v > 0.0) r[k] = other;
        }
        return image_velocity;
    }

    // Present speed in a frame that falls with gravity along the periodic axes, where speeds grow without bound.
    double frame_speed(const double* velocity) const {
        double square = 0.0;
        for (int k = 0; k < d; ++k) {
            const double v = velocity[k] - (box.is_periodic(k) ? box.gravity[k] * now : 0.0);
            square += v * v;
        }
        return math::sqrt(square);
    }
    // Bound on that speed for all particles, once note_speed() knows every velocity. Between walls a fall is limited by
    // the height of the box. The factor leaves time for moving walls.
    double speed_bound() const {
        double square = fastest_ * fastest_;
        for (int k = 0; k < d; ++k)
            if (box.has_walls(k)) {
                const bool moving = box.has_moving_walls(k);
                const double height = box.edge[k] + (moving ? 4.0 * box.farthest_wall(now) : 0.0);
                square += 2.0 * math::abs(box.gravity[k]) * height;
            }
        return math::sqrt(square);
    }
    void note_speed(const double* velocity) { fastest_ = math::max(fastest_, frame_speed(velocity)); }
    void note_present_speed(u32 i) {
        double v[d];
        for (int k = 0; k < d; ++k) v[k] = velocity(i, k);
        note_speed(v);
    }

    // Stores particle `from` of the system as particle i.
    void put(u32 i, const System& s, u32 from) {
        Particle<d>& p = paths[i];
        for (int k = 0; k < d; ++k) {
            const std::size_t at = std::size_t{from} * d + static_cast<std::size_t>(k);
            p.position[k] = s.position[at], p.velocity[k] = s.velocity[at];
        }
        p.time = 0.0;
        p.radius = mixed ? s.radius[from] : collision_count;
        if constexpr (mixed) masses_[i] = s.mass[from];
        if (rotates()) spins[i] = spin_of(s, from);
        original_index[i] = from;
        note_speed(p.velocity);
    }
    void resize(u32 n, bool rescan) {
        paths.resize(n);
        pending.resize(n);
        image_flags.resize(n, {});
        original_index.resize(n);
        if constexpr (mixed) masses_.resize(n);
        if (setting.rule.has_friction()) spins.resize(n);
        if (rescan) rescans.assign(n, math::infinity);
    }
    // now_at[i]: new index of the particle with index i; from: its inverse.
    void reorder(const std::vector<u32>& from, const std::vector<u32>& now_at) {
        permute(paths, from);
        permute(pending, from);
        permute(image_flags, from);
        permute(original_index, from);
        if (!masses_.empty()) permute(masses_, from);
        if (!rescans.empty()) permute(rescans, from);
        if (rotates()) permute(spins, from);
        for (PendingEvents& e : pending)
            if (e.partner != no_particle) e.partner = now_at[e.partner];
    }
    // Index in memory of each particle, by original index. Sums in this order do not depend on the storage.
    std::vector<u32> in_original_order() const {
        std::vector<u32> place(size());
        for (u32 i = 0; i < size(); ++i) place[original_index[i]] = i;
        return place;
    }
    void fetch(u32 i) const {
        prefetch(&paths[i]);
        if (setting.falls()) prefetch(&image_flags[i]);
        if constexpr (mixed) prefetch(&masses_[i]);
    }
    void state(double* x, double* v) const {
        for (u32 i = 0; i < size(); ++i) {
            const ImageMotion image = box.image(image_flags[i], now);
            for (int k = 0; k < d; ++k) {
                const std::size_t at = std::size_t{original_index[i]} * d + static_cast<std::size_t>(k);
                x[at] = position(i, k) + image.shift[k];
                v[at] = velocity(i, k) + image.velocity[k];
            }
        }
    }
    std::size_t bytes() const {
        const auto of = [](const auto& v) { return v.capacity() * sizeof(v[0]); };
        return of(paths) + of(pending) + of(image_flags) + of(original_index) + of(masses_) + of(rescans) +
               of(spins);
    }
    template <class Archive>
    void exchange(Archive& a) {
        a(paths), a(pending), a(image_flags), a(original_index), a(masses_), a(rescans), a(fastest_),
            a(spins);
    }

private:
    Records<double> masses_;  // if mixed [kg]
    double fastest_ = 0.0;    // [m/s]
};

}  // namespace hardlimit::boxes::spheres
