// Newton's equations for a column of N balls under any contact law. The integration is of high order, and every
// instant at which a force sets in or ends is located (Eq. 14 of Müller & Pöschel, Phys. Rev. E 83, 041304 (2011), for
// N balls):
//   m_i dv_i/dt = F_i − F_{i+1} − m_i g,   d(gap_j)/dt = −rate_j,   rate_j = v_{j−1} − v_j  (floor: −v_1),
//   F_j = force(s_j, rate_j) while contact j is closed, otherwise 0;   ξ_j = −gap_j = s_j^p.
// Of the law, only the interface in contact/law.hpp is used.
//
// Order. While a contact is closed its coordinate is s, and time is scaled (contact/smooth_time.hpp). A contact that
// starts at rate 0 because a neighbour presses on it has ξ ~ t^{7/2} or so; ξ is the better coordinate for it. The
// coordinate is chosen before each step. A one-step method keeps no history, so a change costs nothing.
//
// Events of a pair are defined in contact/events.hpp. After an event the state is set exactly on the zero of the event
// function. The event re-arms once its function is positive; a negative value while it rises is rounding error.
//
// Touching pairs (gap exactly 0, at release or later). If rate > 0, a contact begins now. If rate < 0, the pair opens
// without contact, whatever its neighbours do. If rate = 0, the acceleration decides. All forces are repulsive and
// gravity acts on all balls alike, so d(rate_j)/dt = F_{j−1}/m_{j−1} + F_{j+1}/m_j >= 0 (floor: g + F_1/m_1). The pair
// therefore closes when a neighbouring contact begins (the floor pair under gravity: at once), and in turn closes its
// other neighbour. Without such a contact its gap and rate stay 0. The contact starts as a high power of time,
// ξ ~ t^{7/2} next to a Hertz contact. Its state is `pressed`: the force law applies, but the end of the contact is
// not searched for until ξ exceeds rounding error.
//
// A zero inside a step is found by Newton's method with a bracket; each trial state is one Runge-Kutta step from the
// start of the interval. Two zeros within a step show as a minimum, which is refined until its sign is certain. In
// free flight the motion is a parabola; only slack → closed needs a search.
//
// Energy. The potential energy is Σ_j W_j gap_j with W_j the weight above gap j (zero for balls that touch); only this
// form keeps the digits of a small gap. Dissipation is ∫ Σ (F − F_elastic) rate dt, plus the energy that a contact
// still stores when its force ends.
//
// Creep. Under strong damping, or between much heavier neighbours, the equations are stiff: modes of 1e6/s and more
// decay and leave a motion over milliseconds or seconds, while the explicit method still needs steps of a microsecond.
// After many steps without an event an implicit method (radau.hpp) therefore takes over until the next event, at the
// same tolerance.
//
// Rest. With all contacts closed the energy above the static equilibrium is Σ_j B_j(ξ_j) + kinetic energy
// with B_j(ξ) = U_j(ξ) − U_j(ξ_s) − W_j (ξ − ξ_s) >= 0 for a convex U, and never grows. Contact j can end only if
// this reaches the smallest energy of a state without force, min over u of B_j(d(−u)) + m_eff u²/2: the bodies separate
// at speed u, and d(−u) is the compression at which the force vanishes at that speed. Below it the contact never ends.
#pragma once
#include <algorithm>
#include <vector>

#include "../../base/dormand_prince.hpp"
#include "../../base/radau.hpp"
#include "../../base/roots.hpp"
#include "../../contact/smooth_time.hpp"
#include "../energies.hpp"
#include "../sequence.hpp"
#include "../state.hpp"

namespace hardlimit::column {

namespace newton {

enum class Pair : unsigned char { open, pressed, slack, closed };

template <class Law>
double pair_mass(const Column<Law>& c, int j) {
    return effective(j == 0 ? math::infinity : c.mass[j - 1], c.mass[j]);
}

// Scales of the problem: the impact speed, and for each contact the largest compression ξ = s^p of an elastic impact
// at this speed.
struct Scales {
    double speed = 0.0, time = math::infinity, energy = 0.0;
    std::vector<double> s, depth;  // [N] ℓ_j and ℓ_j^p

    template <class Law>
    explicit Scales(const Column<Law>& c) : s(c.balls, 0.0), depth(c.balls, 0.0) {
        for (const double v : c.velocity) speed = math::max(speed, math::abs(v));
        const double landing = c.velocity[0] * c.velocity[0] + 2.0 * c.gravity * math::max(c.gaps[0], 0.0);
        if (c.floor) speed = math::max(speed, math::sqrt(landing));
        if (!(speed > 0.0)) return;
        for (int j = 0; j < c.balls; ++j) energy += 0.5 * c.mass[j] * speed * speed;
        for (int j = c.floor ? 0 : 1; j < c.balls; ++j) {
            const Law& law = c.contacts[j];
            const double target = 0.5 * pair_mass(c, j) * speed * speed;
            s[j] = roots::solve_power([&](double x) { return law.energy(x); }, target);
            depth[j] = math::power<Law::onset_power>(s[j]);
            time = math::min(time, depth[j] / speed);
        }
        if (!c.floor) depth[0] = speed * time;
    }
};

// The equations of motion between two events.
template <FrictionlessLaw Law>
struct Motion {
    static constexpr int p = Law::onset_power;

    const Column<Law>* column;
    Scales scales;
    std::vector<Pair> pair;
    std::vector<unsigned char> uses_root;
    bool implicit = false;  // the implicit method advances the state
    mutable std::vector<double> force, factor, stages;
    mutable Radau radau;

    explicit Motion(const Column<Law>& c)
        : column(&c),
          scales(c),
          pair(c.balls, Pair::open),
          uses_root(c.balls, 0),
          force(c.balls + 1, 0.0),
          factor(c.balls, 0.0),
          stages(DormandPrince::stages * dimension()) {}

    int balls() const { return column->balls; }
    int dimension() const { return 2 * balls() + 2; }
    int clock() const { return 2 * balls(); }
    int loss() const { return 2 * balls() + 1; }

    bool pushes(int j) const { return pair[j] == Pair::closed || pair[j] == Pair::pressed; }
    bool free() const { return std::find(pair.begin(), pair.end(), Pair::closed) == pair.end(); }

    double rate(int j, const double* y) const {
        const double* v = y + balls();
        return (j == 0 ? 0.0 : v[j - 1]) - v[j];
    }
    double gap(int j, const double* y) const { return uses_root[j] ? -math::power<p>(y[j]) : y[j]; }
    double s(int j, const double* y) const { return uses_root[j] ? y[j] : onset_root<p>(-y[j]); }

    // Returns γ = dt/dτ and stores γ (ℓ_j/s_j)^{p−1} in factor[j].
    double clock_rate(const double* y) const {
        if constexpr (p == 1) return 1.0;
        const auto for_each_root = [this](const auto& f) {
            for (int j = 0; j < balls(); ++j)
                if (uses_root[j]) f(j);
        };
        for_each_root([&](int j) { factor[j] = math::power<p - 1>(y[j] / scales.s[j]); });
        return smooth_time_rate(for_each_root, factor.data());
    }

    void operator()(const double* y, double* dy) const {
        const int n = balls();
        const double g = clock_rate(y);
        double dissipation = 0.0;
        for (int j = 0; j < n; ++j) {
            const double closing = rate(j, y);
            dy[j] = -g * closing;
            force[j] = 0.0;
            if (!pushes(j)) continue;
            const Law& law = column->contacts[j];
            const double at = s(j, y);
            force[j] = law.force(at, closing);
            dissipation += (force[j] - law.elastic_force(at)) * closing;
            if (uses_root[j]) dy[j] = closing / p * factor[j] / math::power<p - 1>(scales.s[j]);
        }
        for (int i = 0; i < n; ++i) {
            dy[n + i] = g * ((force[i] - force[i + 1]) / column->mass[i] - column->gravity);
        }
        dy[clock()] = g;
        dy[loss()] = g * dissipation;
    }

    // Computes the state `length` (in τ) after y; k0 = dy/dτ at y. Exact (a parabola) without forces. Returns false if
    // the implicit method did not converge.
    bool advance(const double* y, const double* k0, double length, double* out) const {
        const int n = balls();
        if (!free()) {
            if (implicit) return advance_implicitly(y, length, out);
            std::copy(k0, k0 + dimension(), stages.begin());
            DormandPrince::step(*this, y, length, dimension(), stages.data(), out);
            return true;
        }
        const double g = column->gravity;
        for (int j = 0; j < n; ++j) {
            out[j] = y[j] - length * (rate(j, y) + (j == 0 ? 0.5 * g * length : 0.0));
            out[n + j] = y[n + j] - g * length;
        }
        out[clock()] = y[clock()] + length;
        out[loss()] = y[loss()];
        return true;
    }

    // Only gaps and velocities are coupled; time and dissipated energy are quadratures.
    bool advance_implicitly(const double* y, double length, double* out) const {
        const int n = balls();
        std::vector<double> unit(clock());
        for (int j = 0; j < n; ++j) {
            unit[j] = math::abs(y[j]) + (uses_root[j] ? scales.s[j] : scales.depth[j]);
            unit[n + j] = math::abs(y[n + j]) + scales.speed;
        }
        return radau.step(*this, y, length, dimension(), clock(), unit.data(), out);
    }

    // Computes the state at a given time within an interval, by Newton's method on the increasing function t(τ).
    void reach(const double* y, const double* k0, double length, double time, double* out) const {
        const double wanted = time - y[clock()];
        if (wanted == 0.0) {
            std::copy(y, y + dimension(), out);
            return;
        }
        if (std::find(uses_root.begin(), uses_root.end(), 1) == uses_root.end()) {
            advance(y, k0, wanted, out);
            return;
        }
        std::vector<double> k(dimension());
        double low = 0.0, high = length, at = 0.5 * length;
        for (int i = 0; i < 80; ++i) {
            advance(y, k0, at, out);
            const double excess = out[clock()] - time;
            (excess > 0.0 ? high : low) = at;
            const double next = at - excess / clock_rate(out);
            const double previous = at;
            at = next > low && next < high ? next : 0.5 * (low + high);
            if (math::abs(at - previous) <= 4.0 * math::epsilon * length) break;
        }
        advance(y, k0, at, out);
    }

    Energies energies(const double* y) const {
        Energies e{0.0, 0.0, 0.0, y[loss()]};
        double weight = 0.0;
        for (int j = balls() - 1; j >= 0; --j) {
            weight += column->mass[j] * column->gravity;
            e.kinetic += 0.5 * column->mass[j] * y[balls() + j] * y[balls() + j];
            e.potential += weight * gap(j, y);
            if (pair[j] == Pair::open) continue;
            const double stored = column->contacts[j].energy(s(j, y));
            e.contact += stored;
            if (pair[j] == Pair::slack) e.dissipated -= stored;  // counted as dissipated when the force ended
        }
        return e;
    }

    void choose_coordinate(int j, double* y, bool use_root) {
        if (use_root == static_cast<bool>(uses_root[j])) return;
        y[j] = use_root ? onset_root<p>(-y[j]) : -math::power<p>(y[j]);
        uses_root[j] = use_root;
    }

    // Chooses s for contacts that are noticeably compressed or change fast, the gap for all others. Returns whether any
    // coordinate has changed.
    bool choose_coordinates(double* y) {
        if constexpr (p == 1) return false;
        bool changed = false, at_zero = false;
        for (int j = 0; j < balls(); ++j) {
            const double sigma = pair[j] == Pair::closed ? s(j, y) / scales.s[j] : 0.0;
            const bool noticeable = sigma > 0.1 || math::abs(rate(j, y)) > sigma * scales.speed;
            const bool use_root = pair[j] == Pair::closed && noticeable && !(sigma == 0.0 && at_zero);
            at_zero = at_zero || (use_root && sigma == 0.0);
            changed = changed || use_root != static_cast<bool>(uses_root[j]);
            choose_coordinate(j, y, use_root);
        }
        return changed;
    }
};

}  // namespace newton

}  // namespace hardlimit::column
