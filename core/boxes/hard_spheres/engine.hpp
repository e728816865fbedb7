// Event-driven dynamics of hard spheres and disks.
//
// Each particle has two pending events: its earliest predicted collision, which is stale once the partner's collision
// count has changed, and a self event: it leaves its cell or meets a wall. After a collision both particles predict
// their next one among all neighbours; a particle that enters a cell searches only the cells that have become
// neighbours. A stale event triggers a new prediction; its time is a lower bound on the particle's next collision.
//
// The engine consists of parts, each of which knows only those before it: Setting, Particles, Totals (observe.hpp),
// CellAssignment, LastContacts, Predictor (predict.hpp), Schedule, CollisionLog, Collisions (events.hpp).
#pragma once
#include <vector>

#include "../common/archive.hpp"
#include "events.hpp"
#include "growing.hpp"
#include "predict.hpp"
#include "schedule.hpp"

namespace hardlimit::boxes {

template <int d, bool mixed>
class HardSpheres final : public Engine {
public:
    // The engine must not be used if `stop` interrupted the prediction of the first events.
    HardSpheres(const System& s, const RuleChoice& rule, bool keep_log,
                const hardlimit_abi::TouchKernels& kernels, Stop& stop, spheres::Growth growth = {});
    // Loads a saved run. Reader::failed() tells whether it could be read.
    HardSpheres(Reader& saved, const hardlimit_abi::TouchKernels& kernels);

    // The unit of work is a collision: a pause is at the instant of the last one.
    void advance(double until, u64 most_work, int threads, Stop& stop) override;
    bool paused() const override { return paused_; }
    double time() const override { return particles_.now; }
    Outcome outcome() const override { return log_.outcome(); }
    EarlyEnd early_end() const override { return log_.early_end(); }
    u64 work() const override { return totals_.so_far.collisions(); }
    u64 contacts() const override { return totals_.so_far.collisions(); }
    u64 logged() const override { return totals_.so_far.collisions(); }
    std::vector<Statistic> statistics() const override;
    double set_velocities(const double* velocity, const double* spin) override;
    void state(double* x, double* v) const override { particles_.state(x, v); }
    bool rotates() const override { return particles_.rotates(); }
    void spins(double* spin) const override;
    Observation observe() const override;
    bool contacts_have_duration() const override { return false; }
    std::vector<ContactRecord> take_log() override { return log_.take(); }
    std::vector<ContactRecord> open_contacts() const override { return {}; }
    std::vector<char> save() const override;
    std::size_t bytes() const override;
    int dimension() const override { return d; }
    std::size_t size() const override { return particles_.size(); }

private:
    static constexpr u64 collisions_between_sorts = 20;  // per particle

    spheres::Setting setting_;
    spheres::Particles<d, mixed> particles_;
    spheres::Totals<d, mixed> totals_;
    spheres::CellAssignment<d, mixed> cells_;
    spheres::LastContacts<d> last_contacts_;
    spheres::Predictor<d, mixed> predictor_;
    spheres::Schedule<d, mixed> schedule_;
    spheres::CollisionLog log_;
    CollapseDetector collapse_;
    spheres::Collisions<d, mixed> collisions_;
    spheres::GrowingCollisions<d, mixed> growing_;
    i64 events_ = 0;  // since the run was made or loaded: collisions, cell crossings, predictions
    bool paused_ = false;
    u64 next_sort_ = 0;  // collision count at the next sort

    HardSpheres(spheres::Setting&& setting, const hardlimit_abi::TouchKernels& kernels);

    void predict(u32 i, u32 except) {
        predictor_.predict(i, except);
        schedule_.push(i);
    }
    void predict_all(Stop& stop);
    void tilt_cells();
    void sort_along_cells();
    void process_event(u32 i);
    void leave_cell(u32 i);
    void collide(u32 i, u32 j);
    void collide_with_wall(u32 i, const Wall& wall);
    bool meets(u32 i, const Wall& wall) const;
    void after_collision(u32 i);
    template <class Archive>
    void exchange(Archive& a);
};

template <int d, bool mixed>
void HardSpheres<d, mixed>::advance(double until, u64 most_work, int /*threads*/, Stop& stop) {
    const u64 done = work(), last = most_work > ~done ? ~u64{0} : done + most_work;
    double& now = particles_.now;
    paused_ = false;
    while (outcome() == Outcome::ok) {
        if (work() >= last) {
            paused_ = true;
            return;
        }
        if (schedule_.large() && work() >= next_sort_) sort_along_cells();
        const QueuedEvent* due = schedule_.next();
        const double end = math::min(until, cells_.cells().next_tilt());
        const bool over = !due || due->time > end;
        if (over && end == until) {
            now = math::max(now, until);
            return;
        }
        if (over ? stop.now() : stop()) {
            paused_ = true;
            return;
        }
        if (over) {
            now = math::max(now, end);
            tilt_cells();
            continue;
        }
        now = math::max(now, due->time);
        const u32 i = due->id;
        ++events_;
        schedule_.pop();
        process_event(i);
    }
}

template <int d, bool mixed>
void HardSpheres<d, mixed>::process_event(u32 i) {
    const PendingEvents& e = particles_.pending[i];
    if (e.pair_time <= e.own_time) {
        if (particles_.collisions(e.partner) == e.partner_count) return collide(i, e.partner);
        return predict(i, last_contacts_.excluded_partner(i));
    }
    const SelfEvent own = static_cast<SelfEvent>(e.own);
    if (own == SelfEvent::rescan) return predict(i, last_contacts_.excluded_partner(i));
    if (is_wall(own)) return collide_with_wall(i, setting_.box.wall(wall_at(own)));
    leave_cell(i);
}

template <int d, bool mixed>
void HardSpheres<d, mixed>::leave_cell(u32 i) {
    const SelfEvent own = static_cast<SelfEvent>(particles_.pending[i].own);
    const int axis = axis_of(own), step = is_high(own) ? 1 : -1;
    const Place<d> at = cells_.cross_face(i, axis, step);
    predictor_.predict_beyond(i, at, axis, step, last_contacts_.excluded_partner(i));
    schedule_.push(i);
}

template <int d, bool mixed>
void HardSpheres<d, mixed>::collide(u32 i, u32 j) {
    if (setting_.grows())
        growing_.collide(i, j);
    else
        collisions_.collide(i, j);
    after_collision(i);
    after_collision(j);
    // A pair that has just collided cannot collide again before one of them has another collision; other images can.
    const bool soft = collisions_.take_time();
    predict(i, soft ? last_contacts_.excluded_partner(i) : j);
    predict(j, soft ? last_contacts_.excluded_partner(j) : i);
}

template <int d, bool mixed>
bool HardSpheres<d, mixed>::meets(u32 i, const Wall& wall) const {
    const int axis = wall.id.axis();
    return meets_oscillating_wall(wall, particles_.now, particles_.position(i, axis),
                                  particles_.velocity(i, axis), setting_.box.gravity[axis],
                                  particles_.radius(i));
}

template <int d, bool mixed>
void HardSpheres<d, mixed>::collide_with_wall(u32 i, const Wall& wall) {
    if (wall.motion.oscillates() && !meets(i, wall)) [[unlikely]] {
        predictor_.predict_self_event(i, cells_.place(i));
        return schedule_.push(i);
    }
    if (setting_.grows())
        growing_.collide_with_wall(i, wall);
    else
        collisions_.collide_with_wall(i, wall);
    if (outcome() != Outcome::ok) return;
    after_collision(i);
    predict(i, no_particle);
}

template <int d, bool mixed>
void HardSpheres<d, mixed>::after_collision(u32 i) {
    particles_.count_collision(i);
    if (cells_.has_levels()) particles_.note_speed(particles_.paths[i].velocity);
    if (!setting_.grows()) totals_.count_change();
}

// The time of a particle's last collision, which rules need, is kept: its path is extrapolated back from now to that
// time with the new velocity. Under the rule soft, a pair whose contact is over may collide again, and contacts with
// walls end.
template <int d, bool mixed>
double HardSpheres<d, mixed>::set_velocities(const double* velocity, const double* spin) {
    Sum lifted;
    for (u32 i = 0; i < particles_.size(); ++i) {
        const double time = particles_.paths[i].time;
        particles_.advance_to_now(i);
        if (collisions_.take_time()) lifted.add(last_contacts_.end_wall_contacts(particles_, i));
        particles_.set_velocity(i, velocity + std::size_t{particles_.original_index[i]} * d);
        if (spin && rotates())
            std::copy_n(spin + std::size_t{particles_.original_index[i]} * 3, 3,
                        particles_.spins[i].velocity);
        boxes::advance(particles_.paths[i], time, setting_.box);
        if (collisions_.take_time()) last_contacts_.release(i, particles_.now);
    }
    totals_.refresh();
    Stop never;
    predict_all(never);
    return lifted.value();
}

template <int d, bool mixed>
void HardSpheres<d, mixed>::spins(double* spin) const {
    for (u32 i = 0; i < particles_.size(); ++i)
        std::copy_n(particles_.spins[i].velocity, 3, spin + std::size_t{particles_.original_index[i]} * 3);
}

template <int d, bool mixed>
Observation HardSpheres<d, mixed>::observe() const {
    Observation o = totals_.observe();
    o.largest_compression = collisions_.largest_compression();
    return o;
}

template <int d, bool mixed>
std::vector<Statistic> HardSpheres<d, mixed>::statistics() const {
    const Accumulators<d>& a = totals_.so_far;
    return {{"n_events", static_cast<double>(events_)},
            {"n_pairs", static_cast<double>(a.pairs)},
            {"n_walls", static_cast<double>(a.walls)},
            {"n_elastic_by_tc", static_cast<double>(a.elastic_by_tc)},
            {"n_soft", static_cast<double>(last_contacts_.contacts)},
            {"n_soft_third_body", static_cast<double>(last_contacts_.third_body)}};
}

template <int d, bool mixed>
std::size_t HardSpheres<d, mixed>::bytes() const {
    return sizeof(*this) + particles_.bytes() + last_contacts_.bytes() + predictor_.bytes() +
           cells_.cells().bytes() + schedule_.bytes();
}

}  // namespace hardlimit::boxes

#include "checkpoint.hpp"
#include "start.hpp"
