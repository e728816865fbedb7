// Criterion for a column that gravity keeps closed forever; motions.hpp derives it under "Rest".
#pragma once
#include "motions.hpp"

namespace hardlimit::column::newton {

// The static equilibrium of the closed column, and the smallest energy that can open a contact (`barrier`).
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
            const double s = roots::solve_power([&](double x) { return law.elastic_force(x); }, above);
            depth[j] = math::power<p>(s);
            stored[j] = law.energy(s);
            rounding += 1e-13 * above * depth[j];
            barrier = math::min(barrier, release_energy(law, j, pair_mass(c, j)));
        }
    }

    // Smallest energy above the equilibrium at which contact j can be without force: the minimum over the separation
    // speed u, on a grid of octaves and then by golden-section search. The energy at ξ = 0 and u = 0 is an upper bound,
    // and so bounds u.
    double release_energy(const Law& law, int j, double mass) const {
        const double standing = excess(law, j, 0.0);
        const auto energy = [&](double u) {
            const double at = math::max(law.slack(-u).depth, 0.0);
            // If the slack is deeper than the equilibrium, the force also vanishes at the equilibrium, where B = 0.
            const double stored = at < depth[j] ? excess(law, j, onset_root<Law::onset_power>(at)) : 0.0;
            return stored + 0.5 * mass * u * u;
        };
        const double fastest = math::sqrt(2.0 * standing / mass);
        double best = fastest, least = standing;
        for (double u = fastest; u > 1e-100 * fastest; u *= 0.5) {
            if (energy(u) >= least) continue;
            least = energy(u);
            best = u;
        }
        constexpr double golden = 0.6180339887498949;
        double low = 0.5 * best, high = 2.0 * best;
        for (int i = 0; i < 60; ++i) {
            const double width = golden * (high - low), left = high - width, right = low + width;
            const bool lower_half = energy(left) < energy(right);
            (lower_half ? high : low) = lower_half ? right : left;
        }
        return math::min(least, energy(0.5 * (low + high)));
    }

    double excess(const Law& law, int j, double s) const {
        return (law.energy(s) - stored[j]) - weight[j] * (math::power<Law::onset_power>(s) - depth[j]);
    }

    // Energy above the equilibrium [J]; requires all contacts closed.
    double energy(const Motion<Law>& motion, const double* y) const {
        double total = motion.energies(y).kinetic;
        for (int j = 0; j < motion.balls(); ++j) {
            total += excess(motion.column->contacts[j], j, motion.s(j, y));
        }
        return total;
    }

    // Whether contact j can reach the compression `deep` with this energy, or reaches it under the weight alone.
    bool reaches(const Law& law, int j, double deep, double energy) const {
        return depth[j] >= deep || excess(law, j, onset_root<Law::onset_power>(deep)) <= energy;
    }
    // holds: with this energy no contact can end. settled: the energy is within rounding error of zero.
    bool holds(double energy) const { return energy < barrier || settled(energy); }
    bool settled(double energy) const { return energy < rounding; }
};

}  // namespace hardlimit::column::newton
