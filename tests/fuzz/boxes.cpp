// Fuzz target: small boxes of hard spheres and disks, of every kind and under every rule, which nothing else runs under
// sanitizers: a few hundred collisions, then saved, loaded and gone on with.
#include <vector>

#include "check.hpp"
#include "particles/check.hpp"
#include "particles/make_engine.hpp"

namespace {

using namespace hardlimit;
using namespace hardlimit::particles;
using fuzz::require;
using Draw = fuzz::Draw<fuzz::Bytes>;

template <int lanes>
constexpr hardlimit_abi::TouchKernels kernels = touch_kernels<typename Vector<lanes>::Real, false>("fuzz");

// Bodies on the places of a lattice, some of them moved, so that they may touch and do not overlap.
struct Case {
    Setting s{};
    std::vector<double> position, velocity, radius, mass;
    RuleChoice rule;

    explicit Case(Draw& draw) {
        s.dimension = 2 + draw.below(2);
        s.kernels = draw.below(2) == 0 ? &kernels<2> : &kernels<8>;
        const double large = draw.decades(1e-4, 1.0);
        const double ratio = draw.often({1.0}, [&] { return draw.decades(0.01, 1.0); });
        const double spacing = 2.0 * large * draw.often({1.0}, [&] { return 1.0 + draw.decades(1e-9, 3.0); });
        const double speed = draw.decades(1e-3, 10.0);
        int places[3] = {1, 1, 1};
        for (int k = 0; k < s.dimension; ++k) {
            places[k] = 1 + draw.below(4);
            s.edge[k] = spacing * places[k];
            s.periodic[k] = draw.below(2) == 0;
            s.gravity[k] = draw.often({0.0}, [&] { return draw.between(-10.0, 10.0); });
        }
        for (int x = 0; x < places[0]; ++x)
            for (int y = 0; y < places[1]; ++y)
                for (int z = 0; z < places[2]; ++z) {
                    if (draw.below(4) == 0 && s.n > 0) continue;
                    const int at[3] = {x, y, z};
                    add(draw, at, spacing, draw.below(2) == 0 ? large : ratio * large, speed);
                }
        s.position = position.data(), s.velocity = velocity.data();
        s.radius = radius.data(), s.mass = mass.data();
        choose_rule(draw, large / speed);
    }

private:
    void add(Draw& draw, const int (&at)[3], double spacing, double size, double speed) {
        for (int k = 0; k < s.dimension; ++k) {
            const double room = 0.5 * spacing - size;
            const double aside = draw.often({0.0}, [&] { return draw.between(-room, room); });
            position.push_back(math::min(spacing * (at[k] + 0.5) + aside, s.edge[k]));
            velocity.push_back(draw.often({0.0, speed, -speed}, [&] { return draw.between(-speed, speed); }));
        }
        radius.push_back(size);
        mass.push_back(draw.often({1.0}, [&] { return draw.decades(1e-3, 1e3); }));
        ++s.n;
    }
    void choose_rule(Draw& draw, double time) {
        rule.restitution = draw.restitution();
        const int kind = draw.below(4);
        if (kind == 1) rule.contact_duration = time * draw.decades(1e-6, 1.0);
        if (kind < 2) return;
        rule.soft = kind == 3;
        rule.law = 0, rule.alternative = 1;  // linear, by stiffness and damping
        rule.parameters[0] = 1e6;
        rule.parameters[1] = draw.often({0.0}, [&] { return draw.decades(1e-3, 10.0); });
    }
};

struct State {
    std::vector<double> position, velocity;
    explicit State(const Engine& e)
        : position(e.size() * static_cast<std::size_t>(e.dimension())), velocity(position.size()) {
        e.state(position.data(), velocity.data());
    }
};

double energy(const Observation& o) { return o.kinetic_energy + o.potential_energy; }

void check(const Case& c, const Engine& e, const Observation& start) {
    const State now(e);
    for (std::size_t i = 0; i < now.position.size(); ++i)
        require(math::is_finite(now.position[i]) && math::is_finite(now.velocity[i]),
                "finite places and velocities");
    const Observation o = e.observe();
    // Along a periodic axis a fall goes on for ever: there is no potential.
    bool closed = true, free = true;
    for (int k = 0; k < c.s.dimension; ++k) {
        closed = closed && (c.s.gravity[k] == 0.0 || !c.s.periodic[k]);
        free = free && c.s.gravity[k] == 0.0 && c.s.periodic[k];
    }
    double scale = start.kinetic_energy + math::abs(start.potential_energy), impulse = 0.0;
    for (std::size_t i = 0; i < c.s.n; ++i) {
        impulse += c.s.mass[i];
        for (int k = 0; k < c.s.dimension; ++k)
            scale += c.s.mass[i] * math::abs(c.s.gravity[k]) * c.s.edge[k];
    }
    impulse = math::sqrt(2.0 * scale * impulse);
    if (closed)
        require(math::abs(energy(start) - energy(o) - o.dissipated_energy) <= 1e-9 * scale + 1e-300,
                "what energy is lost is what collisions took");
    for (int k = 0; free && k < c.s.dimension; ++k)
        require(math::abs(o.momentum[k] - start.momentum[k]) <= 1e-9 * impulse + 1e-300, "momentum is kept");
}

// Whether it came to its end; a run that stands still is given up.
bool advance(Engine& e, double until, i64 rows) {
    long left = 300;  // times 64 events
    Stop stop([](void* n) { return --*static_cast<long*>(n) < 0; }, &left);
    e.advance(until, rows, stop);
    return !stop.stopped();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    Draw draw{fuzz::Bytes(data, size)};
    const Case c(draw);
    if (fault_of(c.s).kind != Fault::none) return 0;
    Stop never;
    const auto engine = make_engine(c.s, c.rule, draw.below(2) == 0, never);
    const Observation start = engine->observe();
    const double until = draw.decades(1e-6, 1e3);
    advance(*engine, until, 150);
    check(c, *engine, start);
    const std::vector<char> bytes = engine->save();
    const auto again = load_engine(bytes.data(), bytes.size(), *c.s.kernels);
    require(again != nullptr, "what was saved can be loaded");
    const bool ended = advance(*engine, 2.0 * until, 300), same = advance(*again, 2.0 * until, 300);
    check(c, *engine, start);
    require(ended == same, "what was loaded ends as well");
    const State a(*engine), b(*again);
    require(engine->time() == again->time() && a.position == b.position && a.velocity == b.velocity,
            "what was loaded goes on with the same bits");
    require(!load_engine(bytes.data(), bytes.size() / 2, *c.s.kernels), "half a file is refused");
    return 0;
}
