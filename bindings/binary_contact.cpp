// Bindings of one isolated contact: solved in the plane of approach, tabulated, and integrated with a fixed time step.
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <string>
#include <tuple>
#include <vector>

#include "arrays.hpp"
#include "boxes/binary_contact/equivalent_collision.hpp"
#include "boxes/binary_contact/tabulated_contact.hpp"
#include "boxes/binary_contact/turning_contact.hpp"
#include "boxes/newton_steps/time_step.hpp"
#include "contact.hpp"

namespace nb = nanobind;
using namespace nb::literals;
namespace hl = hardlimit;
using hl::bindings::Contact;
using hl::bindings::In;
using hl::bindings::make_array;
using hl::boxes::Approach;

namespace {

// End of a contact and its equivalent collision, as a dict.
nb::dict planar_contact(const Contact& c, double distance, double normal, double tangential, double gravity) {
    const Approach approach{c.pair.effective_mass, distance, normal, tangential, gravity};
    const auto end =
        std::visit([&](const auto& law) { return hl::boxes::solve_planar_contact(law, approach); }, c.law);
    const auto collision = hl::boxes::equivalent_collision(approach, end);
    return hl::bindings::dict_of("outcome", hl::outcome_records[static_cast<int>(end.outcome)].name,
                                 "duration", end.duration, "turn", end.turn, "compression", end.compression,
                                 "radial_speed", end.radial_speed, "tangential_speed", end.tangential_speed,
                                 "normal_velocity", collision.normal_velocity, "tangential_velocity",
                                 collision.tangential_velocity, "normal_shift", collision.normal_shift,
                                 "tangential_shift", collision.tangential_shift);
}

// Compression, its rate and rotation of the line of centres at each time [n, 3].
auto planar_path(const Contact& c, double distance, double normal, double tangential, In times,
                 double gravity) {
    const Approach approach{c.pair.effective_mass, distance, normal, tangential, gravity};
    const std::size_t n = times.shape(0);
    std::vector<hl::boxes::PlanarState> states(n);
    std::visit(
        [&](const auto& law) {
            hl::boxes::sample_planar_contact(law, approach, times.data(), static_cast<long>(n),
                                             states.data());
        },
        c.law);
    std::vector<double> rows;
    for (const auto& s : states) rows.insert(rows.end(), {s.compression, s.rate, s.turn});
    return make_array(std::move(rows), {n, std::size_t{3}});
}

// Duration, rotation of the line of centres, final compression, radial and tangential speed of contacts at these
// speeds, as computed by an event-driven run whose tables are built for the pair `own`.
auto soft_contacts(const Contact& own, double own_distance, bool damping_varies, const Contact& c,
                   double distance, In normal, In tangential) {
    const std::size_t n = normal.shape(0);
    hl::bindings::require_values("tangential_speed", tangential.shape(0), n, "as of normal_speed");
    std::vector<double> rows;
    std::visit(
        [&](const auto& law) {
            using Law = std::decay_t<decltype(law)>;
            const Law* first = std::get_if<Law>(&own.law);
            if (!first) throw nb::value_error("contact: must be of the law of own");
            hl::boxes::TabulatedContacts<Law> contacts(*first, own.pair.effective_mass, own_distance,
                                                       damping_varies);
            for (std::size_t i = 0; i < n; ++i) {
                const auto end =
                    contacts(law, {c.pair.effective_mass, distance, normal.data()[i], tangential.data()[i]});
                rows.insert(rows.end(), {end.duration, end.turn, end.compression, end.radial_speed,
                                         end.tangential_speed});
            }
        },
        c.law);
    return make_array(std::move(rows), {n, std::size_t{5}});
}

using hl::boxes::TurningApproach;

hl::boxes::Vector3 vector_of(const char* name, In x) {
    hl::bindings::require_values(name, x.shape(0), 3, "a vector");
    return {x.data()[0], x.data()[1], x.data()[2]};
}
nb::tuple tuple_of(const hl::boxes::Vector3& v) { return nb::make_tuple(v[0], v[1], v[2]); }

TurningApproach turning_approach(const Contact& c, double distance, double arm, double rotational_ratio,
                                 In normal, In velocity, In spin) {
    return {c.pair.effective_mass,
            distance,
            arm,
            rotational_ratio,
            vector_of("normal", normal),
            vector_of("velocity", velocity),
            vector_of("spin", spin)};
}
template <class Law>
hl::WithFriction<Law> with_friction(const Law& law, const Contact& c) {
    return {law, c.friction};
}

nb::dict turning_contact(const Contact& c, double distance, double arm, double rotational_ratio, In normal,
                         In velocity, In spin) {
    const auto touch = turning_approach(c, distance, arm, rotational_ratio, normal, velocity, spin);
    const auto end = std::visit(
        [&](const auto& law) { return hl::boxes::solve_turning_contact(with_friction(law, c), touch); },
        c.law);
    const int known = end.changes < hl::boxes::most_intervals ? end.changes : hl::boxes::most_intervals;
    return hl::bindings::dict_of(
        "outcome", hl::outcome_records[static_cast<int>(end.outcome)].name, "duration", end.duration, "shift",
        tuple_of(end.shift), "velocity", tuple_of(end.velocity), "spin", tuple_of(end.spin), "normal",
        tuple_of(end.normal), "compression", end.compression, "normal_spring", end.normal_spring,
        "tangential_spring", end.tangential_spring, "normal_damping", end.normal_damping,
        "tangential_damping", end.tangential_damping, "friction", end.slip, "changes", end.changes, "slips_first",
        end.slips_first, "change_times", std::vector<double>(end.change, end.change + known));
}

// States at times since touch [n, 17], up to the end of the contact: shift, velocity, spin, normal, normal force,
// tangential force on the second body, whether the surfaces slip.
auto turning_path(const Contact& c, double distance, double arm, double rotational_ratio, In normal,
                  In velocity, In spin, In times) {
    const auto touch = turning_approach(c, distance, arm, rotational_ratio, normal, velocity, spin);
    std::vector<hl::boxes::TurningState> states(times.shape(0));
    const long n = std::visit(
        [&](const auto& law) {
            return hl::boxes::sample_turning_contact(with_friction(law, c), touch, times.data(),
                                                     static_cast<long>(states.size()), states.data());
        },
        c.law);
    states.resize(static_cast<std::size_t>(n));
    std::vector<double> rows;
    for (const auto& s : states) {
        for (const auto& v : {s.shift, s.velocity, s.spin, s.normal})
            rows.insert(rows.end(), v.begin(), v.end());
        rows.push_back(s.normal_force);
        rows.insert(rows.end(), s.tangential_force.begin(), s.tangential_force.end());
        rows.push_back(s.slips ? 1.0 : 0.0);
    }
    return make_array(std::move(rows), {states.size(), std::size_t{17}});
}

}  // namespace

void bind_binary_contact(nb::module_& m) {
    m.def("planar_contact", &planar_contact, "contact"_a, "distance"_a, "normal_speed"_a,
          "tangential_speed"_a, "gravity"_a = 0.0,
          "Isolated contact of two bodies whose centres are at this distance at touch, in the plane of "
          "approach: its end, and velocity and displacement of the equivalent collision. For a wall: "
          "infinite distance; gravity presses against it.");
    m.def("planar_path", &planar_path, "contact"_a, "distance"_a, "normal_speed"_a, "tangential_speed"_a,
          "times"_a, "gravity"_a = 0.0,
          "Compression, its rate and rotation angle of the line of centres at times since touch [n, 3].");
    m.def("soft_contacts", &soft_contacts, "own"_a, "own_distance"_a, "damping_varies"_a, "contact"_a,
          "distance"_a, "normal_speed"_a, "tangential_speed"_a,
          "Duration, rotation angle, final compression, radial and tangential speed [n, 5] of contacts, as "
          "computed by an event-driven run whose polynomials were fitted for the pair `own`.");
    m.def(
        "turning_contact", &turning_contact, "contact"_a, "distance"_a, "arm"_a, "rotational_ratio"_a,
        "normal"_a, "velocity"_a, "spin"_a,
        "Isolated contact with friction of two bodies, the second relative to the first: its end. The normal "
        "points from the first to the second. For a wall: infinite distance; arm: the radius.");
    m.def("turning_path", &turning_path, "contact"_a, "distance"_a, "arm"_a, "rotational_ratio"_a, "normal"_a,
          "velocity"_a, "spin"_a, "times"_a,
          "States at times since touch [n, 17], up to the end of the contact: shift, velocity, spin, normal, "
          "normal force, tangential force on the second body, whether the surfaces slip.");
    m.def(
        "step_errors",
        [](const Contact& c, double speed, double time_step) {
            const auto found = std::visit(
                [&](const auto& law) {
                    return hl::boxes::steps::contact_errors(law, c.pair.effective_mass, speed, time_step);
                },
                c.law);
            return std::tuple(found.restitution, found.energy, found.position);
        },
        "contact"_a, "speed"_a, "time_step"_a,
        "Largest errors of fixed time steps in an isolated contact: of ε; of the energy balance, "
        "relative to the impact energy; of positions after it, relative to impact speed times duration. "
        "Infinite if a contact does not end.");
    m.def(
        "longest_step",
        [](const Contact& c, double speed, double error) {
            return std::visit(
                [&](const auto& law) {
                    return hl::boxes::steps::longest_step(law, c.pair.effective_mass, speed, error);
                },
                c.law);
        },
        "contact"_a, "speed"_a, "error"_a, "Longest time step whose `step_errors` are at most `error`.");
}
