// Program for test_friction.py: a contact law with friction in the time-stepping engine.
//
//   friction frictionless   prints three numbers of differing values: friction coefficient 0 against the linear law;
//                           with friction, one thread against three threads with pauses; with friction against without
//   friction rolling        a sphere slides on the floor until it rolls: prints the ratio of its final to its initial
//                           speed, that of the final speed of its surface at the floor, and the ratio of the
//                           dissipated to the initial energy
//   friction oblique        two spheres collide off-centre: prints the relative changes of momentum and of angular
//                           momentum, the sum of the spins, and the largest |F_t|/F_n
//   friction energy         the same collision, with a time step and with half of it: prints for each the largest
//                           relative change of the total energy, and the part of it that friction dissipates
#include "boxes/common/random.hpp"
#include "boxes/newton_steps/engine.hpp"
#include "contact/linear_dashpot.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>

namespace {

using namespace hardlimit;
using namespace hardlimit::boxes;

double coefficient = 0.0, largest_ratio = 0.0;

// Linear dashpot with a tangential spring limited by Coulomb friction (P. A. Cundall & O. D. L. Strack,
// Géotechnique 29, 47 (1979)).
struct CundallStrack : contact::LinearDashpot {
    struct History {
        double spring[3];  // displacement of the second surface relative to the first [m]
        void reverse() {
            for (double& x : spring) x = -x;
        }
    };
    double tangential_stiffness;

    static CundallStrack from_parameters(int alternative, const double* p, PairGeometry pair) {
        const auto normal = contact::LinearDashpot::from_parameters(alternative, p, pair);
        return {normal, 2.0 / 7.0 * normal.stiffness};
    }
    TangentialForce tangential_force(const ContactMotion& m, History& h) const {
        double along = 0.0, square = 0.0;
        for (int k = 0; k < 3; ++k) along += h.spring[k] * m.normal[k];
        for (int k = 0; k < 3; ++k) {
            h.spring[k] += m.sliding_velocity[k] * m.duration - along * m.normal[k];
            square += h.spring[k] * h.spring[k];
        }
        const double limit = coefficient * m.normal_force / tangential_stiffness, length = std::sqrt(square);
        if (length > limit)
            for (double& x : h.spring) x *= limit / length;
        TangentialForce f{};
        square = 0.0;
        for (int k = 0; k < 3; ++k) {
            f.component[k] = -tangential_stiffness * h.spring[k];
            square += f.component[k] * f.component[k];
        }
        if (m.normal_force > 0.0) largest_ratio = std::max(largest_ratio, std::sqrt(square) / m.normal_force);
        return f;
    }
    double tangential_energy(const History& h) const {
        double square = 0.0;
        for (const double x : h.spring) square += x * x;
        return 0.5 * tangential_stiffness * square;
    }
};
static_assert(FrictionalLaw<CundallStrack> && !FrictionlessLaw<CundallStrack>);
static_assert(FrictionlessLaw<contact::LinearDashpot>);
static_assert(sizeof(steps::Contact<CundallStrack>) > sizeof(steps::Contact<contact::LinearDashpot>));

using Numbers = std::vector<double>;
constexpr Boundary periodic = Boundary::periodic;

template <class Law>
struct Run {
    std::size_t n;
    std::unique_ptr<NewtonSteps<Law>> engine;

    Run(const Box& box, const Numbers& x, const Numbers& v, double restitution, double step = 2e-6)
        : n(x.size() / 3) {
        const Numbers each(n, 0.01);  // radius and mass
        const System system = {box, n, x.data(), v.data(), each.data(), each.data()};
        LawChoice choice{};
        choice.parameters[0] = 1e5, choice.parameters[1] = restitution;
        engine = std::make_unique<NewtonSteps<Law>>(NewtonSetting(system, choice, false, step), system);
    }
    void advance(double until, int threads = 1, std::uint64_t most_steps = 1u << 30) {
        Stop never;
        do engine->advance(until, most_steps, threads, never);
        while (engine->paused());
    }
    Numbers state() const {
        Numbers position(3 * n), all(3 * n);
        engine->state(position.data(), all.data());
        all.insert(all.end(), position.begin(), position.end());
        return all;  // velocities first
    }
    Numbers spins() const {
        Numbers spin(3 * n);
        engine->angular_velocity(spin.data());
        return spin;
    }
    // Kinetic energy with that of the rotation, energy of the contacts, and dissipated energy [J].
    double total_energy() const {
        const Observation o = engine->observe();
        double sum = o.kinetic_energy + o.potential_energy + o.contact_energy + o.dissipated_energy;
        for (const double w : spins()) sum += 0.5 * (0.4 * 0.01 * 1e-4) * w * w;
        return sum;
    }
};

long differences(const Numbers& a, const Numbers& b) {
    long count = 0;
    for (std::size_t i = 0; i < a.size(); ++i) count += a[i] != b[i];
    return count;
}

int frictionless() {
    constexpr int side = 10;
    constexpr double spacing = 0.023;
    const Box box{3,
                  {side * spacing, side * spacing, side * spacing},
                  {periodic, Boundary::wall, periodic},
                  {0.0, -9.81, 0.0}};
    Numbers x, v;
    Random random(1);
    for (int i = 0; i < side * side * side; ++i)
        for (const int k : {i % side, i / side % side, i / side / side})
            x.push_back((k + 0.5) * spacing), v.push_back(random.normal());
    Run<contact::LinearDashpot> plain(box, x, v, 0.8);
    Run<CundallStrack> smooth(box, x, v, 0.8);
    plain.advance(0.02), smooth.advance(0.02);
    const long changed = differences(plain.state(), smooth.state());
    coefficient = 0.5;
    Run<CundallStrack> one(box, x, v, 0.8), three(box, x, v, 0.8);
    one.advance(0.02), three.advance(0.02, 3, 97);
    std::printf("%ld %ld %ld\n", changed,
                differences(one.state(), three.state()) + differences(one.spins(), three.spins()),
                differences(one.state(), plain.state()));
    return 0;
}

int rolling() {
    coefficient = 0.3;
    const double radius = 0.01, weight = 0.01 * 9.81, sunk = weight / 1e5;
    const Box box{3, {1.0, 0.1, 0.1}, {periodic, Boundary::wall, periodic}, {0.0, -9.81, 0.0}};
    Run<CundallStrack> run(box, {0.5, radius - sunk, 0.05}, {1.0, 0.0, 0.0}, 0.5);
    run.advance(0.3);
    const Numbers v = run.state(), spin = run.spins();
    std::printf("%.9g %.3g %.9g\n", v[0], v[0] + spin[2] * (radius - sunk),
                run.engine->observe().dissipated_energy / (0.5 * 0.01));
    return 0;
}

const Box empty_space{3, {1.0, 1.0, 1.0}, {periodic, periodic, periodic}, {}};
const Numbers off_centre = {0.47, 0.5, 0.5, 0.5, 0.512, 0.504}, towards = {1.0, 0.2, 0.0, -1.0, 0.1, 0.3};

int oblique() {
    coefficient = 0.2;
    Run<CundallStrack> run(empty_space, off_centre, towards, 0.8);
    const auto sums = [](const Numbers& s, const Numbers& spin) {
        Numbers p(3), l(3);
        for (std::size_t i = 0; i < 2; ++i) {
            const double *u = s.data() + 3 * i, *r = s.data() + 6 + 3 * i;
            for (std::size_t k = 0; k < 3; ++k) {
                const std::size_t a = (k + 1) % 3, b = (k + 2) % 3;
                p[k] += u[k];
                l[k] += r[a] * u[b] - r[b] * u[a] + 0.4 * 1e-4 * spin[3 * i + k];
            }
        }
        p.insert(p.end(), l.begin(), l.end());
        return p;
    };
    const Numbers before = sums(run.state(), run.spins());
    run.advance(0.03);
    const Numbers spin = run.spins(), after = sums(run.state(), spin);
    double changed[2] = {}, turned = 0.0;
    for (std::size_t k = 0; k < 6; ++k)
        changed[k / 3] = std::max(changed[k / 3], std::abs(after[k] - before[k]));
    for (std::size_t k = 0; k < 3; ++k) turned = std::max(turned, std::abs(spin[k] + spin[3 + k]));
    std::printf("%.3g %.3g %.3g %.12g\n", changed[0], changed[1] / 0.01, turned, largest_ratio);
    return 0;
}

int energy() {
    for (const double step : {4e-6, 2e-6}) {
        coefficient = 0.2;
        Run<CundallStrack> run(empty_space, off_centre, towards, 0.8, step);
        const double before = run.total_energy();
        double worst = 0.0;  // during the contact too
        for (int k = 1; k <= 300; ++k) {
            run.advance(1e-4 * k);
            worst = std::max(worst, std::abs(run.total_energy() / before - 1.0));
        }
        const double lost = run.engine->observe().dissipated_energy / before;
        coefficient = 0.0;
        Run<CundallStrack> smooth(empty_space, off_centre, towards, 0.8, step);
        smooth.advance(0.03);
        std::printf("%.3g %.9g ", worst, lost - smooth.engine->observe().dissipated_energy / before);
    }
    std::printf("\n");
    return 0;
}

}  // namespace

int main(int, char** words) {
    if (std::strcmp(words[1], "frictionless") == 0) return frictionless();
    if (std::strcmp(words[1], "energy") == 0) return energy();
    return std::strcmp(words[1], "rolling") == 0 ? rolling() : oblique();
}
