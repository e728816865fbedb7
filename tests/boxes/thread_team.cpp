// Program for test_thread_team.py: a ThreadTeam works through phases of tasks.
//
//   thread_team N PARTITIONS   prints the number of tasks that N threads did, and of those not done exactly once per
//                              phase
#include "boxes/newton_steps/thread_team.hpp"

#include <cstdio>
#include <cstdlib>

namespace {

struct Work {
    static constexpr int phases = 3000;
    std::vector<std::atomic<int>> done;
    int phase = 0;
    long tasks = 0, wrong = 0;

    explicit Work(std::uint32_t partitions) : done(partitions) {}

    void perform(std::uint32_t partition) {
        if (phase % 500 == 1 && partition == 1) std::this_thread::sleep_for(std::chrono::milliseconds(2));
        ++done[partition];
    }
    bool next(hardlimit::Stop&) {
        for (std::atomic<int>& of_partition : done) {
            const int times = of_partition.exchange(0);
            tasks += times;
            wrong += times != 1;
        }
        return ++phase < phases;
    }
};

}  // namespace

int main(int count, char** words) {
    if (count != 3) return 2;
    const auto partitions = static_cast<std::uint32_t>(std::atoi(words[2]));
    Work work(partitions);
    hardlimit::boxes::steps::ThreadTeam team(partitions);
    {
        std::vector<std::jthread> threads;
        for (int i = 0; i < std::atoi(words[1]); ++i)
            threads.emplace_back([&] {
                hardlimit::Stop never;
                team.work(never, work);
            });
    }
    std::printf("%ld %ld\n", work.tasks, work.wrong);
}
