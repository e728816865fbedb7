// What every engine of a box offers, whatever its dimension, particles and rule.
#pragma once
#include <cstddef>
#include <memory>
#include <vector>

#include "../../base/outcome.hpp"
#include "../../base/stop.hpp"
#include "../hard_spheres/accumulators.hpp"
#include "../hard_spheres/rules/rules.hpp"
#include "../kernels/interface.hpp"

namespace hardlimit::boxes {

// A system as the user gives it: arrays of n, or n·d, row by row. Checked before an engine is made of it.
struct Setting {
    int dimension;
    std::size_t n;
    const double* position;  // [m], 0 ≤ x ≤ L
    const double* velocity;  // [m/s]
    const double* radius;    // [m]
    const double* mass;      // [kg]
    double edge[3];          // [m]
    bool periodic[3];
    double gravity[3];                           // [m/s²]
    const hardlimit_abi::TouchKernels* kernels;  // for the processor at hand
};

// Collisions in the order of time.
struct Log {
    std::vector<double> time;  // [s]
    std::vector<i64> first, second;
    std::vector<double> impact_speed, separation_speed;  // [m/s]
};

struct Observation {
    double kinetic_energy, potential_energy;  // [J]
    double momentum[3];                       // [kg m/s]
    double dissipated_energy;                 // by collisions so far [J]
    double virial;                            // Σ r·Δp of pair collisions so far [J s]
    double kinetic_integral;                  // ∫ Σ m v'² dt so far [J s]
};

struct Counts {
    i64 pairs, walls, elastic_by_tc, soft, soft_third_body;
};

// Of a run that ended before it was to: the collision at which it did.
struct EarlyEnd {
    double time;  // [s]; NaN of others
    i64 first, second;
};

class Engine {
public:
    virtual ~Engine() = default;

    // To `until` [s], or to the instant of row number `most_rows` of the log (0: no limit), or until `stop`.
    virtual void advance(double until, i64 most_rows, Stop& stop) = 0;
    virtual double time() const = 0;
    virtual i64 events() const = 0;  // since it was made or loaded: collisions, cell crossings, predictions
    virtual Counts counts() const = 0;
    virtual Outcome outcome() const = 0;
    virtual EarlyEnd early_end() const = 0;
    // Of all contacts so far as the law has them, over the smaller radius, with that at which the run ended; NaN
    // without a law or a collision.
    virtual double largest_compression() const = 0;
    // n·d values each, in the user's order; positions along continuous paths, not folded into the box.
    virtual void state(double* position, double* velocity) const = 0;
    virtual Observation observe() const = 0;
    virtual Log take_log() = 0;
    virtual std::vector<char> save() const = 0;
    virtual std::size_t bytes() const = 0;
    virtual int dimension() const = 0;
    virtual std::size_t size() const = 0;
};

}  // namespace hardlimit::boxes
