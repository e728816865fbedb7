// Format of golden values: numbers are the sixteen hexadecimal digits of their bits, every NaN is "nan".
#pragma once
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string>

inline std::string bits(double x) {
    if (x != x) return "\"nan\"";
    std::uint64_t v;
    std::memcpy(&v, &x, 8);
    char text[24];
    std::snprintf(text, sizeof text, "\"%016llx\"", static_cast<unsigned long long>(v));
    return text;
}
inline void print(const char* name, const double* x, long n, const char* after) {
    std::printf("\"%s\": [", name);
    for (long i = 0; i < n; ++i) std::printf("%s%s", i ? ", " : "", bits(x[i]).c_str());
    std::printf("]%s", after);
}

// Two 32-bit hashes of the bits, NaN counted as one value.
struct Hash {
    std::uint32_t a = 2166136261u, b = 0x9e3779b9u;
    void add(double x) {
        std::uint64_t v = 0x7ff8000000000000ull;
        if (x == x) std::memcpy(&v, &x, 8);
        for (const std::uint32_t word :
             {static_cast<std::uint32_t>(v), static_cast<std::uint32_t>(v >> 32)}) {
            a = (a ^ word) * 16777619u;
            b = ((b ^ word) * 0x85ebca6bu) ^ (b >> 13);
        }
    }
    void print(const char* name, const char* after) const {
        std::printf("\"%s\": \"%08x%08x\"%s", name, static_cast<unsigned>(a), static_cast<unsigned>(b),
                    after);
    }
};

// Gases (golden_gas.cpp).
void print_boxes();
