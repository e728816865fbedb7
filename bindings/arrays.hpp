// Conversion of arrays between Python and the core.
#pragma once
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <initializer_list>
#include <utility>
#include <vector>

#include "interpreter.hpp"

namespace hardlimit::bindings {

// Argument from Python: any sequence of numbers that NumPy converts without loss, as one contiguous array.
using In = nanobind::ndarray<const double, nanobind::ndim<1>, nanobind::c_contig, nanobind::device::cpu>;

// Returns an array to Python, which takes ownership.
template <class T>
auto make_array(std::vector<T>&& values, std::initializer_list<std::size_t> shape) {
    auto* owned = new std::vector<T>(std::move(values));
    nanobind::capsule owner(owned, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
    return nanobind::ndarray<nanobind::numpy, T>(owned->data(), shape, owner);
}

// Applies f to each value.
template <class F>
auto map(In x, F&& f) {
    const double* data = x.data();
    std::vector<double> y = unlocked([&](Stop& stop) {
        std::vector<double> values(x.shape(0));
        for (std::size_t i = 0; i < values.size() && !stop(); ++i) values[i] = f(data[i]);
        return values;
    });
    const std::size_t n = y.size();
    return make_array(std::move(y), {n});
}

}  // namespace hardlimit::bindings
