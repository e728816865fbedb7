// Compiles the time-stepping engine for Newton's equations.
#include "boxes/newton_steps/make_engine.hpp"
#include "engines.hpp"

namespace hardlimit::bindings {

const EngineRecord newton_steps_engine = {
    "newton_steps",
    [](const boxes::System& s, const EngineArguments& a, Stop&) {
        return boxes::make_newton_steps(s, a.rule.law, a.log, a.time_step);
    },
    [](const char* data, std::size_t n) { return boxes::load_newton_steps(data, n); }};

}  // namespace hardlimit::bindings
