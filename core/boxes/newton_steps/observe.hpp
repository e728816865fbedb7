// Energies, momentum and virial of the time-stepping engine.
#pragma once
#include "../common/engine.hpp"
#include "decomposition.hpp"

namespace hardlimit::boxes::steps {

// All observables except the counts of begun and ended contacts. velocity_of(i): velocity of body i at the time of the
// positions [m/s]; spin_of(i): its angular velocity [rad/s].
template <class Law, class VelocityOf, class SpinOf>
Observation observe(const Box& box, const Decomposition<Law>& domain, double time,
                    const VelocityOf& velocity_of, const SpinOf& spin_of) {
    const Bodies& bodies = domain.bodies;
    Observation o;
    for (std::size_t i = 0; i < bodies.count(); ++i) {
        Double4 v = velocity_of(i);
        const double mass = 1.0 / bodies.velocity[i][3];
        const ImageMotion image = box.image(bodies.tag[i].image_flags, time);
        const double flow = to_image_in_box(box, o, mass, bodies.position[i], v);
        o.kinetic_energy += 0.5 * mass * dot(v, v);
        for (int axis = 0; axis < box.dimension; ++axis) {
            const double unfolded = bodies.position[i][axis] + image.shift[axis];
            o.potential_energy -= mass * box.gravity[axis] * unfolded;
            o.momentum[axis] += mass * v[axis];
        }
        v[0] -= flow;
        o.kinetic_tensor.add_square(mass, v);
        if constexpr (FrictionalLaw<Law>) {
            const Double4 spin = spin_of(i);
            const double inertia = 1.0 / bodies.spin[i][3];
            o.rotational_energy += 0.5 * inertia * dot(spin, spin);
            for (int axis = 0; axis < 3; ++axis) o.spin.component[axis] += inertia * spin[axis];
        }
    }
    o.dissipated_energy = domain.dissipated, o.friction_loss = domain.friction_loss;
    o.wall_work = domain.wall_work, o.virial = domain.virial;
    o.shear_work += domain.shear_work;
    o.walls = domain.given_to_walls;
    for (const Slab<Law>& s : domain.slabs) {
        o.dissipated_energy += s.dissipated, o.friction_loss += s.friction_loss;
        o.wall_work += s.wall_work, o.shear_work += s.shear_work;
        o.virial += s.virial, o.walls += s.given_to_walls;
        for (const Contact<Law>& c : s.contacts) {
            if (c.index_first == no_body) continue;
            o.contact_energy += c.law.energy(onset_root<Law::onset_power>(c.compression));
            if constexpr (FrictionalLaw<Law>) o.tangential_energy += c.friction.energy(c.law, c.compression);
            o.in_contact += c.in_contact;
        }
    }
    o.contact_energy += o.tangential_energy;
    o.largest_compression = domain.largest_compression();
    return o;
}

}  // namespace hardlimit::boxes::steps
