// What the stepping engine keeps of every body, in the order of the cells.
#pragma once
#include <cstdint>
#include <vector>

#include "../../base/math.hpp"
#include "box.hpp"
#include "storage.hpp"

namespace hardlimit::boxes::steps {

using Four = Vector<4>::Real;

inline constexpr Four four(double x, double y, double z, double w) { return Four{x, y, z, w}; }
// Of the first three.
inline double dot(Four a, Four b) { return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]; }

// The same as plain numbers, four for each.
inline double* numbers(Records<Four>& of) { return reinterpret_cast<double*>(of.data()); }
inline const double* numbers(const Records<Four>& of) { return reinterpret_cast<const double*>(of.data()); }

inline Four pull(const Box& box) { return four(box.gravity[0], box.gravity[1], box.gravity[2], 0.0); }

// Acceleration by contacts. Few bodies are in contact at a time, so nothing is cleared: an entry counts only at the
// step it was written and, as the one before, at the next.
struct Push {
    double now[3] = {};  // [m/s²] at step `stamp`
    std::uint64_t stamp = 0;
    double before[3] = {};  // at step stamp − 1
    std::uint64_t unused = 0;

    Four at(std::uint64_t step) const { return stamp == step ? four(now[0], now[1], now[2], 0.0) : Four{}; }
    // At the step before `step`, whether or not this one has been written already.
    Four preceding(std::uint64_t step) const {
        if (stamp == step) return four(before[0], before[1], before[2], 0.0);
        return at(step - 1);
    }
    // Whether it is the first at this step.
    bool add(std::uint64_t step, Four acceleration) {
        const bool first = stamp != step;
        if (first) {
            const Four last = at(step - 1);
            for (int axis = 0; axis < 3; ++axis) before[axis] = last[axis], now[axis] = 0.0;
            stamp = step;
        }
        for (int axis = 0; axis < 3; ++axis) now[axis] += acceleration[axis];
        return first;
    }
};

// Which body it is, and how many times its path has left the box through each periodic side.
struct Label {
    std::uint32_t number;
    std::int32_t turns[3];
};

struct Bodies {
    Records<Four> place;   // [N] x, y, z [m] in the box, radius [m]
    Records<Four> motion;  // [N] velocity [m/s], 1/mass [1/kg]
    Records<Label> label;  // [N]
    Records<Push> push;    // [N]

    std::size_t count() const { return place.size(); }
};

}  // namespace hardlimit::boxes::steps
