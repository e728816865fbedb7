// The interface of all engines that simulate a box of particles.
#pragma once
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "../../base/outcome.hpp"
#include "../../base/stop.hpp"
#include "box.hpp"
#include "symmetric_tensor.hpp"

namespace hardlimit::boxes {

// q of the moment of inertia q m R² of a solid sphere, in two dimensions of a disk.
constexpr double solid_inertia_factor(int dimension) { return dimension == 2 ? 0.5 : 0.4; }

// The user's input: box and particles. Arrays have n or n·d values, particle by particle.
struct System {
    Box box;
    std::size_t n = 0;
    const double* position = nullptr;  // [m], 0 ≤ x ≤ L
    const double* velocity = nullptr;  // [m/s]
    const double* radius = nullptr;    // [m]
    const double* mass = nullptr;      // [kg]
    // Only used with friction; nullptr: solid spheres or in two dimensions disks, which do not spin.
    const double* inertia_factor = nullptr;    // q of the moment of inertia q m R²
    const double* angular_velocity = nullptr;  // [rad/s], three components also in two dimensions

    double packing_fraction() const {
        double filled = 0.0;
        for (std::size_t i = 0; i < n; ++i)
            filled += (box.dimension == 3 ? 4.0 / 3.0 * radius[i] : 1.0) * math::pi * radius[i] * radius[i];
        return filled / box.volume();
    }
};

// In two dimensions only the third component, along the normal of the plane, may differ from 0.
struct AxialVector {
    double component[3] = {};
};

// Totals over the box at one instant. "So far" means since the start of the run.
struct Observation {
    double kinetic_energy = 0.0, potential_energy = 0.0;  // [J]
    double contact_energy = 0.0;                          // elastic, of all contacts [J]
    double momentum[3] = {};                              // [kg m/s]
    double dissipated_energy = 0.0;                       // so far, friction_loss included [J]
    // With friction, otherwise 0. The energy of a tangential spring is T²/(2 k_t), with the present k_t.
    double rotational_energy = 0.0;  // Σ I ω²/2 [J]
    double tangential_energy = 0.0;  // elastic, of all tangential springs; part of contact_energy [J]
    double friction_loss = 0.0;      // by the tangential forces, so far [J]
    AxialVector spin;                // Σ I ω [kg m²/s]
    SymmetricTensor kinetic_tensor;  // Σ m c⊗c [J], c the velocity relative to the mean flow of a sheared box
    double flow_momentum = 0.0;      // Σ m of that mean flow, along the first axis [kg m/s]
    double wall_work = 0.0;          // done by moving walls, so far [J]
    double shear_work = 0.0;         // done by a Lees–Edwards boundary, so far [J]
    WallSums walls;                  // so far
    SymmetricTensor virial;          // ∫ Σ r⊗F dt of pairs, Σ r⊗Δp of collisions, so far [J s]
    double kinetic_integral = math::nan;     // ∫ Σ m v'² dt so far [J s], v' relative to the mean
    double largest_compression = math::nan;  // in units of the smaller radius, so far; NaN without a law
    u64 begun = 0, pairs = 0;                // contacts so far; of these, contacts of two particles
    u64 ended = 0, overlapped = 0;  // ended contacts; of these, contacts that shared a particle with another
    u64 in_contact = 0;             // contacts at present
};

// Engines that sample a field of Observation: all, those of collisions, those of contacts that take time; these with
// friction only; none: its value at the end of a run matters.
enum class Sampled { by_all, of_collisions, of_contacts, with_friction, of_contacts_with_friction, never };

// Calls f(name, unit, engines, value) for each field of an observation, under the names of Python.
template <class F>
void for_fields(const Observation& o, const F& f) {
    using enum Sampled;
    f("kinetic_energy", "J", by_all, o.kinetic_energy);
    f("potential_energy", "J", by_all, o.potential_energy);
    f("contact_energy", "J", of_contacts, o.contact_energy);
    f("momentum", "kg m/s", by_all, o.momentum);
    f("dissipated_energy", "J", by_all, o.dissipated_energy);
    f("rotational_energy", "J", with_friction, o.rotational_energy);
    f("tangential_energy", "J", of_contacts_with_friction, o.tangential_energy);
    f("friction_loss", "J", with_friction, o.friction_loss);
    f("spin", "kg m2/s", with_friction, o.spin);
    f("kinetic_tensor", "J", by_all, o.kinetic_tensor);
    f("virial_tensor", "J s", by_all, o.virial);
    f("flow_momentum", "kg m/s", by_all, o.flow_momentum);
    f("wall_work", "J", by_all, o.wall_work);
    f("shear_work", "J", by_all, o.shear_work);
    f("wall_impulse", "N s", by_all, o.walls.impulse);
    f("wall_energy", "J", by_all, o.walls.energy);
    f("kinetic_integral", "J s", of_collisions, o.kinetic_integral);
    f("largest_compression", "1", never, o.largest_compression);
    f("n_contacts", "1", of_contacts, o.begun);
    f("n_pairs", "1", by_all, o.pairs);
    f("n_ended", "1", of_contacts, o.ended);
    f("n_overlapped", "1", of_contacts, o.overlapped);
    f("n_in_contact", "1", of_contacts, o.in_contact);
}

// Changes the velocity of a particle at x to that of its image in a sheared box, and adds the work that this takes. A
// particle may be beyond the side before its path is continued from the other one. Returns the mean flow there [m/s], 0
// without shear.
template <class Position, class Velocity>
double to_image_in_box(const Box& box, Observation& sums, double mass, Position x, Velocity& v) {
    if (!box.is_sheared()) return 0.0;
    const auto axis = static_cast<std::size_t>(box.gradient);
    const int crossed = box.turns(x[axis], box.gradient);
    x[axis] -= crossed * box.edge[box.gradient];
    const double change = -crossed * box.image_velocity(), flow = box.mean_flow(x);
    sums.shear_work += gained_energy(mass, v[0], change);
    sums.flow_momentum += mass * flow;
    v[0] += change;
    return flow;
}

// One row of the log. A collision of hard spheres begins and ends at the same instant.
struct ContactRecord {
    double begin, end;                      // [s]; end is NaN while the contact is open
    std::int32_t first, second;             // particle; particle or wall (WallId)
    double impact_speed, separation_speed;  // [m/s]; NaN where not known
    bool overlapped;                        // a body had another contact at the same time
    // With friction, at the begin: tangential speed of the surfaces [m/s], and β = −(that after)/(that before), along
    // the direction before.
    bool slid = false;  // the surfaces have slipped
    double tangential_speed = math::nan, tangential_restitution = math::nan;
};

// A named performance figure of an engine.
struct Statistic {
    const char* name;
    double value;
};

// Time and particles at which a run stopped early.
struct EarlyEnd {
    double time = math::nan;     // [s]
    std::vector<i64> particles;  // of the contact or cluster, or the one that moved too fast; ascending
    WallId wall;                 // of the contact, if any
};

// Kicks of a thermostat so far.
struct Kicks {
    u64 number = 0;
    double heat = 0.0;  // energy gained [J]
};

class Engine {
public:
    virtual ~Engine() = default;

    // Advances to `until` [s]. Pauses after `most_work` units of work (collisions, events or steps, depending on the
    // engine), or when `stop` returns true. A second call with the same `until` continues bit for bit. `threads`
    // matters only to engines that use several.
    virtual void advance(double until, u64 most_work, int threads, Stop& stop) = 0;
    virtual bool paused() const = 0;
    virtual double time() const = 0;  // [s]
    virtual Outcome outcome() const = 0;
    virtual EarlyEnd early_end() const = 0;  // if the outcome is not ok

    // Counters, read without computation: work done, contacts begun, rows logged.
    virtual u64 work() const = 0;
    virtual u64 contacts() const = 0;
    virtual u64 logged() const = 0;
    virtual std::vector<Statistic> statistics() const = 0;

    // Whether contacts have friction, so that particles have spins.
    virtual bool rotates() const { return false; }

    // Gives all particles new velocities now, as a thermostat does: n·d values in the user's order, as state() gives
    // them; and new spins as spins() gives them, unless they are nullptr. Contacts go on. Not during a pause.
    // Returns the energy [J] of particles that it lifts off walls.
    virtual double set_velocities(const double* velocity, const double* spin) = 0;
    // The same, and counts it at once: an interrupt never comes between a kick and its count.
    void kick(const double* velocity, const double* spin, double heat) {
        const double lifted = set_velocities(velocity, spin);
        ++kicks.number;
        kicks.heat += heat + lifted;
    }
    Kicks kicks;  // not part of save()

    // Writes n·d values each, in the user's order: those of the unfolded paths, with Box::image() added to both.
    virtual void state(double* position, double* velocity) const = 0;
    // Writes the angular velocities [rad/s], three of each particle also in two dimensions, if the engine rotates.
    virtual void spins(double* /*spin*/) const {}
    virtual Observation observe() const = 0;
    virtual bool contacts_have_duration() const = 0;    // whether contacts take time; false: collisions
    virtual std::vector<ContactRecord> take_log() = 0;  // rows since the last call
    virtual std::vector<ContactRecord> open_contacts() const = 0;  // contacts that are not logged yet
    // For tests: the largest part of a safety radius that a body in contact uses, now and at `instants` later times; at
    // most 1.
    virtual double largest_safety_use(int /*instants*/) const { return 0.0; }

    virtual std::vector<char> save() const = 0;
    virtual std::size_t bytes() const = 0;  // memory used, approximately
    virtual int dimension() const = 0;
    virtual std::size_t size() const = 0;
};

}  // namespace hardlimit::boxes
