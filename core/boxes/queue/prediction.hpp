// Times until a particle in free flight meets a wall or leaves its cell.
#pragma once
#include "../common/box.hpp"

namespace hardlimit::boxes {

// Time during which x + v τ stays at or below `high`.
HL_FN double time_below(double x, double v, double high) {
    return v > 0.0 ? math::max(0.0, (high - x) / v) : math::infinity;
}

// Time to cover a distance at velocity v, both of the same sign; 0 if rounding has passed the end, infinity for v = 0.
HL_FN double time_to(double way, double v) {
    constexpr double standing[2] = {math::infinity, 0.0};
    return math::max(0.0, way / v) + standing[math::abs(v) > 0.0];
}

// √(v² + 2 g way), or NaN. Squares that would underflow are scaled by a power of two, which leaves all other bits.
HL_FN double speed_after(double v, double g, double way) {
    const double square = v * v + 2.0 * g * way;
    if (math::abs(square) > 1e-280) [[likely]]
        return math::sqrt(square);
    constexpr double scale = 0x1p500;
    return math::sqrt((scale * v) * (scale * v) + 2.0 * (scale * g) * (scale * way)) / scale;
}

// Time during which x + v τ + g τ²/2 stays at or below `high`, if x ≤ high or v leads there. It is the last upward
// crossing for g > 0 and the first for g < 0, each computed without cancellation.
HL_FN double time_below(double x, double v, double g, double high) {
    if (g == 0.0) return time_below(x, v, high);
    const double room = v < 0.0 ? high - x : math::max(0.0, high - x);
    if (g > 0.0) {
        double root = speed_after(v, g, room);
        if (!(root >= 0.0)) root = 0.0;
        return v > 0.0 ? 2.0 * room / (v + root) : (root - v) / g;
    }
    const double root = speed_after(v, g, room);
    return v > 0.0 && root >= 0.0 ? 2.0 * room / (v + root) : math::infinity;
}

// Time until u + v τ + g τ²/2 leaves the interval between two faces, and whether through the upper one. `rounding`:
// error of times [s]. A particle that turns on a face to within it counts as turned. Without branches, since no
// processor can predict which face it is.
struct Exit {
    double time;
    bool high;
};
HL_FN Exit exit_of(double u, double v, double g, double low, double high, double rounding) {
    const bool up = v + g * rounding > 0.0;
    const double sign = up ? 1.0 : -1.0, speed = math::max(0.0, sign * v), pull = sign * g;
    const double ahead = math::max(0.0, up ? high - u : u - low);
    const double behind = math::max(0.0, up ? u - low : high - u);
    const bool reaches = speed * speed + 2.0 * pull * ahead >= 0.0;
    const double root = math::sqrt(speed * speed + 2.0 * (reaches ? pull * ahead : -pull * behind));
    const double time = (reaches ? 2.0 * ahead : speed + root) / (reaches ? speed + root : -pull);
    return {math::max(0.0, time), up == reaches};
}

// Time after `now` at which a particle in free flight, at x with velocity v and acceleration g along the axis, comes
// within `reach` of a wall. For a wall that oscillates: oscillating_contact_time().
double oscillating_contact_time(const Wall& wall, double now, double x, double v, double g, double reach,
                                double horizon);
inline double wall_contact_time(const Wall& wall, double now, double x, double v, double g, double reach,
                                double horizon = math::infinity) {
    if (wall.motion.oscillates()) [[unlikely]]
        return oscillating_contact_time(wall, now, x, v, g, reach, horizon);
    const double out = -wall.inward();
    return time_below(reach - wall.distance(x, now), out * (v - wall.velocity(now)), out * g, 0.0);
}

// Whether a particle in flight touches an oscillating wall and does not separate from it, to within the rounding of
// positions and times. If not, the time of its wall event was a lower bound, or the wall has turned back at that
// instant. A flight too short for the time to resolve counts as over.
inline bool meets_oscillating_wall(const Wall& wall, double now, double x, double v, double g, double reach) {
    const double rate = wall.inward() * (v - wall.velocity(now)), rounding = 16.0 * math::epsilon * now;
    return wall.distance(x, now) - reach <= 1e-9 * reach + rounding * math::abs(rate) &&
           rate <= rounding * math::abs(g - wall.acceleration(now));
}

// First time after `now` at which the gap to an oscillating wall falls to zero; a lower bound on it if it is far away
// or the time there does not resolve the phase, and any later time if it is beyond `horizon`. With the gap
// D(τ) = inward·(x + vτ + gτ²/2 − W(now + τ)) − reach,
//   D(t + s) ≥ D + Ḋ s + m s²/2,   m = min D̈ on [t, t + s],
// where m is the smaller of the two values at the ends, since the acceleration of the wall is monotonic in a quarter of
// the period. The first zero of the right-hand side is never beyond that of D. Steps to it converge quadratically
// to a zero at which D changes its sign; with a triangle wave and with parabolas m is exact, and one step suffices.
// Where Ḋ ≥ 0 and D̈ > 0 the gap grows at least until D̈ may have fallen to zero, a time D̈/(largest jerk), so that a
// launch at zero relative speed is passed over as well. D is summed over the steps from differences of W, which keep
// the digits of a low flight. A particle out of reach of the amplitude needs no steps.
inline double oscillating_contact_time(const Wall& wall, double now, double x, double v, double g,
                                       double reach, double horizon) {
    constexpr int most_steps = 256;
    const WallMotion& m = wall.motion;
    const double in = wall.inward(), jerk = m.greatest_jerk();
    const double middle = wall.start + m.offset + m.velocity * now;
    const double room = in * (x - middle) - (reach + m.amplitude);
    const double clear =
        room > 0.0 ? time_below(-room, -in * (v - m.velocity), -in * g, 0.0) * (1.0 - 1e-12) : 0.0;
    if (!(clear < horizon)) return clear;
    if (const double latest = math::max(now, m.resolved_until() - now); clear > latest) return latest;
    const double rounding =
        4.0 * math::epsilon * (math::abs(x) + math::abs(wall.start) + m.amplitude + reach);
    double t = clear;
    WallPiece piece = wall.piece(now + t);
    double gap = in * (x + t * (v + 0.5 * g * t) - piece.position(now + t)) - reach;
    for (int i = 0; i < most_steps && t < horizon; ++i) {
        const double at = now + t;
        piece.follow(at, at);
        const double left = piece.end - at;
        const double rate = in * ((v + g * t) - piece.velocity(at));
        const double bend = in * (g - piece.acceleration(at));
        const double least = math::min(bend, in * (g - piece.acceleration(piece.end)));
        if (gap <= rounding) {
            if (rate < 0.0 || (rate == 0.0 && bend < 0.0)) return t;
            gap = math::max(gap, 0.0);
        }
        double s = time_below(-gap, -rate, -least, 0.0);
        if (rate >= 0.0 && bend > 0.0) s = math::max(s, jerk > 0.0 ? bend / jerk : left);
        if (s <= 2.0 * math::epsilon * at) return t;
        if (jerk == 0.0 && s <= left) return t + s;
        s = math::min(s, left);
        gap += in * (s * ((v + g * t) + 0.5 * g * s) - piece.displacement(at, s));
        t += s;
    }
    return t;
}

}  // namespace hardlimit::boxes
