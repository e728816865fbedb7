// Detection of inelastic collapse, infinitely many collisions in a finite time: of a ball that comes to rest on a
// floor, or among a few particles (S. McNamara and W. R. Young, Phys. Fluids A 4, 496 (1992)).
//
// In a collapse, speeds and waiting times shrink by a factor at each collision. A particle has collapsed after four or
// more collisions in a row, each slower than the last and within 1e-8 radii/(approach speed) of it, if the approach
// speed has fallen to a millionth. In a gas, one collision in 1e8 follows the last so soon. Touching particles that are
// hit also collide at one instant, but their speeds do not fall so far. Approaches at the rounding error of the
// velocities do not count. So that no run hangs, ten thousand collisions, a thousand of them of one particle, within
// 1e-9 of the time in which a particle moves by a radius are a collapse too.
#pragma once
#include <unordered_map>
#include <vector>

#include "../common/particle.hpp"

namespace hardlimit::boxes {

class CollapseDetector {
public:
    struct Collision {
        double time;        // [s]
        u32 first;          // particle
        i64 second;         // particle, or number of a wall
        double speed;       // of approach [m/s]
        double waited;      // since the last collision of either, the longer of the two [s]
        bool may_collapse;  // whether the rule allows a collapse
    };

    // Whether this collision is part of a collapse. typical(): root mean square speed of all particles [m/s]; index(i):
    // original index of a particle, the key used here. Both are called only if needed.
    template <class Typical, class Index>
    bool collapses(const Collision& c, double radius, const Typical& typical, const Index& index) {
        const auto other = [&] { return index(static_cast<u32>(c.second)); };
        if (c.time > instant_ + window_)
            start_instant(c.time, radius, typical());
        else if (++at_once_ > many_at_once &&
                 (++times_[index(c.first)] > of_one || (c.second >= 0 && ++times_[other()] > of_one)))
            return true;
        if (!(c.may_collapse && c.waited * c.speed < soon * radius)) {
            if (!streaks_.empty()) {
                streaks_.erase(index(c.first));
                if (c.second >= 0) streaks_.erase(other());
            }
            return false;
        }
        if (!(c.speed > rounding * typical())) return false;
        const bool first = shrinks(index(c.first), c.speed);
        const bool second = c.second >= 0 && shrinks(other(), c.speed);
        return first || second;
    }

    template <class Archive>
    void archive(Archive& a) {
        a(instant_), a(window_), a(at_once_);
        archive_map(a, times_);
        archive_map(a, streaks_);
    }

private:
    static constexpr double soon = 1e-8, far = 1e-6, at_an_instant = 1e-9, rounding = 4.0 * math::epsilon;
    static constexpr int many_at_once = 10'000, of_one = 1'000, in_a_row = 4;
    struct Streak {
        double first, last;  // speeds [m/s]
        int length;
    };
    double instant_ = -math::infinity, window_ = 0.0;
    int at_once_ = 0;
    std::unordered_map<u32, int> times_;
    std::unordered_map<u32, Streak> streaks_;

    template <class Archive, class Map>
    static void archive_map(Archive& a, Map& map) {
        struct Row {
            u32 key;
            typename Map::mapped_type value;
        };
        std::vector<Row> rows;
        for (const auto& [key, value] : map) rows.push_back({key, value});
        a(rows);
        map.clear();
        for (const Row& r : rows) map.emplace(r.key, r.value);
    }

    void start_instant(double time, double radius, double typical_speed) {
        instant_ = time;
        window_ = 8.0 * math::epsilon * math::abs(time);
        if (typical_speed > 0.0) window_ = math::max(window_, at_an_instant * radius / typical_speed);
        at_once_ = 0;
        if (!times_.empty()) times_.clear();
    }
    // Adds a collision to the streak of ever slower collisions of a particle. Returns whether the streak is a collapse.
    bool shrinks(u32 particle, double speed) {
        const auto [at, fresh] = streaks_.try_emplace(particle, Streak{speed, speed, 1});
        Streak& s = at->second;
        if (fresh) return false;
        if (!(speed < s.last)) {
            s = {speed, speed, 1};
            return false;
        }
        s.last = speed;
        return ++s.length >= in_a_row && speed < far * s.first;
    }
};

}  // namespace hardlimit::boxes
