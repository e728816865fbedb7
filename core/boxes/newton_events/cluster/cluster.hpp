// Newton's equations for a few spheres or disks whose contacts overlap in time, under any contact law:
//   m_i dv_i/dt = Σ_j F_ij n_ij + m_i g,   F = force(s, dξ/dt) while the contact is closed, otherwise 0,
//   ξ = s^p = R_i + R_j − |r_ij|  (at a wall: R_i − distance of the centre),   dξ/dt = −n·(v_j − v_i).
// The method is that of columns (column/general/motions.hpp): integration of order 8 in a scaled time
// (contact/smooth_time.hpp). Every begin and end of a contact is located within its step (contact/events.hpp). The s of
// a closed contact is integrated together with the positions. A closed pair that reaches the largest compression of its
// law (deepest_compression) ends the run of the cluster. Under a linear law a step is a power series (linear.hpp), and
// events are zeros of polynomials.
//
// A pair is `fresh` if an event has just occurred, so that an event function is zero. The function is ignored until it
// has become positive; a negative value while it rises is rounding error.
#pragma once
#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "../../../base/dormand_prince.hpp"
#include "../../../base/stop.hpp"
#include "../../../contact/events.hpp"
#include "../../../contact/smooth_time.hpp"
#include "../../binary_contact/planar_contact.hpp"
#include "../../kernels/power_series.hpp"
#include "records.hpp"

namespace hardlimit::boxes {

inline constexpr long no_limit = std::numeric_limits<long>::max();

template <class Law>
class Cluster {
    static_assert(FrictionlessLaw<Law>);

public:
    static constexpr int p = Law::onset_power;

    std::vector<Member> members;
    std::vector<ContactPair<Law>> pairs;
    std::vector<WallPiece>
        wall_pieces;  // present pieces by −1 − number of the wall; empty if no wall oscillates
    Vector3 gravity{};
    double largest_coordinate = 0.0;  // largest edge of the box, for the rounding error of positions [m]
    const hardlimit_abi::SeriesKernels* kernels = nullptr;  // needed for a linear law
    double base = 0.0;                                      // absolute time at time = 0 [s]
    double time = 0.0;                                      // since `base` [s]
    double dissipated = 0.0;   // including the elastic energy that slack pairs still store [J]
    SymmetricTensor virial;    // ∫ Σ r⊗F dt over pairs of bodies [J s]
    double wall_work = 0.0;    // done by moving walls [J]
    WallSums walls;            // as `dissipated`, with the energy that slack pairs still store
    double shear_work = 0.0;   // done on pairs whose image moves [J]
    double tolerance = 1e-11;  // of a step, relative to the units of length, speed and time
    bool record = false;       // whether to keep the trajectory
    std::vector<EndedContact> ended;
    Trajectory trajectory;
    bool unresolved = false;
    int too_deep = -1;                 // pair that reached the largest compression of its law
    double largest_compression = 0.0;  // in units of the smaller radius, including earlier clusters
    long begun = 0, begun_pairs = 0;   // contacts since the start; of these, between two bodies

    // Resets everything but keeps the allocated storage.
    void clear() {
        members.clear();
        pairs.clear();
        wall_pieces.clear();
        ended.clear();
        trajectory.clear();
        base = time = dissipated = wall_work = shear_work = largest_compression = 0.0;
        virial = {};
        walls = {};
        too_deep = -1;
        record = unresolved = known_ = false;
        begun = begun_pairs = steps_ = 0;
        h_ = 0.0;
    }

    // Integrates to `until`, or until the last pair opens, or for `most_steps` steps.
    void run(double until, Stop& stop, long most_steps = no_limit) { run(until, stop, most_steps, false); }

    // Integrates to `until` even if all pairs open before. If one pair opens at the instant at which another begins,
    // their order depends on rounding, and may differ if steps end elsewhere.
    void run_through(double until) {
        Stop never;
        run(until, never, no_limit, true);
    }

    // Moves the members to this time, also backward, while no contact begins or ends. Needs a linear law. Returns false
    // if that takes more than a few steps.
    bool move_to(double end);

    long steps() const { return steps_; }

    // Rate of approach of a pair [m/s].
    double rate(const ContactPair<Law>& q) const { return geometry_of_members(q).rate; }

    // Distance between the surfaces of a pair [m].
    double gap(const ContactPair<Law>& q) const { return -geometry_of_members(q).depth; }

    // Upper bound on a member's speed relative to the others, or to walls if one may be touched [m/s].
    double speed() const { return unit_of_speed(); }
    // The largest velocity of an image of a pair [m/s].
    double image_speed() const {
        double most = 0.0;
        for (const ContactPair<Law>& q : pairs)
            if (q.image_moves) most = math::max(most, math::sqrt(dot(q.image_velocity, q.image_velocity)));
        return most;
    }

    bool near_a_wall() const {
        return std::any_of(pairs.begin(), pairs.end(), [](const auto& q) { return q.second < 0; });
    }

    // Velocity to which speeds are relative: of the centre of mass, or near walls that of the walls [m/s].
    Vector3 frame_velocity() const;

    // Elastic energy of the pairs in this state, closed or slack [J].
    double stored(ContactState state) const {
        double sum = 0.0;
        for (const ContactPair<Law>& pair : pairs)
            if (pair.state == state) sum += pair.law.energy(math::max(depth_root(pair), 0.0));
        return sum;
    }

    // `walls` without the energy that slack pairs still store.
    WallSums given_to_walls() const {
        WallSums given = walls;
        for (const ContactPair<Law>& q : pairs)
            if (q.second < 0 && q.state == ContactState::slack)
                given.add(q.wall_id, 0.0, -q.law.energy(math::max(depth_root(q), 0.0)));
        return given;
    }

private:
    // Speed below which squares underflow: the bodies do not move [m/s].
    static constexpr double at_rest = 1e-150;
    // Smallest compression that the positions resolve, relative to the contact distance.
    static constexpr double resolved_depth = 1e-12;

    using Event = ContactEvent;
    struct StepEvent {  // the first event in a step of a series
        double at;      // in units of the series
        Event what = Event::none;
        int which = 0;
    };
    struct Geometry {
        double depth, rate, distance;
        Vector3 normal;  // from the first body to the second
    };

    // Working storage that is not copied with the cluster.
    template <class T>
    struct Scratch : std::vector<T> {
        Scratch() = default;
        Scratch(const Scratch&) : std::vector<T>() {}
        Scratch& operator=(const Scratch&) { return *this; }
        Scratch(Scratch&&) noexcept : std::vector<T>() {}
        Scratch& operator=(Scratch&&) noexcept { return *this; }
        ~Scratch() = default;
    };

    Scratch<double> y_, k_, end_, k_end_, trial_, k_trial_, tolerance_;
    mutable Scratch<double> stages_, factor_;
    Scratch<series::Path> series_;  // [members]
    Scratch<double> travel_;        // [members] largest distance covered within a step
    Scratch<int> body_order_;       // [members] those in contact, then the others
    Scratch<char> is_ordered_;      // [members]
    int in_contact_ = 0;            // number of members in contact
    Scratch<series::Contact> contacts_;
    Scratch<int> rooted_;                      // pairs whose s is a component, in the order of the state
    Scratch<int> slot_;                        // [pairs] index of s in the state
    bool known_ = false;                       // whether k_ is the derivative of y_
    std::array<int, most_walls> wall_slot_{};  // place of each wall among those of the pairs, or −1
    int touched_walls_ = 0;                    // number of the walls of the pairs
    bool walls_move_ = false;            // whether a wall of a pair moves: the state then holds wall_work
    bool images_move_ = false;           // whether the image of a pair moves: the state then holds shear_work
    bool integrates_ = !LinearLaw<Law>;  // whether steps are integrated; otherwise they are power series
    bool sine_ = false;                  // whether a wall of a pair moves as a sine
    double h_ = 0.0, speed_unit_ = 0.0, lightest_ = 0.0;
    double step_ = 0.0;  // of the series, in its unit, at most 1
    long steps_ = 0;

    int count() const { return static_cast<int>(members.size()); }
    int time_index() const { return 6 * count(); }
    int loss_index() const { return 6 * count() + 1; }
    int wall_work_index() const { return 6 * count() + 2; }
    bool integrates() const { return (boxes_move || !LinearLaw<Law>) && integrates_; }
    int shear_work_index() const { return 6 * count() + 2 + (walls_move_ ? 1 : 0); }
    int first_root_index() const { return shear_work_index() + (images_move_ ? 1 : 0); }
    // The virial stands behind the others, and what each wall of the pairs gets (impulse, energy) last: nothing depends
    // on them.
    int virial_index() const { return first_root_index() + static_cast<int>(rooted_.size()); }
    int wall_sums_index() const { return virial_index() + static_cast<int>(SymmetricTensor::size); }
    int wall_sums_index(WallId wall) const { return wall_sums_index() + 2 * wall_slot_[wall.index()]; }
    int dimension() const { return wall_sums_index() + 2 * touched_walls_; }
    template <class F>
    void for_touched_walls(const F& f) const {
        for (std::size_t k = 0; k < most_walls; ++k)
            if (wall_slot_[k] >= 0) f(k, wall_sums_index() + 2 * wall_slot_[k]);
    }
    // Adds energy that is dissipated in a pair, or taken back if negative.
    void add_loss(const ContactPair<Law>& q, double energy) {
        y_[loss_index()] += energy;
        if (q.second < 0) y_[wall_sums_index(q.wall_id) + 1] += energy;
    }

    bool all(ContactState state) const {
        return std::all_of(pairs.begin(), pairs.end(), [&](const auto& q) { return q.state == state; });
    }
    bool any(ContactState state) const {
        return std::any_of(pairs.begin(), pairs.end(), [&](const auto& q) { return q.state == state; });
    }

    void run(double until, Stop& stop, long most_steps, bool through);

    // state.hpp
    const WallPiece& piece(const ContactPair<Law>& q) const { return wall_pieces[q.wall_id.index()]; }
    double wall_position(const ContactPair<Law>& q, double t) const {
        return wall_pieces.empty() ? q.wall_position(t) : piece(q).position(t);
    }
    double wall_velocity(const ContactPair<Law>& q, double t) const {
        return wall_pieces.empty() ? q.wall_velocity : piece(q).velocity(t);
    }
    double wall_acceleration(const ContactPair<Law>& q, double t) const {
        return wall_pieces.empty() ? 0.0 : piece(q).acceleration(t);
    }
    double end_of_pieces(double until);
    void load_state();
    void resize();
    void store_state();
    void record_state();
    double lightest() const;
    double unit_of_speed() const;
    double energy_unit() const { return 0.5 * lightest_ * speed_unit_ * speed_unit_; }
    double time_unit() const;
    double most_energy() const;
    void set_scales(ContactPair<Law>& q) const;
    double smaller_radius(const ContactPair<Law>& q) const {
        const double first = members[static_cast<std::size_t>(q.first)].radius;
        return q.second < 0 ? first : math::min(first, members[static_cast<std::size_t>(q.second)].radius);
    }
    void record_compression(const ContactPair<Law>& q, double depth) {
        largest_compression = math::max(largest_compression, depth / smaller_radius(q));
    }
    Geometry geometry(const ContactPair<Law>& q, const double* y) const {
        const double *xa = y + 3 * q.first, *va = y + 3 * (count() + q.first);
        if (q.second < 0) return wall_geometry(q, xa, va, y[time_index()]);
        return geometry(q, xa, va, y + 3 * q.second, y + 3 * (count() + q.second), y[time_index()]);
    }
    Geometry geometry_of_members(const ContactPair<Law>& q) const {
        const Member& a = members[static_cast<std::size_t>(q.first)];
        if (q.second < 0) return wall_geometry(q, a.position.data(), a.velocity.data(), time);
        const Member& b = members[static_cast<std::size_t>(q.second)];
        return geometry(q, a.position.data(), a.velocity.data(), b.position.data(), b.velocity.data(), time);
    }
    inline Geometry wall_geometry(const ContactPair<Law>& q, const double* x, const double* v,
                                  double t) const;
    static inline Geometry geometry(const ContactPair<Law>& q, const double* xa, const double* va,
                                    const double* xb, const double* vb, double t);
    // s of a pair, from the members or from a state y.
    double depth_root(const ContactPair<Law>& q) const;
    double depth_root(int q, const Geometry& g, const double* y) const {
        return pairs[static_cast<std::size_t>(q)].rooted ? y[slot_[static_cast<std::size_t>(q)]]
                                                         : onset_root<p>(g.depth);
    }

    // integrate.hpp
    struct Equations {
        const Cluster* cluster;
        void operator()(const double* y, double* dy) const { cluster->derivative(y, dy); }
    };
    double clock_rate(const double* y) const;
    void derivative(const double* y, double* dy) const;
    void advance(double length, double* out) const {
        std::copy(k_.begin(), k_.end(), stages_.begin());
        DormandPrince::step(Equations{this}, y_.data(), length, dimension(), stages_.data(), out,
                            virial_index());
    }
    void probe(double at) {
        advance(at, trial_.data());
        derivative(trial_.data(), k_trial_.data());
    }
    void choose_coordinates();
    void rearrange(const std::vector<int>& chosen);
    void integration_step(double until);
    bool try_step(double length, bool last);
    void end_step(double until, double length, bool last);
    void record_compressions(double length);
    bool ends_within_rounding();
    double shorten_to_time(double until, double length);
    void set_tolerance(double length);

    // linear.hpp
    void series_step(double until);
    double series_unit() const;
    double event_value(const ContactPair<Law>& q, Event kind) const;
    bool lies_on_surface(const ContactPair<Law>& q) const;
    void expand_series(double unit);
    void add_contact(int index, double unit);
    void expand_wall(const ContactPair<Law>& q, double unit, series::Terms& wall) const;
    double longest_step() const;
    void predict_end(const series::Contact& f, StepEvent& found) const;
    void predict_deepest(const series::Contact& f, StepEvent& found) const;
    void record_compressions(const series::Contact& f, double at);
    void open_pairs(StepEvent& found);
    void order_bodies();
    void predict_begins(double unit, StepEvent& found);
    void predict_begin(int index, double unit, StepEvent& found);
    void consider(int index, Event kind, const series::Terms& f, double unit, StepEvent& found) const;
    static double work_on_wall(const series::Contact& f, double at);
    void advance_series(double at, double unit);
    std::array<double, 4> gravity4() const { return {gravity[0], gravity[1], gravity[2], 0.0}; }

    // flight.hpp
    void rest_until(double until);
    void fly(double until);
    // d(rate)/dt of a body in flight and a wall.
    double approach_acceleration(const ContactPair<Law>& q) const {
        if (q.second >= 0) return 0.0;
        const double wall = wall_acceleration(q, y_[time_index()]);
        return -q.side * (gravity[static_cast<std::size_t>(q.axis)] - wall);
    }
    bool is_pressed(const ContactPair<Law>& q) const;
    double time_to_touch(const ContactPair<Law>& q) const;
    double time_to_open(const ContactPair<Law>& q) const;
    double time_to_engage(const ContactPair<Law>& q) const;
    double relative_speed_squared(const ContactPair<Law>& q, const double* y) const;

    // events.hpp
    static std::array<Event, 2> events_of(const ContactPair<Law>& q) {
        if (q.state == ContactState::open) return {Event::begins, Event::none};
        if (q.state == ContactState::slack) return {Event::opens, Event::engages};
        return {Event::ends, q.may_be_too_deep ? Event::deepens : Event::none};
    }
    // Compression left until the largest of the law [m].
    double depth_left(const ContactPair<Law>& q, const Geometry& g) const {
        return deepest_compression * smaller_radius(q) - g.depth;
    }
    // Rounding error of a compression, the difference of positions [m]. While others are in contact, a pair that moves
    // by less does not begin a contact.
    static double rounding(const ContactPair<Law>& q) { return 2.0 * math::epsilon * q.contact_distance; }
    EventFunction event_at(int index, Event kind, const double* y, const double* dy) const;
    double acceleration(const ContactPair<Law>& q, const Geometry& g, const double* y,
                        const double* dy) const;
    bool still_fresh(int q) const;
    bool crosses(int q, Event kind, double& length);
    void midpoint_step(double step);
    double first_guess(int q, const EventFunction& a, const EventFunction& b, double length,
                       double high) const;
    template <class Value>
    bool event_at_start(const Value& value);
    void apply(Event what, int index);
    void begin_contact(int index, const Geometry& g);
    static bool share_a_body(const ContactPair<Law>& a, const ContactPair<Law>& b);
    void end_contact(int index, const Geometry& g);
};

template <class Law>
void Cluster<Law>::run(double until, Stop& stop, long most_steps, bool through) {
    load_state();
    const double from = time;
    const long before = steps_;
    while (time < until && !unresolved && too_deep < 0 && !stop()) {
        if (!through && all(ContactState::open)) break;
        const double end = wall_pieces.empty() ? until : end_of_pieces(until);
        if (!(speed_unit_ > at_rest)) {
            rest_until(end);
        } else if (!any(ContactState::closed) && !sine_) {
            fly(end);
        } else if (integrates()) {
            integration_step(end);
        } else {
            if constexpr (LinearLaw<Law>) series_step(end);
        }
        if (++steps_ > 10'000'000) unresolved = true;
        if (steps_ - before >= most_steps && time > from) break;
    }
    store_state();
}

}  // namespace hardlimit::boxes

#include "events.hpp"
#include "flight.hpp"
#include "integrate.hpp"
#include "linear.hpp"
#include "state.hpp"
