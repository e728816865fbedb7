// The start of a run: the width of the cells, and contacts of bodies that overlap.
#pragma once
#include <algorithm>
#include <utility>
#include <vector>

#include "formation.hpp"

namespace hardlimit::boxes::events {

// The largest safety radius for which the cells shall be wide enough: a multiple of the compression of contacts at the
// initial speeds of bodies, relative to a sheared flow, and of walls. A larger radius requires wider cells, which hold
// more candidates. The largest value under gravity, since speeds grow.
template <class Law>
double initial_safety_radius(const NewtonSetting& setting, const System& s) {
    const Box& box = setting.box;
    const auto largest = std::ranges::max_element(setting.radius);
    const double radius = *largest, most = 0.1 * radius;
    if (box.falls()) return most;
    double square = 0.0;
    for (std::size_t i = 0; i < s.n; ++i) {
        double x[3]{}, v[3]{};
        setting.in_three(s.position, i, x);
        setting.in_three(s.velocity, i, v);
        v[0] -= box.mean_flow(x);
        square += dot(v, v);
    }
    const double of_shear = math::abs(box.shear_rate) * radius;
    const double speed = math::max(math::sqrt(square / static_cast<double>(s.n)),
                                   math::max(2.0 * box.fastest_wall(), of_shear));
    if (!(speed > 0.0)) return most;
    std::size_t at = 0;
    for (std::size_t i = 0; i < s.n; ++i)
        if (setting.radius[i] == radius) at = i;
    const double mass = setting.mass[at];
    const Law law = make_law<Law>(setting.law, {effective(mass, mass), effective(radius, radius)});
    const double duration = law.duration(speed, 0.5 * mass);
    return math::clamp(2.0 * speed * duration, 0.005 * radius, most);
}

// Finds the contacts of particles that overlap initially by more than rounding error. They start in contact if their
// force is repulsive.
template <class Law>
struct InitialContacts {
    // Largest initial overlap that counts as rounding error, relative to the sum of the radii.
    static constexpr double touching_depth = 1e-9;

    const Paths<Law>& paths;
    const BodyCells<Law>& cells;
    Ledger<Law>& ledger;
    std::vector<int> bodies{};  // that overlap
    ActivePairs<Law> pairs{};
    std::vector<char> is_known =
        std::vector<char>(paths.particles.size(), 0);  // [bodies] whether it is in `bodies`

    // `touching`, in ascending order, contains all bodies that overlap with another.
    void find(const std::vector<int>& touching) {
        auto next = touching.begin();
        for (int i = 0; i < paths.size(); ++i) {
            if (next != touching.end() && *next == i) {
                ++next;
                find_pairs(i);
            }
            for (int axis = 0; axis < paths.box.dimension; ++axis)
                for (const bool high : {false, true})
                    if (paths.box.has_walls(axis)) find_wall(i, paths.box.wall(axis, high));
        }
    }

private:
    void find_pairs(int i) {
        cells.for_neighbours(i, [&](int j, const Vector3& r, const double (&image_velocity)[3]) {
            if (j <= i) return;
            Vector3 v;
            for (std::size_t a = 0; a < 3; ++a)
                v[a] = (paths.particles[j].velocity[a] + image_velocity[a]) - paths.particles[i].velocity[a];
            const double distance = math::sqrt(dot(r, r));
            add(i, j, {}, (paths.radius(i) + paths.radius(j)) - distance, -dot(r, v) / distance);
        });
    }
    void find_wall(int i, const Wall& wall) {
        const Particle<3>& p = paths.particles[i];
        const int axis = wall.id.axis();
        add(i, -1, wall.id, paths.radius(i) - wall.distance(p.position[axis], paths.now),
            -wall.inward() * (p.velocity[axis] - wall.velocity(paths.now)));
    }
    // Adds a pair, or body i and a wall if j < 0, if they overlap.
    void add(int i, int j, WallId wall, double depth, double rate) {
        if (!(depth > touching_depth * (j < 0 ? paths.radius(i) : paths.radius(i) + paths.radius(j)))) return;
        ActivePair<Law> pair = new_pair<Law>(i, j, wall, paths.now);
        const Law law = paths.laws()(i, j);
        if (depth > law.slack(rate).depth) {
            pair.pair.state = ContactState::closed;
            pair.pair.velocity_jumped();
            ledger.begin_contact(j >= 0);
        } else {
            const double stored = law.energy(onset_root<Law::onset_power>(depth));
            ledger.sums.dissipated_energy += stored;
            if (j < 0) ledger.sums.walls.add(wall, 0.0, stored);
        }
        pairs.push_back(pair);
        for (const int k : {i, j})
            if (k >= 0 && !std::exchange(is_known[static_cast<std::size_t>(k)], 1)) bodies.push_back(k);
    }
};

}  // namespace hardlimit::boxes::events
