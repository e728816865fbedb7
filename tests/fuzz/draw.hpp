// Generates columns from random numbers or the bytes of a fuzzer. Each parameter covers many decades, and special cases
// (zero gap, equal balls, critical damping, ε = 1, no gravity) are frequent.
#pragma once
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <string_view>

#include "column/state.hpp"

namespace hardlimit::fuzz {

// Random numbers determined by the key (splitmix64: Steele, Lea & Flood, OOPSLA 2014).
class Random {
public:
    explicit Random(std::uint64_t key) : state_(key * 0x9e3779b97f4a7c15ull) {}
    std::uint32_t bits() {
        std::uint64_t z = state_ += 0x9e3779b97f4a7c15ull;
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
        return static_cast<std::uint32_t>((z ^ (z >> 31)) >> 32);
    }

private:
    std::uint64_t state_;
};

// Numbers from a byte array, four bytes each; zero after its end.
class Bytes {
public:
    Bytes(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}
    std::uint32_t bits() {
        std::uint32_t value = 0;
        for (int i = 0; i < 4 && at_ < size_; ++i)
            value |= static_cast<std::uint32_t>(data_[at_++]) << (8 * i);
        return value;
    }

private:
    const std::uint8_t* data_;
    std::size_t size_, at_ = 0;
};

template <class Source>
class Draw {
public:
    explicit Draw(Source source) : source_(source) {}

    int below(int n) { return static_cast<int>(source_.bits() % static_cast<std::uint32_t>(n)); }
    double between(double low, double high) { return low + (high - low) * (source_.bits() * 0x1p-32); }
    double decades(double low, double high) { return math::exp(between(math::log(low), math::log(high))); }
    // With probability 3/8 one of the special values, otherwise common().
    template <class Common>
    double often(std::initializer_list<double> special, const Common& common) {
        const int i = below(8);
        return i < 3 ? special.begin()[below(static_cast<int>(special.size()))] : common();
    }

    double restitution() {
        return often({1.0, 0.1353352832366127, 0.20787957635076193, 0.5}, [&] {
            const int kind = below(4);
            if (kind == 0) return 1.0 - decades(1e-12, 0.1);
            return kind == 1 ? decades(1e-4, 1.0) : between(0.02, 1.0);
        });
    }

private:
    Source source_;
};

// Draws a value of a law's parameter; for a parameter not listed here, from the middle of its range.
template <class Source>
double draw_parameter(Draw<Source>& draw, const Parameter& p) {
    struct Range {
        const char* name;
        double low, high;
        bool zero;  // also draw 0
    };
    constexpr Range known[] = {
        {"stiffness", 1e2, 1e10, false},         {"damping", 1e-6, 1e4, true},
        {"youngs_modulus", 1e4, 1e12, false},    {"dissipative_time", 1e-9, 1e-3, true},
        {"impact_speed", 1e-3, 10.0, false},     {"elastic_prefactor", 1e3, 1e12, false},
        {"damping_coefficient", 1e-4, 4.0, true}};
    const std::string_view name = p.name;
    if (name == "restitution") return draw.restitution();
    for (const Range& r : known) {
        if (name != r.name) continue;
        const double value = draw.decades(r.low, r.high);
        return r.zero ? draw.often({0.0}, [&] { return value; }) : value;
    }
    const bool bounded = p.lowest > -math::infinity && p.highest < math::infinity;
    return bounded ? draw.between(0.75 * p.lowest + 0.25 * p.highest, 0.25 * p.lowest + 0.75 * p.highest)
                   : draw.decades(1e-3, 1e3);
}

// Randomly drawn parameters of a law, for one of the alternatives in its record.
template <class Law>
struct Material {
    int alternative;
    double parameters[2 * max_parameters] = {};

    template <class Source>
    explicit Material(Draw<Source>& draw) : alternative(draw.below(Law::record.n_alternatives)) {
        const LawRecord& record = Law::record;
        for (int i = 0; i < record.n_common; ++i) parameters[i] = draw_parameter(draw, record.common[i]);
        for (int i = 0; i < record.n_in_alternative[alternative]; ++i)
            parameters[record.n_common + i] = draw_parameter(draw, record.alternatives[alternative][i]);
    }
    Law between(PairGeometry pair) const { return Law::from_parameters(alternative, parameters, pair); }
};

template <class Law>
PairGeometry geometry(const column::Column<Law>& c, std::size_t j) {
    const bool floor = j == 0;
    return {effective(floor ? math::infinity : c.mass[j - 1], c.mass[j]),
            effective(floor ? math::infinity : c.radius[j - 1], c.radius[j])};
}

template <class Law, class Source>
void draw_balls(Draw<Source>& draw, column::Column<Law>& c) {
    const double first = draw.decades(1e-5, 1.0), density = draw.decades(100.0, 2e4);
    for (int i = 0; i < c.balls; ++i) {
        const double ratio = draw.often({1.0, 10.0}, [&] { return draw.decades(0.02, 50.0); });
        const double radius = i == 0 ? first : first / ratio;
        c.radius.push_back(radius);
        c.mass.push_back(4.0 / 3.0 * math::pi * density * radius * radius * radius);
    }
}

// Draws gravity, gaps and velocities at release: all at rest, all equal, only one moving, or all different. At least
// one ball moves or falls.
template <class Law, class Source>
void draw_motion(Draw<Source>& draw, column::Column<Law>& c) {
    c.gravity = draw.often({0.0, 9.81, 1.62}, [&] { return draw.decades(1e-3, 1e3); });
    const double speed = draw.decades(1e-4, 30.0);
    const int kind = draw.below(4);
    for (int i = 0; i < c.balls; ++i) {
        const double own = kind == 3   ? draw.between(-speed, speed)
                           : kind == 2 ? (i == 0 ? -speed : 0.0)
                                       : -speed;
        c.velocity.push_back(kind == 0 && c.gravity > 0.0 ? 0.0 : own);
        if (i == 0 && c.floor && !(c.gravity > 0.0)) c.velocity[0] = -speed;  // otherwise it would never land
        const double gap = draw.often({0.0, 1e-15}, [&] { return draw.decades(1e-12, 0.1); });
        c.gaps.push_back(i == 0 && kind == 0 ? draw.decades(1e-9, 10.0) : gap);
    }
}

// A column that the Python package accepts.
template <class Law, class Source>
column::Column<Law> draw_column(Draw<Source>& draw, int balls, bool floor) {
    column::Column<Law> c{balls, floor, 0.0, {}, {}, {}, {}, {}};
    draw_balls(draw, c);
    draw_motion(draw, c);
    if (!floor) c.gravity = 0.0;
    const Material<Law> common(draw);
    const Material<Law> own(draw);
    const bool each_its_own = draw.below(4) == 0;
    for (int j = 0; j < balls; ++j) {
        const Material<Law>& material = each_its_own && j == 0 ? own : common;
        c.contacts.push_back(material.between(geometry(c, static_cast<std::size_t>(j))));
    }
    return c;
}

// Limits the damping ratio of each contact to `most`.
inline void limit_damping(column::Column<contact::LinearDashpot>& c, double most) {
    for (std::size_t j = 0; j < c.contacts.size(); ++j) {
        contact::LinearDashpot& k = c.contacts[j];
        const double ratio = k.damping_ratio(geometry(c, j).effective_mass);
        if (ratio > most) k.damping *= most / ratio;
    }
}

}  // namespace hardlimit::fuzz
