// The next event of a particle by itself: it leaves its cell, or meets a wall.
#pragma once
#include "../neighbours/cells.hpp"
#include "prediction.hpp"

namespace hardlimit::boxes {

// State of a particle along an axis, a time after its path began.
struct AxisState {
    double since;  // [s]
    double x, v;   // [m], [m/s]
};

// The earliest of the events considered. Times count from the begin of the path [s].
struct NextSelfEvent {
    double in = math::infinity;
    SelfEvent which = SelfEvent::low_x;

    void consider(double time, int axis, bool high, bool wall) {
        // A mask, since gcc would turn ?: into a branch, and no processor can predict which face comes first.
        const auto sooner = 0u - static_cast<u32>(time < in);
        which = static_cast<SelfEvent>((static_cast<u32>(self_event(axis, high, wall)) & sooner) |
                                       (static_cast<u32>(which) & ~sooner));
        in = math::min(in, time);
    }
};

// A moving wall may be in any cell. By value: a flight that is referred to could not stay in registers.
template <class Flight>
NextSelfEvent with_moving_walls(NextSelfEvent next, const Box& box, Flight flight) {
    for (int k = 0; k < flight.axes; ++k)
        for (const bool high : {false, true})
            if (box.has_walls(k) && flight.walls_move(k))
                next.consider(flight.until_wall(box.wall(k, high), next.in), k, high, true);
    return next;
}

// The faces of a column of cells in a sheared box, between two values of Cells::along().
template <int d, class Flight>
HL_FN_INLINE void consider_column(NextSelfEvent& next, const Box& box, const Cells<d>& cells, double low,
                                  double high, double now, const Flight& flight) {
    const AxisState x = flight.at_present(0), y = flight.at_present(box.gradient);
    const auto u = cells.along(x.x, y.x, x.v, y.v, now);
    const Exit leaves = exit_of(u.at, u.rate, u.acceleration, low, high, 4.0 * math::epsilon * now);
    next.consider(x.since + leaves.time, 0, leaves.high, false);
}

// Predicts the next event of a particle in the cell `at`. A wall at rest is the face of the outermost cells. Flight
// describes the path:
//   axes, radius            number of axes; [m]
//   meets_walls()           whether it meets walls itself; otherwise it only leaves its cell
//   falls(axis)             whether its path may be curved along the axis
//   walls_move(axis)        whether walls along the axis move, as seen from its surface
//   from(axis, high, wall)  AxisState from which the time to that face of the cell, or wall at rest, is found
//   at_present(axis)        AxisState now
//   until_wall(wall, end)   time until it meets a moving wall, from the begin of the path; any later one if after `end`
template <int d, class Flight>
HL_FN_INLINE NextSelfEvent next_self_event(const Box& box, const Cells<d>& cells, int level,
                                           const Place<d>& at, double now, const Flight& flight) {
    const Grid<d>& g = cells.grids()[static_cast<std::size_t>(level)];
    NextSelfEvent next;
    bool walls_move = false;
    HL_UNROLL
    for (int k = 0; k < d; ++k) {
        if (k == flight.axes) break;
        if (k == 0 && box.is_sheared()) continue;
        double face[2] = {at[k] * g.edge[k], (at[k] + 1) * g.edge[k]};
        bool wall[2] = {};
        if (box.has_walls(k)) {
            wall[0] = at[k] == 0, wall[1] = at[k] == g.cells[k] - 1;
            const bool moving = flight.walls_move(k), resting = flight.meets_walls() && !moving;
            if (wall[0])
                face[0] = resting ? box.wall(k, false).position(now) + flight.radius : -math::infinity;
            if (wall[1]) face[1] = resting ? box.wall(k, true).position(now) - flight.radius : math::infinity;
            walls_move = walls_move || (moving && flight.meets_walls());
        }
        if (!flight.falls(k)) {
            const bool up = flight.from(k, false, false).v > 0.0;
            const AxisState s = flight.from(k, up, wall[up]);
            next.consider(s.since + time_to(face[up] - s.x, s.v), k, up, wall[up]);
        } else {
            const double pull = box.gravity[k];
            const AxisState high = flight.from(k, true, wall[1]), low = flight.from(k, false, wall[0]);
            next.consider(high.since + time_below(high.x, high.v, pull, face[1]), k, true, wall[1]);
            next.consider(low.since + time_below(-low.x, -low.v, -pull, -face[0]), k, false, wall[0]);
        }
    }
    if (walls_move) [[unlikely]]
        next = with_moving_walls(next, box, flight);
    if (box.is_sheared())
        consider_column(next, box, cells, at[0] * g.edge[0], (at[0] + 1) * g.edge[0], now, flight);
    return next;
}

}  // namespace hardlimit::boxes
