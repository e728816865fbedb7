// What stays the same during a run of hard spheres.
#pragma once
#include <algorithm>
#include <array>
#include <set>

#include "../common/archive.hpp"
#include "../common/engine.hpp"
#include "../common/particle.hpp"
#include "rules/rule.hpp"
#include "spins.hpp"

namespace hardlimit::boxes::spheres {

// Growing radii: σ(t) = (start + rate t) σ.
struct Growth {
    double start = 1.0;  // factor of the radii at time 0
    double rate = 0.0;   // [1/s]

    double at(double time) const { return start + rate * time; }
};

struct Setting {
    Box box{};
    RuleChoice rule{};
    Growth growth{};
    bool keeps_log = false;
    double mass = 0.0;                                   // of each particle, unless they differ [kg]
    double smallest_radius = 0.0, largest_radius = 0.0;  // [m]
    Motion motion = Motion::straight;
    Kinds kinds = Kinds::few;  // of particles with friction

    Setting(const System& s, const RuleChoice& rule, bool keeps_log, Growth growth)
        : box(s.box),
          rule(rule),
          growth(growth),
          keeps_log(keeps_log),
          mass(s.mass[0]),
          smallest_radius(*std::min_element(s.radius, s.radius + s.n)),
          largest_radius(*std::max_element(s.radius, s.radius + s.n)) {
        set_motion();
        if (rule.has_friction()) count_kinds(s);
    }
    explicit Setting(Reader& saved) {
        exchange(saved);
        set_motion();
    }
    template <class Archive>
    void exchange(Archive& a) {
        a(box), a(rule), a(growth), a(keeps_log), a(mass), a(smallest_radius), a(largest_radius), a(kinds);
    }

    bool falls() const { return motion == Motion::falling; }
    bool grows() const { return motion == Motion::growing; }

private:
    static constexpr std::size_t most_kinds = 16;

    void count_kinds(const System& s) {
        std::set<std::array<double, 3>> different;
        bool one_shape = true;
        for (std::size_t i = 0; i < s.n; ++i) {
            const double q = inertia_factor(s, i);
            one_shape = one_shape && q == inertia_factor(s, 0);
            if (different.size() <= most_kinds) different.insert({s.radius[i], s.mass[i], q});
        }
        kinds = different.size() <= most_kinds ? Kinds::few
                : one_shape                    ? Kinds::many_of_one_shape
                                               : Kinds::many;
    }
    void set_motion() {
        motion = growth.rate != 0.0 ? Motion::growing : box.falls() ? Motion::falling : Motion::straight;
    }
};

}  // namespace hardlimit::boxes::spheres
