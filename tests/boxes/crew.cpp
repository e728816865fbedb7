// For test_crew.py: the order of steps and the threads that share it.
//
//   crew schedules          shares advance in random order: prints how many courses of steps, how many of them were
//                           wrong, and in how many a share began a step before another one had begun the last
//   crew threads N SHARES   N threads do the tasks of so many shares: prints the tasks, and how many were not done once
#include "boxes/newton_steps/thread_team.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <random>
#include <thread>
#include <vector>

#include "boxes/newton_steps/schedule.hpp"

namespace steps = hardlimit::boxes::steps;

namespace {

struct Slab {
    std::size_t first_body;
};

// A course of steps of which each share does a chore now and then, wherever the shares begin. Some who move ask for an
// early end.
class Order {
public:
    Order(std::uint32_t slabs, std::uint32_t shares, std::mt19937& engine)
        : slabs_(slabs), shares_(shares), engine_(engine), steps_(1 + engine() % 12) {
        std::vector<Slab> made;
        std::size_t bodies = 0;
        for (std::uint32_t k = 0; k < slabs; ++k) made.push_back({bodies}), bodies += 1 + engine() % 1000;
        course_.deal(made, bodies, shares);
    }

    // In some courses, one after the other: slabs are swept and moved in turn, even ones first, and all end where the
    // first one has asked for it.
    bool right() {
        std::uint64_t step = 2;
        for (int k = 0; k < 3 && right_; ++k) {
            course_.begin(step, steps_);
            next_.assign(shares_, 0), swept_.assign(slabs_, 0), moved_.assign(slabs_, 0);
            asks_ = engine_() % 2 == 0 ? static_cast<std::uint32_t>(engine_() % (slabs_ * steps_))
                                       : slabs_ * steps_;
            for (int idle = 0; idle < 300 * static_cast<int>(shares_);) idle = advance() ? 0 : idle + 1;
            const std::uint32_t made = std::min(steps_, asks_ / slabs_ + 2);
            right_ = right_ && course_.steps() == made && std::ranges::count(swept_, made) == slabs_ &&
                     std::ranges::count(moved_, made) == slabs_;
            step += made;
        }
        return right_;
    }
    std::uint32_t lead() const { return lead_; }

private:
    std::uint32_t slabs_, shares_;
    std::mt19937& engine_;
    std::uint32_t steps_;
    steps::Course course_;
    std::vector<std::uint32_t> next_, swept_, moved_;
    std::vector<bool> busy_ = std::vector<bool>(shares_);
    std::uint32_t asks_ = 0;  // step and slab
    std::uint32_t lead_ = 0;  // of one share before another one, in steps
    bool right_ = true;

    // A task of some share, in the middle of which others go on.
    bool advance() {
        const std::uint32_t share = engine_() % shares_;
        if (busy_[share] || next_[share] == course_.tasks(share)) return false;
        const std::uint32_t task = next_[share];
        if (task == 0 ? false : !course_.ready(share, task)) return false;
        busy_[share] = true;
        course_.perform(share, task, [&](steps::Chore chore, std::uint32_t ahead) {
            while (engine_() % 4 == 0) advance();
            if (ahead >= steps_) right_ = false;
            if (chore.kind == steps::Chore::sweep) sweep(chore.slab, ahead);
            if (chore.kind == steps::Chore::move) move(chore.slab, ahead);
            while (engine_() % 4 == 0) advance();
        });
        ++next_[share];
        busy_[share] = false;
        return true;
    }
    std::uint32_t after(std::uint32_t slab) const { return (slab + 1) % slabs_; }
    std::uint32_t before(std::uint32_t slab) const { return (slab + slabs_ - 1) % slabs_; }
    // It looks at both slabs, and even ones push first.
    void sweep(std::uint32_t slab, std::uint32_t ahead) {
        const std::uint32_t neighbours = ahead + slab % 2;
        const bool alone = slabs_ == 1;
        right_ = right_ && swept_[slab] == ahead && moved_[slab] == ahead && moved_[after(slab)] == ahead &&
                 (alone || (swept_[before(slab)] == neighbours && swept_[after(slab)] == neighbours));
        ++swept_[slab];
        lead_ = std::max(lead_, ahead + 1 - std::ranges::min(swept_));
    }
    void move(std::uint32_t slab, std::uint32_t ahead) {
        right_ =
            right_ && moved_[slab] == ahead && swept_[slab] == ahead + 1 && swept_[before(slab)] == ahead + 1;
        if (ahead * slabs_ + slab == asks_ || (ahead * slabs_ > asks_ && slab % 7 == 0))
            course_.end_after(ahead);
        ++moved_[slab];
    }
};

int schedules() {
    std::mt19937 engine(1);
    int wrong = 0, all = 0, apart = 0;
    for (std::uint32_t slabs = 1; slabs <= 128; slabs += slabs == 1 ? 1 : 2)
        for (std::uint32_t shares = 1; shares <= 9; ++shares, ++all) {
            Order order(slabs, shares, engine);
            wrong += !order.right();
            apart += order.lead() > 1;
        }
    std::printf("%d %d %d\n", all, wrong, apart);
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
