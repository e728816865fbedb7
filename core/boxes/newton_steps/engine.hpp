// Newton's equations for a box of spheres or disks in small equal steps.
//
// Leapfrog: the forces at t_n change the velocities from t_n − h/2 to t_n + h/2, with which the bodies move to t_{n+1}.
// A force that depends on the velocity is evaluated at v_n = v_{n−1/2} + a_n h/2. Here a_n contains this force itself
// (contact_force.hpp) and the forces of other contacts at the step before; with the velocity half a step earlier, ε
// would be of first order only. New contacts get the impulse that equal steps miss (onset.hpp). So positions,
// velocities, energies and ε are all of second order in h.
//
// A step is a sweep over the neighbour list, which finds the few pairs in contact, and a pass that moves all bodies
// (stepper.hpp). An advance begins and ends with half a step of the velocities: between two calls they belong to the
// same time as the positions.
#pragma once
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <utility>
#include <vector>

#include "../../base/outcome.hpp"
#include "../../base/threads.hpp"
#include "../common/archive.hpp"
#include "contact_log.hpp"
#include "observables.hpp"
#include "stepper.hpp"
#include "thread_team.hpp"

namespace hardlimit::boxes {

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
        if constexpr (FrictionalLaw<Law>) make_spins();
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
        if (paused_ && until != plan_.until) plan_.planned = plan_.done;
        if (paused_) {
            Stop never;
            begin_steps(never);
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
                position[to] = steps::unfolded(box_, bodies_, i, axis);
                velocity[to] = v[axis];
            }
        }
    }

    // Angular velocities [rad/s], [3 N] by original index; zero at the start.
    void angular_velocity(double* spin) const
        requires FrictionalLaw<Law>
    {
        for (std::size_t i = 0; i < bodies_.count(); ++i)
            for (int axis = 0; axis < 3; ++axis)
                spin[3 * std::size_t{bodies_.tag[i].original_index} + static_cast<std::size_t>(axis)] =
                    bodies_.spin[i][axis];
    }

    StepsObservables observe() const {
        return steps::observe(box_, domain_, [this](std::size_t i) { return velocity_of(i); });
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
    // Of the work that threads share. A step is swept inside the partitions and then at their borders, and after a
    // batch the first slab of each partition moves.
    enum class Phase { resume, move, measure, cells, gather, list, inside, border, last_move, over };

    Box3 box_;
    PairLaws<Law> laws_;
    steps::Decomposition<Law> domain_;
    steps::RebuildCriterion criterion_;
    steps::Stepper<Law> stepper_;
    Bodies& bodies_ = domain_.bodies;
    std::vector<Slab>& slabs_ = domain_.slabs;
    steps::StepPlan& plan_ = stepper_.plan;
    steps::Instant& now_ = stepper_.now;

    double time_step_;  // the longest [s]
    Phase phase_ = Phase::cells;
    double time_ = 0.0;
    std::uint64_t taken_ = 0;  // steps since the start
    std::uint64_t quota_ = 0;  // steps until the run pauses
    bool paused_ = false;
    Outcome outcome_ = Outcome::ok;
    std::vector<i64> ended_by_;
    i64 ended_at_wall_ = 0;
    steps::ContactLog log_;
    std::atomic<double> reached_{0.0};
    std::atomic<std::uint64_t> contacts_{0};

    NewtonSteps(const Box3& box, PairLaws<Law> laws, std::size_t bodies, double time_step, bool log)
        : box_(box),
          laws_(std::move(laws)),
          domain_(box_, laws_, bodies),
          stepper_(box_, laws_, domain_, criterion_),
          time_step_(time_step),
          log_(bodies, log) {}

    void plan(double until) {
        const double steps = (until - time_) / time_step_ * (1.0 - 1e-12);
        plan_.planned = static_cast<std::uint64_t>(math::max(0.0, steps)) + 1;
        plan_.from = time_, plan_.until = until, plan_.done = 0;
        plan_.h = (until - time_) / static_cast<double>(plan_.planned);
        criterion_.batch_end = taken_;
        phase_ = Phase::resume;
    }
    template <class Watch>
    void run(int threads, std::chrono::milliseconds period, const Watch& watch) {
        try {
            steps::ThreadTeam team(static_cast<std::uint32_t>(threads));
            Work work{*this, team.partitions()};
            ThreadPool().run(threads, period, [&](Stop& stop) { team.work(stop, work); }, watch);
        } catch (...) {  // some work was left half done, for example for want of memory
            if (phase_ != Phase::over) outcome_ = Outcome::unresolved;
            throw;
        }
    }

    // Moment of inertia of a solid sphere, or in two dimensions of a disk.
    void make_spins() {
        for (std::size_t i = 0; i < bodies_.count(); ++i) {
            const double radius = bodies_.position[i][3], factor = box_.dimension == 2 ? 0.5 : 0.4;
            const double inverse = bodies_.velocity[i][3] / (factor * radius * radius);
            bodies_.spin.push_back(Double4{0.0, 0.0, 0.0, inverse});
        }
        bodies_.angular_acceleration.resize(bodies_.count());
    }
    Double4 velocity_of(std::size_t i) const {
        if (!paused_) return bodies_.velocity[i];
        return bodies_.velocity[i] + (bodies_.acceleration[i].at(now_.step) + box_.pull()) * (0.5 * plan_.h);
    }
    double pull() const { return math::sqrt(dot(box_.pull(), box_.pull())); }

    // --- phases ---------------------------------------------------------------------------------------------------

    struct Work {
        NewtonSteps& of;
        std::uint32_t partitions;

        void perform(std::uint32_t k) { of.perform(k, partitions); }
        bool next(Stop& stop) { return of.next(stop), of.phase_ != Phase::over; }
    };

    void perform(std::uint32_t k, std::uint32_t partitions) {
        const auto p = steps::Partition::of(slabs_.size(), k, partitions);
        const auto for_slabs = [&](const auto& action) {
            for (std::uint32_t slab = p.first; slab < p.last; ++slab) action(slab);
        };
        const std::size_t n = bodies_.count(), first = n * k / partitions, last = n * (k + 1) / partitions;
        switch (phase_) {
            case Phase::resume:
                return for_slabs(
                    [&](std::uint32_t slab) { steps::Forces<Law>::resume(slabs_[slab], bodies_, plan_.h); });
            case Phase::move:
                return for_slabs([&](std::uint32_t slab) { stepper_.move(slab, 0, true); });
            case Phase::measure:
                return for_slabs([&](std::uint32_t slab) { domain_.measure(slabs_[slab]); });
            case Phase::cells:
                return domain_.find_cells(first, last);
            case Phase::gather:
                return domain_.gather(first, last);
            case Phase::list:
                return for_slabs([&](std::uint32_t slab) { domain_.list(slabs_[slab]); });
            case Phase::inside:
                return stepper_.step_inside(p);
            case Phase::border:
                return stepper_.step_at_border(p);
            case Phase::last_move:
                return stepper_.end_steps(p);
            case Phase::over:
                return;
        }
    }

    // Ends a phase and begins the next one.
    void next(Stop& stop) {
        switch (phase_) {
            case Phase::resume:
                stepper_.kick = 0.5 * plan_.h;
                phase_ = Phase::move;
                return;
            case Phase::move:
                return end_steps(1, stop);
            case Phase::measure:
                return end_measure(stop);
            case Phase::cells:
                domain_.order();
                phase_ = Phase::gather;
                return;
            case Phase::gather:
                domain_.divide();
                phase_ = Phase::list;
                return;
            case Phase::list:
                domain_.restore_contacts();
                criterion_.list_built(domain_.skin());
                return begin_batch(stop);
            case Phase::inside:
                phase_ = Phase::border;
                return;
            case Phase::border:
                phase_ = stepper_.next_step() ? Phase::inside : Phase::last_move;
                return;
            case Phase::last_move:
                return end_batch(stepper_.steps_taken(), stop);
            case Phase::over:
                return;
        }
    }

    // --- between two phases, by one thread ------------------------------------------------------------------------

    void begin_batch(Stop& stop) {
        criterion_.begin_batch(taken_, plan_.planned - plan_.done, bodies_.count(), pull(), plan_.h);
        begin_steps(stop);
    }
    // Begins steps of the current batch, or pauses.
    void begin_steps(Stop& stop) {
        const bool first = now_.step == 0;
        const bool closing = first || plan_.done == plan_.planned || outcome_ != Outcome::ok;
        paused_ = !closing && !paused_ && (quota_ == 0 || stop.now());
        phase_ = paused_ ? Phase::over : Phase::inside;
        if (paused_) return;
        const double weight = closing ? 0.5 : 1.0, h = first ? 0.0 : plan_.h;
        now_ = {first ? 2 : now_.step + 1, time_, h, 0.5 * h, weight * h, closing};
        stepper_.kick = closing ? now_.velocity_lag : plan_.h;
        const std::uint64_t most = std::min(quota_, std::uint64_t{stepper_.most_steps});
        const std::uint64_t steps = closing ? 1 : std::min(criterion_.batch_end - taken_, most);
        stepper_.begin(steps);
    }
    void end_batch(std::uint32_t steps, Stop& stop) {
        steps::log_events(slabs_, log_);
        if (stepper_.too_deep()) end_too_deep();
        if (now_.closing) {
            phase_ = Phase::over;
            return;
        }
        now_ = stepper_.instant(steps - 1);
        quota_ -= steps;
        end_steps(steps, stop);
    }
    void end_steps(std::uint32_t steps, Stop& stop) {
        stepper_.take_speeds(steps, [this](double fastest) {
            ++plan_.done, ++taken_;
            criterion_.add_step(taken_, fastest, pull(), plan_.h);
        });
        time_ = plan_.time_at(plan_.done);
        reached_.store(time_, std::memory_order_relaxed);
        contacts_.store(log_.begun(), std::memory_order_relaxed);
        if (taken_ < criterion_.batch_end) return begin_steps(stop);
        if (criterion_.holds()) return begin_batch(stop);
        phase_ = Phase::measure;
    }

    void end_measure(Stop& stop) {
        const auto [farthest, fastest, finite] = domain_.take_measurement();
        const bool missed = criterion_.measured(farthest, fastest, plan_.h, domain_.skin());
        // Bodies that move further in a step could pass through each other.
        if (missed || !(finite && fastest * plan_.h < 0.25 * domain_.smallest_diameter())) {
            outcome_ = Outcome::unresolved;
            ended_by_ = {domain_.fastest_body()};
            begin_steps(stop);
        } else if (criterion_.allowance > 0.05 * domain_.skin()) {
            begin_batch(stop);
        } else {
            begin_rebuild();
        }
    }
    void begin_rebuild() {
        phase_ = Phase::cells;
        domain_.begin_rebuild(criterion_.fastest, domain_.lists_built() > 0 ? plan_.h : time_step_);
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

    // --- checkpoint -----------------------------------------------------------------------------------------------

    template <class Archive>
    void exchange(Archive& archive) {
        domain_.exchange(archive);
        criterion_.exchange(archive);
        archive(time_), archive(plan_.h), archive(taken_), archive(now_), archive(outcome_);
        archive(ended_by_), archive(ended_at_wall_);
        archive(plan_.from), archive(plan_.until), archive(plan_.planned), archive(plan_.done),
            archive(paused_);
        log_.exchange(archive);
    }
};

}  // namespace hardlimit::boxes
