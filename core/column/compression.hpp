// Upper bounds on the compressions of two balls on a floor, from energy conservation. Where they exclude a compression
// beyond the limit, the solver need not search for one.
//
// While the floor contact is compressed by less than L1 and the pair by less than L2, the sum of kinetic energy and
// energy stored in the contacts is at most
//   E = energy at release, with heights measured from the position in which the compressions are L1 and L2.
// So the speed of the lower ball is at most c = √(2E/m1). With v2 the velocity of the upper ball and F12 the force on
// it, define s by
//   m2 s²/2 = kinetic energy of the upper ball + energy stored in the pair.
// This energy grows by at most ∫ F12 v1 dt plus the work of gravity, since dashpots only dissipate, and momentum
// balance gives ∫ F12 dt = m2 (v2 − v2(0) + g t). As v2 <= s,
//   s²/2 <= v2(0)²/2 + g × (largest distance of fall) + c (s − v2(0) + g t).
// For a light upper ball this is far less than E. It also holds in the adiabatic model, where E bounds the floor
// contact but not the pair.
#pragma once
#include "../contact/law.hpp"

namespace hardlimit::column {

struct CompressionBound {
    double m1, m2, gravity;
    double height, v1, v2;                         // gap of the floor, and velocities, at release
    bool coupled = true;                           // the lower ball feels the upper one
    double floor = 0.0, pair = 0.0;                // L1, L2 [m]
    double floor_energy = 0.0, pair_energy = 0.0;  // stored at L1 and L2 [J]
    double stored = 0.0;                           // in the contacts at release [J]

    // The bound for L1 and L2 equal to `part` times the smaller radius.
    template <class Law>
    HL_FN CompressionBound within(double part, double r1, double r2, const Law& of_floor,
                                  const Law& of_pair) const {
        constexpr int p = Law::onset_power;
        CompressionBound b = *this;
        b.floor = part * r1;
        b.pair = part * math::min(r1, r2);
        b.floor_energy = of_floor.energy(onset_root<p>(b.floor));
        b.pair_energy = of_pair.energy(onset_root<p>(b.pair));
        return b;
    }

    // Value of g t [m/s], with t the time since release, up to which neither compression can be reached. `gap`: gap of
    // the pair at release. ∞: never reached; −∞: not excluded.
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

// The bound applied to one drop with a given gap of its pair.
struct DropBound {
    double sure, landed, gravity;  // g t up to which it is excluded, g t at the floor touch [m/s]; g

    HL_FN static DropBound of(const CompressionBound& b, double gap, double impact_speed) {
        return {b.excluded_until(gap), b.v1 + impact_speed, b.gravity};
    }
    // Whether both compressions are excluded up to t [s] after the floor touch.
    HL_FN bool holds(double t) const {
        return sure == math::infinity || landed + gravity * math::max(t, 0.0) <= sure;
    }
    // Whether both are excluded in a sequence with this many pair contacts; with none only the floor contact counts.
    HL_FN bool holds(int n_contacts, double t_end) const {
        return n_contacts == 0 ? sure > -math::infinity : holds(t_end);
    }
};

}  // namespace hardlimit::column
