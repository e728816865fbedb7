// C interface to the hard-sphere engine, for WebAssembly; it only converts numbers. The page loads this module when it
// shows a box. The same file compiled natively (tests/web/golden_grains.cpp) gives the reference values with which the
// WebAssembly build is compared, bit for bit.
//
// The caller writes its input to box_setting(): numbers in the order of `Field`, then positions (n·d), velocities
// (n·d), radii (n) and masses (n), all in SI units.
#include "boxes/common/system_check.hpp"
#include "boxes/hard_spheres/growth.hpp"
#include "boxes/hard_spheres/make_engine.hpp"
#include "boxes/hard_spheres/rules/registry.hpp"
#include "boxes/kernels/kernel_table.hpp"

#include <algorithm>
#include <memory>
#include <string_view>
#include <vector>

namespace {

namespace hl = hardlimit;
namespace box = hardlimit::boxes;

enum Field {
    dimension,         // d: 2 or 3
    number,            // n
    rule,              // index in the registry of rules
    restitution,       // for the rule constant, and for tc without a law
    contact_duration,  // t_c of the rule tc [s]
    law,               // index in registry.hpp; −1: none
    alternative,       // which of the law's parameter sets
    parameters,        // of the law, common ones first
    edges = parameters + hl::max_parameters,
    periodic = edges + 3,  // 1, or 0: walls
    gravity = periodic + 3,
    fields = gravity + 3
};

// Reason why a run could not start.
enum Refusal { none, no_such_box, no_such_rule, no_such_start };

const hardlimit_abi::TouchKernels kernels = box::touch_kernels<hl::Vector<2>::Real, false>("wasm");

struct Run {
    std::vector<double> setting;
    std::unique_ptr<box::Engine> engine;
    std::vector<box::ContactRecord> log;
    std::vector<double> out;  // last returned array
};
Run& run() {
    static Run* only = new Run;
    return *only;
}

int field(Field f) { return static_cast<int>(run().setting[f]); }
std::size_t size_of_box() { return static_cast<std::size_t>(field(number)); }

// Arrays within the setting.
struct Arrays {
    double *position, *velocity, *radius, *mass;
};
Arrays arrays() {
    const std::size_t n = size_of_box(), nd = n * static_cast<std::size_t>(field(dimension));
    double* const first = run().setting.data() + fields;
    return {first, first + nd, first + 2 * nd, first + 2 * nd + n};
}

box::System system_given() {
    box::System s{};
    const Arrays a = arrays();
    s.n = size_of_box();
    s.position = a.position, s.velocity = a.velocity, s.radius = a.radius, s.mass = a.mass;
    s.box.dimension = field(dimension);
    for (int k = 0; k < s.box.dimension; ++k) {
        const auto value = [&](Field f) { return run().setting[static_cast<std::size_t>(f + k)]; };
        s.box.edge[k] = value(edges);
        s.box.boundary[k] = value(periodic) != 0.0 ? box::Boundary::periodic : box::Boundary::wall;
        s.box.gravity[k] = value(gravity);
    }
    return s;
}

bool is_box() {
    const std::size_t given = run().setting.size();
    if (given < fields || (field(dimension) != 2 && field(dimension) != 3) || field(number) < 1) return false;
    return given == fields + size_of_box() * (2 * static_cast<std::size_t>(field(dimension)) + 2);
}

// Whether the law exists and has this set of parameters.
bool is_law(const box::LawChoice& choice) {
    const auto exists = [&]<class Law>() {
        return choice.alternative >= 0 && choice.alternative < Law::record.n_alternatives;
    };
    return box::with_law<bool>(choice ? choice.law : -1, exists);
}

// Reads the collision rule from the setting; false if it is invalid.
bool read_rule(box::RuleChoice& choice) {
    const double* const s = run().setting.data();
    choice.rule = field(rule);
    if (choice.rule < 0 || choice.rule >= box::rule_count) return false;
    const box::RuleRecord& record = box::rule_records[choice.rule];
    if (record.n_parameters > 0) choice.parameters[0] = s[contact_duration];
    if (!(choice.parameters[0] >= 0.0)) return false;
    if (record.takes_law && (!record.takes_restitution || field(law) >= 0)) {
        choice.law.law = field(law);
        choice.law.alternative = field(alternative);
        std::copy_n(s + parameters, hl::max_parameters, choice.law.parameters);
        return is_law(choice.law);
    }
    choice.restitution = s[restitution];
    return choice.restitution >= 0.0 && choice.restitution <= 1.0;
}

template <int d>
bool grow(const box::System& s, hl::u64 seed) {
    hl::Stop never;
    box::PackingGrowth<d> growth(s, seed);
    if (!growth.run(kernels, never, [](box::GrowthReport) { return true; })) return false;
    const std::vector<double> found = std::move(growth).positions();
    std::copy(found.begin(), found.end(), arrays().position);
    return true;
}

}  // namespace

extern "C" {

// Allocates the setting for n particles and writes these two numbers; valid until the next call.
double* box_setting(int dimensions, int n) {
    const std::size_t each = 2 * static_cast<std::size_t>(dimensions) + 2;
    run().setting.assign(fields + static_cast<std::size_t>(n) * each, 0.0);
    run().setting[dimension] = dimensions;
    run().setting[number] = n;
    return run().setting.data();
}
// Number of values before the arrays.
int box_fields() { return fields; }

// Writes random positions without overlap to the setting, for its radii and box. Returns 0 if none were found.
int box_grow(double seed) {
    if (!is_box()) return 0;
    const box::System s = system_given();
    if (box::fault_of_sizes(s).kind != box::Fault::none || !(s.packing_fraction() < 1.0)) return 0;
    const hl::u64 whole = static_cast<hl::u64>(seed);
    return s.box.dimension == 2 ? grow<2>(s, whole) : grow<3>(s, whole);
}

// Starts a run; returns 0 or the Refusal.
int box_start(int keep_log) {
    run().engine.reset();
    if (!is_box()) return no_such_box;
    box::RuleChoice choice;
    if (!read_rule(choice)) return no_such_rule;
    const box::System s = system_given();
    if (box::validate(s).kind != box::Fault::none) return no_such_start;
    hl::Stop never;
    run().engine = box::make_hard_spheres(s, choice, keep_log != 0, kernels, never);
    return none;
}

// Advances to `until` [s], or to collision number `most_rows` (0: no limit). Returns the outcome.
int box_advance(double until, double most_rows) {
    hl::Stop never;
    box::Engine& engine = *run().engine;
    const hl::u64 most = most_rows > 0.0 ? static_cast<hl::u64>(most_rows) : ~hl::u64{0};
    if (most > engine.contacts()) engine.advance(until, most - engine.contacts(), 1, never);
    return static_cast<int>(engine.outcome());
}

// Returns: time; numbers of collisions of pairs, with walls, made elastic by the TC rule, soft, and soft with a third
// body; kinetic and potential energy, momentum (3), dissipated energy, trace of the virial, ∫ Σ m v'² dt; time, first
// and second particle of an early end.
double* box_observe() {
    const box::Engine& engine = *run().engine;
    const box::Observation o = engine.observe();
    const box::EarlyEnd end = engine.early_end();
    run().out = {engine.time()};
    for (const box::Statistic& s : engine.statistics())
        if (std::string_view(s.name) != "n_events") run().out.push_back(s.value);
    run().out.insert(run().out.end(),
                     {o.kinetic_energy, o.potential_energy, o.momentum[0], o.momentum[1], o.momentum[2],
                      o.dissipated_energy, o.virial.trace(), o.kinetic_integral});
    const std::size_t n = end.particles.size();
    const hl::i64 second = end.wall ? end.wall.number : n > 1 ? end.particles[1] : 0;
    run().out.insert(run().out.end(), {end.time, n > 0 ? static_cast<double>(end.particles[0]) : -1.0,
                                       static_cast<double>(second)});
    return run().out.data();
}

// Current positions, unwrapped across periodic boundaries (n·d), then velocities (n·d); valid until the next call of
// this interface.
double* box_state() {
    const std::size_t nd = size_of_box() * static_cast<std::size_t>(field(dimension));
    run().out.resize(2 * nd);
    run().engine->state(run().out.data(), run().out.data() + nd);
    return run().out.data();
}

// Returns the number of collisions logged since the last call; box_log() returns time, first, second (wall: < 0) and
// impact speed of each.
int box_take_log() {
    run().log = run().engine->take_log();
    return static_cast<int>(run().log.size());
}
double* box_log() {
    run().out.clear();
    for (const box::ContactRecord& row : run().log)
        run().out.insert(run().out.end(), {row.begin, static_cast<double>(row.first),
                                           static_cast<double>(row.second), row.impact_speed});
    return run().out.data();
}

}  // extern "C"
