// Counting sort of the bodies by cell.
#pragma once
#include <cstdint>
#include <utility>
#include <vector>

#include "neighbour_list.hpp"

namespace hardlimit::boxes {

class CellSort {
public:
    explicit CellSort(std::size_t bodies = 0)
        : cell_(bodies), where_(bodies), position_(bodies), velocity_(bodies), tag_(bodies) {}

    // Wraps the bodies first … last − 1 into the box and finds their cells.
    void find_cells(const Box& box, const CellLayers& grid, Bodies& bodies, std::size_t first,
                    std::size_t last, double time) {
        for (std::size_t i = first; i < last; ++i) {
            for (int axis = 0; axis < box.dimension; ++axis)
                if (box.is_periodic(axis)) wrap(box, bodies, i, axis, time);
            cell_[i] = grid.cell_of(bodies.position[i]);
        }
    }
    // Computes the new index of each body; the sort is stable. Sets start [cells + 1], the first body of each cell.
    void order(const Bodies& bodies, std::uint32_t cells, std::vector<std::uint32_t>& start) {
        spin_.resize(bodies.spin.size());
        start.assign(cells + 2, 0);
        for (const std::uint32_t c : cell_) ++start[c + 2];
        for (std::size_t c = 2; c < start.size(); ++c) start[c] += start[c - 1];
        for (std::size_t i = 0; i < cell_.size(); ++i) where_[i] = start[cell_[i] + 1]++;
        start.pop_back();
    }
    void move(const Bodies& bodies, std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) {
            const std::uint32_t to = where_[i];
            position_[to] = bodies.position[i];
            velocity_[to] = bodies.velocity[i];
            tag_[to] = bodies.tag[i];
            if (!spin_.empty()) spin_[to] = bodies.spin[i];
        }
    }
    void swap(Bodies& bodies) {
        bodies.position.swap(position_);
        bodies.velocity.swap(velocity_);
        bodies.tag.swap(tag_);
        bodies.spin.swap(spin_);
    }
    std::uint32_t where(std::uint32_t body) const { return where_[body]; }

    // After the sort: makes where(k) the index of the body with original index k.
    void index_by_original(const Bodies& bodies, std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i)
            where_[bodies.tag[i].original_index] = static_cast<std::uint32_t>(i);
    }
    // Positions at the last list build, kept in the buffer that the next sort overwrites.
    Records<Double4>& reference() { return position_; }

private:
    std::vector<std::uint32_t> cell_, where_;  // [N]
    Records<Double4> position_, velocity_;
    Records<BodyTag> tag_;
    Records<Double4> spin_;  // as long as Bodies::spin

    static void wrap(const Box& box, Bodies& bodies, std::size_t i, int axis, double time) {
        Double4 &x = bodies.position[i], &v = bodies.velocity[i];
        auto& flags = bodies.tag[i].image_flags;
        if (x[axis] < 0.0) box.wrap(x, v, flags, axis, -1, time);
        if (x[axis] >= box.edge[axis]) box.wrap(x, v, flags, axis, 1, time);
    }
};

}  // namespace hardlimit::boxes
