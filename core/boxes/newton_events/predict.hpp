// Prediction of the next events of a body.
#pragma once
#include <algorithm>
#include <utility>
#include <vector>

#include "../queue/self_event.hpp"
#include "body_cells.hpp"
#include "busy_bodies.hpp"

namespace hardlimit::boxes::events {

// The path of a body from now on, for next_self_event().
struct BodyFlight {
    const Box& box;
    const hardlimit_abi::ContactQuery& body;
    bool free;
    int axes = box.dimension;
    double radius = body.radius;

    bool meets_walls() const { return free; }
    bool falls(int axis) const { return box.gravity[axis] != 0.0; }
    bool walls_move(int axis) const { return box.has_moving_walls(axis); }
    AxisState at_present(int axis) const { return {0.0, body.position[axis], body.velocity[axis]}; }
    AxisState from(int axis, bool, bool) const { return at_present(axis); }
    double until_wall(const Wall& wall, double end) const {
        const int axis = wall.id.axis();
        return wall_contact_time(wall, body.now, body.position[axis], body.velocity[axis], box.gravity[axis],
                                 radius, end);
    }
};

// When a body in the cell `at` leaves it or, if it is free, meets a wall.
inline void predict_self_event(PendingEvents& e, const Box& box, const Cells<3>& cells, int level,
                               const Place<3>& at, const hardlimit_abi::ContactQuery& body, bool free) {
    const NextSelfEvent next = next_self_event(box, cells, level, at, body.now, BodyFlight{box, body, free});
    e.own_time = body.now + next.in;
    e.own = static_cast<u32>(next.which) & 15u;
}

// Predicts the next collision of a body and its next event by itself. The kernels examine its neighbours.
template <class Law>
class Predictor {
public:
    Predictor(Paths<Law>& paths, const BodyCells<Law>& cells, const BusyBodies<Law>& busy,
              const hardlimit_abi::TouchKernels& kernels)
        : paths_(paths), cells_(cells), busy_(busy), touch_(kernels.enlarged[paths.box.falls() ? 1 : 0]) {
        query_.others = 1.0;
        for (int a = 0; a < 3; ++a) {
            query_.edge[a] = box_.edge[a];
            query_.per_edge[a] = box_.is_periodic(a) ? 1.0 / box_.edge[a] : 0.0;
            query_.gravity[a] = box_.gravity[a];
            query_.half_gravity[a] = 0.5 * box_.gravity[a];
        }
    }

    // Predicts all events of body i.
    void predict(int i) {
        set_query(i);
        predict_with_query(i);
    }
    // The same except collisions with body `other`: the kernel finds no contact with a body whose time is NaN.
    void predict_without(int i, int other) {
        if (i == other) return predict(i);
        const double time = std::exchange(paths_.particles[other].time, math::nan);
        predict(i);
        paths_.particles[other].time = time;
    }
    // Predicts the events of all bodies at the start. Returns the bodies that may overlap with another, in ascending
    // order: those that the kernel reports with a slightly larger radius. Their events must be predicted again.
    std::vector<int> predict_first(double largest_radius) {
        constexpr double wider =
            1e-8;  // of the largest radius: more than the rounding that the kernel allows
        static_assert(wider > rounding_of_touch);
        std::vector<int> touching;
        for (int i = 0; i < paths_.size(); ++i) {
            set_query(i);
            query_.enlarged_radius += wider * largest_radius;
            predict_with_query(i);
            if (paths_.pending[i].pair_time <= paths_.now) touching.push_back(i);
        }
        return touching;
    }
    // After a cell crossing: predicts collisions in the cells that become neighbours.
    void predict_crossed(int i, const typename BodyCells<Law>::Crossing& crossing) {
        set_query(i);
        predict_collisions(i, crossing.beyond);
        predict_own(i, crossing.to);
    }
    // Predicts only when body i leaves its cell or meets a wall.
    void predict_own(int i) {
        set_query(i);
        predict_own(i, cells_.place(i));
    }

    std::size_t bytes() const {
        return candidates_.capacity() * sizeof(u32) + times_.capacity() * sizeof(double);
    }

private:
    Paths<Law>& paths_;
    const Box& box_ = paths_.box;
    const BodyCells<Law>& cells_;
    const BusyBodies<Law>& busy_;
    const hardlimit_abi::TouchKernels::Of touch_;
    alignas(64) hardlimit_abi::ContactQuery query_{};  // constant parts are set once; aligned for wide loads
    double kernel_exact_after_ = 0.0;  // from then on the kernel's times for free bodies are exact [s]
    Scratch<u32> candidates_;
    Scratch<double> times_;  // until touch [s]

    // Sets the kernel's query to body i. After an isolated contact a body has its own radius again.
    void set_query(int i) {
        const Particle<3>& p = paths_.particles[i];
        const BodyEvents& e = paths_.pending[i];
        const double now = paths_.now, s = now - p.time;
        const bool shrinks = e.group >= 0 && !e.clustered;
        query_.now = now;
        query_.radius = shrinks ? paths_.radius(i) : p.radius;
        query_.enlarged_radius = p.radius;
        query_.enlarged_span = shrinks ? e.end - now : 0.0;
        kernel_exact_after_ =
            shrinks ? now + query_.enlarged_span : (e.clustered ? math::infinity : -math::infinity);
        for (int a = 0; a < 3; ++a) {
            query_.position[a] = position_after(p, a, s, box_);
            query_.velocity[a] = velocity_after(p, a, s, box_);
        }
    }
    void predict_with_query(int i) {
        PendingEvents& e = paths_.pending[i];
        e.pair_time = math::infinity;
        e.partner = no_particle;
        const Place<3> at = cells_.place(i);
        predict_collisions(i, cells_.around(at));
        predict_own(i, at);
    }
    // The end of a cluster is a self event of its first member.
    void predict_own(int i, const Place<3>& at) {
        BodyEvents& e = paths_.pending[i];
        predict_self_event(e, box_, cells_.cells(), cells_.level(), at, query_, paths_.free(i));
        if (!e.first || !e.clustered || e.end > e.own_time) return;
        e.own_time = e.end;
        e.own = static_cast<u32>(SelfEvent::ends) & 15u;
    }
    void predict_collisions(int i, const Block& in) {
        if (!box_.is_sheared()) return predict_part(i, in);
        cells_.for_sides(in, [&](const Block& part, const ImageMotion& image) {
            const hardlimit_abi::ContactQuery own = query_;
            for (int a = 0; a < 3; ++a)
                query_.position[a] -= image.shift[a], query_.velocity[a] -= image.velocity[a];
            predict_part(i, part);
            for (int a = 0; a < 3; ++a)
                query_.position[a] = own.position[a], query_.velocity[a] = own.velocity[a];
        });
    }
    // Predicts collisions with the bodies in a block of cells, in whose frame the query is.
    void predict_part(int i, const Block& in) {
        const Cells<3>& cells = cells_.cells();
        if (times_.size() < cells.room()) times_.resize(cells.room()), candidates_.resize(cells.room());
        const auto self = static_cast<unsigned>(i);
        const Particle<3>* const particles = paths_.particles.data();
        if (cells_.several_images()) {
            const auto in_cell = [&](u32 cell, const double (&shift)[3]) {
                std::copy_n(shift, 3, query_.shift);
                const std::size_t n = cells.collect(cell, candidates_, 0);
                take_candidates(i,
                                touch_.listed(query_, particles, self, candidates_.data(), times_.data(), n));
            };
            return cells.for_block(cells_.box(), cells_.level(), in.from, in.to, in_cell);
        }
        hardlimit_abi::CellBlock block;
        const bool outside = cells.lay_block(block, cells_.box(), cells_.level(), in.from, in.to);
        const auto touch = outside ? touch_.across : touch_.near;
        take_candidates(i, touch(query_, particles, self, candidates_.data(), times_.data(), block));
    }
    // Takes the earliest collision among the candidates. The kernel's times are lower bounds if a body is busy.
    // Simultaneous collisions are ordered by original index.
    void take_candidates(int i, const hardlimit_abi::EarliestContact& touched) {
        const PendingEvents& e = paths_.pending[i];
        const double now = paths_.now;
        if (now + touched.time > e.pair_time || touched.time == math::infinity) return;
        take_candidate(i, touched.id, now + touched.time);
        if (!touched.several && (now + touched.next > e.pair_time || touched.next == math::infinity)) return;
        double last = e.pair_time;
        for (std::size_t k = 0; k < touched.n; ++k) {
            if (now + times_[k] > last || times_[k] == math::infinity || candidates_[k] == touched.id)
                continue;
            take_candidate(i, candidates_[k], now + times_[k]);
            last = e.pair_time;
        }
    }
    // Makes body `id` the next partner of body i if they collide earlier. `enlarged_time`: see BusyBodies.
    void take_candidate(int i, u32 id, double enlarged_time) {
        const auto& pending = paths_.pending;
        PendingEvents& e = paths_.pending[i];
        const bool exact = pending[id].group < 0 && enlarged_time > kernel_exact_after_;
        const double time =
            exact ? enlarged_time : busy_.collision_time(query_, i, static_cast<int>(id), enlarged_time);
        if (time > e.pair_time || time == math::infinity) return;
        if (time == e.pair_time && e.partner != no_particle &&
            pending[e.partner].original_index < pending[id].original_index)
            return;
        e.pair_time = time;
        e.partner = id;
        e.partner_count = pending[id].count;
    }
};

}  // namespace hardlimit::boxes::events
