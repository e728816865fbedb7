// Bounds on the compressions of the contacts of two balls on a floor, from energies alone. Where they exclude a
// contact that is too deep, the motion is not searched for one.
//
// As long as the floor contact is compressed by less than L1 and the pair by less than L2, kinetic energy and energy
// stored in the contacts are together at most
//   E = energy at release, heights being counted from where the contacts are compressed by L1 and L2.
// It bounds the speed of the lower ball by c = √(2E/m1). With v2 the velocity of the upper ball and F12 the force on
// it,
//   m2 s²/2 = kinetic energy of the upper ball + energy stored in the pair
// gains no more than ∫ F12 v1 dt and what the ball falls, since dashpots only take from it, and by momentum
// ∫ F12 dt = m2 (v2 − v2(0) + g t). As v2 <= s,
//   s²/2 <= v2(0)²/2 + g × (way that it can fall) + c (s − v2(0) + g t).
// For a light upper ball that is far less than E. It holds in the adiabatic model as well, where E bounds the floor
// contact, but not the pair.
#pragma once
#include "../contact/law.hpp"

namespace hardlimit::column {

struct CompressionBound {
    double m1, m2, gravity;
    double height, v1, v2;             // gap of the floor, and velocities, at release
    double floor, pair;                // L1, L2 [m]
    double floor_energy, pair_energy;  // stored at L1 and L2 [J]
    bool coupled;                      // the lower ball feels the upper one
    double stored = 0.0;               // in the contacts at release [J]

    // The bound for compressions by `part` of the smaller radius.
    template <class Law>
    HL_FN static CompressionBound of(double part, const Law& floor, const Law& pair, double m1, double m2,
                                     double r1, double r2, double gravity, double height, double v1,
                                     double v2, bool coupled) {
        constexpr int p = Law::onset_power;
        const double l1 = part * r1, l2 = part * math::min(r1, r2);
        return {m1,
                m2,
                gravity,
                height,
                v1,
                v2,
                l1,
                l2,
                floor.energy(onset_root<p>(l1)),
                pair.energy(onset_root<p>(l2)),
                coupled};
    }

    // g t [m/s] up to which both compressions are excluded, with t the time since release and this gap of the pair at
    // release; −∞: they are not excluded, ∞: at all times.
    HL_FN double excluded_until(double gap) const {
        const double e = stored + 0.5 * (m1 * (v1 * v1) + m2 * (v2 * v2)) +
                         gravity * (m1 * (height + floor) + m2 * (height + gap + floor + pair));
        if (!(floor_energy > e)) return -math::infinity;
        if (coupled && pair_energy > e) return math::infinity;
        const double c = math::sqrt(2.0 * e / m1), room = math::sqrt(2.0 * pair_energy / m2) - c;
        if (!(room > 0.0)) return -math::infinity;
        const double fall = 2.0 * gravity * (height + gap + floor + pair);
        return ((room * room - (c * c + v2 * v2)) - fall) / (2.0 * c) + v2;
    }
};

// The same for one drop and the gap of its pair.
struct DropBound {
    double sure, landed, gravity;  // g t that is sure; g t at the touch; g

    HL_FN static DropBound of(const CompressionBound& b, double gap, double impact_speed) {
        return {b.excluded_until(gap), b.v1 + impact_speed, b.gravity};
    }
    // Both compressions are excluded up to t [s] after the touch.
    HL_FN bool holds(double t) const {
        return sure == math::infinity || landed + gravity * math::max(t, 0.0) <= sure;
    }
    // Both are excluded in a sequence with this many contacts of the pair; without any only the floor contact counts.
    HL_FN bool holds(int n_contacts, double t_end) const {
        return n_contacts == 0 ? sure > -math::infinity : holds(t_end);
    }
};

}  // namespace hardlimit::column
