// Bindings of the checks of a box of grains.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <string>
#include <tuple>

#include "arrays.hpp"
#include "boxes/neighbours/overlap.hpp"

namespace nb = nanobind;
using namespace nb::literals;
namespace hl = hardlimit;
namespace pt = hardlimit::boxes;
using hl::bindings::In;
using hl::bindings::unlocked;
using Rows = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

namespace {

pt::Enclosure enclosure(std::size_t dimension, In box, const std::vector<bool>& periodic) {
    if (dimension < 2 || dimension > 3) throw nb::value_error("positions: must have two or three columns");
    if (box.shape(0) != dimension || periodic.size() != dimension)
        throw nb::value_error("box: must have one edge, and one periodicity, for each column of positions");
    pt::Enclosure made{static_cast<int>(dimension), {1.0, 1.0, 1.0}, {false, false, false}};
    for (std::size_t axis = 0; axis < dimension; ++axis) {
        made.edge[axis] = box.data()[axis];
        if (!(made.edge[axis] > 0.0)) throw nb::value_error("box: every edge must be > 0");
        made.periodic[axis] = periodic[axis];
    }
    return made;
}

auto deepest_overlap(Rows positions, In radius, In box, const std::vector<bool>& periodic) {
    const pt::Enclosure bounds = enclosure(positions.shape(1), box, periodic);
    if (radius.shape(0) != positions.shape(0))
        throw nb::value_error("radius: must have one value for each row of positions");
    for (std::size_t i = 0; i < radius.shape(0); ++i)
        if (!(radius.data()[i] > 0.0)) throw nb::value_error("radius: every value must be > 0");
    const pt::Overlap found = unlocked([&](hl::Stop& stop) {
        return pt::deepest_overlap(bounds, positions.data(), radius.data(), positions.shape(0), stop);
    });
    return std::tuple(found.first, found.second, found.gap);
}

}  // namespace

void bind_particle_checks(nb::module_& m) {
    m.def(
        "deepest_overlap", &deepest_overlap, "positions"_a, "radius"_a, "box"_a, "periodic"_a,
        "Two bodies and their gap [m], the deepest relative to the sum of the radii; −1, −1 and 0 where none overlap.");
}
