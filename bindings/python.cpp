// Python bindings: conversion and release of the interpreter lock, nothing else.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include <memory>
#include <variant>

#include "column/exact/drop.hpp"
#include "column/general/sample.hpp"
#include "column/independent.hpp"
#include "contact/registry.hpp"

namespace nb = nanobind;
using namespace nb::literals;
namespace hl = hardlimit;
namespace col = hardlimit::column;

namespace {

using In = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Out = nb::ndarray<nb::numpy, double>;
using OutInt = nb::ndarray<nb::numpy, int>;

template <class T>
auto make_array(std::vector<T>&& values, std::initializer_list<std::size_t> shape) {
    auto* owned = new std::vector<T>(std::move(values));
    nb::capsule owner(owned, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
    return nb::ndarray<nb::numpy, T>(owned->data(), shape, owner);
}

// One contact of any registered law, with what it knows of its bodies.
#define HL_COMMA_TYPE(name) , hl::contact::name
template <class First, class... Rest>
using VariantOf = std::variant<Rest...>;
using AnyLaw = VariantOf<void HARDLIMIT_LAWS(HL_COMMA_TYPE)>;

struct Contact {
    AnyLaw law;
    hl::PairGeometry pair;
};

template <class F>
void for_each_law(F&& f) {
#define HL_VISIT(name) f.template operator()<hl::contact::name>();
    HARDLIMIT_LAWS(HL_VISIT)
#undef HL_VISIT
}

Contact make_contact(const std::string& name, int alternative, const std::vector<double>& parameters,
                     double mass, double radius) {
    Contact made{};
    bool found = false;
    for_each_law([&]<class Law>() {
        if (name != Law::record.name) return;
        made = {Law::from_parameters(alternative, parameters.data(), {mass, radius}), {mass, radius}};
        found = true;
    });
    if (!found) throw nb::value_error(("law: unknown name " + name).c_str());
    return made;
}

template <class F>
Out map(In x, F&& f) {
    std::vector<double> y(x.shape(0));
    const double* data = x.data();
    {
        nb::gil_scoped_release unlocked;
        for (std::size_t i = 0; i < y.size(); ++i) y[i] = f(data[i]);
    }
    const std::size_t n = y.size();
    return make_array(std::move(y), {n});
}

// ξ^(1/p) for the root coordinate of a law.
template <class Law>
double root_coordinate(double compression) {
    static_assert(Law::onset_power == 1 || Law::onset_power == 2);
    return Law::onset_power == 1 ? compression : hl::math::sqrt(compression);
}

Out force(const Contact& c, In compression, In rate) {
    std::vector<double> f(compression.shape(0));
    std::visit(
        [&](const auto& law) {
            using Law = std::decay_t<decltype(law)>;
            for (std::size_t i = 0; i < f.size(); ++i) {
                const double xi = compression.data()[i];
                f[i] =
                    xi > 0.0 ? hl::math::max(0.0, law.force(root_coordinate<Law>(xi), rate.data()[i])) : 0.0;
            }
        },
        c.law);
    const std::size_t n = f.size();
    return make_array(std::move(f), {n});
}

nb::dict parameter_dict(const hl::Parameter& p) {
    nb::dict d;
    d["name"] = p.name;
    d["unit"] = p.unit;
    d["lowest"] = p.lowest;
    d["highest"] = p.highest;
    d["lowest_allowed"] = p.lowest_allowed;
    d["highest_allowed"] = p.highest_allowed;
    d["meaning"] = p.meaning;
    return d;
}

nb::list law_records() {
    nb::list laws;
    for_each_law([&]<class Law>() {
        const hl::LawRecord& r = Law::record;
        nb::dict d;
        d["name"] = r.name;
        d["class_name"] = r.class_name;
        d["summary"] = r.summary;
        d["source"] = r.source;
        nb::list common, alternatives, contact;
        for (int i = 0; i < r.n_common; ++i) common.append(parameter_dict(r.common[i]));
        for (int a = 0; a < r.n_alternatives; ++a) {
            nb::list one;
            for (int i = 0; i < r.n_in_alternative[a]; ++i) one.append(parameter_dict(r.alternatives[a][i]));
            alternatives.append(one);
        }
        for (int i = 0; i < r.n_contact; ++i) contact.append(r.contact_parameters[i]);
        d["common"] = common;
        d["alternatives"] = alternatives;
        d["contact_parameters"] = contact;
        laws.append(d);
    });
    return laws;
}

// A column under any law.
#define HL_COMMA_COLUMN(name) , col::Column<hl::contact::name>
using AnyColumn = VariantOf<void HARDLIMIT_LAWS(HL_COMMA_COLUMN)>;

struct PyColumn {
    AnyColumn value;
};

PyColumn make_column(bool floor, double gravity, std::vector<double> mass, std::vector<double> radius,
                     const std::vector<Contact>& contacts, std::vector<double> gaps,
                     std::vector<double> velocity) {
    PyColumn made;
    const bool same = std::visit(
        [&](const auto& first) {
            using Law = std::decay_t<decltype(first)>;
            col::Column<Law> c{
                static_cast<int>(mass.size()), floor, gravity, mass, radius, {}, gaps, velocity};
            for (const Contact& k : contacts) {
                const Law* law = std::get_if<Law>(&k.law);
                if (!law) return false;
                c.contacts.push_back(*law);
            }
            made.value = std::move(c);
            return true;
        },
        contacts.front().law);
    if (!same) throw nb::value_error("law: every contact of a column must follow the same kind of law");
    return made;
}

// States at the times asked for.
struct Samples {
    std::size_t n, balls;
    std::vector<double> position, velocity, force, kinetic, potential, stored, dissipated;
    Samples(std::size_t n_, std::size_t balls_)
        : n(n_),
          balls(balls_),
          position(n_ * balls_),
          velocity(n_ * balls_),
          force(n_ * balls_),
          kinetic(n_),
          potential(n_),
          stored(n_),
          dissipated(n_) {}
};

// What every solver returns.
struct Solution {
    col::Sequence sequence;
    std::vector<col::Contact> contacts;
    double t_first = hl::math::nan, t_last = hl::math::nan;  // span that can be sampled
    long steps = 0;
    double energy_error = hl::math::nan;
    virtual ~Solution() = default;
    virtual void sample(const double* times, Samples& out) = 0;
};

struct ExactSolution final : Solution {
    col::LinearColumn column;
    col::Drop drop;
    ExactSolution(const col::LinearColumn& c, col::Coupling coupling, double until)
        : column(c), drop(col::solve_drop(c, coupling, until)) {
        sequence = drop.sequence;
        contacts = drop.contacts;
        steps = static_cast<long>(drop.nodes.size());
        if (drop.nodes.empty()) return;
        t_first = drop.nodes.front().t / drop.start.units.rate;
        t_last = drop.nodes.back().t / drop.start.units.rate;
    }
    void sample(const double* times, Samples& out) override {
        for (std::size_t i = 0; i < out.n; ++i) {
            const col::DropSample s = col::sample_drop(column, drop, times[i]);
            out.position[2 * i] = s.u + column.radius[0];
            out.position[2 * i + 1] = s.u + s.w + 2.0 * column.radius[0] + column.radius[1];
            out.velocity[2 * i] = s.du;
            out.velocity[2 * i + 1] = s.du + s.dw;
            out.force[2 * i] = s.force_floor;
            out.force[2 * i + 1] = s.force_pair;
            out.kinetic[i] = s.kinetic;
            out.potential[i] = s.potential;
            out.stored[i] = s.stored;
            out.dissipated[i] = s.dissipated;
        }
    }
};

template <class Law>
struct IndependentSolution final : Solution {
    col::Column<Law> column;
    col::IndependentRun run;
    IndependentSolution(const col::Column<Law>& c, double until)
        : column(c), run(col::solve_independent(c, until)) {
        sequence = run.sequence;
        contacts = run.contacts;
        steps = static_cast<long>(run.contacts.size()) + 1;
        t_first = run.t_first;
        t_last = run.t_last;
    }
    double mechanical(const col::Flight& f, Samples* out, std::size_t i) const {
        double kinetic = 0.0, potential = 0.0, height = 0.0, position = f.gaps[0] + column.radius[0];
        for (int j = 0; j < column.balls; ++j) {
            if (j > 0) position += column.radius[j - 1] + f.gaps[j] + column.radius[j];
            kinetic += 0.5 * column.mass[j] * f.velocity[j] * f.velocity[j];
            height += f.gaps[j];
            potential += column.gravity * column.mass[j] * height;
            if (out) {
                out->position[i * out->balls + j] = position;
                out->velocity[i * out->balls + j] = f.velocity[j];
            }
        }
        if (out) {
            out->kinetic[i] = kinetic;
            out->potential[i] = potential;
        }
        return kinetic + potential;
    }
    void sample(const double* times, Samples& out) override {
        const double initial = mechanical(run.states.front(), nullptr, 0);
        col::IndependentMotion motion(column, run);
        for (std::size_t i = 0; i < out.n; ++i)
            out.dissipated[i] = initial - mechanical(motion.at(times[i]), &out, i);
    }
};

template <class Law>
struct IntegratedSolution final : Solution {
    col::Column<Law> column;
    col::Integration<Law> run;
    IntegratedSolution(const col::Column<Law>& c, double until, double tolerance) : column(c) {
        col::IntegrateOptions options;
        options.tolerance = tolerance;
        options.until = until;
        options.record = true;
        run = col::integrate(c, options);
        sequence = run.sequence;
        contacts = run.contacts;
        steps = run.steps;
        energy_error = run.energy_error;
        if (run.intervals.empty()) return;
        t_first = run.intervals.front().t;
        t_last = run.intervals.back().t;
    }
    void sample(const double* times, Samples& out) override {
        std::vector<double> gaps(out.n * out.balls);
        std::vector<col::Energies> energies(out.n);
        col::sample(column, run, times, static_cast<long>(out.n),
                    col::Samples{gaps.data(), out.velocity.data(), out.force.data(), energies.data()});
        for (std::size_t i = 0; i < out.n; ++i) {
            double z = 0.0;
            for (std::size_t j = 0; j < out.balls; ++j) {
                z += gaps[i * out.balls + j] + column.radius[j] + (j > 0 ? column.radius[j - 1] : 0.0);
                out.position[i * out.balls + j] = z;
            }
            out.kinetic[i] = energies[i].kinetic;
            out.potential[i] = energies[i].potential;
            out.stored[i] = energies[i].contact;
            out.dissipated[i] = energies[i].dissipated;
        }
    }
};

std::unique_ptr<Solution> newton(const PyColumn& c, double until, bool general, double tolerance) {
    nb::gil_scoped_release unlocked;
    return std::visit(
        [&](const auto& column) -> std::unique_ptr<Solution> {
            using Law = std::decay_t<decltype(column.contacts[0])>;
            if constexpr (std::is_same_v<Law, hl::contact::LinearDashpot>)
                if (!general && column.floor && column.balls == 2)
                    return std::make_unique<ExactSolution>(column, col::Coupling::full, until);
            return std::make_unique<IntegratedSolution<Law>>(column, until, tolerance);
        },
        c.value);
}

std::unique_ptr<Solution> adiabatic(const PyColumn& c, double until) {
    const auto* linear = std::get_if<col::LinearColumn>(&c.value);
    if (!linear || !linear->floor || linear->balls != 2)
        throw nb::value_error(
            "column: the adiabatic solution is that of two balls on a floor under the linear law");
    nb::gil_scoped_release unlocked;
    return std::make_unique<ExactSolution>(*linear, col::Coupling::adiabatic, until);
}

std::unique_ptr<Solution> independent(const PyColumn& c, double until) {
    nb::gil_scoped_release unlocked;
    return std::visit(
        [&](const auto& column) -> std::unique_ptr<Solution> {
            using Law = std::decay_t<decltype(column.contacts[0])>;
            return std::make_unique<IndependentSolution<Law>>(column, until);
        },
        c.value);
}

auto contact_arrays(const Solution& s) {
    const std::size_t n = s.contacts.size();
    std::vector<int> pair(n);
    std::vector<double> begin(n), end(n);
    for (std::size_t i = 0; i < n; ++i) {
        pair[i] = s.contacts[i].pair;
        begin[i] = s.contacts[i].begin;
        end[i] = s.contacts[i].end;
    }
    return std::tuple(make_array(std::move(pair), {n}), make_array(std::move(begin), {n}),
                      make_array(std::move(end), {n}));
}

auto sample(Solution& s, In times, std::size_t balls) {
    Samples out(times.shape(0), balls);
    {
        nb::gil_scoped_release unlocked;
        s.sample(times.data(), out);
    }
    const std::size_t n = out.n;
    return std::tuple(make_array(std::move(out.position), {n, balls}),
                      make_array(std::move(out.velocity), {n, balls}),
                      make_array(std::move(out.force), {n, balls}), make_array(std::move(out.kinetic), {n}),
                      make_array(std::move(out.potential), {n}), make_array(std::move(out.stored), {n}),
                      make_array(std::move(out.dissipated), {n}));
}

void bind_contacts(nb::module_& m) {
    m.def("law_records", &law_records, "What the registered contact laws state about themselves.");
    nb::class_<Contact>(m, "Contact", "One contact: law, effective mass and radius.")
        .def_prop_ro("effective_mass", [](const Contact& c) { return c.pair.effective_mass; })
        .def_prop_ro("effective_radius", [](const Contact& c) { return c.pair.effective_radius; })
        .def("values",
             [](const Contact& c) {
                 std::vector<double> v(hl::max_parameters);
                 std::visit(
                     [&](const auto& law) {
                         law.values(v.data());
                         v.resize(law.record.n_contact);
                     },
                     c.law);
                 return v;
             })
        .def("force", &force, "compression"_a, "rate"_a)
        .def(
            "restitution",
            [](const Contact& c, In speed) {
                return std::visit(
                    [&](const auto& law) {
                        return map(speed,
                                   [&](double v) { return law.restitution(v, c.pair.effective_mass); });
                    },
                    c.law);
            },
            "speed"_a)
        .def(
            "duration",
            [](const Contact& c, In speed) {
                return std::visit(
                    [&](const auto& law) {
                        return map(speed, [&](double v) { return law.duration(v, c.pair.effective_mass); });
                    },
                    c.law);
            },
            "speed"_a)
        .def(
            "energy",
            [](const Contact& c, In compression) {
                return std::visit(
                    [&](const auto& law) {
                        using Law = std::decay_t<decltype(law)>;
                        return map(compression, [&](double xi) {
                            return xi > 0.0 ? law.energy(root_coordinate<Law>(xi)) : 0.0;
                        });
                    },
                    c.law);
            },
            "compression"_a);
    m.def("make_contact", &make_contact, "law"_a, "alternative"_a, "parameters"_a, "effective_mass"_a,
          "effective_radius"_a);
    m.def("effective", &hl::effective, "a"_a, "b"_a, "a b/(a + b), also for an infinite partner.");
    m.def(
        "viscoelastic_restitution",
        [](In x) {
            return map(x, [](double v) { return hl::contact::viscoelastic_collision(v).restitution; });
        },
        "x"_a);
    m.def(
        "viscoelastic_duration",
        [](In x) { return map(x, [](double v) { return hl::contact::viscoelastic_collision(v).duration; }); },
        "x"_a);
    m.def(
        "viscoelastic_series",
        [](In x, int terms) {
            return map(x, [=](double v) { return hl::contact::viscoelastic_series(v, terms); });
        },
        "x"_a, "terms"_a = hl::contact::series_terms);
    m.def(
        "viscoelastic_pade",
        [](In x, int p, int q) {
            if (p < 0 || q < 0 || q > 6 || p + q >= hl::contact::series_terms)
                throw nb::value_error("orders: need numerator + denominator <= 9, denominator <= 6");
            return map(x, [=](double v) { return hl::contact::viscoelastic_pade(v, p, q); });
        },
        "x"_a, "numerator"_a, "denominator"_a);
    m.def(
        "linear_restitution",
        [](In b) {
            return map(b, [](double v) { return hl::math::exp(-hl::contact::linear_loss_exponent(v)); });
        },
        "damping_ratio"_a);
    m.def(
        "linear_duration", [](In b) { return map(b, &hl::contact::linear_scaled_duration<double>); },
        "damping_ratio"_a);
}

void bind_math(nb::module_& m) {
    m.def(
        "math",
        [](const std::string& name, In x) {
            namespace hm = hl::math;
            const std::pair<const char*, double (*)(double)> functions[] = {{"exp", &hm::exp<double>},
                                                                            {"log", &hm::log<double>},
                                                                            {"log1p", &hm::log1p<double>},
                                                                            {"sin", &hm::sin<double>},
                                                                            {"cos", &hm::cos<double>}};
            for (const auto& [known, f] : functions)
                if (name == known) return map(x, f);
            throw nb::value_error("name: exp, log, log1p, sin or cos");
        },
        "name"_a, "x"_a, "The core's own elementary functions, for their tests.");
    m.def("atan2_upper", &hl::math::atan2_upper<double>, "y"_a, "x"_a);
}

void bind_columns(nb::module_& m) {
    nb::class_<PyColumn>(m, "Column", "A column of balls in SI units.");
    m.def("make_column", &make_column, "floor"_a, "gravity"_a, "mass"_a, "radius"_a, "contacts"_a, "gaps"_a,
          "velocity"_a);
    nb::class_<Solution>(m, "Solution", "What a solver found.")
        .def_prop_ro("n_contacts", [](const Solution& s) { return s.sequence.n_contacts; })
        .def_prop_ro("t_end", [](const Solution& s) { return s.sequence.t_end; })
        .def_prop_ro("t_floor_end", [](const Solution& s) { return s.sequence.t_floor_end; })
        .def_prop_ro("relative_velocity", [](const Solution& s) { return s.sequence.relative_velocity; })
        .def_prop_ro("separation_velocity", [](const Solution& s) { return s.sequence.separation_velocity; })
        .def_prop_ro("outcome", [](const Solution& s) { return static_cast<int>(s.sequence.outcome); })
        .def_ro("t_first", &Solution::t_first)
        .def_ro("t_last", &Solution::t_last)
        .def_ro("steps", &Solution::steps)
        .def_ro("energy_error", &Solution::energy_error)
        .def("contacts", &contact_arrays)
        .def("sample", &sample, "times"_a, "balls"_a);
    m.def("newton", &newton, "column"_a, "until"_a, "general"_a, "tolerance"_a);
    m.def("adiabatic", &adiabatic, "column"_a, "until"_a);
    m.def("independent", &independent, "column"_a, "until"_a);
    m.def("fall_time", &col::fall_time, "gap"_a, "velocity"_a, "gravity"_a);
    m.def("impact_speed", &col::impact_speed, "gap"_a, "velocity"_a, "gravity"_a);
    m.def("effective_restitution", &col::effective_restitution<double>, "relative_velocity"_a,
          "impact_speed"_a);
}

}  // namespace

void bind_sweep(nb::module_& m);

NB_MODULE(_core, m) {
    nb::set_leak_warnings(false);  // objects alive at exit, in a traceback say, are no fault
    m.attr("version") = HARDLIMIT_VERSION;
    nb::list names, messages;
    for (const hl::OutcomeRecord& r : hl::outcome_records) {
        names.append(r.name);
        messages.append(r.message);
    }
    m.attr("outcome_names") = nb::tuple(names);
    m.attr("outcome_messages") = nb::tuple(messages);
    bind_contacts(m);
    bind_math(m);
    bind_columns(m);
    bind_sweep(m);
}
