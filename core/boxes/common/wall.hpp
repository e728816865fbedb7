// A wall and its motion: at rest, with a constant velocity, or oscillating.
#pragma once
#include <cstddef>
#include <cstdint>

#include "../../base/math.hpp"

namespace hardlimit::boxes {

// Whether walls may move and boxes be sheared. A module without these leaves out their code (bindings/wasm_gas.cpp).
#ifdef HARDLIMIT_BOXES_AT_REST
inline constexpr bool boxes_move = false;
#else
inline constexpr bool boxes_move = true;
#endif

// Number of a wall in logs and results: −1 − 2·axis at 0, −2 − 2·axis at L; 0: no wall. The second partner of a contact
// is a particle (≥ 0) or a wall (< 0).
struct WallId {
    std::int32_t number = 0;

    static constexpr WallId at(int axis, bool high) { return {-1 - 2 * axis - (high ? 1 : 0)}; }
    // The wall that is the second partner of a contact; no wall if that partner is a particle.
    static constexpr WallId of(i64 second) { return {second < 0 ? static_cast<std::int32_t>(second) : 0}; }
    constexpr explicit operator bool() const { return number < 0; }
    constexpr int axis() const { return (-1 - number) / 2; }
    constexpr bool high() const { return (-1 - number) % 2 != 0; }
    constexpr std::size_t index() const { return static_cast<std::size_t>(-1 - number); }  // 0 … 5
    constexpr bool operator==(const WallId&) const = default;
};
inline constexpr int most_walls = 6;

// What particles have given to each wall in their contacts with it, by index() of the wall: momentum along the outward
// normal, and energy, which is the dissipated energy less the work of the wall.
struct WallSums {
    double impulse[most_walls] = {};  // [N s]
    double energy[most_walls] = {};   // [J]

    void add(WallId wall, double momentum, double given) {
        impulse[wall.index()] += momentum;
        energy[wall.index()] += given;
    }
    WallSums& operator+=(const WallSums& other) {
        for (int k = 0; k < most_walls; ++k) impulse[k] += other.impulse[k], energy[k] += other.energy[k];
        return *this;
    }
};

// One period as a function of the phase φ: sin φ; the triangle wave with its zeros and extrema; parabolic arcs with
// these, φ = π u: 4u(1 − u) in [0, π].
enum class Waveform : int {
    none,
    sine,
    triangle,
    parabola,
};

// Displacement from the rest place: offset + velocity t + amplitude w(2π frequency t + phase), along the axis.
struct WallMotion {
    double offset = 0.0;     // [m]
    double velocity = 0.0;   // [m/s]
    double amplitude = 0.0;  // [m]
    double frequency = 0.0;  // [1/s]
    double cycles = 0.0;     // phase/2π
    Waveform waveform = Waveform::none;
    int unused = 0;

    // Beyond this number of periods the time is rounded to a thousandth of a period or more.
    static constexpr double most_periods = 0x1p42;

    constexpr bool oscillates() const { return boxes_move && waveform != Waveform::none; }
    // Up to here the time resolves the phase of the oscillation [s].
    double resolved_until() const { return most_periods / frequency; }
    constexpr bool moves() const { return boxes_move && (velocity != 0.0 || oscillates()); }
    // Greatest velocity, acceleration and jerk of the oscillation. A triangle wave jumps in velocity, a parabola in
    // acceleration: these jumps are not included.
    double fastest() const {
        const double rate = frequency * amplitude;
        if (waveform == Waveform::sine) return 2.0 * math::pi * rate;
        return waveform == Waveform::triangle   ? 4.0 * rate
               : waveform == Waveform::parabola ? 8.0 * rate
                                                : 0.0;
    }
    double greatest_acceleration() const {
        const double rate = frequency * frequency * amplitude;
        if (waveform == Waveform::sine) return 4.0 * math::pi * math::pi * rate;
        return waveform == Waveform::parabola ? 32.0 * rate : 0.0;
    }
    double greatest_jerk() const {
        const double omega = 2.0 * math::pi * frequency;
        return waveform == Waveform::sine ? amplitude * omega * omega * omega : 0.0;
    }
};

// Motion of a wall during a quarter of its period. The motion is smooth there and its acceleration monotonic; only
// between two quarters may the velocity (triangle) or the acceleration (parabola) jump. A wall that does not oscillate
// has one piece.
struct WallPiece {
    WallMotion motion;
    double quarter = 0.0;                         // number of the quarter
    double begin = 0.0, end = math::infinity;     // [s]
    double position0 = 0.0;                       // at `begin` [m]
    double velocity0 = 0.0, acceleration0 = 0.0;  // at `begin`, without a sine [m/s], [m/s²]
    double amplitude = 0.0, omega = 0.0;          // of a sine [m], [1/s]
    double phase0 = 0.0;                          // of a sine at `begin`
    double shift_of_time = 0.0, place = 0.0;      // subtracted from times; rest place with its shift [m]

    // The piece with this number, for a wall at `place`; `base` becomes time 0.
    static WallPiece of(const WallMotion& m, double place, double quarter, double base) {
        WallPiece p;
        p.motion = m, p.quarter = quarter, p.shift_of_time = base, p.place = place;
        const auto time = [&](double count) { return (0.25 * count - m.cycles) / m.frequency; };
        const double begin = time(quarter);
        const bool resolved = math::abs(quarter) < 4.0 * WallMotion::most_periods;
        const int k = resolved ? static_cast<int>(quarter - 4.0 * math::floor_small(0.25 * quarter)) : 0;
        const double sign = k < 2 ? 1.0 : -1.0;  // of the displacement
        const bool rising = k == 0 || k == 3, odd = k % 2 != 0;
        p.begin = begin - base, p.end = time(quarter + 1.0) - base;
        p.position0 = (place + m.offset) + m.velocity * begin + (odd ? sign * m.amplitude : 0.0);
        p.velocity0 = m.velocity;
        if (m.waveform == Waveform::sine) {
            p.amplitude = m.amplitude, p.omega = 2.0 * math::pi * m.frequency, p.phase0 = 0.5 * math::pi * k;
        } else if (m.waveform == Waveform::triangle) {
            p.velocity0 += rising ? m.fastest() : -m.fastest();
        } else {
            p.velocity0 += odd ? 0.0 : sign * m.fastest();
            p.acceleration0 = -sign * m.greatest_acceleration();
        }
        return p;
    }
    static double quarter_at(const WallMotion& m, double time) {
        return math::floor_small(4.0 * (m.frequency * time + m.cycles));
    }
    // The same for a wall that does not oscillate.
    static WallPiece uniform(double position, double velocity) {
        WallPiece p;
        p.position0 = position, p.velocity0 = velocity;
        return p;
    }
    // Whether it ends at this time, to within the rounding of the time since the start.
    bool ends_at(double time, double since_start) const {
        return end - time <= 2.0 * math::epsilon * math::abs(since_start);
    }
    WallPiece next() const { return of(motion, place, quarter + 1.0, shift_of_time); }
    // Becomes the piece at this time. Returns whether it has ended.
    bool follow(double time, double since_start) {
        if (!ends_at(time, since_start)) return false;
        const double later = math::max(quarter + 1.0, quarter_at(motion, since_start));
        *this = of(motion, place, later, shift_of_time);
        if (ends_at(time, since_start)) *this = next();
        return true;
    }

    double velocity(double time) const {
        const double s = time - begin;
        const double v = velocity0 + acceleration0 * s;
        return amplitude == 0.0 ? v : v + amplitude * omega * math::cos(phase0 + omega * s);
    }
    double acceleration(double time) const {
        if (amplitude == 0.0) return acceleration0;
        return acceleration0 - amplitude * omega * omega * math::sin(phase0 + omega * (time - begin));
    }
    // Displacement from one time to another in this piece, which keeps its digits if they are close.
    double displacement(double from, double s) const {
        const double begun = from - begin;
        const double moved = s * (velocity0 + acceleration0 * (begun + 0.5 * s));
        if (amplitude == 0.0) return moved;
        const double half = 0.5 * omega * s;
        return moved + 2.0 * amplitude * math::sin(half) * math::cos(phase0 + omega * begun + half);
    }
    double position(double time) const { return position0 + displacement(begin, time - begin); }
    // The position as a power series around `time`, up to order n >= 3. `unit`: of the variable of the series [s].
    void expand(double time, double unit, int n, double* series) const {
        series[0] = position(time), series[1] = unit * velocity(time);
        series[2] = 0.5 * unit * unit * acceleration(time);
        const double square = omega * unit * omega * unit;
        series[3] = -square / 6.0 * (series[1] - unit * velocity0);
        for (int k = 4; k <= n; ++k) series[k] = -square / (k * (k - 1)) * series[k - 2];
    }
};

// wall_contact_time() (queue/prediction.hpp) locates collisions with it.
struct Wall {
    WallId id;
    double start;  // coordinate of the rest place [m]
    WallMotion motion = {};

    constexpr bool moves() const { return motion.moves(); }
    // The piece at a time, or the next one if it begins within rounding.
    WallPiece piece(double time) const { return piece_from(time, 0.0, 0.0); }
    // The same with `base` and `origin` as the origins of its times and positions.
    WallPiece piece_from(double time, double base, double origin) const {
        if (!motion.oscillates()) return WallPiece::uniform(position(base) - origin, motion.velocity);
        const auto of = WallPiece::of(motion, start - origin, WallPiece::quarter_at(motion, time), base);
        return of.ends_at(time - base, time) ? of.next() : of;
    }
    double position(double time) const {
        if (motion.oscillates()) return piece(time).position(time);
        return moves() ? (start + motion.offset) + motion.velocity * time : start + motion.offset;
    }
    double velocity(double time) const {
        return motion.oscillates() ? piece(time).velocity(time) : motion.velocity;
    }
    // Mean velocity around a time; of second order in the span also where the velocity jumps.
    double mean_velocity(double time, double span) const {
        if (!motion.oscillates() || !(span > 0.0)) return velocity(time);
        return (position(time + 0.5 * span) - position(time - 0.5 * span)) / span;
    }
    double acceleration(double time) const {
        return motion.oscillates() ? piece(time).acceleration(time) : 0.0;
    }
    // Sign of the inward normal along the axis, and distance of a coordinate inside the box from the wall [m].
    constexpr double inward() const { return id.high() ? -1.0 : 1.0; }
    double distance(double x, double time) const {
        return id.high() ? position(time) - x : x - position(time);
    }
    // Whether a coordinate surely stays farther away than `reach` between two times. The amplitude is tried first,
    // because the phase of an oscillation is costly.
    bool stays_beyond(double reach, double x, double from, double until) const {
        if (motion.oscillates()) {
            const auto middle = [&](double time) { return start + motion.offset + motion.velocity * time; };
            const double a = inward() * (x - middle(from)), b = inward() * (x - middle(until));
            if (math::min(a, b) - motion.amplitude > reach) return true;
        }
        const double a = distance(x, from), b = distance(x, until);
        if (!motion.oscillates()) return math::min(a, b) > reach;
        return 0.5 * ((a + b) - (math::abs(motion.velocity) + motion.fastest()) * (until - from)) > reach;
    }
};

}  // namespace hardlimit::boxes
