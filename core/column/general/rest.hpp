// When gravity holds a column closed for good: the head of motions.hpp says why.
#pragma once
#include "motions.hpp"

namespace hardlimit::column::newton {

// The static equilibrium of the closed column and the energy that keeps it closed.
template <class Law>
struct Equilibrium {
    std::vector<double> weight, depth, stored;
    double barrier = math::infinity, rounding = 0.0;

    explicit Equilibrium(const Column<Law>& c) : weight(c.balls), depth(c.balls), stored(c.balls) {
        constexpr int p = Law::onset_power;
        double above = 0.0;
        for (int j = c.balls - 1; j >= 0; --j) {
            const Law& law = c.contacts[j];
            weight[j] = above += c.mass[j] * c.gravity;
            const double s = solve_power([&](double x) { return law.elastic_force(x); }, above);
            depth[j] = power<p>(s);
            stored[j] = law.energy(s);
            rounding += 1e-13 * above * depth[j];
            const double time = law.relaxation_time();
            const double inertia = time > 0.0 ? pair_mass(c, j) / (time * time) : math::infinity;
            double low = 0.0, high = depth[j];  // of the ξ that costs least
            for (int i = 0; i < 100 && time > 0.0; ++i) {
                const double middle = 0.5 * (low + high);
                const double slope = law.elastic_force(root<p>(middle)) - above + inertia * middle;
                (slope > 0.0 ? high : low) = middle;
            }
            const double kinetic = time > 0.0 ? 0.5 * inertia * low * low : 0.0;
            barrier = math::min(barrier, excess(law, j, root<p>(low)) + kinetic);
        }
    }

    double excess(const Law& law, int j, double s) const {
        return (law.energy(s) - stored[j]) - weight[j] * (power<Law::onset_power>(s) - depth[j]);
    }

    // Energy above the equilibrium [J]; all contacts are closed.
    double energy(const Motion<Law>& motion, const double* y) const {
        double total = motion.energies(y).kinetic;
        for (int j = 0; j < motion.balls(); ++j) {
            total += excess(motion.column->contacts[j], j, motion.s(j, y));
        }
        return total;
    }

    // With this energy no contact ends any more; all motion is over.
    bool holds(double energy) const { return energy < barrier || settled(energy); }
    bool settled(double energy) const { return energy < rounding; }
};

}  // namespace hardlimit::column::newton
