// Program for test_threads.py: checks that computations obey their Stop: one point of a two-ball map, and
// the energy dissipated up to each node of a long run. Each line: the name of the case, and passed or failed.
#include <cstdio>

#include "contact/viscoelastic.hpp"
#include "sweep/solve_point.hpp"

namespace hl = hardlimit;
using hl::Stop;
using hl::contact::LinearDashpot;
using hl::contact::Viscoelastic;

namespace {

// A Stop that is true from its third check on.
struct Impatient {
    int asked = 0;
    Stop stop{[](void* self) { return ++static_cast<Impatient*>(self)->asked >= 3; }, this};
};

// Whether a point stops at the third check and checks no more, and has contacts if it is not stopped.
template <class Law>
bool gives_up_a_point(int alternative, hl::sweep::Parameters p) {
    const hl::sweep::Setting setting{hl::sweep::Model::newton, alternative, true, true, -1};
    Impatient impatient;
    Stop patient;
    hl::sweep::solve_point<Law>(setting, p, impatient.stop);
    return impatient.asked == 3 && hl::sweep::solve_point<Law>(setting, p, patient).n_contacts > 0;
}

bool gives_up_the_dissipated_energy() {
    using hl::column::LinearColumn;
    const LinearDashpot law{1e6, 1e-3};
    const LinearColumn c{2, true, 9.81, {1.0, 0.5}, {0.02, 0.02}, {law, law}, {0.1, 1e-4}, {0.0, 0.0}};
    const hl::column::Drop run = solve_drop(c, hl::column::Coupling::full, 10.0, true, nullptr);
    Impatient impatient;
    Stop patient;
    const std::size_t all = dissipated_energy(c, run, patient).size();
    return all == run.nodes.size() && dissipated_energy(c, run, impatient.stop).size() < all;
}

void print(const char* name, bool passed) { std::printf("%s %s\n", name, passed ? "passed" : "failed"); }

}  // namespace

int main() {
    // A light ball below a heavy one that falls slowly: the pair has many contacts.
    const hl::sweep::Parameters linear{0.001, 0.1, hl::math::nan, 1000.0, 1000.0,     1e-6,
                                       0.1,   0.0, 0.0,           9.81,   {1e6, 0.0}, {1e6, 0.0}};
    const hl::sweep::Parameters soft{0.1, 0.01, hl::math::nan, 1000.0, 1000.0,           1e-6,
                                     0.6, 0.0,  0.0,           9.81,   {1e9, 0.3, 1e-5}, {1e9, 0.3, 1e-5}};
    print("exact", gives_up_a_point<LinearDashpot>(1, linear));
    print("general", gives_up_a_point<Viscoelastic>(0, soft));
    print("dissipated", gives_up_the_dissipated_energy());
}
