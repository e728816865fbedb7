// Compares the solutions of a contact with friction over random settings: `forms NUMBER WIDTH`: closed form and order 8
// of linear laws; `steps NUMBER`: all laws with the time steps that particle codes take. Prints the worst deviations.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>

#include "contact/frictional_impact.hpp"

namespace {

using namespace hardlimit;
using namespace hardlimit::contact;

class Random {
public:
    int below(int n) { return static_cast<int>(bits_() % static_cast<unsigned>(n)); }
    double between(double a, double b) {
        return a + (b - a) * (static_cast<double>(bits_() >> 11) * 0x1p-53);
    }
    double decades(double a, double b) { return std::exp(between(std::log(a), std::log(b))); }
    // With probability 1/n the special value.
    double rarely(int n, double special, double common) { return below(n) == 0 ? special : common; }

private:
    std::mt19937_64 bits_{1};
};

// A contact whose spring often follows its limit without slip.
void let_follow(Random& random, ScaledImpact& p) {
    p.normal_damping = random.rarely(4, 0.0, random.decades(0.003, 0.3));
    p.stiffness.factor = random.decades(4.0, 20.0);
    p.damping = {random.decades(4.0, 30.0), p.powers.damping};
    p.coefficient = random.decades(0.3, 1.0);
    p.limit = SlipLimit::spring;
}

// A linear contact. `width`: over how many orders of magnitude beyond the common values.
ScaledImpact linear_contact(Random& random, double width) {
    ScaledImpact p{{4, 0, random.below(4) == 0}, 0.0, {}, {}, 0, 0, SlipLimit::total, 0.0};
    const double ratios[] = {0.0, random.decades(1e-3, 2.0), random.decades(1e-6, 2.0 * width),
                             random.between(0.5, 4.0)};
    p.normal_damping = ratios[random.below(4)];
    if (p.powers.attracts) p.normal_damping = std::fmod(p.normal_damping, 1.9);
    p.stiffness = {random.rarely(8, 0.0, random.decades(0.1 / width, 10.0 * width)), 0};
    p.damping = {random.rarely(2, 0.0, random.decades(0.01 / width, 10.0 * std::sqrt(width))), 0};
    p.limit = random.below(2) ? SlipLimit::spring : SlipLimit::total;
    // Half of them near the border between stick and slip at touch.
    p.coefficient = random.rarely(2, random.decades(0.3, 3.0) * p.stiffness.factor,
                                  random.decades(0.1 / width, 30.0 * width));
    p.coefficient = random.rarely(16, math::infinity, p.coefficient);
    p.coefficient = random.rarely(16, 0.0, p.coefficient);
    if (random.below(8) == 0) let_follow(random, p);
    return p;
}

// A contact of any model. γ_t follows the damping of the normal force: constant, it would matter at once at touch,
// where steps see too little.
ScaledImpact any_contact(Random& random) {
    const int damping_powers[] = {0, 1, 2, 4}, model = random.below(6);
    const bool linear = model == 0;
    const FrictionModelRecord& history = friction_models[linear ? 0 : model % 5];
    ScaledImpact p{{linear ? 4 : 6, linear ? 0 : damping_powers[random.below(4)], random.below(4) == 0},
                   0.0,
                   {},
                   {},
                   history.loading,
                   history.unloading,
                   SlipLimit::total,
                   0.0};
    p.normal_damping = random.rarely(4, 0.0, random.decades(0.02, 1.2));
    if (!linear && p.powers.damping == 0) p.powers.attracts = false;  // such bodies may never separate
    p.stiffness = {random.rarely(8, 0.0, random.decades(0.1, 10.0)), linear || model % 5 == 0 ? 0 : 2};
    p.damping = {random.rarely(2, 0.0, p.normal_damping * random.decades(0.05, 4.0)), p.powers.damping};
    p.limit = random.below(2) ? SlipLimit::spring : SlipLimit::total;
    p.coefficient = random.rarely(16, math::infinity, random.decades(0.1, 10.0));
    if (random.below(4) == 0) let_follow(random, p);
    return p;
}

// Changes between stick and slip, and whether the spring followed its limit.
struct Counter {
    int transitions = -1;
    bool follows = false;
    Intervals<Counter> intervals{*this};

    void operator()(bool /*slips*/, double /*begin*/, double /*end*/) { ++transitions; }
    template <class At>
    void operator()(Surfaces surfaces, double begin, double end, const At& at) {
        follows = follows || surfaces == Surfaces::follow;
        intervals(surfaces, begin, end, at);
    }
};
template <class Solution>
Counter count(Solution& solution) {
    Counter counter;
    if (!solution.run(counter)) std::exit(1);
    counter.intervals.finish();
    return counter;
}

double relative(double a, double b) { return std::abs(a - b) / std::fmax(1.0, std::abs(b)); }

void compare_forms(int number, double width) {
    Random random;
    double slip = 0.0, rate = 0.0, time = 0.0, work = 0.0, ledger = 0.0;
    int counts = 0, follows = 0;
    for (int i = 0; i < number; ++i) {
        const ScaledImpact p = linear_contact(random, width);
        LinearImpact closed(p);
        PowerImpact general(p);
        const Counter of_closed = count(closed), of_general = count(general);
        if (of_closed.transitions != of_general.transitions) ++counts;
        if (of_general.follows) ++follows;
        const impact::State a = closed.state(), b = general.state();
        const impact::Work v = closed.work(), w = general.work();
        slip = std::fmax(slip, std::abs(a.slip - b.slip));
        rate = std::fmax(rate, std::abs(a.rate - b.rate));
        time = std::fmax(time, relative(a.time, b.time));
        const double scale = 1.0 + std::abs(w.sticking) + std::abs(w.slipping) + w.damping;
        for (const double d : {v.sticking - w.sticking, v.slipping - w.slipping, v.damping - w.damping,
                               v.normal_damping - w.normal_damping})
            work = std::fmax(work, std::abs(d) / scale);
        const double sum = 0.5 * b.slip * b.slip + w.sticking + w.slipping + w.damping - 0.5;
        ledger = std::fmax(ledger, std::abs(sum) / scale);
    }
    std::printf("slip %.3g\nrate %.3g\ntime %.3g\nwork %.3g\nledger %.3g\n", slip, rate, time, work, ledger);
    std::printf("counts %d\nfollows %d\n", counts, follows);
}

// Time steps as codes take them: the trial force is limited, and the spring set to what the limit leaves of it.
class Steps {
public:
    explicit Steps(const ScaledImpact& p) : p_(p) {}

    double slip_at_end(double step) {
        for (;;) {
            const double x = x_, v = v_;
            move(step);
            const double middle = 0.5 * (x + x_), rate = 0.5 * (v + v_);
            if (x_ <= 0.0) return slip_;
            const double f = force(middle, rate);
            if (!p_.powers.attracts && f <= 0.0 && rate < 0.0) return slip_;
            slip_ -= drag(middle, rate, p_.coefficient * std::abs(f), step) * step;
        }
    }

private:
    static double power(PowerTerm term, double x) { return term.factor * std::pow(x, 0.25 * term.power); }
    double force(double x, double v) const {
        if (x < 0.0) return 0.0;
        return std::pow(x, 0.25 * p_.powers.elastic) +
               p_.normal_damping * std::pow(x, 0.25 * p_.powers.damping) * v;
    }
    // Runge-Kutta of order 4.
    void move(double h) {
        const double a1 = -force(x_, v_), v2 = v_ + 0.5 * h * a1;
        const double a2 = -force(x_ + 0.5 * h * v_, v2), v3 = v_ + 0.5 * h * a2;
        const double a3 = -force(x_ + 0.5 * h * v2, v3), v4 = v_ + h * a3;
        const double a4 = -force(x_ + h * v3, v4);
        x_ += h / 6.0 * (v_ + 2.0 * v2 + 2.0 * v3 + v4);
        v_ += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
    }
    double drag(double x, double v, double limit, double h) {
        const double radius = std::sqrt(x), viscous = power(p_.damping, x) * slip_;
        const bool spring = p_.stiffness.factor > 0.0;
        if (radius_ > 0.0) spring_ *= std::pow(radius / radius_, v > 0.0 ? p_.loading : p_.unloading);
        radius_ = radius;
        if (spring) spring_ += power(p_.stiffness, x) * slip_ * h;
        const double trial = spring_ + viscous;
        const bool total = p_.limit == SlipLimit::total || !spring;
        if (std::abs(total ? trial : spring_) <= limit || limit != limit) return trial;
        const double limited = std::copysign(limit, total ? trial : spring_);
        if (spring) spring_ = total ? limited - viscous : limited;
        return limited;
    }

    ScaledImpact p_;
    double x_ = 0.0, v_ = 1.0, slip_ = 1.0, spring_ = 0.0, radius_ = 0.0;
};

void compare_steps(int number) {
    Random random;
    double worst = 0.0;
    int follows = 0;
    for (int i = 0; i < number; ++i) {
        const ScaledImpact p = any_contact(random);
        const double exact = with_solution(p, [&](auto& solution) {
            if (count(solution).follows) ++follows;
            return solution.state().slip;
        });
        const double coarse = Steps(p).slip_at_end(3e-4), fine = Steps(p).slip_at_end(3e-5);
        // Steps converge at a power of their length that the powers of ξ make small.
        const double deviation = std::abs(fine - exact) - 2.0 * std::abs(fine - coarse);
        worst = deviation == deviation ? std::fmax(worst, deviation) : math::infinity;
    }
    std::printf("steps %.3g\nfollows %d\n", worst, follows);
}

}  // namespace

int main(int count, char** arguments) {
    const std::string what = count > 2 ? arguments[1] : "";
    if (what == "forms") compare_forms(std::atoi(arguments[2]), count > 3 ? std::atof(arguments[3]) : 1.0);
    if (what == "steps") compare_steps(std::atoi(arguments[2]));
    return what == "forms" || what == "steps" ? 0 : 1;
}
