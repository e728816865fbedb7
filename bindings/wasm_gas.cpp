// C interface to a gas of equal disks as hard spheres and under Newton's equations, for WebAssembly; it only converts
// numbers. The page of the gas loads this module. The same file compiled natively (tests/web/golden_gas.cpp) gives the
// reference values with which the WebAssembly build is compared, bit for bit.
//
// The caller writes its input to gas_setting(): numbers in the order of `Field`, then positions (2n) and velocities
// (2n) and, with friction, angular velocities (n), in SI units. Both engines start from this setting. Worlds: 0 hard
// spheres, 1 Newton's equations.
//
// The module contains one contact law, the linear dashpot (registry.hpp), and disks of one kind in a box at rest:
// smooth ones, or with HARDLIMIT_GAS_RUBS those with friction, whose module is 95 kB larger.
#define HARDLIMIT_LAWS(X) X(LinearDashpot)
#define HARDLIMIT_BOXES_AT_REST
#ifndef HARDLIMIT_GAS_RUBS
#define HARDLIMIT_SMOOTH
#endif

#include <algorithm>
#include <memory>
#include <string_view>
#include <type_traits>
#include <vector>

#include "boxes/binary_contact/planar_contact.hpp"
#include "boxes/common/error_law.hpp"
#include "boxes/common/system_check.hpp"
#include "boxes/hard_spheres/growth.hpp"
#include "boxes/hard_spheres/rules/registry.hpp"
#include "boxes/kernels/kernel_table.hpp"
#include "boxes/newton_events/engine.hpp"

namespace {

namespace hl = hardlimit;
namespace box = hardlimit::boxes;
using Law = hl::contact::LinearDashpot;
using LawOfModule = std::conditional_t<box::particles_rub, hl::WithFriction<Law>, Law>;

enum Field {
    number,                  // n
    radius,                  // [m]
    mass,                    // [kg]
    edges,                   // of the box, two [m]
    periodic = edges + 2,    // two: 1, or 0: walls
    gravity = periodic + 2,  // two [m/s²]
    rule = gravity + 2,      // index in the registry of rules
    restitution,
    stiffness,         // [N/m]
    contact_duration,  // t_c of the rule tc [s]
    friction,          // μ
    stiffness_ratio,   // k_t/k_n
    fields
};

// Reason why a run could not start.
enum Refusal { none, no_such_box, no_such_rule, no_such_law, no_such_start };

using Vectorised = hl::Vector<2>::Real;
const hardlimit_abi::TouchKernels kernels = [] {
    hardlimit_abi::TouchKernels made{
        "wasm", {}, {}, box::series::kernels(), &box::read_wide_cell, box::sample_kernels<Vectorised>()};
    made.of[0][0] = box::touch_kernels_of<Vectorised, 2, box::Motion::straight>();
    made.of[0][1] = box::touch_kernels_of<Vectorised, 2, box::Motion::falling>();
    made.of[0][2] = box::touch_kernels_of<Vectorised, 2, box::Motion::growing>();
    made.enlarged[0] = box::touch_kernels_of<Vectorised, 3, box::Motion::straight, true>();
    made.enlarged[1] = box::touch_kernels_of<Vectorised, 3, box::Motion::falling, true>();
    return made;
}();

struct Gas {
    std::vector<double> setting, radii, masses, spins;
    std::unique_ptr<box::Engine> world[2];
    std::vector<double> out;  // last returned array
};
Gas& gas() {
    static Gas* only = new Gas;
    return *only;
}

double field(Field f) { return gas().setting[f]; }
std::size_t count() { return static_cast<std::size_t>(field(number)); }
double* positions() { return gas().setting.data() + fields; }
double* velocities() { return positions() + 2 * count(); }
double* spins() { return velocities() + 2 * count(); }
std::size_t length() { return fields + (box::particles_rub ? 5 : 4) * count(); }
box::Engine& engine(int world) { return *gas().world[world]; }

box::System system_given() {
    Gas& g = gas();
    box::System s{};
    s.n = count();
    g.radii.assign(s.n, field(radius));
    g.masses.assign(s.n, field(mass));
    s.position = positions(), s.velocity = velocities(), s.radius = g.radii.data(), s.mass = g.masses.data();
    if (box::particles_rub) {
        g.spins.assign(3 * s.n, 0.0);
        for (std::size_t i = 0; i < s.n; ++i) g.spins[3 * i + 2] = spins()[i];
        s.angular_velocity = g.spins.data();
    }
    s.box.dimension = 2;
    for (int k = 0; k < 2; ++k) {
        const auto value = [&](Field f) { return g.setting[static_cast<std::size_t>(f + k)]; };
        s.box.edge[k] = value(edges);
        s.box.boundary[k] = value(periodic) != 0.0 ? box::Boundary::periodic : box::Boundary::wall;
        s.box.gravity[k] = value(gravity);
    }
    return s;
}

box::LawChoice law_given() {
    box::LawChoice law{0, 0, {field(stiffness), field(restitution)}, {}};
    if (field(friction) == 0.0) return law;
    law.friction.coefficient = field(friction), law.friction.stiffness_ratio = field(stiffness_ratio);
    law.friction.damping_ratio = 0.0;
    return law;
}

// Reads the collision rule; false if the module does not contain it or a number is out of its range.
bool read_rule(box::RuleChoice& choice) {
    choice.rule = static_cast<int>(field(rule));
    if (choice.rule < 0 || choice.rule >= box::rule_count) return false;
    const box::RuleRecord& record = box::rule_records[choice.rule];
    if (record.n_parameters > 0) choice.parameters[0] = field(contact_duration);
    if (record.takes_restitution && field(friction) == 0.0)
        choice.restitution = field(restitution);
    else if (record.takes_law)
        choice.law = law_given();
    else
        return false;
    return choice.parameters[0] >= 0.0;
}

// The law of a pair of disks, or of a disk and a wall.
box::Approach approach(double speed, bool wall) {
    return {wall ? field(mass) : 0.5 * field(mass), hl::math::infinity, speed};
}
Law law_of(const box::Approach& a) {
    return Law::from_parameters(0, law_given().parameters, {a.effective_mass, 0.0});
}

}  // namespace

extern "C" {

// Allocates the setting for n disks; valid until the next call.
double* gas_setting(int n) {
    gas().setting.assign(fields + (box::particles_rub ? 5 : 4) * static_cast<std::size_t>(n), 0.0);
    gas().setting[number] = n;
    return gas().setting.data();
}
// Number of values before the arrays.
int gas_fields() { return fields; }

// Writes random positions without overlap to the setting. Returns 0 if none were found.
int gas_place(double seed) {
    const box::System s = system_given();
    if (box::fault_of_sizes(s).kind != box::Fault::none || !(s.packing_fraction() < 1.0)) return 0;
    hl::Stop never;
    box::PackingGrowth<2, false> growth(s, static_cast<hl::u64>(seed));
    if (!growth.run(kernels, never, [](box::GrowthReport) { return true; })) return 0;
    std::ranges::copy(std::move(growth).positions(), positions());
    return 1;
}

// Writes Maxwellian velocities with this root mean square [m/s], and no total momentum along periodic axes; with
// friction also Maxwellian spins with the same energy for each degree of freedom.
void gas_heat(double seed, double rms_speed) {
    const std::size_t n = count();
    double* const v = velocities();
    double square = 0.0;
    box::Random random(static_cast<hl::u64>(seed));
    for (std::size_t i = 0; i < 2 * n; ++i) v[i] = random.normal();
    for (std::size_t k = 0; k < 2; ++k) {
        double mean = 0.0;
        for (std::size_t i = 0; i < n; ++i) mean += v[2 * i + k] / static_cast<double>(n);
        if (gas().setting[periodic + k] == 0.0) mean = 0.0;
        for (std::size_t i = 0; i < n; ++i) v[2 * i + k] -= mean;
    }
    for (std::size_t i = 0; i < 2 * n; ++i) square += v[i] * v[i];
    for (std::size_t i = 0; i < 2 * n; ++i)
        v[i] *= rms_speed / hl::math::sqrt(square / static_cast<double>(n));
    if (!box::particles_rub) return;
    double mean = 0.0;
    for (std::size_t i = 0; i < n; ++i) spins()[i] = random.normal(), mean += spins()[i] * spins()[i];
    // q R² ⟨ω²⟩ = ⟨v²⟩/2
    const double spin = rms_speed / (field(radius) * hl::math::sqrt(2.0 * box::solid_inertia_factor(2)));
    for (std::size_t i = 0; i < n; ++i) spins()[i] *= spin / hl::math::sqrt(mean / static_cast<double>(n));
}

// Contact duration [s] of two disks.
double gas_duration() {
    const box::Approach pair = approach(1.0, false);
    return law_of(pair).duration(1.0, pair.effective_mass);
}

// Greatest compression of an impact at this speed [m/s], in units of the radius. Laws hold below gas_deepest().
double gas_compression(double speed, int wall) {
    const box::Approach impact = approach(speed, wall != 0);
    return box::solve_planar_contact(law_of(impact), impact).greatest / field(radius);
}
double gas_deepest() { return hl::deepest_compression; }

// Starts both worlds; returns 0 or the Refusal.
int gas_start() {
    for (auto& world : gas().world) world.reset();
    const std::size_t given = gas().setting.size();
    if (given < fields || field(number) < 1 || given != length()) return no_such_box;
    box::RuleChoice choice;
    if (!read_rule(choice)) return no_such_rule;
    if (!(field(restitution) > 0.0 && field(restitution) <= 1.0 && field(stiffness) > 0.0))
        return no_such_law;
    if (box::particles_rub ? !(field(friction) > 0.0 && field(stiffness_ratio) > 0.0)
                           : field(friction) != 0.0)
        return no_such_law;
    const box::System s = system_given();
    if (box::validate(s).kind != box::Fault::none) return no_such_start;
    hl::Stop never;
    gas().world[0] = std::make_unique<box::HardSpheres<2, false>>(s, choice, true, kernels, never);
    gas().world[1] = std::make_unique<box::NewtonEvents<LawOfModule>>(
        box::NewtonSetting(s, law_given(), true), s, kernels);
    return none;
}

// Advances a world to `until` [s], by at most `most_work` collisions or events. Returns whether it reached that time
// or has ended.
int gas_advance(int world, double until, double most_work) {
    hl::Stop never;
    engine(world).advance(until, static_cast<hl::u64>(most_work), 1, never);
    return !engine(world).paused();
}

// Returns: time; outcome; contacts begun, of pairs, ended, overlapped; kinetic, potential, contact, dissipated and
// rotational energy; largest compression; collisions made elastic by the rule tc, soft, and soft with a third body;
// events.
double* gas_observe(int world) {
    const box::Engine& e = engine(world);
    const box::Observation o = e.observe();
    const auto real = [](hl::u64 x) { return static_cast<double>(x); };
    gas().out = {e.time(),
                 static_cast<double>(e.outcome()),
                 real(o.begun),
                 real(o.pairs),
                 real(o.ended),
                 real(o.overlapped),
                 o.kinetic_energy,
                 o.potential_energy,
                 o.contact_energy,
                 o.dissipated_energy,
                 o.rotational_energy,
                 o.largest_compression};
    for (const char* name : {"n_elastic_by_tc", "n_soft", "n_soft_third_body", "n_events"}) {
        double value = 0.0;
        for (const box::Statistic& s : e.statistics())
            if (std::string_view(s.name) == name) value = s.value;
        gas().out.push_back(value);
    }
    return gas().out.data();
}

// Current positions, unwrapped across periodic boundaries (2n), then velocities (2n), with friction then angular
// velocities (n); valid until the next call of this interface.
double* gas_state(int world) {
    const std::size_t n = count();
    gas().out.resize(length() - fields);
    engine(world).state(gas().out.data(), gas().out.data() + 2 * n);
    if (box::particles_rub) {
        std::vector<double> spin(3 * n);
        engine(world).spins(spin.data());
        for (std::size_t i = 0; i < n; ++i) gas().out[4 * n + i] = spin[3 * i + 2];
    }
    return gas().out.data();
}

// Returns the number of contacts logged since the last call (open == 0), or of those that are open now. gas_log()
// returns begin, end, first, second (wall: < 0), impact speed, separation speed and whether it overlapped, of each.
int gas_take_log(int world, int open) {
    const auto rows = open ? engine(world).open_contacts() : engine(world).take_log();
    gas().out.clear();
    for (const box::ContactRecord& r : rows)
        gas().out.insert(gas().out.end(),
                         {r.begin, r.end, static_cast<double>(r.first), static_cast<double>(r.second),
                          r.impact_speed, r.separation_speed, r.overlapped ? 1.0 : 0.0});
    return static_cast<int>(rows.size());
}
double* gas_log() { return gas().out.data(); }

const char* gas_outcome(int outcome) { return hl::outcome_records[outcome].message; }

// Name of a rule by its index in the registry; null after the last one.
const char* gas_rule(int index) { return index < box::rule_count ? box::rule_records[index].name : nullptr; }

// --- the law of the error -------------------------------------------------------------------------------------------

namespace law = hardlimit::boxes::error_law;

// Enskog's collision rate [1/s] of disks of this packing fraction, diameter [m] and temperature [m²/s²].
double law_rate(double packing_fraction, double diameter, double temperature) {
    return law::fluid(2, packing_fraction).collision_rate(diameter, temperature);
}
// Rules: constant (0), tc (1), soft (2). `added`, `bar`: what friction adds to a, and its standard error; `wider`: the
// factor of the standard error outside the range of its measurements.
static law::ErrorLaw law_made(double packing_fraction, double restitution, int rule, double added, double bar,
                              double wider) {
    auto made = law::make(law::fluid(2, packing_fraction), restitution, static_cast<law::Rule>(rule));
    made.coefficient += added;
    const double own = made.coefficient_error;
    if (bar > 0.0) made.coefficient_error = wider * hl::math::sqrt(own * own + bar * bar);
    return made;
}
// D 2^D φ χ, and the slope s of the pair correlation at contact.
double* law_fluid(double packing_fraction) {
    const auto fluid = law::fluid(2, packing_fraction);
    gas().out = {fluid.density(), fluid.slope};
    return gas().out.data();
}
// Returns a, its standard error and 2k.
double* law_of_error(double packing_fraction, double restitution, int rule, double added, double bar,
                     double wider) {
    const law::ErrorLaw made = law_made(packing_fraction, restitution, rule, added, bar, wider);
    gas().out = {made.coefficient, made.coefficient_error, made.decay};
    return gas().out.data();
}
// Returns the relative error of the cooling and its standard error.
double* law_errors(double packing_fraction, double restitution, int rule, double added, double bar,
                   double wider, double tc_nu) {
    const law::ErrorLaw made = law_made(packing_fraction, restitution, rule, added, bar, wider);
    gas().out = {made.error(tc_nu), made.error_bar(tc_nu)};
    return gas().out.data();
}
double law_largest(double packing_fraction, double restitution, int rule, double added, double bar,
                   double wider, double error) {
    return law_made(packing_fraction, restitution, rule, added, bar, wider).largest_tc_nu(error);
}
// Returns the smallest and largest packing fraction, the smallest restitution and the largest t_c ν of the
// measurements.
double* law_measured() {
    const law::MeasuredRange& in = law::measured[0];
    gas().out = {in.thinnest, in.densest, in.restitution, law::measured_tc_nu};
    return gas().out.data();
}

}  // extern "C"
