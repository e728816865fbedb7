// Solves a map of columns with any number of balls, point by point, on several threads.
#pragma once
#include <cstdint>

#include "axes.hpp"
#include "solve_column.hpp"

namespace hardlimit::sweep {

// Output arrays; those that are null are skipped. Index 0 is the first point of the call.
struct ColumnOutputs {
    std::uint32_t* n_contacts;
    std::uint8_t* outcome;
    double *t_end, *t_floor_end;
    double *rebound_height, *final_velocity;  // [count × N]
};

struct ColumnJob : PointQueue {
    ColumnSetting setting;
    ColumnOutputs out;

    void put(u64 i, const ColumnResult& r) const {
        const column::Sequence& q = r.sequence;
        if (out.n_contacts) out.n_contacts[i] = static_cast<std::uint32_t>(q.n_contacts);
        if (out.outcome) out.outcome[i] = static_cast<std::uint8_t>(q.outcome);
        if (out.t_end) out.t_end[i] = one_nan(q.t_end);
        if (out.t_floor_end) out.t_floor_end[i] = one_nan(q.t_floor_end);
        put(out.rebound_height, i, r.rebound_height);
        put(out.final_velocity, i, r.final_velocity);
    }

private:
    static void put(double* out, u64 i, const std::vector<double>& of_balls) {
        if (!out) return;
        for (std::size_t j = 0; j < of_balls.size(); ++j) out[i * of_balls.size() + j] = one_nan(of_balls[j]);
    }
};

// Work of one thread, in batches of `size` points.
template <class Law>
void work_columns(ColumnJob& job, u64 size, Stop& stop) {
    job.for_each_point(
        size, stop, [&](const double* values) { return solve_one<Law>(job.setting, values, stop); },
        [&](u64 i, const ColumnResult& r) { job.put(i, r); });
}

}  // namespace hardlimit::sweep
