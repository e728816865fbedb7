// Fuzz target: one contact with friction in three dimensions, under any law and friction, with spins, masses and speeds
// over many decades. Checks that it ends, and its balances of energy and angular momentum.
#include <cstdlib>

#include "boxes/binary_contact/turning_contact.hpp"
#include "check.hpp"

namespace {

using namespace hardlimit;
using namespace hardlimit::boxes;
using Draw = fuzz::Draw<fuzz::Bytes>;

Vector3 any_vector(Draw& draw, double size) {
    return {draw.between(-size, size), draw.between(-size, size), draw.between(-size, size)};
}
Vector3 any_direction(Draw& draw) {
    if (draw.below(4) == 0) return {0.0, 0.0, 1.0};
    Vector3 v = any_vector(draw, 1.0);
    v[2] += 1e-3;
    const double length = math::sqrt(dot(v, v));
    for (double& x : v) x /= length;
    return v;
}

template <class Law>
Friction any_friction(Draw& draw) {
    Friction f;
    f.coefficient = draw.often({0.0, math::infinity, 1.0, 0.5}, [&] { return draw.decades(1e-6, 10.0); });
    f.limit = draw.below(2) == 0 ? SlipLimit::total : SlipLimit::spring;
    f.damping_ratio = draw.often({0.0, 0.0, 1.0, 0.5}, [&] { return draw.decades(1e-3, 4.0); });
    if (draw.below(8) == 0) {
        f.model = FrictionModel::none;
        return f;
    }
    f.model = Law::onset_power == 1 ? FrictionModel::spring : static_cast<FrictionModel>(1 + draw.below(4));
    f.stiffness_ratio = draw.often({2.0 / 7.0, 1.0, 0.5, 2.0}, [&] { return draw.decades(0.05, 5.0); });
    return f;
}

// The motion of two bodies whose elastic impact reaches a part of the distance of their centres.
template <class Law>
TurningApproach any_approach(Draw& draw, const Law& law, double mass, double arm) {
    const bool wall = draw.below(4) == 0;
    const double depth = arm * draw.decades(1e-8, 0.1);
    const double speed = math::sqrt(2.0 * law.energy(onset_root<Law::onset_power>(depth)) / mass);
    TurningApproach a{mass, wall ? math::infinity : arm, arm, draw.between(1.0, 8.0), any_direction(draw), {},
                      {}};
    const double slide = speed * draw.often({0.0, 1.0}, [&] { return draw.decades(1e-6, 100.0); });
    const double turn = speed / arm * draw.often({0.0, 1.0}, [&] { return draw.decades(1e-6, 100.0); });
    const Vector3 across = any_vector(draw, slide);
    const double along = dot(across, a.normal) + speed;
    for (std::size_t k = 0; k < 3; ++k) a.velocity[k] = across[k] - along * a.normal[k];
    a.spin = any_vector(draw, turn);
    if (draw.below(4) == 0) a.spin = {0.0, 0.0, a.spin[2]};
    return a;
}

void check_balances(const TurningApproach& a, const TurningContact& end) {
    const double m = a.effective_mass, inertia = m * a.arm * a.arm / a.rotational_ratio;
    const auto energy = [&](const Vector3& v, const Vector3& w) {
        return 0.5 * m * dot(v, v) + 0.5 * inertia * dot(w, w);
    };
    const double before = energy(a.velocity, a.spin), after = energy(end.velocity, end.spin);
    const double taken =
        end.normal_spring + end.tangential_spring + end.normal_damping + end.tangential_damping + end.slip;
    const double scale = before + math::abs(end.tangential_spring) + math::abs(end.slip);
    fuzz::require(math::abs(before - after - taken) <= 1e-10 * scale, "the energy closes");
    Vector3 centres, first;
    for (std::size_t k = 0; k < 3; ++k) {
        first[k] = a.arm * a.normal[k];
        centres[k] = first[k] + end.shift[k];
    }
    if (a.distance == math::infinity) return;
    const Vector3 old = cross(first, a.velocity), now = cross(centres, end.velocity);
    const double size =
        math::sqrt(dot(a.velocity, a.velocity)) * m * a.arm + inertia * math::sqrt(dot(a.spin, a.spin));
    for (std::size_t k = 0; k < 3; ++k) {
        const double change = m * (now[k] - old[k]) + inertia * (end.spin[k] - a.spin[k]);
        fuzz::require(math::abs(change) <= 1e-11 * size, "angular momentum is conserved");
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    Draw draw{fuzz::Bytes(data, size)};
    fuzz::with_some_law(draw, [&]<class Law>() {
        const double mass = draw.decades(1e-9, 1e3), radius = draw.decades(1e-5, 10.0);
        const Law normal = fuzz::Material<Law>(draw).between({mass, radius});
        const Friction friction = any_friction<Law>(draw);
        const FrictionTerms terms = friction_terms(friction, Law::record.powers, normal.coefficients());
        const TurningApproach touch = any_approach(draw, normal, mass, 2.0 * radius);
        const WithFriction<Law> law{normal, terms};
        const TurningContact end = solve_turning_contact(law, touch);
        fuzz::require(end.outcome == Outcome::ok || end.outcome == Outcome::too_deep, "the contact ends");
        if (end.outcome != Outcome::ok) return;
        fuzz::require(end.duration > 0.0, "a duration above zero");
        fuzz::require(solve_turning_contact(law, touch).velocity == end.velocity, "the same numbers again");
        check_balances(touch, end);
    });
    return 0;
}
