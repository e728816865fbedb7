// Constant input of the Newton engines: box, particle properties, contact law. Checkpoints store it.
#pragma once
#include <algorithm>
#include <vector>

#include "engine.hpp"
#include "law_choice.hpp"
#include "pair_laws.hpp"

namespace hardlimit::boxes {

struct NewtonSetting {
    Box box;
    std::vector<double> mass, radius;    // [N]
    std::vector<double> inertia_factor;  // [N] q of the moment of inertia q m R²; empty without friction
    LawChoice law;
    bool log = false;
    double time_step = 0.0;  // largest step [s]; only for the time-stepping engine

    NewtonSetting() = default;
    NewtonSetting(const System& s, const LawChoice& choice, bool keep_log, double longest_step = 0.0)
        : box(s.box),
          mass(s.mass, s.mass + s.n),
          radius(s.radius, s.radius + s.n),
          law(choice),
          log(keep_log),
          time_step(longest_step) {
        if (!law.has_friction()) return;
        inertia_factor.assign(s.n, solid_inertia_factor(box.dimension));
        if (s.inertia_factor) inertia_factor.assign(s.inertia_factor, s.inertia_factor + s.n);
    }

    std::size_t count() const { return mass.size(); }
    std::size_t axes() const { return static_cast<std::size_t>(box.dimension); }

    template <class Archive>
    void exchange(Archive& archive) {
        archive(box), archive(mass), archive(radius), archive(inertia_factor), archive(law), archive(log),
            archive(time_step);
    }

    template <class Law>
    PairLaws<Law> laws() const {
        return {law, mass, radius};
    }
    // Moment of inertia of particle i [kg m²], with friction.
    double inertia(std::size_t i) const { return inertia_factor[i] * mass[i] * radius[i] * radius[i]; }

    // Copies the components of particle i; the third is 0 in two dimensions.
    void in_three(const double* values, std::size_t i, double (&three)[3]) const {
        three[2] = 0.0;
        std::copy_n(values + axes() * i, axes(), three);
    }
};

}  // namespace hardlimit::boxes
