// Newton's equations for a few spheres or disks whose contacts overlap in time, under any contact law:
//   m_i dv_i/dt = Σ_j F_ij n_ij + m_i g,   F = force(s, dξ/dt) while the contact is closed, otherwise 0,
//   ξ = s^p = R_i + R_j − |r_ij|  (at a wall: R_i − distance of the centre),   dξ/dt = −n·(v_j − v_i).
// The method is that of columns (column/general/motions.hpp): integration of order 8 in a scaled time
// (contact/smooth_time.hpp). Every begin and end of a contact is located within its step (contact/events.hpp). The s of
// a closed contact is integrated together with the positions. A closed pair that reaches the largest compression of its
// law (deepest_compression) ends the run of the cluster. Under a linear law a step is a power series (linear.hpp), and
// events are zeros of polynomials. While no pair exerts a force, the members fly in closed form (flight.hpp).
//
// With friction the spins and what the surfaces of each pair keep (surfaces.hpp) are components too, also under a
// linear law, and the begins of slip and stick are events. Steps in which a direction of slip relaxes quickly are
// implicit in it (slip_step.hpp). While a single pair of bodies under a linear law is in contact, steps are power
// series (turning_step.hpp).
#pragma once
#include <algorithm>
#include <limits>
#include <vector>

#include "../../../base/stop.hpp"
#include "flight.hpp"
#include "integrated_step.hpp"
#include "linear.hpp"

namespace hardlimit::boxes {

inline constexpr long no_limit = std::numeric_limits<long>::max();

// A contact network that moves. Its members, pairs and time are those at the end of the last run.
template <class Law>
class Cluster : public ContactNetwork<Law>, public Ledger {
    using Network = ContactNetwork<Law>;

public:
    using Network::base, Network::members, Network::pairs, Network::time, Network::wall_pieces;

    double largest_coordinate = 0.0;  // largest edge of the box, for the rounding error of positions [m]
    const hardlimit_abi::SeriesKernels* kernels = nullptr;  // needed for a linear law
    double tolerance = 1e-11;  // of a step, relative to the units of length, speed and time
    bool record = false;       // whether to keep the trajectory
    Trajectory trajectory;
    bool unresolved = false;
    int too_deep = -1;  // pair that reached the largest compression of its law

    // Resets everything but keeps the allocated storage.
    void clear() {
        Network::clear();
        Ledger::clear();
        trajectory.clear();
        record = unresolved = false;
        too_deep = -1;
        steps_ = still_ = 0;
        integrator_.restart();
    }

    // Integrates to `until`, or until the last pair opens, or for `most_steps` steps.
    void run(double until, Stop& stop, long most_steps = no_limit) { run(until, stop, most_steps, false); }

    // Integrates to `until` even if all pairs open before. If one pair opens at the instant at which another begins,
    // their order depends on rounding, and may differ if steps end elsewhere.
    void run_through(double until) {
        Stop never;
        run(until, never, no_limit, true);
    }

    long steps() const { return steps_; }
    double speed() const { return Scales(*this).speed; }
    Vector3 frame_velocity() const { return boxes::frame_velocity(*this); }

    // `walls` without the energies of slack pairs and of tangential springs.
    WallSums given_to_walls() const {
        WallSums given = this->walls;
        for (const ContactPair<Law>& q : pairs)
            if (q.second < 0 && q.state == ContactState::slack) given.add(q.wall_id, 0.0, -this->stored(q));
        if constexpr (FrictionalLaw<Law>)
            for (const ContactPair<Law>& q : pairs)
                if (q.second < 0) given.add(q.wall_id, 0.0, -this->tangential(q));
        return given;
    }

private:
    // Speed below which squares underflow: the bodies do not move [m/s].
    static constexpr double at_rest = 1e-150;
    static constexpr bool by_series = LinearLaw<Law> && FrictionlessLaw<Law>;

    Network& network() { return *this; }
    Ledger& ledger() { return *this; }

    void run(double until, Stop& stop, long most_steps, bool through) {
        load();
        if constexpr (FrictionalLaw<Law>)
            EventChange<Law>{network(), state_, scales_, ledger()}.start_friction();
        const double from = time;
        const long before = steps_;
        while (time < until && !unresolved && too_deep < 0 && !stop()) {
            if (!through && this->all_open()) break;
            const Progress progress = step(wall_pieces.empty() ? until : end_of_pieces(until));
            if constexpr (FrictionalLaw<Law>) count_still(state_.time() > time);
            time = state_.time();
            if (progress.moved) record_state();
            if (progress.event) apply(progress.event);
            unresolved = ++steps_ > 10'000'000 || progress.failed || still_ > most_still();
            if (steps_ - before >= most_steps && time > from) break;
        }
        if constexpr (FrictionalLaw<Law>) keep_springs();
        state_.store(network(), ledger());
    }
    // Counts the steps in which time stands still: events without end at one time, as where many bodies touch at once.
    void count_still(bool advances)
        requires FrictionalLaw<Law>
    {
        still_ = advances ? 0 : still_ + 1;
        if (advances)
            for (ContactPair<Law>& q : pairs) q.surfaces.keeps_slipping = false;
    }
    long most_still() const { return 200 + 4 * static_cast<long>(pairs.size()); }
    void keep_springs()
        requires FrictionalLaw<Law>
    {
        for (int i = 0; i < static_cast<int>(pairs.size()); ++i)
            if (pairs[i].state == ContactState::closed)
                pairs[i].surfaces.elastic = SurfacePair<Law>(state_.at(network()), i).elastic();
    }

    void load() {
        state_.load(network(), ledger());
        scales_ = Scales(*this);
        integrates_ = !by_series || state_.layout.images_move();
        integrator_.forget();
        trajectory.clear();
        record_state();
    }
    bool integrates() const { return (boxes_move || !by_series) && integrates_; }
    void record_state() {
        if (record) trajectory.add(state_.y.data(), members.size(), state_.time(), !integrates());
    }

    // Replaces the pieces of walls that have ended. Returns when the present ones end, at most `until`; steps along a
    // sine are at most a 32nd of its period, so that no event within a step is missed.
    double end_of_pieces(double until) {
        double end = until;
        bool jumps = false;
        for (const ContactPair<Law>& q : pairs) {
            if (q.second >= 0) continue;
            WallPiece& p = wall_pieces[q.wall_id.index()];
            if (p.follow(time, base + time)) {
                integrator_.forget();
                jumps = jumps || p.amplitude == 0.0;
            }
            end = math::min(end, p.end);
            if (p.amplitude != 0.0) end = math::min(end, time + 0.125 * (p.end - p.begin));
        }
        if (!jumps) return end;
        integrator_.restart();
        for (ContactPair<Law>& q : pairs)
            if (q.second < 0) q.velocity_jumped();
        return end;
    }

    Progress step(double until) {
        if (!(scales_.speed > at_rest)) {
            state_.time() = until;
            return {.moved = true};
        }
        if (!this->any(ContactState::closed) && !this->has_sine()) {
            integrator_.forget();
            return {.moved = true, .event = fly(network(), state_, until)};
        }
        if constexpr (by_series)
            if (!integrates())
                return SeriesStep<Law>{network(),  state_,    scales_,           ledger(),
                                       expansion_, tolerance, largest_coordinate}
                    .take(until, *kernels, record ? &trajectory : nullptr);
        return IntegratedStep<Law>{network(), state_, scales_, ledger(), integrator_, tolerance}.take(until);
    }

    void apply(PairEvent event) {
        EventChange<Law>{network(), state_, scales_, ledger()}.apply(event);
        integrator_.restart();
        if (event.what == ContactEvent::deepens) too_deep = event.pair;
    }

    StateVector state_;
    Scales scales_;
    Integrator integrator_;
    Expansion expansion_;
    bool integrates_ = !by_series;  // whether steps are integrated; otherwise they are power series
    long steps_ = 0, still_ = 0;    // still_: in a row in which time stands still; counted with friction
};

}  // namespace hardlimit::boxes
