// Program for test_contact.py: checks that the laws declared `linear` are linear. A force k ξ + γ ξ̇ is the sum of its
// values at ξ̇ = 0 and at ξ = 0, which are proportional to ξ and ξ̇. Prints the name of each declared law and its
// largest deviation; the last law is not linear.
#include <cmath>
#include <cstdio>
#include <random>

#include "contact/registry.hpp"

namespace {

using namespace hardlimit;

// Declared linear, but quadratic in the compression.
struct Quadratic : contact::LinearDashpot {
    template <class T>
    T force(T s, T rate) const {
        return stiffness * s * s + damping * rate;
    }
};

std::mt19937 engine(1);
double some() { return std::pow(10.0, std::uniform_real_distribution<double>(-6.0, 3.0)(engine)); }

template <class Law>
double departure() {
    double worst = 0.0;
    for (int i = 0; i < 1000; ++i) {
        double p[max_parameters];
        for (double& x : p) x = std::uniform_real_distribution<double>(0.1, 0.9)(engine);
        const Law law{Law::from_parameters(i % Law::record.n_alternatives, p, {some(), some()})};
        const double s = some(), rate = (i % 2 ? -1.0 : 1.0) * some(), by = some();
        const double spring = law.force(s, 0.0), damper = law.force(0.0, rate);
        const double size = std::fabs(spring) + std::fabs(damper);
        for (const double off :
             {law.force(s, rate) - (spring + damper), law.elastic_force(s) - spring,
              law.force(by * s, 0.0) / by - spring, law.force(0.0, by * rate) / by - damper,
              law.force(s, 0.0) - s * law.elastic_force(1.0)})
            worst = std::fmax(worst, std::fabs(off) / size);
    }
    return worst;
}

template <class Law>
void look(const char* name) {
    if constexpr (LinearLaw<Law>) {
        static_assert(Law::onset_power == 1, "a linear force is a polynomial in the compression");
        std::printf("%s %g\n", name, departure<Law>());
    }
}

}  // namespace

int main() {
#define HL_LAW(Law) look<contact::Law>(contact::Law::record.name);
    HARDLIMIT_LAWS(HL_LAW)
#undef HL_LAW
    struct Liar : Quadratic {
        static Liar from_parameters(int alternative, const double* p, PairGeometry pair) {
            return {{contact::LinearDashpot::from_parameters(alternative, p, pair)}};
        }
    };
    look<Liar>("liar");
}
