// Program for test_planar_contact.py: tables of contacts under a law that does not state its coefficients. Prints the
// largest difference between the table and the solver, for the pair of the table and for a lighter one.
#include "boxes/binary_contact/tabulated_contact.hpp"

#include <cstdio>

#include "contact/viscoelastic.hpp"

using namespace hardlimit;

struct Unstated : contact::Viscoelastic {
    void coefficients() const = delete;
};
static_assert(PowerLaw<contact::Viscoelastic> && !PowerLaw<Unstated>);

int main() {
    const Unstated law{{1e9, 1e-5}};
    for (const double mass : {1e-5, 5e-6}) {
        boxes::TabulatedContacts<Unstated> contacts(law, 1e-5, 2e-3, true);
        double worst = 0.0;
        for (int i = 1; i < 200; ++i) {
            const boxes::Approach a{mass, 2e-3, 1e-2 * i, 3e-3 * (i % 7), 0.0};
            const boxes::PlanarContact read = contacts(law, a), solved = boxes::solve_planar_contact(law, a);
            worst = math::max(worst, math::abs(read.duration / solved.duration - 1.0));
            worst = math::max(worst, math::abs(read.turn - solved.turn) / math::max(solved.turn, 1e-9));
        }
        std::printf("%g\n", worst);
    }
}
