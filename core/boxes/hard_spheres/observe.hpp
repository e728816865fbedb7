// Sums over all particles and collisions, kept up with every change, and the observables from them.
#pragma once
#include <algorithm>
#include <vector>

#include "accumulators.hpp"
#include "particles.hpp"

namespace hardlimit::boxes::spheres {

template <int d, bool mixed>
class Totals {
public:
    Accumulators<d> so_far;

    explicit Totals(Particles<d, mixed>& particles) : particles_(particles) {}
    // Begins the sums of a new run.
    void begin(const System& s) {
        Sum total;
        for (std::size_t i = 0; i < s.n; ++i) total.add(s.mass[i]);
        so_far.mass = total.value();
        std::copy_n(box_.gravity, d, so_far.gravity);
        so_far.gradient = box_.gradient, so_far.shear_rate = box_.shear_rate;
        refresh();
    }
    void advance() { so_far.advance(particles_.now); }

    // Gives a particle another velocity at the instant of its position.
    void set_velocity(u32 i, const double (&velocity)[d]) {
        Particle<d>& p = particles_.paths[i];
        so_far.sums.change(particles_.mass(i), p.velocity, velocity);
        if (box_.is_sheared()) {
            const double flow = box_.mean_flow(p.position);
            double before[d], after[d];
            std::copy_n(p.velocity, d, before);
            std::copy_n(velocity, d, after);
            before[0] -= flow, after[0] -= flow;
            so_far.from_flow.change(particles_.mass(i), before, after);
        }
        std::copy_n(velocity, d, p.velocity);
    }
    // Adds one particle's share of a change of the relative velocity and position.
    void displace(u32 i, double share, const double (&velocity)[d], const double (&shift)[d]) {
        Particle<d>& p = particles_.paths[i];
        const double m = particles_.mass(i);
        double changed[d];
        for (int k = 0; k < d; ++k) changed[k] = p.velocity[k] + share * velocity[k];
        set_velocity(i, changed);
        for (int k = 0; k < d; ++k) p.position[k] += share * shift[k];
        if (box_.is_sheared()) {  // the mean flow at the new place is another one
            const double flow = box_.mean_flow(p.position);
            const double moved = box_.shear_rate * (share * shift[box_.gradient]);
            double before[d];
            changed[0] -= flow;
            std::copy_n(changed, d, before);
            before[0] += moved;
            so_far.from_flow.change(m, before, changed);
        }
        if (particles_.setting.falls()) so_far.sums.add_potential(-share * m * dot(so_far.gravity, shift));
    }
    // Moves a particle that leaves a sheared box through the far side (step 1) or that at 0 (−1) to its image in the
    // box. The boundary does the work by which its kinetic energy changes.
    void cross_sheared_side(u32 i, int step) {
        const double m = particles_.mass(i);
        advance();
        double before[d], crossed[d];
        for (int k = 0; k < d; ++k) before[k] = crossed[k] = particles_.velocity(i, k);
        particles_.wrap(i, box_.gradient, step);
        crossed[0] = particles_.paths[i].velocity[0];
        so_far.sums.change(m, before, crossed);
        so_far.shear_work.add(gained_energy(m, before[0], crossed[0] - before[0]));
    }

    // Recomputes the sums: the errors of many changes add up, and a gas cools by many orders of magnitude.
    void refresh() {
        until_refresh_ = changes_between_refreshes();
        advance();
        so_far.sums = full_sums(false);
        if (box_.is_sheared()) so_far.from_flow = full_sums(true);
    }
    // The same when due, after the change of a particle.
    void count_change() {
        const i64 changes = changes_between_refreshes() - --until_refresh_;
        if (until_refresh_ == 0 || (changes >= particles_.size() && !so_far.are_exact())) refresh();
    }
    Observation observe() const {
        Observation o;
        const ParticleSums<d> sums = present_sums(false);
        const ParticleSums<d> relative = box_.is_sheared() ? present_sums(true) : sums;
        o.kinetic_energy = 0.5 * sums.twice_kinetic();
        o.potential_energy = sums.potential();
        for (int k = 0; k < d; ++k) o.momentum[k] = sums.momentum(k);
        o.dissipated_energy = so_far.dissipated.value();
        o.friction_loss = so_far.friction_loss.value();
        if (particles_.rotates()) add_rotation(o);
        int k = 0;
        for (std::size_t c = 0; c < SymmetricTensor::size; ++c)
            if (SymmetricTensor::column[c] < d) {
                o.kinetic_tensor.component[c] = relative.product(k);
                o.virial.component[c] = so_far.virial.value(k++);
            }
        o.flow_momentum = sums.momentum(0) - relative.momentum(0);
        o.shear_work = so_far.shear_work.value();
        o.wall_work = so_far.wall_work.value();
        o.walls = so_far.of_walls();
        o.kinetic_integral = so_far.integral_until(particles_.now);
        o.begun = o.ended = so_far.collisions();
        o.pairs = so_far.pairs;
        return o;
    }
    // Root mean square speed of all particles [m/s].
    double typical_speed() const {
        return math::sqrt(math::max(0.0, so_far.sums.twice_kinetic() / so_far.mass));
    }
    template <class Archive>
    void exchange(Archive& a) {
        a(so_far), a(until_refresh_);
    }

private:
    Particles<d, mixed>& particles_;
    const Box& box_ = particles_.box;
    i64 until_refresh_ = 0;  // changes until the sums are recomputed

    i64 changes_between_refreshes() const { return 16 * static_cast<i64>(particles_.size()); }
    // The sums from the state of each particle, whose data are prefetched: particles are stored by cell. `from_flow`:
    // those of the velocities relative to the mean flow of a sheared box.
    ParticleSums<d> full_sums(bool from_flow) const {
        constexpr std::size_t ahead = 24;
        ParticleSums<d> sums;
        const std::vector<u32> place = particles_.in_original_order();
        for (std::size_t at = 0; at < place.size(); ++at) {
            const u32 i = place[at];
            particles_.fetch(place[std::min(at + ahead, place.size() - 1)]);
            double x[d], velocity[d], potential = 0.0;
            for (int k = 0; k < d; ++k)
                x[k] = particles_.position(i, k), velocity[k] = particles_.velocity(i, k);
            if (from_flow) velocity[0] -= box_.mean_flow(x);
            sums.add(particles_.mass(i), velocity);
            if (!particles_.setting.falls()) continue;
            const ImageMotion image = box_.image(particles_.image_flags[i], particles_.now);
            for (int k = 0; k < d; ++k) potential -= box_.gravity[k] * (x[k] + image.shift[k]);
            sums.add_potential(particles_.mass(i) * potential);
        }
        return sums;
    }
    void add_rotation(Observation& o) const {
        Sum energy, spin[3];
        for (const u32 i : particles_.in_original_order()) {
            const Spin& of = particles_.spins[i];
            energy.add(of.energy());
            for (int k = 0; k < 3; ++k) spin[k].add(of.velocity[k] / of.inverse_inertia);
        }
        o.rotational_energy = energy.value();
        for (int k = 0; k < 3; ++k) o.spin.component[k] = spin[k].value();
    }
    ParticleSums<d> present_sums(bool from_flow) const {
        if (!so_far.are_exact()) return full_sums(from_flow);
        Accumulators<d> present = so_far;
        present.advance(particles_.now);
        return from_flow ? present.from_flow : present.sums;
    }
};

}  // namespace hardlimit::boxes::spheres
