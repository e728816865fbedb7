// Bindings of the contact laws: their records, and one contact of two bodies.
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <string>
#include <type_traits>

#include "../core/contact/powers.hpp"
#include "arrays.hpp"
#include "boxes/binary_contact/planar_contact.hpp"
#include "contact.hpp"

namespace nb = nanobind;
using namespace nb::literals;
namespace hl = hardlimit;
using hl::bindings::Contact;
using hl::bindings::In;
using hl::bindings::make_array;
using hl::bindings::map;

namespace {

template <class F>
void for_each_law(F&& f) {
#define HL_VISIT(name) f.template operator()<hl::contact::name>();
    HARDLIMIT_LAWS(HL_VISIT)
#undef HL_VISIT
}

template <class Law>
Law from_parameters(int alternative, const std::vector<double>& parameters, hl::PairGeometry pair) {
    const hl::LawRecord& r = Law::record;
    if (alternative < 0 || alternative >= r.n_alternatives)
        throw nb::value_error(
            ("alternative: got " + std::to_string(alternative) + ", must be a set of parameters of the law")
                .c_str());
    const int wanted = r.n_common + r.n_in_alternative[alternative];
    if (parameters.size() != static_cast<std::size_t>(wanted))
        throw nb::value_error(("parameters: got " + std::to_string(parameters.size()) + " values, must be " +
                               std::to_string(wanted))
                                  .c_str());
    return Law::from_parameters(alternative, parameters.data(), pair);
}

Contact make_contact(const std::string& name, int alternative, const std::vector<double>& parameters,
                     double mass, double radius) {
    Contact made{};
    bool found = false;
    for_each_law([&]<class Law>() {
        if (name != Law::record.name) return;
        made = {from_parameters<Law>(alternative, parameters, {mass, radius}), {mass, radius}};
        found = true;
    });
    if (!found) throw nb::value_error(("law: unknown name " + name).c_str());
    return made;
}

auto force(const Contact& c, In compression, In rate) {
    if (rate.shape(0) != compression.shape(0))
        throw nb::value_error(("rate: got " + std::to_string(rate.shape(0)) + " values, must be " +
                               std::to_string(compression.shape(0)) + " as of compression")
                                  .c_str());
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
        nb::list common, alternatives, constants;
        for (int i = 0; i < r.n_common; ++i) common.append(parameter_dict(r.common[i]));
        for (int a = 0; a < r.n_alternatives; ++a) {
            nb::list one;
            for (int i = 0; i < r.n_in_alternative[a]; ++i) one.append(parameter_dict(r.alternatives[a][i]));
            alternatives.append(one);
        }
        for (int i = 0; i < r.n_constants; ++i) {
            nb::dict one;
            one["name"] = r.constants[i].name;
            one["unit"] = r.constants[i].unit;
            one["meaning"] = r.constants[i].meaning;
            constants.append(one);
        }
        d["common"] = common;
        d["alternatives"] = alternatives;
        d["constants"] = constants;
        laws.append(d);
    });
    return laws;
}

}  // namespace

void bind_contacts(nb::module_& m) {
    m.def("law_records", &law_records, "Records of the registered contact laws.");
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
            "compression",
            [](const Contact& c, In speed) {
                return std::visit(
                    [&](const auto& law) {
                        return map(speed, [&](double v) {
                            const double mass = c.pair.effective_mass;
                            return hl::boxes::solve_planar_contact(law, {mass, hl::math::infinity, v})
                                .greatest;
                        });
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
                            return xi > 0.0 ? law.energy(hl::onset_root<Law::onset_power>(xi)) : 0.0;
                        });
                    },
                    c.law);
            },
            "compression"_a);
    m.def("make_contact", &make_contact, "law"_a, "alternative"_a, "parameters"_a, "effective_mass"_a,
          "effective_radius"_a);
    m.def("effective", &hl::effective, "a"_a, "b"_a, "a b/(a + b); also if one of them is infinite.");
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
    m.attr("series_terms") = hl::contact::series_terms;
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
