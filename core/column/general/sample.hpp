// Dense output: the state of a recorded integration at any time.
#pragma once
#include <algorithm>
#include <vector>

#include "run.hpp"

namespace hardlimit::column {

// Output arrays of sample(); those that are null are skipped.
struct Samples {
    double* gaps;        // [n × N] [m]
    double* velocity;    // [n × N] [m/s]
    double* force;       // [n × N] [N], pair 0 (floor) first
    Energies* energies;  // [n] [J]
};

// Writes the states at n times of a recorded integration; NaN outside the recorded range.
template <class Law>
void sample(const Column<Law>& column, const Integration<Law>& run, const double* times, long n,
            const Samples& out) {
    newton::Motion<Law> motion(column);
    const int balls = column.balls;
    std::vector<double> k(motion.dimension()), y(motion.dimension());
    for (long i = 0; i < n; ++i) {
        const auto after =
            std::upper_bound(run.intervals.begin(), run.intervals.end(), times[i],
                             [](double t, const newton::Interval& interval) { return t < interval.t; });
        const bool known = after != run.intervals.begin() && times[i] <= run.intervals.back().t;
        if (known) {
            const newton::Interval& from = *(after - 1);
            const double* start =
                run.states.data() + (after - 1 - run.intervals.begin()) * motion.dimension();
            motion.pair = run.modes[from.modes].pair;
            motion.uses_root = run.modes[from.modes].uses_root;
            motion.implicit = run.modes[from.modes].implicit;
            motion(start, k.data());
            if (from.length > 0.0) {
                motion.reach(start, k.data(), from.length, times[i], y.data());
            } else {
                std::copy(start, start + motion.dimension(), y.begin());
            }
        } else {
            std::fill(y.begin(), y.end(), math::nan);
        }
        for (int j = 0; j < balls; ++j) {
            const double pushed = column.contacts[j].force(motion.s(j, y.data()), motion.rate(j, y.data()));
            const double force = motion.pushes(j) ? math::max(pushed, 0.0) : 0.0;
            if (out.gaps) out.gaps[i * balls + j] = motion.gap(j, y.data());
            if (out.velocity) out.velocity[i * balls + j] = y[balls + j];
            if (out.force) out.force[i * balls + j] = known ? force : math::nan;
        }
        if (out.energies) out.energies[i] = motion.energies(y.data());
    }
}

}  // namespace hardlimit::column
