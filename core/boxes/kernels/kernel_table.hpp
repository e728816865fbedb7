// Table of all SIMD kernels of boxes for one instruction set.
#pragma once
#include "open_contacts.hpp"
#include "polynomial_cell.hpp"
#include "power_series.hpp"
#include "touch_kernel.hpp"
#include "velocity_sums.hpp"

namespace hardlimit::boxes {

template <class Real, int d, Motion motion, bool enlarged = false>
constexpr hardlimit_abi::TouchKernels::Of touch_kernels_of() {
    return {&touch_listed<Real, d, motion, Image::shifted, enlarged>,
            &touch_near<Real, d, motion, Image::as_it_is, enlarged>,
            &touch_near<Real, d, motion, Image::nearest, enlarged>};
}

template <class Real>
constexpr hardlimit_abi::SampleKernels sample_kernels() {
    return {&open_contacts::solve<Real>, &sum_velocities<Lanes<Real>::count>};
}

// `newton`: includes the kernels that only Newton's equations need.
template <class Real, bool newton = true>
constexpr hardlimit_abi::TouchKernels touch_kernels(const char* name) {
    return {name,
            {{touch_kernels_of<Real, 2, Motion::straight>(), touch_kernels_of<Real, 2, Motion::falling>(),
              touch_kernels_of<Real, 2, Motion::growing>()},
             {touch_kernels_of<Real, 3, Motion::straight>(), touch_kernels_of<Real, 3, Motion::falling>(),
              touch_kernels_of<Real, 3, Motion::growing>()}},
            {touch_kernels_of<Real, 3, Motion::straight, true>(),
             touch_kernels_of<Real, 3, Motion::falling, true>()},
            newton ? series::kernels() : hardlimit_abi::SeriesKernels{},
            newton ? &read_wide_cell : nullptr,
            newton ? sample_kernels<Real>() : hardlimit_abi::SampleKernels{}};
}

}  // namespace hardlimit::boxes
