// Program for test_newton_events.py: compares ContactEndQueue with a sorted set, while contacts begin, are disturbed
// and end. Prints the numbers of ended contacts, simultaneous ends, disturbed contacts and differences.
#include "boxes/newton_events/contact_end_queue.hpp"

#include <cstdio>
#include <random>
#include <set>
#include <tuple>

using namespace hardlimit::boxes;

int main() {
    std::mt19937 engine(1);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    long ended = 0, simultaneous = 0, disturbed = 0, wrong = 0;
    for (int run = 0; run < 400; ++run) {
        constexpr int bodies = 500;
        const bool equal = run % 2 != 0, ties = run % 3 != 0;
        std::vector<double> end(bodies, -1.0);  // of bodies in contact
        std::vector<int> name(bodies);
        for (int i = 0; i < bodies; ++i) name[static_cast<std::size_t>(i)] = (i * 7 + run) % bodies;
        const auto named = [&](int i) { return name[static_cast<std::size_t>(i)]; };
        const auto valid = [&](const ContactEnd& e) {
            return end[static_cast<std::size_t>(e.first)] == e.time && e.group == 2 * e.first;
        };
        ContactEndQueue queue;
        std::set<std::tuple<double, int, int>> sorted;
        double now = 0.0, last = -1.0;
        for (int step = 0; step < 1500; ++step) {
            now += ties ? static_cast<double>(engine() % 3) : uniform(engine);
            for (;;) {
                const ContactEnd* const next = queue.next(valid, named);
                const bool any = !sorted.empty() && std::get<0>(*sorted.begin()) <= now;
                if (!any) {
                    wrong += next && next->time <= now;
                    break;
                }
                const auto [time, who, body] = *sorted.begin();
                sorted.erase(sorted.begin());
                wrong += !next || next->time != time || next->first != body;
                if (next) queue.pop(named);
                end[static_cast<std::size_t>(body)] = -1.0;
                ++ended, simultaneous += time == last;
                last = time;
            }
            const int body = static_cast<int>(engine() % bodies);
            double& until = end[static_cast<std::size_t>(body)];
            if (until >= 0.0) {
                sorted.erase({until, named(body), body});
                until = -1.0, ++disturbed;
            }
            if (engine() % 8 == 0) continue;
            until = now + (equal  ? 100.0
                           : ties ? static_cast<double>(engine() % 200)
                                  : 200.0 * uniform(engine));
            queue.push(until, body, 2 * body, named);
            sorted.insert({until, named(body), body});
        }
    }
    std::printf("%ld %ld %ld %ld\n", ended, simultaneous, disturbed, wrong);
}
