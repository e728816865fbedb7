// A map on a GPU, compiled at run time by src/hardlimit/sweep/engines/cuda_device.py. A block keeps a pool of drops
// in shared memory. In each round its threads take drops that wait for the same step of linear_kernel.hpp, the one that
// most of the pool wait for, so that they do the same work, and its warps share the instructions: the steps together
// exceed the instruction caches. A finished drop is replaced by the next one of a queue that all blocks share. A result
// depends on its point alone, so it has the same bits as on a CPU.
#include "linear_kernel.hpp"
#include "parameters.hpp"

namespace hardlimit::sweep {

// Written by cuda.py; every field takes eight bytes.
struct Task {
    u64 next;   // point of the queue
    u64 count;  // points in all
    // Value of parameter i at a point: values[i][(point / stride[i]) % size[i]].
    const double* values[parameter_count];
    u64 stride[parameter_count], size[parameter_count];
    // b = β/ω0 of floor and pair for each ε among their values; one list if these are the same.
    double* ratio[2];
    i64 adiabatic, density_1, density_2, restitution_at;
    // Results; null: not wanted, except the outcome.
    unsigned char *n_contacts, *outcome;
    double* quantity[quantity_count];
};

// Outcome of a point that is left to the scalar solver on the host.
inline constexpr unsigned char left_to_host = 255;
inline constexpr int largest_count = 255;  // of n_contacts in a byte

inline constexpr int warp = 32;
inline constexpr int block = 128;      // threads, as in cuda_device.py
inline constexpr int blocks = 4;       // of a multiprocessor, which limits the registers of a thread to 128
inline constexpr int pool_size = 240;  // drops of a block: as many as fit into 48 KiB
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
    Parameters p;
    double* const to = reinterpret_cast<double*>(&p);
    HL_ROLL
    for (int i = 0; i < parameter_count; ++i) to[i] = task.values[i][place(task, i, point)];
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
    for (int k = 0; k < quantity_count; ++k)
        if (task.quantity[k]) task.quantity[k][point] = r.of[k];
}

enum Step : unsigned char { flight, floor_step, pair_step, large_step, taylor_step, vacant, none };

// A drop in progress.
struct Drop {
    lanes::State<double> q;
    lanes::NextSteps<bool> next;
    column::Units units;
    unsigned point;

    // Starts at `point`; false if this kernel does not solve it.
    HL_FN bool take(const Task& task) {
        Parameters p = parameters_of(task, point);
        column::Start s;
        if (!enter(setting_of(task), p, ratio_of(task, 0, point), ratio_of(task, 1, point), s)) return false;
        units = s.units;
        const hardlimit_abi::Batch one = {
            1,
            {&s.groups.a1, &s.groups.a2, &s.groups.c1, &s.groups.c2, &s.groups.gravity, &s.first.u,
             &s.first.du, &s.first.w, &s.first.dw, &s.t},
            {},
            nullptr};
        lanes::load(q, 0, one, 0);
        lanes::start<double>(q, true);
        return true;
    }

    HL_FN void give(const Task& task) const {
        if (q.unsolved) {
            task.outcome[point] = left_to_host;
            return;
        }
        const Found found = {q.contacts, q.t_first, q.t_end, q.t_floor_end, q.relative, q.separation};
        const Parameters p = parameters_of(task, point);
        const PointResult r = leave(setting_of(task), p, units, found);
        const auto sure = column::DropBound::of(linear_bound(setting_of(task), p), p.gap, units.speed);
        if (sure.holds(0.0) && sure.holds(r.n_contacts, r.of[t_end_index]))
            put(task, point, r);
        else
            task.outcome[point] = left_to_host;
    }

    HL_FN Step next_step() const {
        if (next.flight) return flight;
        if (next.floor) return floor_step;
        if (next.pair) return pair_step;
        return next.large ? large_step : taylor_step;
    }

    // Takes the step it waits for unless it has just started; returns what it waits for then.
    HL_FN Step advance(const Task& task, bool started) {
        bool moved = started;
        if (!started) {
            lanes::Modes<double> k;  // recomputed each time: storing them would leave room for fewer drops
            if (next.floor) lanes::find_floor_mode<double>(q.s, k);
            if (next.pair || next.large) lanes::find_pair_modes<double>(q.s, k);
            moved = lanes::step<double>(q, k, next);
        }
        if (moved) lanes::sort<double>(q, next, true);
        if (q.active) return next_step();
        give(task);
        return vacant;
    }
};

// A drop in shared memory, with an odd number of words of eight bytes: the places of a half warp then begin in
// different pairs of banks. With the 24 words of a drop they would begin in two of the sixteen pairs.
struct Slot {
    Drop drop;
    u64 unused;
};
static_assert(sizeof(Slot) / 8 % 2 == 1);

// The drops of a block.
struct Pool {
    Slot slot[pool_size];
    Step waits_for[pool_size];
    unsigned char chosen[block];
    int waiting[none + 1], taken;
};
static_assert(sizeof(Pool) + 8 <= 48 * 1024);

// The step that most of the pool wait for; `none` when all is done.
__device__ inline Step most_wanted(Pool& pool) {
    if (threadIdx.x <= none) pool.waiting[threadIdx.x] = 0;
    if (threadIdx.x == 0) pool.taken = 0;
    __syncthreads();
    for (unsigned i = threadIdx.x; i < pool_size; i += block) atomicAdd(&pool.waiting[pool.waits_for[i]], 1);
    __syncthreads();
    Step wanted = none;
    int most = 0;
    for (int k = 0; k < none; ++k) {
        if (pool.waiting[k] <= most) continue;
        most = pool.waiting[k];
        wanted = static_cast<Step>(k);
    }
    return wanted;
}

// For each thread a drop that waits for this step; −1: none left.
__device__ inline int choose(Pool& pool, Step step) {
    for (unsigned i = threadIdx.x; i < pool_size; i += block) {
        if (pool.waits_for[i] != step) continue;
        const int at = atomicAdd(&pool.taken, 1);
        if (at < block) pool.chosen[at] = static_cast<unsigned char>(i);
    }
    __syncthreads();
    return static_cast<int>(threadIdx.x) < pool.taken ? pool.chosen[threadIdx.x] : -1;
}

// The next point of the queue for each thread that needs one.
__device__ inline u64 draw(Task& task, bool draws) {
    const unsigned lane = threadIdx.x % warp;
    const unsigned who = __ballot_sync(everyone, draws);
    u64 first = 0;
    if (lane == 0) first = atomicAdd(&task.next, static_cast<u64>(__popc(who)));
    return __shfl_sync(everyone, first, 0) + static_cast<u64>(__popc(who & ((1u << lane) - 1u)));
}

}  // namespace hardlimit::sweep

using hardlimit::sweep::Task;

extern "C" __global__ void __launch_bounds__(hardlimit::sweep::block, hardlimit::sweep::blocks)
    solve(Task* task) {
    using namespace hardlimit::sweep;
    __shared__ unsigned long long room[sizeof(Pool) / 8 + 1];  // without constructors
    Pool& pool = *reinterpret_cast<Pool*>(room);
    for (unsigned i = threadIdx.x; i < pool_size; i += block) pool.waits_for[i] = vacant;
    for (;;) {
        __syncthreads();
        const Step now = most_wanted(pool);
        if (now == none) break;
        const int mine = choose(pool, now);
        const hardlimit::u64 point = now == vacant ? draw(*task, mine >= 0) : 0;
        if (mine < 0) continue;
        // A vacant place holds no valid drop, and its flags must not be copied.
        Drop drop{};
        Step next = none;  // the queue is empty
        bool solves = now != vacant;
        if (solves) {
            drop = pool.slot[mine].drop;
        } else if (point < task->count) {
            drop.point = static_cast<unsigned>(point);
            solves = drop.take(*task);
            if (!solves) task->outcome[point] = left_to_host;
            next = vacant;
        }
        if (solves) next = drop.advance(*task, now == vacant);
        if (next < vacant) pool.slot[mine].drop = drop;
        pool.waits_for[mine] = next;
    }
}

// b of every ε among the values of floor and pair.
extern "C" __global__ void damping_ratios(Task* task) {
    using namespace hardlimit::sweep;
    const int sides = task->ratio[1] == task->ratio[0] ? 1 : 2;
    for (int side = 0; side < sides; ++side) {
        const int i =
            geometry_count + side * hardlimit::max_parameters + static_cast<int>(task->restitution_at);
        for (hardlimit::u64 k = threadIdx.x + blockIdx.x * blockDim.x; k < task->size[i];
             k += gridDim.x * blockDim.x)
            task->ratio[side][k] =
                hardlimit::contact::linear_damping_ratio<double>(-hardlimit::math::log(task->values[i][k]));
    }
}
