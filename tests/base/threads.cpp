// For test_threads.py: members of a team go through phases together.
//
//   threads phases N   prints how many phases N threads finished, and in how many of them one was missing
//   threads failure N  one of N threads throws: prints how many have returned, and whether the caller got the exception
#include "base/threads.hpp"

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

using hardlimit::ThreadTeam;

namespace {

constexpr int phases = 3000;
constexpr auto period = std::chrono::milliseconds(10);
constexpr auto never = [] { return false; };

int count_phases(int threads) {
    std::vector<int> done(static_cast<std::size_t>(threads));
    int finished = 0, wrong = 0;
    const auto work = [&](ThreadTeam::Member& me) {
        for (int phase = 1; phase <= phases; ++phase) {
            if (phase % 500 == 1 && me.index == phase / 500 % threads)
                std::this_thread::sleep_for(std::chrono::milliseconds(2));
            ++done[static_cast<std::size_t>(me.index)];
            me.sync([&] {
                for (const int of_member : done) wrong += of_member != phase;
                ++finished;
            });
        }
    };
    ThreadTeam().run(threads, period, work, never);
    std::printf("%d %d\n", finished, wrong);
    return 0;
}

int fail(int threads) {
    std::atomic<int> returned{0};
    bool caught = false;
    const auto work = [&](ThreadTeam::Member& me) {
        struct AtReturn {
            std::atomic<int>& returned;
            ~AtReturn() { ++returned; }
        } at_return{returned};
        for (int phase = 0; phase < phases; ++phase) {
            if (phase == 1000 && me.index == threads - 1) throw std::runtime_error("as asked");
            me.sync();
        }
    };
    try {
        ThreadTeam().run(threads, period, work, never);
    } catch (const std::runtime_error& error) {
        caught = std::strcmp(error.what(), "as asked") == 0;
    }
    std::printf("%d %d\n", returned.load(), caught);
    return 0;
}

}  // namespace

int main(int count, char** words) {
    if (count != 3) return 2;
    const int threads = std::atoi(words[2]);
    return std::strcmp(words[1], "phases") == 0 ? count_phases(threads) : fail(threads);
}
