// Event-driven dynamics of hard spheres and disks.
//
// Each particle has two events pending: the earliest collision found, which is told to be superseded by the partner's
// number of collisions, and one of its own, the border of its cell or a wall. Whoever collides looks for its next
// collision among all neighbours; whoever enters a cell looks only into the cells that have become neighbours. A
// collision that is superseded when its time comes makes its particle look anew: it was a lower bound for all others.
//
// Particles are held in an order of their own, along the cells. Nothing that comes out depends on it: where order
// matters, in ties, the user's number of a particle decides.
#pragma once
#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "../common/archive.hpp"
#include "../common/engine.hpp"
#include "../kernels/interface.hpp"
#include "../neighbours/cells.hpp"
#include "../queue/calendar_queue.hpp"
#include "../queue/prediction.hpp"
#include "../queue/prefetch.hpp"
#include "collapse.hpp"
#include "rules/soft.hpp"

namespace hardlimit::boxes {

// Growing radii: σ(t) = (start + rate t) σ.
struct Growth {
    double start = 1.0;  // share of the radius at time 0
    double rate = 0.0;   // [1/s]

    double at(double time) const { return start + rate * time; }
};

template <int d, Motion motion, bool mixed>
class HardSpheres final : public Engine {
public:
    // Predicting the first event of each particle takes a while; a run that `stop` has stopped is of no use.
    HardSpheres(const Setting& s, const RuleChoice& rule, bool keep_log, Stop& stop, Growth growth = {});
    // A run that was saved; failed() of the reader tells whether it could be.
    HardSpheres(Reader& saved, const hardlimit_abi::TouchKernels& kernels);

    void advance(double until, i64 most_rows, Stop& stop) override;
    double time() const override { return now_; }
    i64 events() const override { return events_; }
    Counts counts() const override {
        return {tally_.pairs, tally_.walls, tally_.elastic_by_tc, soft_contacts_, soft_third_body_};
    }
    Outcome outcome() const override { return outcome_; }
    EarlyEnd early_end() const override { return early_end_; }
    double largest_compression() const override { return deepest_.compression; }
    void state(double* position, double* velocity) const override;
    Observation observe() const override;
    Log take_log() override { return std::exchange(log_, {}); }
    std::vector<char> save() const override;
    std::size_t bytes() const override;
    int dimension() const override { return d; }
    std::size_t size() const override { return particles_.size(); }

private:
    // Growing radii that touch part at this many times the speed at which they grow, or faster.
    static constexpr double separation = 1.5;
    static constexpr i64 collisions_between_sorts = 20;  // for each particle

    // A particle that looks for its next collision, and what it has found.
    struct Look {
        u32 id;
        u32 except = no_particle;  // not to be met where it touches: what the particle has just collided with
        double in = math::infinity;  // [s] from now
        u32 partner = no_particle;
    };

    Box<d> box_{};
    Rule rule_;
    Growth growth_{};
    bool keep_log_ = false;
    double mass_ = 0.0;  // of all, unless mixed [kg]
    double smallest_radius_ = 0.0, largest_radius_ = 0.0;
    Records<Particle<d>> particles_;
    Records<Pending> pending_;
    Records<std::array<int, d>> periods_;  // by which the continuous path differs from the folded place
    Records<u32> names_;                   // the user's number of each
    Records<double> masses_;               // if mixed [kg]
    Cells<d> cells_;
    CalendarQueue calendar_;
    Tally<d> tally_;
    CollapseWatch watch_;
    Log log_;
    double now_ = 0.0;  // [s]
    i64 events_ = 0;
    Outcome outcome_ = Outcome::ok;
    EarlyEnd early_end_{math::nan, -1, 0};
    hardlimit_abi::TouchKernels::Of touch_{};
    hardlimit_abi::TouchQuery query_{};  // of the particle that looks now
    Scratch<u32> candidates_;
    Scratch<double> times_;    // until they are touched [s]
    i64 next_sort_ = 0;        // row of the log
    i64 until_refresh_ = 0;    // particles' collisions before energy and momentum are summed anew
    Records<double> rescans_;  // time of the next look for smaller particles [s]
    double fastest_ = 0.0;     // bound of the speeds of all particles [m/s]
    // The last contact of a particle under the soft rule.
    struct SoftContact {
        double until;  // [s]
        u32 partner;   // nobody: a wall, or none yet
        u32 wall = 0;  // one more than the event at which it was met; 0: another particle, or none yet
    };
    std::unique_ptr<SoftRule> soft_;
    Records<SoftContact> softs_;  // under the soft rule only
    i64 soft_contacts_ = 0, soft_third_body_ = 0;
    DeepestImpact deepest_;  // where there is a law
    bool fetches_ = false;   // whether the system is too large for a core's caches

    static const hardlimit_abi::TouchKernels::Of& kernels_of(const hardlimit_abi::TouchKernels& kernels) {
        return kernels.of[d - 2][static_cast<int>(motion)];
    }
    u32 size32() const { return static_cast<u32>(particles_.size()); }
    double mass(u32 i) const {
        if constexpr (mixed) return masses_[i];
        return mass_;
    }
    double radius(u32 i) const {
        if constexpr (mixed) return particles_[i].radius;
        return largest_radius_;
    }
    int level(u32 i) const {
        if constexpr (mixed) return cells_.level_for(2.0 * radius(i));
        return 0;
    }
    u32 collisions(u32 i) const {
        if constexpr (mixed) return pending_[i].count;
        return collisions_in(particles_[i].radius);
    }
    void count_collision(u32 i) {
        if constexpr (mixed)
            ++pending_[i].count;
        else
            particles_[i].radius = one_more_collision(particles_[i].radius);
    }
    double event_time(u32 i) const { return pending_[i].time(); }

    void schedule(u32 i) {
        calendar_.push(i, event_time(i), [this](u32 id) { return names_[id]; });
    }
    const Due* next_due() {
        return calendar_.next([this](u32 id) { return event_time(id); },
                              [this](u32 id) { return names_[id]; },
                              [this] {
                                  if (fetches_) ahead().enter_bin();
                              });
    }

    // hard_spheres/start.hpp
    void take(const Setting& s);
    void lay_cells(std::size_t n);
    void put_into_cells();
    void make_rule(const RuleChoice& choice);
    void predict_all(Stop& stop);
    void restart_calendar();
    template <class Archive>
    void archive(Archive& a);
    void refresh_tally();

    // hard_spheres/soft.hpp
    void collide_softly(u32 i, u32 j, const double (&r)[d], const double (&v)[d], double distance,
                        double speed);
    void meet_wall_softly(u32 i, int axis, double away, double speed);
    void shift_body(u32 i, double share, const double (&velocity)[d], const double (&shift)[d]);
    void settle(u32 i);
    void remember(u32 i, u32 j, double duration, u32 wall = 0);
    double free_of_wall(u32 i, int axis, bool high) const;
    u32 last_met(u32 i) const;

    // hard_spheres/predict.hpp
    void prepare_query();
    Look look(u32 i);
    void predict(u32 i, u32 except);
    void predict_unscheduled(u32 i, u32 except);
    void predict_own(u32 i, const Place<d>& at);
    void search_block(Look& look, int level, const Place<d>& from, const Place<d>& to);
    void search_images(Look& look, int level, const Place<d>& from, const Place<d>& to);
    void search_finer(Look& look, int level);
    void make_room_for_candidates();
    void examine(Look& look, const hardlimit_abi::Touched& touched, bool nearest);
    bool in_touch(u32 id, bool nearest) const;
    void keep(const Look& found);
    double frame_speed(const double* velocity) const;
    double fastest_possible() const;

    // hard_spheres/sort.hpp
    void sort_along_cells();

    auto ahead() const {
        return Prefetcher{calendar_,
                          cells_,
                          pending_.data(),
                          particles_.data(),
                          [this](u32 id) { return level(id); },
                          [](u32) {},
                          [this](u32 id) {
                              if (mixed) prefetch(&pending_[id]);
                          }};
    }

    // hard_spheres/events.hpp
    void happen(u32 i);
    void leave_cell(u32 i, Place<d> at);
    void meet_wall(u32 i);
    void collide(u32 i, u32 j);
    void advance_to_now(u32 i);
    void nearest(u32 i, u32 j, double (&r)[d]) const;
    bool had_before(u32 i, double waited) const;
    void collide_at_once(u32 i, u32 j, const double (&r)[d], const double (&v)[d], double distance,
                         double speed, std::array<double, 2> waited);
    u32 except_for(u32 i, u32 partner) const;
    void keep_bounds(u32 i);
    double restitution(bool within_contact, double speed, PairGeometry pair, double smaller_radius);
    PairGeometry geometry(u32 i, u32 j) const;
    void note(u32 i, i64 second, double speed, double separation_speed, double lost, double waited);
    std::pair<i64, i64> named(u32 i, i64 second) const;
    void end_here(Outcome outcome, u32 i, i64 second);
    void give_up(Outcome outcome, u32 i, i64 second, double speed);
};

// What a saved run begins with, to be known before its type is.
struct Kind {
    int dimension;
    Motion motion;
    bool mixed;
};

template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::advance(double until, i64 most_rows, Stop& stop) {
    while (outcome_ == Outcome::ok && (most_rows == 0 || tally_.rows() < most_rows)) {
        if (fetches_ && tally_.rows() >= next_sort_) sort_along_cells();
        const Due* due = next_due();
        if (!due || due->time > until) {
            now_ = math::max(now_, until);
            return;
        }
        if (stop()) return;
        now_ = math::max(now_, due->time);
        const u32 i = due->id;
        calendar_.pop();
        ++events_;
        if (fetches_) ahead().step();
        happen(i);
    }
}

template <int d, Motion motion, bool mixed>
void HardSpheres<d, motion, mixed>::state(double* position, double* velocity) const {
    for (u32 i = 0; i < size32(); ++i) {
        const Particle<d>& p = particles_[i];
        for (int k = 0; k < d; ++k) {
            const std::size_t at = std::size_t{names_[i]} * d + static_cast<std::size_t>(k);
            const double after = now_ - p.time;
            position[at] = position_after<motion>(p, k, after, box_) + periods_[i][k] * box_.edge[k];
            velocity[at] = velocity_after<motion>(p, k, after, box_);
        }
    }
}

}  // namespace hardlimit::boxes

#include "events.hpp"
#include "predict.hpp"
#include "soft.hpp"
#include "sort.hpp"
#include "start.hpp"
