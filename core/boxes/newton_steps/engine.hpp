// Newton's equations for a box of spheres or disks in small equal steps.
//
// Leapfrog: the forces at t_n change the velocities from t_n − h/2 to t_n + h/2, with which the bodies move to t_{n+1}.
// A force that depends on the velocity is evaluated at v_n = v_{n−1/2} + a_n h/2. Here a_n contains this force itself
// (contact_force.hpp) and the forces of other contacts at the step before; with the velocity half a step earlier, ε
// would be of first order only. New contacts get the impulse that equal steps miss (onset.hpp). So positions,
// velocities, energies and ε are all of second order in h.
//
// A step is a sweep over the neighbour list, which finds the few pairs in contact, and a pass that moves all bodies
// (slab_sweep.hpp). An advance begins and ends with half a step of the velocities: between two calls they belong to the
// same time as the positions.
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
#include "decomposition.hpp"
#include "forces.hpp"
#include "motion.hpp"
#include "rebuild_criterion.hpp"

namespace hardlimit::boxes {

struct StepsObservables {
    double kinetic, potential, contact, dissipated;  // energies [J]; dissipated since the start
    double momentum[3];                              // [kg m/s]
    double virial;                                   // ∫ Σ r·F dt over pairs since the start [J s]
    std::uint64_t in_contact;                        // open contacts
};

template <class Law>
class NewtonSteps {
public:
    // position, velocity [3 N], body by body; positions in the box.
    NewtonSteps(const Box3& box, const std::vector<double>& position, const std::vector<double>& velocity,
                PairLaws<Law> laws, double time_step, bool log)
        : NewtonSteps(box, std::move(laws), position.size() / 3, time_step, log) {
        for (std::size_t i = 0; i < position.size() / 3; ++i) {
            const double* x = position.data() + 3 * i;
            const double* v = velocity.data() + 3 * i;
            bodies_.position.push_back(Double4{x[0], x[1], x[2], laws_.radius(i)});
            bodies_.velocity.push_back(Double4{v[0], v[1], v[2], 1.0 / laws_.mass(i)});
            bodies_.tag.push_back({static_cast<std::uint32_t>(i), {0, 0, 0}});
            criterion_.fastest =
                math::max(criterion_.fastest, math::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]));
        }
        bodies_.acceleration.resize(bodies_.count());
        begin_rebuild();
        const auto never = [] { return false; };
        run(1, std::chrono::milliseconds(1000), never);  // forces at the start
    }
    // Continues a saved run.
    NewtonSteps(const Box3& box, PairLaws<Law> laws, std::size_t bodies, double time_step, bool log,
                Reader& reader)
        : NewtonSteps(box, std::move(laws), bodies, time_step, log) {
        exchange(reader);
    }
    void save(Writer& writer) { exchange(writer); }

    // To `until` [s] in equal steps of at most the time step. After `most_steps`, or if the watch says stop, the run
    // pauses earlier. Asked to go on to the same time, it continues with the same bits as without the pause.
    template <class Watch>
    void advance(double until, std::uint64_t most_steps, int threads, std::chrono::milliseconds period,
                 const Watch& watch) {
        if (outcome_ != Outcome::ok) return;
        quota_ = std::max(most_steps, std::uint64_t{1});
        if (paused_ && until != until_) planned_ = done_;
        if (paused_) {
            Stop never;
            begin_batch(never);
            run(threads, period, watch);
        }
        if (paused_ || !(until > time_) || outcome_ != Outcome::ok) return;
        plan(until);
        run(threads, period, watch);
    }
    bool paused() const { return paused_; }

    double time() const { return time_; }
    double time_step() const { return time_step_; }
    std::uint64_t steps_taken() const { return taken_; }
    Outcome outcome() const { return outcome_; }
    // If the run ended early: original index of the body that moved too far in a step, or of the bodies of the contact
    // that was too deep; and the wall of that contact, or 0.
    const std::vector<i64>& ended_by() const { return ended_by_; }
    i64 ended_at_wall() const { return ended_at_wall_; }
    double largest_compression() const { return domain_.largest_compression(); }
    const steps::ContactLog& log() const { return log_; }
    std::size_t count() const { return bodies_.count(); }
    double skin() const { return domain_.skin(); }
    std::uint64_t lists_made() const { return domain_.lists_built(); }
    // For another thread during an advance: time and contacts so far.
    double time_reached() const { return reached_.load(std::memory_order_relaxed); }
    std::uint64_t contacts_reached() const { return contacts_.load(std::memory_order_relaxed); }

    // Positions along the unfolded paths [m] and velocities [m/s], [3 N] each, by original index. In a pause the
    // velocities are estimates, without the contacts of the last step.
    void state(double* position, double* velocity) const {
        for (std::size_t i = 0; i < bodies_.count(); ++i) {
            const Double4 v = velocity_of(i);
            for (int axis = 0; axis < 3; ++axis) {
                const std::size_t to =
                    3 * std::size_t{bodies_.tag[i].original_index} + static_cast<std::size_t>(axis);
                position[to] = unfolded(i, axis);
                velocity[to] = v[axis];
            }
        }
    }

    StepsObservables observe() const {
        StepsObservables o{};
        for (std::size_t i = 0; i < bodies_.count(); ++i) {
            const Double4 v = velocity_of(i);
            const double mass = 1.0 / bodies_.velocity[i][3];
            o.kinetic += 0.5 * mass * dot(v, v);
            for (int axis = 0; axis < box_.dimension; ++axis) {
                o.potential -= mass * box_.gravity[axis] * unfolded(i, axis);
                o.momentum[axis] += mass * v[axis];
            }
        }
        o.dissipated = domain_.dissipated, o.virial = domain_.virial;
        for (const Slab& s : slabs_) {
            o.dissipated += s.dissipated, o.virial += s.virial;
            for (const Contact& c : s.contacts) {
                if (c.index_first == steps::no_body) continue;
                o.contact += c.law.energy(onset_root<Law::onset_power>(c.compression));
                o.in_contact += c.in_contact;
            }
        }
        return o;
    }

    // Contacts that ended since the last call, ordered by their ends.
    std::vector<ContactRecord> take_log() { return log_.take(); }
    // Open contacts, ordered by their begins.
    std::vector<ContactRecord> open_contacts() const {
        std::vector<ContactRecord> rows;
        for (const Slab& s : slabs_)
            for (const Contact& c : s.contacts)
                if (c.index_first != steps::no_body && c.in_contact)
                    rows.push_back(log_.record(c, math::nan, math::nan));
        std::ranges::sort(rows, {}, &ContactRecord::begin);
        return rows;
    }

private:
    using Slab = steps::Slab<Law>;
    using Contact = steps::Contact<Law>;
    using Member = ThreadTeam::Member;
    // What the threads do next.
    enum class Phase { resume, measure, rebuild, batch, over };
    static constexpr std::size_t most_in_batch = steps::RebuildCriterion::most_steps;

    Box3 box_;
    PairLaws<Law> laws_;
    steps::Decomposition<Law> domain_;
    Bodies& bodies_ = domain_.bodies;
    std::vector<Slab>& slabs_ = domain_.slabs;

    // Written between two phases by one thread, and read by all during a phase.
    alignas(64) steps::Instant now_{};  // of the first step of the batch; between phases of the last one
    double time_step_;                  // the longest [s]
    double h_ = 0.0;                    // the current one [s]
    double kick_ = 0.0;                 // by which velocities advance in the phase [s]
    Phase phase_ = Phase::rebuild;
    std::uint32_t batch_steps_ = 0;
    steps::RebuildCriterion criterion_;

    // What threads report during a batch.
    alignas(64) std::atomic<std::uint32_t> last_step_{0};  // of the batch
    std::atomic<bool> too_deep_{false};                    // a contact
    std::atomic<bool> faster_{false};                      // a body, than criterion_.fastest
    std::array<std::atomic<double>, most_in_batch>
        fastest_in_{};  // each step, if beyond criterion_.fastest [m/s]

    alignas(64) double time_ = 0.0;
    double from_ = 0.0, until_ = 0.0;                   // of this advance [s]
    std::uint64_t planned_ = 0, done_ = 0, taken_ = 0;  // steps: of this advance, of it done, since the start
    std::uint64_t quota_ = 0;                           // steps until it pauses
    bool paused_ = false;
    Outcome outcome_ = Outcome::ok;
    std::vector<i64> ended_by_;
    i64 ended_at_wall_ = 0;
    steps::ContactLog log_;
    std::vector<std::pair<std::uint32_t, std::size_t>> events_;  // slab, index in its events
    std::atomic<double> reached_{0.0};
    std::atomic<std::uint64_t> contacts_{0};

    NewtonSteps(const Box3& box, PairLaws<Law> laws, std::size_t bodies, double time_step, bool log)
        : box_(box),
          laws_(std::move(laws)),
          domain_(box_, laws_, bodies),
          time_step_(time_step),
          log_(bodies, log) {}

    void plan(double until) {
        const double steps = (until - time_) / time_step_ * (1.0 - 1e-12);
        planned_ = static_cast<std::uint64_t>(math::max(0.0, steps)) + 1;
        from_ = time_, until_ = until, done_ = 0;
        h_ = (until - time_) / static_cast<double>(planned_);
        criterion_.batch_end = taken_;
        phase_ = Phase::resume;
    }
    template <class Watch>
    void run(int threads, std::chrono::milliseconds period, const Watch& watch) {
        try {
            ThreadTeam().run(threads, period, [this](Member& me) { work(me); }, watch);
        } catch (...) {  // some work was left half done, for example for want of memory
            if (phase_ != Phase::over) outcome_ = Outcome::unresolved;
            throw;
        }
    }

    Double4 velocity_of(std::size_t i) const {
        if (!paused_) return bodies_.velocity[i];
        return bodies_.velocity[i] + (bodies_.acceleration[i].at(now_.step) + box_.pull()) * (0.5 * h_);
    }
    double unfolded(std::size_t i, int axis) const {
        return bodies_.position[i][axis] + bodies_.tag[i].image_flags[axis] * box_.edge[axis];
    }
    double pull() const { return math::sqrt(dot(box_.pull(), box_.pull())); }

    // --- phases, each of which all threads do together ------------------------------------------------------------

    void work(Member& me) {
        while (phase_ != Phase::over) switch (phase_) {
                case Phase::resume:
                    resume(me);
                    break;
                case Phase::measure:
                    for_slabs(me, [this](std::uint32_t k) { domain_.measure(slabs_[k]); });
                    me.sync([&] { end_measure(me.stop); });
                    break;
                case Phase::rebuild:
                    rebuild(me);
                    break;
                case Phase::batch:
                    take_steps(me);
                    break;
                case Phase::over:
                    break;
            }
    }

    // Slabs of a thread: first, last. Its first slab is even, since pairs of an even and an odd slab are divided.
    std::pair<std::uint32_t, std::uint32_t> slabs_of(const Member& me) const {
        const auto count = static_cast<std::uint32_t>(slabs_.size());
        if (count == 1) return {0, me.index == 0 ? 1 : 0};
        const auto [first, last] = me.part_of(count / 2);
        return {2 * first, 2 * last};
    }
    template <class Action>
    void for_slabs(const Member& me, const Action& action) {
        const auto [first, last] = slabs_of(me);
        for (std::uint32_t k = first; k < last; ++k) action(k);
    }

    void resume(Member& me) {
        for_slabs(me, [this](std::uint32_t k) { steps::Forces<Law>::resume(slabs_[k], bodies_, h_); });
        me.sync([&] { kick_ = 0.5 * h_; });
        for_slabs(me, [this](std::uint32_t k) { move(k, 0); });
        me.sync([&] { end_steps(1, me.stop); });
    }

    void rebuild(Member& me) {
        const auto [first, last] = me.part_of(bodies_.count());
        domain_.find_cells(first, last);
        me.sync([&] { domain_.order(); });
        domain_.gather(first, last);
        me.sync([&] { domain_.divide(); });
        for_slabs(me, [this](std::uint32_t k) { domain_.list(slabs_[k]); });
        me.sync([&] {
            domain_.restore_contacts();
            criterion_.list_built(domain_.skin());
            begin_batch_of_steps(me.stop);
        });
    }

    // Slabs of a batch of steps. The sweep of a slab accelerates bodies of this slab and of the next one, which move
    // afterwards. Every body is to receive its forces in the same order with any number of threads: those of an even
    // slab first. So an odd slab is swept after both its neighbours, and a slab moves after the sweeps of it and of the
    // one before. A thread keeps to this order in its own slabs, and moves bodies soon after their sweep, while they
    // are in the cache. It waits for the others before its last sweep, which reaches into the slabs of the next thread,
    // and after it, so that the next thread may move its first slab.
    void take_steps(Member& me) {
        const auto [first, last] = slabs_of(me);
        const bool any = first < last;
        std::uint32_t step = 0;
        for (; step <= last_step_.load(std::memory_order_relaxed); ++step) {
            if (any && step > 0) move(first, step - 1);
            if (any) sweep(first, step);
            for (std::uint32_t odd = first + 1; odd + 1 < last; odd += 2) {
                sweep(odd + 1, step), sweep(odd, step);
                move(odd, step), move(odd + 1, step);
            }
            me.sync();
            if (any && last - 1 > first) sweep(last - 1, step), move(last - 1, step);
            me.sync();
        }
        if (any) move(first, step - 1);
        me.sync([&] { end_batch(step, me.stop); });
    }

    void sweep(std::uint32_t k, std::uint32_t step) {
        Slab& slab = slabs_[k];
        steps::Forces<Law>(box_, domain_.grid, bodies_, laws_, instant(step)).sweep(slab);
        if (slab.largest_compression >= deepest_compression) {
            too_deep_.store(true, std::memory_order_relaxed);
            end_after(step + 1);
        }
    }
    // After all forces on the slab: velocities advance by kick_, then positions by h_, unless the advance ends here.
    void move(std::uint32_t k, std::uint32_t step) {
        Slab& slab = slabs_[k];
        slab.vacant.insert(slab.vacant.end(), slab.vacated.begin(), slab.vacated.end());
        slab.vacated.clear();
        const std::size_t before = (k + slabs_.size() - 1) % slabs_.size();
        kick(slab, slabs_[before], bodies_, box_, now_.step + step, kick_);
        const double fastest = math::sqrt(slab.fastest);
        slab.fastest = 0.0;
        if (phase_ == Phase::batch && now_.closing) return;
        if (fastest > criterion_.fastest) {
            std::atomic<double>& most = fastest_in_[step];
            double was = most.load(std::memory_order_relaxed);
            while (was < fastest && !most.compare_exchange_weak(was, fastest, std::memory_order_relaxed))
                continue;
            faster_.store(true, std::memory_order_relaxed);
            if (fastest > criterion_.limit) end_after(step + 1);
        }
        drift(slab, bodies_, h_);
    }
    // Ends the batch early. Threads may be in the step after the one that asks for it, so that is the last one.
    void end_after(std::uint32_t step) {
        std::uint32_t last = last_step_.load(std::memory_order_relaxed);
        while (last > step && !last_step_.compare_exchange_weak(last, step, std::memory_order_relaxed))
            continue;
    }

    // --- between two phases, by one thread ------------------------------------------------------------------------

    double time_at(std::uint64_t done) const {
        return done == planned_ ? until_ : from_ + static_cast<double>(done) * h_;
    }
    steps::Instant instant(std::uint32_t ahead) const {
        steps::Instant then = now_;
        if (ahead > 0) then.step += ahead, then.time = time_at(done_ + ahead);
        return then;
    }

    void begin_batch_of_steps(Stop& stop) {
        criterion_.begin_batch(taken_, planned_ - done_, bodies_.count(), pull(), h_);
        begin_batch(stop);
    }
    // Begins the steps of a batch, or pauses.
    void begin_batch(Stop& stop) {
        const bool first = now_.step == 0;
        const bool closing = first || done_ == planned_ || outcome_ != Outcome::ok;
        paused_ = !closing && !paused_ && (quota_ == 0 || stop.now());
        phase_ = paused_ ? Phase::over : Phase::batch;
        if (paused_) return;
        const double weight = closing ? 0.5 : 1.0, h = first ? 0.0 : h_;
        now_ = {first ? 2 : now_.step + 1, time_, h, 0.5 * h, weight * h, closing};
        kick_ = closing ? now_.velocity_lag : h_;
        const std::uint64_t most = std::min(quota_, std::uint64_t{most_in_batch});
        const std::uint64_t steps = closing ? 1 : std::min(criterion_.batch_end - taken_, most);
        last_step_.store(static_cast<std::uint32_t>(steps) - 1, std::memory_order_relaxed);
    }
    void end_batch(std::uint32_t steps, Stop& stop) {
        log_events();
        if (too_deep_.load(std::memory_order_relaxed)) end_too_deep();
        if (now_.closing) {
            phase_ = Phase::over;
            return;
        }
        now_ = instant(steps - 1);
        quota_ -= steps;
        end_steps(steps, stop);
    }
    void end_steps(std::uint32_t steps, Stop& stop) {
        const bool faster = faster_.load(std::memory_order_relaxed);
        for (std::uint32_t k = 0; k < steps; ++k) {
            ++done_, ++taken_;
            const double fastest = faster ? fastest_in_[k].load(std::memory_order_relaxed) : 0.0;
            criterion_.add_step(taken_, fastest, pull(), h_);
        }
        if (faster) {
            for (auto& fastest : fastest_in_) fastest.store(0.0, std::memory_order_relaxed);
            faster_.store(false, std::memory_order_relaxed);
        }
        time_ = time_at(done_);
        reached_.store(time_, std::memory_order_relaxed);
        contacts_.store(log_.begun(), std::memory_order_relaxed);
        if (taken_ < criterion_.batch_end) return begin_batch(stop);
        if (criterion_.holds()) return begin_batch_of_steps(stop);
        phase_ = Phase::measure;
    }

    void end_measure(Stop& stop) {
        double farthest = 0.0, fastest = 0.0;
        bool finite = true;
        for (Slab& s : slabs_) {
            finite = finite && s.farthest < math::infinity && s.fastest < math::infinity;
            farthest = math::max(farthest, math::sqrt(s.farthest));
            fastest = math::max(fastest, math::sqrt(s.fastest));
            s.farthest = s.fastest = 0.0;
        }
        const bool missed = criterion_.measured(farthest, fastest, h_, domain_.skin());
        // Bodies that move further in a step could pass through each other.
        if (missed || !(finite && fastest * h_ < 0.25 * domain_.smallest_diameter())) {
            outcome_ = Outcome::unresolved;
            ended_by_ = {fastest_body()};
            begin_batch(stop);
        } else if (criterion_.allowance > 0.05 * domain_.skin()) {
            begin_batch_of_steps(stop);
        } else {
            begin_rebuild();
        }
    }
    void begin_rebuild() {
        phase_ = Phase::rebuild;
        domain_.begin_rebuild(criterion_.fastest, domain_.lists_built() > 0 ? h_ : time_step_);
    }

    // Original index of the fastest body, or of one whose state is not finite.
    i64 fastest_body() const {
        const auto square = [this](std::size_t i) {
            const double speed = dot(bodies_.velocity[i], bodies_.velocity[i]);
            const double distance = dot(bodies_.position[i], bodies_.position[i]);
            return distance < math::infinity && speed < math::infinity ? speed : math::infinity;
        };
        std::size_t fastest = 0;
        for (std::size_t i = 1; i < bodies_.count(); ++i)
            if (square(i) > square(fastest)) fastest = i;
        return bodies_.tag[fastest].original_index;
    }
    // The run ends since a contact has reached the largest compression of its law.
    void end_too_deep() {
        const auto deepest = std::ranges::max_element(slabs_, {}, &Slab::largest_compression);
        outcome_ = Outcome::too_deep;
        ended_by_ = {deepest->deepest[0]};
        ended_at_wall_ = deepest->deepest[1] < 0 ? deepest->deepest[1] : 0;
        if (ended_at_wall_ == 0) ended_by_.push_back(deepest->deepest[1]);
        std::ranges::sort(ended_by_);
    }

    // Logs what began and ended in the steps of a batch, in the order of time.
    void log_events() {
        for (std::uint32_t k = 0; k < slabs_.size(); ++k)
            for (std::size_t at = 0; at < slabs_[k].events.size(); ++at) events_.push_back({k, at});
        std::ranges::stable_sort(events_, {}, [this](const std::pair<std::uint32_t, std::size_t>& where) {
            return slabs_[where.first].events[where.second].order();
        });
        for (const auto& [k, at] : events_) {
            std::vector<steps::ContactEvent>& all = slabs_[k].events;
            steps::ContactEvent& e = all[at];
            if (e.begins) {
                log_.begin(e.contact);
                Contact& c = slabs_[k].contacts[static_cast<std::size_t>(e.slot)];
                if (c.begin_event != static_cast<std::int32_t>(at)) continue;  // it has ended already
                static_cast<steps::ContactBegin&>(c) = e.contact;
                c.begin_event = -1;
            } else {
                const bool logged = e.begin_event < 0;
                log_.end(logged ? e.contact : all[static_cast<std::size_t>(e.begin_event)].contact, e.time,
                         e.separation_speed);
            }
        }
        for (const auto& [k, at] : events_) slabs_[k].events.clear();
        events_.clear();
    }

    // --- checkpoint -----------------------------------------------------------------------------------------------

    template <class Archive>
    void exchange(Archive& archive) {
        domain_.exchange(archive);
        criterion_.exchange(archive);
        archive(time_), archive(h_), archive(taken_), archive(now_), archive(outcome_);
        archive(ended_by_), archive(ended_at_wall_);
        archive(from_), archive(until_), archive(planned_), archive(done_), archive(paused_);
        log_.exchange(archive);
    }
};

}  // namespace hardlimit::boxes
