// A batch of steps on all slabs, in phases that several threads share.
#pragma once
#include <array>
#include <atomic>
#include <cstdint>
#include <utility>

#include "decomposition.hpp"
#include "forces.hpp"
#include "motion.hpp"
#include "rebuild_criterion.hpp"

namespace hardlimit::boxes::steps {

// The equal steps of one call of advance().
struct StepPlan {
    double from = 0.0, until = 0.0, h = 0.0;  // [s]
    std::uint64_t planned = 0, done = 0;      // steps

    double time_at(std::uint64_t step) const {
        return step == planned ? until : from + static_cast<double>(step) * h;
    }
};

// Slabs first … last − 1. The first one is even.
struct Partition {
    std::uint32_t first, last;

    // Partition k of `count`. An even slab and the odd one after it are in the same partition.
    static Partition of(std::size_t slabs, std::uint32_t k, std::uint32_t count) {
        if (slabs == 1) return {0, k == 0 ? 1u : 0u};
        const auto at = [&](std::uint32_t i) {
            return static_cast<std::uint32_t>(2 * (slabs / 2 * i / count));
        };
        return {at(k), at(k + 1)};
    }
};

template <class Law>
class Stepper {
public:
    static constexpr std::uint32_t most_steps = RebuildCriterion::most_steps;

    // Written between two phases by one thread, and read by all during a phase.
    Instant now{};      // of the first step of the batch; between phases of the last one
    double kick = 0.0;  // by which velocities advance in a step [s]
    StepPlan plan;

    Stepper(const Box& box, const PairLaws<Law>& laws, Decomposition<Law>& domain,
            const RebuildCriterion& criterion)
        : box_(box), laws_(laws), domain_(domain), slabs_(domain.slabs), criterion_(criterion) {}

    Instant instant(std::uint32_t ahead) const {
        Instant then = now;
        if (ahead > 0) then.step += ahead, then.time = plan.time_at(plan.done + ahead);
        return then;
    }
    void begin(std::uint64_t steps) {
        step_ = 0;
        last_step_.store(static_cast<std::uint32_t>(steps) - 1, std::memory_order_relaxed);
    }

    // A step has two phases with one task per partition, and a last phase follows the batch. The sweep of a slab
    // accelerates bodies of this slab and of the next one, which move afterwards. Every body must receive its forces in
    // the same order with any number of partitions, those of an even slab first. So an odd slab is swept after both its
    // neighbours, and a slab moves after it and the slab before have been swept. Inside a partition a slab moves soon
    // after its sweep, while it is in the cache.
    void step_inside(Partition p) {
        if (p.first == p.last) return;
        if (step_ > 0) move(p.first, step_ - 1);
        sweep(p.first);
        for (std::uint32_t odd = p.first + 1; odd + 1 < p.last; odd += 2) {
            sweep(odd + 1), sweep(odd);
            move(odd, step_), move(odd + 1, step_);
        }
    }
    // The last slab reaches into the first slab of the next partition, which moves in the next phase.
    void step_at_border(Partition p) {
        if (p.last - p.first > 1) sweep(p.last - 1), move(p.last - 1, step_);
    }
    void end_steps(Partition p) {
        if (p.first < p.last) move(p.first, step_);
    }
    // Returns whether another step of the batch follows.
    bool next_step() {
        if (step_ >= last_step_.load(std::memory_order_relaxed)) return false;
        ++step_;
        return true;
    }
    std::uint32_t steps_taken() const { return step_ + 1; }

    // After all forces on the slab: velocities advance by `kick`, then positions by h, unless the advance ends here.
    void move(std::uint32_t k, std::uint32_t step, bool drifts) {
        Slab<Law>& slab = slabs_[k];
        slab.free_slots.insert(slab.free_slots.end(), slab.freed_slots.begin(), slab.freed_slots.end());
        slab.freed_slots.clear();
        const std::size_t before = (k + slabs_.size() - 1) % slabs_.size();
        steps::kick(slab, slabs_[before], domain_.bodies, box_, now.step + step, kick);
        const double fastest = math::sqrt(slab.fastest) + domain_.strain_speed();
        slab.fastest = 0.0;
        if (!drifts) return;
        if (fastest > criterion_.fastest) {
            std::atomic<double>& most = fastest_[step];
            double was = most.load(std::memory_order_relaxed);
            while (was < fastest && !most.compare_exchange_weak(was, fastest, std::memory_order_relaxed))
                continue;
            faster_.store(true, std::memory_order_relaxed);
            if (fastest > criterion_.limit) end_after(step + 1);
        }
        drift(slab, domain_.bodies, plan.h);
    }

    // After a batch: whether a contact was too deep, and add(speed) for each step with its largest speed if that
    // exceeds criterion.fastest, else 0.
    bool too_deep() const { return too_deep_.load(std::memory_order_relaxed); }
    template <class Add>
    void take_speeds(std::uint32_t steps, const Add& add) {
        const bool faster = faster_.load(std::memory_order_relaxed);
        for (std::uint32_t k = 0; k < steps; ++k)
            add(faster ? fastest_[k].load(std::memory_order_relaxed) : 0.0);
        if (!faster) return;
        for (auto& fastest : fastest_) fastest.store(0.0, std::memory_order_relaxed);
        faster_.store(false, std::memory_order_relaxed);
    }

private:
    const Box& box_;
    const PairLaws<Law>& laws_;
    Decomposition<Law>& domain_;
    std::vector<Slab<Law>>& slabs_;
    const RebuildCriterion& criterion_;
    std::uint32_t step_ = 0;  // of the batch

    // Written by the threads during a batch. Apart from the data that they only read, to avoid false sharing.
    alignas(128) std::atomic<std::uint32_t> last_step_{0};  // of the batch
    std::atomic<bool> too_deep_{false};                     // whether a contact is too deep
    std::atomic<bool> faster_{false};                       // whether a body is faster than criterion.fastest
    std::array<std::atomic<double>, most_steps> fastest_{};  // in each step, if > criterion.fastest [m/s]

    void move(std::uint32_t k, std::uint32_t step) { move(k, step, !now.closing); }
    void sweep(std::uint32_t k) {
        Slab<Law>& slab = slabs_[k];
        Forces<Law>(box_, domain_.grid, domain_.bodies, laws_, instant(step_)).sweep(slab);
        if (slab.largest_compression >= deepest_compression) {
            too_deep_.store(true, std::memory_order_relaxed);
            end_after(step_ + 1);
        }
    }
    // Ends the batch early. The first slab of each partition moves in the following step, so that step is the last.
    void end_after(std::uint32_t step) {
        std::uint32_t last = last_step_.load(std::memory_order_relaxed);
        while (last > step && !last_step_.compare_exchange_weak(last, step, std::memory_order_relaxed))
            continue;
    }
};

}  // namespace hardlimit::boxes::steps
