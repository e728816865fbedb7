// Time stepping of Newton's equations for a box of spheres or disks under a contact law.
//
// Leapfrog: the forces at t_n change the velocities from t_n − h/2 to t_n + h/2, with which the bodies move to t_{n+1}.
// A force that depends on the velocity is evaluated at v_n = v_{n−1/2} + a_n h/2. Here a_n contains this force itself
// (contact_force.hpp) and the forces of other contacts at the step before; with the velocity half a step earlier, ε
// would be of first order only. New contacts get the impulse that equal steps miss (onset.hpp). So positions,
// velocities, energies and ε are all of second order in h.
//
// A step is a sweep over the neighbour list, which finds the few pairs in contact, and a pass that moves all bodies
// (stepper.hpp). advance() begins and ends with a half step of the velocities, so that between two calls they belong to
// the same time as the positions.
#pragma once
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <utility>
#include <vector>

#include "../../base/outcome.hpp"
#include "../../base/threads.hpp"
#include "../common/archive.hpp"
#include "../common/newton_setting.hpp"
#include "contact_log.hpp"
#include "observe.hpp"
#include "stepper.hpp"
#include "thread_team.hpp"

namespace hardlimit::boxes {

template <class Law>
class NewtonSteps final : public Engine {
public:
    NewtonSteps(const NewtonSetting& setting, const System& s);
    // Continues a saved run.
    NewtonSteps(const NewtonSetting& setting, Reader& reader);

    // Takes equal steps, at most as long as the time step. The unit of work is a step.
    void advance(double until, u64 most_work, int threads, Stop& stop) override {
        constexpr std::chrono::milliseconds period{50};  // between two checks of `stop`
        const auto watch = [&] { return stop.now(); };
        if (outcome_ != Outcome::ok) return;
        quota_ = std::max(most_work, u64{1});
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
    bool paused() const override { return paused_; }
    double time() const override { return time_; }
    Outcome outcome() const override { return outcome_; }
    // Names the body that moved too far in a step, or the bodies of the contact that was too deep.
    EarlyEnd early_end() const override { return {time_, ended_by_, ended_at_wall_}; }
    u64 work() const override { return taken_; }
    u64 contacts() const override { return log_.begun(); }
    u64 logged() const override { return log_.ended(); }
    std::vector<Statistic> statistics() const override {
        return {{"time_step", setting_.time_step},
                {"n_steps", static_cast<double>(taken_)},
                {"n_lists", static_cast<double>(domain_.lists_built())},
                {"skin", domain_.skin()}};
    }

    double set_velocities(const double* velocity, const double* spin) override {
        const auto d = static_cast<std::size_t>(box_.dimension);
        for (std::size_t i = 0; i < bodies_.count(); ++i) {
            const double* of = velocity + d * std::size_t{bodies_.tag[i].original_index};
            Double4& v = bodies_.velocity[i];
            const double before = v[0];
            for (std::size_t axis = 0; axis < d; ++axis) v[axis] = of[axis];
            v[0] -= box_.image(bodies_.tag[i].image_flags, time_).velocity[0];
            // Beyond a sheared side, the work of the crossing is counted in advance. It depends on the velocity.
            const int crossed = box_.turns(bodies_.position[i][box_.gradient], box_.gradient);
            domain_.shear_work += crossed * box_.image_velocity() * (v[0] - before) / v[3];
            include_speed(i);
        }
        if constexpr (FrictionalLaw<Law>)
            for (std::size_t i = 0; spin && i < bodies_.count(); ++i)
                for (std::size_t axis = 0; axis < 3; ++axis)
                    bodies_.spin[i][axis] = spin[3 * std::size_t{bodies_.tag[i].original_index} + axis];
        return 0.0;
    }

    // During a pause the velocities are estimates, without the contacts of the last step.
    void state(double* position, double* velocity) const override {
        const int d = box_.dimension;
        for (std::size_t i = 0; i < bodies_.count(); ++i) {
            const Double4 v = velocity_of(i);
            const ImageMotion image = box_.image(bodies_.tag[i].image_flags, time_);
            const std::size_t to = std::size_t{bodies_.tag[i].original_index} * static_cast<std::size_t>(d);
            for (int axis = 0; axis < d; ++axis) {
                position[to + static_cast<std::size_t>(axis)] = bodies_.position[i][axis] + image.shift[axis];
                velocity[to + static_cast<std::size_t>(axis)] = v[axis] + image.velocity[axis];
            }
        }
    }
    Observation observe() const override {
        Observation o = steps::observe(
            box_, domain_, time_, [this](std::size_t i) { return velocity_of(i); },
            [this](std::size_t i) { return spin_of(i); });
        o.begun = log_.begun(), o.pairs = log_.pairs(), o.ended = log_.ended();
        o.overlapped = log_.overlapped();
        return o;
    }

    bool rotates() const override { return FrictionalLaw<Law>; }
    void spins(double* spin) const override {
        if constexpr (FrictionalLaw<Law>)
            for (std::size_t i = 0; i < bodies_.count(); ++i) {
                const Double4 of = spin_of(i);
                for (std::size_t axis = 0; axis < 3; ++axis)
                    spin[3 * std::size_t{bodies_.tag[i].original_index} + axis] = of[axis];
            }
    }
    bool contacts_have_duration() const override { return true; }

    // Contacts that ended since the last call, ordered by their ends.
    std::vector<ContactRecord> take_log() override { return log_.take(); }
    // Open contacts, ordered by their begins.
    std::vector<ContactRecord> open_contacts() const override {
        std::vector<ContactRecord> rows;
        for (const Slab& s : slabs_)
            for (const Contact& c : s.contacts)
                if (c.index_first != steps::no_body && c.in_contact)
                    rows.push_back(log_.record(c, math::nan, math::nan, sliding(c)));
        std::ranges::sort(rows, {}, &ContactRecord::begin);
        return rows;
    }

    std::vector<char> save() const override;
    std::size_t bytes() const override {
        // Bodies are stored twice, for sorting.
        constexpr std::size_t per_body =
            2 * (2 * sizeof(Double4) + sizeof(ContactAcceleration) + sizeof(BodyTag));
        std::size_t sum = sizeof *this + bodies_.count() * per_body;
        for (const Slab& s : slabs_)
            sum += s.pairs.capacity() * sizeof(NeighbourPair) + s.contacts.capacity() * sizeof(Contact);
        return sum;
    }
    int dimension() const override { return box_.dimension; }
    std::size_t size() const override { return bodies_.count(); }

private:
    using Slab = steps::Slab<Law>;
    using Contact = steps::Contact<Law>;
    // Phases of the work that threads share. A step sweeps first the inside of the partitions and then their borders.
    // After a batch the first slab of each partition moves.
    enum class Phase { resume, move, measure, cells, gather, list, inside, border, last_move, over };

    NewtonSetting setting_;
    const Box& box_ = setting_.box;
    PairLaws<Law> laws_;
    steps::Decomposition<Law> domain_;
    steps::RebuildCriterion criterion_;
    steps::Stepper<Law> stepper_;
    Bodies& bodies_ = domain_.bodies;
    std::vector<Slab>& slabs_ = domain_.slabs;
    steps::StepPlan& plan_ = stepper_.plan;
    steps::Instant& now_ = stepper_.now;

    Phase phase_ = Phase::cells;
    double time_ = 0.0;
    std::uint64_t taken_ = 0;  // steps since the start
    std::uint64_t quota_ = 0;  // steps until the run pauses
    bool paused_ = false;
    Outcome outcome_ = Outcome::ok;
    std::vector<i64> ended_by_;
    WallId ended_at_wall_;
    steps::ContactLog log_;

    explicit NewtonSteps(const NewtonSetting& setting);
    void add_bodies(const System& s);
    void add_spins(const System& s);
    template <class Archive>
    void exchange(Archive& archive);

    void plan(double until) {
        const double steps = (until - time_) / setting_.time_step * (1.0 - 1e-12);
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
        } catch (...) {  // some work is incomplete, for example for lack of memory
            if (phase_ != Phase::over) outcome_ = Outcome::unresolved;
            throw;
        }
    }

    Double4 velocity_of(std::size_t i) const {
        if (!paused_) return bodies_.velocity[i];
        return bodies_.velocity[i] +
               (double4(bodies_.acceleration[i].at(now_.step)) + gravity_of(box_)) * (0.5 * plan_.h);
    }
    Double4 spin_of(std::size_t i) const {
        if (!paused_) return bodies_.spin[i];
        return bodies_.spin[i] + double4(bodies_.angular_acceleration[i].at(now_.step)) * (0.5 * plan_.h);
    }
    void include_speed(std::size_t i) {
        const Double4 v = velocity_from_flow(box_, bodies_, i);
        criterion_.fastest = math::max(criterion_.fastest, math::sqrt(dot(v, v)) + domain_.strain_speed());
    }
    double pull() const { return math::sqrt(dot(gravity_of(box_), gravity_of(box_))); }

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
                return for_slabs([&](std::uint32_t slab) { domain_.measure(slabs_[slab], time_); });
            case Phase::cells:
                return domain_.find_cells(first, last, time_);
            case Phase::gather:
                return domain_.gather(first, last);
            case Phase::list:
                return for_slabs([&](std::uint32_t slab) { domain_.list(slabs_[slab], time_); });
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
                domain_.restore_contacts(time_);
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
        if (taken_ < criterion_.batch_end) return begin_steps(stop);
        if (criterion_.holds()) return begin_batch(stop);
        phase_ = Phase::measure;
    }

    void end_measure(Stop& stop) {
        const auto [farthest, fastest, finite] = domain_.take_measurement(time_);
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
        const double step = domain_.lists_built() > 0 ? plan_.h : setting_.time_step;
        domain_.begin_rebuild(criterion_.fastest, step, time_);
    }

    // Ends the run because a contact has reached the largest compression of its law.
    void end_too_deep() {
        const auto deepest = std::ranges::max_element(slabs_, {}, &Slab::largest_compression);
        outcome_ = Outcome::too_deep;
        ended_by_ = {deepest->deepest[0]};
        ended_at_wall_ = WallId::of(deepest->deepest[1]);
        if (!ended_at_wall_) ended_by_.push_back(deepest->deepest[1]);
        std::ranges::sort(ended_by_);
    }
};

}  // namespace hardlimit::boxes

#include "checkpoint.hpp"
#include "start.hpp"
