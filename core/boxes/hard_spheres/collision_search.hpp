// Search for the next collision of a particle among its neighbours.
#pragma once
#include <vector>

#include "../kernels/interface.hpp"
#include "cell_assignment.hpp"

namespace hardlimit::boxes::spheres {

// The earliest collision found so far.
struct NextCollision {
    u32 id;
    u32 except = no_particle;    // the partner of its last collision, ignored while they touch
    double in = math::infinity;  // [s] from now
    u32 partner = no_particle;
};

template <int d, bool mixed>
class CollisionSearch {
public:
    CollisionSearch(const Particles<d, mixed>& particles, const CellAssignment<d, mixed>& assignment,
                    const hardlimit_abi::TouchKernels& kernels)
        : particles_(particles),
          assignment_(assignment),
          touch_(kernels.of[d - 2][static_cast<int>(particles.setting.motion)]) {
        query_.radius = mixed ? 0.0 : 2.0 * particles.setting.largest_radius;
        query_.others = mixed ? 1.0 : 0.0;
        query_.radius_factor = 1.0;
        query_.growth_rate = particles.setting.growth.rate;
        for (int k = 0; k < d; ++k) {
            query_.edge[k] = box_.edge[k];
            query_.per_edge[k] = box_.is_periodic(k) ? 1.0 / box_.edge[k] : 0.0;
            query_.half_gravity[k] = 0.5 * box_.gravity[k];
            query_.gravity[k] = box_.gravity[k];
        }
    }

    // Begins the search for a particle, with its present state.
    NextCollision begin(u32 i, u32 except) {
        const Setting& setting = particles_.setting;
        query_.now = particles_.now;
        if constexpr (mixed) query_.radius = particles_.radius(i);
        if (setting.grows()) query_.radius_factor = setting.growth.at(particles_.now);
        for (int k = 0; k < d; ++k) {
            query_.position[k] = particles_.position(i, k);
            query_.velocity[k] = particles_.velocity(i, k);
        }
        return NextCollision{i, except};
    }
    // Searches all cells around the cell `at`, in its own grid and in coarser ones.
    void search_around(NextCollision& next, int level, const Place<d>& at) {
        cells_.for_stencils(level, at, [&](int q, const Place<d>& from, const Place<d>& to) {
            if (assignment_.holds_any(q)) search(next, q, from, to);
        });
    }
    // Searches the cells that have become neighbours of a particle that has entered the cell `at`: in its own grid, and
    // in coarser ones in which it has changed its cell as well.
    void search_beyond(NextCollision& next, int level, Place<d> at, int axis, int step) {
        for (int q = level;; ++q) {
            Place<d> from, to;
            for (int k = 0; k < d; ++k) from[k] = at[k] - 1, to[k] = at[k] + 1;
            from[axis] = to[axis] = at[axis] + step;
            if (assignment_.holds_any(q)) search(next, q, from, to);
            // The face just crossed is a face of the next coarser grid if an even number of cells lies below it.
            const int border = step > 0 ? at[axis] : at[axis] + 1;
            if (q + 1 == cells_.levels() || border % 2 != 0) break;
            for (int k = 0; k < d; ++k) at[k] >>= 1;
        }
    }
    // Searches finer grids, whose particles may be many: only for those that can arrive before the next such search.
    // Returns the time of that search [s].
    double search_finer(NextCollision& next, int level) {
        double horizon = math::infinity;
        const double speed = particles_.frame_speed(query_.velocity) + particles_.speed_bound() +
                             math::abs(box_.image_velocity());
        for (int q = 0; q < level; ++q) {
            const double widest = cells_.grids()[static_cast<std::size_t>(q)].widest;
            if (widest == 0.0) continue;
            const double margin = 2.0 * widest;
            horizon = math::min(horizon, 0.99 * margin / speed);
            search_within(next, q, query_.radius + 0.5 * widest + margin);
        }
        return particles_.now + horizon;
    }
    std::size_t bytes() const { return candidates_.capacity() * sizeof(u32); }

private:
    const Particles<d, mixed>& particles_;
    const CellAssignment<d, mixed>& assignment_;
    const Box& box_ = particles_.box;
    const Cells<d>& cells_ = assignment_.cells();
    hardlimit_abi::TouchKernels::Of touch_;
    hardlimit_abi::ContactQuery query_{};
    Scratch<u32> candidates_;
    Scratch<double> times_;  // until contact with each candidate [s]
    std::vector<u32> rows_;  // of cells

    // A block of cells that may reach beyond the sides of the box.
    void search(NextCollision& next, int level, const Place<d>& from, const Place<d>& to) {
        search_block(next, level, from, to);
        if (!box_.is_sheared()) return;
        for_images_beyond(level, from, to, [&](const Place<d>& low, const Place<d>& high) {
            search_block(next, level, low, high);
        });
    }
    // Calls f(from, to) for the parts of a block beyond the sides of a sheared box. Meanwhile, the particle of the
    // query is in the frame of the images there: the relative motion is the same, and the neighbours stay as they are.
    template <class F>
    void for_images_beyond(int level, const Place<d>& from, const Place<d>& to, const F& f) {
        cells_.for_sheared_parts(box_, level, from, to, particles_.now,
                                 [&](const Place<d>& low, const Place<d>& high, const ImageMotion& image) {
                                     const auto query = query_;
                                     for (int k = 0; k < d; ++k) {
                                         query_.position[k] -= image.shift[k];
                                         query_.velocity[k] -= image.velocity[k];
                                     }
                                     f(low, high);
                                     query_ = query;
                                 });
    }
    void search_block(NextCollision& next, int level, const Place<d>& from, const Place<d>& to) {
        if (cells_.grids()[static_cast<std::size_t>(level)].few) return search_images(next, level, from, to);
        make_room(cells_.room());
        hardlimit_abi::CellBlock block;
        const bool across = cells_.lay_block(block, box_, level, from, to);
        run(across ? touch_.across : touch_.near, next, block, across);
    }
    // A block that may hold several images of a particle, because the box is small.
    void search_images(NextCollision& next, int level, const Place<d>& from, const Place<d>& to) {
        make_room(cells_.room());
        cells_.for_block(box_, level, from, to, [&](u32 cell, const double (&shift)[d]) {
            for (int k = 0; k < d; ++k) query_.shift[k] = shift[k];
            run(touch_.listed, next, cells_.collect(cell, candidates_, 0), false);
        });
        for (double& shift : query_.shift) shift = 0.0;
    }
    // The cells within reach of the particle [m].
    void search_within(NextCollision& next, int level, double reach) {
        const Grid<d>& g = cells_.grids()[static_cast<std::size_t>(level)];
        Place<d> from, to;
        bool narrow = false;  // so that two images of a particle may be within reach
        for (int k = 0; k < d; ++k) {
            const double x = k == 0 ? cells_.along(query_.position, particles_.now) : query_.position[k];
            const double far = k == 0 ? cells_.extent_along(reach, particles_.now) : reach;
            narrow = narrow || (box_.is_periodic(k) && box_.edge[k] < 2.001 * far);
            from[k] = floor_to_int((x - far) / g.edge[k]);
            to[k] = floor_to_int((x + far) / g.edge[k]);
        }
        const auto examine = [&](const hardlimit_abi::CellBlock& block, std::size_t room) {
            make_room(room);
            run(touch_.across, next, block, true);
        };
        const auto search_part = [&](const Place<d>& low, const Place<d>& high) {
            if (narrow) return search_images(next, level, low, high);
            cells_.for_blocks_within(box_, level, query_.position, reach, low, high, rows_, examine);
        };
        search_part(from, to);
        if (box_.is_sheared()) for_images_beyond(level, from, to, search_part);
    }

    void make_room(std::size_t room) {
        if (times_.size() >= room) return;
        times_.resize(room);
        candidates_.resize(room);
    }
    // cells: a block, or the number of candidates that are listed already.
    template <class Kernel, class CellsToSearch>
    void run(Kernel kernel, NextCollision& next, const CellsToSearch& cells, bool nearest) {
        keep_earliest(
            next, kernel(query_, particles_.paths.data(), next.id, candidates_.data(), times_.data(), cells),
            nearest);
    }
    // Keeps the earliest collision that a kernel has found among the candidates; among simultaneous ones, that with the
    // lowest original index. `nearest`: the candidates' nearest images are meant.
    void keep_earliest(NextCollision& next, const hardlimit_abi::EarliestContact& touched, bool nearest) {
        if (!(touched.time <= next.in) || touched.time == math::infinity) return;
        if (touched.time < next.in && !touched.several && touched.id != next.except) {
            next.in = touched.time;
            next.partner = touched.id;
            return;
        }
        for (std::size_t k = 0; k < touched.n; ++k) {
            if (times_[k] > next.in || times_[k] == math::infinity) continue;
            const u32 id = candidates_[k];
            if (id == next.except && touches(id, nearest)) continue;
            if (times_[k] < next.in ||
                particles_.original_index[id] < particles_.original_index[next.partner]) {
                next.in = times_[k];
                next.partner = id;
            }
        }
    }
    // Whether the image of a particle that was just examined touches or overlaps the particle of the query.
    bool touches(u32 id, bool nearest) const {
        double square = 0.0;
        for (int k = 0; k < d; ++k) {
            double r = particles_.position(id, k) + query_.shift[k] - query_.position[k];
            if (nearest) r -= query_.edge[k] * math::round_small(r * query_.per_edge[k]);
            square += r * r;
        }
        const double touch = (query_.radius + query_.others * particles_.radius(id)) * query_.radius_factor;
        return square <= touch * touch * (1.0 + 1e-9);
    }
};

}  // namespace hardlimit::boxes::spheres
