// Bindings of one isolated contact: solved in the plane of approach, tabulated, and integrated with a fixed time step.
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <string>
#include <tuple>
#include <vector>

#include "arrays.hpp"
#include "boxes/binary_contact/equivalent_collision.hpp"
#include "boxes/binary_contact/tabulated_contact.hpp"
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
