// Newton's equations for a box of spheres or disks in small equal steps.
//
// Leapfrog: the forces at t_n change the velocities from t_n − h/2 to t_n + h/2, with which the bodies move on to
// t_{n+1}. A force that depends on the velocity is taken at v_n = v_{n−1/2} + a_n h/2, where a_n holds this force
// itself (steps/strength.hpp says how, and what is dissipated) and those of the step before of other contacts; with
// the velocity half a step ago, ε is right to first order only. New contacts get the impulse that equal steps miss
// (steps/onset.hpp). So positions, velocities, energies and ε are all of second order in h.
//
// A step is a sweep over the list of neighbours, which finds the few pairs in contact, and a pass that moves all
// bodies, slab by slab (steps/schedule.hpp). An advance begins and ends with half a step of the velocities: between
// two calls they belong to the time of the positions.
//
// The list is made anew once a body may have moved by half the skin. The sum of the largest speeds bounds that; where
// the bound says so, distances are measured, since in a dense box bodies do not get far.
//
// Threads meet only after a course of steps (steps/schedule.hpp): so many that the bound will hold if no speed exceeds
// a limit, with room for a body that does so for one step. Such a body ends the course with the next step. Courses
// follow from the state alone and pauses leave them as they are, so lists are made at the same steps in any case. Where
// a body was too fast for that room, distances show whether the list was still good for the last step.
#pragma once
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <utility>
#include <vector>

#include "../../base/outcome.hpp"
#include "../../base/threads.hpp"
#include "../common/archive.hpp"
#include "../neighbours/sorting.hpp"
#include "forces.hpp"
#include "schedule.hpp"
#include "thread_team.hpp"

namespace hardlimit::boxes {

// Of a box of bodies at one instant.
struct StepsObservables {
    double kinetic, potential, contact, dissipated;  // energies [J]; dissipated since the start
    double momentum[3];                              // [kg m/s]
    double virial;                                   // ∫ Σ r·F dt over pairs since the start [J s]
    std::uint64_t in_contact;                        // contacts that last
};

template <class Law>
class NewtonSteps {
public:
    using Box = boxes::Box;
    using Row = ContactRow;

    // position, velocity [3 N], body by body; positions in the box.
    NewtonSteps(const Box& box, const std::vector<double>& position, const std::vector<double>& velocity,
                PairLaws<Law> laws, double time_step, bool log)
        : NewtonSteps(box, std::move(laws), position.size() / 3, time_step, log) {
        for (std::size_t i = 0; i < position.size() / 3; ++i) {
            const double* x = position.data() + 3 * i;
            const double* v = velocity.data() + 3 * i;
            bodies_.place.push_back(steps::four(x[0], x[1], x[2], laws_.radius(i)));
            bodies_.motion.push_back(steps::four(v[0], v[1], v[2], 1.0 / laws_.mass(i)));
            bodies_.label.push_back({static_cast<std::uint32_t>(i), {0, 0, 0}});
            fastest_ = math::max(fastest_, math::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]));
        }
        bodies_.push.resize(bodies_.count());
        start();
    }
    // As saved.
    NewtonSteps(const Box& box, PairLaws<Law> laws, std::size_t bodies, double time_step, bool log,
                Reader& reader)
        : NewtonSteps(box, std::move(laws), bodies, time_step, log) {
        exchange(reader);
    }
    void save(Writer& writer) { exchange(writer); }

    // To `until` in equal steps of at most the time step. After `most_steps`, or where the watch says stop, the run
    // pauses on the way: asked to go on to the same time, it does as if nothing had been, to the last bit.
    template <class Watch>
    void advance(double until, std::uint64_t most_steps, int threads, std::chrono::milliseconds period,
                 const Watch& watch) {
        if (outcome_ != Outcome::ok) return;
        quota_ = std::max(most_steps, std::uint64_t{1});
        if (paused_ && until != until_) planned_ = done_;
        if (paused_) go(threads, period, watch);
        if (paused_ || !(until > time_) || outcome_ != Outcome::ok) return;
        plan(until);
        go(threads, period, watch);
    }
    bool paused() const { return paused_; }

    double time() const { return time_; }
    double time_step() const { return time_step_; }
    std::uint64_t steps_taken() const { return taken_; }
    Outcome outcome() const { return outcome_; }
    // Where a run ended early: the body that moved too far in a step, or the bodies of the contact that was too deep,
    // by the user's numbers; and its wall, or 0.
    const std::vector<i64>& ended_by() const { return ended_by_; }
    i64 ended_at_wall() const { return ended_at_wall_; }
    // At the instants of the steps, over the smaller radius.
    double largest_compression() const {
        double largest = largest_compression_;
        for (const Slab& s : slabs_) largest = math::max(largest, s.largest_compression);
        return largest;
    }
    const steps::ContactLog& log() const { return log_; }
    std::size_t count() const { return bodies_.count(); }
    double skin() const { return skin_; }
    std::uint64_t lists_made() const { return lists_; }
    // While another thread advances: the time and the contacts so far.
    double time_reached() const { return reached_.load(std::memory_order_relaxed); }
    std::uint64_t contacts_reached() const { return contacts_.load(std::memory_order_relaxed); }

    // Positions along the unfolded paths [m] and velocities [m/s], [3 N] each, by number. In a pause the velocities are
    // those expected, without the contacts of the last step.
    void state(double* position, double* velocity) const {
        for (std::size_t i = 0; i < bodies_.count(); ++i) {
            const steps::Label& label = bodies_.label[i];
            const Four v = velocity_of(i);
            for (int axis = 0; axis < 3; ++axis) {
                const std::size_t to = 3 * std::size_t{label.number} + static_cast<std::size_t>(axis);
                position[to] = bodies_.place[i][axis] + label.turns[axis] * box_.edge[axis];
                velocity[to] = v[axis];
            }
        }
    }

    StepsObservables observe() const {
        StepsObservables seen{};
        for (std::size_t i = 0; i < bodies_.count(); ++i) {
            const Four v = velocity_of(i);
            const double mass = 1.0 / bodies_.motion[i][3];
            seen.kinetic += 0.5 * mass * steps::dot(v, v);
            for (int axis = 0; axis < box_.dimension; ++axis) {
                const double x = bodies_.place[i][axis] + bodies_.label[i].turns[axis] * box_.edge[axis];
                seen.potential -= mass * box_.gravity[axis] * x;
                seen.momentum[axis] += mass * v[axis];
            }
        }
        seen.dissipated = dissipated_, seen.virial = virial_;
        for (const Slab& s : slabs_) {
            seen.dissipated += s.dissipated, seen.virial += s.virial;
            for (const Touch& t : s.touches) {
                if (t.at_first == steps::nobody) continue;
                seen.contact += t.law.energy(onset_root<Law::onset_power>(t.compression));
                seen.in_contact += t.closed;
            }
        }
        return seen;
    }

    // Contacts that have ended since the last call, in the order of their ends.
    std::vector<Row> take_log() { return log_.take(); }
    // Those that last.
    std::vector<Row> open_contacts() const {
        std::vector<Row> rows;
        for (const Slab& s : slabs_)
            for (const Touch& t : s.touches)
                if (t.at_first != steps::nobody && t.closed)
                    rows.push_back(log_.so_far(t, math::nan, math::nan));
        std::sort(rows.begin(), rows.end(), [](const Row& a, const Row& b) { return a.begin < b.begin; });
        return rows;
    }

private:
    using Slab = steps::Slab<Law>;
    using Touch = steps::Touch<Law>;
    using Four = steps::Four;
    enum class Phase { go_on, move, measure, cells, gather, list, step, over };
    static constexpr std::size_t most_slabs = steps::Course::most_slabs;
    static constexpr std::uint32_t most_ahead = 64;  // steps in a phase

    // What the tasks of a phase say to who ends it: only what is new, or it would have to fetch many cache lines.
    struct alignas(steps::apart) News {
        std::atomic<bool> faster{false};
        std::array<std::atomic<double>, most_ahead> fastest{};  // [m/s] in each step, if beyond fastest_
        std::array<std::atomic<bool>, most_slabs> changes{};    // contacts of a slab have begun or ended
        std::atomic<bool> too_deep{false};                      // a contact
    };
    // What the threads of a crew do.
    struct Job {
        NewtonSteps& of;

        void next(Stop& stop) const { of.next(stop); }
        std::uint32_t tasks(std::uint32_t share) const { return of.tasks(share); }
        bool ready(std::uint32_t share, std::uint32_t task) const { return of.ready(share, task); }
        void perform(std::uint32_t share, std::uint32_t task) const { of.perform(share, task); }
    };

    Box box_;
    PairLaws<Law> laws_;
    steps::Bodies bodies_;
    steps::Sorting sorting_;
    steps::Grid grid_;
    std::vector<std::uint32_t> start_;  // [cells + 1] first body of each cell
    std::vector<Slab> slabs_;
    steps::Course course_;
    std::vector<steps::Border> borders_ = std::vector<steps::Border>(most_slabs);  // of each slab
    std::vector<Touch> moving_;                                                    // while the list is made
    std::vector<std::pair<std::uint32_t, steps::Push>> moving_pushes_;

    double time_step_;                                                    // the longest [s]
    double widest_ = 0.0, mean_width_ = 0.0, smallest_ = math::infinity;  // diameters [m]
    double filled_ = 0.0;                                                 // share of the box
    double h_ = 0.0;                                                      // this one [s]

    // Between two phases one thread writes, here and below; in a phase all read, here and above.
    alignas(64) steps::Instant now_{};  // of the first step of the phase; between phases of the last one
    double kick_ = 0.0;                 // the time by which velocities go on in this phase [s]
    Phase phase_ = Phase::cells;
    double fastest_ = 0.0;  // no body was faster before this phase [m/s]
    double limit_ = 0.0;    // of the speeds of a course [m/s]

    News news_;

    alignas(64) double time_ = 0.0;
    double from_ = 0.0, until_ = 0.0;  // of this advance
    std::uint64_t planned_ = 0, done_ = 0, taken_ = 0;
    std::uint64_t quota_ = 0;  // steps until it pauses
    bool paused_ = false;
    Outcome outcome_ = Outcome::ok;
    std::vector<i64> ended_by_;
    i64 ended_at_wall_ = 0;

    double skin_ = 0.0;                         // [m]
    double travelled_ = 0.0, allowance_ = 0.0;  // how far a body may have moved, and may [m]
    std::uint64_t course_end_ = 0;              // among the steps taken
    bool unproven_ = false;                     // a step was made though a body may have moved further
    std::uint64_t lists_ = 0;

    double dissipated_ = 0.0, virial_ = 0.0, largest_compression_ = 0.0;  // before the list was made
    steps::ContactLog log_;
    std::vector<std::pair<std::uint32_t, std::size_t>> changes_;  // slab, place in its changes
    std::atomic<double> reached_{0.0};
    std::atomic<std::uint64_t> contacts_{0};

    NewtonSteps(const Box& box, PairLaws<Law> laws, std::size_t bodies, double time_step, bool log)
        : box_(box), laws_(std::move(laws)), sorting_(bodies), time_step_(time_step), log_(bodies, log) {
        for (std::size_t i = 0; i < bodies; ++i) {
            const double width = 2.0 * laws_.radius(i);
            widest_ = math::max(widest_, width);
            smallest_ = math::min(smallest_, width);
            mean_width_ += width / static_cast<double>(bodies);
            double part = math::pi / (box.dimension == 2 ? 4.0 : 6.0);
            for (int axis = 0; axis < box.dimension; ++axis) part *= width / box.edge[axis];
            filled_ += part;
        }
    }

    void plan(double until) {
        const double steps = (until - time_) / time_step_ * (1.0 - 1e-12);
        planned_ = static_cast<std::uint64_t>(math::max(0.0, steps)) + 1;
        from_ = time_, until_ = until, done_ = 0;
        h_ = (until - time_) / static_cast<double>(planned_);
        course_end_ = taken_;
        phase_ = Phase::go_on;
    }
    template <class Watch>
    void go(int threads, std::chrono::milliseconds period, const Watch& watch) {
        steps::Crew crew(threads);
        Job job{*this};
        divide(static_cast<std::uint32_t>(threads));
        open_borders();
        if (paused_) {
            Stop never;
            begin_step(never);
        }
        crew.begin(job);
        const auto work = [&](Stop& stop) { crew.work(stop, job); };
        try {
            Team().run(threads, period, work, watch);
        } catch (...) {  // a task was left half done, for want of memory say
            if (phase_ != Phase::over) outcome_ = Outcome::unresolved;
            throw;
        }
    }

    Four velocity_of(std::size_t i) const {
        if (!paused_) return bodies_.motion[i];
        return bodies_.motion[i] + (bodies_.push[i].at(now_.step) + steps::pull(box_)) * (0.5 * h_);
    }

    // --- phases ---------------------------------------------------------------------------------------------------

    std::uint32_t slabs() const { return static_cast<std::uint32_t>(slabs_.size()); }
    std::uint32_t before(std::uint32_t slab) const { return (slab + slabs() - 1) % slabs(); }
    std::uint32_t blocks() const { return static_cast<std::uint32_t>(bodies_.count() / 1024) + 1; }
    std::uint32_t first_block(std::uint32_t share) const {
        return static_cast<std::uint32_t>(std::uint64_t{blocks()} * share / course_.shares());
    }
    std::pair<std::size_t, std::size_t> block(std::uint32_t index) const {
        return {bodies_.count() * index / blocks(), bodies_.count() * (index + 1) / blocks()};
    }

    void divide(std::uint32_t shares) { course_.deal(slabs_, bodies_.count(), shares); }
    void open_borders() {
        for (steps::Border& border : borders_) border.open = false;
        for (std::uint32_t share = 0; share < course_.shares(); ++share) {
            const std::uint32_t first = course_.first_slab(share), last = course_.first_slab(share + 1);
            if (first == last || last - first == slabs()) continue;
            const Slab &slab = slabs_[last - 1], &next = slabs_[last % slabs()];
            borders_[last - 1].set(slab.pairs, next.first_body, next.last_body, bodies_);
        }
    }
    std::uint32_t tasks(std::uint32_t share) const {
        switch (phase_) {
            case Phase::go_on:
            case Phase::move:
            case Phase::measure:
            case Phase::list:
                return course_.first_slab(share + 1) - course_.first_slab(share);
            case Phase::cells:
            case Phase::gather:
                return first_block(share + 1) - first_block(share);
            case Phase::step:
                return course_.tasks(share);
            case Phase::over:
                break;
        }
        return 0;
    }
    bool ready(std::uint32_t share, std::uint32_t task) const {
        return phase_ != Phase::step || course_.ready(share, task);
    }
    void perform(std::uint32_t share, std::uint32_t task) {
        const std::uint32_t slab = course_.first_slab(share) + task;  // in phases of all slabs
        switch (phase_) {
            case Phase::go_on:
                return steps::Forces<Law>::go_on(slabs_[slab], bodies_, h_);
            case Phase::move:
                return move(slab, 0);
            case Phase::measure:
                return measure(slabs_[slab]);
            case Phase::list:
                return list(slabs_[slab]);
            case Phase::cells:
                return find_cells(first_block(share) + task);
            case Phase::gather:
                return gather(first_block(share) + task);
            case Phase::step:
                return course_.perform(
                    share, task, [this](steps::Chore chore, std::uint32_t ahead) { perform(chore, ahead); });
            case Phase::over:
                return;
        }
    }

    void perform(steps::Chore chore, std::uint32_t ahead) {
        switch (chore.kind) {
            case steps::Chore::sweep:
                return sweep(chore.slab, ahead);
            case steps::Chore::move:
                return move(chore.slab, ahead);
            case steps::Chore::look:
                course_.look((chore.slab + 1) % slabs());
                return look(borders_[chore.slab]);
            case steps::Chore::fetch:
                return fetch(borders_[before(chore.slab)], slabs_[before(chore.slab)]);
        }
    }

    // Ends one phase and begins the next one.
    void next(Stop& stop) {
        switch (phase_) {
            case Phase::go_on:
                kick_ = 0.5 * h_;
                phase_ = Phase::move;
                break;
            case Phase::move:
                end_steps(1, stop);
                break;
            case Phase::measure:
                end_measure(stop);
                break;
            case Phase::cells:
                begin_gather();
                break;
            case Phase::gather:
                begin_list();
                break;
            case Phase::list:
                restore_touches();
                begin_course(stop);
                break;
            case Phase::step:
                note_changes();
                if (news_.too_deep.load(std::memory_order_relaxed)) end_too_deep();
                if (now_.closing) {
                    phase_ = Phase::over;
                    break;
                }
                now_ = instant(course_.steps() - 1);
                quota_ -= course_.steps();
                end_steps(course_.steps(), stop);
                break;
            case Phase::over:
                break;
        }
    }

    // The forces at the start, for which velocities are not behind.
    void start() {
        phase_ = Phase::cells;
        begin_cells();
        Stop never;
        steps::Crew crew(1);
        Job job{*this};
        divide(1);
        crew.begin(job);
        crew.work(never, job);
    }

    // --- moving ---------------------------------------------------------------------------------------------------

    // The bodies of a slab, after all their pushes: velocities go on by kick_, then positions by h_, unless this is
    // where the advance ends.
    void move(std::uint32_t index, std::uint32_t ahead) {
        Slab& slab = slabs_[index];
        slab.vacant.insert(slab.vacant.end(), slab.vacated.begin(), slab.vacated.end());
        slab.vacated.clear();
        kick(slab, slabs_[before(index)], now_.step + ahead);
        const double fastest = math::sqrt(slab.fastest);
        slab.fastest = 0.0;
        if (phase_ == Phase::step && now_.closing) return;
        if (fastest > fastest_) {
            raise(news_.fastest[ahead], fastest);
            news_.faster.store(true, std::memory_order_relaxed);
            if (fastest > limit_) course_.end_after(ahead);
        }
        drift(slab);
        steps::Border& border = borders_[before(index)];
        if (border.open) border.update(bodies_);
    }
    static constexpr std::size_t per_line = 64 / sizeof(Four);
    void look(const steps::Border& border) {
        for (std::size_t k = 0; k < border.place.size(); k += per_line) prefetch(&border.place[k]);
    }
    void fetch(const steps::Border& border, const Slab& previous) {
        for (std::size_t k = 0; k < border.place.size(); k += per_line) prefetch_to_write(&border.place[k]);
        prefetch(previous.pushed_beyond.data()), prefetch(previous.jolts.data());
    }
    // Few have been pushed; all feel gravity.
    void kick(Slab& slab, const Slab& previous, std::uint64_t step) {
        for (const std::uint32_t i : slab.pushed_here) kick_body(slab, i, step);
        for (const std::uint32_t i : previous.pushed_beyond)
            if (slab.holds(i)) kick_body(slab, i, step);
        jolt(slab, slab);
        if (slabs() > 1) jolt(slab, previous);
        const Four fall = steps::pull(box_) * kick_;
        if (steps::dot(fall, fall) > 0.0)
            for (std::uint32_t i = slab.first_body; i < slab.last_body; ++i) bodies_.motion[i] += fall;
    }
    void kick_body(Slab& slab, std::uint32_t i, std::uint64_t step) {
        bodies_.motion[i] += bodies_.push[i].at(step) * kick_;
        slab.fastest = math::max(slab.fastest, steps::dot(bodies_.motion[i], bodies_.motion[i]));
    }
    void jolt(Slab& slab, const Slab& of) {
        for (const steps::Jolt& j : of.jolts) {
            if (!slab.holds(j.body)) continue;
            bodies_.motion[j.body] += j.change;
            slab.fastest =
                math::max(slab.fastest, steps::dot(bodies_.motion[j.body], bodies_.motion[j.body]));
        }
    }
    void drift(const Slab& slab) {
        // By numbers and not by vectors of four, which a compiler for vectors of two takes through memory.
        const double h[4] = {h_, h_, h_, 0.0};
        double* place = steps::numbers(bodies_.place);
        const double* motion = steps::numbers(bodies_.motion);
        for (std::size_t i = slab.first_body; i < slab.last_body; ++i)
            for (std::size_t k = 0; k < 4; ++k) place[4 * i + k] += motion[4 * i + k] * h[k];
    }

    static void raise(std::atomic<double>& most, double to) {
        double was = most.load(std::memory_order_relaxed);
        while (was < to && !most.compare_exchange_weak(was, to, std::memory_order_relaxed)) continue;
    }

    double time_at(std::uint64_t done) const {
        return done == planned_ ? until_ : from_ + static_cast<double>(done) * h_;
    }
    void end_steps(std::uint32_t steps, Stop& stop) {
        const bool faster = news_.faster.load(std::memory_order_relaxed);
        const double fall = math::sqrt(steps::dot(steps::pull(box_), steps::pull(box_))) * h_;
        for (std::uint32_t ahead = 0; ahead < steps; ++ahead) {
            ++done_, ++taken_;
            const double fastest = faster ? news_.fastest[ahead].load(std::memory_order_relaxed) : 0.0;
            if (fastest > limit_) course_end_ = std::min(course_end_, taken_ + 1);
            fastest_ = math::max(fastest_, fastest) + fall;
            travelled_ += fastest_ * h_;
            unproven_ = unproven_ || (travelled_ > allowance_ && taken_ < course_end_);
        }
        if (faster) {
            for (auto& fastest : news_.fastest) fastest.store(0.0, std::memory_order_relaxed);
            news_.faster.store(false, std::memory_order_relaxed);
        }
        time_ = time_at(done_);
        reached_.store(time_, std::memory_order_relaxed);
        contacts_.store(log_.begun(), std::memory_order_relaxed);
        if (taken_ < course_end_) return begin_step(stop);
        if (travelled_ <= allowance_) return begin_course(stop);
        phase_ = Phase::measure;
    }

    // Speeds may grow by a quarter, and one may jump to five times the limit in the step before that is known. Where
    // all are at rest nothing is known. A course of many bodies is short enough to be stopped soon.
    void begin_course(Stop& stop) {
        constexpr double growth = 1.25, reserve = 4.0, work = 4e6;  // work: of bodies and steps, some 20 ms
        const double most = math::clamp(work / static_cast<double>(bodies_.count()), 1.0, double{most_ahead});
        const double fall = most * math::sqrt(steps::dot(steps::pull(box_), steps::pull(box_))) * h_;
        limit_ = growth * fastest_ + fall;
        const double room = (allowance_ - travelled_) / ((limit_ + fall) * h_) - reserve;
        const double fit = fastest_ > 0.0 && room > 1.0 ? math::min(room, most) : 1.0;
        course_end_ = taken_ + std::min(static_cast<std::uint64_t>(fit), planned_ - done_);
        begin_step(stop);
    }

    // --- the list of neighbours -----------------------------------------------------------------------------------

    void measure(Slab& slab) {
        const Records<Four>& from = sorting_.reference();
        for (std::uint32_t i = slab.first_body; i < slab.last_body; ++i) {
            const Four d = bodies_.place[i] - from[i], v = bodies_.motion[i];
            const double way = steps::dot(d, d), speed = steps::dot(v, v);
            slab.farthest = way <= slab.farthest ? slab.farthest : way;  // also if it is not a number
            slab.fastest = speed <= slab.fastest ? slab.fastest : speed;
        }
    }

    void end_measure(Stop& stop) {
        double farthest = 0.0, fastest = 0.0;
        bool sane = true;
        for (Slab& s : slabs_) {
            sane = sane && s.farthest < math::infinity && s.fastest < math::infinity;
            farthest = math::max(farthest, math::sqrt(s.farthest));
            fastest = math::max(fastest, math::sqrt(s.fastest));
            s.farthest = s.fastest = 0.0;
        }
        fastest_ = fastest, travelled_ = 0.0;
        allowance_ = 0.5 * skin_ - farthest;
        const bool missed = unproven_ && !(fastest * h_ <= allowance_);  // some contact perhaps, a step ago
        unproven_ = false;
        if (missed || !(sane && fastest * h_ < 0.25 * smallest_)) {  // bodies could pass through each other
            outcome_ = Outcome::unresolved;
            ended_by_ = {fastest_body()};
            begin_step(stop);
        } else if (allowance_ > 0.05 * skin_) {
            begin_course(stop);
        } else {
            begin_cells();
        }
    }

    // Or one of which nothing is known.
    i64 fastest_body() const {
        const auto square = [this](std::size_t i) {
            const double speed = steps::dot(bodies_.motion[i], bodies_.motion[i]);
            const double place = steps::dot(bodies_.place[i], bodies_.place[i]);
            return place < math::infinity && speed < math::infinity ? speed : math::infinity;
        };
        std::size_t fastest = 0;
        for (std::size_t i = 1; i < bodies_.count(); ++i)
            if (square(i) > square(fastest)) fastest = i;
        return bodies_.label[fastest].number;
    }

    void begin_cells() {
        phase_ = Phase::cells;
        choose_skin();
        grid_ = steps::Grid(box_, widest_ + skin_, bodies_.count());
        save_touches();
    }
    void choose_skin() {
        const double d = box_.dimension, dilute = 2.0 * d * filled_ / mean_width_;
        // The first list: as in a fluid, in which touch is more likely by the inverse of the free volume.
        double pairs_per_skin = dilute / math::pow(1.0 - math::min(filled_, 0.7), d);
        if (lists_ > 0) {
            std::size_t listed = 0;
            for (const Slab& s : slabs_) listed += s.pairs.size();
            const double pairs = static_cast<double>(listed) / static_cast<double>(bodies_.count());
            pairs_per_skin = math::max(pairs / skin_, dilute);
        }
        const double step = lists_ > 0 ? h_ : time_step_;
        const double least = math::max(20.0 * fastest_ * step, 1e-3 * mean_width_);
        const double best = steps::best_skin(pairs_per_skin, fastest_, step);
        skin_ = math::min(math::max(best, least), 0.3 * mean_width_);
    }
    // Contacts outlive the list; so do the pushes of the last step.
    void save_touches() {
        for (Slab& s : slabs_) {
            for (const Touch& t : s.touches)
                if (t.at_first != steps::nobody) moving_.push_back(t);
            for (const auto* pushed : {&s.pushed_here, &s.pushed_beyond})
                for (const std::uint32_t i : *pushed) moving_pushes_.push_back({i, bodies_.push[i]});
            dissipated_ += s.dissipated, virial_ += s.virial;
        }
        largest_compression_ = largest_compression();
    }

    void find_cells(std::uint32_t task) {
        const auto [first, last] = block(task);
        sorting_.find_cells(box_, grid_, bodies_, first, last);
    }
    void begin_gather() {
        phase_ = Phase::gather;
        sorting_.order(grid_.cells(), start_);
    }
    void gather(std::uint32_t task) {
        const auto [first, last] = block(task);
        sorting_.move(bodies_, first, last);
    }
    void begin_list() {
        phase_ = Phase::list;
        sorting_.swap(bodies_);
        for (const auto& [body, push] : moving_pushes_) bodies_.push[body].stamp = 0;
        for (const auto& [body, push] : moving_pushes_) bodies_.push[sorting_.where(body)] = push;
        moving_pushes_.clear();
        share_out();
    }

    // Whole layers to slabs of about as many bodies each. The number of slabs is even, or one: with periodic sides the
    // last one reaches into the first.
    void share_out() {
        const std::uint32_t layers = grid_.layers(), in_layer = grid_.cells_in_layer();
        const std::size_t n = bodies_.count(), wanted = std::clamp<std::size_t>(n / 256, 2, most_slabs);
        const auto most = static_cast<std::uint32_t>(std::min<std::size_t>(layers, wanted));
        const std::uint32_t count = most < 2 ? 1 : most & ~1u;
        slabs_.resize(count);
        std::uint32_t layer = 0;
        for (std::uint32_t k = 0; k < count; ++k) {
            Slab& s = slabs_[k];
            s.first_cell = layer * in_layer, s.first_body = start_[s.first_cell];
            const std::uint32_t last = layers - (count - 1 - k);
            for (++layer; layer < last && (k + 1 == count || start_[layer * in_layer] < n * (k + 1) / count);)
                ++layer;
            s.last_cell = layer * in_layer, s.last_body = start_[s.last_cell];
            s.touches.clear(), s.vacant.clear(), s.vacated.clear(), s.changes.clear();
            s.clear_step();
            s.dissipated = s.virial = s.farthest = s.fastest = s.largest_compression = 0.0;
        }
        divide(course_.shares());
    }

    void list(Slab& slab) {
        slab.pairs.clear(), slab.walls.clear();
        for (std::uint32_t cell = slab.first_cell; cell < slab.last_cell; ++cell)
            steps::list_pairs(grid_, bodies_.place, start_, cell, skin_, slab.pairs);
        steps::list_walls(box_, bodies_.place, slab.first_body, slab.last_body, skin_, slab.walls);
        slab.touch_of_pair.assign(slab.pairs.size(), -1);
        slab.touch_of_wall.assign(slab.walls.size(), -1);
        sorting_.number(bodies_, slab.first_body, slab.last_body);
        std::copy(bodies_.place.begin() + slab.first_body, bodies_.place.begin() + slab.last_body,
                  sorting_.reference().begin() + slab.first_body);
    }

    void restore_touches() {
        for (const Touch& t : moving_) {
            const std::uint32_t i = sorting_.where(static_cast<std::uint32_t>(t.first));
            if (t.second < 0) {
                restore_wall(t, i);
                continue;
            }
            const std::uint32_t j = sorting_.where(static_cast<std::uint32_t>(t.second));
            if (!restore_pair(t, i, j, 1)) restore_pair(t, j, i, -1);
        }
        moving_.clear();
        open_borders();
        travelled_ = 0.0, allowance_ = 0.5 * skin_;
        ++lists_;
    }
    Slab& slab_of(std::uint32_t body) {
        return *std::find_if(slabs_.begin(), slabs_.end(), [&](const Slab& s) { return body < s.last_body; });
    }
    void restore_wall(const Touch& t, std::uint32_t body) {
        Slab& s = slab_of(body);
        const auto wall = static_cast<std::uint32_t>(-1 - t.second);
        for (std::size_t k = 0; k < s.walls.size(); ++k)
            if (s.walls[k].body == body && s.walls[k].wall == wall) put(s, s.touch_of_wall[k], t);
    }
    // Whether the pair is listed as (i, j), j being the second of the contact if sense = 1, the first if −1.
    bool restore_pair(const Touch& t, std::uint32_t i, std::uint32_t j, int sense) {
        Slab& s = slab_of(i);
        const auto before = [](const steps::Pair& p, std::uint32_t body) { return p.first < body; };
        auto p = std::lower_bound(s.pairs.begin(), s.pairs.end(), i, before);
        for (; p != s.pairs.end() && p->first == i; ++p) {
            if (p->second() != j) continue;
            const auto turns = steps::unfolded(*p, bodies_.label);
            bool same = true;
            for (int axis = 0; axis < 3; ++axis)
                same = same && turns[static_cast<std::size_t>(axis)] == sense * t.turns[axis];
            if (!same) continue;
            put(s, s.touch_of_pair[static_cast<std::size_t>(p - s.pairs.begin())], t);
            s.touches.back().normal *= static_cast<double>(sense);
            return true;
        }
        return false;
    }
    static void put(Slab& s, std::int32_t& slot, const Touch& t) {
        slot = static_cast<std::int32_t>(s.touches.size());
        s.touches.push_back(t);
    }

    // --- forces ---------------------------------------------------------------------------------------------------

    void begin_step(Stop& stop) {
        const bool first = now_.step == 0;
        const bool closing = first || done_ == planned_ || outcome_ != Outcome::ok;
        paused_ = !closing && !paused_ && (quota_ == 0 || stop.now());
        if (paused_) {
            phase_ = Phase::over;
            return;
        }
        phase_ = Phase::step;
        const double share = closing ? 0.5 : 1.0, h = first ? 0.0 : h_;
        now_ = {first ? 2 : now_.step + 1, time_, h, 0.5 * h, share * h, closing};
        kick_ = closing ? now_.ahead : h_;
        const std::uint64_t most = std::min(quota_, std::uint64_t{most_ahead});
        const std::uint64_t span = closing ? 1 : std::min(course_end_ - taken_, most);
        course_.begin(now_.step, static_cast<std::uint32_t>(span));
    }
    steps::Instant instant(std::uint32_t ahead) const {
        steps::Instant then = now_;
        if (ahead > 0) then.step += ahead, then.time = time_at(done_ + ahead);
        return then;
    }
    void sweep(std::uint32_t index, std::uint32_t ahead) {
        Slab& slab = slabs_[index];
        steps::Forces<Law>(box_, grid_, bodies_, laws_, instant(ahead)).of(slab, borders_[index]);
        if (slab.largest_compression >= deepest_compression) {
            news_.too_deep.store(true, std::memory_order_relaxed);
            course_.end_after(ahead);
        }
        std::atomic<bool>& news = news_.changes[index];
        if (!slab.changes.empty() && !news.load(std::memory_order_relaxed))
            news.store(true, std::memory_order_relaxed);
    }

    // What began and ended in the steps of this phase, in the order of time.
    void note_changes() {
        for (std::uint32_t k = 0; k < slabs(); ++k) {
            if (!news_.changes[k].load(std::memory_order_relaxed)) continue;
            news_.changes[k].store(false, std::memory_order_relaxed);
            for (std::size_t at = 0; at < slabs_[k].changes.size(); ++at) changes_.push_back({k, at});
        }
        std::ranges::stable_sort(changes_, {}, [this](const std::pair<std::uint32_t, std::size_t>& where) {
            return slabs_[where.first].changes[where.second].order();
        });
        for (const auto& [k, at] : changes_) {
            std::vector<steps::Change>& all = slabs_[k].changes;
            steps::Change& c = all[at];
            if (c.begins) {
                log_.begins(c.contact);
                Touch& t = slabs_[k].touches[static_cast<std::size_t>(c.slot)];
                if (t.news != static_cast<std::int32_t>(at)) continue;  // it has ended already
                static_cast<steps::Record&>(t) = c.contact;
                t.news = -1;
            } else {
                const bool known = c.since < 0;
                log_.ends(known ? c.contact : all[static_cast<std::size_t>(c.since)].contact, c.time,
                          c.separation_speed);
            }
        }
        for (const auto& [k, at] : changes_) slabs_[k].changes.clear();
        changes_.clear();
    }

    // The run is over: a contact has reached the largest compression of its law.
    void end_too_deep() {
        const auto deepest = std::ranges::max_element(slabs_, {}, &Slab::largest_compression);
        outcome_ = Outcome::too_deep;
        ended_by_ = {deepest->deepest[0]};
        ended_at_wall_ = deepest->deepest[1] < 0 ? deepest->deepest[1] : 0;
        if (ended_at_wall_ == 0) ended_by_.push_back(deepest->deepest[1]);
        std::ranges::sort(ended_by_);
    }

    // --- all of it, as bytes --------------------------------------------------------------------------------------

    template <class Archive>
    void exchange(Archive& archive) {
        archive(bodies_.place), archive(bodies_.motion), archive(bodies_.label), archive(bodies_.push);
        archive(sorting_.reference()), archive(grid_), archive(start_);
        archive(time_), archive(h_), archive(taken_), archive(now_), archive(outcome_);
        archive(ended_by_), archive(ended_at_wall_), archive(largest_compression_);
        archive(skin_), archive(fastest_), archive(travelled_), archive(allowance_), archive(lists_);
        archive(limit_), archive(course_end_), archive(unproven_);
        archive(from_), archive(until_), archive(planned_), archive(done_), archive(paused_);
        archive(dissipated_), archive(virial_);
        log_.exchange(archive);
        std::size_t count = slabs_.size();
        archive(count);
        slabs_.resize(count);
        for (Slab& s : slabs_) s.exchange(archive);
    }
};

}  // namespace hardlimit::boxes
