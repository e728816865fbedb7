// Event-driven solution of Newton's equations for a box of spheres or disks under a contact law.
//
// Between contacts the bodies move on parabolas, known exactly. Bodies in contact form a group, which is solved in
// advance from its begin to its end. A contact that no third body disturbs is solved as a whole in the plane of its
// approach (isolated_contact.hpp). Contacts that share a body form a cluster, which is integrated (cluster/) until its
// contacts are over, or for a limited time.
//
// Until its group ends, a member is busy. For all other bodies it is a larger body on a parabola: its radius grows by a
// safety radius, the largest distance between its true path and that parabola. As long as no other body touches this
// larger body, nothing can act on the group, and its solution holds. If one does (a conflict), the group is integrated
// again up to the present, and continues together with that body. So no contact is missed, and the solution never
// contains anything that a later event could change.
//
// The parabola of a cluster's member connects both ends of its path; collisions beyond the end are predicted at the
// end. The parabola of a body in an isolated contact is its outgoing path, extrapolated back from the end: collisions
// after the contact are predicted at its begin, and the end changes only the body's radius.
//
// Bodies are stored and scheduled like hard spheres (hard_spheres/): sorted by cell, with a record, two pending events
// and a cell for each. The end of a cluster is a self event of its first member. The ends of isolated contacts have a
// short queue of their own, and the pending events of their members stay valid.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "../../base/outcome.hpp"
#include "../binary_contact/tabulated_contact.hpp"
#include "../common/archive.hpp"
#include "../common/newton_setting.hpp"
#include "../kernels/interface.hpp"
#include "../neighbours/cell_order.hpp"
#include "../neighbours/cells.hpp"
#include "../queue/calendar_queue.hpp"
#include "../queue/prediction.hpp"
#include "../queue/prefetch.hpp"
#include "contact_end_queue.hpp"
#include "records.hpp"

namespace hardlimit::boxes {

template <class Law>
class NewtonEvents final : public Engine {
public:
    // The cost of integrating a cluster for the duration of a contact grows with the square of its members, because
    // each contact that ends also ends a step of all of them. A large cluster is integrated for few steps, since any
    // body that comes near restarts the integration.
    static constexpr std::size_t large_cluster = 50;
    static constexpr long steps_of_large_cluster = 64;
    // Only clusters that come to rest need so many steps. The limit lets a run be stopped between clusters.
    static constexpr long steps_of_small_cluster = 10'000;
    // Limit on the integration steps, summed over members, per body of the box and contact begun. Beyond it contacts
    // are persistent, and time stepping is cheaper. Small clusters may use the steps of `fewest_bodies` bodies.
    static constexpr double most_integration_steps = 1e4, fewest_bodies = 1e3;
    // Largest cluster that is integrated for a full horizon again when another body joins it. A larger one keeps its
    // time of end, and then splits into connected parts. Otherwise bodies that separated long ago would stay members,
    // and in a large gas a cluster would grow without bound.
    static constexpr std::size_t largest_renewed_cluster = 8;
    // Largest rotation of the line of centres in a contact that is solved as isolated [rad].
    static constexpr double largest_rotation = 1.0;
    // Largest initial overlap that counts as rounding error, relative to the sum of the radii.
    static constexpr double touching_depth = 1e-9;

    // Bodies that overlap start in contact if their force is repulsive.
    NewtonEvents(const NewtonSetting& setting, const System& s, const hardlimit_abi::TouchKernels& kernels);
    // Continues a saved run.
    NewtonEvents(const NewtonSetting& setting, Reader& reader, const hardlimit_abi::TouchKernels& kernels);

    // The unit of work is an event.
    void advance(double until, u64 most_work, int threads, Stop& stop) override;
    bool paused() const override { return paused_; }
    double time() const override { return now_; }
    Outcome outcome() const override { return outcome_; }
    EarlyEnd early_end() const override { return {now_, ended_by_, ended_at_wall_}; }
    u64 work() const override { return events_; }
    // Without contacts that begin or end within an unfinished group.
    u64 contacts() const override { return begun_; }
    u64 logged() const override { return ended_; }
    std::vector<Statistic> statistics() const override;

    double set_velocities(const double* velocity) override;

    // Const: groups are integrated in a copy.
    void state(double* position, double* velocity) const override;
    Observation observe() const override;
    bool contacts_have_duration() const override { return true; }
    std::vector<ContactRecord> take_log() override { return std::exchange(log_, {}); }
    std::vector<ContactRecord> open_contacts() const override { return groups_at_present().open; }
    double largest_safety_use(int instants) const override;

    std::vector<char> save() const override;
    std::size_t bytes() const override;
    int dimension() const override { return box_.dimension; }
    std::size_t size() const override { return particles_.size(); }

private:
    using IsolatedContact = boxes::IsolatedContact<Law>;
    using SeparatedMembers = std::array<Member, 2>;  // at the end of an isolated contact
    using ClusterStates = boxes::ClusterStates<Law>;
    using Group = ContactGroup<Law>;
    using ActivePair = boxes::ActivePair<Law>;
    using ClusterSeed = boxes::ClusterSeed<Law>;
    struct RelativeMotion {
        Vector3 position, velocity;
    };
    struct Block {
        Place<3> from, to;
    };
    // Flags of an image, and what it adds to its particle.
    struct BodyImage {
        double flags[3] = {};
        ImageMotion motion{};
    };

    NewtonSetting setting_;
    const Box& box_ = setting_.box;
    Box cell_box_;        // one cell deep in two dimensions
    PairLaws<Law> laws_;  // by index in memory
    TabulatedContacts<Law, true> soft_;
    // By index in memory. A path is a parabola that starts at `time`, in the frame of the cell; the radius includes the
    // safety radius.
    Records<Particle<3>> particles_;
    Records<BodyEvents> pending_;
    Records<Group> groups_;
    std::vector<int> free_groups_;
    std::vector<ClusterSeed> parts_;  // of ended clusters, still in contact; empty between events
    Cells<3> cells_;
    int level_ = 0;
    CalendarQueue calendar_queue_;
    ContactEndQueue contact_ends_;  // of isolated contacts
    hardlimit_abi::TouchKernels::Of touch_{};
    const hardlimit_abi::SeriesKernels* series_ = nullptr;
    hardlimit_abi::ContactQuery query_{};  // constant parts are set once
    double kernel_exact_after_ = 0.0;      // from then on the kernel's times for free bodies are exact [s]
    mutable Scratch<u32> candidates_;
    mutable Scratch<double> times_;  // until touch [s]
    Vector3 gravity_;
    double largest_radius_ = 0.0, smallest_radius_ = math::infinity;
    double largest_safety_radius_ = 0.0;  // for which the cells are wide enough [m]
    double largest_displacement_ = 0.0;   // of a member while its group lasts [m]
    bool several_images_ = false;         // whether several images of a body may be near
    bool walled_ = false;                 // whether there are walls
    bool prefetches_ = false;             // whether the data exceed the caches
    double now_ = 0.0, wall_work_ = 0.0, shear_work_ = 0.0, clustered_ = 0.0;
    WallSums walls_;
    SymmetricTensor virial_;
    double dissipated_ = 0.0;  // including the elastic energy that slack pairs still store [J]
    std::uint64_t begun_ = 0, begun_pairs_ = 0, ended_ = 0, overlapped_ = 0, events_ = 0;
    int largest_cluster_ = 0;
    double largest_compression_ = 0.0;  // without unfinished groups
    double integration_steps_ = 0.0;    // count towards the limit [steps of a body]
    std::uint64_t begun_before_ = 0;    // contacts at the last update of integration_steps_
    bool paused_ = false;
    Outcome outcome_ = Outcome::ok;
    std::vector<i64> ended_by_;
    WallId ended_at_wall_;
    std::vector<ContactRecord> log_;
    mutable std::optional<GroupsAtPresent> groups_at_present_;  // until the run is advanced

    const Grid<3>& grid() const { return cells_.grids()[static_cast<std::size_t>(level_)]; }
    u32 size32() const { return static_cast<u32>(particles_.size()); }
    double radius(int i) const { return laws_.radius(static_cast<std::size_t>(i)); }
    double mass(int i) const { return laws_.mass(static_cast<std::size_t>(i)); }
    // second < 0: a wall.
    Law law(int first, int second) const { return laws_(first, second); }
    bool free(int i) const { return pending_[i].group < 0; }
    bool clustered(int i) const { return pending_[i].clustered; }
    Group& group(int i) { return groups_[static_cast<std::size_t>(i)]; }
    const Group& group(int i) const { return groups_[static_cast<std::size_t>(i)]; }

    auto prefetcher() const {
        return Prefetcher{calendar_queue_,
                          cells_,
                          pending_.data(),
                          particles_.data(),
                          [this](u32) { return level_; },
                          [this](u32 id) { laws_.fetch(id); },
                          [this](u32 id) { prefetch(&pending_[id]); }};
    }

    auto by_original_index() const {
        return [this](auto id) { return pending_[id].original_index; };
    }
    auto is_valid() const {
        return [this](const ContactEnd& of) {
            const BodyEvents& e = pending_[of.first];
            return e.end == of.time && e.group == of.group && !e.clustered;
        };
    }
    void prefetch_contact_ends() const;
    void process_event(int i);

    // cells.hpp
    void find_extreme_radii(std::size_t n);
    double initial_safety_radius(const System& s) const;
    double smallest_edge() const;
    void make_cells(std::size_t n, const hardlimit_abi::TouchKernels& kernels);
    void sort_in(const System& s);
    void put_into_cells();
    void restart_calendar_queue();
    void reserve_candidates() const;
    Block around(const Place<3>& at) const;
    template <class F>
    void for_neighbours(int i, const F& f) const;
    void leave_cell(int i);

    // sheared_side.hpp
    template <class F>
    void for_sides(const Block& in, const F& f) const;
    void cross_sheared_side(int i, int step);
    void fold_into_column(int i);
    void tilt_cells();
    BodyImage nearest_image(const Vector3& r) const;
    void set_sheared_member(Group& g, std::size_t m, Member& member) const;
    void set_sheared_image(const Member& a, const Member& b, ContactPair<Law>& q) const;
    ImageMotion cell_frame(const Group& g, std::size_t m, double time) const;
    template <class Velocity>
    double sheared_energy(const Group& g, const Velocity& velocity) const;
    template <class Velocity>
    double shear_work(const Group& g, const Velocity& velocity) const;
    double shear_work_of_contact(const Group& g) const;

    // flight.hpp
    Vector3 position(int i, double t) const;
    Vector3 velocity(int i, double t) const;
    bool meets_wall(int i, const Wall& wall) const;
    void restart_path(int i);
    void schedule(int i);
    void reschedule(int i);
    void predict_events(int i);
    void predict_events_of_query(int i);
    std::vector<int> predict_first_events();
    void predict_events_without(int i, int other);
    void set_query(int i);
    void predict_collisions(int i, const Block& in);
    void predict_part(int i, const Block& in);
    void take_candidates(int i, const hardlimit_abi::EarliestContact& touched);
    void take_candidate(int i, u32 id, double enlarged_time);
    double collision_time(int i, int j, double enlarged_time) const;
    RelativeMotion relative_motion(int j) const;
    bool stays_clear(const RelativeMotion& between, int i, int member, double from,
                     double other_radius) const;
    double time_at_distance(int j, double distance) const;
    void predict_self_event(int i, const Place<3>& at);

    // groups.hpp
    bool begin_contacts(const std::vector<int>& touching);
    void begin_contact(int i, int j, WallId wall);
    ActivePair active_pair(int i, int j, WallId wall) const;
    void resolve_conflict(int i, int j);
    void end_cluster(int i);
    void end_isolated_contact(int index);
    void form_parts();
    void split_cluster(const std::vector<int>& bodies, const std::vector<ActivePair>& active);
    void open_isolated_contact(Group& g, int i, int j, WallId wall) const;
    bool try_isolated_contact(int i, int j, WallId wall, int& third_body);
    void form_group(ClusterSeed& set);
    void absorb(int i, ClusterSeed& set);
    void absorb_touching(std::size_t last, ClusterSeed& set);
    void find_third_bodies(int i, int index, std::vector<int>& near) const;
    void schedule_group(int index);
    bool ends_too_deep(int index);
    void end_run(Outcome outcome, const std::vector<int>& bodies, WallId wall = {});

    // membership.hpp
    int new_group();
    void discard_group(int index);
    void dissolve_group(int index, bool at_end, std::vector<ActivePair>& active);
    void revert_group(int index);
    void join_group(int i, int index, std::size_t m, double span);
    void release_members(int i);
    void restart_body(const Group& g, std::size_t m, const Member& at);
    Vector3 body_position(const Group& g, std::size_t m, Vector3 x, double time) const;
    Vector3 body_velocity(const Group& g, std::size_t m, Vector3 v) const;

    // cluster_setup.hpp
    void build_cluster(int index, ClusterSeed& set);
    bool exceeds_step_budget(const Cluster<Law>& c);
    void reset_cluster(Cluster<Law>& c, double base) const;
    void open_group(Group& g, const std::vector<int>& set) const;
    void set_member(Group& g, std::size_t m, Member& member) const;
    void make_pairs(Group& g, std::vector<ActivePair>& active) const;
    void set_wall_pieces(Group& g) const;
    bool may_touch(const Member& a, const Member& b) const;
    void carry_over(ContactPair<Law>& q, ContactPair<Law>& old, const Cluster<Law>& c) const;
    double nearest_period(double x, int axis) const;
    void set_pair(const Group& g, int i, int j, const Member& a, const Member& b, ContactPair<Law>& q) const;
    bool near_wall(int i, const Wall& wall) const;
    double wall_distance(int i, const Wall& wall) const;
    ContactPair<Law> wall_pair(const Group& g, int i, const Wall& wall) const;
    double horizon_of(const Group& g) const;
    double time_to_cover(double distance, double speed, bool falls) const;
    double time_to_a_wall(const Group& g, double speed) const;
    void initial_cluster(const Group& g, Cluster<Law>& c) const;

    // safety_radius.hpp
    bool set_safety_radii(int index);
    double deviation_from_path(const Group& g, std::size_t m) const;
    void assign_path(int index, std::size_t m, const Member& before, const Member& after, double span);
    void set_safety_radii(IsolatedContact& l) const;
    void follow_outgoing_path(int index, std::size_t m, const Member& after);
    void set_radius(int i, double safety_radius);
    double safety_radius_used(const Group& g, std::size_t m, const Vector3& at, double time) const;
    double speed_from_rounding(const Group& g) const;

    // isolated_contact.hpp
    static TabulatedContacts<Law, true> soft_contacts(const PairLaws<Law>& laws, std::size_t count,
                                                      const hardlimit_abi::TouchKernels& kernels);
    bool solve_pair(Group& g, SeparatedMembers& after);
    void separate_pair(IsolatedContact& l, SeparatedMembers& after, const PlanarContact& end,
                       const Vector3& normal, const Vector3& tangent) const;
    bool solve_wall(Group& g, SeparatedMembers& after);
    bool far_from_walls(const Group& g, const SeparatedMembers& after) const;

    // observe.hpp
    const GroupsAtPresent& groups_at_present() const;
    bool set_present_contact(const Group& g, Cluster<Law>& c) const;
    void add_group(GroupsAtPresent& present, const Group& g, Cluster<Law>& c) const;
    template <class F>
    void for_bodies(const F& f) const;
    void log(const Group& g, const ContactPair<Law>& q, const EndedContact& e);
    ContactRecord contact_row(const Group& g, const ContactPair<Law>& q, const EndedContact& e) const;

    // checkpoint.hpp
    template <class Archive>
    void exchange(Archive& archive);
    template <class Archive>
    static void exchange(Archive& archive, Group& g);
    template <class Archive, class T, std::size_t most_in_place>
    static void exchange(Archive& archive, SmallVector<T, most_in_place>& list);
    template <class Archive>
    static void exchange(Archive& archive, Cluster<Law>& c);
};

template <class Law>
void NewtonEvents<Law>::advance(double until, u64 most_work, int /*threads*/, Stop& stop) {
    const u64 last = most_work > ~events_ ? ~u64{0} : events_ + most_work;
    paused_ = false;
    groups_at_present_.reset();
    while (outcome_ == Outcome::ok) {
        const QueuedEvent* due =
            calendar_queue_.next([this](u32 id) { return pending_[id].time(); }, by_original_index(),
                                 [this] {
                                     if (prefetches_) prefetcher().enter_bin();
                                 });
        const ContactEnd* ending = contact_ends_.next(is_valid(), by_original_index());
        const bool ends = ending && !(due && due->time < ending->time);
        const double event = ends ? ending->time : due ? due->time : math::infinity;
        const bool tilts = event > cells_.next_tilt();
        const double time = tilts ? cells_.next_tilt() : event;
        if (time > until || time == math::infinity) break;
        if (events_ >= last || (tilts ? stop.now() : stop())) {
            paused_ = true;
            return;
        }
        now_ = math::max(now_, time);
        if (tilts) {
            tilt_cells();
            continue;
        }
        ++events_;
        if (ends) {
            const int index = ending->group;
            contact_ends_.pop(by_original_index());
            if (prefetches_) prefetch_contact_ends();
            end_isolated_contact(index);
            continue;
        }
        const int i = static_cast<int>(due->id);
        calendar_queue_.pop();
        if (prefetches_) prefetcher().step();
        process_event(i);
    }
    if (outcome_ == Outcome::ok) now_ = math::max(now_, until);
}

template <class Law>
void NewtonEvents<Law>::prefetch_contact_ends() const {
    const auto record = [this](const ContactEnd& of) {
        prefetch(&group(of.group));
        prefetch(&pending_[of.first]);
        prefetch(&particles_[of.first]);
    };
    const auto second = [this](const ContactEnd& of) {
        const int i = group(of.group).isolated_contact.body[1];
        if (i < 0) return;
        prefetch(&pending_[i]);
        prefetch(&particles_[i]);
    };
    contact_ends_.ahead(record, second);
}

template <class Law>
void NewtonEvents<Law>::process_event(int i) {
    const PendingEvents& e = pending_[i];
    if (e.pair_time <= e.own_time) {
        if (pending_[e.partner].count != e.partner_count) return reschedule(i);
        const int j = static_cast<int>(e.partner);
        return free(i) && free(j) ? begin_contact(i, j, {}) : resolve_conflict(i, j);
    }
    const SelfEvent own = static_cast<SelfEvent>(e.own);
    if (own == SelfEvent::ends) return end_cluster(i);
    if (is_wall(own))
        return meets_wall(i, box_.wall(wall_at(own))) ? begin_contact(i, -1, wall_at(own)) : reschedule(i);
    leave_cell(i);
}

}  // namespace hardlimit::boxes

#include "cells.hpp"
#include "checkpoint.hpp"
#include "cluster_setup.hpp"
#include "flight.hpp"
#include "groups.hpp"
#include "isolated_contact.hpp"
#include "membership.hpp"
#include "observe.hpp"
#include "safety_radius.hpp"
#include "sheared_side.hpp"
