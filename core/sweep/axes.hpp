// Axes of a map: the values of each parameter along the dimensions of the result.
#pragma once
#include <cstddef>
#include <vector>

#include "../base/portable.hpp"

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

}  // namespace hardlimit::sweep
