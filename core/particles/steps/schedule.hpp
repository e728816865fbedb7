// In which order the slabs are worked on in a step.
//
// A sweep finds the contacts of the pairs that belong to a slab; it pushes bodies of this slab and the next one. Then
// bodies may move. Every body is to receive its pushes in one order, whoever works: those of an even slab first. So
//   an even slab is swept at once,
//   an odd one after both its neighbours,
//   the bodies of a slab move after it and the one before have been swept.
#pragma once
#include <algorithm>
#include <cstdint>
#include <vector>

namespace hardlimit::particles::steps {

struct Chore {
    // look: brings near what another thread has moved; fetch: what another thread has looked at, to be moved.
    enum Kind : std::uint32_t { sweep, move, look, fetch };
    Kind kind;
    std::uint32_t slab;
};

// Some of them, one after the other, by the same thread.
struct Task {
    std::vector<Chore> chores;
    std::vector<std::uint32_t> needs;  // slabs that are to be swept before
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
    if (!alone) chores.push_back({Chore::look, last - 1});
    for (std::uint32_t odd = even + 1; odd < last; odd += 2) {
        if (!alone && (odd >= halfway || odd + 2 >= last)) {
            if (last % 2 == 0) sweep(last - 2);
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
        if (made.empty() || made.back().chores.size() == most || std::ranges::any_of(needed, waits)) {
            made.emplace_back();
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

}  // namespace hardlimit::particles::steps
