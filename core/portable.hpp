// The only file that names a compiler, a device or a platform.
#pragma once

#if defined(__CUDACC__) || defined(__CUDACC_RTC__)
#define HL_FN __host__ __device__ inline
#else
#define HL_FN inline
#endif

namespace hardlimit {

using i64 = long long;
using u64 = unsigned long long;
static_assert(sizeof(i64) == 8 && sizeof(double) == 8);

// The eight bytes of a double as an integer and back. A library call on the host would drag std headers into
// NVRTC; the builtin is known to gcc, clang (wasm too) and nvcc.
HL_FN u64 bits_of(double x) {
#if defined(__CUDA_ARCH__)
    return static_cast<u64>(__double_as_longlong(x));
#else
    return __builtin_bit_cast(u64, x);
#endif
}
HL_FN double double_of(u64 b) {
#if defined(__CUDA_ARCH__)
    return __longlong_as_double(static_cast<i64>(b));
#else
    return __builtin_bit_cast(double, b);
#endif
}

// Correctly rounded on every platform, so it cannot differ between them.
HL_FN double sqrt_of(double x) {
#if defined(__CUDA_ARCH__)
    return __dsqrt_rn(x);
#else
    return __builtin_sqrt(x);
#endif
}

}  // namespace hardlimit
