// Steps of order 8 of a state vector, and states within the step.
#pragma once
#include "../../../base/dormand_prince.hpp"
#include "slip_step.hpp"

namespace hardlimit::boxes {

// States within a step, if they are known without integration.
struct StepSeries {
    virtual void move(double t, double* y) = 0;  // y becomes the state a time t after the start, except sums
    virtual void add_sums(double t, double* y) = 0;  // adds what happens until then to the sums

protected:
    ~StepSeries() = default;
};

// A step from a state y: the slope there, the end of the step, and a trial state within it. A slope is a derivative
// d/dτ, computed by f(y, slope).
class Integrator {
public:
    double length = 0.0;           // of the next step; 0: unknown
    bool implicit = false;         // whether the step is one of SlipStep; with friction only
    bool converged = true;         // whether all implicit steps since this was set did
    double implicit_length = 0.0;  // of the next such step; 0: unknown
    StepSeries* series = nullptr;  // of the step, instead; with friction only
    WorkVector<double> slope, end, end_slope, trial, trial_slope, tolerance;
    WorkVector<double> near, near_slope;  // close to one of these states, for differences

    bool explicit_step() const { return !implicit && !series; }

    // For a state that has changed since the last step; restart() also forgets the length of the step.
    void forget() { known_ = false; }
    void restart() { known_ = false, length = implicit_length = 0.0; }

    template <class F>
    void begin(const F& f, const StateVector& state) {
        const auto n = state.y.size();
        for (auto* x : {&slope, &end, &end_slope, &trial, &trial_slope, &tolerance}) x->resize(n);
        stages_.resize(n * DormandPrince::stages);
        if (!known_) f(state.y.data(), slope.data());
        known_ = true;
    }
    // Computes the end of a step. error() is in units of the tolerance: the virial has none of its own, but counts as
    // one component.
    template <class F>
    void advance(const F& f, const StateVector& state, double step) {
        advance(f, state, step, end);
    }
    double error(const StateVector& state, double step) const {
        if (implicit) return error_;
        const int n = state.layout.size(), used = state.layout.virial();
        return DormandPrince::error(stages_.data(), step, n, tolerance.data(), used, used + 1);
    }
    // Computes the trial state at a part of the step.
    template <class F>
    void probe(const F& f, const StateVector& state, double at) {
        advance(f, state, at, trial);
        f(trial.data(), trial_slope.data());
    }
    // Moves the trial state by a very short step.
    template <class F>
    HL_FN_APART void nudge(const F& f, double step) {
        const std::size_t n = trial.size();
        for (std::size_t c = 0; c < n; ++c) stages_[c] = trial[c] + 0.5 * step * trial_slope[c];
        f(stages_.data(), trial_slope.data());
        for (std::size_t c = 0; c < n; ++c) trial[c] += step * trial_slope[c];
        f(trial.data(), trial_slope.data());
    }
    void end_at_trial() { end.swap(trial), end_slope.swap(trial_slope); }
    // Ends the step where the time is `until`, before its present end. Returns its length.
    template <class F>
    HL_FN_APART double end_at_time(const F& f, const StateVector& state, double until, double step) {
        const auto time = static_cast<std::size_t>(state.layout.time());
        double low = 0.0, high = step, at = step * (until - state.time()) / (end[time] - state.time());
        for (int i = 0; i < 80; ++i) {
            probe(f, state, at);
            const double excess = trial[time] - until;
            (excess > 0.0 ? high : low) = at;
            const double next = at - excess / trial_slope[time], previous = at;
            at = next > low && next < high ? next : 0.5 * (low + high);
            if (math::abs(at - previous) <= 4.0 * math::epsilon * step) break;
        }
        probe(f, state, at);
        end_at_trial();
        return at;
    }
    // Makes the end of the step the state.
    void accept(StateVector& state) { state.y.swap(end), slope.swap(end_slope); }

private:
    template <class F>
    HL_FN_APART void advance(const F& f, const StateVector& state, double step, WorkVector<double>& out) {
        if constexpr (FrictionalLaw<typename F::Law>) {
            if (series) return series->move(step, out.data());
            if (implicit) {
                error_ = SlipStep<typename F::Law>(f, tolerance.data(), slip_)
                             .take(state.y.data(), step, out.data());
                converged = converged && error_ < math::infinity;
                return;
            }
        }
        std::copy(slope.begin(), slope.end(), stages_.begin());
        const StateLayout& at = state.layout;
        DormandPrince::step(f, state.y.data(), step, at.size(), stages_.data(), out.data(), at.virial());
    }

    WorkVector<double> stages_;
    SlipStages slip_;
    double error_ = 0.0;  // of an implicit step
    bool known_ = false;  // whether `slope` is that of the state
};

}  // namespace hardlimit::boxes
