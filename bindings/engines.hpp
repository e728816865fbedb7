// Table entries of the engines of boxes, each compiled in its own file.
#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "boxes/common/engine.hpp"
#include "boxes/hard_spheres/rules/rule.hpp"
#include "processor.hpp"

namespace hardlimit::bindings {

// Arguments of an engine in addition to the system.
struct EngineArguments {
    boxes::RuleChoice rule;  // contains the contact law; engines other than hard_spheres use only that
    double time_step = 0.0;  // for newton_steps [s]
    bool log = false;
};

struct EngineRecord {
    const char* name;
    std::unique_ptr<boxes::Engine> (*make)(const boxes::System&, const EngineArguments&, Stop&);
    // Returns nullptr if the data are damaged.
    std::unique_ptr<boxes::Engine> (*load)(const char* data, std::size_t n);
};
// Random positions without overlap; empty if there was not enough space. report(fraction of the final radii,
// collisions) returns whether to continue.
std::optional<std::vector<double>> grow_packing(const boxes::System& s, u64 seed, Stop& stop,
                                                const std::function<bool(double, u64)>& report);

extern const EngineRecord hard_spheres_engine, newton_events_engine, newton_steps_engine;

}  // namespace hardlimit::bindings
