// Collisions with busy bodies, and the regions that these do not leave.
#pragma once
#include "../common/triangle.hpp"
#include "../kernels/interface.hpp"
#include "groups.hpp"
#include "paths.hpp"

namespace hardlimit::boxes::events {

struct RelativeMotion {
    Vector3 position, velocity;
};

template <class Law>
struct BusyBodies {
    using Query = hardlimit_abi::ContactQuery;

    const Paths<Law>& paths;
    const Groups<Law>& groups;
    bool several_images;  // whether several images of a body may be near

    // Time at which body i of the query and body j collide if at least one of them is busy. `enlarged_time`: time at
    // which they would collide if both kept their safety radius. The path of a cluster's member is unknown beyond the
    // end of the cluster: its later collisions are predicted then. Members of one group do not collide here.
    double collision_time(const Query& query, int i, int j, double enlarged_time) const {
        const auto& pending = paths.pending;
        if (pending[i].group == pending[j].group) return math::infinity;
        const bool i_first = paths.free(j) || (!paths.free(i) && pending[i].end < pending[j].end);
        const int first = i_first ? i : j, last = i_first ? j : i;
        if (enlarged_time < pending[first].end) {
            const RelativeMotion r = relative_motion(query, j);
            const bool apart = stays_clear(r, i, first, paths.now, enlarged_radius(last)) ||
                               stays_clear(r, i, last, paths.now, enlarged_radius(first));
            if (!apart) return enlarged_time;
        }
        if (paths.clustered(first)) return math::infinity;
        if (!paths.free(last)) {
            const double time = time_at_distance(query, j, paths.radius(first) + enlarged_radius(last));
            if (time < pending[last].end &&
                !stays_clear(relative_motion(query, j), i, last, pending[first].end, paths.radius(first)))
                return math::max(time, pending[first].end);
            if (paths.clustered(last)) return math::infinity;
        }
        return time_at_distance(query, j, paths.radius(i) + paths.radius(j));
    }

    // Whether `member`, body i or j in an isolated contact, stays out of reach of the other body from the time `from`
    // until its group ends. The distance of its true path from its outgoing path is at most b(s) = ∫_s^∞ (t − s) |a|
    // dt, which is convex in s and zero at the end, so that b ≤ b(touch) (T − s)/T. The true path deviates away from
    // the partner, within the angle by which the line of centres rotates. Seen from the other body, the true positions
    // therefore lie in a triangle: its corners are both ends of the outgoing path and the true position at `from`.
    bool stays_clear(const RelativeMotion& between, int i, int member, double from,
                     double other_radius) const {
        if (paths.free(member) || paths.clustered(member)) return false;
        const BodyEvents& e = paths.pending[member];
        const IsolatedContact<Law>& l = groups[e.group].isolated_contact;
        const std::size_t m = e.first ? 0 : 1;
        const double share = l.share[m], left = e.end - from, sign = member == i ? 1.0 : -1.0;
        const double off = (m == 0 ? -share : share) * math::clamp(left / l.span, 0.0, 1.0);
        Vector3 begin, away, along;
        for (std::size_t k = 0; k < 3; ++k) {
            begin[k] = sign * (between.position[k] + (from - paths.now) * between.velocity[k]);
            along[k] = sign * left * between.velocity[k];
            away[k] = -off * l.initial_offset[k];
        }
        const double reach = paths.radius(member) + other_radius + l.safety_radius[m];
        return square_to_triangle(begin, away, along) > reach * reach * (1.0 + rounding_of_touch);
    }

private:
    double enlarged_radius(int i) const { return paths.particles[i].radius; }
    // Position and velocity of body j relative to body i of the query, at the current time.
    RelativeMotion relative_motion(const Query& query, int j) const {
        const Vector3 x = paths.position(j, paths.now), v = paths.velocity(j, paths.now);
        RelativeMotion between;
        for (std::size_t k = 0; k < 3; ++k) {
            const double r = x[k] - query.position[k];
            between.position[k] =
                r +
                (several_images ? query.shift[k] : -query.edge[k] * math::round_small(r * query.per_edge[k]));
            between.velocity[k] = v[k] - query.velocity[k];
        }
        return between;
    }
    // Time at which the paths of body i of the query and of body j come within this distance.
    double time_at_distance(const Query& query, int j, double distance) const {
        const RelativeMotion between = relative_motion(query, j);
        const double a = dot(between.velocity, between.velocity), b = dot(between.position, between.velocity);
        const double c = dot(between.position, between.position) - distance * distance,
                     discriminant = b * b - a * c;
        if (!(b < 0.0 && discriminant > 0.0)) return math::infinity;
        return paths.now + math::max(c, 0.0) / (math::sqrt(discriminant) - b);
    }
};

}  // namespace hardlimit::boxes::events
