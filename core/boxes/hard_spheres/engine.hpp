// Event-driven dynamics of hard spheres and disks.
//
// Each particle has two pending events: its earliest predicted collision, which is stale once the partner's collision
// count has changed, and a self event: it leaves its cell or meets a wall. After a collision both particles predict
// their next one among all neighbours; a particle that enters a cell searches only the cells that have become
// neighbours. A stale event triggers a new prediction; its time is a lower bound on the particle's next collision.
//
// Particles are sorted in memory by cell. Results do not depend on this order: simultaneous events are ordered by the
// original index, the index in the user's arrays.
#pragma once
#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "../common/archive.hpp"
#include "../common/engine.hpp"
#include "../kernels/interface.hpp"
#include "../neighbours/cell_order.hpp"
#include "../neighbours/cells.hpp"
#include "../queue/calendar_queue.hpp"
#include "../queue/prefetch.hpp"
#include "../queue/self_event.hpp"
#include "accumulators.hpp"
#include "collapse.hpp"
#include "rules/rule.hpp"

namespace hardlimit::boxes {

// Growing radii: σ(t) = (start + rate t) σ.
struct Growth {
    double start = 1.0;  // factor of the radii at time 0
    double rate = 0.0;   // [1/s]

    double at(double time) const { return start + rate * time; }
};

template <int d, bool mixed>
class HardSpheres final : public Engine {
public:
    // The engine must not be used if `stop` interrupted the prediction of the first events.
    HardSpheres(const System& s, const RuleChoice& rule, bool keep_log,
                const hardlimit_abi::TouchKernels& kernels, Stop& stop, Growth growth = {});
    // Loads a saved run. Reader::failed() tells whether it could be read.
    HardSpheres(Reader& saved, const hardlimit_abi::TouchKernels& kernels);

    // The unit of work is a collision: a pause is at the instant of the last one.
    void advance(double until, u64 most_work, int threads, Stop& stop) override;
    bool paused() const override { return paused_; }
    double time() const override { return now_; }
    Outcome outcome() const override { return outcome_; }
    EarlyEnd early_end() const override { return early_end_; }
    u64 work() const override { return accumulators_.collisions(); }
    u64 contacts() const override { return accumulators_.collisions(); }
    u64 logged() const override { return accumulators_.collisions(); }
    std::vector<Statistic> statistics() const override;
    double set_velocities(const double* velocity) override;
    void state(double* position, double* velocity) const override;
    Observation observe() const override;
    bool contacts_have_duration() const override { return false; }
    std::vector<ContactRecord> take_log() override { return std::exchange(log_, {}); }
    std::vector<ContactRecord> open_contacts() const override { return {}; }
    std::vector<char> save() const override;
    std::size_t bytes() const override;
    int dimension() const override { return d; }
    std::size_t size() const override { return particles_.size(); }

private:
    // After a collision, growing particles separate at least this many times as fast as their radii grow.
    static constexpr double separation_of_growing = 1.5;
    static constexpr u64 collisions_between_sorts = 20;  // per particle

    struct Flight;  // predict.hpp
    // Search for the next collision of a particle, with the earliest one found so far.
    struct NextCollision {
        u32 id;
        u32 except = no_particle;    // the partner of its last collision, ignored while they touch
        double in = math::infinity;  // [s] from now
        u32 partner = no_particle;
    };
    // The last contact of a particle, under a rule with contacts of finite duration, and those with walls that it has
    // not cut short: contacts with walls of different axes are independent.
    struct LastContact {
        double until = -math::infinity;  // [s]
        u32 partner = no_particle;       // no_particle: a wall, or none yet
        WallId wall[d] = {};             // the wall met along each axis, if any
        double wall_until[d] = {};       // end of that contact [s]
    };

    Box box_;
    RuleChoice choice_;
    std::unique_ptr<Rule> rule_;
    Growth growth_{};
    Motion motion_ = Motion::straight;
    bool keep_log_ = false;
    double mass_ = 0.0;  // of each particle, unless mixed [kg]
    double smallest_radius_ = 0.0, largest_radius_ = 0.0;
    Records<Particle<d>> particles_;
    Records<PendingEvents> pending_;
    Records<std::array<int, d>>
        image_flags_;              // how often each particle has left the box through a periodic side
    Records<u32> original_index_;  // index in the user's arrays
    Records<double> masses_;       // if mixed [kg]
    Cells<d> cells_;
    double columns_ = 0.0;  // Cells::columns(), for checkpoints
    CalendarQueue calendar_;
    Accumulators<d> accumulators_;
    CollapseDetector collapse_;
    std::vector<ContactRecord> log_;
    double now_ = 0.0;  // [s]
    i64 events_ = 0;    // since the run was made or loaded: collisions, cell crossings, predictions
    bool paused_ = false;
    Outcome outcome_ = Outcome::ok;
    EarlyEnd early_end_;
    hardlimit_abi::TouchKernels::Of touch_{};
    hardlimit_abi::ContactQuery query_{};  // of the particle whose next collision is predicted
    Scratch<u32> candidates_;
    Scratch<double> times_;               // until contact with each candidate [s]
    std::vector<u32> rows_;               // of cells, in a search for smaller particles
    u64 next_sort_ = 0;                   // collision count at the next sort
    i64 until_refresh_ = 0;               // collisions until totals are recomputed; a pair counts twice
    Records<double> rescans_;             // time of the next search for smaller particles [s]
    double fastest_ = 0.0;                // bound on the speeds of all particles [m/s]
    bool takes_time_ = false;             // whether contacts take time under the rule
    Records<LastContact> last_contacts_;  // if they do
    u64 soft_contacts_ = 0, soft_third_body_ = 0;
    DeepestImpact deepest_;    // if there is a law
    bool prefetches_ = false;  // whether the system is larger than the caches

    bool falls() const { return motion_ == Motion::falling; }
    bool grows() const { return motion_ == Motion::growing; }
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
    bool holds_any(int level) const {
        return !mixed || cells_.grids()[static_cast<std::size_t>(level)].widest > 0.0;
    }
    u32 collisions(u32 i) const {
        if constexpr (mixed) return pending_[i].count;
        return collisions_in(particles_[i].radius);
    }
    void count_collision(u32 i) {
        if constexpr (mixed)
            ++pending_[i].count;
        else
            particles_[i].radius = increment_collision_count(particles_[i].radius);
    }
    double event_time(u32 i) const { return pending_[i].time(); }

    void schedule(u32 i) {
        calendar_.push(i, event_time(i), [this](u32 id) { return original_index_[id]; });
    }
    const QueuedEvent* next_due() {
        return calendar_.next([this](u32 id) { return event_time(id); },
                              [this](u32 id) { return original_index_[id]; },
                              [this] {
                                  if (prefetches_) ahead().enter_bin();
                              });
    }
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

    // start.hpp
    void sort_in(const System& s);
    void make_cells(std::size_t n);
    void fill_cells();
    void tilt_cells();
    void set_rule(const RuleChoice& choice);
    void set_motion(const hardlimit_abi::TouchKernels& kernels);
    void predict_all(Stop& stop);
    void rebuild_queue();
    void sort_along_cells();
    template <class Archive>
    void archive(Archive& a);

    // observe.hpp
    std::vector<u32> in_original_order() const;
    ParticleSums<d> full_sums(bool from_flow) const;
    ParticleSums<d> present_sums(bool from_flow) const;
    i64 changes_between_refreshes() const { return 16 * static_cast<i64>(size32()); }
    void refresh_accumulators();

    // predict.hpp
    void prepare_query();
    NextCollision begin_prediction(u32 i, u32 except);
    void predict(u32 i, u32 except);
    void predict_unscheduled(u32 i, u32 except);
    void predict_self_event(u32 i, const Place<d>& at);
    void predict_near(NextCollision& next, int level, const Place<d>& from, const Place<d>& to);
    void predict_beyond_sides(NextCollision& next, int level, const Place<d>& from, const Place<d>& to);
    template <class F>
    void for_images_beyond(int level, const Place<d>& from, const Place<d>& to, const F& f);
    void predict_in_block(NextCollision& next, int level, const Place<d>& from, const Place<d>& to);
    void predict_in_images(NextCollision& next, int level, const Place<d>& from, const Place<d>& to);
    void predict_finer(NextCollision& next, int level);
    void make_room_for_candidates(std::size_t room);
    void keep_earliest(NextCollision& next, const hardlimit_abi::EarliestContact& touched, bool nearest);
    bool touches(u32 id, bool nearest) const;
    void store(const NextCollision& next);
    double frame_speed(const double* velocity) const;
    double speed_bound() const;

    // events.hpp
    void process_event(u32 i);
    void leave_cell(u32 i, Place<d> at);
    void cross_sheared_side(u32 i, int step);
    u32 fold_into_column(u32 i);
    void collide_with_wall(u32 i, const Wall& wall);
    bool meets_wall(u32 i, const Wall& wall) const;
    void collide(u32 i, u32 j);
    void advance_to_now(u32 i) { boxes::advance(particles_[i], now_, box_); }
    double to_nearest_image(u32 i, u32 j, double (&r)[d]) const;
    void rebound(u32 i, u32 j, const double (&r)[d], const double (&v)[d], double distance, double speed,
                 double image_velocity, std::array<double, 2> waited);
    Rebound rebound_of(const Impact& impact);
    double since_last(u32 i, double waited) const { return collisions(i) > 0 ? waited : math::infinity; }
    PairGeometry geometry(u32 i, u32 j) const;
    void set_velocity(u32 i, const double (&velocity)[d]);
    void after_collision(u32 i);
    void record(u32 i, i64 second, double speed, double separation_speed, double lost, double waited);
    std::pair<i64, i64> original_pair(u32 i, i64 second) const;
    void end_run(Outcome outcome, u32 i, i64 second);
    void end_unsolved(Outcome outcome, u32 i, i64 second, double speed);

    // soft_contact.hpp
    void contact(u32 i, u32 j, const double (&r)[d], const double (&v)[d], double distance, double speed,
                 double image_velocity);
    void contact_with_wall(u32 i, const Wall& wall, double speed);
    void displace(u32 i, double share, const double (&velocity)[d], const double (&shift)[d]);
    void update_cell(u32 i);
    void remember_contact(u32 i, u32 j, double duration, WallId wall = {});
    double wall_blocked_until(u32 i, WallId wall) const;
    double end_wall_contacts(u32 i);
    u32 excluded_partner(u32 i) const;
};

// Type of the engine, stored at the start of a checkpoint.
struct Kind {
    int dimension;
    bool mixed;
};

template <int d, bool mixed>
void HardSpheres<d, mixed>::advance(double until, u64 most_work, int /*threads*/, Stop& stop) {
    const u64 done = accumulators_.collisions(), last = most_work > ~done ? ~u64{0} : done + most_work;
    paused_ = false;
    while (outcome_ == Outcome::ok) {
        if (accumulators_.collisions() >= last) {
            paused_ = true;
            return;
        }
        if (prefetches_ && accumulators_.collisions() >= next_sort_) sort_along_cells();
        const QueuedEvent* due = next_due();
        const double end = math::min(until, cells_.next_tilt());
        const bool over = !due || due->time > end;
        if (over && end == until) {
            now_ = math::max(now_, until);
            return;
        }
        if (over ? stop.now() : stop()) {
            paused_ = true;
            return;
        }
        if (over) {
            now_ = math::max(now_, end);
            tilt_cells();
            continue;
        }
        now_ = math::max(now_, due->time);
        const u32 i = due->id;
        calendar_.pop();
        ++events_;
        if (prefetches_) ahead().step();
        process_event(i);
    }
}

// The time of a particle's last collision, which rules need, is kept: its path is extrapolated back from now to that
// time with the new velocity. Under the rule soft, a pair whose contact is over may collide again, and contacts with
// walls end.
template <int d, bool mixed>
double HardSpheres<d, mixed>::set_velocities(const double* velocity) {
    Sum lifted;
    for (u32 i = 0; i < size32(); ++i) {
        Particle<d>& p = particles_[i];
        const double time = p.time;
        const ImageMotion image = box_.image(image_flags_[i], now_);
        advance_to_now(i);
        if (takes_time_) lifted.add(end_wall_contacts(i));
        for (int k = 0; k < d; ++k)
            p.velocity[k] = velocity[std::size_t{original_index_[i]} * d + static_cast<std::size_t>(k)] -
                            image.velocity[k];
        fastest_ = math::max(fastest_, frame_speed(p.velocity));
        boxes::advance(p, time, box_);
        if (takes_time_ && last_contacts_[i].until <= now_) last_contacts_[i].partner = no_particle;
    }
    refresh_accumulators();
    Stop never;
    predict_all(never);
    rebuild_queue();
    return lifted.value();
}

template <int d, bool mixed>
void HardSpheres<d, mixed>::state(double* position, double* velocity) const {
    for (u32 i = 0; i < size32(); ++i) {
        const Particle<d>& p = particles_[i];
        const ImageMotion image = box_.image(image_flags_[i], now_);
        for (int k = 0; k < d; ++k) {
            const std::size_t at = std::size_t{original_index_[i]} * d + static_cast<std::size_t>(k);
            const double after = now_ - p.time;
            position[at] = position_after(p, k, after, box_) + image.shift[k];
            velocity[at] = velocity_after(p, k, after, box_) + image.velocity[k];
        }
    }
}

}  // namespace hardlimit::boxes

#include "events.hpp"
#include "observe.hpp"
#include "predict.hpp"
#include "soft_contact.hpp"
#include "start.hpp"
