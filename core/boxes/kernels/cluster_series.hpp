// The motion of bodies under linear contacts as power series in time.
//
// While no contact begins or ends, F = k ξ + γ dξ/dt keeps the motion analytic, and its Taylor series follows from
// itself, order by order. With r the vector from the first body of a pair to the second, d = |r|, l the sum of their
// radii, and q = k l − γ dd/dt,
//   d² = r·r,   F = q − k d,   w = q/d,   m_1 a_1 = −(w − k) r,   m_2 a_2 = (w − k) r.
// Each product of two series is a sum for each order; a root and a quotient solve such a sum for its last term. A step
// is a good part of a contact, and all that has to be known within it, or where in it a contact begins or ends, is a
// polynomial. Time counts in units in which the fastest contact oscillates with frequency 1.
#pragma once
#include <array>
#include <cstddef>

#include "../../base/math.hpp"

namespace hardlimit_abi {

// What takes the time of a step, compiled once for each instruction set. `paths` [bodies] and `contacts` [n] are
// arrays of series::Path and series::Followed; order [bodies]: the bodies, the first `pushed` of them those in the
// contacts, while the others fly; gravity [4]; bulge [bodies] or none; state: places, then velocities [bodies, 3];
// sums: what is lost, and ∫ Σ r·F dt.
struct SeriesKernels {
    void (*expand)(void* paths, int bodies, void* contacts, int n, const double* gravity, double unit);
    double (*last_terms)(const void* paths, const int* order, int pushed);
    void (*travel)(const void* paths, const int* order, int pushed, int bodies, double at, double* out);
    // Of the distance of two paths; image [3].
    void (*square)(const void* first, const void* second, const double* image, double* out);
    double (*first_zero)(const double* series, double end);
    double (*next_zero)(const double* series, double end, double step, double rounding);
    void (*move)(const void* paths, const int* order, int pushed, int bodies, const void* contacts, int n,
                 double at, double unit, const double* gravity, double* state, double* sums, double* bulge);
};

}  // namespace hardlimit_abi

namespace hardlimit::boxes {

template <class Law>
concept LinearLaw = requires { requires Law::linear; };

namespace series {

inline constexpr int order = 16;
inline constexpr int length = order + 1;

using Four = Vector<4>::Real;  // three coordinates and nothing

// A plain array: a function of the library's could be merged with its copy for another processor. Aligned as such a
// vector is on a processor that has them, so that all copies agree.
template <class T>
struct alignas(sizeof(T)) Series {
    T of[length];

    T& operator[](std::size_t k) { return of[k]; }
    const T& operator[](std::size_t k) const { return of[k]; }
};
using Terms = Series<double>;
using Path = Series<Four>;

struct State {
    Four place, velocity;
};
template <int top = order>
State state(const Path& x, double t) {
    State s{x[top], {}};
    for (int k = top - 1; k >= 0; --k) {
        s.velocity = s.velocity * t + s.place;
        s.place = s.place * t + x[static_cast<std::size_t>(k)];
    }
    return s;
}

// The most by which a path can leave the line between two of its places up to t, all being under the same gravity.
inline double bulge(const Path& x, double t, const Four& gravity) {
    Four bend{};
    for (int k = order; k >= 2; --k) {
        const Four& term = x[static_cast<std::size_t>(k)];
        const Four free = k == 2 ? term - 0.5 * gravity : term;
        bend = bend * t + (k * (k - 1)) * math::max<Four>(free, -free);
    }
    return 0.125 * t * t * math::sqrt(bend[0] * bend[0] + bend[1] * bend[1] + bend[2] * bend[2]);
}

inline Four load_four(const double* x) { return load_lanes<Four>(x); }

// Σ f_k t^k, four terms at a time: the processor need not wait for one product after the other.
template <int groups>
double sum_of_powers(const Four* f, double t) {
    const double t2 = t * t, t4 = t2 * t2;
    Four sum = f[groups - 1];
    HL_UNROLL
    for (int g = groups - 2; g >= 0; --g) sum = sum * t4 + f[g];
    sum *= Four{1.0, t, t2, t2 * t};
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

// From a place where a function is positive, `value`, no zero lies nearer than that of the parabola that bends down as
// much as it does anywhere.
inline double free_of_zeros(double value, double slope, double bend) {
    const double root = math::sqrt(slope * slope + 2.0 * bend * value);
    return slope > 0.0 ? (root + slope) / bend : 2.0 * value / (root - slope);
}

// The first zero in (0, end] of a polynomial that is positive at 0; infinity where there is none. In most cases there
// is none, which shows as soon as the parabolas from both ends meet.
inline double first_zero(const double* f, double end) {
    static_assert(order == 16);
    constexpr Four index = {1.0, 2.0, 3.0, 4.0};
    Four value[5], slope[4], bends[4];  // f, f' and a bound of |f''|
    HL_UNROLL
    for (int g = 0; g < 4; ++g) {
        value[g] = load_four(f + 4 * g);
        slope[g] = (index + 4.0 * g) * load_four(f + 4 * g + 1);
        const Four two_on = g < 3 ? load_four(f + 4 * g + 2) : Four{f[14], f[15], f[16], 0.0};
        const Four bend = (index + 4.0 * g) * (index + (4.0 * g + 1.0)) * two_on;
        bends[g] = math::max<Four>(bend, -bend);
    }
    value[4] = Four{f[16], 0.0, 0.0, 0.0};
    const double bend = sum_of_powers<4>(bends, end);
    double t = 0.0, at = f[0], rate = f[1], last = end;
    for (int i = 0; i < 1000; ++i) {
        if (!(at > 0.0)) return t;
        const double step = free_of_zeros(at, rate, bend);
        if (!(t + step <= last)) return math::infinity;
        if (t + step <= t * (1.0 + 2.0 * math::epsilon)) return t;
        t += step;
        if (i == 0) {
            at = sum_of_powers<5>(value, end);
            if (at > 0.0) last = end - free_of_zeros(at, -sum_of_powers<4>(slope, end), bend);
            if (!(t <= last)) return math::infinity;
        }
        at = sum_of_powers<5>(value, t);
        rate = sum_of_powers<4>(slope, t);
    }
    return t;
}

// The same for one that falls from zero on by its term of order k, the first that counts. What falls by no more than
// `rounding` before it rises has not fallen.
inline double zero_of_falling(const double* f, int k, double end, double rounding) {
    double above[length] = {rounding}, below[length] = {rounding};
    for (int n = k; n < length; ++n) above[n] = f[n], below[n] = -f[n];
    const double fallen = first_zero(above, end);
    return fallen <= end && first_zero(below, fallen) > fallen ? 0.0 : fallen;
}

// The same for a function that has just been put to zero, up to `rounding`: what is left of its first terms is none,
// and what changes by less in a step of the series stays there.
inline double next_zero(const double* f, double end, double step, double rounding) {
    double whole = 0.0, terms[length] = {}, power = 1.0;
    for (int k = 1; k < length; ++k) {
        power *= step;
        terms[k] = math::abs(f[k]) * power;
        whole += terms[k];
    }
    if (math::abs(f[0]) > math::max(1e-9 * whole, rounding)) return f[0] > 0.0 ? first_zero(f, end) : 0.0;
    if (!(whole > rounding)) return math::infinity;
    int k = 1;
    while (k < length && !(terms[k] > 1e-10 * whole)) ++k;
    if (k == length) return math::infinity;
    if (f[k] < 0.0) return zero_of_falling(f, k, end, rounding);
    double rest[length] = {};
    for (int n = k; n < length; ++n) rest[n - k] = f[n];
    return first_zero(rest, end);
}

// How far a body can get up to t.
template <int top = order>
double travel(const Path& x, double t) {
    Four sum{};
    for (int k = top; k >= 1; --k) {
        const Four& term = x[static_cast<std::size_t>(k)];
        sum = (sum + math::max<Four>(term, -term)) * t;
    }
    return math::sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
}
inline double largest(const Four& x) {
    return math::max(math::abs(x[0]), math::max(math::abs(x[1]), math::abs(x[2])));
}

inline double sum_of(const Four& x) { return (x[0] + x[1]) + x[2]; }

// Two bodies. The terms are found in turn: those of the distance up to n + 1 before those of the force of order n. The
// order is known to the compiler, which makes one line of operations of each sum. The distance stands behind the three
// coordinates of r, so that one sum of products serves r·r and d², another one w r and w d; what has to wait for the
// last terms comes last in both.
struct Pair {
    Path between;                   // r, d
    Terms distance;                 // d
    Terms weight, force;            // w, F
    double spring, damper, touch;   // k, γ and l, time counting in its unit
    double per_distance, pressing;  // 1/d and F/d at the begin

    // r and d of order n: r·r = d². The fourth place of `r` is zero.
    template <int n>
    void approach(Four r) {
        if constexpr (n == 0) {
            distance[0] = math::sqrt(sum_of(r * r));
            per_distance = 1.0 / distance[0];
        } else {
            Four sum{};
            HL_UNROLL
            for (std::size_t j = 1; 2 * j < n; ++j) sum += between[j] * between[n - j];
            if constexpr (n % 2 == 0) sum += 0.5 * (between[n / 2] * between[n / 2]);
            sum += between[0] * r;
            distance[n] = (sum_of(sum) - sum[3]) * per_distance;
        }
        r[3] = distance[n];
        between[n] = r;
    }
    // F of order n; returns q.
    template <int n>
    double push() {
        const double damping = damper * (n + 1) * distance[n + 1];
        force[n] = spring * (n == 0 ? touch - distance[0] : -distance[n]) - damping;
        return (n == 0 ? spring * touch : 0.0) - damping;
    }
    // (w − k) r of order n: what pushes the bodies apart. Its first factor is F/d, which is no difference of large
    // numbers.
    template <int n>
    Four apart() {
        Four along{};
        HL_UNROLL
        for (std::size_t j = 1; j < n; ++j) along += weight[j] * between[n - j];
        const double q = push<n>();
        if constexpr (n == 0) {
            pressing = force[0] * per_distance;
            weight[0] = q * per_distance;
        } else {
            weight[n] = ((q - along[3]) - weight[0] * distance[n]) * per_distance;
            along += weight[n] * between[0];
        }
        along += pressing * between[n];
        along[3] = 0.0;
        return along;
    }
};

// The square of the distance of two bodies.
template <int n = 0>
void square_from(const Path& between, double* out) {
    if constexpr (n < length) {
        Four sum{};
        HL_UNROLL
        for (std::size_t j = 0; 2 * j < n; ++j) sum += between[j] * between[n - j];
        sum *= 2.0;
        if constexpr (n % 2 == 0) sum += between[n / 2] * between[n / 2];
        out[n] = sum_of(sum);
        square_from<n + 1>(between, out);
    }
}
inline void square(const void* first, const void* second, const double* image, double* out) {
    const Path &from = *static_cast<const Path*>(first), &to = *static_cast<const Path*>(second);
    Path between;
    for (std::size_t n = 0; n < length; ++n) between[n] = to[n] - from[n];
    between[0] += Four{image[0], image[1], image[2], 0.0};
    square_from(between, out);
}

// ∫ (dd/dt)² dt and ∫ F d dt, F = k (l − d) − γ dd/dt, from 0 to t: by Gauss's rule, whose error over a step, in which
// the square goes through less than half a period, is far below rounding.
struct Integrals {
    double square, product;
};
inline Integrals integrals(const Terms& d, double t, double spring, double damper, double touch) {
    using Eight = Vector<8>::Real;
    constexpr Eight node = {0.01985507175123188, 0.10166676129318663, 0.2372337950418355, 0.4082826787521751,
                            0.5917173212478249,  0.7627662049581645,  0.8983332387068134, 0.9801449282487681};
    constexpr Eight weight = {0.05061426814518813, 0.11119051722668724, 0.15685332293894363,
                              0.18134189168918100, 0.18134189168918100, 0.15685332293894363,
                              0.11119051722668724, 0.05061426814518813};
    const Eight at = t * node;
    Eight value = Eight{} + d[order], slope{};
    for (int k = order - 1; k >= 0; --k) {
        slope = slope * at + value;
        value = value * at + d[static_cast<std::size_t>(k)];
    }
    const Eight squares = weight * (slope * slope);
    const Eight products = weight * ((spring * (touch - value) - damper * slope) * value);
    Integrals sum{};
    for (int i = 0; i < 8; ++i) sum.square += squares[i], sum.product += products[i];
    return {t * sum.square, t * sum.product};
}

// A pair of bodies, or of a body and a wall, that overlap.
struct Followed {
    int pair;           // its number
    int first, second;  // second < 0: a wall
    int axis;           // of the wall's normal
    bool closed;        // pushes
    double side, wall;  // as in Touching
    double reach;
    alignas(sizeof(Four)) Four image;
    double spring, damper;  // time counting in the unit of the series
    double per_mass[2];
    Pair bodies;
    Terms depth, force;  // at a wall

    const Terms& push() const { return second < 0 ? force : bodies.force; }

    Followed() {}  // leaves its terms to those who find them
};
static_assert(alignof(Path) == 32 && alignof(Followed) == 32);

template <int n>
void approach(const Path* paths, Followed& f) {
    const Four& first = paths[f.first][n];
    if (f.second < 0) {
        f.depth[n] = n == 0 ? f.reach - f.side * (first[f.axis] - f.wall) : -f.side * first[f.axis];
        return;
    }
    Four r = paths[f.second][n] - first;
    if constexpr (n == 0) r += f.image;
    f.bodies.template approach<n>(r);
}

template <int n>
void push_of(Followed& f) {
    if (f.second >= 0)
        f.bodies.template push<n>();
    else
        f.force[n] = f.spring * f.depth[n] + f.damper * (n + 1) * f.depth[n + 1];
}

// Adds to the terms of order n + 2 what a pair does. `share`: of an acceleration of order n, in them.
template <int n>
void press(Path* paths, Followed& f, double share) {
    approach<n + 1>(paths, f);
    if (!f.closed) return push_of<n>(f);
    if (f.second < 0) {
        push_of<n>(f);
        paths[f.first][n + 2][f.axis] += (share * f.per_mass[0]) * (f.side * f.force[n]);
        return;
    }
    const Four apart = f.bodies.template apart<n>();
    paths[f.first][n + 2] -= (share * f.per_mass[0]) * apart;
    paths[f.second][n + 2] += (share * f.per_mass[1]) * apart;
}

// The terms from order n + 2 on.
template <int n>
void expand_from(Path* paths, Followed* contacts, int count, double unit) {
    if constexpr (n + 2 > order) {
        for (int c = 0; c < count; ++c) {
            approach<n + 1>(paths, contacts[c]);
            push_of<n>(contacts[c]);
        }
    } else {
        const double share = unit * unit / ((n + 1) * (n + 2));
        for (int c = 0; c < count; ++c) press<n>(paths, contacts[c], share);
        expand_from<n + 1>(paths, contacts, count, unit);
    }
}

// From places and velocities, the first two terms, the series of all bodies and contacts.
inline void expand(void* paths, int bodies, void* contacts, int n, const double* gravity, double unit) {
    Path* const path = static_cast<Path*>(paths);
    Followed* const first = static_cast<Followed*>(contacts);
    const Four fall = load_four(gravity) * (0.5 * unit * unit);
    for (Path* x = path; x != path + bodies; ++x) {
        (*x)[2] = fall;
        HL_UNROLL
        for (std::size_t k = 3; k < length; ++k) (*x)[k] = Four{};
    }
    for (int c = 0; c < n; ++c) {
        first[c].force[order] = first[c].bodies.force[order] = 0.0;
        approach<0>(path, first[c]);
    }
    expand_from<0>(path, first, n, unit);
}

// The largest coordinate of the last two terms of the bodies in contact.
inline double last_terms(const void* paths, const int* bodies_of, int pushed) {
    Four most{};
    for (int i = 0; i < pushed; ++i) {
        const Path& x = static_cast<const Path*>(paths)[bodies_of[i]];
        for (std::size_t k = order - 1; k <= order; ++k)
            most = math::max<Four>(most, math::max<Four>(x[k], -x[k]));
    }
    return math::max(math::max(most[0], most[1]), most[2]);
}

inline void travels(const void* paths, const int* bodies_of, int pushed, int bodies, double at, double* out) {
    const Path* const path = static_cast<const Path*>(paths);
    for (int i = 0; i < bodies; ++i) {
        const int body = bodies_of[i];
        out[body] = i < pushed ? travel(path[body], at) : travel<2>(path[body], at);
    }
}

// To a place in the step.
inline void move(const void* paths, const int* bodies_of, int pushed, int bodies, const void* contacts, int n,
                 double at, double unit, const double* gravity, double* places, double* sums,
                 double* bulges) {
    const Path* const path = static_cast<const Path*>(paths);
    for (int c = 0; c < n; ++c) {
        const Followed& f = static_cast<const Followed*>(contacts)[c];
        if (!f.closed) continue;
        const Terms& shape = f.second < 0 ? f.depth : f.bodies.distance;
        const Integrals sum = integrals(shape, at, f.spring, f.damper, f.reach);
        sums[0] += f.damper * sum.square;
        if (f.second >= 0) sums[1] += unit * sum.product;
    }
    const Four fall = load_four(gravity) * (unit * unit);
    const double per_unit = 1.0 / unit;
    for (int i = 0; i < bodies; ++i) {
        const int body = bodies_of[i];
        if (bulges) bulges[body] = i < pushed ? bulge(path[body], at, fall) : 0.0;
        const State s = i < pushed ? state(path[body], at) : state<2>(path[body], at);
        for (int a = 0; a < 3; ++a) {
            places[3 * body + a] = s.place[a];
            places[3 * (bodies + body) + a] = s.velocity[a] * per_unit;
        }
    }
}

constexpr hardlimit_abi::SeriesKernels kernels() {
    return {&expand, &last_terms, &travels, &square, &first_zero, &next_zero, &move};
}

}  // namespace series
}  // namespace hardlimit::boxes
