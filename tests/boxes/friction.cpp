// Program for test_friction.py: laws with friction in the time-stepping engine. Reads the numbers of a setting in the
// order below and prints one row for each sample: positions, velocities and angular velocities of all bodies, elastic
// energy of the contacts, dissipated and potential energy.
//
//   law parameters         number of the law (0: linear, 1: viscoelastic, 2: Tsuji, 3: linear without friction) and
//                          three parameters
//   friction               μ, number of the model, number of the limit, stiffness ratio, stiffness, damping ratio,
//                          damping (NaN: not given)
//   box                    dimension, edges, boundaries (1: periodic, 2: wall), gravity; three numbers each
//   bodies                 number; for each radius, mass, inertia factor, position, velocity, angular velocity
//   run                    time step, end, samples, threads (with several, the run is saved and loaded at each
//                          sample), steps between pauses
#include "boxes/newton_steps/engine.hpp"
#include "contact/linear_dashpot.hpp"
#include "contact/tsuji.hpp"
#include "contact/viscoelastic.hpp"

#include <cstdio>
#include <cstdlib>
#include <memory>

namespace {

using namespace hardlimit;
using namespace hardlimit::boxes;
using Numbers = std::vector<double>;

using Linear = contact::LinearDashpot;
static_assert(FrictionalLaw<WithFriction<Linear>> && !FrictionlessLaw<WithFriction<Linear>>);
static_assert(FrictionlessLaw<Linear> && FrictionlessLaw<contact::Viscoelastic>);
static_assert(sizeof(steps::Contact<WithFriction<Linear>>) >
              sizeof(steps::Contact<Linear>) + sizeof(FrictionTerms));

double number() {
    char word[64];
    if (std::scanf("%63s", word) != 1) std::exit(1);
    return std::strtod(word, nullptr);
}
int integer() { return static_cast<int>(number()); }

struct InitialState {
    Numbers radius, mass, inertia_factor, position, velocity, spin;

    static InitialState read(int dimension) {
        InitialState b;
        for (int left = integer(); left > 0; --left) {
            for (Numbers* of : {&b.radius, &b.mass, &b.inertia_factor}) of->push_back(number());
            for (Numbers* of : {&b.position, &b.velocity})
                for (int k = 0; k < dimension; ++k) of->push_back(number());
            for (int k = 0; k < 3; ++k) b.spin.push_back(number());
        }
        return b;
    }
};

template <class Law>
std::unique_ptr<NewtonSteps<Law>> reloaded(const NewtonSteps<Law>& engine) {
    const std::vector<char> saved = engine.save();
    Reader reader(saved.data(), saved.size());
    if (!reader.whole("newton_steps")) std::exit(3);
    NewtonSetting setting;
    setting.exchange(reader);
    return std::make_unique<NewtonSteps<Law>>(setting, reader);
}

template <class Law>
int run(const LawChoice& law, const Box& box, const InitialState& bodies) {
    const double step = number(), end = number();
    const int samples = integer(), threads = integer();
    const auto most_steps = static_cast<u64>(number());
    const System system = {box,
                           bodies.radius.size(),
                           bodies.position.data(),
                           bodies.velocity.data(),
                           bodies.radius.data(),
                           bodies.mass.data(),
                           bodies.inertia_factor.data(),
                           bodies.spin.data()};
    auto engine = std::make_unique<NewtonSteps<Law>>(NewtonSetting(system, law, false, step), system);
    Numbers position(bodies.position.size()), velocity(position.size()), spin(3 * system.n);
    for (int k = 0; k <= samples; ++k) {
        Stop never;
        do engine->advance(end * k / samples, most_steps, threads, never);
        while (engine->paused());
        if (engine->outcome() != Outcome::ok) return 2;
        engine->state(position.data(), velocity.data());
        if constexpr (FrictionalLaw<Law>) engine->spins(spin.data());
        const Observation o = engine->observe();
        for (const Numbers& values :
             {position, velocity, spin, {o.contact_energy, o.dissipated_energy, o.potential_energy}})
            for (const double value : values) std::printf("%.17g ", value);
        std::printf("\n");
        if (threads > 1) engine = reloaded(*engine);
    }
    return 0;
}

}  // namespace

int main() {
    const int kind = integer();
    LawChoice law{};
    for (int k = 0; k < 3; ++k) law.parameters[k] = number();
    Friction& friction = law.friction;
    friction.coefficient = number();
    friction.model = static_cast<FrictionModel>(integer());
    friction.limit = static_cast<SlipLimit>(integer());
    friction.stiffness_ratio = number(), friction.stiffness = number();
    friction.damping_ratio = number(), friction.damping = number();
    Box box;
    box.dimension = integer();
    for (double& edge : box.edge) edge = number();
    for (Boundary& boundary : box.boundary) boundary = static_cast<Boundary>(integer());
    for (double& g : box.gravity) g = number();
    const InitialState bodies = InitialState::read(box.dimension);
    switch (kind) {
        case 0:
            return run<WithFriction<Linear>>(law, box, bodies);
        case 1:
            return run<WithFriction<contact::Viscoelastic>>(law, box, bodies);
        case 2:
            return run<WithFriction<contact::Tsuji>>(law, box, bodies);
        default:
            return run<Linear>(law, box, bodies);
    }
}
