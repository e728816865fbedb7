// Program for test_sequence_rules.py: applies random sequences of events to the scalar rules of column/sequence.hpp and
// to the vector rules of sweep/lane_state.hpp. Prints the number of drops compared; how many of them finished, touched
// the floor again during a pair contact, and had a separation velocity; and in how many the two implementations differ.
#include <cstdio>
#include <random>

#include "sweep/lane_state.hpp"

namespace {

using hardlimit::column::Sequence;
namespace lanes = hardlimit::sweep::lanes;
namespace math = hardlimit::math;

constexpr int width = 2;
using Real = hardlimit::Vector<width>::Real;
using Flags = hardlimit::Mask<Real>;

// One drop: its sequence, the contacts that act and the gaps that are open.
struct Drop {
    Sequence sequence;
    bool floor = false, pair = false, floor_open = true, pair_open = true, counted = false;
};

enum class Event { floor_begins, floor_ends, floor_opens, pair_begins, pair_ends, pair_opens, free };

// Whether an event, in the order of the enum, may happen.
bool possible(const Drop& d, Event e) {
    const bool may[] = {
        !d.floor,           d.floor, !d.floor && !d.floor_open, !d.pair, d.pair, !d.pair && !d.pair_open,
        !d.floor && !d.pair};
    return may[static_cast<int>(e)];
}

void apply(Drop& d, Event e, double t, double rate, bool damped) {
    Sequence& q = d.sequence;
    switch (e) {
        case Event::floor_begins: {
            const bool first = math::is_nan(q.t_first_touch);
            d.floor = true;
            d.floor_open = false;
            q.floor_begins(t);
            if (first) q.clock_restarts();
            break;
        }
        case Event::floor_ends:
            d.floor = false;
            d.floor_open = !damped;
            q.floor_ends(t);
            if (d.floor_open) q.floor_opens();
            break;
        case Event::floor_opens:
            d.floor_open = true;
            q.floor_opens();
            break;
        case Event::pair_begins:
            d.pair = true;
            d.pair_open = false;
            d.counted = q.pair_begins();
            break;
        case Event::pair_ends:
            d.pair = false;
            d.pair_open = !damped;
            if (d.counted) q.pair_ends(t, rate);
            d.counted = false;
            break;
        case Event::pair_opens:
            d.pair_open = true;
            break;
        case Event::free:
            q.moves_freely(rate, q.floor_opened && d.floor_open);
            break;
    }
}

void apply(lanes::State<Real>& q, Flags m, Event e) {
    constexpr void (*rules[])(lanes::State<Real>&, Flags) = {
        lanes::floor_begins<Real>, lanes::floor_ends<Real>, lanes::floor_opens<Real>,
        lanes::pair_begins<Real>,  lanes::pair_ends<Real>,  lanes::pair_opens<Real>,
        lanes::moves_freely<Real>};
    rules[static_cast<int>(e)](q, m);
}

bool same(double a, double b) { return a == b || (math::is_nan(a) && math::is_nan(b)); }

bool same(const Drop& d, const lanes::State<Real>& q, int lane) {
    const Sequence& s = d.sequence;
    return static_cast<double>(s.n_contacts) == q.contacts[lane] && same(s.t_first_touch, q.t_first[lane]) &&
           same(s.t_end, q.t_end[lane]) && same(s.t_floor_end, q.t_floor_end[lane]) &&
           same(s.relative_velocity, q.relative[lane]) && same(s.separation_velocity, q.separation[lane]) &&
           s.finished == (q.active[lane] == 0) &&
           s.second_floor_contact == (q.second_floor_contact[lane] != 0) &&
           s.floor_opened == (q.opened[lane] != 0) && d.counted == (q.counted[lane] != 0) &&
           d.floor == (q.floor[lane] != 0) && d.pair == (q.pair[lane] != 0) &&
           d.floor_open == (q.floor_open[lane] != 0) && d.pair_open == (q.pair_open[lane] != 0);
}

struct Totals {
    long compared = 0, finished = 0, followed = 0, separated = 0, different = 0;
};

// Compares `width` drops, each with its own random events, over `most` events.
void compare(std::mt19937& engine, Totals& totals) {
    constexpr int most = 40, kinds = 7;
    const bool damped = engine() % 4 != 0;
    Drop drops[width];
    lanes::State<Real> q{};
    q.s.c1 = q.s.c2 = Real{} + (damped ? 0.3 : 0.0);
    q.x.u = q.x.w = Real{} + 1.0;
    lanes::start<Real>(q, q.x.u > 0.0);
    bool followed[width] = {};
    for (int i = 0; i < most; ++i) {
        const Event e = static_cast<Event>(engine() % kinds);
        Flags m{};
        for (int lane = 0; lane < width; ++lane) {
            Drop& d = drops[lane];
            // Each drop has its own clock, which restarts at the first touch.
            const double step = 1.0 / 64.0 * static_cast<double>(engine() % 100 + 1);
            const double rate = (static_cast<double>(engine() % 200) - 100.0) / 64.0;
            const bool takes_part = engine() % 4 != 0;
            if (d.sequence.finished || !takes_part || !possible(d, e)) continue;
            m[lane] = -1;
            q.t[lane] += step;
            q.x.dw[lane] = rate;
            followed[lane] |= e == Event::floor_begins && d.sequence.floor_opened && d.counted;
            apply(d, e, q.t[lane], rate, damped);
        }
        apply(q, m, e);
        for (int lane = 0; lane < width; ++lane)
            if (!same(drops[lane], q, lane)) {
                ++totals.different;
                return;
            }
    }
    for (int lane = 0; lane < width; ++lane) {
        ++totals.compared;
        totals.finished += drops[lane].sequence.finished;
        totals.followed += followed[lane];
        totals.separated += !math::is_nan(drops[lane].sequence.separation_velocity);
    }
}

}  // namespace

int main() {
    std::mt19937 engine(1);
    Totals totals;
    for (int i = 0; i < 50'000; ++i) compare(engine, totals);
    std::printf("%ld %ld %ld %ld %ld\n", totals.compared, totals.finished, totals.followed, totals.separated,
                totals.different);
}
