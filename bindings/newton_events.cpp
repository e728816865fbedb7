// Compiles the event-driven engine for Newton's equations.
#ifndef HARDLIMIT_LAWS_APART  // otherwise newton_events_of_law.cpp does
#include "boxes/newton_events/engine.hpp"
#endif
#include "boxes/newton_events/make_engine.hpp"
#include "engines.hpp"

namespace hardlimit::bindings {

const EngineRecord newton_events_engine = {
    "newton_events",
    [](const boxes::System& s, const EngineArguments& a, Stop&) {
        return boxes::make_newton_events(s, a.rule.law, a.log, touch_kernels());
    },
    [](const char* data, std::size_t n) { return boxes::load_newton_events(data, n, touch_kernels()); }};

}  // namespace hardlimit::bindings
