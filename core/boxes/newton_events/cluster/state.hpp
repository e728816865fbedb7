// The state vector of a cluster.
#pragma once
#include <array>
#include <vector>

#include "network.hpp"

namespace hardlimit::boxes {

// Working storage that is not copied with its owner.
template <class T>
struct WorkVector : std::vector<T> {
    WorkVector() = default;
    WorkVector(const WorkVector&) : std::vector<T>() {}
    WorkVector& operator=(const WorkVector&) { return *this; }
    WorkVector(WorkVector&&) noexcept : std::vector<T>() {}
    WorkVector& operator=(WorkVector&&) noexcept { return *this; }
    ~WorkVector() = default;
};

// Index of each quantity in the state vector: positions and velocities [3 a member], time, dissipated energy, work of
// walls and work of images if any moves; with friction the work of tangential forces, spins [3 a member] and what the
// surfaces of pairs keep [4 a pair]; the s of each rooted pair, the virial, and impulse and energy of each wall of the
// pairs. Nothing depends on the components from virial() on.
class StateLayout {
public:
    template <class Law>
    void assign(const ContactNetwork<Law>& network) {
        members_ = static_cast<int>(network.members.size());
        surfaces_ = FrictionalLaw<Law> ? static_cast<int>(network.pairs.size()) : 0;
        rubs_ = FrictionalLaw<Law>;
        walls_move_ = !network.wall_pieces.empty();
        images_move_ = false;
        wall_slot_.fill(-1);
        walls_ = 0;
        rooted_.clear();
        for (std::size_t k = 0; k < network.pairs.size(); ++k) {
            const ContactPair<Law>& q = network.pairs[k];
            walls_move_ = walls_move_ || q.wall_velocity != 0.0;
            images_move_ = images_move_ || q.image_moves;
            if (q.second < 0 && wall_slot_[q.wall_id.index()] < 0) wall_slot_[q.wall_id.index()] = walls_++;
            if (q.rooted) rooted_.push_back(static_cast<int>(k));
        }
        root_.assign(network.pairs.size(), -1);
        set_roots();
    }
    // Changes the pairs whose s is a component.
    void choose_roots(const std::vector<int>& pairs) {
        rooted_.assign(pairs.begin(), pairs.end());
        set_roots();
    }

    int members() const { return members_; }
    int position(int member) const { return 3 * member; }
    int velocity(int member) const { return 3 * (members_ + member); }
    int time() const { return 6 * members_; }
    int loss() const { return time() + 1; }
    int wall_work() const { return time() + 2; }                            // if walls move
    int shear_work() const { return wall_work() + (walls_move_ ? 1 : 0); }  // if images move
    int rubbed() const {
        return shear_work() + (images_move_ ? 1 : 0);
    }  // with friction, as all up to first_root()
    int spin(int member) const { return rubbed() + 1 + 3 * member; }
    int surface(int pair) const { return spin(members_) + 4 * pair; }
    int first_root() const { return rubs_ ? surface(surfaces_) : rubbed(); }
    int root(int pair) const { return root_[pair]; }
    int virial() const { return first_root() + static_cast<int>(rooted_.size()); }
    int wall_sums() const { return virial() + static_cast<int>(SymmetricTensor::size); }
    int wall_sums(WallId wall) const { return wall_sums() + 2 * wall_slot_[wall.index()]; }
    int size() const { return wall_sums() + 2 * walls_; }

    bool walls_move() const { return walls_move_; }
    bool images_move() const { return images_move_; }
    int walls() const { return walls_; }  // of the pairs
    const std::vector<int>& rooted() const { return rooted_; }

private:
    void set_roots() {
        for (std::size_t i = 0; i < rooted_.size(); ++i)
            root_[rooted_[i]] = first_root() + static_cast<int>(i);
    }

    int members_ = 0, walls_ = 0, surfaces_ = 0;
    bool rubs_ = false, walls_move_ = false, images_move_ = false;
    std::array<int, most_walls> wall_slot_{};  // place of each wall among those of the pairs, or −1
    WorkVector<int> rooted_;                   // pairs whose s is a component, in the order of the state
    WorkVector<int> root_;                     // [pairs] index of s
};

// A contact network at a state y.
template <class Law>
struct Snapshot {
    using Pair = ContactPair<Law>;

    const ContactNetwork<Law>& network;
    const StateLayout& layout;
    const double* y;

    double time() const { return y[layout.time()]; }
    ContactGeometry geometry(const Pair& q) const {
        return network.geometry(q, y + layout.position(q.first), y + layout.velocity(q.first),
                                y + layout.position(q.second), y + layout.velocity(q.second), time());
    }
    // The s of a pair.
    double depth_root(int pair, const ContactGeometry& g) const {
        return network.pairs[pair].rooted ? y[layout.root(pair)] : onset_root<Law::onset_power>(g.depth);
    }
    // Of two bodies [m²/s²].
    double relative_speed_squared(const Pair& q) const {
        const double *va = y + layout.velocity(q.first), *vb = y + layout.velocity(q.second);
        double sum = 0.0;
        for (std::size_t a = 0; a < 3; ++a) {
            double v = vb[a] - va[a];
            if (q.image_moves) v += q.image_velocity[a];
            sum += v * v;
        }
        return sum;
    }
};

// The present state of a contact network as a vector.
class StateVector {
public:
    StateLayout layout;
    WorkVector<double> y;

    template <class Law>
    void load(const ContactNetwork<Law>& network, const Ledger& ledger) {
        layout.assign(network);
        y.assign(static_cast<std::size_t>(layout.size()), 0.0);
        for (int i = 0; i < layout.members(); ++i) {
            std::ranges::copy(network.members[i].position, &y[layout.position(i)]);
            std::ranges::copy(network.members[i].velocity, &y[layout.velocity(i)]);
        }
        y[layout.time()] = network.time;
        y[layout.loss()] = ledger.dissipated;
        if (layout.walls_move()) y[layout.wall_work()] = ledger.wall_work;
        if (layout.images_move()) y[layout.shear_work()] = ledger.shear_work;
        if constexpr (FrictionalLaw<Law>) load_surfaces(network, ledger);
        for (const int q : layout.rooted()) y[layout.root(q)] = network.pairs[q].s;
        std::ranges::copy(ledger.virial.component, &y[layout.virial()]);
        for (const ContactPair<Law>& q : network.pairs) {
            if (q.second >= 0) continue;
            y[layout.wall_sums(q.wall_id)] = ledger.walls.impulse[q.wall_id.index()];
            y[layout.wall_sums(q.wall_id) + 1] = ledger.walls.energy[q.wall_id.index()];
        }
    }
    template <class Law>
    void store(ContactNetwork<Law>& network, Ledger& ledger) const {
        for (int i = 0; i < layout.members(); ++i) {
            std::copy_n(&y[layout.position(i)], 3, network.members[i].position.begin());
            std::copy_n(&y[layout.velocity(i)], 3, network.members[i].velocity.begin());
        }
        ledger.dissipated = y[layout.loss()];
        if (layout.walls_move()) ledger.wall_work = y[layout.wall_work()];
        if (layout.images_move()) ledger.shear_work = y[layout.shear_work()];
        if constexpr (FrictionalLaw<Law>) store_surfaces(network, ledger);
        for (const int q : layout.rooted()) network.pairs[q].s = y[layout.root(q)];
        std::copy_n(&y[layout.virial()], SymmetricTensor::size, ledger.virial.component);
        for (const ContactPair<Law>& q : network.pairs) {
            if (q.second >= 0) continue;
            ledger.walls.impulse[q.wall_id.index()] = y[layout.wall_sums(q.wall_id)];
            ledger.walls.energy[q.wall_id.index()] = y[layout.wall_sums(q.wall_id) + 1];
        }
    }

    double& time() { return y[layout.time()]; }
    double time() const { return y[layout.time()]; }
    template <class Law>
    Snapshot<Law> at(const ContactNetwork<Law>& network) const {
        return {network, layout, y.data()};
    }
    // Adds energy that is dissipated in a pair, or taken back if negative.
    template <class Law>
    void add_loss(const ContactPair<Law>& q, double energy) {
        y[layout.loss()] += energy;
        if (q.second < 0) y[layout.wall_sums(q.wall_id) + 1] += energy;
    }
    // Makes the s of these pairs components, and no other.
    template <class Law>
    void choose_roots(ContactNetwork<Law>& network, const std::vector<int>& chosen) {
        const Snapshot<Law> before = at(network);
        WorkVector<double> changed;
        changed.assign(y.begin(), y.begin() + layout.first_root());
        for (const int q : chosen) changed.push_back(before.depth_root(q, before.geometry(network.pairs[q])));
        changed.insert(changed.end(), y.begin() + layout.virial(), y.end());
        for (ContactPair<Law>& q : network.pairs) q.rooted = false;
        for (const int q : chosen) network.pairs[q].rooted = true;
        layout.choose_roots(chosen);
        y.swap(changed);
    }

private:
    template <class Law>
    void load_surfaces(const ContactNetwork<Law>& network, const Ledger& ledger) {
        y[layout.rubbed()] = ledger.rubbed;
        for (int i = 0; i < layout.members(); ++i)
            std::ranges::copy(network.rotations[i].spin, &y[layout.spin(i)]);
        for (int q = 0; q < static_cast<int>(network.pairs.size()); ++q)
            std::ranges::copy(network.pairs[q].surfaces.memory, &y[layout.surface(q)]);
    }
    template <class Law>
    void store_surfaces(ContactNetwork<Law>& network, Ledger& ledger) const {
        ledger.rubbed = y[layout.rubbed()];
        for (int i = 0; i < layout.members(); ++i)
            std::copy_n(&y[layout.spin(i)], 3, network.rotations[i].spin.begin());
        for (int q = 0; q < static_cast<int>(network.pairs.size()); ++q)
            std::copy_n(&y[layout.surface(q)], 3, network.pairs[q].surfaces.memory.begin());
    }
};

}  // namespace hardlimit::boxes
