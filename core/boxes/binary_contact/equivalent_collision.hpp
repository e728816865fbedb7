// Equivalent collision: the instantaneous collision that leads to the same path as a contact of finite duration t_c.
//
// The free flight after the contact, extrapolated back to the instant of touch, starts at r* = r(t_c) − t_c v(t_c) with
// v* = v(t_c). At a wall with gravity along its normal, it is the parabola through the end of the contact. A pair that
// is moved to r* at touch and flies freely is on the path of Newton's equations from t_c on.
#pragma once
#include "planar_contact.hpp"

namespace hardlimit::boxes {

// Relative motion (first body minus second, or body minus wall). Normal: along the line of centres at touch, from the
// second body to the first. Tangential: along the component of the relative velocity perpendicular to it.
struct EquivalentCollision {
    double normal_velocity, tangential_velocity;  // v* [m/s]
    double normal_shift, tangential_shift;        // r* − r at touch [m]
};

// The shift of two bodies is a sum of small terms, so that it keeps its digits even if l is 1e8 times as large.
HL_FN EquivalentCollision equivalent_collision(const Approach& a, const PlanarContact& end) {
    const double t = end.duration;
    if (a.distance == math::infinity) {
        const double fallen = a.gravity * t;
        return {end.radial_speed + fallen, a.tangential_speed,
                -end.compression - t * (end.radial_speed + 0.5 * fallen), 0.0};
    }
    const auto half = math::sincos(0.5 * end.turn);
    const double sine = 2.0 * half.sin * half.cos, versine = 2.0 * half.sin * half.sin;  // 1 − cos
    const double cosine = 1.0 - versine;
    const double normal = end.radial_speed * cosine - end.tangential_speed * sine;
    const double across = end.radial_speed * sine + end.tangential_speed * cosine;
    return {normal, across, -end.compression * cosine - a.distance * versine - t * normal,
            (a.distance - end.compression) * sine - t * across};
}

}  // namespace hardlimit::boxes
