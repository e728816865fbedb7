// Construction of the engine: the bodies, their spins, and the forces at the start.
#pragma once
#include "engine.hpp"

namespace hardlimit::boxes {

template <class Law>
NewtonSteps<Law>::NewtonSteps(const NewtonSetting& setting)
    : setting_(setting),
      laws_(setting_.laws<Law>()),
      domain_(box_, laws_, setting_.count()),
      stepper_(box_, laws_, domain_, criterion_),
      log_(setting_.count(), setting_.log) {}

template <class Law>
NewtonSteps<Law>::NewtonSteps(const NewtonSetting& setting, const System& s) : NewtonSteps(setting) {
    add_bodies(s);
    if constexpr (FrictionalLaw<Law>) add_spins(s);
    criterion_.fastest = math::max(criterion_.fastest, box_.fastest_wall());
    begin_rebuild();
    const auto never = [] { return false; };
    run(1, std::chrono::milliseconds(1000), never);  // forces at the start
}

template <class Law>
void NewtonSteps<Law>::add_bodies(const System& s) {
    for (std::size_t i = 0; i < s.n; ++i) {
        double x[3], v[3];
        setting_.in_three(s.position, i, x);
        setting_.in_three(s.velocity, i, v);
        bodies_.position.push_back(Double4{x[0], x[1], x[2], laws_.radius(i)});
        bodies_.velocity.push_back(Double4{v[0], v[1], v[2], 1.0 / laws_.mass(i)});
        bodies_.tag.push_back({static_cast<std::uint32_t>(i), {0, 0, 0}});
        include_speed(i);
    }
    bodies_.acceleration.resize(bodies_.count());
}

template <class Law>
void NewtonSteps<Law>::add_spins(const System& s) {
    for (std::size_t i = 0; i < s.n; ++i) {
        Double4 spin{0.0, 0.0, 0.0, 1.0 / setting_.inertia(i)};
        if (s.angular_velocity)
            for (std::size_t k = 0; k < 3; ++k) spin[k] = s.angular_velocity[3 * i + k];
        bodies_.spin.push_back(spin);
    }
    bodies_.angular_acceleration.resize(bodies_.count());
}

}  // namespace hardlimit::boxes
