// Equations of the isolated contact of two spheres with friction (turning_contact.hpp), in a frame that the line of
// centres n carries along without twist (parallel transport). With r the distance of the centres, l that at touch,
// ξ = l − r, w the tangential velocity of the centres, Ω = (R_i ω_i + R_j ω_j)/l, u = Ω×n, g = w − r u the velocity of
// the surfaces and −Φ the tangential force on the second body, the components in this frame obey
//   ξ̈ = −F_n/m − w²/r,   ẇ = −Φ/m + (ξ̇/r) w,   u̇ = c r Φ/(m l²) − (Ω_n/r) w×n,   Ω̇_n = (u_1 w_2 − u_2 w_1)/r,
// c = m (R_i²/I_i + R_j²/I_j). At a wall 1/r is zero, and r in g is the radius, as is l. The frame turns at
// (−w_2, w_1, 0)/r.
//
// Surfaces that stick: Φ = T + γ_t g, dT/dt = k_t g + m T (da/dt)/a (friction.hpp). The integrated variable is
// T/a^m, which has no singular derivative. Surfaces that slip: Φ = μ F_n f. With the rate h of T + γ_t g without slip,
//   df/dt = h_⊥/(μ F_n),   rate of slip λ = (h·f − μ dF_n/dt)/k_t >= 0   (γ_t = 0 under SlipLimit::spring).
// f is written by the tangent z of half its angle to a direction that is kept during a step: no trigonometry, and z = 0
// exactly if the motion is in a plane.
//
// Units and the smooth variables σ, τ: planar_contact.hpp. Forces are in m V²/L, w in V, u and Ω in V/l.
#pragma once
#include "../../contact/friction.hpp"
#include "../common/triangle.hpp"
#include "planar_contact.hpp"

namespace hardlimit::boxes {

// Two bodies at the instant of touch. Velocities and spin are those of the second body relative to the first.
struct TurningApproach {
    double effective_mass;    // m_i m_j/(m_i + m_j) [kg]
    double distance;          // of the centres [m]; infinite at a wall
    double arm;               // the same [m]; at a wall the radius
    double rotational_ratio;  // effective_mass (R_i²/I_i + R_j²/I_j)
    Vector3 normal;           // unit vector from the first body to the second
    Vector3 velocity;         // [m/s]
    Vector3 spin;             // (R_i ω_i + R_j ω_j)/(R_i + R_j), at a wall ω [rad/s]
};

// A vector in the tangent plane.
struct Tangential {
    double first, second;

    double length() const { return math::sqrt(first * first + second * second); }
    friend Tangential operator+(Tangential a, Tangential b) {
        return {a.first + b.first, a.second + b.second};
    }
    friend Tangential operator-(Tangential a, Tangential b) {
        return {a.first - b.first, a.second - b.second};
    }
    friend Tangential operator*(double x, Tangential a) { return {x * a.first, x * a.second}; }
    friend double operator*(Tangential a, Tangential b) { return a.first * b.first + a.second * b.second; }
    Tangential turned() const { return {-second, first}; }  // by a right angle about the normal
};

template <class Normal>
class TurningMotion {
public:
    static constexpr int p = Normal::onset_power;
    static constexpr int elastic_power = p * Normal::record.powers.elastic / 4;  // of σ in the force
    static constexpr int damping_power = p * Normal::record.powers.damping / 4;
    enum : int {
        root_depth,            // σ
        rate,                  // U
        across,                // w, two components
        surface = across + 2,  // u, two components
        twist = surface + 2,   // Ω_n
        memory,                // T/a^m, two components; while the surfaces slip z and 0
        turn = memory + 2,     // quaternion of the frame; at a wall 1, ∫w dT and 0
        coupled = turn + 4,
        time = coupled,  // T; this and the following are integrals on which nothing depends
        loss,            // by damping of the normal force
        work,            // ∫Φ·g dT
        stuck,           // part of it while the surfaces stick
        damped,          // part of that by the tangential damping
        dimension
    };

    bool slips = false;
    bool follows = false;            // T follows its limit without slip
    bool frozen = false;             // f no longer matters
    bool unloads = false;            // ξ falls
    Tangential reference{1.0, 0.0};  // direction of f for z = 0

    TurningMotion(const WithFriction<Normal>& law, const TurningApproach& touch)
        : TurningMotion(law, touch, PlanarMotion<Normal>(law, approach_of(touch))) {}
    TurningMotion(const WithFriction<Normal>& law, const TurningApproach& touch,
                  const PlanarMotion<Normal>& units)
        : units_(units), touch_(touch), friction_(law.friction) {
        const Coefficients normal = law.coefficients();
        const double length = units_.length, speed = units_.speed;
        elastic_ = units_.force_unit * normal.elastic * math::power<elastic_power>(units_.root);
        damping_ = units_.force_unit * speed * normal.damping * math::power<damping_power>(units_.root);
        stiffness_ = units_.force_unit * length * in_units(friction_.stiffness);
        dashpot_ = units_.force_unit * speed * in_units(friction_.damping);
        stiffness_power_ = p * friction_.stiffness.power / 4;
        dashpot_power_ = p * friction_.damping.power / 4;
        set_frame();
    }

    static Approach approach_of(const TurningApproach& a) {
        const double normal = -dot(a.velocity, a.normal);
        const Vector3 across = cross(a.normal, a.velocity);
        return {a.effective_mass, a.distance, normal, math::sqrt(dot(across, across))};
    }
    // Whether the powers of the friction are whole in σ and its history stays bounded.
    bool solvable() const {
        const auto whole = [](const PowerTerm& t) { return p * t.power % 4 == 0 && t.power >= 0; };
        const bool loads = friction_.loading > friction_.unloading;
        const int most = loads ? friction_.loading : friction_.unloading;
        if (most > 0 && dashpot_power_ == 0 && dashpot_ > 0.0)
            return false;  // T > 0 where the radius is zero
        return whole(friction_.stiffness) && whole(friction_.damping) && p * most % 2 == 0 &&
               stiffness_power_ + p - 1 >= p * most / 2;
    }

    const PlanarMotion<Normal>& units() const { return units_; }
    // Factors of the powers of σ in the forces.
    struct Constants {
        double elastic, damping, stiffness, dashpot;
    };
    Constants constants() const { return {elastic_, damping_, stiffness_, dashpot_}; }
    const TurningApproach& touch() const { return touch_; }
    const FrictionTerms& friction() const { return friction_; }
    bool is_wall() const { return touch_.distance == math::infinity; }
    bool has_spring() const { return stiffness_ > 0.0; }
    double time_unit() const { return units_.length / units_.speed; }

    // The state at touch, before it is known whether the surfaces stick.
    void start(double* y) const {
        for (int i = 0; i < dimension; ++i) y[i] = 0.0;
        const double per_speed = 1.0 / units_.speed, spin = touch_.arm * per_speed;
        const Vector3 u = cross(touch_.spin, touch_.normal);
        y[rate] = -dot(touch_.velocity, touch_.normal) * per_speed;
        y[across] = dot(touch_.velocity, axes_[0]) * per_speed;
        y[across + 1] = without_rounding(dot(touch_.velocity, axes_[1]) * per_speed, y[across]);
        y[surface] = dot(u, axes_[0]) * spin;
        y[surface + 1] = without_rounding(dot(u, axes_[1]) * spin, y[surface]);
        y[twist] = dot(touch_.spin, touch_.normal) * spin;
        y[twist] = without_rounding(y[twist], math::sqrt(dot(touch_.spin, touch_.spin)) * spin);
        y[turn] = 1.0;
    }

    // A state within the contact instead (WithinContact).
    void start_within(double* y, double compression, double rate_now, bool slide, const Vector3& held) {
        start(y);
        y[root_depth] = onset_root<p>(compression / units_.length);
        y[rate] = rate_now / units_.speed;
        const Tangential part{dot(held, axes_[0]), dot(held, axes_[1])};
        slips = slide;
        if (slips)
            reference = part;
        else
            remember(y, units_.force_unit * part);
    }

    // What the equations need at one state.
    struct Now {
        double clock, width, curve;  // dT/dτ, r/l, L/r
        double elastic, normal;      // F_n without and with damping
        Tangential w, u, g;
    };
    Now now(const double* y) const {
        Now at;
        const double s = y[root_depth];
        at.clock = math::power<p - 1>(s);
        at.width = 1.0 - units_.ratio * (at.clock * s);
        at.curve = units_.ratio / at.width;
        at.elastic = elastic_ * math::power<elastic_power>(s);
        at.normal = at.elastic + damping_ * math::power<damping_power>(s) * y[rate];
        at.w = {y[across], y[across + 1]};
        at.u = {y[surface], y[surface + 1]};
        at.g = at.w - at.width * at.u;
        return at;
    }
    double limit(const Now& at) const { return friction_.coefficient * at.normal; }       // μ F_n
    double dashpot(double s) const { return dashpot_ * whole_power(s, dashpot_power_); }  // γ_t
    bool limits_spring() const { return friction_.limit == SlipLimit::spring && has_spring(); }
    int history() const { return unloads ? friction_.unloading : friction_.loading; }  // m

    // T of surfaces that stick.
    Tangential spring(const double* y) const {
        return whole_power(y[root_depth], p * history() / 2) * Tangential{y[memory], y[memory + 1]};
    }
    // Direction of the force of surfaces that slip.
    Tangential direction(const double* y, const Now& at) const {
        if (!has_spring()) {
            const double speed = at.g.length();
            return speed > 0.0 ? (1.0 / speed) * at.g : Tangential{0.0, 0.0};
        }
        const double z = y[memory], inverse = 1.0 / (1.0 + z * z);
        return inverse * ((1.0 - z * z) * reference + (2.0 * z) * reference.turned());
    }
    // Φ, the tangential force on the first body.
    Tangential force(const double* y, const Now& at) const {
        if (slips) return limit(at) * direction(y, at);
        return spring(y) + (follows ? damping_part(y, at) : 1.0) * dashpot(y[root_depth]) * at.g;
    }
    // The power of σ in dT/dτ.
    int memory_power() const { return stiffness_power_ + p - 1 - p * history() / 2; }

    // Energy of the spring: T²/(2k_t), and if k_t is not constant the work that it took while the surfaces stuck.
    double spring_energy(const double* y) const {
        const Now at = now(y);
        if (!has_spring()) return 0.0;
        if (stiffness_power_ > 0 || friction_.loading > 0 || friction_.unloading > 0)
            return y[stuck] - y[damped];
        Tangential elastic = spring(y);
        if (slips) elastic = force(y, at);
        if (slips && !limits_spring()) elastic = elastic - dashpot(y[root_depth]) * at.g;
        return 0.5 * (elastic * elastic) / stiffness_;
    }

    // What Coulomb's law limits, of surfaces that stick.
    Tangential limited(const double* y, const Now& at) const {
        return limits_spring() ? spring(y) : force(y, at);
    }

    void operator()(const double* y, double* dy) const {
        const Now at = now(y);
        const Tangential push = force(y, at);
        move(y, at, push, dy);
        if (!slips) {
            const double stiffness =
                has_spring() ? stiffness_ * whole_power(y[root_depth], memory_power()) : 0.0;
            dy[memory] = stiffness * at.g.first;
            dy[memory + 1] = stiffness * at.g.second;
            return;
        }
        dy[memory] = dy[memory + 1] = 0.0;
        if (!has_spring() || frozen) return;
        const Drive drive = slip_drive(y, at, dy);
        const double z = y[memory];
        if (drive.across != 0.0) dy[memory] = 0.5 * (1.0 + z * z) * drive.across / limit(at);
    }

    // The rates of surfaces that slip, except that of the direction, and what turns the direction.
    struct Drive;
    Drive slip_rates(const double* y, double* dy) const {
        const Now at = now(y);
        move(y, at, force(y, at), dy);
        dy[memory] = dy[memory + 1] = 0.0;
        return slip_drive(y, at, dy);
    }

    // h along f and perpendicular to it, and h·f − μ dF_n/dτ = k_t λ, of surfaces that slip; dy: the rates of the rest.
    struct Drive {
        double along, across, excess;
    };
    Drive slip_drive(const double* y, const Now& at, const double* dy) const {
        const double s = y[root_depth];
        const Tangential f = direction(y, at);
        const Tangential accelerated = Tangential{dy[across], dy[across + 1]} -
                                       at.width * Tangential{dy[surface], dy[surface + 1]} +
                                       (units_.ratio * at.clock * y[rate]) * at.u;
        Tangential h = (stiffness_ * whole_power(s, stiffness_power_) * at.clock) * at.g;
        Tangential elastic = limit(at) * f;  // T
        if (!limits_spring() && dashpot_ > 0.0) {
            const double damping = dashpot(s);
            elastic = elastic - damping * at.g;
            h = h + damping * accelerated;
            if (dashpot_power_ > 0)
                h = h +
                    (dashpot_ * dashpot_power_ * whole_power(s, dashpot_power_ - 1) * dy[root_depth]) * at.g;
        }
        if (history() > 0 && s != 0.0) h = h + (0.5 * history() * y[rate] / s) * elastic;
        const double along = h * f;
        return {along, h * f.turned(), along - friction_.coefficient * normal_growth(y, dy)};
    }

    // Whether everything stays in the plane of the normal and the first tangent.
    bool is_planar(const double* y) const {
        const double aside = slips && has_spring() ? reference.second : y[memory + 1];
        return y[across + 1] == 0.0 && y[surface + 1] == 0.0 && y[twist] == 0.0 && aside == 0.0;
    }

    // Positive until the surfaces that stick begin to slip.
    double grip(const double* y) const {
        const Now at = now(y);
        return limit(at) - limited(y, at).length();
    }
    // Positive until the surfaces that slip begin to stick.
    double slipping(const double* y) const {
        const Now at = now(y);
        if (!has_spring()) return dashpot(y[root_depth]) * at.g.length() - limit(at);
        double dy[dimension];
        move(y, at, force(y, at), dy);
        return slip_drive(y, at, dy).excess;
    }

    // Part of the damping with which T just follows its limit without slip. With none of it the surfaces would stick
    // and with all of it slip; codes alternate from step to step (A. F. Filippov, Differential Equations with
    // Discontinuous Righthand Sides (1988)). Infinite if they stick with all of it. Only under SlipLimit::spring.
    double damping_part(const double* y, const Now& at) const {
        constexpr double pull_back = 5.0;
        if (frozen) return kept_part_;
        const Tangential elastic = spring(y), viscous = dashpot(y[root_depth]) * at.g;
        double dy[dimension], near[dimension], slope[2];
        for (int i = 0; i < 2; ++i) {
            move(y, at, elastic + double(i) * viscous, dy);
            const Tangential grown = stiffness_ * whole_power(y[root_depth], memory_power()) * at.g;
            dy[memory] = grown.first;
            dy[memory + 1] = grown.second;
            const double left = limit(at) / math::abs(friction_.coefficient * normal_growth(y, dy));
            const double difference = math::min(3e-4, 0.01 * left);
            slope[i] = 0.0;
            for (const int k : {-2, -1, 1, 2}) {
                for (int c = 0; c < memory + 2; ++c) near[c] = y[c] + k * difference * dy[c];
                slope[i] += (k % 2 == 0 ? -0.5 * k : 8.0 * k) / (12.0 * difference) * yielding(near);
            }
        }
        const double gain = slope[1] - slope[0];
        return slope[1] > 0.0 && gain > 0.0 ? (-slope[0] - pull_back * yielding(y)) / gain : math::infinity;
    }

    // From now on neither the direction of slip nor this part matters.
    void freeze(const double* y) {
        if (follows && !frozen) kept_part_ = math::clamp(damping_part(y, now(y)), 0.0, 1.0);
        frozen = true;
    }

    // Changes from sticking to slipping at this state, and back. T is continuous.
    void begin_slip(double* y, Tangential along) {
        const double length = along.length();
        slips = true;
        follows = false;
        reference = length > 0.0 ? (1.0 / length) * along : Tangential{1.0, 0.0};
        y[memory] = y[memory + 1] = 0.0;
    }
    void begin_stick(double* y) {
        const Now at = now(y);
        Tangential elastic = limit(at) * direction(y, at);
        if (!limits_spring()) elastic = elastic - dashpot(y[root_depth]) * at.g;
        slips = false;
        remember(y, has_spring() ? elastic : Tangential{0.0, 0.0});
        follows = limits_spring() && dashpot_ > 0.0 && damping_part(y, at) < 1.0;
    }
    // The compression begins to fall: the history follows another power of the contact radius.
    void begin_unloading(double* y) {
        const Tangential elastic = spring(y);
        unloads = true;
        if (!slips) remember(y, elastic);
    }
    // Keeps z small.
    void renew_reference(double* y) {
        if (!slips || y[memory] == 0.0) return;
        reference = direction(y, now(y));
        reference = (1.0 / reference.length()) * reference;
        y[memory] = 0.0;
    }

    // Whether the surfaces slip from touch on; prepares the state. Compares the forces to leading order in ξ.
    void choose_at_touch(double* y) {
        const Now at = now(y);
        const double g = at.g.length(), least = 1e-30;  // ξ, in units of L
        if (friction_.coefficient == math::infinity || g == 0.0) return;
        const auto power = [&](double exponent) { return math::pow(least, exponent); };
        const double normal = elastic_ * power(elastic_power / double(p)) +
                              damping_ * power(damping_power / double(p)) * y[rate];
        const double exponent = stiffness_power_ / double(p) + 1.0;
        const double elastic =
            stiffness_ * power(exponent) / (exponent - 0.5 * friction_.loading) * (g / y[rate]);
        const double viscous = limits_spring() ? 0.0 : dashpot_ * power(dashpot_power_ / double(p)) * g;
        if (elastic + viscous <= friction_.coefficient * normal) return;
        begin_slip(y, at.g);
        if (!has_spring()) return;
        double near[dimension];
        for (int i = 0; i < dimension; ++i) near[i] = y[i];
        if (p > 1) near[root_depth] = 1e-6;  // at touch all rates in τ are zero
        if (at.normal == 0.0 && (p == 1 || dashpot_power_ == 0)) align(near);
        if (slipping(near) > 0.0) return;
        begin_slip(y, -1.0 * at.g);  // a history that grows with the radius may drive the surfaces
        if (p > 1 && slipping(near) > 0.0) return;
        begin_slip(y, at.g);
        begin_stick(near);
        y[memory] = near[memory];
        y[memory + 1] = near[memory + 1];
    }

    // Axes at touch: two tangents and the normal.
    const Vector3 (&axes() const)[3] { return axes_; }
    // Components in the frame as a vector [in the unit of the components].
    Vector3 in_space(const double* y, double first, double second, double along) const {
        Vector3 c{first, second, along};
        if (!is_wall()) {
            double q[4];
            for (int i = 0; i < 4; ++i) q[i] = y[turn + i];
            const double square = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
            const Vector3 axis{q[1], q[2], q[3]}, once = cross(axis, c), twice = cross(axis, once);
            for (std::size_t k = 0; k < 3; ++k) c[k] += 2.0 / square * (q[0] * once[k] + twice[k]);
        }
        return from_touch(c);
    }
    // n less the normal at touch, without cancellation; at a wall 0.
    Vector3 normal_change(const double* y) const {
        if (is_wall()) return {0.0, 0.0, 0.0};
        const double* q = y + turn;
        const double square = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3], two = 2.0 / square;
        return from_touch({two * (q[1] * q[3] + q[0] * q[2]), two * (q[2] * q[3] - q[0] * q[1]),
                           -two * (q[1] * q[1] + q[2] * q[2])});
    }
    Vector3 from_touch(const Vector3& c) const {
        Vector3 x;
        for (std::size_t k = 0; k < 3; ++k)
            x[k] = c[0] * axes_[0][k] + c[1] * axes_[1][k] + c[2] * axes_[2][k];
        return x;
    }

private:
    PlanarMotion<Normal> units_;
    TurningApproach touch_;
    FrictionTerms friction_;
    Vector3 axes_[3]{};
    double elastic_, damping_, stiffness_, dashpot_;
    int stiffness_power_, dashpot_power_;
    double kept_part_ = 0.0;

    static double whole_power(double x, int n) {
        double product = 1.0;
        for (int i = 0; i < n; ++i) product *= x;
        return product;
    }
    double in_units(const PowerTerm& t) const { return t.factor * whole_power(units_.root, p * t.power / 4); }
    static double without_rounding(double x, double beside) {
        return math::abs(x) <= 4.0 * math::epsilon * math::abs(beside) ? 0.0 : x;
    }

    // The first tangent: along the tangential velocity of the centres, or else along that of the surfaces.
    void set_frame() {
        const Vector3& n = touch_.normal;
        axes_[2] = n;
        const Vector3 candidates[] = {
            touch_.velocity, cross(touch_.spin, n), {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}};
        for (const Vector3& v : candidates) {
            Vector3 t = v;
            for (int twice = 0; twice < 2; ++twice) {
                const double along = dot(t, n);
                for (std::size_t k = 0; k < 3; ++k) t[k] -= along * n[k];
            }
            const double length = math::sqrt(dot(t, t));
            if (!(length > 1e-14 * math::sqrt(dot(v, v)))) continue;
            for (std::size_t k = 0; k < 3; ++k) axes_[0][k] = t[k] / length;
            break;
        }
        axes_[1] = cross(n, axes_[0]);
    }

    void remember(double* y, Tangential elastic) const {
        const double scale = whole_power(y[root_depth], p * history() / 2);
        y[memory] = scale > 0.0 ? elastic.first / scale : 0.0;
        y[memory + 1] = scale > 0.0 ? elastic.second / scale : 0.0;
    }

    // d|T|/dτ without slip less that of its limit.
    double yielding(const double* y) const {
        const Now at = now(y);
        const Tangential elastic = spring(y);
        double dy[dimension];
        move(y, at, elastic, dy);
        const double size = elastic.length(), s = y[root_depth];
        const double pulled =
            stiffness_ * whole_power(s, stiffness_power_) * at.clock * (at.g * elastic) / size;
        const double grown = s > 0.0 ? 0.5 * history() * y[rate] / s * size : 0.0;
        return pulled + grown - friction_.coefficient * normal_growth(y, dy);
    }

    // F_n = 0 at touch: f is the direction of h.
    void align(double* y) {
        double dy[dimension];
        for (int i = 0; i < 3; ++i) {
            const Now at = now(y);
            move(y, at, force(y, at), dy);
            const Drive drive = slip_drive(y, at, dy);
            begin_slip(y, drive.along * reference + drive.across * reference.turned());
        }
    }

    // dF_n/dτ
    double normal_growth(const double* y, const double* dy) const {
        const double s = y[root_depth];
        double slope = elastic_power * elastic_ * math::power<elastic_power - 1>(s);
        if constexpr (damping_power > 0)
            slope += damping_power * damping_ * math::power<damping_power - 1>(s) * y[rate];
        return slope * dy[root_depth] + damping_ * math::power<damping_power>(s) * dy[rate];
    }

    // Rates of everything but the memory.
    void move(const double* y, const Now& at, Tangential push, double* dy) const {
        const double clock = at.clock, bend = clock * at.curve;
        const double c = touch_.rotational_ratio * at.width;
        dy[root_depth] = y[rate] * (1.0 / p);
        dy[rate] = -clock * at.normal - bend * (at.w * at.w);
        dy[across] = bend * y[rate] * at.w.first - clock * push.first;
        dy[across + 1] = bend * y[rate] * at.w.second - clock * push.second;
        dy[surface] = clock * c * push.first - bend * y[twist] * at.w.second;
        dy[surface + 1] = clock * c * push.second + bend * y[twist] * at.w.first;
        dy[twist] = bend * (at.u.first * at.w.second - at.u.second * at.w.first);
        const double* q = y + turn;
        if (is_wall()) {
            dy[turn] = dy[turn + 3] = 0.0;
            dy[turn + 1] = clock * at.w.first;
            dy[turn + 2] = clock * at.w.second;
        } else {
            const double a = -0.5 * bend * at.w.second, b = 0.5 * bend * at.w.first;
            dy[turn] = -(q[1] * a + q[2] * b);
            dy[turn + 1] = q[0] * a - q[3] * b;
            dy[turn + 2] = q[0] * b + q[3] * a;
            dy[turn + 3] = q[1] * b - q[2] * a;
        }
        dy[time] = clock;
        dy[loss] = clock * (at.normal - at.elastic) * y[rate];
        dy[work] = clock * (push * at.g);
        dy[stuck] = slips ? 0.0 : dy[work];
        dy[damped] = slips ? 0.0 : clock * ((push - spring(y)) * at.g);
    }
};

}  // namespace hardlimit::boxes
