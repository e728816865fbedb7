// Axes of a map: the values of each parameter along the dimensions of the result. Threads take its points in batches.
#pragma once
#include <atomic>
#include <cstddef>
#include <vector>

#include "../base/stop.hpp"

namespace hardlimit::sweep {

// Values of one parameter along one dimension of the result: value index = (point / stride) mod size.
struct Axis {
    const double* values;
    u64 stride, size;
};

// Writes the parameter at `count` consecutive points, from `point` on.
inline void fill(double* to, const Axis& k, u64 point, int count) {
    u64 index = (point / k.stride) % k.size, left = k.stride - point % k.stride;
    for (int i = 0; i < count; ++i) {
        to[i] = k.values[index];
        if (--left > 0) continue;
        left = k.stride;
        if (++index == k.size) index = 0;
    }
}

// Iterates over the points of a map in order, without integer divisions.
class Cursor {
    struct Varying {
        std::size_t at;
        Axis axis;
        u64 index, run;
    };
    std::vector<Varying> varying_;
    std::vector<double> value_;

public:
    Cursor(const std::vector<Axis>& axes, u64 point) {
        for (const Axis& k : axes) {
            const u64 index = (point / k.stride) % k.size;
            if (k.size > 1) varying_.push_back({value_.size(), k, index, point % k.stride});
            value_.push_back(k.values[index]);
        }
    }
    // Parameters of the current point.
    const double* values() const { return value_.data(); }
    void next() {
        for (Varying& v : varying_) {
            if (++v.run < v.axis.stride) continue;
            v.run = 0;
            if (++v.index == v.axis.size) v.index = 0;
            value_[v.at] = v.axis.values[v.index];
        }
    }
};

// A map or a part of it, shared by the threads that solve it. Results do not depend on the number of threads or the
// order of the points.
struct PointQueue {
    std::vector<Axis> axes;  // one for each parameter of a point
    u64 first, count;
    std::atomic<u64> next{0}, done{0};

    // Calls solve(begin, end) for batches of `size` points until none is left.
    template <class Solve>
    void for_each_batch(u64 size, Stop& stop, const Solve& solve) {
        for (;;) {
            const u64 begin = next.fetch_add(size);
            if (begin >= count || stop.now()) return;
            const u64 end = begin + size < count ? begin + size : count;
            solve(begin, end);
            done += end - begin;
        }
    }
    // Calls put(i, solve(parameters)) for each point; the result of a stopped solver is not used.
    template <class Solve, class Put>
    void for_each_point(u64 size, Stop& stop, const Solve& solve, const Put& put) {
        for_each_batch(size, stop, [&](u64 begin, u64 end) {
            Cursor at(axes, first + begin);
            for (u64 i = begin; i < end; ++i, at.next()) {
                const auto result = solve(at.values());
                if (stop.stopped()) return;
                put(i, result);
            }
        });
    }
};

}  // namespace hardlimit::sweep
