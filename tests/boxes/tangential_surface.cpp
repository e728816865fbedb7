// β from the tables in two numbers (tangential_surface.hpp) beside the contacts themselves. A line for each
// setting: contacts, largest difference of 1 + β, contacts whose slip differs.
#include "boxes/binary_contact/tangential_surface.hpp"

#include <cstdio>
#include <random>

using namespace hardlimit;
using namespace hardlimit::boxes;

namespace {

struct Case {
    const char* name;
    FrictionModel model;
    SlipLimit limit;
    double restitution, coefficient, stiffness_ratio, damping_ratio;
    bool many_sizes;
};
constexpr Case cases[] = {
    {"pairs of one kind", FrictionModel::mindlin_rescale, SlipLimit::total, 0.9, 0.5, 0.8, 0.0, false},
    {"sizes, damped", FrictionModel::mindlin_rescale_force, SlipLimit::total, 0.5, 0.2, 1.1, 0.5, true},
    {"sizes, limited spring", FrictionModel::mindlin, SlipLimit::spring, 0.7, 1.5, 0.5, 1.0, true},
    {"sizes, no spring", FrictionModel::none, SlipLimit::total, 0.8, 0.5, math::nan, 1.0, true},
    {"sizes, elastic", FrictionModel::mindlin_force, SlipLimit::total, 1.0, 0.5, 0.9, 0.0, true},
    {"constant spring", FrictionModel::spring, SlipLimit::total, 0.8, 0.3, 0.6, 0.0, false},
};

// A viscoelastic contact of two equal spheres: with size 1 it has this restitution at speed 1.
contact::FrictionalContact contact_of(const Case& of, double size) {
    const Powers powers{6, 2, false};
    const double elastic = 1e6, mass = 0.5;
    contact::FrictionalContact c{powers, {elastic, 0.0}, mass, mass / 3.5, {}};
    const double length = c.length_unit(1.0), time = c.time_unit(1.0);
    const double damping =
        contact::power_damping(powers, of.restitution) * mass / (time * math::sqrt(length));
    const double root = math::sqrt(size);
    c.mass = mass * size * size * size, c.tangential_mass = c.mass / 3.5;
    c.normal = {elastic * root, damping * root};
    Friction f{.coefficient = of.coefficient, .model = of.model, .limit = of.limit};
    f.damping_ratio = of.damping_ratio;
    (of.model == FrictionModel::spring ? f.stiffness : f.stiffness_ratio) =
        of.stiffness_ratio * (of.model == FrictionModel::spring ? elastic * math::sqrt(length) : 1.0);
    c.friction = friction_terms(f, powers, c.normal);
    return c;
}

}  // namespace

int main() {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> uniform;
    for (const Case& of : cases) {
        TangentialSurfaces surfaces;
        double worst = 0.0;
        int contacts = 0, other_slip = 0;
        for (; contacts < 1000; ++contacts) {
            const double size = of.many_sizes ? 0.95 + 0.1 * uniform(random) : 1.0;
            const contact::FrictionalContact c = contact_of(of, size);
            const double speed = 0.5 + 0.05 * uniform(random), x = uniform(random);
            const double slip = of.coefficient * 3.5 * speed * (1.0 - x) / x;
            const TangentialResult from_table =
                surfaces(c, {c.mass, size}, 2.5, speed, slip, TangentialSurfaces::without_table);
            const TangentialResult solved = solve_tangential(c, speed, slip);
            worst = math::max(worst, math::abs(from_table.gain - solved.gain));
            other_slip += from_table.slid != solved.slid;
        }
        std::printf("%d %.3g %d\n", contacts, worst, other_slip);
    }
}
