// Bindings of the contact laws: their records, and one contact of two bodies.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <optional>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>

#include "../core/contact/frictional_impact.hpp"
#include "../core/contact/powers.hpp"
#include "arrays.hpp"
#include "boxes/binary_contact/planar_contact.hpp"
#include "contact.hpp"

namespace nb = nanobind;
using namespace nb::literals;
namespace hl = hardlimit;
using hl::bindings::Contact;
using hl::bindings::dict_of;
using hl::bindings::In;
using hl::bindings::list_of;
using hl::bindings::make_array;
using hl::bindings::map;

namespace {

Contact make_contact(const std::string& name, int alternative, const std::vector<double>& parameters,
                     double mass, double radius, const std::optional<hl::Friction>& friction) {
    const hl::boxes::LawChoice choice = hl::bindings::law_choice(name, alternative, parameters);
    const hl::PairGeometry pair{mass, radius};
    return hl::boxes::with_law<Contact>(choice.law, [&]<class Law>() {
        const Law law = hl::boxes::make_law<Law>(choice, pair);
        Contact contact{law, pair, {}};
        if constexpr (hl::PowerLaw<Law>)
            if (friction)
                contact.friction = hl::friction_terms(*friction, Law::record.powers, law.coefficients());
        return contact;
    });
}

nb::dict parameter_dict(const hl::Parameter& p) {
    return dict_of("name", p.name, "unit", p.unit, "lowest", p.lowest, "highest", p.highest, "lowest_allowed",
                   p.lowest_allowed, "highest_allowed", p.highest_allowed, "meaning", p.meaning);
}

nb::dict friction_record() {
    nb::list parameters, models;
    for (const hl::Parameter& p : hl::friction_parameters) parameters.append(parameter_dict(p));
    for (const hl::FrictionModelRecord& m : hl::friction_models)
        models.append(dict_of("name", m.name, "summary", m.summary, "source", m.source, "loading", m.loading,
                              "unloading", m.unloading));
    return dict_of(
        "parameters", parameters, "models", models, "limits",
        list_of(hl::slip_limit_names, std::size(hl::slip_limit_names), [](const char* n) { return n; }));
}

// What hardlimit.contact.friction.FrictionTerms holds.
using Terms = std::tuple<double, double, int, double, int, int, int, int>;
hl::contact::FrictionalContact frictional_contact(std::tuple<int, int, bool> powers,
                                                  std::pair<double, double> normal, double mass,
                                                  double tangential_mass, const Terms& terms) {
    const auto [coefficient, stiffness, stiffness_power, damping, damping_power, loading, unloading, limit] =
        terms;
    return {{std::get<0>(powers), std::get<1>(powers), std::get<2>(powers)},
            {normal.first, normal.second},
            mass,
            tangential_mass,
            {coefficient,
             {stiffness, stiffness_power},
             {damping, damping_power},
             loading,
             unloading,
             static_cast<hl::SlipLimit>(limit)}};
}

// Intervals of stick and slip, and states at given times, of a contact; scaled.
class ImpactRecorder {
public:
    explicit ImpactRecorder(std::vector<double> times) : times_(std::move(times)), intervals_(*this) {}

    template <class At>
    void operator()(hl::contact::Surfaces surfaces, double begin, double end, const At& at) {
        intervals_(surfaces, begin, end, at);
        while (states.size() < times_.size() && times_[states.size()] <= end)
            states.push_back(at(times_[states.size()]));
    }
    void operator()(bool slip, double begin, double end) {
        slips.push_back(slip);
        begins.push_back(begin);
        ends.push_back(end);
    }
    // Times that rounding error puts after the contact have its last state.
    void finish(const hl::contact::impact::State& last) {
        intervals_.finish();
        states.resize(times_.size(), last);
    }

    std::vector<hl::contact::impact::State> states;
    std::vector<double> slips, begins, ends;

private:
    std::vector<double> times_;
    hl::contact::Intervals<ImpactRecorder> intervals_;
};

nb::dict impact_dict(const hl::contact::FrictionalImpact& r) {
    const auto& e = r.energies;
    return dict_of("solved", r.solved, "restitution", r.restitution, "tangential_restitution",
                   r.tangential_restitution, "duration", r.duration, "normal_impulse", r.normal_impulse,
                   "tangential_impulse", r.tangential_impulse, "normal", e.normal, "tangential", e.tangential,
                   "normal_spring", e.normal_spring, "tangential_spring", e.tangential_spring,
                   "normal_damping", e.normal_damping, "tangential_damping", e.tangential_damping, "friction",
                   e.friction);
}

// The contact with its intervals and its states at the given times, in the units of the user.
nb::dict frictional_impact(const hl::contact::FrictionalContact& contact, double speed, double slip,
                           In times) {
    const double time = contact.time_unit(speed), length = contact.length_unit(speed);
    const double force = contact.mass * speed / time, drag = contact.tangential_mass * slip / time;
    std::vector<double> scaled(times.data(), times.data() + times.shape(0));
    for (double& t : scaled) t /= time;
    ImpactRecorder record(std::move(scaled));
    nb::dict all = impact_dict(hl::contact::frictional_impact(contact, speed, slip, record));
    const auto in_units = [&](const std::vector<double>& values, double unit) {
        return hl::bindings::column_of(values, [&](double x) { return x * unit; });
    };
    const auto sampled = [&](const char* name, double unit, const auto member) {
        all[name] = hl::bindings::column_of(record.states, [&](const auto& s) { return s.*member * unit; });
    };
    using hl::contact::impact::State;
    all["slips"] = in_units(record.slips, 1.0);
    all["begin"] = in_units(record.begins, time);
    all["end"] = in_units(record.ends, time);
    sampled("compression", length, &State::compression);
    sampled("rate", speed, &State::rate);
    sampled("normal_force", force, &State::force);
    sampled("slip_velocity", slip, &State::slip);
    sampled("spring_force", drag, &State::spring);
    sampled("tangential_force", drag, &State::tangential_force);
    return all;
}

nb::tuple friction_terms(const Contact& c) {
    const hl::FrictionTerms& f = c.friction;
    return nb::make_tuple(f.coefficient, f.stiffness.factor, f.stiffness.power, f.damping.factor,
                          f.damping.power, f.loading, f.unloading, static_cast<int>(f.limit));
}

auto force(const Contact& c, In compression, In rate) {
    hl::bindings::require_values("rate", rate.shape(0), compression.shape(0), "as of compression");
    std::vector<double> f(compression.shape(0));
    std::visit(
        [&](const auto& law) {
            using Law = std::decay_t<decltype(law)>;
            for (std::size_t i = 0; i < f.size(); ++i) {
                const double xi = compression.data()[i], at = hl::onset_root<Law::onset_power>(xi);
                f[i] = xi > 0.0 ? hl::math::max(0.0, law.force(at, rate.data()[i])) : 0.0;
            }
        },
        c.law);
    const std::size_t n = f.size();
    return make_array(std::move(f), {n});
}

// The function that applies f(law, value, effective mass) of a contact to each value of an array.
template <class F>
auto elementwise(F f) {
    return [f](const Contact& c, In values) {
        return std::visit(
            [&](const auto& law) {
                return map(values, [&](double x) { return f(law, x, c.pair.effective_mass); });
            },
            c.law);
    };
}

template <class Law>
nb::dict law_record() {
    const hl::LawRecord& r = Law::record;
    nb::list alternatives;
    for (int a = 0; a < r.n_alternatives; ++a) {
        const auto n = static_cast<std::size_t>(r.n_in_alternative[a]);
        alternatives.append(list_of(r.alternatives[a], n, parameter_dict));
    }
    const auto constant = [](const hl::ContactConstant& c) {
        return dict_of("name", c.name, "unit", c.unit, "meaning", c.meaning);
    };
    return dict_of(
        "name", r.name, "class_name", r.class_name, "summary", r.summary, "source", r.source, "powers",
        nb::make_tuple(r.powers.elastic, r.powers.damping), "power_law", hl::PowerLaw<Law>, "common",
        list_of(r.common, static_cast<std::size_t>(r.n_common), parameter_dict), "alternatives", alternatives,
        "constants", list_of(r.constants, static_cast<std::size_t>(r.n_constants), constant));
}

nb::list law_records() {
    nb::list records;
#define HL_APPEND(Law) records.append(law_record<hl::contact::Law>());
    HARDLIMIT_LAWS(HL_APPEND)
#undef HL_APPEND
    return records;
}

}  // namespace

void bind_contacts(nb::module_& m) {
    m.def("law_records", &law_records, "Records of the registered contact laws.");
    m.def("friction_record", &friction_record, "Parameters, models and limits of friction.");
    nb::class_<hl::Friction>(m, "Friction", "Friction as the user gives it; NaN: not given.")
        .def(
            "__init__",
            [](hl::Friction* f, int model, int limit, double coefficient, double stiffness_ratio,
               double stiffness, double damping_ratio, double damping) {
                new (f) hl::Friction{coefficient,
                                     static_cast<hl::FrictionModel>(model),
                                     static_cast<hl::SlipLimit>(limit),
                                     stiffness_ratio,
                                     stiffness,
                                     damping_ratio,
                                     damping};
            },
            "model"_a, "limit"_a, "coefficient"_a, "stiffness_ratio"_a, "stiffness"_a, "damping_ratio"_a,
            "damping"_a);
    nb::class_<Contact>(m, "Contact", "One contact: law, effective mass and radius.")
        .def_prop_ro("effective_mass", [](const Contact& c) { return c.pair.effective_mass; })
        .def_prop_ro("effective_radius", [](const Contact& c) { return c.pair.effective_radius; })
        .def("values",
             [](const Contact& c) {
                 std::vector<double> v(hl::max_parameters);
                 std::visit(
                     [&](const auto& law) {
                         law.values(v.data());
                         v.resize(law.record.n_constants);
                     },
                     c.law);
                 return v;
             })
        .def_prop_ro(
            "coefficients",
            [](const Contact& c) {
                return std::visit(
                    []<class Law>(const Law& law) -> std::optional<std::pair<double, double>> {
                        if constexpr (hl::PowerLaw<Law>)
                            return std::pair(law.coefficients().elastic, law.coefficients().damping);
                        return {};
                    },
                    c.law);
            },
            "K and C of the force K ξ^p + C ξ^q dξ/dt; None if the force is not of this form.")
        .def_prop_ro(
            "friction_terms", &friction_terms,
            "μ, k_t and four times its power, γ_t and four times its power, m while the compression grows "
            "and while it falls, number of the limit.")
        .def("force", &force, "compression"_a, "rate"_a)
        .def("restitution",
             elementwise([](const auto& law, double v, double mass) { return law.restitution(v, mass); }),
             "speed"_a)
        .def("duration",
             elementwise([](const auto& law, double v, double mass) { return law.duration(v, mass); }),
             "speed"_a)
        .def("compression", elementwise([](const auto& law, double v, double mass) {
                 return hl::boxes::solve_planar_contact(law, {mass, hl::math::infinity, v}).greatest;
             }),
             "speed"_a)
        .def("energy", elementwise([](const auto& law, double xi, double) {
                 using Law = std::decay_t<decltype(law)>;
                 return xi > 0.0 ? law.energy(hl::onset_root<Law::onset_power>(xi)) : 0.0;
             }),
             "compression"_a);
    m.def("make_contact", &make_contact, "law"_a, "alternative"_a, "parameters"_a, "effective_mass"_a,
          "effective_radius"_a, "friction"_a = nb::none());
    m.def(
        "tangential_restitution",
        [](std::tuple<int, int, bool> powers, std::pair<double, double> normal, double mass,
           double tangential_mass, const Terms& terms, double speed, In slip) {
            const auto contact = frictional_contact(powers, normal, mass, tangential_mass, terms);
            return map(slip,
                       [&](double g) { return hl::contact::tangential_restitution(contact, speed, g); });
        },
        "powers"_a, "coefficients"_a, "effective_mass"_a, "tangential_mass"_a, "terms"_a, "speed"_a, "slip"_a,
        "β of a contact at each slip velocity at touch.");
    m.def(
        "frictional_impact",
        [](std::tuple<int, int, bool> powers, std::pair<double, double> normal, double mass,
           double tangential_mass, const Terms& terms, double speed, double slip, In times) {
            return frictional_impact(frictional_contact(powers, normal, mass, tangential_mass, terms), speed,
                                     slip, times);
        },
        "powers"_a, "coefficients"_a, "effective_mass"_a, "tangential_mass"_a, "terms"_a, "speed"_a, "slip"_a,
        "times"_a,
        "A contact with this slip velocity at touch: result, intervals of stick and slip, and the motion at the "
        "times, which do not decrease.");
    m.def("inverse_tangential_mass", &hl::inverse_tangential_mass, "mass"_a, "inertia_factor"_a,
          "other_mass"_a, "other_inertia_factor"_a,
          "1/m_t = 1/m_n + R_i²/I_i + R_j²/I_j; masses of walls are infinite.");
    m.def("effective", &hl::effective, "a"_a, "b"_a, "a b/(a + b); also if one of them is infinite.");
    using hl::contact::viscoelastic_collision;
    const auto over = [](auto f) { return [f](In values) { return map(values, f); }; };
    m.def("viscoelastic_restitution", over([](double x) { return viscoelastic_collision(x).restitution; }),
          "x"_a);
    m.def("viscoelastic_duration", over([](double x) { return viscoelastic_collision(x).duration; }), "x"_a);
    m.attr("series_coefficients") =
        nb::tuple(list_of(hl::contact::series_coefficients, [](double h) { return h; }));
    m.def("linear_restitution",
          over([](double b) { return hl::math::exp(-hl::contact::linear_loss_exponent(b)); }),
          "damping_ratio"_a);
    m.def("linear_duration", over(&hl::contact::linear_scaled_duration<double>), "damping_ratio"_a);
    m.def(
        "power_collision",
        [](int elastic, int damping, bool attracts, double c) {
            const auto r = hl::contact::power_collision({elastic, damping, attracts}, c);
            return nb::make_tuple(r.restitution, r.duration, r.compression, r.force);
        },
        "elastic"_a, "damping"_a, "attracts"_a, "c"_a,
        "ε, duration, largest compression and force of X'' + X^(elastic/4) + c X^(damping/4) X' = 0, "
        "X(0) = 0, X'(0) = 1.");
    m.def(
        "power_damping",
        [](int elastic, int damping, bool attracts, double restitution) {
            return hl::contact::power_damping({elastic, damping, attracts}, restitution);
        },
        "elastic"_a, "damping"_a, "attracts"_a, "restitution"_a,
        "The damping c for which power_collision gives this ε in (0, 1].");
}
