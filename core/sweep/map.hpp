// A map: every point of a grid (or list) of parameters, in blocks, on a few threads.
#pragma once
#include <atomic>
#include <bit>
#include <cstdint>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "block.hpp"
#include "point.hpp"
#include "viscoelastic.hpp"

namespace hardlimit::sweep {

// Values of one parameter along one dimension of the result: value index = (point / stride) mod size.
struct Axis {
    const double* values;
    u64 stride, size;
};

struct Axes {
    Axis axis[parameter_count];
};

// Walks through the points of a map in order, without a division for each.
class Cursor {
    const Axes& axes;
    int varying[parameter_count], n_varying = 0;
    u64 index[parameter_count] = {}, run[parameter_count] = {};
    double value[parameter_count];

public:
    Cursor(const Axes& a, u64 point) : axes(a) {
        for (int i = 0; i < parameter_count; ++i) {
            const Axis& k = axes.axis[i];
            if (k.size > 1) {
                varying[n_varying++] = i;
                index[i] = (point / k.stride) % k.size;
                run[i] = point % k.stride;
            }
            value[i] = k.values[index[i]];
        }
    }
    Parameters parameters() const { return std::bit_cast<Parameters>(value); }
    void next() {
        for (int v = 0; v < n_varying; ++v) {
            const int i = varying[v];
            const Axis& k = axes.axis[i];
            if (++run[i] < k.stride) continue;
            run[i] = 0;
            if (++index[i] == k.size) index[i] = 0;
            value[i] = k.values[index[i]];
        }
    }
};

// Where results go; a null pointer: not wanted. Index 0 is the first point of the call.
struct Outputs {
    std::uint8_t* n_contacts;
    std::uint8_t* outcome;
    double *relative_velocity, *separation_velocity, *effective_restitution, *restitution_ratio, *t_end,
        *t_floor_end;
};

// Counts that a byte cannot hold.
struct LargeCount {
    u64 point;
    int count;
};

struct Job {
    Axes axes;
    Setting setting;
    const hardlimit_abi::Kernel* kernel;
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

// How a law gets through its vector kernel; a law without one is solved point by point.
template <class Law>
struct Vectorised {
    static bool covers(Model) { return false; }
};

template <>
struct Vectorised<contact::LinearDashpot> {
    using Block = hardlimit_abi::Block;
    using Kernel = hardlimit_abi::Kernel;
    static bool covers(Model model) { return model != Model::independent; }
    static void solve(const Kernel& kernel, const Block& b) { kernel.solve(b); }
    // What the law needs to know of each −ln ε, in place: β/ω0.
    static void invert(const Kernel& kernel, double* exponents, int n) {
        kernel.damping_ratios(exponents, n);
    }
    static bool enter(const Setting& setting, Parameters& p, double floor, double pair, column::Start& s) {
        return sweep::enter(setting, p, floor, pair, s);
    }
};

template <>
struct Vectorised<contact::Viscoelastic> {
    using Block = hardlimit_abi::Block;
    using Kernel = hardlimit_abi::Kernel;
    static bool covers(Model model) { return model == Model::newton; }
    static void solve(const Kernel& kernel, const Block& b) { kernel.solve_viscoelastic(b); }
    static void invert(const Kernel&, double* exponents, int n) {
        for (int i = 0; i < n; ++i) exponents[i] = LossTable::shared().argument(exponents[i]);
    }
    static bool enter(const Setting& setting, Parameters& p, double floor, double pair, column::Start& s) {
        return enter_viscoelastic(setting, p, floor, pair, s);
    }
};

// Points of one block on their way through the vector kernel.
template <class Law>
class VectorBlock {
    using Via = Vectorised<Law>;

public:
    static constexpr int most = 1024;

    void solve(Job& job, u64 first, int count) {
        Cursor at(job.axes, job.first + first);
        for (int i = 0; i < count; ++i, at.next()) p[i] = at.parameters();
        damping(job, count);
        int n = 0;
        for (int i = 0; i < count; ++i) {
            slot[i] = enter_block(job.setting, i, n) ? n++ : -1;
        }
        const hardlimit_abi::Block b = {n,     in[0], in[1],  in[2],  in[3],  in[4],  in[5],  in[6],  in[7],
                                        in[8], in[9], out[0], out[1], out[2], out[3], out[4], out[5], status};
        Via::solve(*job.kernel, b);
        for (int i = 0; i < count && !job.stop; ++i) {
            using hardlimit_abi::Status;
            PointResult r;
            const int k = slot[i];
            const Status end = k >= 0 ? static_cast<Status>(status[k]) : Status::left;
            if (end == Status::left)
                r = solve_point<Law>(job.setting, p[i]);
            else
                r = leave(job.setting, p[i], units[k],
                          {out[0][k], out[1][k], out[2][k], out[3][k], out[4][k], out[5][k]},
                          end == Status::rests ? Outcome::at_rest : Outcome::ok);
            job.put(first + static_cast<u64>(i), r);
        }
    }

private:
    Parameters p[most];
    double ratio[2][most] = {};  // what Via::invert makes of floor's and pair's ε, when given by it
    double listed[2 * most];
    int list_of[2][most];
    double in[10][most], out[6][most];
    int status[most], slot[most];
    column::Units units[most];

    // Once for each run of equal values.
    void damping(const Job& job, int count) {
        if (job.setting.restitution_at < 0) return;
        int n = 0;
        double last = math::nan;
        for (int i = 0; i < count; ++i) {
            for (int side = 0; side < 2; ++side) {
                const double e = (side == 0 ? p[i].floor_law : p[i].pair_law)[job.setting.restitution_at];
                if (e != last) listed[n++] = -math::log(e);
                last = e;
                list_of[side][i] = n - 1;
            }
        }
        Via::invert(*job.kernel, listed, n);
        for (int side = 0; side < 2; ++side)
            for (int i = 0; i < count; ++i) ratio[side][i] = listed[list_of[side][i]];
    }

    // Groups and start of point i into place k; false if it is not one for the kernel.
    bool enter_block(const Setting& setting, int i, int k) {
        column::Start s;
        if (!Via::enter(setting, p[i], ratio[0][i], ratio[1][i], s)) return false;
        const double values[10] = {s.groups.a1, s.groups.a2, s.groups.c1, s.groups.c2, s.groups.gravity,
                                   s.first.u,   s.first.du,  s.first.w,   s.first.dw,  s.t};
        for (int j = 0; j < 10; ++j) in[j][k] = values[j];
        units[k] = s.units;
        return true;
    }
};

// Takes blocks until none is left; each result depends on its point alone, so neither the number of threads nor the
// order matters.
template <class Law>
void work(Job& job, u64 block) {
    const auto each_block = [&](const auto& solve) {
        for (;;) {
            const u64 begin = job.next.fetch_add(block);
            if (begin >= job.count || job.stop) break;
            const u64 end = begin + block < job.count ? begin + block : job.count;
            solve(begin, end);
            job.done += end - begin;
        }
    };
    const auto by_point = [&](u64 begin, u64 end) {
        Cursor at(job.axes, job.first + begin);
        for (u64 i = begin; i < end && !job.stop; ++i, at.next())
            job.put(i, solve_point<Law>(job.setting, at.parameters()));
    };
    if (job.kernel && Vectorised<Law>::covers(job.setting.model)) {
        if constexpr (requires { typename Vectorised<Law>::Kernel; }) {
            constexpr int most = VectorBlock<Law>::most;
            const auto lanes = std::make_unique<VectorBlock<Law>>();
            each_block([&](u64 begin, u64 end) {
                for (u64 i = begin; i < end && !job.stop; i += most)
                    lanes->solve(job, i, static_cast<int>(end - i < most ? end - i : most));
            });
        }
    } else {
        each_block(by_point);
    }
    --job.running;
}

}  // namespace hardlimit::sweep
