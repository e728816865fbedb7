// Bindings of the contact laws: what they state about themselves, and one contact of two bodies.
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <string>
#include <type_traits>

#include "arrays.hpp"
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

}  // namespace

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

