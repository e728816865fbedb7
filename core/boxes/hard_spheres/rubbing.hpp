// Tangential impulses of instantaneous collisions with friction.
//
// Surface velocity of the second body relative to the first, with r from the first centre to the second and
// l = R_i + R_j (at a wall l = R_i):
//   g = v − Ω×r,   Ω = (R_i ω_i + R_j ω_j)/l,   g_t = g − (g·r/r²) r.
// The impulse on the second body J = −m_t (1 + β) g_t changes both spins by −(R/(l I)) r×J, so that g_t becomes −β g_t
// with 1/m_t = 1/m + (R_i²/I_i + R_j²/I_j) r²/l². The arms R r/l of velocity and torque are the same. Therefore angular
// momentum and energy are exact also if r differs from l by rounding, and no square root enters (see
// Collisions::rebound).
#pragma once
#include "soft_contact.hpp"

namespace hardlimit::boxes::spheres {

// Slip of two surfaces at touch.
struct Slip {
    Vector3 r{};                        // [m]
    Vector3 spin{};                     // Ω [rad/s]
    Vector3 velocity{};                 // g_t [m/s]
    double speed = 0.0;                 // |g_t| [m/s]
    double mass = 0.0;                  // m_t [kg]
    double length = 1.0;                // l [m]
    double turning_mass_inverse = 0.0;  // R_i²/I_i + R_j²/I_j [1/kg]
};

template <int d, bool mixed>
class Rubbing {
public:
    explicit Rubbing(Particles<d, mixed>& particles) : particles_(particles) {}

    // Both enter the slip into `impact`.
    Slip of_pair(const Touch<d>& t, Impact& impact) const {
        Slip s;
        std::copy_n(t.r, d, s.r.begin());
        Vector3 v{};
        std::copy_n(t.v, d, v.begin());
        s.length = particles_.radius(t.i) + particles_.radius(t.j);
        s.turning_mass_inverse = add_body(t.i, s) + add_body(t.j, s);
        set_velocity(s, v, impact);
        return s;
    }
    Slip at_wall(u32 i, const Wall& wall, Impact& impact) const {
        Slip s;
        const auto axis = static_cast<std::size_t>(wall.id.axis());
        s.length = particles_.radius(i);
        s.r[axis] = -wall.inward() * s.length;
        s.turning_mass_inverse = add_body(i, s);
        Vector3 v{};
        for (std::size_t k = 0; k < d; ++k) v[k] = -particles_.paths[i].velocity[k];
        v[axis] = 0.0;
        set_velocity(s, v, impact);
        return s;
    }
    // Impulse on the second body.
    static Vector3 impulse(const Slip& s, double gain) {
        Vector3 j;
        for (std::size_t k = 0; k < 3; ++k) j[k] = -(s.mass * gain) * s.velocity[k];
        return j;
    }
    // Turns a particle by the impulse on the second body.
    void turn(u32 i, const Slip& s, const Vector3& impulse) {
        Spin& spin = particles_.spins[i];
        const Vector3 torque = cross(s.r, impulse);
        const double change = particles_.radius(i) / s.length * spin.inverse_inertia;
        for (std::size_t k = 0; k < 3; ++k) spin.velocity[k] -= change * torque[k];
    }
    // Adds what the tangential impulse does to the result of the normal one.
    static void add_result(const Slip& s, const Rebound& rebound, CollisionResult& result) {
        const double gain = rebound.tangential_gain;
        const double lost = 0.5 * s.mass * gain * (2.0 - gain) * s.speed * s.speed;
        result.lost += lost, result.friction_loss = lost;
        result.tangential_speed = s.speed, result.tangential_restitution = gain - 1.0;
        result.slid = rebound.slid;
    }

    // A contact that takes time. n and v: from the first body to the second.
    TurningApproach approach(const Slip& s, const Impact& impact, const Vector3& n, const Vector3& v) const {
        const double distance = impact.approach.distance;
        const double arm = distance == math::infinity ? s.length : distance;
        return {impact.approach.effective_mass, distance, arm, impact.rotational_ratio, n, v, s.spin};
    }
    // Gives a particle the spin after this contact. Returns the energy that it loses [J].
    double turn(u32 i, const Slip& s, const TurningContact& end) {
        Spin& spin = particles_.spins[i];
        const double share = s.length * particles_.radius(i) * spin.inverse_inertia / s.turning_mass_inverse;
        double gained = 0.0;
        for (std::size_t k = 0; k < 3; ++k) {
            const double change = share * (end.spin[k] - s.spin[k]);
            gained += change * (spin.velocity[k] + 0.5 * change);
            spin.velocity[k] += change;
        }
        return -gained / spin.inverse_inertia;
    }
    static void add_result(const Slip& s, const TurningApproach& touch, const TurningContact& end,
                           CollisionResult& result) {
        result.friction_loss = end.slip + end.tangential_damping + end.tangential_spring;
        result.tangential_speed = s.speed;
        result.slid = end.slips_first || end.changes > 0;
        const Vector3 turning = cross(end.spin, end.normal);
        const double arm = touch.arm - end.compression;
        double along = 0.0;
        for (std::size_t k = 0; k < 3; ++k) along += (end.velocity[k] - arm * turning[k]) * s.velocity[k];
        if (s.speed > 0.0) result.tangential_restitution = -(along / s.speed) / s.speed;
    }

private:
    Particles<d, mixed>& particles_;

    // Adds (R/l) ω to Ω. Returns R²/I [1/kg].
    double add_body(u32 i, Slip& s) const {
        const Spin& of = particles_.spins[i];
        const double radius = particles_.radius(i), share = radius / s.length;
        for (std::size_t k = 0; k < 3; ++k) s.spin[k] += share * of.velocity[k];
        return radius * radius * of.inverse_inertia;
    }
    static void set_velocity(Slip& s, const Vector3& v, Impact& impact) {
        const double square = dot(s.r, s.r), along = dot(v, s.r) / square;
        const Vector3 turning = cross(s.spin, s.r);
        for (std::size_t k = 0; k < 3; ++k) s.velocity[k] = (v[k] - along * s.r[k]) - turning[k];
        s.speed = math::sqrt(dot(s.velocity, s.velocity));
        const double mass = impact.pair.effective_mass, ratio = mass * s.turning_mass_inverse;
        s.mass = mass / (1.0 + ratio * (square / (s.length * s.length)));
        impact.slip_speed = s.speed, impact.rotational_ratio = ratio;
    }
};

}  // namespace hardlimit::boxes::spheres
