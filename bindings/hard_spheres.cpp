// Compiles the hard-sphere engine and the growth of random packings.
#include "boxes/hard_spheres/growth.hpp"
#include "boxes/hard_spheres/make_engine.hpp"
#include "engines.hpp"

namespace hardlimit::bindings {

const EngineRecord hard_spheres_engine = {
    "hard_spheres",
    [](const boxes::System& s, const EngineArguments& a, Stop& stop) {
        return boxes::make_hard_spheres(s, a.rule, a.log, touch_kernels(), stop);
    },
    [](const char* data, std::size_t n) { return boxes::load_hard_spheres(data, n, touch_kernels()); }};

namespace {

template <int d>
std::optional<std::vector<double>> grow(const boxes::System& s, u64 seed, Stop& stop,
                                        const std::function<bool(double, u64)>& report) {
    boxes::PackingGrowth<d> growth(s, seed);
    const auto told = [&](boxes::GrowthReport r) { return report(r.share, r.collisions); };
    if (!growth.run(touch_kernels(), stop, told)) return {};
    return std::move(growth).positions();
}

}  // namespace

std::optional<std::vector<double>> grow_packing(const boxes::System& s, u64 seed, Stop& stop,
                                                const std::function<bool(double, u64)>& report) {
    return s.box.dimension == 2 ? grow<2>(s, seed, stop, report) : grow<3>(s, seed, stop, report);
}

}  // namespace hardlimit::bindings
