// Program for test_comparison.py: compares a column of six balls whose upper balls collide very often in the
// event-driven model. Prints the number of collisions that the comparison computes, its answer, and the largest
// difference of the energies of all balls from that of the column, relative to the latter.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "column/comparison.hpp"
#include "contact/viscoelastic.hpp"

namespace {

namespace hl = hardlimit;
namespace col = hardlimit::column;

// The law, which counts its collisions.
struct Counted : hl::contact::Viscoelastic {
    static inline long collisions = 0;

    explicit Counted(const hl::contact::Viscoelastic& law) : Viscoelastic(law) {}
    double restitution(double speed, double mass) const {
        ++collisions;
        return Viscoelastic::restitution(speed, mass);
    }
};

std::shared_ptr<const col::Column<Counted>> six_balls() {
    const double youngs_modulus = 1.76e8, poisson_ratio = 0.3, dissipative_time = 4.62e-4;
    const double mass[] = {0.0069, 4.1688, 0.0012, 0.0164, 9.9107, 0.0112};
    const double radius[] = {0.0706, 0.0403, 0.064, 0.0427, 0.0231, 0.0576};
    const double gap[] = {0.0279, 1.276e-6, 6.127e-5, 3.072e-5, 8.096e-5, 3.24e-6};
    col::Column<Counted> c{6, true, 9.81, {}, {}, {}, {}, {}};
    for (int i = 0; i < 6; ++i) {
        const double m = i == 0 ? mass[0] : hl::effective(mass[i - 1], mass[i]);
        const double r = i == 0 ? radius[0] : hl::effective(radius[i - 1], radius[i]);
        const double given[] = {youngs_modulus, poisson_ratio, dissipative_time};
        c.mass.push_back(mass[i]);
        c.radius.push_back(radius[i]);
        c.gaps.push_back(gap[i]);
        c.velocity.push_back(0.0);
        c.contacts.push_back(Counted(hl::contact::Viscoelastic::from_parameters(0, given, {m, r})));
    }
    return std::make_shared<const col::Column<Counted>>(std::move(c));
}

// Of Newton's equations, at all times at which a contact begins or ends.
double energy_difference(const col::Solution& newton) {
    const std::vector<double> times = newton.knots();
    col::States states(times.size(), 6);
    newton.sample(times.data(), states);
    double largest = 0.0;
    for (std::size_t i = 0; i < times.size(); ++i) {
        const double total = states.total[i].kinetic + states.total[i].potential;
        double sum = -total;
        for (std::size_t j = 0; j < 6; ++j) sum += states.energy[6 * i + j];
        largest = std::max(largest, std::abs(sum / total));
    }
    return largest;
}

}  // namespace

int main() {
    const auto column = six_balls();
    const col::SolveOptions options;
    const auto newton = col::solve_column(column, col::Model::newton, options);
    const auto independent = col::solve_column(column, col::Model::independent, options);
    Counted::collisions = 0;
    const col::Comparison found = col::compare_models(column, options, *newton, *independent, 0.01);
    std::printf("%ld %s %g\n", Counted::collisions, col::answer_names[static_cast<int>(found.answer)],
                energy_difference(*newton));
}
