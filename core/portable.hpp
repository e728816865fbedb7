// The only file that names a compiler, a device or a platform.
//
// Numerical code is written once for a Real that is either a double or a vector of W doubles (lanes). Comparisons
// of Reals give a Mask: bool, or a vector of W integers that are 0 or −1. A lane never depends on its neighbours, so
// a vector returns in each lane the bits a double would.
#pragma once

#if defined(__CUDACC__) || defined(__CUDACC_RTC__)
#define HL_FN __host__ __device__ inline
#else
#define HL_FN inline
#endif

#if defined(__clang__) && !defined(__CUDACC__)
// Masks are combined with & and |, which for a single double are bools.
#pragma clang diagnostic ignored "-Wbitwise-instead-of-logical"
#endif

// Before a loop with a constant number of turns: unroll it.
#if defined(__GNUC__) && !defined(__clang__) && !defined(__CUDACC__)
#define HL_UNROLL _Pragma("GCC unroll 64")
#else
#define HL_UNROLL _Pragma("unroll")
#endif

#if defined(__CUDACC_RTC__)  // lacks these two constants
#define __builtin_huge_val() __builtin_bit_cast(double, 0x7ff0000000000000ULL)
#define __builtin_nan(text) __builtin_bit_cast(double, 0x7ff8000000000000ULL)
#endif

namespace hardlimit {

using i64 = long long;
using u64 = unsigned long long;
static_assert(sizeof(i64) == 8 && sizeof(double) == 8);

template <class Real>
using Mask = decltype(Real{} < Real{});

// T, without a part in the deduction of T: & and | of two bools give an int, which becomes a bool again.
template <class T>
struct Unchanged {
    using Type = T;
};
template <class T>
using Same = typename Unchanged<T>::Type;

template <class Real>
struct Lanes {
    using Bits = u64;
    static constexpr int count = 1;
};

#if !defined(__CUDACC__) && !defined(__CUDACC_RTC__)
// gcc and clang split a vector that is wider than the registers of the target.
template <int W>
struct Vector {
    typedef double Real __attribute__((vector_size(8 * W)));
    typedef u64 Bits __attribute__((vector_size(8 * W)));
};
template <class Real>
    requires(sizeof(Real) > sizeof(double))
struct Lanes<Real> {
    static constexpr int count = sizeof(Real) / sizeof(double);
    using Bits = typename Vector<count>::Bits;
};
#endif

// All lanes the same.
template <class Real>
HL_FN Real broadcast(double x) {
    if constexpr (Lanes<Real>::count == 1)
        return x;
    else
        return Real{} + x;
}

// Lane by lane. Real may itself be a Mask.
template <class Real>
HL_FN Real select(Mask<Real> m, Real yes, Real no) {
    return m ? yes : no;
}

template <class M>
HL_FN bool any(M m) {
    if constexpr (sizeof(M) == sizeof(bool)) {
        return m;
    } else {
        i64 found = 0;
        for (int i = 0; i < static_cast<int>(sizeof(M) / 8); ++i) found |= m[i];
        return found != 0;
    }
}
HL_FN bool any(int m) { return m != 0; }
HL_FN bool negation(int m) { return m == 0; }
template <class M>
HL_FN M negation(M m) {
    if constexpr (sizeof(M) == sizeof(bool))
        return !m;
    else
        return ~m;
}

// The eight bytes of a double as an integer and back. A library call on the host would drag std headers into
// NVRTC; the builtin is known to gcc, clang (wasm too) and nvcc.
template <class Real>
HL_FN typename Lanes<Real>::Bits bits_of(Real x) {
#if defined(__CUDA_ARCH__)
    return static_cast<u64>(__double_as_longlong(x));
#else
    return __builtin_bit_cast(typename Lanes<Real>::Bits, x);
#endif
}
template <class Real>
HL_FN Real real_of(typename Lanes<Real>::Bits b) {
#if defined(__CUDA_ARCH__)
    return __longlong_as_double(static_cast<i64>(b));
#else
    return __builtin_bit_cast(Real, b);
#endif
}

// Correctly rounded on every platform, so it cannot differ between them.
template <class Real>
HL_FN Real sqrt_of(Real x) {
#if defined(__CUDA_ARCH__)
    return __dsqrt_rn(x);
#else
    if constexpr (Lanes<Real>::count == 1) {
        return __builtin_sqrt(x);
    } else {
        Real r{};
        for (int i = 0; i < Lanes<Real>::count; ++i) r[i] = __builtin_sqrt(x[i]);
        return r;
    }
#endif
}

}  // namespace hardlimit
