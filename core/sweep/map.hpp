// Solves a map of two-ball drops, a grid or list of parameter points, in batches on several threads.
#pragma once
#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <mutex>
#include <numeric>
#include <vector>

#include "../base/threads.hpp"
#include "axes.hpp"
#include "batch.hpp"
#include "list_order.hpp"
#include "solve_point.hpp"
#include "viscoelastic_entry.hpp"

namespace hardlimit::sweep {

inline Parameters parameters_at(const double* values) {
    Parameters p;
    std::memcpy(&p, values, sizeof p);
    return p;
}

// Output arrays; those that are null are skipped. Index 0 is the first point of the call.
struct Outputs {
    std::uint8_t *n_contacts, *outcome;
    double* quantity[quantity_count];
};

// A number of contacts above 255, which does not fit into the byte array.
struct LargeCount {
    u64 point;
    int count;
};

// `axes` has one entry for each field of Parameters.
struct Job : PointQueue {
    Setting setting;
    const hardlimit_abi::Kernel* kernel;
    double log2_tolerance;  // error tolerance of a step of the viscoelastic kernel
    Outputs out;
    std::mutex guard;
    std::vector<LargeCount> large;  // protected by guard
    std::once_flag begun;
    // Damping of floor and pair for each ε of their axis; if empty, computed batch by batch.
    std::vector<double> damping[2];

    // Axis of ε of floor (0) or pair (1), for a law specified by ε.
    const Axis& restitution_axis(int side) const {
        return axes[static_cast<std::size_t>(geometry_count + side * max_parameters +
                                             setting.restitution_at)];
    }
    bool one_restitution() const { return restitution_axis(0).values == restitution_axis(1).values; }

    // Whether the points are a list rather than a grid: each has values of its own.
    bool is_list() const {
        return std::all_of(axes.begin(), axes.end(), [this](const Axis& k) {
            return k.size == 1 || (k.stride == 1 && first + count <= k.size);
        });
    }
    // Order in which points begin … end − 1 are solved; empty: as they are.
    ListOrder order(u64 begin, u64 end) const {
        if (!is_list()) return {};
        std::vector<const double*> parameters;
        for (const Axis& k : axes) {
            const double* const values = k.values + first + begin;
            if (k.size > 1 && std::find(parameters.begin(), parameters.end(), values) == parameters.end())
                parameters.push_back(values);
        }
        return {parameters, static_cast<int>(end - begin)};
    }

    void put(u64 i, int n_contacts, Outcome outcome) {
        if (out.n_contacts) {
            out.n_contacts[i] = static_cast<std::uint8_t>(n_contacts > 255 ? 255 : n_contacts);
            if (n_contacts > 255) {
                const std::lock_guard lock(guard);
                large.push_back({i, n_contacts});
            }
        }
        if (out.outcome) out.outcome[i] = static_cast<std::uint8_t>(outcome);
    }
    void put(u64 i, const PointResult& r) {
        put(i, r.n_contacts, r.outcome);
        for (int k = 0; k < quantity_count; ++k)
            if (out.quantity[k]) out.quantity[k][i] = r.of[k];
    }
};

// Interface between a law and its vector kernel. A law without a kernel is solved point by point.
template <class Law>
struct Vectorised {
    static constexpr bool on_gpu = false;  // whether kernel.cu is this kernel
    static bool covers(Model) { return false; }
};

template <>
struct Vectorised<contact::LinearDashpot> {
    using Batch = hardlimit_abi::Batch;
    using Kernel = hardlimit_abi::Kernel;
    static constexpr bool on_gpu = true;
    static bool covers(Model model) { return model != Model::independent; }
    static void solve(const Kernel& kernel, const Batch& b, double) { kernel.solve(b); }
    // Replaces each ε by β/ω0.
    static void invert(const Kernel& kernel, double* restitution, int n) {
        kernel.damping_ratios(restitution, n);
    }
    bool enter(const Setting& setting, Parameters& p, double floor, double pair, column::Start& s) {
        return sweep::enter(setting, p, floor, pair, s);
    }
    static column::CompressionBound bound(const Setting& setting, const Parameters& p) {
        return linear_bound(setting, p);
    }
};

template <>
struct Vectorised<contact::Viscoelastic> {
    using Batch = hardlimit_abi::Batch;
    using Kernel = hardlimit_abi::Kernel;
    static constexpr bool on_gpu = false;
    static bool covers(Model model) { return model == Model::newton; }
    static void solve(const Kernel& kernel, const Batch& b, double log2_tolerance) {
        kernel.solve_viscoelastic(b, log2_tolerance);
    }
    static void invert(const Kernel&, double* restitution, int n) {
        for (int i = 0; i < n; ++i) restitution[i] = LossTable::shared().argument(-math::log(restitution[i]));
    }
    bool enter(const Setting& setting, Parameters& p, double floor, double pair, column::Start& s) {
        return enter_viscoelastic(setting, p, floor, pair, rates, s);
    }
    static column::CompressionBound bound(const Setting& setting, const Parameters& p) {
        return viscoelastic_bound(setting, p);
    }

private:
    Rates rates;
};

// Solves a batch of points with the vector kernel.
template <class Law>
class VectorBatch {
    using Via = Vectorised<Law>;

public:
    static constexpr int most = 1024;

    VectorBatch(Job& j, Stop& stop_) : job(j), stop(stop_) {
        for (int i = 0; i < parameter_count; ++i) {
            const Axis& k = job.axes[static_cast<std::size_t>(i)];
            if (k.size > 1)
                varying[n_varying++] = i;
            else
                for (double& v : value[i]) v = k.values[0];
            if (k.size > 1 && i != gap_at) alike = std::gcd(alike, k.stride);
        }
    }

    // Solves points begin … begin + size − 1 or, of a list, the points begin + chosen[0 … size − 1].
    void solve(u64 begin, int size, const int* chosen = nullptr) {
        first = begin;
        count = size;
        order = chosen;
        for (int v = 0; v < n_varying; ++v)
            read(value[varying[v]], job.axes[static_cast<std::size_t>(varying[v])]);
        if (job.setting.restitution_at >= 0) damping();
        enter();
        Via::solve(*job.kernel, drops.batch(), job.log2_tolerance);
        leave();
    }

private:
    static constexpr int gap_at = offsetof(Parameters, gap) / sizeof(double);
    static constexpr int room = Drops<most>::room;
    Job& job;
    Stop& stop;
    Via via;
    int varying[parameter_count], n_varying = 0;
    u64 alike = 0;  // parameters other than the gap change only at multiples of this; 0: never
    u64 first;
    int count;
    const int* order;                     // of the points, counted from `first`; null: as they are
    double value[parameter_count][room];  // the parameters
    double ratio[2][most] = {};  // Via::invert of the ε of floor and pair, if the law is specified by ε
    Drops<most> drops;
    int point[most];                  // of each drop
    column::DropBound shallow[most];  // of each drop
    double restitution[room], quotient[2][room];

    u64 place(int i) const { return first + static_cast<u64>(order ? order[i] : i); }

    // Reads the parameter of an axis at the points.
    void read(double* to, const Axis& axis) const {
        if (!order) return fill(to, axis, job.first + first, count);
        for (int i = 0; i < count; ++i) to[i] = axis.values[axis.size > 1 ? job.first + place(i) : 0];
    }

    // Calls f(i, end) for each range of points that differ only in the gap.
    template <class F>
    void each_run(F f) {
        u64 end = alike == 0 ? most : alike - (job.first + first) % alike;
        for (int i = 0; i < count; end += alike) {
            const int last = end < static_cast<u64>(count) ? static_cast<int>(end) : count;
            f(i, last);
            i = last;
        }
    }

    Parameters parameters(int i) const {
        double p[parameter_count];
        for (int j = 0; j < parameter_count; ++j) p[j] = value[j][i];
        return std::bit_cast<Parameters>(p);
    }

    void damping() {
        for (int side = 0; side < 2; ++side) {
            const Axis& axis = job.restitution_axis(side);
            const std::vector<double>& known = job.damping[side];
            if (!known.empty()) {
                read(ratio[side], {known.data(), axis.stride, axis.size});
            } else if (side == 1 && job.one_restitution()) {
                std::copy_n(ratio[0], count, ratio[1]);
            } else {
                read(ratio[side], axis);
                Via::invert(*job.kernel, ratio[side], count);
            }
        }
    }

    // Adds the points to the kernel's batch; points that the kernel cannot take are solved here.
    void enter() {
        drops.count = 0;
        each_run([&](int i, int end) {
            const double* gap = value[gap_at];
            Parameters p = parameters(i);
            const double e = restitution_of(job.setting, p);
            column::Start s;
            column::CompressionBound bound;
            bool started = false;
            for (int at = i; at < end && !stop(); ++at) {
                bool one;
                if (started) {
                    column::release_pair(s, gap[at]);
                    one = math::is_finite(s.first.w);
                } else {
                    p.gap = gap[at];
                    one = started = via.enter(job.setting, p, ratio[0][i], ratio[1][i], s);
                    if (one) bound = Via::bound(job.setting, p);
                }
                column::DropBound& sure = shallow[drops.count];
                if (one) sure = column::DropBound::of(bound, gap[at], s.units.speed);
                if (!one || !sure.holds(0.0)) {
                    solve_alone(at);
                    continue;
                }
                restitution[drops.count] = e;
                point[drops.count] = at;
                drops.add(s);
            }
        });
    }

    // Stores the results. The scalar solver solves the points that the kernel did not solve and those in which a
    // contact may be too deep.
    void leave() {
        const int n = drops.count;
        auto& out = drops.out;
        job.kernel->leave({n, drops.speed, drops.rate, restitution, out[1], out[2], out[3], out[4], out[5],
                           quotient[0], quotient[1]});
        const auto give = [&](double* to, const double* from) {
            if (!to) return;
            if (n == count && !order)
                std::copy_n(from, n, to + first);
            else
                for (int k = 0; k < n; ++k) to[place(point[k])] = from[k];
        };
        const double* const solved[quantity_count] = {out[4],      out[5], quotient[0],
                                                      quotient[1], out[2], out[3]};
        for (int k = 0; k < quantity_count; ++k) give(job.out.quantity[k], solved[k]);
        for (int k = 0; k < n && !stop(); ++k) {
            if (drops.unsolved(k) || !shallow[k].holds(drops.n_contacts(k), out[2][k])) {
                solve_alone(point[k]);
                continue;
            }
            column::Sequence q;
            q.n_contacts = drops.n_contacts(k);
            q.outcome = drops.outcome(k);
            q.close();
            job.put(place(point[k]), q.n_contacts, q.outcome);
        }
    }

    // Not inlined: inlining into both loops made the scalar solver 1 to 2 % slower.
    HL_FN_APART void solve_alone(int i) {
        const PointResult r = solve_point<Law>(job.setting, parameters(i), stop);
        if (!stop.stopped()) job.put(place(i), r);
    }
};

// Computes the damping for each ε of an axis, if many points share its values.
template <class Law>
void tabulate_damping(Job& job) {
    constexpr u64 longest = u64{1} << 20;
    if (job.setting.restitution_at < 0) return;
    for (int side = 0; side < 2; ++side) {
        const Axis& axis = job.restitution_axis(side);
        if (axis.size > longest || 2 * axis.size > job.count) continue;
        if (side == 1 && job.one_restitution()) {
            job.damping[1] = job.damping[0];
            continue;
        }
        job.damping[side].assign(axis.values, axis.values + axis.size);
        Vectorised<Law>::invert(*job.kernel, job.damping[side].data(), static_cast<int>(axis.size));
    }
}

// Work of one thread, in batches of `size` points.
template <class Law>
void work(Job& job, u64 size, Stop& stop) {
    if constexpr (requires { typename Vectorised<Law>::Kernel; }) {
        if (job.kernel && Vectorised<Law>::covers(job.setting.model)) {
            constexpr int most = VectorBatch<Law>::most;
            std::call_once(job.begun, tabulate_damping<Law>, std::ref(job));
            const auto lanes = std::make_unique<VectorBatch<Law>>(job, stop);
            job.for_each_batch(size, stop, [&](u64 begin, u64 end) {
                const ListOrder order = job.order(begin, end);
                for (u64 i = begin; i < end && !stop(); i += most) {
                    const int n = static_cast<int>(end - i < most ? end - i : most);
                    order.empty() ? lanes->solve(i, n) : lanes->solve(begin, n, order.points() + (i - begin));
                }
            });
            return;
        }
    }
    job.for_each_point(
        size, stop,
        [&](const double* values) { return solve_point<Law>(job.setting, parameters_at(values), stop); },
        [&](u64 i, const PointResult& r) { job.put(i, r); });
}

}  // namespace hardlimit::sweep
