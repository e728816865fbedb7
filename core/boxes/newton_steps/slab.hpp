// A slab of bodies: its neighbour list, its contacts, and the output of a sweep over its pairs.
#pragma once
#include <cstdint>
#include <vector>

#include "../common/symmetric_tensor.hpp"
#include "../neighbours/neighbour_list.hpp"
#include "contacts.hpp"

namespace hardlimit::boxes::steps {

inline constexpr std::uint32_t most_slabs = 128;

struct Impulse {
    std::uint32_t body;
    Double4 velocity_change;  // [m/s]
};

template <class Law>
struct alignas(64) Slab {
    std::uint32_t first_body, last_body, first_cell, last_cell;
    std::vector<NeighbourPair> pairs;
    std::vector<WallNeighbour> walls;
    std::vector<std::int32_t> contact_of_pair, contact_of_wall;  // index in contacts, −1: none
    std::vector<Contact<Law>> contacts;
    std::vector<std::int32_t> free_slots,
        freed_slots;  // slots of contacts that are free, and free after this step
    std::vector<std::uint32_t> accelerated,
        accelerated_next;           // bodies in contact, of this slab and of the next one
    std::vector<Impulse> impulses;  // on bodies of both
    std::vector<Impulse> turns;     // changes of their angular velocities [rad/s]; only with friction
    std::vector<ContactEvent> events;
    double dissipated = 0.0, friction_loss = 0.0, wall_work = 0.0,
           shear_work = 0.0;               // since the list was built [J]
    WallSums given_to_walls;               // since the list was built
    SymmetricTensor virial;                // ∫ Σ r⊗F dt of pairs, since the list was built [J s]
    double farthest = 0.0, fastest = 0.0;  // squares, relative to the mean flow [m²], [m²/s²]
    double largest_compression = 0.0;      // in units of the smaller radius, since the list was built
    std::int32_t deepest[2] = {-1, -1};    // its contact: first and second as in ContactBegin

    bool holds(std::uint32_t body) const { return body >= first_body && body < last_body; }
    void clear_step() { accelerated.clear(), accelerated_next.clear(), impulses.clear(), turns.clear(); }
    void clear(std::uint32_t of_bodies, std::uint32_t of_cells) {
        first_body = of_bodies, first_cell = of_cells;
        contacts.clear(), free_slots.clear(), freed_slots.clear(), events.clear();
        clear_step();
        dissipated = friction_loss = wall_work = shear_work = farthest = fastest = largest_compression = 0.0;
        virial = {};
        given_to_walls = {};
    }
    template <class Archive>
    void exchange(Archive& archive) {
        archive(first_body), archive(last_body), archive(first_cell), archive(last_cell);
        archive(pairs), archive(walls), archive(contact_of_pair), archive(contact_of_wall);
        archive(contacts), archive(free_slots), archive(accelerated), archive(accelerated_next);
        archive(dissipated), archive(friction_loss), archive(wall_work), archive(shear_work), archive(virial);
        archive(given_to_walls), archive(largest_compression), archive(deepest);
    }
};

}  // namespace hardlimit::boxes::steps
