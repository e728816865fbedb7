// Present states of isolated contacts under a linear law, as power series in time, in lanes of several contacts.
//
// In the plane of the approach, with the distance at the start and the time t from there as units, r(0) = (1, 0) and
//   d² = r·r,   F = k (l − d) − γ dd/dt,   w = F/d,   r'' = w r.
// Each order of a product of two series is a convolution sum. z = d − x is computed from z (d + x) = y², without
// cancellation. All series are evaluated at time 1. A step covers half of a contact: from touch, or back from the end
// of the force.
#pragma once
#include <cstddef>

#include "gauss_legendre.hpp"
#include "interface.hpp"

namespace hardlimit::boxes::open_contacts {

// At time 1.57, the middle of an undamped contact in units of 1/ω, the last term is 4e-15 of the greatest compression.
inline constexpr int order = 20;
inline constexpr int together = 4;  // terms of a sum between two branches

// Terms of a series. Those of negative order are 0, and so are those not known yet.
template <class Real>
struct Terms {
    Real of[together + order + together] = {};

    HL_FN_INLINE Real& operator[](int n) { return of[together + n]; }
    HL_FN_INLINE const Real& operator[](int n) const { return of[together + n]; }
};

template <class Real>
struct Planar {
    Terms<Real> x, y, z, d, w;
    Terms<Real> both;  // x + d

    HL_FN_INLINE void set_distance(int n, const Real& difference) {
        z[n] = difference;
        d[n] = x[n] + difference;
        both[n] = x[n] + d[n];
    }
    // Expands all series up to order 20 from order 1 of x and y, and order 0 of w.
    void expand(const Real& spring, const Real& damper) {
        x[0] = Real{} + 1.0;
        set_distance(0, Real{});
        set_distance(1, Real{});
        HL_ROLL
        for (int n = 0; n < order; ++n) {
            Real wd{}, wx = w[0] * x[n], wy = w[0] * y[n], yy{}, zb{};
            HL_ROLL
            for (int from = 1; from <= n; from += together) {
                HL_UNROLL
                for (int k = 0; k < together; ++k) {
                    const int j = from + k;
                    wd += d[n - j] * w[j], wx += x[n - j] * w[j], wy += y[n - j] * w[j];
                    yy += y[n + 1 - j] * y[j], zb += both[n + 1 - j] * z[j];
                }
            }
            if (n > 0) {
                set_distance(n + 1, 0.5 * (yy - zb));
                w[n] = -(spring * d[n] + damper * ((n + 1) * d[n + 1]) + (w[0] * d[n] + wd));
                wx += w[n];
            }
            if (n + 2 > order) break;
            const double share = 1.0 / ((n + 1) * (n + 2));
            x[n + 2] = share * wx;
            y[n + 2] = share * wy;
        }
    }
};

template <class Real>
void solve_lanes(hardlimit_abi::OpenContact* contacts, int count) {
    using Contact = hardlimit_abi::OpenContact;
    const auto load = [&](double Contact::* field) {
        Real r;
        for (int i = 0; i < Lanes<Real>::count; ++i) r[i] = contacts[i < count ? i : 0].*field;
        return r;
    };
    const auto store = [&](double Contact::* field, const Real& r) {
        for (int i = 0; i < count; ++i) contacts[i].*field = r[i];
    };
    Planar<Real> p;
    p.x[1] = load(&Contact::radial_speed), p.y[1] = load(&Contact::tangential_speed);
    p.w[0] = load(&Contact::force);
    p.expand(load(&Contact::spring), load(&Contact::damper));

    Real x{}, y{}, z{}, vx{}, vy{}, rate{}, last{};
    constexpr int nodes = 8;
    Real rates[3][nodes] = {};
    HL_ROLL
    for (int n = order; n >= 1; --n) {
        const Real slope[3] = {n * p.x[n], n * p.y[n], n * p.d[n]};
        x += p.x[n], y += p.y[n], z += p.z[n];
        vx += slope[0], vy += slope[1], rate += slope[2];
        HL_UNROLL
        for (int c = 0; c < 3; ++c) {
            HL_UNROLL
            for (int i = 0; i < nodes; ++i) rates[c][i] = rates[c][i] * quadrature::node[i] + slope[c];
        }
    }
    Real xx{}, xy{}, yy{}, dd{};  // ∫ of products of rates
    HL_UNROLL
    for (int i = 0; i < nodes; ++i) {
        const double weight = quadrature::weight[i];
        const Real wx = weight * rates[0][i], wy = weight * rates[1][i];
        xx += wx * rates[0][i], xy += wx * rates[1][i], yy += wy * rates[1][i];
        dd += (weight * rates[2][i]) * rates[2][i];
    }
    for (int n = order - 1; n <= order; ++n)
        for (const Real& term : {p.x[n], p.y[n], p.d[n]}) last = math::max<Real>(last, math::abs<Real>(term));
    store(&Contact::stretched, x + z);
    x += 1.0;
    store(&Contact::x, x);
    store(&Contact::y, y);
    store(&Contact::rate, rate);
    store(&Contact::speed_x, vx);
    store(&Contact::speed_y, vy);
    store(&Contact::rate_square, dd);
    store(&Contact::virial_xx, (x * vx - p.x[1]) - xx);
    store(&Contact::virial_xy, y * vx - xy);
    store(&Contact::virial_yy, y * vy - yy);
    store(&Contact::last_term, last);
}

// Solves n contacts.
template <class Real>
void solve(hardlimit_abi::OpenContact* contacts, std::size_t n) {
    constexpr std::size_t lanes = Lanes<Real>::count;
    for (std::size_t i = 0; i < n; i += lanes)
        solve_lanes<Real>(contacts + i, static_cast<int>(math::min(lanes, n - i)));
}

}  // namespace hardlimit::boxes::open_contacts
