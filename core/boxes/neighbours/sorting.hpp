// Bodies brought into the order of the cells.
#pragma once
#include <cstdint>
#include <utility>
#include <vector>

#include "neighbour_list.hpp"

namespace hardlimit::boxes::steps {

class Sorting {
public:
    explicit Sorting(std::size_t bodies = 0)
        : cell_(bodies), where_(bodies), place_(bodies), motion_(bodies), label_(bodies) {}

    // Folds the bodies first … last − 1 back into the box and finds their cells.
    void find_cells(const Box& box, const Grid& grid, Bodies& bodies, std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) {
            for (int axis = 0; axis < box.dimension; ++axis)
                if (box.wraps(axis)) fold(bodies.place[i], bodies.label[i], axis, box.edge[axis]);
            cell_[i] = grid.cell_of(bodies.place[i]);
        }
    }
    // Where each body goes: by cell, and in a cell as before. Sets start [cells + 1], the first body of each.
    void order(std::uint32_t cells, std::vector<std::uint32_t>& start) {
        start.assign(cells + 2, 0);
        for (const std::uint32_t c : cell_) ++start[c + 2];
        for (std::size_t c = 2; c < start.size(); ++c) start[c] += start[c - 1];
        for (std::size_t i = 0; i < cell_.size(); ++i) where_[i] = start[cell_[i] + 1]++;
        start.pop_back();
    }
    void move(const Bodies& bodies, std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) {
            const std::uint32_t to = where_[i];
            place_[to] = bodies.place[i];
            motion_[to] = bodies.motion[i];
            label_[to] = bodies.label[i];
        }
    }
    void swap(Bodies& bodies) {
        bodies.place.swap(place_);
        bodies.motion.swap(motion_);
        bodies.label.swap(label_);
    }
    std::uint32_t where(std::uint32_t body) const { return where_[body]; }

    // Once the bodies have moved: the index of the body with this number.
    void number(const Bodies& bodies, std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i)
            where_[bodies.label[i].number] = static_cast<std::uint32_t>(i);
    }
    // The places at which the list was made share their memory with that of the bodies' next order.
    Records<Four>& reference() { return place_; }

private:
    std::vector<std::uint32_t> cell_, where_;  // [N]
    Records<Four> place_, motion_;
    Records<Label> label_;

    static void fold(Four& place, Label& label, int axis, double edge) {
        if (place[axis] < 0.0) place[axis] += edge, --label.turns[axis];
        if (place[axis] >= edge) place[axis] -= edge, ++label.turns[axis];
    }
};

}  // namespace hardlimit::boxes::steps
