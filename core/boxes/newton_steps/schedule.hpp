// In which order the slabs are worked on in a step, and how far threads may be apart in several.
//
// A sweep finds the contacts of the pairs that belong to a slab; it pushes bodies of this slab and the next one. Then
// bodies may move. Every body is to receive its pushes in one order, whoever works: those of an even slab first. So
//   an even slab is swept at once,
//   an odd one after both its neighbours,
//   the bodies of a slab move after it and the one before have been swept.
// In the next step
//   a slab is swept after the bodies of it and of the next one have moved.
#pragma once
#include <algorithm>
#include <atomic>
#include <cstdint>
#include <utility>
#include <vector>

#include "../../base/portable.hpp"

namespace hardlimit::boxes::steps {

struct Chore {
    // Beside the work, they bring cache lines near from another thread: look, what it has written and a sweep is to
    // read; fetch, what it has read and a move is to write. Earlier they would have to go there and back.
    enum Kind : std::uint32_t { sweep, move, look, fetch };
    Kind kind;
    std::uint32_t slab;
};

// Some of them, one after the other, by the same thread.
struct Task {
    std::vector<Chore> chores;
    std::vector<std::uint32_t> needs;  // slabs that are to be swept before
    bool reaches = false;              // into the next share, where all is to have moved in the step before
};

// What one thread does, which owns the slabs first … last − 1: at least two, or all of them. Bodies move soon after
// their slab is swept, while they are in the cache. It begins with an even slab. Those at the end, which reach into the
// slabs of the next thread, are swept halfway, and what needs the slabs of the thread before comes last: nobody waits
// unless another one is late by half a step.
inline std::vector<Chore> schedule(std::uint32_t first, std::uint32_t last, bool alone) {
    std::vector<Chore> chores;
    std::vector<bool> swept(last);
    const auto sweep = [&](std::uint32_t slab) {
        if (slab < last && !swept[slab]) chores.push_back({Chore::sweep, slab});
        if (slab < last) swept[slab] = true;
    };
    const auto move = [&](std::uint32_t slab) {
        if (slab < last) chores.push_back({Chore::move, slab});
    };
    const std::uint32_t even = first + first % 2, halfway = even + (last - first) / 2;
    sweep(even);
    for (std::uint32_t odd = even + 1; odd < last; odd += 2) {
        if (!alone && (odd >= halfway || odd + 2 >= last)) {
            if (!swept[last - 1]) chores.push_back({Chore::look, last - 1});
            if (last % 2 == 0)
                sweep(last - 2);
            else
                sweep(odd + 1), sweep(odd);
            sweep(last - 1);
        }
        if (!alone && odd + 2 >= last) chores.push_back({Chore::fetch, first});
        sweep(odd + 1), sweep(odd);
        move(odd), move(odd + 1);
    }
    if (first < even) sweep(first), move(first);
    move(even);
    return chores;
}

// The slabs that have to be swept before a chore, of so many slabs.
inline std::vector<std::uint32_t> needs(Chore chore, std::uint32_t slabs) {
    const std::uint32_t before = (chore.slab + slabs - 1) % slabs;
    switch (chore.kind) {
        case Chore::sweep:
            if (chore.slab % 2 == 0) return {};
            return {before, (chore.slab + 1) % slabs};
        case Chore::move:
            return {chore.slab, before};
        case Chore::look:
            return {};
        case Chore::fetch:
            break;
    }
    return {before};
}

// The chores of the slabs first … last − 1 as a few tasks: to take one and to ask whether it may be done costs as much
// as to move a dozen bodies. What waits for another thread begins a task.
inline std::vector<Task> tasks(const std::vector<Chore>& chores, std::uint32_t first, std::uint32_t last,
                               std::uint32_t slabs) {
    constexpr std::size_t most = 8;
    std::vector<Task> made;
    std::vector<bool> swept(slabs);  // in this task
    for (const Chore chore : chores) {
        const auto has = [&](std::uint32_t slab) { return std::ranges::count(made.back().needs, slab) > 0; };
        const auto waits = [&](std::uint32_t slab) { return (slab < first || slab >= last) && !has(slab); };
        const std::vector<std::uint32_t> needed = needs(chore, slabs);
        // Where the last slab is odd, it waits for the next one to be swept, which has moved before.
        const bool reaches =
            chore.kind == Chore::sweep && chore.slab + 1 == last && last % 2 == 1 && last - first < slabs;
        if (made.empty() || made.back().chores.size() == most || reaches ||
            std::ranges::any_of(needed, waits)) {
            made.emplace_back();
            made.back().reaches = reaches;
            swept.assign(slabs, false);
        }
        for (const std::uint32_t slab : needed)
            if (!swept[slab] && !has(slab)) made.back().needs.push_back(slab);
        if (chore.kind == Chore::sweep) swept[chore.slab] = true;
        made.back().chores.push_back(chore);
    }
    return made;
}

// Where the slabs of each share begin: about as many bodies for each, slab by slab. Shares beyond half the number of
// slabs have none.
template <class Slabs>
std::vector<std::uint32_t> cuts(const Slabs& slabs, std::size_t bodies, std::uint32_t shares) {
    const auto count = static_cast<std::uint32_t>(slabs.size());
    const std::uint32_t filled = std::clamp(count / 2, 1u, shares);
    std::vector<std::uint32_t> cut(shares + 1, count);
    cut[0] = 0;
    for (std::uint32_t k = 1; k < filled; ++k) {
        const std::size_t wanted = bodies * k / filled;
        std::uint32_t at = cut[k - 1] + 2;
        const std::uint32_t most = count - 2 * (filled - k);
        const auto off = [&](std::uint32_t slab) {
            const std::size_t begin = slabs[slab].first_body;
            return begin < wanted ? wanted - begin : begin - wanted;
        };
        while (at < most && off(at + 1) <= off(at)) ++at;
        cut[k] = at;
    }
    return cut;
}

// What different threads write lies so far apart: two cache lines, which the hardware fetches in pairs.
inline constexpr std::size_t apart = 128;

// A phase of several steps. Its tasks are those of the first one, of the next and so on. What a thread waits for is
// what its next task needs, so threads drift apart by up to half a step with each border between them. Nobody begins a
// step before all have ended the last but one: who asks for an early end gets it one step later, at the same step with
// any number of threads, and the tasks of all further ones are skipped.
class Course {
public:
    static constexpr std::uint32_t most_slabs = 128;

    // Between two phases, as `begin`: deals the slabs out.
    template <class Slabs>
    void deal(const Slabs& slabs, std::size_t bodies, std::uint32_t shares) {
        const auto count = static_cast<std::uint32_t>(slabs.size());
        std::vector<std::uint32_t> cut = cuts(slabs, bodies, shares);
        if (cut != cuts_) {
            cuts_ = std::move(cut);
            tasks_.resize(shares);
            filled_ = 0;
            for (std::uint32_t k = 0; k < shares; ++k) {
                const std::uint32_t first = cuts_[k], last = cuts_[k + 1];
                tasks_[k] = steps::tasks(schedule(first, last, cuts_[1] == count), first, last, count);
                filled_ += first < last;
            }
        }
        done_ = std::vector<Done>(shares);
        before_.assign(shares, 0);
        span_ = 0;
    }
    void begin(std::uint64_t step, std::uint32_t steps) {
        for (std::uint32_t k = 0; k < shares(); ++k) before_[k] += std::uint64_t{span_} * tasks_[k].size();
        first_ = step, span_ = steps;
        if (last_.load(std::memory_order_relaxed) != never) last_.store(never, std::memory_order_relaxed);
    }
    std::uint32_t shares() const { return static_cast<std::uint32_t>(tasks_.size()); }
    std::uint32_t first_slab(std::uint32_t share) const { return cuts_[share]; }
    // In the phase.
    std::uint32_t tasks(std::uint32_t share) const {
        return span_ * static_cast<std::uint32_t>(tasks_[share].size());
    }

    bool ready(std::uint32_t share, std::uint32_t task) const {
        const auto [ahead, at] = place(share, task);
        if (at == 0 && ahead > 0 && !may_begin(share, ahead)) return false;
        if (skips(ahead)) return true;
        const Task& t = tasks_[share][at];
        if (t.reaches && !ended(next(share), ahead)) return false;
        return std::ranges::all_of(t.needs, [&](std::uint32_t slab) {
            return swept_[slab].step.load(std::memory_order_acquire) >= first_ + ahead;
        });
    }
    // Calls perform(chore, ahead), so many steps after the first one of the phase.
    template <class Perform>
    void perform(std::uint32_t share, std::uint32_t task, const Perform& perform) {
        const auto [ahead, at] = place(share, task);
        if (!skips(ahead))
            for (const Chore chore : tasks_[share][at].chores) {
                perform(chore, ahead);
                if (chore.kind == Chore::sweep)
                    swept_[chore.slab].step.store(first_ + ahead, std::memory_order_release);
            }
        done_[share].tasks.fetch_add(1, std::memory_order_release);
    }
    // By a chore: whether the slab is swept will soon be asked for.
    void look(std::uint32_t slab) const { prefetch(&swept_[slab].step); }
    // By a chore: only one more step is to follow.
    void end_after(std::uint32_t ahead) {
        const std::uint64_t last = first_ + ahead + 1;
        std::uint64_t was = last_.load(std::memory_order_relaxed);
        while (was > last && !last_.compare_exchange_weak(was, last, std::memory_order_relaxed)) continue;
    }
    // At the end of the phase: the steps that were made.
    std::uint32_t steps() const {
        const std::uint64_t last = last_.load(std::memory_order_relaxed);
        return last < first_ + span_ ? static_cast<std::uint32_t>(last - first_) + 1 : span_;
    }

private:
    static constexpr std::uint64_t never = ~std::uint64_t{0};
    struct alignas(apart) Swept {
        std::atomic<std::uint64_t> step{0};  // at which a slab was swept last
    };
    struct alignas(apart) Done {
        std::atomic<std::uint64_t> tasks{0};  // of a share, since the slabs were dealt out
    };

    std::vector<std::uint32_t> cuts_;       // [shares + 1] first slab of each
    std::vector<std::vector<Task>> tasks_;  // of each share, in one step
    std::vector<std::uint64_t> before_;     // [shares] tasks done before this phase
    std::uint32_t filled_ = 0;              // shares that have slabs
    std::uint64_t first_ = 0;
    std::uint32_t span_ = 0;
    std::vector<Swept> swept_ = std::vector<Swept>(most_slabs);
    std::vector<Done> done_;
    alignas(apart) std::atomic<std::uint64_t> last_{never};  // step

    std::pair<std::uint32_t, std::uint32_t> place(std::uint32_t share, std::uint32_t task) const {
        const auto each = static_cast<std::uint32_t>(tasks_[share].size());
        return {task / each, task % each};
    }
    std::uint32_t next(std::uint32_t share) const { return share + 1 < filled_ ? share + 1 : 0; }
    // Whether the share has ended so many steps of the phase.
    bool ended(std::uint32_t share, std::uint32_t steps) const {
        return done_[share].tasks.load(std::memory_order_acquire) >=
               before_[share] + std::uint64_t{steps} * tasks_[share].size();
    }
    bool may_begin(std::uint32_t share, std::uint32_t ahead) const {
        if (!ended(share, ahead)) return false;
        for (std::uint32_t k = 0; k < filled_; ++k)
            if (k != share && !ended(k, ahead - 1)) return false;
        return true;
    }
    // The same for all tasks of a step: an end that was asked for two steps before is known where it begins, a later
    // one is later than this step.
    bool skips(std::uint32_t ahead) const { return last_.load(std::memory_order_relaxed) < first_ + ahead; }
};

}  // namespace hardlimit::boxes::steps
