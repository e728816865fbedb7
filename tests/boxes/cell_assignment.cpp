// Program for test_hard_spheres.py: CellAssignment without an engine. Particles of a sheared box jump at random times
// by random distances, also through its sides. Prints the numbers of jumps, of jumps that change the kinetic energy,
// and of wrong cells, and the relative errors of the work of the boundary and of the sum over all particles.
#include "boxes/hard_spheres/cell_assignment.hpp"

#include <cstdio>
#include <random>

using namespace hardlimit;
using namespace hardlimit::boxes;

int main() {
    constexpr u32 n = 300;
    std::mt19937 engine(1);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    System s;
    s.box.dimension = 2, s.box.edge[0] = 1.0, s.box.edge[1] = 0.8;
    s.box.boundary[0] = Boundary::periodic, s.box.boundary[1] = Boundary::lees_edwards;
    s.box.shear(1, 3.0, 0.1);
    std::vector<double> x, v, radius, mass;
    for (u32 i = 0; i < n; ++i) {
        x.insert(x.end(), {uniform(engine), 0.8 * uniform(engine)});
        v.insert(v.end(), {uniform(engine) - 0.5, uniform(engine) - 0.5});
        radius.push_back(0.004 + 0.02 * uniform(engine)), mass.push_back(1.0 + uniform(engine));
    }
    s.n = n, s.position = x.data(), s.velocity = v.data(), s.radius = radius.data(), s.mass = mass.data();

    const spheres::Setting setting(s, {}, false, {});
    spheres::Particles<2, true> particles(setting);
    spheres::Totals<2, true> totals(particles);
    spheres::CellAssignment<2, true> cells(particles, totals);
    cells.begin(s);
    totals.begin(s);
    const auto energy = [&](u32 i) {
        const double (&u)[2] = particles.paths[i].velocity;
        return 0.5 * particles.mass(i) * (u[0] * u[0] + u[1] * u[1]);
    };
    long jumps = 0, crossings = 0, wrong = 0;
    double gained = 0.0;
    const auto jump = [&](u32 i, double farthest) {
        particles.advance_to_now(i);
        double (&at)[2] = particles.paths[i].position;
        for (double& coordinate : at) coordinate += farthest * (2.0 * uniform(engine) - 1.0);
        const double before = energy(i);
        cells.update(i);
        gained += energy(i) - before;
        ++jumps, crossings += energy(i) != before;
        const Place<2> place = cells.place(i),
                       expected = cells.cells().place_of(cells.level(i), at, particles.now);
        Scratch<u32> ids(1000);
        const std::size_t held = cells.cells().collect(particles.pending[i].cell, ids, 0);
        const double along = cells.cells().along(at, particles.now);
        wrong += place[0] != expected[0] || place[1] != expected[1] || along < 0.0 || along > 1.0 ||
                 at[1] < 0.0 || at[1] > 0.8 ||
                 std::find(ids.data(), ids.data() + held, i) == ids.data() + held;
    };
    for (int step = 0; step < 20'000; ++step) {
        const double then = particles.now + 1e-3 * uniform(engine);
        if (then >= cells.cells().next_tilt()) {
            particles.now = cells.cells().next_tilt();
            for (u32 i = 0; i < n; ++i) jump(i, 0.0);
            cells.tilt_back();
        }
        particles.now = then;
        jump(static_cast<u32>(engine() % n), 0.3);
    }
    double sum = 0.0;
    for (u32 i = 0; i < n; ++i) sum += energy(i);
    std::printf("%ld %ld %ld %g %g\n", jumps, crossings, wrong,
                totals.so_far.shear_work.value() / gained - 1.0,
                totals.so_far.sums.twice_kinetic() / (2.0 * sum) - 1.0);
}
