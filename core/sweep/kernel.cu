// A map on a GPU, compiled at run time by src/hardlimit/maps/cuda.py. A thread is one lane of the kernel of lanes.hpp and
// a warp is its vector: each round is spent on the step that most threads of the warp wait for, where to take a new
// drop is a step too. Warps draw their drops from one queue until it is empty. A result depends on its point alone,
// so it has the bits of a processor's.
#include "lanes.hpp"
#include "parameters.hpp"

namespace hardlimit::sweep {

// Written by cuda.py; every field takes eight bytes.
struct Task {
    u64 next;   // point of the queue
    u64 count;  // points in all
    // Value of parameter i at a point: values[i][(point / stride[i]) % size[i]].
    const double* values[parameter_count];
    u64 stride[parameter_count], size[parameter_count];
    double* ratio[2];  // b = β/ω0 of floor and pair for each ε among their values
    i64 adiabatic, density_1, density_2, restitution_at;
    // Results, null: not wanted. The outcome is always.
    unsigned char *n_contacts, *outcome;
    double *relative_velocity, *separation_velocity, *effective_restitution, *restitution_ratio, *t_end,
        *t_floor_end;
};

// Outcome of a point that is left to the scalar solver on the host.
inline constexpr unsigned char left_to_host = 255;
inline constexpr int largest_count = 255;  // of n_contacts in a byte

inline constexpr int warp = 32;
inline constexpr unsigned everyone = 0xffffffffu;

HL_FN unsigned place(const Task& task, int i, unsigned point) {
    const unsigned size = static_cast<unsigned>(task.size[i]);
    return size > 1 ? (point / static_cast<unsigned>(task.stride[i])) % size : 0;
}

HL_FN Setting setting_of(const Task& task) {
    return {task.adiabatic ? Model::adiabatic : Model::newton, 0, task.density_1 != 0, task.density_2 != 0,
            static_cast<int>(task.restitution_at)};
}

HL_FN Parameters parameters_of(const Task& task, unsigned point) {
    const auto value = [&](int i) { return task.values[i][place(task, i, point)]; };
    Parameters p = {value(0), value(1), value(2), value(3), value(4), value(5),
                    value(6), value(7), value(8), value(9), {},       {}};
    for (int i = 0; i < max_parameters; ++i) {
        p.floor_law[i] = value(geometry_count + i);
        p.pair_law[i] = value(geometry_count + max_parameters + i);
    }
    return p;
}

HL_FN double ratio_of(const Task& task, int side, unsigned point) {
    if (task.restitution_at < 0) return 0.0;
    const int i = geometry_count + side * max_parameters + static_cast<int>(task.restitution_at);
    return task.ratio[side][place(task, i, point)];
}

HL_FN void put(const Task& task, unsigned point, const PointResult& r) {
    const bool large = r.n_contacts > largest_count;
    task.outcome[point] = large ? left_to_host : static_cast<unsigned char>(r.outcome);
    if (task.n_contacts) task.n_contacts[point] = static_cast<unsigned char>(r.n_contacts);
    if (task.relative_velocity) task.relative_velocity[point] = r.relative_velocity;
    if (task.separation_velocity) task.separation_velocity[point] = r.separation_velocity;
    if (task.effective_restitution) task.effective_restitution[point] = r.effective_restitution;
    if (task.restitution_ratio) task.restitution_ratio[point] = r.restitution_ratio;
    if (task.t_end) task.t_end[point] = r.t_end;
    if (task.t_floor_end) task.t_floor_end[point] = r.t_floor_end;
}

// A drop on its way through one thread.
struct Thread {
    lanes::State<double> q{};
    lanes::Waiting<bool> wait{};
    column::Units units{};
    unsigned point = 0;
    bool busy = false;

    // Starts at `point`; a point that is not one for this kernel leaves the thread idle.
    HL_FN void take(const Task& task) {
        Parameters p = parameters_of(task, point);
        column::Start s;
        if (!enter(setting_of(task), p, ratio_of(task, 0, point), ratio_of(task, 1, point), s)) {
            task.outcome[point] = left_to_host;
            return;
        }
        units = s.units;
        const hardlimit_abi::Block one = {
            1,          &s.groups.a1, &s.groups.a2, &s.groups.c1, &s.groups.c2, &s.groups.gravity,
            &s.first.u, &s.first.du,  &s.first.w,   &s.first.dw,  &s.t,         nullptr,
            nullptr,    nullptr,      nullptr,      nullptr,      nullptr,      nullptr};
        wait.drop(0);
        lanes::load(q, 0, one, 0);
        busy = true;
    }

    HL_FN void give(const Task& task) {
        busy = false;
        if (q.left) {
            task.outcome[point] = left_to_host;
            return;
        }
        const Found found = {q.contacts, q.t_first, q.t_end, q.t_floor_end, q.relative, q.separation};
        put(task, point, leave(setting_of(task), parameters_of(task, point), units, found));
    }
};

enum Step : int { lying, pressed, lasting, stuck, idle, none };

HL_FN Step next_step(const Thread& t, bool empty) {
    if (!t.busy) return empty ? none : idle;
    return t.wait.lying ? lying : t.wait.pressed ? pressed : t.wait.lasting ? lasting : stuck;
}

// The step that most threads of the warp wait for; `none` when all are done.
__device__ inline Step most_wanted(Step mine) {
    Step wanted = none;
    int most = 0;
    for (int i = 0; i < none; ++i) {
        const int n = __popc(__ballot_sync(everyone, mine == i));
        if (n > most) {
            most = n;
            wanted = static_cast<Step>(i);
        }
    }
    return wanted;
}

// A place in the queue for each thread that draws.
__device__ inline u64 draw(Task& task, bool draws) {
    const unsigned who = __ballot_sync(everyone, draws), lane = threadIdx.x % warp;
    u64 first = 0;
    if (lane == 0) first = atomicAdd(&task.next, static_cast<u64>(__popc(who)));
    return __shfl_sync(everyone, first, 0) + static_cast<u64>(__popc(who & ((1u << lane) - 1u)));
}

}  // namespace hardlimit::sweep

using hardlimit::sweep::Task;

extern "C" __global__ void __launch_bounds__(128) solve(Task* task) {
    using namespace hardlimit::sweep;
    Thread t;
    bool empty = false;
    for (;;) {
        const Step mine = next_step(t, empty), now = most_wanted(mine);
        if (now == none) break;
        bool moved = mine == now;
        if (now == idle) {
            const hardlimit::u64 point = draw(*task, moved);
            if (moved) {
                empty = point >= task->count;
                t.point = static_cast<unsigned>(point);
                if (!empty) t.take(*task);
            }
        } else if (moved) {
            moved = lanes::step<double>(t.q, t.wait);
        }
        if (t.busy && moved) lanes::sort<double>(t.q, t.wait, true);
        if (t.busy && !t.q.active) t.give(*task);
    }
}

// b of every ε among the values of floor and pair.
extern "C" __global__ void damping_ratios(Task* task) {
    using namespace hardlimit::sweep;
    for (int side = 0; side < 2; ++side) {
        const int i =
            geometry_count + side * hardlimit::max_parameters + static_cast<int>(task->restitution_at);
        for (hardlimit::u64 k = threadIdx.x + blockIdx.x * blockDim.x; k < task->size[i];
             k += gridDim.x * blockDim.x)
            task->ratio[side][k] =
                hardlimit::contact::linear_damping_ratio<double>(-hardlimit::math::log(task->values[i][k]));
    }
}
