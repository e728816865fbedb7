// States and the end of the contact of two spheres with friction, from the integrated variables (turning_motion.hpp).
#pragma once
#include "turning_motion.hpp"

namespace hardlimit::boxes {

inline constexpr int most_intervals = 16;

// The end of a contact. If it does not end (`outcome`), the numbers are NaN.
struct TurningContact {
    Outcome outcome = Outcome::unresolved;
    double duration = math::nan;                     // [s]
    Vector3 shift{math::nan, math::nan, math::nan};  // of the relative position since touch [m]
    Vector3 velocity = shift;                        // relative [m/s]
    Vector3 spin = shift;                            // Ω [rad/s]
    Vector3 normal = shift;                          // from the first body to the second
    double compression = math::nan;                  // residual [m]
    // Energies [J]: left in the springs, taken by damping (that of the tangential force while the surfaces stick), and
    // by slip, the rest of the work of the tangential force.
    double normal_spring = math::nan, tangential_spring = math::nan;
    double normal_damping = math::nan, tangential_damping = math::nan, slip = math::nan;
    int changes = 0;  // between stick and slip
    // Whether they slip at touch, and the times of the changes [s]; only the first are kept.
    bool slips_first = false;
    double change[most_intervals] = {};
};

// State during a contact.
struct TurningState {
    double time;  // since touch [s]
    Vector3 shift, velocity, spin, normal;
    double normal_force;       // [N]
    Vector3 tangential_force;  // on the second body [N]
    bool slips;
};

// A state within a contact: ξ, dξ/dt, and T [N] while the surfaces stick, the direction of the force while they slip.
struct WithinContact {
    double compression, rate;
    Vector3 memory;
    bool slips;
    bool frozen;  // whether this direction keeps still
};

// What the methods of integration share.
template <class Normal>
class TurningStates {
public:
    using M = TurningMotion<Normal>;

    TurningStates(const WithFriction<Normal>& law, const TurningApproach& touch) : motion_(law, touch) {}
    TurningStates(const WithFriction<Normal>& law, const TurningApproach& touch,
                  const PlanarMotion<Normal>& units)
        : motion_(law, touch, units) {}

    TurningState state_of(const double* y) const {
        const auto& units = motion_.units();
        const auto now = motion_.now(y);
        const Tangential f = motion_.force(y, now);
        const double unit = 1.0 / units.force_unit, normal = math::max(now.normal, 0.0);
        return {y[M::time] * motion_.time_unit(),
                shift_of(y),
                velocity_of(y),
                spin_of(y),
                normal_of(y),
                unit * normal,
                motion_.in_space(y, -unit * f.first, -unit * f.second, 0.0),
                motion_.slips};
    }

protected:
    M motion_;
    TurningContact result_;

    Vector3 normal_of(const double* y) const {
        Vector3 normal = motion_.normal_change(y);
        for (std::size_t k = 0; k < 3; ++k) normal[k] += motion_.touch().normal[k];
        return normal;
    }
    // r − r(0) = −ξ n + l (n − n(0)); at a wall the path along it.
    Vector3 shift_of(const double* y) const {
        const double length = motion_.units().length, depth = length * math::power<M::p>(y[M::root_depth]);
        if (motion_.is_wall())
            return motion_.from_touch({length * y[M::turn + 1], length * y[M::turn + 2], -depth});
        const Vector3 change = motion_.normal_change(y);
        Vector3 shift;
        for (std::size_t k = 0; k < 3; ++k)
            shift[k] = (motion_.touch().distance - depth) * change[k] - depth * motion_.touch().normal[k];
        return shift;
    }
    Vector3 velocity_of(const double* y) const {
        const double unit = motion_.units().speed;
        return motion_.in_space(y, unit * y[M::across], unit * y[M::across + 1], -unit * y[M::rate]);
    }
    Vector3 spin_of(const double* y) const {
        const double unit = motion_.units().speed / motion_.touch().arm;
        return motion_.in_space(y, -unit * y[M::surface + 1], unit * y[M::surface], unit * y[M::twist]);
    }

    TurningContact finish(const double* y) {
        const auto& units = motion_.units();
        const TurningState end = state_of(y);
        const double energy = motion_.touch().effective_mass * units.speed * units.speed;
        result_.outcome = Outcome::ok;
        result_.duration = end.time;
        result_.shift = end.shift;
        result_.velocity = end.velocity;
        result_.spin = end.spin;
        result_.normal = end.normal;
        result_.compression = units.length * math::power<M::p>(math::max(y[M::root_depth], 0.0));
        result_.normal_damping = energy * y[M::loss];
        result_.normal_spring = units.law->energy(units.root * math::max(y[M::root_depth], 0.0));
        const double left = motion_.spring_energy(y);
        result_.tangential_spring = energy * left;
        result_.tangential_damping = energy * y[M::damped];
        result_.slip = energy * (y[M::work] - y[M::damped] - left);
        return result_;
    }
};

}  // namespace hardlimit::boxes
