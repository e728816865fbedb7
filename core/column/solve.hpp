// Chooses the solver for a column and returns its result as a Solution.
#pragma once
#include <algorithm>
#include <atomic>
#include <memory>
#include <type_traits>
#include <utility>

#include "exact/drop.hpp"
#include "general/sample.hpp"
#include "independent.hpp"
#include "model.hpp"
#include "solution.hpp"

namespace hardlimit::column {

struct SolveOptions {
    double until = math::nan;  // [s] after the first floor touch (cradle: release); NaN: end of the sequence
    bool general = false;      // use the general solver even where the exact one applies
    double tolerance = 1e-14;  // of the general solver
    long max_steps = 2'000'000;
    long max_events = independent::most_events;  // collisions in the independent model
    bool record = true;                          // store the states for sample() and knots()
    Stop* stop = nullptr;
};

template <class Law>
using SharedColumn = std::shared_ptr<const Column<Law>>;

namespace solve {

class Exact final : public Solution {
public:
    Exact(SharedColumn<contact::LinearDashpot> c, Coupling coupling, const SolveOptions& o)
        : column_(std::move(c)),
          coupling_(coupling),
          timed_(!math::is_nan(o.until)),
          drop_(solve_drop(*column_, coupling, o.until, o.record, o.stop)) {
        sequence = drop_.sequence;
        too_deep = drop_.too_deep;
        contacts = std::move(drop_.contacts);
        steps = static_cast<long>(drop_.nodes.size());
        if (drop_.nodes.empty()) return;
        first = at(drop_.nodes.front());
        last = at(drop_.nodes.back());
        if (math::abs(last - o.until) <= 1e-12 * math::abs(o.until)) last = o.until;  // reached to rounding
    }
    ~Exact() override { delete dissipated_.load(); }
    // Computes the dissipated energy, needed only for a trajectory. Concurrent threads compute the same values; the
    // first to finish stores them.
    void prepare(Stop& stop) const override {
        if (dissipated_.load()) return;
        auto sum = std::make_unique<const std::vector<double>>(dissipated_energy(*column_, drop_, stop));
        const std::vector<double>* none = nullptr;
        if (!stop.stopped() && dissipated_.compare_exchange_strong(none, sum.get())) sum.release();
    }
    void sample(const double* times, States& out) const override {
        Stop never;
        prepare(never);
        const std::vector<double>& dissipated = *dissipated_.load();
        for (std::size_t i = 0; i < out.n; ++i) {
            const DropSample s = sample_drop(*column_, drop_, dissipated, times[i]);
            for (std::size_t j = 0; j < 2; ++j) {
                out.gap[2 * i + j] = s.gap[j];
                out.velocity[2 * i + j] = s.velocity[j];
                out.force[2 * i + j] = s.force[j];
            }
            out.total[i] = s.energies;
            out.complete(*column_, i, 0.0);
        }
    }
    double largest_compression() const override {
        if (too_deep >= 0) return deepest_compression;
        drop::Compressions all(drop_.start.groups);
        const std::vector<Node>& nodes = drop_.nodes;
        for (std::size_t i = 0; i + 1 < nodes.size(); ++i) all.track(nodes[i], nodes[i + 1].t - nodes[i].t);
        if (rests()) all.track(nodes.back(), exact::never);
        const double metre = drop_.start.per_metre;
        return math::max(all.greatest[0] / (smaller_radius(*column_, 0) * metre),
                         all.greatest[1] / (smaller_radius(*column_, 1) * metre));
    }
    bool presses_by(double part) const override {
        if (drop_.nodes.empty()) return false;
        const CompressionBound bound = drop::bound_of(*column_, coupling_, part);
        const bool sure = DropBound::of(bound, column_->gaps[1], drop_.start.units.speed).holds(last);
        if (sure && (!rests() || drop::settles(*column_, drop_, bound))) return false;
        return Solution::presses_by(part);
    }
    std::vector<double> knots() const override {
        std::vector<double> times;
        for (const Node& n : drop_.nodes) times.push_back(at(n));
        return times;
    }

private:
    SharedColumn<contact::LinearDashpot> column_;
    Coupling coupling_;
    bool timed_;
    Drop drop_;
    // Energy dissipated up to each node [J]; null: not computed yet.
    mutable std::atomic<const std::vector<double>*> dissipated_{nullptr};

    double at(const Node& n) const { return n.t / drop_.start.units.rate; }
    // Whether the contacts last forever after the last node.
    bool rests() const { return sequence.outcome == Outcome::at_rest && !timed_; }
};

inline IntegrateOptions integrate_options(const SolveOptions& o, bool record) {
    IntegrateOptions options;
    options.tolerance = o.tolerance;
    options.max_steps = o.max_steps;
    options.until = o.until;
    options.record = record;
    options.stop = o.stop;
    return options;
}

template <class Law>
class Integrated final : public Solution {
public:
    Integrated(SharedColumn<Law> c, const SolveOptions& o)
        : column_(std::move(c)), options_(integrate_options(o, o.record)) {
        run_ = integrate(*column_, options_);
        options_.stop = nullptr;
        too_deep = run_.too_deep;
        sequence = run_.sequence;
        contacts = std::move(run_.contacts);
        steps = run_.steps;
        energy_error = run_.energy_error;
        if (run_.intervals.empty()) return;
        first = run_.intervals.front().t;
        last = run_.intervals.back().t;
    }
    void sample(const double* times, States& out) const override {
        column::sample(*column_, run_, times, static_cast<long>(out.n),
                       {out.gap.data(), out.velocity.data(), out.force.data(), out.total.data()});
        for (std::size_t i = 0; i < out.n; ++i)
            out.complete(*column_, i, column_->floor ? 0.0 : displacement(&out.gap[i * out.balls], times[i]));
    }
    // If the run ended at rest, continues it until all oscillations have decayed.
    double largest_compression() const override {
        double most = largest(run_);
        if (sequence.outcome == Outcome::at_rest && math::is_nan(options_.until)) {
            IntegrateOptions later = options_;
            later.record = false;
            later.until = last + run_.settling;
            most = math::max(most, largest(integrate(*column_, later)));
        }
        return most;
    }
    std::vector<double> knots() const override {
        std::vector<double> times;
        for (const newton::Interval& k : run_.intervals) times.push_back(k.t);
        return times;
    }

private:
    SharedColumn<Law> column_;
    IntegrateOptions options_;
    Integration<Law> run_;

    static double largest(const Integration<Law>& run) {
        return *std::max_element(run.compression.begin(), run.compression.end());
    }

    // Displacement of the first ball of a cradle, from the free fall of the centre of mass.
    double displacement(const double* gap, double t) const {
        const Column<Law>& c = *column_;
        double mass = 0.0, momentum = 0.0, above = 0.0, offset = 0.0;
        for (std::size_t i = 0; i < c.mass.size(); ++i) {
            mass += c.mass[i];
            momentum += c.mass[i] * c.velocity[i];
        }
        for (std::size_t i = 1; i < c.mass.size(); ++i) {
            offset += gap[i] - c.gaps[i];
            above += c.mass[i] * offset;
        }
        return (momentum * t - above) / mass - 0.5 * c.gravity * t * t;
    }
};

template <class Law>
class EventDriven final : public Solution {
public:
    EventDriven(SharedColumn<Law> c, const SolveOptions& o)
        : column_(std::move(c)), run_(solve_independent(*column_, o.until, o.stop, o.max_events)) {
        sequence = run_.sequence;
        contacts = run_.contacts;
        steps = static_cast<long>(contacts.size()) + 1;
        first = run_.t_first;
        last = run_.t_last;
    }
    void sample(const double* times, States& out) const override {
        States released(1, column_->balls);
        fill(run_.states.front(), released, 0);
        const double initial = sum(released, 0);
        IndependentMotion<Law> motion(*column_, run_);
        for (std::size_t i = 0; i < out.n; ++i) {
            fill(motion.at(times[i]), out, i);
            out.total[i].dissipated = initial - sum(out, i);
        }
    }
    // Resolves the states between several collisions at the same instant.
    void sample_after(std::size_t contact, States& out) const override {
        fill(IndependentMotion<Law>(*column_, run_).after_collisions(contact + 1), out, 0);
    }
    std::vector<double> knots() const override {
        std::vector<double> times{first};
        for (const Contact& k : contacts) {  // also the instant before it, because velocities jump
            times.push_back(k.begin - 2.0 * math::epsilon * math::max(math::abs(k.begin), math::abs(first)));
            times.push_back(k.begin);
        }
        times.push_back(last);
        return times;
    }

private:
    SharedColumn<Law> column_;
    IndependentRun run_;

    static double sum(const States& s, std::size_t i) {
        double energy = 0.0;
        for (std::size_t j = 0; j < s.balls; ++j) energy += s.energy[i * s.balls + j];
        return energy;
    }
    void fill(const Flight& f, States& out, std::size_t i) const {
        const Column<Law>& c = *column_;
        double kinetic = 0.0, potential = 0.0, height = 0.0;
        for (std::size_t j = 0; j < out.balls; ++j) {
            out.gap[i * out.balls + j] = f.gaps[j];
            out.velocity[i * out.balls + j] = f.velocity[j];
            out.force[i * out.balls + j] = 0.0;
            height += j > 0 || c.floor ? f.gaps[j] : 0.0;
            kinetic += 0.5 * c.mass[j] * f.velocity[j] * f.velocity[j];
            potential += c.gravity * c.mass[j] * height;
        }
        out.complete(c, i, f.gaps[0] - c.gaps[0]);
        out.total[i] = {kinetic, potential, 0.0, 0.0};
    }
};

}  // namespace solve

// Whether the exact solver applies: two balls on a floor under a law with a closed form.
template <class Law>
bool solved_exactly(const Column<Law>& c) {
    return has_exact_solver<Law> && c.floor && c.balls == 2;
}

// Computes only the sequence and, if `contacts` is given, its contacts; used for maps. Solves Newton's equations where
// the adiabatic model does not apply.
template <class Law>
Sequence solve_sequence(const Column<Law>& c, Model model, const SolveOptions& o,
                        std::vector<Contact>* contacts) {
    if (model == Model::independent) {
        IndependentRun run = solve_independent(c, o.until, o.stop, o.max_events);
        if (contacts) *contacts = std::move(run.contacts);
        return run.sequence;
    }
    if constexpr (has_exact_solver<Law>) {
        if (solved_exactly(c) && !o.general) {
            const Coupling coupling = model == Model::adiabatic ? Coupling::adiabatic : Coupling::full;
            if (!contacts) return solve_drop_sequence(c, coupling, o.until, o.stop);
            Drop d = solve_drop(c, coupling, o.until, false, o.stop);
            *contacts = std::move(d.contacts);
            return d.sequence;
        }
    }
    Integration<Law> run = integrate(c, solve::integrate_options(o, false));
    if (contacts) *contacts = std::move(run.contacts);
    return run.sequence;
}

// Solves a column. Null where the model does not apply: the adiabatic model has only the exact solver.
template <class Law>
std::unique_ptr<Solution> solve_column(SharedColumn<Law> c, Model model, const SolveOptions& o) {
    if (model == Model::independent) return std::make_unique<solve::EventDriven<Law>>(std::move(c), o);
    if constexpr (has_exact_solver<Law>) {
        const bool adiabatic = model == Model::adiabatic;
        if (solved_exactly(*c) && (adiabatic || !o.general))
            return std::make_unique<solve::Exact>(std::move(c),
                                                  adiabatic ? Coupling::adiabatic : Coupling::full, o);
    }
    if (model == Model::newton) return std::make_unique<solve::Integrated<Law>>(std::move(c), o);
    return nullptr;
}

}  // namespace hardlimit::column
