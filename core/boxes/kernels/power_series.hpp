// Motion of bodies under linear contacts as power series in time.
//
// While no contact begins or ends, the motion under F = k ξ + γ dξ/dt is analytic, and its Taylor series follows order
// by order. With r the vector from the first body of a pair to the second, d = |r|, l the contact distance, and q = k l
// − γ dd/dt,
//   d² = r·r,   F = q − k d,   w = q/d,   m_1 a_1 = −(w − k) r,   m_2 a_2 = (w − k) r.
// Each order of a product of two series is a convolution sum; for a root or a quotient that sum is solved for its last
// term. A step covers a good part of a contact, and every event function within it is a polynomial. In the unit of time
// the fastest contact has angular frequency 1.
#pragma once
#include <cstddef>

#include "../common/symmetric_tensor.hpp"
#include "gauss_legendre.hpp"
#include "interface.hpp"
#include "polynomial_zeros.hpp"

namespace hardlimit::boxes {

namespace series {

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

// Upper bound on the distance of a path from its chord up to t, without common gravity.
inline double chord_deviation(const Path& x, double t, const Four& gravity) {
    Four bend{};
    for (int k = order; k >= 2; --k) {
        const Four& term = x[static_cast<std::size_t>(k)];
        const Four free = k == 2 ? term - 0.5 * gravity : term;
        bend = bend * t + (k * (k - 1)) * math::max<Four>(free, -free);
    }
    return 0.125 * t * t * math::sqrt(bend[0] * bend[0] + bend[1] * bend[1] + bend[2] * bend[2]);
}

// Upper bound on the distance covered up to t.
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

// Series of the distance and the force of two bodies. The distance is expanded up to order n + 1 before the force of
// order n. The order is a template parameter, so that each sum becomes straight-line code. The distance is the fourth
// component of r: one sum of products gives r·r and d², another one w r and w d. Their newest terms are added last.
struct PairSeries {
    Path between;                             // r, d
    Terms distance;                           // d
    Terms weight, force;                      // w, F
    double spring, damper, contact_distance;  // k, γ and l, in the unit of time
    double per_distance, force_per_distance;  // 1/d and F/d at the start

    // r and d of order n: r·r = d². The fourth component of `r` is zero.
    template <int n>
    void expand_distance(Four r) {
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
    // F of order n; returns q of order n.
    template <int n>
    double expand_force() {
        const double damping = damper * (n + 1) * distance[n + 1];
        force[n] = spring * (n == 0 ? contact_distance - distance[0] : -distance[n]) - damping;
        return (n == 0 ? spring * contact_distance : 0.0) - damping;
    }
    // (w − k) r of order n, the separating force. Order 0 of w − k is computed as F/d, without cancellation.
    template <int n>
    Four relative_acceleration() {
        Four along{};
        HL_UNROLL
        for (std::size_t j = 1; j < n; ++j) along += weight[j] * between[n - j];
        const double q = expand_force<n>();
        if constexpr (n == 0) {
            force_per_distance = force[0] * per_distance;
            weight[0] = q * per_distance;
        } else {
            weight[n] = ((q - along[3]) - weight[0] * distance[n]) * per_distance;
            along += weight[n] * between[0];
        }
        along += force_per_distance * between[n];
        along[3] = 0.0;
        return along;
    }
};

// Series of the squared distance of two bodies.
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

// An overlapping pair of bodies, or of a body and a wall.
struct Contact {
    int pair;           // index in the cluster
    int first, second;  // second < 0: a wall
    int axis;           // of the wall's normal
    bool closed;        // exerts a force
    double side;        // as in ContactPair
    double contact_distance;
    alignas(sizeof(Four)) Four image;
    double spring, damper;  // in the unit of time
    double per_mass[2];
    PairSeries bodies;
    Terms wall, depth, force;  // at a wall; wall: its coordinate

    const Terms& force_series() const { return second < 0 ? force : bodies.force; }

    Contact() {}  // leaves the terms uninitialized
};
static_assert(alignof(Path) == 32 && alignof(Contact) == 32);

template <int n>
void expand_distance(const Path* paths, Contact& f) {
    const Four& first = paths[f.first][n];
    if (f.second < 0) {
        const double x = first[f.axis] - f.wall[n];
        f.depth[n] = n == 0 ? f.contact_distance - f.side * x : -f.side * x;
        return;
    }
    Four r = paths[f.second][n] - first;
    if constexpr (n == 0) r += f.image;
    f.bodies.template expand_distance<n>(r);
}

template <int n>
void expand_force(Contact& f) {
    if (f.second >= 0)
        f.bodies.template expand_force<n>();
    else
        f.force[n] = f.spring * f.depth[n] + f.damper * (n + 1) * f.depth[n + 1];
}

// Adds the acceleration of a pair, of order n, to the terms of order n + 2 of its bodies. `share`: unit²/((n+1)(n+2)).
template <int n>
void add_accelerations(Path* paths, Contact& f, double share) {
    expand_distance<n + 1>(paths, f);
    if (!f.closed) return expand_force<n>(f);
    if (f.second < 0) {
        expand_force<n>(f);
        paths[f.first][n + 2][f.axis] += (share * f.per_mass[0]) * (f.side * f.force[n]);
        return;
    }
    const Four relative_acceleration = f.bodies.template relative_acceleration<n>();
    paths[f.first][n + 2] -= (share * f.per_mass[0]) * relative_acceleration;
    paths[f.second][n + 2] += (share * f.per_mass[1]) * relative_acceleration;
}

// Expands all terms from order n + 2 on.
template <int n>
void expand_from(Path* paths, Contact* contacts, int count, double unit) {
    if constexpr (n + 2 > order) {
        for (int c = 0; c < count; ++c) {
            expand_distance<n + 1>(paths, contacts[c]);
            expand_force<n>(contacts[c]);
        }
    } else {
        const double share = unit * unit / ((n + 1) * (n + 2));
        for (int c = 0; c < count; ++c) add_accelerations<n>(paths, contacts[c], share);
        expand_from<n + 1>(paths, contacts, count, unit);
    }
}

// Expands the series of all bodies and contacts. Their first two terms, positions and velocities, are given.
inline void expand(void* paths, int bodies, void* contacts, int n, const double* gravity, double unit) {
    Path* const path = static_cast<Path*>(paths);
    Contact* const first = static_cast<Contact*>(contacts);
    const Four fall = load_four(gravity) * (0.5 * unit * unit);
    for (Path* x = path; x != path + bodies; ++x) {
        (*x)[2] = fall;
        HL_UNROLL
        for (std::size_t k = 3; k < length; ++k) (*x)[k] = Four{};
    }
    for (int c = 0; c < n; ++c) {
        first[c].force[order] = first[c].bodies.force[order] = 0.0;
        expand_distance<0>(path, first[c]);
    }
    expand_from<0>(path, first, n, unit);
}

// Largest absolute component of the last two terms of the bodies in contact.
inline double last_terms(const void* paths, const int* body_order, int in_contact) {
    Four most{};
    for (int i = 0; i < in_contact; ++i) {
        const Path& x = static_cast<const Path*>(paths)[body_order[i]];
        for (std::size_t k = order - 1; k <= order; ++k)
            most = math::max<Four>(most, math::max<Four>(x[k], -x[k]));
    }
    return math::max(math::max(most[0], most[1]), most[2]);
}

inline void travels(const void* paths, const int* body_order, int in_contact, int bodies, double at,
                    double* out) {
    const Path* const path = static_cast<const Path*>(paths);
    for (int i = 0; i < bodies; ++i) {
        const int body = body_order[i];
        out[body] = i < in_contact ? travel(path[body], at) : travel<2>(path[body], at);
    }
}

// Adds the integrals from 0 to t of a closed contact, by Gauss-Legendre quadrature: γ ∫ (dd/dt)² dt to the dissipated
// energy and, between two bodies, ∫ F/d r⊗r dt to the virial, with F = k (l − d) − γ dd/dt. `unit`: of time [s]. The
// integrands oscillate through less than one period in a step, and the error is far below rounding.
inline void add_integrals(const Contact& f, double t, double unit, double* dissipated, double* virial) {
    using quadrature::Eight, quadrature::node, quadrature::weight;
    const Terms& d = f.second < 0 ? f.depth : f.bodies.distance;
    const Eight at = t * node;
    Eight value = Eight{} + d[order], slope{};
    for (int k = order - 1; k >= 0; --k) {
        slope = slope * at + value;
        value = value * at + d[static_cast<std::size_t>(k)];
    }
    const auto integral = [t](const Eight& x) {
        double sum = 0.0;
        for (int i = 0; i < 8; ++i) sum += x[i];
        return t * sum;
    };
    *dissipated += f.damper * integral(weight * (slope * slope));
    if (f.second < 0) return;
    Eight r[3];
    for (int a = 0; a < 3; ++a) r[a] = Eight{} + f.bodies.between[order][a];
    for (std::size_t k = order; k-- > 0;)
        for (int a = 0; a < 3; ++a) r[a] = r[a] * at + f.bodies.between[k][a];
    const Eight force = f.spring * (f.contact_distance - value) - f.damper * slope;
    const Eight pressing = unit * weight * force / value;
    for (std::size_t c = 0; c < SymmetricTensor::size; ++c)
        virial[c] += integral(pressing * r[SymmetricTensor::row[c]] * r[SymmetricTensor::column[c]]);
}

// Advances the state to a time within the step.
inline void move(const void* paths, const int* body_order, int in_contact, int bodies, const void* contacts,
                 int n, double at, double unit, const double* gravity, double* places, double* dissipated,
                 double* virial, double* chord_deviations) {
    const Path* const path = static_cast<const Path*>(paths);
    for (int c = 0; c < n; ++c) {
        const Contact& f = static_cast<const Contact*>(contacts)[c];
        if (f.closed) add_integrals(f, at, unit, dissipated, virial);
    }
    const Four fall = load_four(gravity) * (unit * unit);
    const double per_unit = 1.0 / unit;
    for (int i = 0; i < bodies; ++i) {
        const int body = body_order[i];
        if (chord_deviations)
            chord_deviations[body] = i < in_contact ? chord_deviation(path[body], at, fall) : 0.0;
        const State s = i < in_contact ? state(path[body], at) : state<2>(path[body], at);
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
