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
    std::vector<double> mass, radius;  // [N]
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
          time_step(longest_step) {}

    std::size_t count() const { return mass.size(); }
    std::size_t axes() const { return static_cast<std::size_t>(box.dimension); }

    template <class Archive>
    void exchange(Archive& archive) {
        archive(box), archive(mass), archive(radius), archive(law), archive(log), archive(time_step);
    }

    template <class Law>
    PairLaws<Law> laws() const {
        const auto* p = law.parameters;
        return {law.alternative, std::vector<double>(p, p + max_parameters), mass, radius};
    }

    // Copies the components of particle i; the third is 0 in two dimensions.
    void in_three(const double* values, std::size_t i, double (&three)[3]) const {
        three[2] = 0.0;
        std::copy_n(values + axes() * i, axes(), three);
    }
};

}  // namespace hardlimit::boxes
