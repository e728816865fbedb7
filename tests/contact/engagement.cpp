// Program for test_engagement.py: compares two ways to compute the time at which a slack pair engages in free flight:
// the closed form for a law with a relaxation time, and the search for any law. Prints the number of cases, the largest
// relative difference of the times, and the number of cases in which only one of them found a time.
#include <cmath>
#include <cstdio>
#include <random>

#include "contact/events.hpp"
#include "contact/linear_dashpot.hpp"

namespace {

struct WithoutRelaxationTime {
    hardlimit::contact::LinearDashpot law;
    hardlimit::Slack slack(double rate) const { return law.slack(rate); }
};

}  // namespace

int main() {
    using hardlimit::time_to_engage;
    constexpr double g = 9.81;
    std::mt19937 engine(1);
    std::uniform_real_distribution<double> share(0.0, 1.0);
    long compared = 0, only_one = 0;
    double worst = 0.0;
    for (int i = 0; i < 100'000; ++i) {
        const double relaxation = std::pow(10.0, -6.0 + 5.0 * share(engine));
        const double rate = -std::pow(10.0, -5.0 + 5.0 * share(engine));
        const bool just_ended = share(engine) < 0.3;
        const double depth = -relaxation * rate * (just_ended ? 1.0 : share(engine));
        const WithoutRelaxationTime any{{1.0, relaxation}};
        const double closed = time_to_engage(any.law, depth, rate, g, just_ended);
        const double found = time_to_engage(any, depth, rate, g, just_ended);
        const double square = rate * rate - 2.0 * g * depth;
        const double opens = square > 0.0 ? 2.0 * depth / (std::sqrt(square) - rate) : INFINITY;
        if (closed < opens) {
            ++compared;
            const double unit = std::fmax(closed, 1e-6 * std::fmin(opens, -rate / g));
            worst = std::fmax(worst, std::fabs(found - closed) / unit);
        } else if (found < opens * (1.0 - 1e-9)) {
            ++only_one;
        }
    }
    std::printf("%ld %g %ld\n", compared, worst, only_one);
}
