// A map: every point of a grid (or list) of parameters, in blocks, on a few threads.
#pragma once
#include <atomic>
#include <cstdint>
#include <mutex>
#include <thread>
#include <vector>

#include "point.hpp"

namespace hardlimit::sweep {

// Values of one parameter along one dimension of the result: value index = (point / stride) mod size.
struct Axis {
    const double* values;
    u64 stride, size;
    double at(u64 point) const { return values[size == 1 ? 0 : (point / stride) % size]; }
};

struct Axes {
    Axis axis[parameter_count];
    Parameters at(u64 point) const {
        double p[parameter_count];
        for (int i = 0; i < parameter_count; ++i) p[i] = axis[i].at(point);
        return __builtin_bit_cast(Parameters, p);
    }
};

// Where results go; a null pointer: not wanted. Index 0 is the first point of the call.
struct Outputs {
    std::uint8_t* n_contacts;
    std::uint8_t* outcome;
    double *relative_velocity, *separation_velocity, *effective_restitution, *restitution_ratio, *t_end, *t_floor_end;
};

// Counts that a byte cannot hold.
struct LargeCount {
    u64 point;
    int count;
};

struct Job {
    Axes axes;
    Setting setting;
    u64 first, count;
    Outputs out;
    std::atomic<u64> next{0}, done{0};
    std::atomic<bool> stop{false};
    std::atomic<int> running{0};
    std::mutex guard;
    std::vector<LargeCount> large;

    void put(u64 i, const PointResult& r) {
        if (out.n_contacts) {
            out.n_contacts[i] = static_cast<std::uint8_t>(r.n_contacts > 255 ? 255 : r.n_contacts);
            if (r.n_contacts > 255) {
                const std::lock_guard lock(guard);
                large.push_back({i, r.n_contacts});
            }
        }
        if (out.outcome) out.outcome[i] = static_cast<std::uint8_t>(r.outcome);
        if (out.relative_velocity) out.relative_velocity[i] = r.relative_velocity;
        if (out.separation_velocity) out.separation_velocity[i] = r.separation_velocity;
        if (out.effective_restitution) out.effective_restitution[i] = r.effective_restitution;
        if (out.restitution_ratio) out.restitution_ratio[i] = r.restitution_ratio;
        if (out.t_end) out.t_end[i] = r.t_end;
        if (out.t_floor_end) out.t_floor_end[i] = r.t_floor_end;
    }
};

// Takes blocks until none is left; each result depends on its point alone, so neither the number of threads nor the
// order matters.
template <class Law>
void work(Job& job, u64 block) {
    for (;;) {
        const u64 begin = job.next.fetch_add(block);
        if (begin >= job.count || job.stop) break;
        const u64 end = begin + block < job.count ? begin + block : job.count;
        for (u64 i = begin; i < end && !job.stop; ++i) job.put(i, solve_point<Law>(job.setting, job.axes.at(job.first + i)));
        job.done += end - begin;
    }
    --job.running;
}

}  // namespace hardlimit::sweep
