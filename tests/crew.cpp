// For tests/test_crew.py: the order of a step and the threads that share it.
//
//   crew schedules          shares advance in random order: prints how many steps, and how many of them were wrong
//   crew threads N SHARES   N threads do the tasks of so many shares: prints the tasks, and how many were not done once
#include "particles/steps/crew.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <random>
#include <thread>
#include <vector>

#include "particles/steps/schedule.hpp"

namespace steps = hardlimit::particles::steps;

namespace {

struct Slab {
    std::size_t first_body;
};

// Whether every slab is swept and moves once, neighbours in turn, even ones first, wherever the shares begin.
bool right(std::uint32_t slabs, std::uint32_t shares, std::mt19937& engine) {
    std::vector<Slab> made;
    std::size_t bodies = 0;
    for (std::uint32_t k = 0; k < slabs; ++k) made.push_back({bodies}), bodies += 1 + engine() % 1000;
    const std::vector<std::uint32_t> cut = steps::cuts(made, bodies, shares);
    std::vector<std::vector<steps::Task>> tasks;
    for (std::uint32_t k = 0; k < shares; ++k) {
        const std::vector<steps::Chore> chores = steps::schedule(cut[k], cut[k + 1], cut[1] == slabs);
        tasks.push_back(steps::tasks(chores, cut[k], cut[k + 1], slabs));
        if (!tasks[k].empty() && !tasks[k][0].needs.empty()) return false;
    }
    std::vector<std::size_t> next(shares, 0), chore(shares, 0);
    std::vector<int> swept(slabs, 0), moved(slabs, 0);
    for (std::size_t idle = 0; idle < 1000 * shares;) {
        const std::uint32_t k = engine() % shares;
        const bool open =
            next[k] < tasks[k].size() &&
            (chore[k] > 0 ||
             std::ranges::all_of(tasks[k][next[k]].needs, [&](std::uint32_t s) { return swept[s] > 0; }));
        if (!open) {
            ++idle;
            continue;
        }
        idle = 0;
        const std::vector<steps::Chore>& chores = tasks[k][next[k]].chores;
        const auto [kind, slab] = chores[chore[k]++];
        if (chore[k] == chores.size()) ++next[k], chore[k] = 0;
        const std::uint32_t after = (slab + 1) % slabs, before = (slab + slabs - 1) % slabs;
        if (kind == steps::Chore::sweep) {
            ++swept[slab];
            // It looks at both slabs, and even ones push first.
            if (moved[slab] || moved[after]) return false;
            if (slab % 2 == 1 ? !swept[before] || !swept[after]
                              : (slabs > 1 && (swept[before] || swept[after])))
                return false;
        } else if (kind == steps::Chore::move) {
            ++moved[slab];
            if (!swept[slab] || !swept[before]) return false;
        }
    }
    for (std::uint32_t s = 0; s < slabs; ++s)
        if (swept[s] != 1 || moved[s] != 1) return false;
    return true;
}

int schedules() {
    std::mt19937 engine(1);
    int wrong = 0, all = 0;
    for (std::uint32_t slabs = 1; slabs <= 128; slabs += slabs == 1 ? 1 : 2)
        for (std::uint32_t shares = 1; shares <= 9; ++shares, ++all) wrong += !right(slabs, shares, engine);
    std::printf("%d %d\n", all, wrong);
    return 0;
}

// Phases of a random number of tasks, each of which needs the same one of the share before, if that has begun with it.
struct Job {
    static constexpr int phases = 3000;
    static constexpr std::uint32_t most = 7;
    std::uint32_t shares;
    std::vector<std::uint32_t> counts;
    std::vector<std::atomic<int>> done;
    std::mt19937 engine{2};
    int phase = 0;
    long tasks_done = 0, wrong = 0;

    explicit Job(std::uint32_t n) : shares(n), counts(n, 3), done(n * most) {}

    std::uint32_t tasks(std::uint32_t share) const { return counts[share]; }
    bool ready(std::uint32_t share, std::uint32_t task) const {
        const std::uint32_t other = (share + 1) % shares;
        return task == 0 || task > counts[other] || done[other * most + task - 1] > 0;
    }
    void perform(std::uint32_t share, std::uint32_t task) {
        if (task == 2 && phase % 500 == 1) std::this_thread::sleep_for(std::chrono::milliseconds(2));
        ++done[share * most + task];
    }
    void next(hardlimit::Stop&) {
        for (std::uint32_t share = 0; share < shares; ++share)
            for (std::uint32_t task = 0; task < most; ++task) {
                tasks_done += done[share * most + task];
                wrong += done[share * most + task].exchange(0) != (task < counts[share]);
            }
        ++phase;
        for (std::uint32_t& n : counts) n = phase < phases ? engine() % (most + 1) : 0;
        if (phase < phases) counts[engine() % shares] = most;
    }
};

int threads(int count, std::uint32_t shares) {
    Job job(shares);
    steps::Crew crew(static_cast<int>(shares));
    crew.begin(job);
    {
        std::vector<std::jthread> team;
        for (int i = 0; i < count; ++i)
            team.emplace_back([&] {
                hardlimit::Stop stop;
                crew.work(stop, job);
            });
    }
    std::printf("%ld %ld\n", job.tasks_done, job.wrong + (job.phase != Job::phases));
    return 0;
}

}  // namespace

int main(int count, char** words) {
    if (count == 4 && std::strcmp(words[1], "threads") == 0)
        return threads(std::atoi(words[2]), static_cast<std::uint32_t>(std::atoi(words[3])));
    return schedules();
}
