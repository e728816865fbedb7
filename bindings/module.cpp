// The Python extension module _core. Bindings only convert arguments and release the interpreter lock.
#include <string>
#include <utility>

#include "arrays.hpp"
#include "base/math.hpp"
#include "base/outcome.hpp"
#include "contact/law.hpp"

namespace nb = nanobind;
using namespace nb::literals;
namespace hl = hardlimit;

void bind_contacts(nb::module_& m);
void bind_columns(nb::module_& m);
void bind_binary_contact(nb::module_& m);
void bind_sweep(nb::module_& m);
void bind_boxes(nb::module_& m);
void bind_error_law(nb::module_& m);

namespace {

void bind_math(nb::module_& m) {
    m.def(
        "math",
        [](const std::string& name, hl::bindings::In x) {
            namespace hm = hl::math;
            constexpr std::pair<const char*, double (*)(double)> functions[] = {{"exp", &hm::exp<double>},
                                                                                {"log", &hm::log<double>},
                                                                                {"log1p", &hm::log1p<double>},
                                                                                {"sin", &hm::sin<double>},
                                                                                {"cos", &hm::cos<double>}};
            for (const auto& [known, f] : functions)
                if (name == known) return hl::bindings::map(x, f);
            throw nb::value_error("name: exp, log, log1p, sin or cos");
        },
        "name"_a, "x"_a, "The core's elementary functions, for tests.");
    m.def("atan2_upper", &hl::math::atan2_upper<double>, "y"_a, "x"_a);
}

}  // namespace

NB_MODULE(_core, m) {
    nb::set_leak_warnings(false);  // objects alive at exit, for example in a traceback, are not an error
    m.attr("version") = HARDLIMIT_VERSION;
    // A function, because the stub would contain the value of an attribute.
    m.def("compiler", [] { return HARDLIMIT_COMPILER; });
    const auto of_outcomes = [](const char* hl::OutcomeRecord::* field) {
        return nb::tuple(hl::bindings::list_of(hl::outcome_records, [=](const auto& r) { return r.*field; }));
    };
    m.attr("outcome_names") = of_outcomes(&hl::OutcomeRecord::name);
    m.attr("outcome_messages") = of_outcomes(&hl::OutcomeRecord::message);
    m.attr("deepest_compression") = hl::deepest_compression;
    bind_contacts(m);
    bind_math(m);
    bind_columns(m);
    bind_binary_contact(m);
    bind_sweep(m);
    bind_boxes(m);
    bind_error_law(m);
}
