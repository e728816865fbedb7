// Bindings of the law of the error (core/boxes/common/error_law.hpp).
#include "boxes/common/error_law.hpp"

#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>

#include <tuple>

#include "arrays.hpp"

namespace nb = nanobind;
using namespace nb::literals;
namespace law = hardlimit::boxes::error_law;

namespace {

law::Rule rule_named(const std::string& name) {
    return name == "tc" ? law::Rule::tc : name == "soft" ? law::Rule::soft : law::Rule::constant;
}

law::ErrorLaw make(int dimension, double packing_fraction, double restitution, const std::string& rule,
                   double energy, double damping, double mean_compression, double mean_duration) {
    return law::make(law::fluid(dimension, packing_fraction), restitution, rule_named(rule),
                     {energy, damping, mean_compression, mean_duration});
}

}  // namespace

void bind_error_law(nb::module_& m) {
    nb::class_<law::ErrorLaw>(m, "ErrorLaw", "The coefficient a, its standard error, and 2k of the rule tc.")
        .def(nb::init<double, double, double>(), "coefficient"_a, "coefficient_error"_a, "decay"_a)
        .def_ro("coefficient", &law::ErrorLaw::coefficient)
        .def_ro("coefficient_error", &law::ErrorLaw::coefficient_error)
        .def_ro("decay", &law::ErrorLaw::decay)
        .def("error", &law::ErrorLaw::error, "tc_nu"_a)
        .def("error_bar", &law::ErrorLaw::error_bar, "tc_nu"_a)
        .def("largest_tc_nu", &law::ErrorLaw::largest_tc_nu, "limit"_a);
    m.def("error_law", &make, "dimension"_a, "packing_fraction"_a, "restitution"_a, "rule"_a, "energy"_a,
          "damping"_a, "mean_compression"_a, "mean_duration"_a,
          "The law for a rule, and a contact law with these exponents and means.");
    m.def(
        "error_law_inelastic",
        [](int dimension, double packing_fraction, double x) {
            return law::inelastic(law::fluid(dimension, packing_fraction), x);
        },
        "dimension"_a, "packing_fraction"_a, "x"_a,
        "a of the linear law at x = 1 − ε², without correlations of the velocities.");
    m.def(
        "hard_sphere_fluid",
        [](int dimension, double packing_fraction) {
            const law::Fluid gas = law::fluid(dimension, packing_fraction);
            return std::tuple(gas.contact_value, gas.growth, gas.slope, gas.density());
        },
        "dimension"_a, "packing_fraction"_a, "χ, D φ χ'/χ, s = −g'(d⁺) d/χ, and D 2^D φ χ.");
    // (thinnest, densest, restitution) by dimension − 2.
    const auto range = [](const law::MeasuredRange& in) {
        return nb::make_tuple(in.thinnest, in.densest, in.restitution);
    };
    m.attr("error_law_measured") = nb::make_tuple(range(law::measured[0]), range(law::measured[1]));
    m.attr("error_law_measured_hertz") =
        nb::make_tuple(range(law::measured_hertz[0]), range(law::measured_hertz[1]));
    m.attr("error_law_measured_tc_nu") = law::measured_tc_nu;
    m.attr("error_law_nearly_elastic") = law::nearly_elastic_from;
}
