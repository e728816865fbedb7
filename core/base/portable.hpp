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

// Before a loop with a constant number of iterations: unroll it, or do not (WebAssembly should stay small).
#if defined(__wasm__)
#define HL_UNROLL
#define HL_ROLL
#elif defined(__GNUC__) && !defined(__clang__) && !defined(__CUDACC__)
#define HL_UNROLL _Pragma("GCC unroll 64")
#define HL_ROLL _Pragma("GCC unroll 1")
#else
#define HL_UNROLL _Pragma("unroll")
#define HL_ROLL _Pragma("unroll 1")
#endif

// Not inlined: a loop that exceeds the instruction cache runs at half the speed. A GPU has small caches.
#if defined(__CUDACC__) || defined(__CUDACC_RTC__)
#define HL_FN_APART HL_FN __noinline__
#define HL_FN_APART_ON_GPU HL_FN __noinline__
#else
#define HL_FN_APART __attribute__((noinline)) inline
#define HL_FN_APART_ON_GPU HL_FN
#endif

// Always inlined, where the choice of the compiler would depend on what else the source file holds.
#if defined(__CUDACC__) || defined(__CUDACC_RTC__)
#define HL_FN_INLINE __host__ __device__ __forceinline__
#else
#define HL_FN_INLINE __attribute__((always_inline)) inline
#endif

#if defined(__linux__) && !defined(__CUDACC__) && !defined(__CUDACC_RTC__)
#include <sys/mman.h>
#endif

#if defined(__CUDACC_RTC__)  // lacks these two constants
#define __builtin_huge_val() __builtin_bit_cast(double, 0x7ff0000000000000ULL)
#define __builtin_nan(text) __builtin_bit_cast(double, 0x7ff8000000000000ULL)
#endif

namespace hardlimit {

using i64 = long long;
using u64 = unsigned long long;
static_assert(sizeof(i64) == 8 && sizeof(double) == 8);

#if !defined(__CUDACC__) && !defined(__CUDACC_RTC__)
// Prefetches a cache line into the second-level cache; the first-level cache has too few line-fill buffers for many
// prefetches at once. gcc treats a function that only prefetches as pure and drops its calls; the empty asm prevents
// it.
HL_FN_INLINE void prefetch(const void* p) {
    __builtin_prefetch(p, 0, 2);
    __asm__ volatile("" : : "r"(p));
}

// The same into the smallest cache, for a line that the next event reads.
HL_FN_INLINE void prefetch_near(const void* p) {
    __builtin_prefetch(p, 0, 3);
    __asm__ volatile("" : : "r"(p));
}

// In a spin loop: tells the processor to leave resources to its sibling hardware thread.
inline void relax() {
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#elif defined(__aarch64__)
    __asm__ volatile("yield");
#endif
}

// Asks for huge pages for a large array; a hint that may be ignored.
inline void advise_huge_pages(void* p, unsigned long bytes) {
#if defined(__linux__)
    (void)madvise(p, bytes, MADV_HUGEPAGE);
#else
    (void)p, (void)bytes;
#endif
}
#endif

template <class Real>
using Mask = decltype(Real{} < Real{});

// T as a non-deduced context: & and | of two bools give an int, which a parameter of this type converts back to bool.
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
    typedef i64 Integers __attribute__((vector_size(8 * W)));
};
template <class Real>
    requires(sizeof(Real) > sizeof(double))
struct Lanes<Real> {
    static constexpr int count = sizeof(Real) / sizeof(double);
    using Bits = typename Vector<count>::Bits;
};

// Two vectors processed together to hide latency. gcc passes a vector type of twice the width through memory.
template <class V>
struct Pair {
    V lo, hi;
};
template <class V>
struct Lanes<Pair<V>> {
    static constexpr int count = 2 * Lanes<V>::count;
    using Bits = Pair<typename Lanes<V>::Bits>;
};
#define HL_PAIRWISE(op)                                                  \
    template <class V>                                                   \
    HL_FN auto operator op(const Pair<V>& a, const Pair<V>& b) {         \
        return Pair<decltype(a.lo op b.lo)>{a.lo op b.lo, a.hi op b.hi}; \
    }                                                                    \
    template <class V, class Number>                                     \
        requires(sizeof(Number) <= sizeof(double))                       \
    HL_FN auto operator op(const Pair<V>& a, Number b) {                 \
        return Pair<decltype(a.lo op b)>{a.lo op b, a.hi op b};          \
    }                                                                    \
    template <class V, class Number>                                     \
        requires(sizeof(Number) <= sizeof(double))                       \
    HL_FN auto operator op(Number a, const Pair<V>& b) {                 \
        return Pair<decltype(a op b.lo)>{a op b.lo, a op b.hi};          \
    }
HL_PAIRWISE(+)
HL_PAIRWISE(-)
HL_PAIRWISE(*)
HL_PAIRWISE(/)
HL_PAIRWISE(<)
HL_PAIRWISE(>)
HL_PAIRWISE(<=)
HL_PAIRWISE(>=)
HL_PAIRWISE(==)
HL_PAIRWISE(!=)
HL_PAIRWISE(&)
HL_PAIRWISE(|)
HL_PAIRWISE(^)
HL_PAIRWISE(<<)
HL_PAIRWISE(>>)
#undef HL_PAIRWISE
template <class V>
HL_FN Pair<V> operator-(const Pair<V>& a) {
    return {-a.lo, -a.hi};
}
template <class V>
HL_FN Pair<V> operator~(const Pair<V>& a) {
    return {~a.lo, ~a.hi};
}
#endif

template <class T>
inline constexpr bool is_pair = false;
#if !defined(__CUDACC__) && !defined(__CUDACC_RTC__)
template <class V>
inline constexpr bool is_pair<Pair<V>> = true;
#endif

// One lane of a Real or of a Mask.
template <class T>
HL_FN auto lane_of(const T& x, int lane) {
    if constexpr (sizeof(T) <= sizeof(double)) {
        return x;
    } else if constexpr (is_pair<T>) {
        constexpr int half = sizeof(T) / 16;
        return lane < half ? lane_of(x.lo, lane) : lane_of(x.hi, lane - half);
    } else {
        return x[lane];
    }
}
template <class T, class Value>
HL_FN void set_lane(T& x, int lane, Value value) {
    if constexpr (sizeof(T) <= sizeof(double)) {
        x = value;
    } else if constexpr (is_pair<T>) {
        constexpr int half = sizeof(T) / 16;
        set_lane(lane < half ? x.lo : x.hi, lane % half, value);
    } else {
        x[lane] = value;
    }
}

// Lanes of two vectors side by side, by number: those of b follow those of a.
#if defined(__clang__)
#define HL_SHUFFLE(a, b, ...) __builtin_shufflevector(a, b, __VA_ARGS__)
#else
#define HL_SHUFFLE(a, b, ...) \
    __builtin_shuffle(a, b, typename Vector<static_cast<int>(sizeof(a) / 8)>::Integers{__VA_ARGS__})
#endif

// Transposes eight columns of one row per lane: a cache line of eight doubles for each lane.
template <class Real>
struct Columns {
    Real of[8];
};
#if !defined(__CUDACC__) && !defined(__CUDACC_RTC__)
template <class Real>
HL_FN Real load_lanes(const double* from) {
    Real r;
    __builtin_memcpy(&r, from, sizeof r);
    return r;
}
template <class Real>
HL_FN void store_lanes(double* to, const Real& r) {
    __builtin_memcpy(to, &r, sizeof r);
}
template <class Real>
HL_FN Columns<Real> load_columns(const double* const* row) {
    constexpr int lanes = Lanes<Real>::count;
    static_assert(lanes == 1 || lanes == 2 || lanes == 4 || lanes == 8);
    Columns<Real> c;
    if constexpr (lanes == 1) {
        for (int k = 0; k < 8; ++k) c.of[k] = row[0][k];
    } else if constexpr (lanes == 2) {
        HL_UNROLL
        for (int k = 0; k < 8; k += 2) {
            const Real a = load_lanes<Real>(row[0] + k), b = load_lanes<Real>(row[1] + k);
            c.of[k] = HL_SHUFFLE(a, b, 0, 2);
            c.of[k + 1] = HL_SHUFFLE(a, b, 1, 3);
        }
    } else if constexpr (lanes == 4) {
        HL_UNROLL
        for (int k = 0; k < 8; k += 4) {
            const Real r0 = load_lanes<Real>(row[0] + k), r1 = load_lanes<Real>(row[1] + k);
            const Real r2 = load_lanes<Real>(row[2] + k), r3 = load_lanes<Real>(row[3] + k);
            const Real even0 = HL_SHUFFLE(r0, r1, 0, 4, 2, 6), odd0 = HL_SHUFFLE(r0, r1, 1, 5, 3, 7);
            const Real even2 = HL_SHUFFLE(r2, r3, 0, 4, 2, 6), odd2 = HL_SHUFFLE(r2, r3, 1, 5, 3, 7);
            c.of[k] = HL_SHUFFLE(even0, even2, 0, 1, 4, 5);
            c.of[k + 1] = HL_SHUFFLE(odd0, odd2, 0, 1, 4, 5);
            c.of[k + 2] = HL_SHUFFLE(even0, even2, 2, 3, 6, 7);
            c.of[k + 3] = HL_SHUFFLE(odd0, odd2, 2, 3, 6, 7);
        }
    } else {
        Real even[4], odd[4];  // of rows 2p and 2p + 1
        HL_UNROLL
        for (int p = 0; p < 4; ++p) {
            const Real a = load_lanes<Real>(row[2 * p]), b = load_lanes<Real>(row[2 * p + 1]);
            even[p] = HL_SHUFFLE(a, b, 0, 8, 2, 10, 4, 12, 6, 14);
            odd[p] = HL_SHUFFLE(a, b, 1, 9, 3, 11, 5, 13, 7, 15);
        }
        const Real* const pairs[2] = {even, odd};
        HL_UNROLL
        for (int parity = 0; parity < 2; ++parity) {
            const Real* const r = pairs[parity];
            const Real low0 = HL_SHUFFLE(r[0], r[1], 0, 1, 8, 9, 4, 5, 12, 13);
            const Real low4 = HL_SHUFFLE(r[2], r[3], 0, 1, 8, 9, 4, 5, 12, 13);
            const Real high0 = HL_SHUFFLE(r[0], r[1], 2, 3, 10, 11, 6, 7, 14, 15);
            const Real high4 = HL_SHUFFLE(r[2], r[3], 2, 3, 10, 11, 6, 7, 14, 15);
            c.of[parity] = HL_SHUFFLE(low0, low4, 0, 1, 2, 3, 8, 9, 10, 11);
            c.of[parity + 4] = HL_SHUFFLE(low0, low4, 4, 5, 6, 7, 12, 13, 14, 15);
            c.of[parity + 2] = HL_SHUFFLE(high0, high4, 0, 1, 2, 3, 8, 9, 10, 11);
            c.of[parity + 6] = HL_SHUFFLE(high0, high4, 4, 5, 6, 7, 12, 13, 14, 15);
        }
    }
    return c;
}
#endif

#if defined(__AVX512F__) && !defined(__CUDACC__) && !defined(__CUDACC_RTC__)
// Sixteen 32-bit words that are filtered at once.
inline constexpr bool sifts_words = true;
struct Words {
    typedef int Sixteen __attribute__((vector_size(64)));
    Sixteen of;

    Words() : of{} {}
    explicit Words(const void* from) { __builtin_memcpy(&of, from, sizeof of); }
    explicit Words(Sixteen words) : of(words) {}
    Words operator|(const Words& other) const { return Words(of | other.of); }
    // Bits of those that are not, or are more than, a number (without sign).
    unsigned unlike(unsigned x) const { return __builtin_ia32_ucmpd512_mask(of, all(x), 4, 0xffff); }
    unsigned above(unsigned x) const { return __builtin_ia32_ucmpd512_mask(of, all(x), 6, 0xffff); }
    // Packs the words whose bits are set; writes all sixteen.
    void store(unsigned* to, unsigned chosen) const {
        const Sixteen left =
            __builtin_ia32_compresssi512_mask(of, Sixteen{}, static_cast<unsigned short>(chosen));
        __builtin_memcpy(to, &left, sizeof left);
    }

private:
    static Sixteen all(unsigned x) { return Sixteen{} + static_cast<int>(x); }
};
#else
inline constexpr bool sifts_words = false;
struct Words;
#endif

#if defined(__AVX2__) && !defined(__AVX512F__) && !defined(__CUDACC__) && !defined(__CUDACC_RTC__)
// Four lanes, or four 32-bit words, of which those whose bits are set are moved to the front. The others are undefined.
inline constexpr bool packs_lanes = true;
struct PackedLanes {
    typedef int Four __attribute__((vector_size(16)));
    typedef int Eight __attribute__((vector_size(32)));
    typedef float Words __attribute__((vector_size(16)));
    Eight halves;  // of the lanes: sources of the 32-bit words
    Four words;

    explicit PackedLanes(unsigned chosen) {
        __builtin_memcpy(&halves, table.halves[chosen], sizeof halves);
        __builtin_memcpy(&words, table.words[chosen], sizeof words);
    }
    Vector<4>::Real operator()(Vector<4>::Real x) const {
        return __builtin_bit_cast(Vector<4>::Real,
                                  __builtin_ia32_permvarsi256(__builtin_bit_cast(Eight, x), halves));
    }
    void move(unsigned* to, const unsigned* from) const {
        Words w;
        __builtin_memcpy(&w, from, sizeof w);
        w = __builtin_ia32_vpermilvarps(w, words);
        __builtin_memcpy(to, &w, sizeof w);
    }

private:
    struct Table {
        int halves[16][8], words[16][4];
        constexpr Table() : halves{}, words{} {
            for (int chosen = 0; chosen < 16; ++chosen)
                for (int lane = 0, to = 0; lane < 4; ++lane) {
                    if (!(chosen >> lane & 1)) continue;
                    words[chosen][to] = lane;
                    halves[chosen][2 * to] = 2 * lane, halves[chosen][2 * to + 1] = 2 * lane + 1;
                    ++to;
                }
        }
    };
    static const Table table;
};
inline constexpr PackedLanes::Table PackedLanes::table{};
#else
inline constexpr bool packs_lanes = false;
struct PackedLanes;
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
    if constexpr (is_pair<Real>)
        return {select<decltype(yes.lo)>(m.lo, yes.lo, no.lo), select<decltype(yes.lo)>(m.hi, yes.hi, no.hi)};
    else
        return m ? yes : no;
}

// b < a ? b : a and a < b ? b : a, lane by lane: exactly the x86 instructions, which gcc does not find by itself.
template <class Real>
HL_FN Real min_of(Real a, Real b) {
#if defined(__AVX512F__) && !defined(__clang__)
    if constexpr (Lanes<Real>::count == 8 && !is_pair<Real>)
        return __builtin_ia32_minpd512_mask(b, a, Real{}, 0xff, 4);
    else
#endif
        if constexpr (is_pair<Real>)
        return {min_of(a.lo, b.lo), min_of(a.hi, b.hi)};
    else
        return select<Real>(b < a, b, a);
}
template <class Real>
HL_FN Real max_of(Real a, Real b) {
#if defined(__AVX512F__) && !defined(__clang__)
    if constexpr (Lanes<Real>::count == 8 && !is_pair<Real>)
        return __builtin_ia32_maxpd512_mask(b, a, Real{}, 0xff, 4);
    else
#endif
        if constexpr (is_pair<Real>)
        return {max_of(a.lo, b.lo), max_of(a.hi, b.hi)};
    else
        return select<Real>(a < b, b, a);
}

// The lanes of a Mask as bits of an integer. x86 has an instruction for it; a loop would be a chain of shuffles.
template <class M>
HL_FN unsigned lane_bits(const M& m) {
    constexpr int count = static_cast<int>(sizeof(M) / 8);
    if constexpr (sizeof(M) == sizeof(bool)) {
        return m;
    } else if constexpr (is_pair<M>) {
        return lane_bits(m.lo) | lane_bits(m.hi) << (count / 2);
#if defined(__AVX512DQ__)
    } else if constexpr (count == 8) {
        return static_cast<unsigned char>(
            __builtin_ia32_cvtq2mask512(__builtin_bit_cast(Vector<8>::Integers, m)));
#endif
#if defined(__AVX__)
    } else if constexpr (count == 4) {
        return static_cast<unsigned>(__builtin_ia32_movmskpd256(__builtin_bit_cast(Vector<4>::Real, m)));
#endif
#if defined(__SSE2__)
    } else if constexpr (count == 2) {
        return static_cast<unsigned>(__builtin_ia32_movmskpd(__builtin_bit_cast(Vector<2>::Real, m)));
#endif
    } else {
        unsigned bits = 0;
        for (int i = 0; i < count; ++i) bits |= static_cast<unsigned>(m[i] & 1) << i;
        return bits;
    }
}
HL_FN int bit_count(unsigned bits) {
#if defined(__CUDA_ARCH__)
    return __popc(bits);
#else
    return __builtin_popcount(bits);
#endif
}
HL_FN int first_bit(unsigned bits) { return bit_count((bits & -bits) - 1); }
#if !defined(__CUDACC__) && !defined(__CUDACC_RTC__)
HL_FN int first_bit(u64 bits) { return __builtin_ctzll(bits); }
#endif
template <class M>
HL_FN bool any(const M& m) {
    if constexpr (is_pair<M>)
        return any(m.lo | m.hi);
    else
        return lane_bits(m) != 0;
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
    } else if constexpr (is_pair<Real>) {
        return {sqrt_of(x.lo), sqrt_of(x.hi)};
    } else {
        Real r{};
        for (int i = 0; i < Lanes<Real>::count; ++i) r[i] = __builtin_sqrt(x[i]);
        return r;
    }
#endif
}

}  // namespace hardlimit
