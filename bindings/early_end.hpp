// What the engines of boxes tell of a run that ended before it was to.
#pragma once
#include <nanobind/stl/optional.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <optional>
#include <tuple>
#include <vector>

#include "base/portable.hpp"

namespace hardlimit::bindings {

using EarlyEnd = std::optional<std::tuple<double, std::vector<i64>, std::optional<i64>>>;

inline constexpr const char* early_end_text =
    "Time [s], particles and wall where the run ended before it was to; None of others.";

}  // namespace hardlimit::bindings
