// Contacts with friction under a linear law by power series and by the general method: prints how many were compared,
// how many the series left to the other method, the largest differences of duration, velocity and spin, and of the
// balance of energy, how many velocities differ by more than 1e-11, and the largest difference of states near the end.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <vector>

#include "boxes/binary_contact/turning_contact.hpp"
#include "contact/linear_dashpot.hpp"

namespace {

using namespace hardlimit;
using namespace hardlimit::boxes;
using Law = contact::LinearDashpot;

std::mt19937_64 bits(3);
double uniform() { return static_cast<double>(bits() >> 11) * 0x1p-53; }
double decades(double least, double most) { return least * math::exp(uniform() * math::log(most / least)); }
template <std::size_t n>
double any_of(const double (&values)[n]) {
    return values[static_cast<std::size_t>(uniform() * n)];
}
Vector3 any_vector() { return {2.0 * uniform() - 1.0, 2.0 * uniform() - 1.0, 2.0 * uniform() - 1.0}; }

// The normal speed, the effective mass and the distance at touch are 1.
struct Contact {
    WithFriction<Law> law;
    TurningApproach touch;
};
Contact any_contact() {
    const double restitution = any_of({1.0, 1.0 - 1e-6, 0.9, 0.6, 0.3, 0.05}), part = decades(1e-5, 0.3);
    const Law normal = Law::from_damping_ratio((math::pi / part) * (math::pi / part),
                                               contact::linear_damping_ratio(-math::log(restitution)), 1.0);
    FrictionTerms friction;
    friction.coefficient = any_of({0.05, 0.1, 0.5, 1.5, math::infinity});
    friction.stiffness = {decades(0.05, 3.0) * normal.stiffness, 0};
    friction.damping = {any_of({0.0, 0.0, 0.5, 1.0}) * normal.damping, 0};
    friction.limit = uniform() < 0.8 ? SlipLimit::total : SlipLimit::spring;
    const bool wall = uniform() < 0.2, flat = uniform() < 0.2;
    TurningApproach a{1.0, wall ? math::infinity : 1.0, 1.0, decades(1.0, 8.0), {0.0, 0.0, 1.0}, {}, {}};
    const double slide = any_of({0.0, 1e-6, 0.1, 1.0, 3.0, 30.0}), turn = any_of({0.0, 1e-8, 0.1, 1.0, 10.0});
    for (std::size_t k = 0; k < 3; ++k)
        a.velocity[k] = slide * any_vector()[k], a.spin[k] = turn * any_vector()[k];
    if (flat) a.velocity[1] = a.spin[0] = a.spin[2] = 0.0;
    a.velocity[2] = -1.0;
    return {{normal, friction}, a};
}

// Contacts of which a change between stick and slip is easily missed.
const Contact hard_to_follow[] = {
    // Hardly damped: the surfaces stick at touch, where the force jumps, slip after 2e-5 of the contact, and stick
    // again after .008 of it.
    {{Law{15284907993.197212, 0.0787067251553},
      {.coefficient = 1.5, .stiffness = {25549108822.579277, 0}, .damping = {0.0787067251553, 0}}},
     {1.0, 1.0, 1.0, 6.42902, {0.0, 0.0, 1.0}, {0.0, 0.0, -1.0}, {0.0, -0.90063809801758588, 0.0}}},
    // Nearly in a plane: the direction of slip hardly turns, but the surfaces stick and slip once more.
    {{Law{71747526886.756165, 1042150.3074574108},
      {.coefficient = 1.5, .stiffness = {133891047290.01178, 0}, .damping = {0.0, 0}}},
     {1.0,
      1.0,
      1.0,
      2.5714620279776357,
      {0.0, 0.0, 1.0},
      {-0.40203856856536, 0.22956926536595, -1.0},
      {8.5167183611723909e-9, 8.2823011196623e-9, -3.733281177e-9}}},
    // They slip from .38 to .40 of the contact. Then the force of friction turns back, reaching the limit again at .58.
    {{Law{7561.1391470277013, 338.31441938773628},
      {.coefficient = 0.5,
       .stiffness = {13315.003777253009, 0},
       .damping = {0.0, 0},
       .limit = SlipLimit::spring}},
     {1.0,
      math::infinity,
      1.0,
      7.2446050057867959,
      {0.0, 0.0, 1.0},
      {-0.6151516104378183, -0.0721658649447545, -1.0},
      {}}},
    // Undamped: they stick at touch, where all forces begin at zero, and slip from .0006 to .008 of the contact.
    {{Law{315.29676217233146, 0.0},
      {.coefficient = 0.5, .stiffness = {490.79185439892137, 0}, .damping = {0.0, 0}}},
     {1.0,
      1.0,
      1.0,
      3.4027421987910533,
      {0.0, 0.0, 1.0},
      {0.34784637594473966, 0.0, -1.0},
      {0.0, 0.026655891512127685, 0.0}}},
    // Near the end the force of friction turns round, after it has been beyond its limit from .957 to .962.
    {{Law{279.46333072980173, 65.041314303241819},
      {.coefficient = 0.5, .stiffness = {260.85496390860891, 0}, .damping = {0.0, 0}}},
     {1.0,
      1.0,
      1.0,
      3.5754494501930258,
      {0.0, 0.0, 1.0},
      {9.4121685449021548e-07, -4.8666839677637828e-07, -1.0},
      {0.012270005343074854, -0.03200112097863126, 0.086457987913387171}}},
    // Undamped: they slip at touch, and stick from .016 to .050.
    {{Law{295.65515103213397, 0.0},
      {.coefficient = 0.5,
       .stiffness = {21.785884649391708, 0},
       .damping = {0.0, 0},
       .limit = SlipLimit::spring}},
     {1.0,
      1.0,
      1.0,
      3.348080577860808,
      {0.0, 0.0, 1.0},
      {0.0035581788010083273, -0.037941397548055922, -1.0},
      {5.9205484225376726, 3.4127585631213808, 7.4065655285198169}}},
};

double size(const Vector3& a) { return math::sqrt(dot(a, a)); }
double difference(const Vector3& a, const Vector3& b) {
    return size({a[0] - b[0], a[1] - b[1], a[2] - b[2]});
}

double imbalance(const TurningApproach& a, const TurningContact& e) {
    const auto energy = [&](const Vector3& v, const Vector3& w) {
        return 0.5 * (dot(v, v) + dot(w, w) / a.rotational_ratio);
    };
    const double before = energy(a.velocity, a.spin);
    const double taken =
        e.normal_spring + e.tangential_spring + e.normal_damping + e.tangential_damping + e.slip;
    return math::abs(energy(e.velocity, e.spin) + taken - before) / before;
}

// States at these times, in ascending order.
template <class Method>
std::vector<TurningState> states(const Contact& c, const std::vector<double>& times) {
    std::vector<TurningState> path;
    Method(c.law, c.touch).integrate([&](auto& run) {
        while (path.size() < times.size() && times[path.size()] <= run.end_time())
            path.push_back(run.at(times[path.size()]));
    });
    return path;
}
// The largest difference of velocities and spins, and of the forces in units of those at half the time.
double apart_near_the_end(const Contact& c, double duration) {
    std::vector<double> times{0.5 * duration};
    for (const double left : {1e-2, 3e-3, 1e-3, 3e-4, 1e-4}) times.push_back(duration * (1.0 - left));
    const auto a = states<TurningSeries<Law>>(c, times), b = states<TurningSolver<Law>>(c, times);
    double largest = a.size() == times.size() && b.size() == times.size() ? 0.0 : math::infinity;
    for (std::size_t i = 0; i < math::min(a.size(), b.size()); ++i) {
        largest = math::max(largest, difference(a[i].velocity, b[i].velocity));
        largest = math::max(largest, difference(a[i].spin, b[i].spin));
        const double force = difference(a[i].tangential_force, b[i].tangential_force);
        largest = math::max(largest, force / math::max(b[0].normal_force, b[i].normal_force));
    }
    return largest / (size(c.touch.velocity) + size(c.touch.spin));
}

}  // namespace

int main(int, char** arguments) {
    const int count = arguments[1] ? std::atoi(arguments[1]) : 3000;
    int compared = 0, left = 0, many = 0;
    double duration = 0.0, motion = 0.0, balance = 0.0, path = 0.0;
    for (int i = 0; i < count; ++i) {
        const Contact c = i < std::ssize(hard_to_follow) ? hard_to_follow[i] : any_contact();
        const TurningContact whole = TurningSolver<Law>(c.law, c.touch).integrate([](const auto&) {});
        const TurningContact end = TurningSeries<Law>(c.law, c.touch).integrate([](const auto&) {});
        if (whole.outcome != Outcome::ok || end.outcome != Outcome::ok) {
            ++left;
            continue;
        }
        const double speed = size(c.touch.velocity) + size(c.touch.spin);
        const double off =
            math::max(difference(end.velocity, whole.velocity), difference(end.spin, whole.spin)) / speed;
        ++compared, many += off > 1e-11;
        duration = math::max(duration, math::abs(end.duration / whole.duration - 1.0));
        motion = math::max(motion, off);
        balance = math::max(balance, imbalance(c.touch, end));
        path = math::max(path, apart_near_the_end(c, whole.duration));
    }
    std::printf("%d %d %.3g %.3g %.3g %d %.3g\n", compared, left, duration, motion, balance, many, path);
}
