// Program for test_newton_events.py: parts of the event-driven engine alone. Bodies fly through the cells of a sheared
// box without collisions, and their paths and energies are compared with straight lines. Random pairs split bodies into
// parts, which are compared with those of a slow search. Prints the numbers of crossings of the sheared side and of
// parts, the largest error of a position relative to the box, that of the energy relative to the work of the boundary,
// and the number of wrong parts.
#include <algorithm>
#include <cstdio>
#include <random>
#include <vector>

#include "boxes/newton_events/connected_parts.hpp"
#include "boxes/newton_events/predict.hpp"
#include "contact/linear_dashpot.hpp"

using namespace hardlimit;
using namespace hardlimit::boxes;
using Law = contact::LinearDashpot;

namespace {

double kinetic_energy(const events::Paths<Law>& paths) {
    double sum = 0.0;
    for (int i = 0; i < paths.size(); ++i) {
        const Vector3 v = paths.velocity(i, paths.now);
        sum += 0.5 * paths.mass(i) * dot(v, v);
    }
    return sum;
}

void predict(int i, events::Paths<Law>& paths, const events::BodyCells<Law>& cells) {
    hardlimit_abi::ContactQuery body{};
    body.now = paths.now;
    const Vector3 x = paths.position(i, paths.now), v = paths.velocity(i, paths.now);
    std::copy_n(x.data(), 3, body.position), std::copy_n(v.data(), 3, body.velocity);
    events::predict_self_event(paths.pending[i], paths.box, cells.cells(), cells.level(), cells.place(i),
                               body, true);
}

void fly() {
    constexpr std::size_t n = 300;
    constexpr double edge = 0.1, until = 5.0;
    std::mt19937 engine(1);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    std::vector<double> x(3 * n), v(3 * n), radius(n, 1e-3), mass(n);
    for (double& a : x) a = edge * uniform(engine);
    for (double& a : v) a = 0.2 * (uniform(engine) - 0.5);
    for (double& m : mass) m = 1e-3 * (1.0 + uniform(engine));
    System s;
    for (double& a : s.box.edge) a = edge;
    s.box.boundary[0] = s.box.boundary[2] = Boundary::periodic, s.box.boundary[1] = Boundary::lees_edwards;
    s.box.shear(1, 0.7, 0.0);
    s.n = n, s.position = x.data(), s.velocity = v.data(), s.radius = radius.data(), s.mass = mass.data();
    LawChoice law{0, 0, {1000.0, 0.9}};
    const NewtonSetting setting(s, law, false);
    events::Paths<Law> paths(setting);
    events::BodyCells<Law> cells(setting, 2.5e-3, paths);
    cells.sort_in(setting, s);
    const double energy = kinetic_energy(paths);
    double work = 0.0;
    long crossings = 0;
    for (int i = 0; i < paths.size(); ++i) predict(i, paths, cells);
    for (;;) {
        const auto next = std::ranges::min_element(paths.pending, {}, &BodyEvents::own_time);
        const double time = std::min(next->own_time, cells.next_tilt());
        if (time > until) break;
        paths.now = time;
        if (time == next->own_time) {
            const auto i = static_cast<int>(next - paths.pending.begin());
            const double gain = cells.cross(i).shear_work;
            work += gain, crossings += gain != 0.0;
            predict(i, paths, cells);
        } else {
            cells.tilt_back();
            for (int i = 0; i < paths.size(); ++i) predict(i, paths, cells);
        }
    }
    paths.now = until;
    double off = 0.0;
    for (int i = 0; i < paths.size(); ++i) {
        const BodyEvents& e = paths.pending[i];
        const Vector3 at = paths.position(i, until);
        const ImageMotion image = paths.box.image(e.image_flags, until);
        for (std::size_t a = 0; a < 3; ++a) {
            const std::size_t k = 3 * e.original_index + a;
            off = std::max(off, math::abs(at[a] + image.shift[a] - (x[k] + until * v[k])) / edge);
        }
    }
    std::printf("%ld %g %g\n", crossings, off,
                math::abs(kinetic_energy(paths) - energy - work) / math::abs(work));
}

void split() {
    std::mt19937 engine(1);
    long parts = 0, wrong = 0;
    for (int run = 0; run < 300; ++run) {
        const int n = 2 + static_cast<int>(engine() % 60);
        std::vector<int> bodies(static_cast<std::size_t>(n)), label(bodies.size());
        for (int i = 0; i < n; ++i)
            bodies[static_cast<std::size_t>(i)] = 1000 - 7 * i, label[static_cast<std::size_t>(i)] = i;
        ActivePairs<Law> pairs;
        std::vector<char> active(bodies.size(), 0);
        const auto place = [](int body) { return static_cast<std::size_t>((1000 - body) / 7); };
        for (int k = 0; k < n / 2; ++k) {
            const std::size_t a = engine() % bodies.size(), b = engine() % bodies.size();
            const bool wall = a == b;
            pairs.push_back(new_pair<Law>(bodies[a], wall ? -1 : bodies[b], {}, 0.0));
            active[a] = active[b] = 1;
            const int from = label[a], to = label[b];
            std::ranges::replace(label, from, to);
        }
        const auto components = events::connected_parts(bodies, pairs);
        std::size_t members = 0, used = 0;
        for (const auto& part : components) {
            ++parts, members += part.bodies.size(), used += part.pairs.size();
            const int own = label[place(part.bodies[0])];
            for (const int i : part.bodies) wrong += label[place(i)] != own || !active[place(i)];
            for (const auto& pair : part.pairs) wrong += label[place(pair.first)] != own;
            wrong += static_cast<long>(part.bodies.size()) != std::ranges::count(label, own);
        }
        wrong += used != pairs.size();
        wrong += static_cast<long>(members) != std::ranges::count(active, 1);
    }
    std::printf("%ld %ld\n", parts, wrong);
}

}  // namespace

int main() {
    fly();
    split();
}
