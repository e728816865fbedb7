// Energies, momentum and virial of the stepping engine.
#pragma once
#include <cstdint>

#include "decomposition.hpp"

namespace hardlimit::boxes {

struct StepsObservables {
    double kinetic, potential, contact, dissipated;  // energies [J]; dissipated since the start
    double momentum[3];                              // [kg m/s]
    double virial;                                   // ∫ Σ r·F dt over pairs since the start [J s]
    std::uint64_t in_contact;                        // open contacts
};

namespace steps {

// Coordinate along the unfolded path [m].
inline double unfolded(const Box3& box, const Bodies& bodies, std::size_t i, int axis) {
    return bodies.position[i][axis] + bodies.tag[i].image_flags[axis] * box.edge[axis];
}

// velocity_of(i): velocity of body i at the time of the positions [m/s].
template <class Law, class VelocityOf>
StepsObservables observe(const Box3& box, const Decomposition<Law>& domain, const VelocityOf& velocity_of) {
    const Bodies& bodies = domain.bodies;
    StepsObservables o{};
    for (std::size_t i = 0; i < bodies.count(); ++i) {
        const Double4 v = velocity_of(i);
        const double mass = 1.0 / bodies.velocity[i][3];
        o.kinetic += 0.5 * mass * dot(v, v);
        for (int axis = 0; axis < box.dimension; ++axis) {
            o.potential -= mass * box.gravity[axis] * unfolded(box, bodies, i, axis);
            o.momentum[axis] += mass * v[axis];
        }
    }
    o.dissipated = domain.dissipated, o.virial = domain.virial;
    for (const Slab<Law>& s : domain.slabs) {
        o.dissipated += s.dissipated, o.virial += s.virial;
        for (const Contact<Law>& c : s.contacts) {
            if (c.index_first == no_body) continue;
            o.contact += c.law.energy(onset_root<Law::onset_power>(c.compression));
            o.in_contact += c.in_contact;
        }
    }
    return o;
}

}  // namespace steps

}  // namespace hardlimit::boxes
