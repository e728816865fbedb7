// What a contact of the soft rule costs: read from polynomials as an event-driven run does, and solved; for thermal
// speeds at which an elastic impact is `depth` of the distance deep. Processor time of one core.
//   g++ -std=c++20 -O3 -ffp-contract=off -fno-math-errno -fno-trapping-math -Icore benchmarks/soft_contacts.cpp
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <random>
#include <vector>

#include "boxes/binary_contact/equivalent_collision.hpp"
#include "boxes/binary_contact/tabulated_contact.hpp"
#include "contact/registry.hpp"

namespace {

using namespace hardlimit;
using namespace hardlimit::boxes;

double seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

template <class Law>
struct Case {
    std::vector<Law> law;
    std::vector<Approach> approach;
};

// Pairs of bodies of radii from 1 to `spread`; `make` gives the law of a pair.
template <class Law, class Make>
Case<Law> thermal(const Make& make, double depth, double spread, int count) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> uniform;
    const auto rayleigh = [&] { return std::sqrt(-2.0 * std::log(1.0 - uniform(random))); };
    const double energy = make(PairGeometry{0.5, 0.5}).energy(onset_root<Law::onset_power>(2.0 * depth));
    const double scale = 2.0 * std::sqrt(energy);
    Case<Law> c;
    for (int i = 0; i < count; ++i) {
        const double r = 1.0 + (spread - 1.0) * uniform(random), q = 1.0 + (spread - 1.0) * uniform(random);
        const double mass = effective(r * r * r, q * q * q);
        c.law.push_back(make(PairGeometry{mass, effective(r, q)}));
        c.approach.push_back({mass, r + q, scale * rayleigh(), scale * rayleigh()});
    }
    return c;
}

template <class Law, class Make>
void report(const char* name, const Make& make, double depth, double spread = 1.0, bool varies = false) {
    const int count = 100'000, solved = 2'000;
    const Case<Law> c = thermal<Law>(make, depth, spread, count);
    SoftContacts<Law> contacts(make(PairGeometry{0.5, 0.5}), 0.5, 2.0, varies);
    double used = 0.0;
    const auto read_all = [&] {
        const double begin = seconds();
        for (int i = 0; i < count; ++i) {
            const auto n = static_cast<std::size_t>(i);
            used += draw_back(c.approach[n], contacts(c.law[n], c.approach[n])).normal_shift;
        }
        return seconds() - begin;
    };
    const double first = read_all(), again = read_all(), begin = seconds();
    std::vector<PlanarContact> ends;
    for (std::size_t i = 0; i < solved; ++i) ends.push_back(solve_planar_contact(c.law[i], c.approach[i]));
    const double solving = seconds() - begin;
    double worst = 0.0;
    for (std::size_t i = 0; i < solved; ++i) {
        const PlanarContact read = contacts(c.law[i], c.approach[i]), &end = ends[i];
        if (end.outcome != Outcome::ok) continue;
        const double lost = std::abs(read.speed_loss - end.speed_loss) / c.approach[i].normal_speed;
        worst = std::max({worst, lost, std::abs(read.duration / end.duration - 1.0),
                          std::abs(read.turn / end.turn - 1.0)});
    }
    std::printf("%-34s depth %-5g: read %4.0f ns, solved %5.1f us, fits %4.0f ms, worst error %.0e%s\n", name,
                depth, again / count * 1e9, solving / solved * 1e6, (first - again) * 1e3, worst,
                used == 0.0 ? "!" : "");
}

}  // namespace

int main() {
    using contact::LinearDashpot, contact::Tsuji, contact::Viscoelastic;
    const auto linear = [](PairGeometry pair) {
        const double given[] = {5000.0, 0.9};
        return LinearDashpot::from_parameters(0, given, pair);
    };
    const auto tsuji = [](PairGeometry pair) {
        const double given[] = {5000.0, 0.9};
        return Tsuji::from_parameters(0, given, pair);
    };
    const auto viscoelastic = [](PairGeometry pair) {
        const double given[] = {5000.0, 0.3, 3e-3};
        return Viscoelastic::from_parameters(0, given, pair);
    };
    for (const double depth : {1e-4, 0.01, 0.05}) {
        report<LinearDashpot>("linear", linear, depth);
        report<Viscoelastic>("viscoelastic", viscoelastic, depth);
        report<Tsuji>("tsuji", tsuji, depth);
        report<LinearDashpot>("linear, radii 1 to 3", linear, depth, 3.0);
        report<Viscoelastic>("viscoelastic, radii 1 to 3", viscoelastic, depth, 3.0, true);
    }
}
