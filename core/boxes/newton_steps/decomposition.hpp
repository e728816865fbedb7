// Domain decomposition: bodies sorted into cells and slabs, and the neighbour list and contacts of each slab.
#pragma once
#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "../common/pair_laws.hpp"
#include "../neighbours/sorting.hpp"
#include "slab.hpp"

namespace hardlimit::boxes::steps {

template <class Law>
class Decomposition {
public:
    Bodies bodies;
    std::vector<Slab<Law>> slabs;
    CellLayers grid;
    // Sums over contacts up to the last list build.
    double dissipated = 0.0, friction_loss = 0.0, wall_work = 0.0, shear_work = 0.0;  // [J]
    SymmetricTensor virial;                                                           // [J s]
    WallSums given_to_walls;

    Decomposition(const Box& box, const PairLaws<Law>& laws, std::size_t n) : box_(box), sort_(n) {
        for (std::size_t i = 0; i < n; ++i) {
            const double width = 2.0 * laws.radius(i);
            widest_ = math::max(widest_, width);
            smallest_ = math::min(smallest_, width);
            mean_width_ += width / static_cast<double>(n);
            double part = math::pi / (box.dimension == 2 ? 4.0 : 6.0);
            for (int axis = 0; axis < box.dimension; ++axis) part *= width / box.edge[axis];
            packing_fraction_ += part;
        }
    }

    double skin() const { return skin_; }                   // [m]
    double smallest_diameter() const { return smallest_; }  // [m]
    // Bound on what the shear adds to the speeds of neighbours below [m/s].
    double strain_speed() const { return (0.5 + most_skin) * math::abs(box_.shear_rate) * widest_; }
    std::uint64_t lists_built() const { return lists_; }
    // Evaluated at the steps, in units of the smaller radius.
    double largest_compression() const {
        double largest = largest_compression_;
        for (const Slab<Law>& s : slabs) largest = math::max(largest, s.largest_compression);
        return largest;
    }

    // The stages of a rebuild, in the order of their calls. Functions that take a range of bodies or a slab may run on
    // several threads.
    void begin_rebuild(double fastest, double step, double time) {
        choose_skin(fastest, step);
        grid = CellLayers(box_, widest_ + skin_, bodies.count(), time);
        save_contacts();
        if (box_.is_sheared()) cross_sheared_side(time);
    }
    void find_cells(std::size_t first, std::size_t last, double time) {
        sort_.find_cells(box_, grid, bodies, first, last, time);
    }
    void order() { sort_.order(bodies, grid.cells(), start_); }
    void gather(std::size_t first, std::size_t last) { sort_.move(bodies, first, last); }
    void divide() {
        sort_.swap(bodies);
        restore_accelerations(bodies.acceleration, saved_accelerations_);
        if constexpr (FrictionalLaw<Law>)
            restore_accelerations(bodies.angular_acceleration, saved_angular_accelerations_);
        divide_into_slabs();
    }
    void list(Slab<Law>& slab, double time) {
        slab.pairs.clear(), slab.walls.clear();
        for (std::uint32_t cell = slab.first_cell; cell < slab.last_cell; ++cell)
            list_pairs(grid, bodies.position, start_, cell, skin_, slab.pairs);
        list_walls(box_, bodies.position, slab.first_body, slab.last_body, skin_, time, slab.walls);
        slab.contact_of_pair.assign(slab.pairs.size(), -1);
        slab.contact_of_wall.assign(slab.walls.size(), -1);
        sort_.index_by_original(bodies, slab.first_body, slab.last_body);
        std::copy(bodies.position.begin() + slab.first_body, bodies.position.begin() + slab.last_body,
                  sort_.reference().begin() + slab.first_body);
    }
    void restore_contacts(double time) {
        listed_at_ = time;
        for (const Contact<Law>& c : saved_contacts_) {
            const std::uint32_t i = sort_.where(static_cast<std::uint32_t>(c.first));
            if (c.second < 0) {
                restore_wall(c, i);
                continue;
            }
            const std::uint32_t j = sort_.where(static_cast<std::uint32_t>(c.second));
            if (!restore_pair(c, i, j, 1)) restore_pair(c, j, i, -1);
        }
        saved_contacts_.clear();
        ++lists_;
    }

    // Largest displacement since the list was built [m], and largest speed [m/s], of bodies and walls. In a sheared box
    // displacements w are relative to the mean flow at the place of the body when the list was built, and speeds c to
    // that at its present place.
    //
    // Two bodies that touch a time t after the list are then at most 2 w + γ̇ t (D + 2 w) nearer, for they were D + 2 w
    // apart along the gradient, D the largest diameter. As w grows by at most c + γ̇ w per time and 2 w is at most the
    // skin, c + γ̇ (D/2 + skin) bounds the growth of half the distance.
    struct Measurement {
        double farthest = 0.0, fastest = 0.0;
        bool finite = true;
    };
    void measure(Slab<Law>& slab, double time) {
        const Records<Double4>& from = sort_.reference();
        for (std::uint32_t i = slab.first_body; i < slab.last_body; ++i) {
            Double4 d = bodies.position[i] - from[i];
            const Double4 v = velocity_from_flow(box_, bodies, i);
            d[0] -= box_.mean_flow(from[i]) * (time - listed_at_);
            const double distance = dot(d, d), speed = dot(v, v);
            slab.farthest = distance <= slab.farthest ? slab.farthest : distance;  // keeps NaN
            slab.fastest = speed <= slab.fastest ? slab.fastest : speed;
        }
    }
    Measurement take_measurement(double time) {
        const double wall = box_.fastest_wall();
        Measurement m{wall * (time - listed_at_), wall};
        for (Slab<Law>& s : slabs) {
            m.finite = m.finite && s.farthest < math::infinity && s.fastest < math::infinity;
            m.farthest = math::max(m.farthest, math::sqrt(s.farthest));
            m.fastest = math::max(m.fastest, math::sqrt(s.fastest));
            s.farthest = s.fastest = 0.0;
        }
        m.farthest += strain_speed() * (time - listed_at_), m.fastest += strain_speed();
        return m;
    }
    // Original index of the fastest body, or of one whose state is not finite.
    i64 fastest_body() const {
        const auto square = [this](std::size_t i) {
            const Double4 v = velocity_from_flow(box_, bodies, i);
            const double speed = dot(v, v);
            const double distance = dot(bodies.position[i], bodies.position[i]);
            return distance < math::infinity && speed < math::infinity ? speed : math::infinity;
        };
        std::size_t fastest = 0;
        for (std::size_t i = 1; i < bodies.count(); ++i)
            if (square(i) > square(fastest)) fastest = i;
        return bodies.tag[fastest].original_index;
    }

    template <class Archive>
    void exchange(Archive& archive) {
        archive(bodies.position), archive(bodies.velocity), archive(bodies.tag), archive(bodies.acceleration);
        if constexpr (FrictionalLaw<Law>) archive(bodies.spin), archive(bodies.angular_acceleration);
        archive(sort_.reference()), archive(grid), archive(start_), archive(skin_), archive(lists_);
        archive(dissipated), archive(friction_loss), archive(wall_work), archive(shear_work), archive(virial);
        archive(largest_compression_);
        archive(listed_at_), archive(given_to_walls);
        std::size_t count = slabs.size();
        archive(count);
        slabs.resize(count);
        for (Slab<Law>& s : slabs) s.exchange(archive);
    }

private:
    static constexpr double most_skin = 0.3;  // in units of the mean diameter

    const Box& box_;
    CellSort sort_;
    std::vector<std::uint32_t> start_;  // [cells + 1] first body of each cell
    double widest_ = 0.0, mean_width_ = 0.0, smallest_ = math::infinity;  // diameters [m]
    double packing_fraction_ = 0.0;
    double skin_ = 0.0;
    std::uint64_t lists_ = 0;
    double listed_at_ = 0.0;                    // time of the last list build [s]
    double largest_compression_ = 0.0;          // up to the last list build
    std::vector<Contact<Law>> saved_contacts_;  // during a rebuild
    using SavedAccelerations = std::vector<std::pair<std::uint32_t, ContactAcceleration>>;
    SavedAccelerations saved_accelerations_, saved_angular_accelerations_;

    void choose_skin(double fastest, double step) {
        const double d = box_.dimension, dilute = 2.0 * d * packing_fraction_ / mean_width_;
        // First list: as in a fluid, where contacts are more frequent by the inverse of the free volume.
        double pairs_per_skin = dilute / math::pow(1.0 - math::min(packing_fraction_, 0.7), d);
        if (lists_ > 0) {
            std::size_t listed = 0;
            for (const Slab<Law>& s : slabs) listed += s.pairs.size();
            const double pairs = static_cast<double>(listed) / static_cast<double>(bodies.count());
            pairs_per_skin = math::max(pairs / skin_, dilute);
        }
        const double least = math::max(20.0 * fastest * step, 1e-3 * mean_width_);
        const double best = best_skin(pairs_per_skin, fastest, step);
        skin_ = math::min(math::max(best, least), most_skin * mean_width_);
    }
    // Saves the contacts and the accelerations of the last step, which outlive the list.
    void save_contacts() {
        largest_compression_ = largest_compression();
        for (Slab<Law>& s : slabs) {
            for (const Contact<Law>& c : s.contacts) {
                if (c.index_first == no_body) continue;
                saved_contacts_.push_back(c);
                // The pair may be listed in the other order than at the begin of the contact, to which restore_pair()
                // refers.
                if (bodies.tag[c.index_first].original_index != static_cast<std::uint32_t>(c.first))
                    reverse(saved_contacts_.back());
            }
            for (const auto* accelerated : {&s.accelerated, &s.accelerated_next})
                for (const std::uint32_t i : *accelerated) {
                    saved_accelerations_.push_back({i, bodies.acceleration[i]});
                    if constexpr (FrictionalLaw<Law>)
                        saved_angular_accelerations_.push_back({i, bodies.angular_acceleration[i]});
                }
            given_to_walls += s.given_to_walls;
            dissipated += s.dissipated, friction_loss += s.friction_loss;
            wall_work += s.wall_work, shear_work += s.shear_work;
            virial += s.virial;
        }
    }
    void restore_accelerations(Records<ContactAcceleration>& of, SavedAccelerations& saved) const {
        for (const auto& [body, a] : saved) of[body].step = 0;
        for (const auto& [body, a] : saved) of[sort_.where(body)] = a;
        saved.clear();
    }
    // Moves bodies that have left through a sheared side to their images in the box. By one thread, so that the work
    // has the same bits with any number of threads.
    void cross_sheared_side(double time) {
        const int axis = box_.gradient;
        for (std::size_t i = 0; i < bodies.count(); ++i) {
            Double4 &x = bodies.position[i], &v = bodies.velocity[i];
            auto& flags = bodies.tag[i].image_flags;
            for (const int step : {-1, 1}) {
                if (step < 0 ? x[axis] >= 0.0 : x[axis] < box_.edge[axis]) continue;
                const double before = v[0];
                box_.wrap(x, v, flags, axis, step, time);
                shear_work += gained_energy(1.0 / v[3], before, v[0] - before);
                const int turns = box_.turns(x[0], 0);
                x[0] -= turns * box_.edge[0], flags[0] += turns;
            }
        }
    }

    // Divides the layers of cells into slabs with about equal numbers of bodies. The number of slabs is even or one,
    // since with periodic boundaries the last slab reaches into the first.
    void divide_into_slabs() {
        const std::uint32_t layers = grid.layers(), in_layer = grid.cells_in_layer();
        const std::size_t n = bodies.count(), wanted = std::clamp<std::size_t>(n / 256, 2, most_slabs);
        const auto most = static_cast<std::uint32_t>(std::min<std::size_t>(layers, wanted));
        const std::uint32_t count = most < 2 ? 1 : most & ~1u;
        slabs.resize(count);
        std::uint32_t layer = 0;
        for (std::uint32_t k = 0; k < count; ++k) {
            Slab<Law>& s = slabs[k];
            s.clear(start_[layer * in_layer], layer * in_layer);
            const std::uint32_t last = layers - (count - 1 - k);
            for (++layer; layer < last && (k + 1 == count || start_[layer * in_layer] < n * (k + 1) / count);)
                ++layer;
            s.last_cell = layer * in_layer, s.last_body = start_[s.last_cell];
        }
    }

    Slab<Law>& slab_of(std::uint32_t body) {
        return *std::find_if(slabs.begin(), slabs.end(),
                             [&](const Slab<Law>& s) { return body < s.last_body; });
    }
    void restore_wall(const Contact<Law>& c, std::uint32_t body) {
        Slab<Law>& s = slab_of(body);
        const WallId wall = WallId::of(c.second);
        for (std::size_t k = 0; k < s.walls.size(); ++k)
            if (s.walls[k].body == body && s.walls[k].wall == wall) put(s, s.contact_of_wall[k], c);
    }
    // Returns whether the pair is listed as (i, j), where j is the second body of the contact if sense = 1, the first
    // if −1.
    bool restore_pair(const Contact<Law>& c, std::uint32_t i, std::uint32_t j, int sense) {
        Slab<Law>& s = slab_of(i);
        const auto before = [](const NeighbourPair& p, std::uint32_t body) { return p.first < body; };
        auto p = std::lower_bound(s.pairs.begin(), s.pairs.end(), i, before);
        for (; p != s.pairs.end() && p->first == i; ++p) {
            if (p->second() != j) continue;
            const auto image = grid.relative_image(*p, bodies.tag);
            bool same = true;
            for (std::size_t axis = 0; axis < 3; ++axis) same = same && image[axis] == sense * c.image[axis];
            if (!same) continue;
            put(s, s.contact_of_pair[static_cast<std::size_t>(p - s.pairs.begin())], c);
            if (sense < 0) reverse(s.contacts.back());
            return true;
        }
        return false;
    }
    // Exchanges the roles of the two bodies.
    static void reverse(Contact<Law>& c) {
        c.normal = -c.normal;
        if constexpr (FrictionalLaw<Law>) c.friction.reverse();
    }
    static void put(Slab<Law>& s, std::int32_t& slot, const Contact<Law>& c) {
        slot = static_cast<std::int32_t>(s.contacts.size());
        s.contacts.push_back(c);
    }
};

}  // namespace hardlimit::boxes::steps
