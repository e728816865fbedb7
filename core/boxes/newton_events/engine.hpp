// Newton's equations for a box of spheres or disks, from event to event.
//
// Between contacts bodies fly on parabolas, known exactly. Bodies in contact form groups, solved from their `begin`
// to an `end` at which their contacts are over, or for a while: a contact that nothing disturbs in the plane of its
// approach (planar_contact.hpp), contacts that share a body by integration (cluster.hpp). Until its end the members of
// a group are busy. To the others, each of them is a body on a parabola, larger by the `margin`, the most by which its
// true path leaves that parabola. As long as no other body comes so near, nothing can act on the group and its end
// stands. When one does (a conflict), the group is integrated again, up to now, and goes on together with that body.
// So no contact is missed, and nothing is done that a later event could change.
//
// The parabola of a member of a cluster leads from one end of its path to the other, and what is to be met beyond is
// found at the end. That of a body in an undisturbed contact is the one on which it flies on, followed backwards from
// the end: whom it meets then is found at once, and its end changes nothing but its size.
//
// Bodies are held, found and scheduled like hard spheres (hard_spheres/): a record, two pending events and a cell
// each, in the order of the cells. The end of a cluster is an event of its first member's own. Undisturbed contacts
// end in a queue of their own, which is short, and their members' events stand.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "../../base/outcome.hpp"
#include "../binary_contact/tabulated_contact.hpp"
#include "../common/archive.hpp"
#include "../common/bodies.hpp"
#include "../common/contact_record.hpp"
#include "../common/pair_laws.hpp"
#include "../kernels/touch_kernel.hpp"
#include "../neighbours/cells.hpp"
#include "../queue/calendar_queue.hpp"
#include "../queue/prediction.hpp"
#include "../queue/prefetch.hpp"
#include "cluster/cluster.hpp"
#include "contact_end_queue.hpp"

namespace hardlimit::boxes {

template <class Law>
class NewtonEvents {
public:
    using Row = ContactRecord;

    // For a contact's time the integration of a group takes the square of its members: each of its contacts ends a step
    // of all. From so many members on it ends after so many steps, for whoever comes near makes it begin anew,
    static constexpr std::size_t large_group = 50;
    static constexpr long steps_of_large_group = 64;
    // and a small one after so many, which only those take that come to rest: a run can be stopped between groups.
    static constexpr long steps_of_small_group = 10'000;
    // The steps of their members are counted. Where they are so many for each body and each contact that has begun,
    // contacts last, and small steps are cheaper; small groups may take as many as those of so many bodies.
    static constexpr double most_work = 1e4, fewest_bodies = 1e3;
    // A group that others join goes on as if it had formed just then, up to so many members. A larger one ends when it
    // was to, and falls apart into what hangs together: else bodies that have parted long ago stay, more of them join
    // than leave, and in a large gas such a group grows without end.
    static constexpr std::size_t most_lasting = 8;
    // By which the line of centres turns in a contact that is solved as a whole [rad].
    static constexpr double widest_turn = 1.0;
    // Part of the sum of the radii up to which overlap at the start is rounding.
    static constexpr double touching_depth = 1e-9;

    // position, velocity [3 N], body by body; positions in the box. Bodies that overlap are in contact from the start.
    NewtonEvents(const Box& box, const std::vector<double>& position, const std::vector<double>& velocity,
                 PairLaws<Law> laws, bool log, const hardlimit_abi::TouchKernels& kernels);
    NewtonEvents(const Box& box, PairLaws<Law> laws, std::size_t count, bool log,
                 const hardlimit_abi::TouchKernels& kernels, Reader& reader);

    // To `until`, or until so many events have happened, or until `stop`.
    void advance(double until, std::uint64_t most_events, Stop& stop);
    bool paused() const { return paused_; }
    double time() const { return now_; }
    Outcome outcome() const { return outcome_; }
    // Where a run ended early: the members of the group or of the contact, by the user's numbers; and the wall of the
    // contact, or 0.
    const std::vector<i64>& ended_by() const { return ended_by_; }
    i64 ended_at_wall() const { return ended_at_wall_; }
    std::uint64_t events() const { return events_; }
    int largest_cluster() const { return largest_cluster_; }
    // Part of all time that bodies have spent in groups of several contacts.
    double cluster_share() const;
    // Contacts so far, but for those that began or ended in a group that is still together.
    std::uint64_t contacts_reached() const { return begun_; }
    std::uint64_t contacts_logged() const { return ended_; }

    // What is true now. Groups are integrated on the side; nothing changes.
    struct Survey {
        std::vector<double> position, velocity;  // [3 N], along the unfolded paths
        double kinetic, potential, contact, dissipated;
        double momentum[3];
        double virial;               // ∫ Σ r·F dt over pairs since the start [J s]
        double largest_compression;  // of all contacts so far, over the smaller radius
        std::uint64_t in_contact, begun, begun_pairs, ended, overlapped;
        std::vector<Row> open;  // contacts that last, and those that are over in groups still together
    };
    Survey survey() const;
    // What part of its margin the members of groups use, at most, at so many instants of each group: above 1, one would
    // leave the space in which others look for it. Groups are integrated on the side.
    double margin_used(int instants) const;
    std::vector<Row> take_log() { return std::exchange(log_, {}); }

    void save(Writer& writer) const;

private:
    // A contact with which nothing interferes. In a large box each cache line is a wait: the first has what its end
    // needs, the second what is needed where somebody comes near.
    struct Isolated {
        int body[2];              // second < 0: a wall
        double dissipated;        // [J]
        double virial;            // [J s]
        double compression;       // the greatest, over the smaller radius
        alignas(64) double span;  // [s]
        double share[2];          // of what happens to the relative path, that of each member
        double room[2];           // by which a member's path can leave the triangle of passes() [m]
        Vector3 off;    // at touch, from the relative path on which the bodies fly on to the true one [m]
        double margin;  // its length, the most by which the true path is off [m]
        double turn;    // of the line of centres [rad]
        Member before[2];
        Touching<Law> pair;
        EndedContact contact;
    };
    using Parted = std::array<Member, 2>;  // the members at the end of such a contact
    struct Ends {
        Cluster<Law> before, after;
    };
    struct Group {
        Isolated lone{};  // if isolated
        bool alive = false, isolated = false;
        double until = 0.0;  // a large one falls apart [s]
        Vector3 origin{};
        Few<int, 2> body;
        Few<Vector3, 2> offset;         // [members] turns of the frame in which the member's place is given
        std::unique_ptr<Ends> cluster;  // unless isolated
    };
    // A pair of a group that is not open, by its bodies.
    struct Live {
        int first, second;
        Touching<Law> pair;
    };
    // Which member of a group a body is.
    class MemberOf {
    public:
        explicit MemberOf(std::span<const int> bodies) : bodies_(bodies) {
            if (bodies.size() < few) return;
            for (std::size_t m = 0; m < bodies.size(); ++m) sorted_.emplace_back(bodies[m], m);
            std::sort(sorted_.begin(), sorted_.end());
        }
        std::size_t operator()(int body) const {
            if (sorted_.empty())
                return static_cast<std::size_t>(std::find(bodies_.begin(), bodies_.end(), body) -
                                                bodies_.begin());
            return std::lower_bound(sorted_.begin(), sorted_.end(), std::pair{body, std::size_t{0}})->second;
        }

    private:
        static constexpr std::size_t few = 16;
        std::span<const int> bodies_;
        std::vector<std::pair<int, std::size_t>> sorted_;
    };
    struct Relative {
        Vector3 place, velocity;
    };
    // What is held of a body beside its path: one cache line as well.
    struct alignas(64) Held : Pending {  // `count`: how often the body has been deflected
        double end = math::infinity;     // of its group [s]
        int group = -1;                  // or -1
        std::array<int, 3> turns{};      // how often the path has left the box through an edge
        u32 name = 0;                    // the user's number
        bool first = false;              // of its group; the end of a cluster is an event of its own
        bool clustered = false;          // its path ends with its group
        std::uint16_t unused = 0;
    };
    static_assert(sizeof(Held) == 64);
    // Bodies that are to form a group, and when it is to end at the latest.
    struct Joined {
        std::vector<int> body;
        std::vector<Live> live;
        double until = math::infinity;  // [s]
    };

    Box box_;
    Box cell_box_;  // a two-dimensional one is one cell deep
    PairLaws<Law> laws_;        // by place in memory, once it is known
    SoftContacts<Law, true> soft_;
    bool keep_log_;
    // By place in memory. A path is a parabola that starts at its `time`, in the frame of the cell; its radius is that
    // of the space a busy body needs.
    Records<Particle<3>> paths_;
    Records<Held> pending_;
    Records<Group> groups_;
    std::vector<int> spare_;
    std::vector<Joined> remnants_;  // whose contacts go on after their group has ended; empty between events
    Cells<3> cells_;
    int level_ = 0;
    Calendar calendar_;
    Endings endings_;  // of undisturbed contacts
    hardlimit_abi::TouchKernels::Of touch_{};
    const hardlimit_abi::SeriesKernels* series_ = nullptr;
    hardlimit_abi::TouchQuery query_{};  // what is the same in all, once for all
    double settled_ = 0.0;  // after that the kernel's times for free bodies are those of meeting() [s]
    mutable Scratch<u32> candidates_;
    mutable Scratch<double> times_;  // until they are touched [s]
    Vector3 gravity_;
    double largest_ = 0.0, smallest_ = math::infinity;
    double widest_margin_ = 0.0;  // that cells are wide enough for [m]
    double travel_ = 0.0;         // how far a member may go while its group lasts [m]
    bool images_ = false;         // several of a body may be near
    bool walled_ = false;         // there are walls
    bool fetches_ = false;        // all that is held is too large for the caches
    double now_ = 0.0, virial_ = 0.0, clustered_ = 0.0;
    double dissipated_ = 0.0;  // and what slack pairs still hold [J]
    std::uint64_t begun_ = 0, begun_pairs_ = 0, ended_ = 0, overlapped_ = 0, events_ = 0;
    int largest_cluster_ = 0;
    double largest_compression_ = 0.0;  // but for groups still together
    double work_ = 0.0;                 // that counts [steps of a body]
    std::uint64_t begun_before_ = 0;    // contacts, when it was counted last
    bool paused_ = false;
    Outcome outcome_ = Outcome::ok;
    std::vector<i64> ended_by_;
    i64 ended_at_wall_ = 0;
    std::vector<Row> log_;

    u32 size32() const { return static_cast<u32>(paths_.size()); }
    double radius(int i) const { return laws_.radius(static_cast<std::size_t>(i)); }
    double mass(int i) const { return laws_.mass(static_cast<std::size_t>(i)); }
    // second < 0: a wall.
    Law law(int first, int second) const { return laws_(first, second); }
    bool free(int i) const { return pending_[i].group < 0; }
    bool clustered(int i) const { return pending_[i].clustered; }
    Group& group(int i) { return groups_[static_cast<std::size_t>(i)]; }
    const Group& group(int i) const { return groups_[static_cast<std::size_t>(i)]; }

    double smallest_edge() const;

    static SoftContacts<Law, true> soft_contacts(const PairLaws<Law>& laws, std::size_t count,
                                                 const hardlimit_abi::TouchKernels& kernels);

    auto ahead() const {
        return LookAhead{calendar_,
                         cells_,
                         pending_.data(),
                         paths_.data(),
                         [this](u32) { return level_; },
                         [this](u32 id) { laws_.fetch(id); },
                         [this](u32 id) { prefetch(&pending_[id]); }};
    }

    auto by_name() const {
        return [this](auto id) { return pending_[id].name; };
    }
    auto stands() const {
        return [this](const Ending& of) {
            const Held& e = pending_[of.first];
            return e.end == of.time && e.group == of.group && !e.clustered;
        };
    }
    void fetch_endings() const;

    // newton_events/flight.hpp
    Vector3 position(int i, double t) const;
    Vector3 velocity(int i, double t) const;
    void note_radii(std::size_t n);
    double usual_margin(const std::vector<double>& velocity) const;
    void make_cells(std::size_t n, const hardlimit_abi::TouchKernels& kernels);
    void put_into_cells();
    void take(const std::vector<double>& position, const std::vector<double>& velocity);
    void restart_calendar();
    void schedule(int i);
    void predict(int i);
    void find(int i);
    void find_but(int i, int other);
    void look(int i);
    void make_room_for_candidates() const;
    struct Block {
        Place<3> from, to;
    };
    Block around(const Place<3>& at) const;
    void search(int i, const Block& in);
    void examine(int i, const hardlimit_abi::Touched& touched);
    void consider(int i, u32 id, double grown);
    double meeting(int i, int j, double grown) const;
    Relative relative(int j) const;
    bool passes(const Relative& between, int i, int member, double from, double other_radius) const;
    double touch_time(int j, double reach) const;
    void predict_own(int i, const Place<3>& at);
    template <class F>
    void for_near(int i, const F& f) const;
    void happen(int i);
    void leave_cell(int i);

    // groups.hpp
    void begin_contacts();
    void meet(int i, int j, int side);
    Live touching(int i, int j, int side) const;
    void conflict(int i, int j);
    void form_remnants();
    void finish(int i);
    void finish_isolated(int index);
    void part(const std::vector<int>& bodies, const std::vector<Live>& live);
    void go_on_together(int index);
    bool isolate(int i, int j, int side, int& intruder);
    void form(Joined& set);
    void gather_touching(std::size_t last, Joined& set);
    void build(int index, Joined& set);
    bool takes_too_long(const Cluster<Law>& c);
    void end_here(Outcome outcome, const std::vector<int>& bodies, i64 wall = 0);
    bool ends_too_deep(int index);
    int spare_group();
    void open_group(Group& g, const std::vector<int>& set) const;
    void pair_up(Group& g, std::vector<Live>& live) const;
    bool may_touch(const Member& a, const Member& b) const;
    void adopt(Touching<Law>& q, Touching<Law>& old, const Cluster<Law>& c) const;
    double nearest(double x, int axis) const;
    void put_member(Group& g, std::size_t m, Member& member) const;
    void put_pair(const Group& g, int i, int j, const Member& a, const Member& b, Touching<Law>& q) const;
    bool near_wall(int i, int axis, bool high) const;
    double to_wall(int i, int axis, bool high) const;
    Touching<Law> wall_of(const Group& g, int i, int axis, bool high) const;
    double horizon_of(const Group& g) const;
    double time_to_cover(double distance, double speed, bool falls) const;
    double time_to_a_wall(const Group& g, double speed) const;
    bool margins(int index);
    double margin_of(const Group& g, std::size_t m) const;
    void busy(int index, std::size_t m, const Member& before, const Member& after, double span,
              double margin);
    void note_shares(Isolated& l) const;
    void fly_on_from(int index, std::size_t m, const Member& after);
    void join(int i, int index, std::size_t m, double span);
    void make_room_for(int i, double margin);
    void intruders(int i, int index, std::vector<int>& near) const;
    void stop_at_now(int i);
    void gather(int i, Joined& set);
    void settle(int index, bool at_end, std::vector<Live>& live);
    void log(const Group& g, const Touching<Law>& q, const EndedContact& e);
    void drop(int index);
    void release(int index);
    void set_free(int i);
    void put(const Group& g, std::size_t m, const Member& at);
    Vector3 place(const Group& g, std::size_t m, Vector3 x) const;
    void start(const Group& g, Cluster<Law>& c) const;
    Row row_of(const Group& g, const Touching<Law>& q, const EndedContact& e) const;

    // safety_radius.hpp
    double margin_used(const Group& g, std::size_t m, const Vector3& place, double time) const;

    // isolated_contact.hpp
    bool solve_pair(Isolated& l, Parted& after);
    void part_pair(Isolated& l, Parted& after, const PlanarContact& end, const Vector3& normal,
                   const Vector3& across) const;
    bool solve_wall(Isolated& l, Parted& after);
    bool far_from_walls(const Group& g, const Parted& after) const;

    template <class Archive>
    void exchange(Archive& archive);
    template <class Archive>
    static void exchange(Archive& archive, Group& g);
    template <class Archive, class T, std::size_t most_in_place>
    static void exchange(Archive& archive, Few<T, most_in_place>& list);
    template <class Archive>
    static void exchange(Archive& archive, Cluster<Law>& c);
};

template <class Law>
NewtonEvents<Law>::NewtonEvents(const Box& box, const std::vector<double>& position,
                                const std::vector<double>& velocity, PairLaws<Law> laws, bool log,
                                const hardlimit_abi::TouchKernels& kernels)
    : box_(box),
      laws_(std::move(laws)),
      soft_(soft_contacts(laws_, position.size() / 3, kernels)),
      keep_log_(log),
      gravity_(std::to_array(box.gravity)) {
    const std::size_t n = position.size() / 3;
    note_radii(n);
    widest_margin_ = usual_margin(velocity);
    make_cells(n, kernels);
    take(position, velocity);
    begin_contacts();
    for (int i = 0; i < static_cast<int>(n); ++i)
        if (free(i)) find(i);
    restart_calendar();
}

// Fitted to a pair of the first bodies. Whether the damping differs from pair to pair shows between the smallest and
// the largest body; any other pair that does not fit is solved by itself.
template <class Law>
SoftContacts<Law, true> NewtonEvents<Law>::soft_contacts(const PairLaws<Law>& laws, std::size_t count,
                                                         const hardlimit_abi::TouchKernels& kernels) {
    std::size_t least = 0, most = 0;
    for (std::size_t i = 1; i < count; ++i) {
        if (laws.radius(i) < laws.radius(least)) least = i;
        if (laws.radius(i) > laws.radius(most)) most = i;
    }
    const auto mass = [&](std::size_t i, std::size_t j) { return effective(laws.mass(i), laws.mass(j)); };
    const auto reach = [&](std::size_t i, std::size_t j) { return laws.radius(i) + laws.radius(j); };
    const auto damping = [&](std::size_t i, std::size_t j) {
        const Law law = laws(static_cast<std::int64_t>(i), static_cast<std::int64_t>(j));
        return SoftContacts<Law, true>::damping(law, mass(i, j), reach(i, j));
    };
    const double of_most = damping(most, most);
    const auto differs = [&](double other) { return math::abs(other - of_most) > 1e-13 * of_most; };
    const bool varies = differs(damping(least, least)) || differs(damping(least, most));
    const auto first = static_cast<std::int64_t>(most);
    return {laws(first, first), mass(most, most), reach(most, most), varies, kernels.read_cell};
}

template <class Law>
void NewtonEvents<Law>::advance(double until, std::uint64_t most_events, Stop& stop) {
    const std::uint64_t last = most_events > ~events_ ? ~std::uint64_t{0} : events_ + most_events;
    paused_ = false;
    while (outcome_ == Outcome::ok) {
        const Due* due = calendar_.next([this](u32 id) { return pending_[id].time(); }, by_name(),
                                        [this] {
                                            if (fetches_) ahead().enter_bin();
                                        });
        const Ending* ending = endings_.next(stands(), by_name());
        const bool ends = ending && !(due && due->time < ending->time);
        if (!ends && !due) break;
        const double time = ends ? ending->time : due->time;
        if (time > until) break;
        if (events_ >= last || stop()) {
            paused_ = true;
            return;
        }
        now_ = math::max(now_, time);
        ++events_;
        if (ends) {
            const int index = ending->group;
            endings_.pop(by_name());
            if (fetches_) fetch_endings();
            finish_isolated(index);
            continue;
        }
        const int i = static_cast<int>(due->id);
        calendar_.pop();
        if (fetches_) ahead().step();
        happen(i);
    }
    if (outcome_ == Outcome::ok) now_ = math::max(now_, until);
}

template <class Law>
void NewtonEvents<Law>::fetch_endings() const {
    const auto record = [this](const Ending& of) {
        prefetch(&group(of.group));
        prefetch(&pending_[of.first]);
        prefetch(&paths_[of.first]);
    };
    const auto second = [this](const Ending& of) {
        const int i = group(of.group).lone.body[1];
        if (i < 0) return;
        prefetch(&pending_[i]);
        prefetch(&paths_[i]);
    };
    endings_.ahead(record, second);
}

template <class Law>
double NewtonEvents<Law>::smallest_edge() const {
    double least = math::infinity;
    for (int axis = 0; axis < box_.dimension; ++axis)
        if (box_.wraps(axis)) least = math::min(least, box_.edge[axis]);
    return least;
}

template <class Law>
double NewtonEvents<Law>::cluster_share() const {
    return now_ > 0.0 ? clustered_ / (now_ * static_cast<double>(paths_.size())) : 0.0;
}

template <class Law>
typename NewtonEvents<Law>::Survey NewtonEvents<Law>::survey() const {
    const std::size_t n = paths_.size();
    Survey s{std::vector<double>(3 * n),
             std::vector<double>(3 * n),
             0.0,
             0.0,
             0.0,
             dissipated_,
             {},
             virial_,
             largest_compression_,
             0,
             begun_,
             begun_pairs_,
             ended_,
             overlapped_,
             {}};
    const auto write = [&](int i, const Vector3& x, const Vector3& v) {
        const std::size_t at = 3 * std::size_t{pending_[i].name};
        const double m = mass(i);
        for (std::size_t a = 0; a < 3; ++a) {
            s.position[at + a] = x[a] + pending_[i].turns[a] * box_.edge[a];
            s.velocity[at + a] = v[a];
            s.kinetic += 0.5 * m * v[a] * v[a];
            s.potential -= m * box_.gravity[a] * s.position[at + a];
            s.momentum[a] += m * v[a];
        }
    };
    for (int i = 0; i < static_cast<int>(n); ++i)
        if (free(i)) write(i, position(i, now_), velocity(i, now_));
    Cluster<Law> c;
    for (const Group& g : groups_) {
        if (!g.alive) continue;
        start(g, c);
        c.run_through(now_ - c.base);
        const double slack = c.stored(Touch::slack);
        s.contact += c.stored(Touch::closed) + slack;
        s.dissipated += c.dissipated - slack;
        s.virial += c.virial;
        s.largest_compression = math::max(s.largest_compression, c.largest_compression);
        s.begun += static_cast<std::uint64_t>(c.begun);
        s.begun_pairs += static_cast<std::uint64_t>(c.begun_pairs);
        for (std::size_t m = 0; m < g.body.size(); ++m)
            write(g.body[m], place(g, m, c.members[m].position), c.members[m].velocity);
        for (const EndedContact& e : c.ended) {
            ++s.ended;
            s.overlapped += e.overlapped;
            s.open.push_back(row_of(g, c.pairs[static_cast<std::size_t>(e.pair)], e));
        }
        for (const Touching<Law>& q : c.pairs) {
            if (q.touch != Touch::closed) continue;
            ++s.in_contact;
            s.open.push_back(row_of(g, q, {0, q.begin, math::nan, q.impact_speed, math::nan, q.overlapped}));
        }
    }
    return s;
}

}  // namespace hardlimit::boxes

#include "checkpoint.hpp"
#include "flight.hpp"
#include "groups.hpp"
#include "isolated_contact.hpp"
#include "safety_radius.hpp"
