// Conversion of arrays, records and messages between Python and the core.
#pragma once
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>

#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include "interpreter.hpp"

namespace hardlimit::bindings {

// Argument from Python: any sequence of numbers that NumPy converts without loss, as one contiguous array.
using In = nanobind::ndarray<const double, nanobind::ndim<1>, nanobind::c_contig, nanobind::device::cpu>;

inline nanobind::builtin_exception value_error(const std::string& message) {
    return nanobind::value_error(message.c_str());
}
inline void require(bool met, const std::string& message) {
    if (!met) throw value_error(message);
}
// Refuses a wrong number of values. what: the reason for the number wanted.
inline void require_values(const char* name, std::size_t got, std::size_t wanted, const char* what) {
    require(got == wanted, std::string(name) + ": got " + std::to_string(got) + " values, must be " +
                               std::to_string(wanted) + ", " + what);
}
inline std::string shown(double x) {
    char text[32];
    PyOS_snprintf(text, sizeof text, "%.16g", x);
    return text;
}

// The dict of names and values that alternate in the arguments.
template <class... Pairs>
nanobind::dict dict_of(const Pairs&... pairs) {
    nanobind::dict d;
    const auto put = [&](auto self, const char* name, const auto& value, const auto&... rest) -> void {
        d[name] = value;
        if constexpr (sizeof...(rest) > 0) self(self, rest...);
    };
    put(put, pairs...);
    return d;
}
// The list of convert(record) for n records.
template <class Record, class Convert>
nanobind::list list_of(const Record* records, std::size_t n, const Convert& convert) {
    nanobind::list all;
    for (std::size_t i = 0; i < n; ++i) all.append(convert(records[i]));
    return all;
}
template <class Record, std::size_t n, class Convert>
nanobind::list list_of(const Record (&records)[n], const Convert& convert) {
    return list_of(records, n, convert);
}

// Returns an array to Python, which takes ownership.
template <class T>
auto make_array(std::vector<T>&& values, std::initializer_list<std::size_t> shape) {
    auto* owned = new std::vector<T>(std::move(values));
    nanobind::capsule owner(owned, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
    return nanobind::ndarray<nanobind::numpy, T>(owned->data(), shape, owner);
}
// The array of value(record) for each record.
template <class Record, class Value>
auto column_of(const std::vector<Record>& records, const Value& value) {
    std::vector<decltype(value(records[0]))> values;
    values.reserve(records.size());
    for (const Record& r : records) values.push_back(value(r));
    return make_array(std::move(values), {records.size()});
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
