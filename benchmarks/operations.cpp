// Operations per point of a map on a GPU: core/sweep/kernel.cu in the emulated block of emulated_gpu.hpp, with doubles
// that count all operations except those of the set-up. Used by gpu.py.
#include <memory>
#include <type_traits>

#include "emulated_gpu.hpp"

namespace counting {

enum Kind { simple, division, root, kinds };  // simple: + − × and comparisons
inline long done[emulated::Block::size][kinds];

struct Counted {
    double x;
    constexpr Counted() = default;
    template <class T>
        requires std::is_arithmetic_v<T>
    constexpr Counted(T value) : x(value) {}
    constexpr operator double() const { return x; }
};

constexpr void count(Kind kind) {
    if (!std::is_constant_evaluated()) ++done[emulated::block.at][kind];
}

// Mixed operands have their own operators; otherwise a conversion to double would be ambiguous.
#define BOTH_WAYS(Result, op, kind)                      \
    constexpr Result operator op(Counted a, Counted b) { \
        count(kind);                                     \
        return a.x op b.x;                               \
    }                                                    \
    template <class T>                                   \
        requires std::is_arithmetic_v<T>                 \
    constexpr Result operator op(Counted a, T b) {       \
        return a op Counted(b);                          \
    }                                                    \
    template <class T>                                   \
        requires std::is_arithmetic_v<T>                 \
    constexpr Result operator op(T a, Counted b) {       \
        return Counted(a) op b;                          \
    }
BOTH_WAYS(Counted, +, simple)
BOTH_WAYS(Counted, -, simple)
BOTH_WAYS(Counted, *, simple)
BOTH_WAYS(Counted, /, division)
BOTH_WAYS(bool, <, simple)
BOTH_WAYS(bool, >, simple)
BOTH_WAYS(bool, <=, simple)
BOTH_WAYS(bool, >=, simple)
BOTH_WAYS(bool, ==, simple)
BOTH_WAYS(bool, !=, simple)
#undef BOTH_WAYS
constexpr Counted operator-(Counted a) { return -a.x; }
inline double square_root(double a) { return __builtin_sqrt(a); }
inline Counted square_root(Counted a) {
    count(root);
    return __builtin_sqrt(a.x);
}

// Per round: operations of all threads, and for each warp 32 times those of its busiest thread.
inline long useful[kinds], issued[kinds];
inline void end_of_round() {
    for (int first = 0; first < emulated::Block::size; first += emulated::warp) {
        int most = first;
        for (int i = first; i < first + emulated::warp; ++i)
            if (done[i][simple] > done[most][simple]) most = i;
        for (int k = 0; k < kinds; ++k) issued[k] += emulated::warp * done[most][k];
    }
    for (auto& lane : done)
        for (int k = 0; k < kinds; ++k) useful[k] += lane[k];
    for (auto& lane : done)
        for (long& n : lane) n = 0;
}

}  // namespace counting

using counting::square_root;
#define __builtin_sqrt square_root
#include "linear_kernel.hpp"
#include "parameters.hpp"
#define double counting::Counted
#include "kernel.cu"
#undef double

unsigned long long room[sizeof(hardlimit::sweep::Pool) / 8 + 1];

extern "C" int emulate_solve(Task* task) {
    emulated::at_exchange = counting::end_of_round;
    return !emulated::run(solve, task);
}
extern "C" int emulate_damping_ratios(Task* task) {
    const bool synchronous = emulated::run(damping_ratios, task);
    for (auto& lane : counting::done)
        for (long& n : lane) n = 0;
    return !synchronous;
}
// Useful and issued operations since the last call: + − × and comparisons, divisions, roots.
extern "C" void operations(long* out) {
    for (int k = 0; k < counting::kinds; ++k) {
        out[k] = counting::useful[k];
        out[counting::kinds + k] = counting::issued[k];
        counting::useful[k] = counting::issued[k] = 0;
    }
}
