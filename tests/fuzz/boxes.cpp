// Fuzz target: small boxes of hard spheres and disks under every collision rule, without and with friction. Each runs
// for a few hundred collisions, is saved and loaded, and continues. No other test runs this engine under sanitizers.
#include <algorithm>
#include <vector>

#include "boxes/hard_spheres/make_engine.hpp"
#include "boxes/hard_spheres/rules/registry.hpp"
#include "small_box.hpp"

namespace {

using namespace hardlimit;
using namespace hardlimit::boxes;
using fuzz::kernels;
using fuzz::require;
using Draw = fuzz::Draw<fuzz::Bytes>;

struct Case : fuzz::SmallBox {
    RuleChoice rule;

    explicit Case(Draw& draw) : fuzz::SmallBox(draw, 4, 0.0) { choose_rule(draw, large / speed); }

private:
    void choose_rule(Draw& draw, double time) {
        rule.restitution = draw.restitution();
        rule.rule = draw.below(rule_count);
        const RuleRecord& chosen = rule_records[rule.rule];
        if (chosen.n_parameters > 0) rule.parameters[0] = time * draw.decades(1e-6, 1.0);
        const bool rubs = draw.below(2) == 0;
        if (rubs) add_spins(draw, speed);
        if (chosen.takes_restitution) {
            if (!rubs) return;
            rule.friction = draw.often({math::infinity, 0.5}, [&] { return draw.decades(1e-4, 10.0); });
            rule.tangential_restitution =
                draw.often({-1.0, 0.0, 1.0}, [&] { return draw.between(-1.0, 1.0); });
            return;
        }
        fuzz::with_some_law(draw, [&]<class Law>() {
            const fuzz::Material<Law> material(draw);
            rule.law = fuzz::law_choice<Law>(material);
            if constexpr (PowerLaw<Law>)
                if (rubs) rule.law.friction = fuzz::some_friction(draw, Law::onset_power == 1);
        });
    }
};

struct State {
    std::vector<double> position, velocity, spin;
    explicit State(const Engine& e)
        : position(e.size() * static_cast<std::size_t>(e.dimension())),
          velocity(position.size()),
          spin(3 * e.size()) {
        e.state(position.data(), velocity.data());
        if (e.rotates()) e.spins(spin.data());
    }
};

double energy(const Observation& o) { return o.kinetic_energy + o.rotational_energy + o.potential_energy; }

void check(const Case& c, const Engine& e, const Observation& start) {
    const State now(e);
    for (std::size_t i = 0; i < now.position.size(); ++i)
        require(math::is_finite(now.position[i]) && math::is_finite(now.velocity[i]),
                "finite places and velocities");
    for (const double spin : now.spin) require(math::is_finite(spin), "finite spins");
    const Observation o = e.observe();
    // Energy is conserved only without gravity along periodic axes, where there is no potential.
    bool closed = true, free = true;
    for (int k = 0; k < c.s.box.dimension; ++k) {
        closed = closed && (c.s.box.gravity[k] == 0.0 || !c.s.box.is_periodic(k));
        free = free && c.s.box.gravity[k] == 0.0 && c.s.box.is_periodic(k);
    }
    double scale = energy(start) - start.potential_energy + math::abs(start.potential_energy), impulse = 0.0;
    for (std::size_t i = 0; i < c.s.n; ++i) {
        impulse += c.s.mass[i];
        for (int k = 0; k < c.s.box.dimension; ++k)
            scale += c.s.mass[i] * math::abs(c.s.box.gravity[k]) * c.s.box.edge[k];
    }
    impulse = math::sqrt(2.0 * scale * impulse);
    if (closed)
        require(math::abs(energy(start) - energy(o) - o.dissipated_energy) <= 1e-9 * scale + 1e-300,
                "what energy is lost is what collisions took");
    for (int k = 0; free && k < c.s.box.dimension; ++k)
        require(math::abs(o.momentum[k] - start.momentum[k]) <= 1e-9 * impulse + 1e-300, "momentum is kept");
}

// Advances the run. Returns false if it made no progress and was stopped.
bool advance(Engine& e, double until, u64 rows) {
    long left = 300;  // times 64 events
    Stop stop([](void* n) { return --*static_cast<long*>(n) < 0; }, &left);
    if (rows > e.contacts()) e.advance(until, rows - e.contacts(), 1, stop);
    return !stop.stopped();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    Draw draw{fuzz::Bytes(data, size)};
    const Case c(draw);
    if (validate(c.s).kind != Fault::none) return 0;
    Stop never;
    const auto& kernel = c.wide ? kernels<8> : kernels<2>;
    const auto engine = make_hard_spheres(c.s, c.rule, draw.below(2) == 0, kernel, never);
    const Observation start = engine->observe();
    const double until = draw.decades(1e-6, 1e3);
    advance(*engine, until, 150);
    check(c, *engine, start);
    const std::vector<char> bytes = engine->save();
    const auto again = load_hard_spheres(bytes.data(), bytes.size(), kernel);
    require(again != nullptr, "what was saved can be loaded");
    const bool ended = advance(*engine, 2.0 * until, 300), same = advance(*again, 2.0 * until, 300);
    check(c, *engine, start);
    require(ended == same, "what was loaded ends as well");
    const State a(*engine), b(*again);
    require(engine->time() == again->time() && a.position == b.position && a.velocity == b.velocity &&
                a.spin == b.spin,
            "what was loaded goes on with the same bits");
    require(!load_hard_spheres(bytes.data(), bytes.size() / 2, kernel), "half a file is refused");
    return 0;
}
