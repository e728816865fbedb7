// Fuzz target: the exact solver for two balls under the linear law, alone and against the general solver.
#include "agreement.hpp"
#include "check.hpp"

namespace {

using namespace hardlimit;
using fuzz::LinearColumn;
using fuzz::require;

constexpr long most = 300;  // checks of Stop, one for each 64 pieces

column::Drop solve(const LinearColumn& c, column::Coupling coupling, double until) {
    long left = most;
    Stop stop([](void* n) { return --*static_cast<long*>(n) < 0; }, &left);
    return column::solve_drop(c, coupling, until, true, &stop);
}

void check_numbers(const column::Drop& d) {
    const column::Sequence& q = d.sequence;
    if (q.outcome != Outcome::ok) return;
    require(q.n_contacts > 0 && math::is_finite(q.t_end), "an outcome of ok has contacts, and an end");
    require(math::is_finite(q.relative_velocity), "and a relative velocity");
    require(!(q.separation_velocity < 0.0), "what separates does not close");
    double before = -math::infinity;
    for (const column::Contact& k : d.contacts) {
        require(k.begin >= before && !(k.end < k.begin), "contacts in the order of time");
        before = k.begin;
    }
}

// Checks that the mechanical energy never increases from node to node.
void check_energies(const LinearColumn& c, const column::Drop& d) {
    double before = math::infinity, scale = 0.0;
    for (const column::Node& n : d.nodes) {
        const auto e = column::drop::mechanical_energy(c, d.start.units, n.x);
        require(math::is_finite(e.sum()), "finite energies");
        scale = math::max(scale, e.kinetic + math::abs(e.potential) + e.stored);
        require(e.sum() <= before + 1e-10 * scale, "energy never rises");
        before = e.sum();
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::Draw<fuzz::Bytes> draw{fuzz::Bytes(data, size)};
    LinearColumn c = fuzz::draw_column<contact::LinearDashpot>(draw, 2, true);
    const double until = draw.often({math::nan}, [&] { return draw.decades(1e-9, 1e3); });
    const column::Drop d = solve(c, column::Coupling::full, until);
    check_numbers(d);
    check_energies(c, d);
    check_numbers(solve(c, column::Coupling::adiabatic, until));
    fuzz::limit_damping(c, 20.0);
    require(fuzz::compare(c, 500, fuzz::Random(1)).verdict != fuzz::Verdict::unexplained,
            "the general solver agrees, or the difference is explained");
    return 0;
}
