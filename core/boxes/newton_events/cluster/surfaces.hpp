// Friction of the pairs of a cluster, in space. The equations are those of one contact (binary_contact/
// turning_motion.hpp): with arms a_i = R_i r/(R_i + R_j), at a wall R, the surfaces move at
//   g = v_j − v_i − (a_i ω_i + a_j ω_j)×n
// relative to each other, the tangential force on the first body is Φ, on the second −Φ, and both get the torque
// a n×Φ. Tangential vectors turn with n without twist: a vector x that keeps still in the surface changes at
// −(x·ṅ) n.
//
// A pair keeps four components. While the surfaces stick they are T/a^m, whose derivative is not singular, and 0. While
// they slip they are a tangential vector e and z: Φ = μ F_n f, where f is e turned about n by 2 arctan z. z becomes 0
// after each step, and is exactly 0 in two dimensions.
#pragma once
#include "state.hpp"

namespace hardlimit::boxes {

inline Vector3 operator+(const Vector3& a, const Vector3& b) {
    return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
inline Vector3 operator-(const Vector3& a, const Vector3& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline Vector3 operator*(double x, const Vector3& a) { return {x * a[0], x * a[1], x * a[2]}; }
inline double length(const Vector3& a) { return math::sqrt(dot(a, a)); }
inline Vector3 vector_at(const double* x) { return {x[0], x[1], x[2]}; }
inline double whole_power(double x, int n) {
    double product = 1.0;
    for (int i = 0; i < n; ++i) product *= x;
    return product;
}

// A closed pair with friction at one state.
template <FrictionalLaw Law>
class SurfacePair {
public:
    static constexpr int p = Law::onset_power;
    static constexpr int elastic_power = p * Law::record.powers.elastic / 4;
    static constexpr int damping_power = p * Law::record.powers.damping / 4;

    ContactGeometry g;
    double s, force;  // F_n
    double first_arm, second_arm = 0.0;
    Vector3 spin, slip, turn;  // Σ a ω [m/s], g, dn/dt

    SurfacePair(const Snapshot<Law>& now, int pair)
        : SurfacePair(now, pair, now.geometry(now.network.pairs[pair])) {}
    SurfacePair(const Snapshot<Law>& now, int pair, const ContactGeometry& geometry)
        : g(geometry), now_(now), q_(now.network.pairs[pair]), pair_(pair) {
        s = now.depth_root(pair, g);
        force = q_.law.force(s, g.rate);
        const double *va = now.y + now.layout.velocity(q_.first), *wa = now.y + now.layout.spin(q_.first);
        Vector3 v;
        if (is_wall()) {
            first_arm = now.network.members[q_.first].radius;
            v = -1.0 * vector_at(va);
            v[static_cast<std::size_t>(q_.axis)] += now.network.wall_velocity(q_, now.time());
            spin = first_arm * vector_at(wa);
        } else {
            const double ratio = g.distance / q_.contact_distance;
            first_arm = now.network.members[q_.first].radius * ratio;
            second_arm = now.network.members[q_.second].radius * ratio;
            v = vector_at(now.y + now.layout.velocity(q_.second)) - vector_at(va);
            if (q_.image_moves) v = v + q_.image_velocity;
            spin = first_arm * vector_at(wa) + second_arm * vector_at(now.y + now.layout.spin(q_.second));
        }
        const Vector3 across = v + g.rate * g.normal;
        slip = across - cross(spin, g.normal);
        turn = is_wall() ? Vector3{} : (1.0 / g.distance) * across;
        if (q_.surfaces.slips) direction_ = direction_of_slip();
    }

    int pair() const { return pair_; }

    bool is_wall() const { return q_.second < 0; }
    const FrictionTerms& friction() const { return q_.law.friction; }
    bool has_spring() const { return friction().stiffness.factor > 0.0; }
    bool limits_spring() const { return friction().limit == SlipLimit::spring && has_spring(); }
    bool never_slips() const { return friction().coefficient == math::infinity; }
    double limit() const { return friction().coefficient * force; }  // μ F_n
    double damping() const { return term(friction().damping); }      // γ_t
    int history() const {
        return q_.surfaces.unloads ? friction().unloading : friction().loading;  // m
    }
    double radius_power() const { return whole_power(s, p * history() / 2); }  // a^m
    // The power of s in the derivative of T/a^m.
    int memory_power() const { return p * friction().stiffness.power / 4 - p * history() / 2; }

    // T of surfaces that stick, direction of Φ of surfaces that slip.
    Vector3 spring() const { return radius_power() * memory(); }
    const Vector3& direction() const { return direction_; }
    // Φ
    Vector3 push() const {
        if (q_.surfaces.slips) return limit() * direction();
        return (has_spring() ? spring() : Vector3{}) + damping() * slip;
    }
    // T
    Vector3 elastic() const {
        if (!has_spring()) return {};
        if (!q_.surfaces.slips) return spring();
        return limits_spring() ? push() : push() - damping() * slip;
    }
    // What Coulomb's law limits, of surfaces that stick.
    Vector3 limited() const { return limits_spring() ? spring() : push(); }
    // Positive until surfaces that stick begin to slip.
    double grip() const { return limit() - length(limited()); }

    // h along f, h along n×f, and h·f − μ dF_n/dτ, positive until surfaces that slip begin to stick; dy: derivative of
    // the state.
    struct Drive {
        double along, across, excess, growth;  // growth: μ dF_n/dτ
        Vector3 h;
    };
    // dg/dτ in the surface
    Vector3 slip_change(const double* dy) const {
        const StateLayout& at = now_.layout;
        const double clock = dy[at.time()];
        Vector3 dv = -1.0 * vector_at(dy + at.velocity(q_.first)),
                dw = first_arm * vector_at(dy + at.spin(q_.first));
        if (is_wall()) {
            dv[static_cast<std::size_t>(q_.axis)] += clock * now_.network.wall_acceleration(q_, now_.time());
        } else {
            dv = dv + vector_at(dy + at.velocity(q_.second));
            dw = dw + second_arm * vector_at(dy + at.spin(q_.second)) - (clock * g.rate / g.distance) * spin;
        }
        return in_surface(dv + (clock * g.rate) * turn - cross(dw, g.normal) - clock * cross(spin, turn));
    }
    Drive drive(const double* dy) const {
        const StateLayout& at = now_.layout;
        const double clock = dy[at.time()], viscous = damping();
        Vector3 dv = -1.0 * vector_at(dy + at.velocity(q_.first));
        if (is_wall())
            dv[static_cast<std::size_t>(q_.axis)] += clock * now_.network.wall_acceleration(q_, now_.time());
        else
            dv = dv + vector_at(dy + at.velocity(q_.second));
        const double bend = is_wall() ? 0.0 : dot(dv, g.normal) + clock * dot(turn, turn) * g.distance;
        const double rate_slope = is_wall() ? -dot(dv, g.normal) : -bend;
        const double stretch = p * math::power<p - 1>(s);  // dξ/ds
        const double root_slope = q_.rooted       ? dy[at.root(pair_)]
                                  : stretch > 0.0 ? clock * g.rate / stretch
                                                  : 0.0;
        Vector3 h = (clock * term(friction().stiffness)) * slip;
        if (!limits_spring() && viscous > 0.0) {
            h = h + viscous * slip_change(dy);
            if (const int power = p * friction().damping.power / 4; power > 0)
                h = h + (friction().damping.factor * power * whole_power(s, power - 1) * root_slope) * slip;
        }
        if (history() > 0 && s > 0.0) h = h + (0.5 * history() * p * root_slope / s) * elastic();
        double stiff = elastic_power * elastic_force(elastic_power - 1);
        if constexpr (damping_power > 0)
            stiff +=
                damping_power * q_.law.coefficients().damping * math::power<damping_power - 1>(s) * g.rate;
        const double growth =
            friction().coefficient *
            (stiff * root_slope + q_.law.coefficients().damping * math::power<damping_power>(s) * rate_slope);
        const Vector3 f = direction();
        const double along = dot(h, f);
        return {along, dot(h, cross(g.normal, f)), along - growth, growth, h};
    }
    // Positive until surfaces that slip begin to stick.
    double slipping(const double* dy) const {
        return has_spring() ? drive(dy).excess : damping() * length(slip) - limit();
    }
    // −(x·ṅ) n, the rate of a vector that keeps still in the surface.
    Vector3 transport(const Vector3& x) const { return -dot(x, turn) * g.normal; }
    Vector3 in_surface(const Vector3& x) const { return x - dot(x, g.normal) * g.normal; }
    Vector3 memory() const { return vector_at(memory_at()); }

    static Vector3 unit(const Vector3& x) {
        const double size = length(x);
        return size > 0.0 ? (1.0 / size) * x : Vector3{};
    }

private:
    const Snapshot<Law> now_;
    const ContactPair<Law>& q_;
    const int pair_;
    Vector3 direction_{};

    Vector3 direction_of_slip() const {
        if (!has_spring()) return unit(slip);
        const double z = memory_at()[3];
        const Vector3 e = in_surface(memory());
        if (q_.surfaces.frozen) return e;
        const Vector3 f = unit(e);
        if (z == 0.0) return f;
        return (1.0 / (1.0 + z * z)) * ((1.0 - z * z) * f + (2.0 * z) * cross(g.normal, f));
    }
    const double* memory_at() const { return now_.y + now_.layout.surface(pair_); }
    double term(const PowerTerm& t) const { return t.factor * whole_power(s, p * t.power / 4); }
    double elastic_force(int power) const { return q_.law.coefficients().elastic * whole_power(s, power); }
};

}  // namespace hardlimit::boxes
