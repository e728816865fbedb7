// Random numbers, the same on every platform: xoshiro256++ (Blackman & Vigna, ACM Trans. Math. Softw. 47, 36 (2021)),
// seeded with splitmix64.
#pragma once
#include "../../base/math.hpp"

namespace hardlimit::boxes {

class Random {
public:
    explicit Random(u64 seed) {
        for (u64& word : state_) {
            seed += 0x9e3779b97f4a7c15ULL;
            u64 z = seed;
            z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
            z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
            word = z ^ (z >> 31);
        }
    }

    u64 next() {
        const u64 result = turned(state_[0] + state_[3], 23) + state_[0], shifted = state_[1] << 17;
        state_[2] ^= state_[0];
        state_[3] ^= state_[1];
        state_[1] ^= state_[2];
        state_[0] ^= state_[3];
        state_[2] ^= shifted;
        state_[3] = turned(state_[3], 45);
        return result;
    }
    // Uniform in [0, 1).
    double uniform() { return static_cast<double>(next() >> 11) * 0x1p-53; }
    // Standard normal, by the Box-Muller method.
    double normal() {
        const double radius = math::sqrt(-2.0 * math::log(1.0 - uniform()));
        return radius * math::cos(2.0 * math::pi * uniform());
    }

private:
    u64 state_[4];

    static u64 turned(u64 x, int by) { return (x << by) | (x >> (64 - by)); }
};

}  // namespace hardlimit::boxes
