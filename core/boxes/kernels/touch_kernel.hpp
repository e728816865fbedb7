// SIMD kernel that predicts when a particle touches each of its neighbours, eight, four or two at a time. A neighbour's
// record has eight doubles, so that shuffles transpose the records of all lanes. Lanes are independent: results are
// bit-identical for any number of lanes.
//
// A pair at r with relative velocity v touches at the distance σ, which grows at the rate s (0 without growing radii).
// With a = v² − s², b = r·v − σ s, c = r² − σ²:
//   |r + v τ| = σ + s τ   ⇔   a τ² + 2 b τ + c = 0.
// For b < 0 the first root is c/(−b + √(b² − a c)), a form that neither cancels nor gives a time in the past. If c ≤ 0,
// by rounding or after an equivalent collision, a pair that approaches collides now (Bannerman, Strobl,
// Formella & Pöschel, Comput. Part. Mech. 1, 191 (2014)). If radii grow faster than the pair separates, b ≥ 0 and a <
// 0, and the root is (b + √(b² − a c))/(−a).
//
// With `enlarged`, radii include safety radii, and two particles may be too close without approaching: if c < 0 by more
// than rounding, they touch now, for any b. The particle itself may have a larger radius for a limited time. A
// neighbour can touch that radius within this time only if c + 2 b τ <= 0 at its end, as a τ² >= 0; otherwise it
// touches the usual radius.
#pragma once
#include <cstddef>
#include <cstring>

#include "../common/particle.hpp"
#include "interface.hpp"

namespace hardlimit::boxes {

// Which periodic image of a neighbour is used.
enum class Image { as_it_is, nearest, shifted };

// Relative motion of pairs: a and b without the growth of radii, r², and σ at a factor of 1.
template <class Real>
struct RelativeMotion {
    Real a, b, square, touch;
};
template <class Real, int d, Motion motion, Image image>
HL_FN RelativeMotion<Real> relative_motion(const hardlimit_abi::ContactQuery& q, const Columns<Real>& p) {
    const Real after = q.now - p.of[2 * d];
    Real a{}, b{}, square{};
    HL_UNROLL
    for (int k = 0; k < d; ++k) {
        Real x, v;
        if constexpr (motion == Motion::falling) {
            x = p.of[k] + after * (p.of[d + k] + q.half_gravity[k] * after);
            v = p.of[d + k] + q.gravity[k] * after;
        } else {
            x = p.of[k] + after * p.of[d + k];
            v = p.of[d + k];
        }
        if constexpr (image == Image::shifted) x = x + q.shift[k];
        Real r = x - q.position[k];
        if constexpr (image == Image::nearest) r = r - q.edge[k] * math::round_small<Real>(r * q.per_edge[k]);
        v = v - q.velocity[k];
        a = k == 0 ? v * v : a + v * v;
        b = k == 0 ? r * v : b + r * v;
        square = k == 0 ? r * r : square + r * r;
    }
    return {a, b, square, q.radius + q.others * p.of[2 * d + 1]};
}

// Time until a pair with b < 0 and a positive discriminant touches.
template <class Real>
HL_FN Real first_root(const Real& b, const Real& c, const Real& discriminant) {
    return math::max<Real>(c, Real{}) / (math::sqrt<Real>(math::max<Real>(discriminant, Real{})) - b);
}

// `only_group`: there is a single group of lanes. An early return if no lane touches then pays; with several groups
// that branch is unpredictable, and a misprediction costs more than the square root and the division.
template <class Real, int d, Motion motion, Image image, bool enlarged>
HL_FN Real touch_times_of(const hardlimit_abi::ContactQuery& q, const Columns<Real>& p, bool only_group) {
    auto [a, b, square, touch] = relative_motion<Real, d, motion, image>(q, p);
    const Real never = broadcast<Real>(math::infinity);
    if constexpr (motion == Motion::growing) {
        const Real distance = touch * q.radius_factor, speed = touch * q.growth_rate;
        a = a - speed * speed;
        b = b - distance * speed;
        const Real c = square - distance * distance;
        const Real discriminant = b * b - a * c;
        const Mask<Real> approaching = (b < 0.0) & (discriminant > 0.0);
        const Mask<Real> overtaken = (c > 0.0) & (a < 0.0);
        const Real root = math::sqrt<Real>(math::max<Real>(discriminant, Real{}));
        const Real time = select<Real>(b < 0.0, math::max<Real>(c, Real{}) / (root - b), (b + root) / -a);
        return select<Real>((approaching | overtaken) & (square > 0.0), time, never);
    } else {
        const Real c = square - touch * touch;
        const Real discriminant = b * b - a * c;
        const Mask<Real> will = (b < 0.0) & (discriminant > 0.0);
        Mask<Real> soon{};
        Real space{}, excess{};
        if constexpr (enlarged) {
            space = q.enlarged_radius + q.others * p.of[2 * d + 1];
            excess = square - space * space;
            // The particle itself, at zero distance, does not count.
            soon = (excess + 2.0 * q.enlarged_span * math::min<Real>(b, Real{}) <= 0.0) & (square > 0.0);
        }
        if (only_group && !any(will | soon)) return never;
        const Real usual = select<Real>(will, first_root<Real>(b, c, discriminant), never);
        if constexpr (!enlarged) return usual;
        if (!any(soon)) return usual;
        const Mask<Real> now = soon & (excess < -rounding_of_touch * (space * space));
        const Real under = b * b - a * excess;
        const Real sooner = first_root<Real>(b, excess, under);
        const Mask<Real> before = soon & (b < 0.0) & (under > 0.0) & (sooner <= q.enlarged_span);
        return select<Real>(now, Real{}, select<Real>(before, sooner, usual));
    }
}

// Minimum over all lanes.
template <class Real>
HL_FN double least_lane(const Real& x) {
    if constexpr (Lanes<Real>::count == 2) {
        return math::min(lane_of(x, 0), lane_of(x, 1));
    } else {
        using Half = typename Vector<Lanes<Real>::count / 2>::Real;
        double each[Lanes<Real>::count];
        store_lanes(each, x);
        const Half low = load_lanes<Half>(each), high = load_lanes<Half>(each + Lanes<Half>::count);
        return least_lane<Half>(math::min<Half>(low, high));
    }
}

// Earliest contact, from the smallest and the second smallest time of each lane.
template <class Real, bool enlarged>
HL_FN hardlimit_abi::EarliestContact touched_first(const Real& least, const Real& second, const unsigned* ids,
                                                   const double* times, std::size_t n) {
    constexpr std::size_t lanes = Lanes<Real>::count;
    const double time = least_lane<Real>(least);
    hardlimit_abi::EarliestContact touched{time, time, boxes::no_particle, 0, n};
    if (!(time < math::infinity)) return touched;
    if constexpr (enlarged) touched.next = least_lane<Real>(select<Real>(least == time, second, least));
    for (std::size_t begin = 0; begin < n; begin += 64) {
        const std::size_t end = begin + 64 < n ? begin + 64 : n;
        u64 same = 0;
        for (std::size_t k = begin; k < end; k += lanes)
            same |= static_cast<u64>(lane_bits(load_lanes<Real>(times + k) == time)) << (k - begin);
        if (same == 0) continue;
        touched.several |= touched.id != boxes::no_particle || (same & (same - 1)) != 0;
        touched.id = ids[begin + static_cast<std::size_t>(first_bit(same))];
    }
    return touched;
}

// With four lanes the root and the quotient take as long as the rest: the few pairs that will touch are packed first.
// Their ids and times are left in the lists.
template <class Real, int d, Motion motion, Image image, class Packed = PackedLanes>
hardlimit_abi::EarliestContact touch_packed(const hardlimit_abi::ContactQuery& q, const double* lines,
                                            unsigned* ids, double* times, std::size_t n) {
    constexpr std::size_t lanes = Lanes<Real>::count, most = 64;
    Real least = broadcast<Real>(math::infinity);
    std::size_t found = 0;
    for (std::size_t begin = 0; begin < n; begin += most) {
        double b[most + lanes], c[most + lanes], discriminant[most + lanes];
        const std::size_t end = begin + most < n ? begin + most : n;
        std::size_t hits = 0;
        for (std::size_t k = begin; k < end; k += lanes) {
            const double* row[lanes];
            HL_UNROLL
            for (std::size_t lane = 0; lane < lanes; ++lane)
                row[lane] = lines + 8 * std::size_t{ids[k + lane]};
            const auto pair = relative_motion<Real, d, motion, image>(q, load_columns<Real>(row));
            const Real over = pair.square - pair.touch * pair.touch, under = pair.b * pair.b - pair.a * over;
            const unsigned will = lane_bits((pair.b < 0.0) & (under > 0.0));
            const Packed packed(will);
            store_lanes(b + hits, packed(pair.b));
            store_lanes(c + hits, packed(over));
            store_lanes(discriminant + hits, packed(under));
            packed.move(ids + found + hits, ids + k);
            hits += static_cast<std::size_t>(bit_count(will));
        }
        // The rest of the last group never touches.
        store_lanes(b + hits, broadcast<Real>(-1.0));
        store_lanes(c + hits, broadcast<Real>(math::infinity));
        store_lanes(discriminant + hits, Real{});
        for (std::size_t k = 0; k < hits; k += lanes) {
            const Real time = first_root<Real>(load_lanes<Real>(b + k), load_lanes<Real>(c + k),
                                               load_lanes<Real>(discriminant + k));
            store_lanes(times + found + k, time);
            least = math::min<Real>(least, time);
        }
        found += hits;
    }
    return touched_first<Real, false>(least, least, ids, times, found);
}

template <class Real, int d, Motion motion, Image image, bool enlarged>
hardlimit_abi::EarliestContact touch_listed(const hardlimit_abi::ContactQuery& q, const void* particles,
                                            unsigned self, unsigned* ids, double* times, std::size_t n) {
    constexpr std::size_t lanes = Lanes<Real>::count;
    const double* const lines = static_cast<const double*>(particles);
    // Pads the last group of lanes with the particle itself, for which no contact is found.
    for (std::size_t k = 0; k + 1 < lanes; ++k) ids[n + k] = self;
    if constexpr (packs_lanes && lanes == 4 && !enlarged && motion != Motion::growing)
        return touch_packed<Real, d, motion, image>(q, lines, ids, times, n);
    Real least = broadcast<Real>(math::infinity), second = least;
    for (std::size_t k = 0; k < n; k += lanes) {
        const double* row[lanes];
        HL_UNROLL
        for (std::size_t lane = 0; lane < lanes; ++lane) row[lane] = lines + 8 * std::size_t{ids[k + lane]};
        const Real time =
            touch_times_of<Real, d, motion, image, enlarged>(q, load_columns<Real>(row), n <= lanes);
        store_lanes(times + k, time);
        if constexpr (enlarged) second = math::min<Real>(second, math::max<Real>(least, time));
        least = math::min<Real>(least, time);
    }
    return touched_first<Real, enlarged>(least, second, ids, times, n);
}

constexpr unsigned words_of_cell = 4, inline_ids = 3;

// Appends the ids of a cell to a list; returns the new end.
inline unsigned* collect_cell(const unsigned* cell, const unsigned* spilled, unsigned* to) {
    for (;;) {
        std::memcpy(to, cell, words_of_cell * sizeof *cell);
        const unsigned tail = cell[inline_ids];
        if (tail <= inline_ids) return to + tail;
        to += inline_ids;
        cell = spilled + words_of_cell * std::size_t{tail - inline_ids - 1};
    }
}

// Collects all ids in a block; returns their number.
inline std::size_t collect_cells(const hardlimit_abi::CellBlock& block, unsigned* ids) {
    const unsigned* const spilled = static_cast<const unsigned*>(block.spilled);
    unsigned* to = ids;
    for (unsigned part = 0; part < block.parts; ++part)
        for (unsigned r = 0; r < block.rows; ++r) {
            const unsigned* cell = static_cast<const unsigned*>(block.cells) +
                                   words_of_cell * std::size_t{block.begin[part] + block.row[r]};
            const unsigned* const end = cell + words_of_cell * block.length[part];
            if (block.length[part] == 3) {  // as a rule; the loop would wait for one cell after the other
                const unsigned *const second = cell + words_of_cell, *const third = second + words_of_cell;
                const unsigned n = cell[inline_ids], both = n + second[inline_ids];
                if ((cell[inline_ids] | second[inline_ids] | third[inline_ids]) <= inline_ids) {
                    std::memcpy(to, cell, words_of_cell * sizeof *cell);
                    std::memcpy(to + n, second, words_of_cell * sizeof *cell);
                    std::memcpy(to + both, third, words_of_cell * sizeof *cell);
                    to += both + third[inline_ids];
                    continue;
                }
            }
            HL_ROLL
            for (; cell != end; cell += words_of_cell) to = collect_cell(cell, spilled, to);
        }
    return static_cast<std::size_t>(to - ids);
}

// The same, for a row of up to three cells at a time on processors with a compress-store instruction.
template <class Sixteen = Words>
std::size_t collect_block(const hardlimit_abi::CellBlock& block, unsigned* ids) {
    if constexpr (!sifts_words) {
        return collect_cells(block, ids);
    } else {
        unsigned* to = ids;
        Sixteen any{};
        for (unsigned part = 0; part < block.parts; ++part) {
            const unsigned here = (1u << words_of_cell * block.length[part]) - 1, held = 0x7777u & here;
            const unsigned* const column =
                static_cast<const unsigned*>(block.cells) + words_of_cell * std::size_t{block.begin[part]};
            HL_ROLL
            for (unsigned r = 0; r < block.rows; ++r) {
                const Sixteen all(column + words_of_cell * std::size_t{block.row[r]});
                const unsigned chosen = all.unlike(no_particle) & held;
                any = any | all;
                all.store(to, chosen);
                to += bit_count(chosen);
            }
            // The fourth word of a cell exceeds three if further ids are in `spilled`.
            if ((any.above(inline_ids) & (0x8888u & here)) != 0) return collect_cells(block, ids);
        }
        return static_cast<std::size_t>(to - ids);
    }
}

template <class Real, int d, Motion motion, Image image, bool enlarged>
hardlimit_abi::EarliestContact touch_near(const hardlimit_abi::ContactQuery& q, const void* particles,
                                          unsigned self, unsigned* ids, double* times,
                                          const hardlimit_abi::CellBlock& block) {
    return touch_listed<Real, d, motion, image, enlarged>(q, particles, self, ids, times,
                                                          collect_block(block, ids));
}

}  // namespace hardlimit::boxes
