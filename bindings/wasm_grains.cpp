// Boxes of hard spheres behind a C interface of plain numbers, for WebAssembly: conversion, nothing else. A module of
// its own, which a page loads when it shows a box. The same file compiled natively (web/golden_grains.cpp) gives the
// values that the WebAssembly build is tested against, bit for bit.
//
// The caller writes a setting to box_setting(): numbers as in `Field`, then positions (n·d), velocities (n·d), radii
// (n) and masses (n), all in SI units.
#include "boxes/hard_spheres/check.hpp"
#include "boxes/hard_spheres/growth.hpp"
#include "boxes/hard_spheres/make_engine.hpp"
#include "boxes/kernels/kernel_table.hpp"

#include <algorithm>
#include <memory>
#include <vector>

namespace {

namespace hl = hardlimit;
namespace box = hardlimit::boxes;

enum Field {
    dimension,         // d: 2 or 3
    number,            // n
    rule,              // 0 constant, 1 tc, 2 law, 3 soft
    restitution,       // with the rule constant, or tc without a law
    contact_duration,  // t_c of the rule tc [s]
    law,               // place in registry.hpp; −1: none
    alternative,       // which set of parameters
    parameters,        // common ones first
    edges = parameters + hl::max_parameters,
    periodic = edges + 3,  // 1, or 0: walls
    gravity = periodic + 3,
    fields = gravity + 3
};
enum RuleNumber { constant, tc, by_law, soft };

// Why there is no run.
enum Refusal { none, no_such_box, no_such_rule, no_such_start };

const hardlimit_abi::TouchKernels kernels = box::touch_kernels<hl::Vector<2>::Real, false>("wasm");

struct Run {
    std::vector<double> setting;
    std::unique_ptr<box::Engine> engine;
    box::Log log;
    std::vector<double> room;
};
Run& run() {
    static Run* one = new Run;
    return *one;
}

int field(Field f) { return static_cast<int>(run().setting[f]); }
std::size_t size_of_box() { return static_cast<std::size_t>(field(number)); }

// The arrays of the setting.
struct Arrays {
    double *position, *velocity, *radius, *mass;
};
Arrays arrays() {
    const std::size_t n = size_of_box(), nd = n * static_cast<std::size_t>(field(dimension));
    double* const first = run().setting.data() + fields;
    return {first, first + nd, first + 2 * nd, first + 2 * nd + n};
}

box::Setting setting() {
    box::Setting s{};
    const Arrays a = arrays();
    s.dimension = field(dimension);
    s.n = size_of_box();
    s.position = a.position, s.velocity = a.velocity, s.radius = a.radius, s.mass = a.mass;
    for (int k = 0; k < 3; ++k) {
        s.edge[k] = run().setting[static_cast<std::size_t>(edges + k)];
        s.periodic[k] = run().setting[static_cast<std::size_t>(periodic + k)] != 0.0;
        s.gravity[k] = run().setting[static_cast<std::size_t>(gravity + k)];
    }
    s.kernels = &kernels;
    return s;
}

bool is_box() {
    const std::size_t given = run().setting.size();
    if (given < fields || (field(dimension) != 2 && field(dimension) != 3) || field(number) < 1) return false;
    return given == fields + size_of_box() * (2 * static_cast<std::size_t>(field(dimension)) + 2);
}

// The number of parameters in each set of a law; 0 where there is no such set.
int parameters_of(int place, int set) {
    if (place < 0) return 0;
    int n = 0;
    const auto consider = [&](const hl::LawRecord& record) {
        if (place-- == 0 && set >= 0 && set < record.n_alternatives)
            n = record.n_common + record.n_in_alternative[set];
    };
#define HL_CONSIDER(Law) consider(hl::contact::Law::record);
    HARDLIMIT_LAWS(HL_CONSIDER)
#undef HL_CONSIDER
    return n;
}

// Whether the rule asked for is one.
bool make_rule(box::RuleChoice& choice) {
    const double* const s = run().setting.data();
    const int kind = field(rule);
    if (kind < constant || kind > soft) return false;
    if (kind == tc) {
        if (!(s[contact_duration] >= 0.0)) return false;
        choice.contact_duration = s[contact_duration];
    }
    if (kind == by_law || kind == soft || (kind == tc && field(law) >= 0)) {
        if (parameters_of(field(law), field(alternative)) == 0) return false;
        choice.law = field(law);
        choice.alternative = field(alternative);
        choice.soft = kind == soft;
        std::copy_n(s + parameters, hl::max_parameters, choice.parameters);
        return true;
    }
    choice.restitution = s[restitution];
    return choice.restitution >= 0.0 && choice.restitution <= 1.0;
}

template <int d>
bool grow(const box::Setting& s, hl::u64 seed) {
    hl::Stop never;
    box::Grow<d> growth(s, seed);
    if (!growth.run(never, [](box::GrowthReport) { return true; })) return false;
    const std::vector<double> found = std::move(growth).positions();
    std::copy(found.begin(), found.end(), arrays().position);
    return true;
}

}  // namespace

extern "C" {

// Room for the setting of n particles, which the two numbers are already written to; valid until the next call.
double* box_setting(int dimensions, int n) {
    const std::size_t each = 2 * static_cast<std::size_t>(dimensions) + 2;
    run().setting.assign(fields + static_cast<std::size_t>(n) * each, 0.0);
    run().setting[dimension] = dimensions;
    run().setting[number] = n;
    return run().setting.data();
}
// How many numbers stand before the arrays.
int box_fields() { return fields; }

// Random positions without overlap for the radii and the box of the setting, written to it; whether there were any.
int box_grow(double seed) {
    if (!is_box()) return 0;
    const box::Setting s = setting();
    if (box::fault_of_sizes(s).kind != box::Fault::none || !(box::packing_fraction(s) < 1.0)) return 0;
    const hl::u64 whole = static_cast<hl::u64>(seed);
    return s.dimension == 2 ? grow<2>(s, whole) : grow<3>(s, whole);
}

// Begins a run; 0, or why there is none (see Refusal).
int box_start(int keep_log) {
    run().engine.reset();
    if (!is_box()) return no_such_box;
    box::RuleChoice choice;
    if (!make_rule(choice)) return no_such_rule;
    const box::Setting s = setting();
    if (box::fault_of(s).kind != box::Fault::none) return no_such_start;
    hl::Stop never;
    run().engine = box::make_engine(s, choice, keep_log != 0, never);
    return none;
}

// To `until` [s], or to the instant of row number `most_rows` of the log (0: no limit). Returns the outcome.
int box_advance(double until, double most_rows) {
    hl::Stop never;
    run().engine->advance(until, static_cast<hl::i64>(most_rows), never);
    return static_cast<int>(run().engine->outcome());
}

// Time, then collisions of pairs and with walls, those elastic by tc, soft ones and soft ones with a third body;
// kinetic and potential energy, momentum (3), dissipated energy, virial, ∫ Σ m v'² dt; time, first and second of an
// early end.
double* box_observe() {
    const box::Counts c = run().engine->counts();
    const box::Observation o = run().engine->observe();
    const box::EarlyEnd end = run().engine->early_end();
    run().room = {run().engine->time(),
                  static_cast<double>(c.pairs),
                  static_cast<double>(c.walls),
                  static_cast<double>(c.elastic_by_tc),
                  static_cast<double>(c.soft),
                  static_cast<double>(c.soft_third_body),
                  o.kinetic_energy,
                  o.potential_energy,
                  o.momentum[0],
                  o.momentum[1],
                  o.momentum[2],
                  o.dissipated_energy,
                  o.virial,
                  o.kinetic_integral,
                  end.time,
                  static_cast<double>(end.first),
                  static_cast<double>(end.second)};
    return run().room.data();
}

// Positions (n·d), along continuous paths, then velocities (n·d), now; valid until the next call of this interface.
double* box_state() {
    const std::size_t nd = size_of_box() * static_cast<std::size_t>(field(dimension));
    run().room.resize(2 * nd);
    run().engine->state(run().room.data(), run().room.data() + nd);
    return run().room.data();
}

// The number of collisions logged since the last call; box_log() gives time, first, second (a wall: < 0) and impact
// speed of each.
int box_take_log() {
    run().log = run().engine->take_log();
    return static_cast<int>(run().log.time.size());
}
double* box_log() {
    const box::Log& log = run().log;
    run().room.clear();
    for (std::size_t i = 0; i < log.time.size(); ++i)
        run().room.insert(run().room.end(), {log.time[i], static_cast<double>(log.first[i]),
                                             static_cast<double>(log.second[i]), log.impact_speed[i]});
    return run().room.data();
}

}  // extern "C"
