// Inelastic collapse: infinitely many collisions in a finite time, of a ball that bounces out on a floor or of a few
// particles between each other (McNamara & Young, Phys. Fluids A 4, 496 (1992)).
//
// Speeds and waiting times then shrink together, by a factor at each collision. So a particle collapses where it collides
// three times at less than 1e-8 of the thermal speed and after less than the hundredth of the time in which a particle
// moves by a radius, each time more slowly and sooner than before. In a gas one collision of 1e16 is so slow. What is below
// the rounding of the thermal speed are particles in touch: they are left to the other criterion, ten thousand
// collisions, a thousand of them of one particle, in 1e-9 of that time.
#pragma once
#include <unordered_map>
#include <vector>

#include "tally.hpp"

namespace hardlimit::particles {

struct Impact {
    double time;     // [s]
    u32 first;       // id of a user
    i64 second;      // id, or number of a wall
    double speed;    // of approach [m/s]
    double waited;   // since the last collision of either, the longer of the two [s]
    bool shrinking;  // whether speeds may shrink for ever: not under the rule tc
};

class CollapseWatch {
public:
    // thermal: Σ m v'² + M g R, of which the mean square speed is thermal/M.
    bool collapses(const Impact& c, double thermal_energy, double mass, double radius) {
        if (c.time <= instant_ + window_) {
            if (++at_once_ > many_at_once && ++times_[c.first] > of_one) return true;
            if (at_once_ > many_at_once && c.second >= 0 && ++times_[static_cast<u32>(c.second)] > of_one)
                return true;
        } else {
            start_instant(c.time, thermal_energy, mass, radius);
        }
        if (!c.shrinking || !(c.speed * c.speed * mass < slow * slow * thermal_energy)) return false;
        return shrinks(c, math::sqrt(thermal_energy / mass), radius);
    }

    template <class Archive>
    void archive(Archive& a) {
        a(instant_), a(window_), a(at_once_);
        archive_map(a, times_);
        archive_map(a, streaks_);
    }

private:
    static constexpr double slow = 1e-8, soon = 1e-2, at_an_instant = 1e-9, rounding = 4.0 * math::epsilon;
    static constexpr int many_at_once = 10'000, of_one = 1'000, in_a_row = 3;
    struct Streak {
        double speed, waited;
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

    void start_instant(double time, double thermal_energy, double mass, double radius) {
        instant_ = time;
        window_ = 8.0 * math::epsilon * math::abs(time);
        if (thermal_energy > 0.0)
            window_ = math::max(window_, at_an_instant * radius * math::sqrt(mass / thermal_energy));
        at_once_ = 0;
        if (!times_.empty()) times_.clear();
    }
    bool shrinks(const Impact& c, double thermal_speed, double radius) {
        if (!(c.waited * thermal_speed < soon * radius) || !(c.speed > rounding * thermal_speed))
            return false;
        const bool first = grows(c.first, c);
        const bool second = c.second >= 0 && grows(static_cast<u32>(c.second), c);
        return first || second;
    }
    bool grows(u32 particle, const Impact& c) {
        const auto [at, fresh] = streaks_.try_emplace(particle, Streak{c.speed, c.waited, 0});
        Streak& s = at->second;
        s.length = fresh || (c.speed < s.speed && c.waited <= s.waited) ? s.length + 1 : 1;
        s.speed = c.speed;
        s.waited = c.waited;
        return s.length >= in_a_row;
    }
};

}  // namespace hardlimit::particles
