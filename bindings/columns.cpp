// Bindings of the column solvers: column in, Solution out. The solvers run without the interpreter lock.
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <memory>
#include <string>
#include <type_traits>
#include <variant>

#include "arrays.hpp"
#include "column/comparison.hpp"
#include "column/model.hpp"
#include "contact.hpp"

namespace nb = nanobind;
using namespace nb::literals;
namespace hl = hardlimit;
namespace col = hardlimit::column;
using hl::bindings::Contact;
using hl::bindings::In;
using hl::bindings::make_array;
using hl::bindings::require_values;
using hl::bindings::shown;
using hl::bindings::unlocked;
using hl::bindings::value_error;

namespace {

// A column under any law; shared with its solutions.
struct Column {
    hl::bindings::OfEachLaw<col::SharedColumn>::Variant value;
};

template <class Law>
col::SharedColumn<Law> column_under(bool floor, double gravity, const std::vector<double>& mass,
                                    const std::vector<double>& radius, const std::vector<Contact>& contacts,
                                    const std::vector<double>& gaps, const std::vector<double>& velocity) {
    std::vector<Law> laws;
    for (const Contact& k : contacts) {
        const Law* law = std::get_if<Law>(&k.law);
        if (!law) throw value_error("law: every contact of a column must follow the same kind of law");
        laws.push_back(*law);
    }
    return std::make_shared<const col::Column<Law>>(col::Column<Law>{.balls = static_cast<int>(mass.size()),
                                                                     .floor = floor,
                                                                     .gravity = gravity,
                                                                     .mass = mass,
                                                                     .radius = radius,
                                                                     .contacts = std::move(laws),
                                                                     .gaps = gaps,
                                                                     .velocity = velocity});
}

Column make_column(bool floor, double gravity, const std::vector<double>& mass,
                   const std::vector<double>& radius, const std::vector<Contact>& contacts,
                   const std::vector<double>& gaps, const std::vector<double>& velocity) {
    if (mass.empty()) throw value_error("mass: got no values, must be one for each ball");
    require_values("radius", radius.size(), mass.size(), "one for each ball");
    require_values("contacts", contacts.size(), mass.size(), "one for each ball");
    require_values("gaps", gaps.size(), mass.size(), "one for each ball");
    require_values("velocity", velocity.size(), mass.size(), "one for each ball");
    return std::visit(
        [&](const auto& law) {
            using Law = std::decay_t<decltype(law)>;
            return Column{column_under<Law>(floor, gravity, mass, radius, contacts, gaps, velocity)};
        },
        contacts.front().law);
}

// Result of a solver, with its column and options.
struct Solution {
    Column column;
    col::Model model;
    col::SolveOptions options;
    std::unique_ptr<col::Solution> found;
    std::size_t balls;

    const col::Sequence& sequence() const { return found->sequence; }
};

Solution solve(const Column& c, col::Model model, col::SolveOptions options) {
    return std::visit(
        [&](const auto& column) {
            auto found = unlocked([&](hl::Stop& stop) {
                col::SolveOptions stoppable = options;
                stoppable.stop = &stop;
                return col::solve_column(column, model, stoppable);
            });
            if (!found)
                throw value_error(
                    "column: the adiabatic solution is that of two balls on a floor under the linear law");
            return Solution{c, model, options, std::move(found), column->mass.size()};
        },
        c.value);
}

// Calls f(column, options) for the column of a solution without the interpreter lock; Ctrl-C stops it.
template <class F>
auto continue_from(const Solution& s, const F& f) {
    return std::visit(
        [&](const auto& column) {
            return unlocked([&](hl::Stop& stop) {
                col::SolveOptions options = s.options;
                options.stop = &stop;
                return f(column, options);
            });
        },
        s.column.value);
}

std::vector<double> rebound_heights(const Solution& s) {
    return continue_from(s, [&](const auto& column, const col::SolveOptions& options) {
        return col::rebound_heights(column, s.model, options, *s.found);
    });
}

col::Comparison compare(const Solution& newton, const Solution& independent, double tolerance) {
    return continue_from(newton, [&](const auto& column, const col::SolveOptions& options) {
        return col::compare_models(column, options, *newton.found, *independent.found, tolerance);
    });
}

auto contact_arrays(const Solution& s) {
    const auto column = [&](auto member) {
        return hl::bindings::column_of(s.found->contacts, [=](const col::Contact& k) { return k.*member; });
    };
    return std::tuple(column(&col::Contact::pair), column(&col::Contact::begin), column(&col::Contact::end));
}

void require_recorded(const col::Solution& s, const double* times, std::size_t n) {
    const hl::Outcome outcome = s.sequence.outcome;
    const std::string why = outcome == hl::Outcome::ok ? "" : std::string(": ") + hl::message(outcome);
    for (std::size_t i = 0; i < n; ++i)
        if (!(times[i] >= s.first && times[i] <= s.last))
            throw value_error("times: got " + shown(times[i]) + ", must be >= " + shown(s.first) +
                              " and <= " + shown(s.last) + ", where the solution ends" + why);
}

// Arrays returned to Python, appended in chunks of a few thousand times.
struct Trajectory {
    std::vector<double> position, velocity, force, kinetic, potential, stored, dissipated;

    void append(const col::States& s) {
        const auto add = [](std::vector<double>& to, const std::vector<double>& from) {
            to.insert(to.end(), from.begin(), from.end());
        };
        add(position, s.position);
        add(velocity, s.velocity);
        add(force, s.force);
        for (const col::Energies& e : s.total) {
            kinetic.push_back(e.kinetic);
            potential.push_back(e.potential);
            stored.push_back(e.contact);
            dissipated.push_back(e.dissipated);
        }
    }
};

// Height of the first ball's centre in a cradle at release [m].
double origin(const Column& c) {
    return std::visit([](const auto& column) { return column->gaps[0] + column->radius[0]; }, c.value);
}

auto sample(const Solution& s, In times) {
    constexpr std::size_t most = 4096;
    const std::size_t n = times.shape(0), balls = s.balls;
    const double* t = times.data();
    require_recorded(*s.found, t, n);
    Trajectory all = unlocked([&](hl::Stop& stop) {
        Trajectory rows;
        s.found->prepare(stop);
        for (std::size_t i = 0; i < n && !stop.now(); i += most) {
            col::States some(std::min(most, n - i), static_cast<int>(balls), origin(s.column));
            s.found->sample(t + i, some);
            rows.append(some);
        }
        return rows;
    });
    return std::tuple(make_array(std::move(all.position), {n, balls}),
                      make_array(std::move(all.velocity), {n, balls}),
                      make_array(std::move(all.force), {n, balls}), make_array(std::move(all.kinetic), {n}),
                      make_array(std::move(all.potential), {n}), make_array(std::move(all.stored), {n}),
                      make_array(std::move(all.dissipated), {n}));
}

nb::list model_records() {
    return hl::bindings::list_of(col::model_records, [](const col::ModelRecord& r) {
        return hl::bindings::dict_of("name", r.name, "label", r.label, "short", r.short_label, "limits",
                                     r.limits);
    });
}

}  // namespace

void bind_columns(nb::module_& m) {
    m.def("model_records", &model_records,
          "The models of a column, in order of their numbers: name, labels, limits.");
    nb::class_<Column>(m, "Column", "A column of balls in SI units.");
    m.def("make_column", &make_column, "floor"_a, "gravity"_a, "mass"_a, "radius"_a, "contacts"_a, "gaps"_a,
          "velocity"_a);
    nb::class_<Solution>(m, "Solution", "Result of a column solver.")
        .def_prop_ro("n_contacts", [](const Solution& s) { return s.sequence().n_contacts; })
        .def_prop_ro("t_end", [](const Solution& s) { return s.sequence().t_end; })
        .def_prop_ro("t_floor_end", [](const Solution& s) { return s.sequence().t_floor_end; })
        .def_prop_ro("relative_velocity", [](const Solution& s) { return s.sequence().relative_velocity; })
        .def_prop_ro("separation_velocity",
                     [](const Solution& s) { return s.sequence().separation_velocity; })
        .def_prop_ro("outcome", [](const Solution& s) { return static_cast<int>(s.sequence().outcome); })
        .def_prop_ro("t_first", [](const Solution& s) { return s.found->first; })
        .def_prop_ro("t_last", [](const Solution& s) { return s.found->last; })
        .def_prop_ro("steps", [](const Solution& s) { return s.found->steps; })
        .def_prop_ro("energy_error", [](const Solution& s) { return s.found->energy_error; })
        .def_prop_ro("too_deep", [](const Solution& s) { return s.found->too_deep; })
        .def("largest_compression", [](const Solution& s) { return s.found->largest_compression(); })
        .def(
            "presses_by", [](const Solution& s, double part) { return s.found->presses_by(part); }, "part"_a)
        .def("contacts", &contact_arrays)
        .def("rebound_heights", &rebound_heights,
             "Largest height of each centre after its first bounce [m]; NaN where there is none.")
        .def(
            "final_velocities",
            [](const Solution& s) {
                return col::final_velocities(*s.found, static_cast<int>(s.balls), s.options.until);
            },
            "Velocities after the last contact that ended [m/s]; NaN at rest.")
        .def("sample", &sample, "times"_a);
    m.def(
        "newton",
        [](const Column& c, double until, bool general, double tolerance) {
            return solve(c, col::Model::newton, {.until = until, .general = general, .tolerance = tolerance});
        },
        "column"_a, "until"_a, "general"_a, "tolerance"_a);
    const auto under = [](col::Model model) {
        return [model](const Column& c, double until) { return solve(c, model, {.until = until}); };
    };
    nb::class_<col::Comparison>(m, "Comparison", "Independent collisions compared with Newton's equations.")
        .def_prop_ro("answer",
                     [](const col::Comparison& c) { return col::answer_names[static_cast<int>(c.answer)]; })
        .def_prop_ro("ground",
                     [](const col::Comparison& c) { return col::ground_names[static_cast<int>(c.ground)]; })
        .def_ro("overlapping", &col::Comparison::overlapping)
        .def_ro("error", &col::Comparison::error)
        .def_ro("independent", &col::Comparison::independent)
        .def_ro("newton", &col::Comparison::newton)
        .def_ro("ball", &col::Comparison::ball)
        .def_ro("later", &col::Comparison::later);
    m.def("compare", &compare, "newton"_a, "independent"_a, "tolerance"_a);
    m.def("adiabatic", under(col::Model::adiabatic), "column"_a, "until"_a);
    m.def("independent", under(col::Model::independent), "column"_a, "until"_a);
    m.def("fall_time", &col::fall_time, "gap"_a, "velocity"_a, "gravity"_a);
    m.def("impact_speed", &col::impact_speed, "gap"_a, "velocity"_a, "gravity"_a);
    m.def("effective_restitution", &col::effective_restitution<double>, "relative_velocity"_a,
          "impact_speed"_a);
}
