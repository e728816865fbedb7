// The direction of slip at the end of a contact, where F_n falls to zero: f' = h_⊥/(μ F_n), with x = F_n/F_n(0). If h
// keeps its direction, the angle ψ from h to f obeys, however large, tan(ψ/2) ∝ exp(−v) with dv = −κ dx/x and
// κ = |h|/(μ |dF_n/dt|). With y = 2 ln(1/x) the mean of f that is weighted with the force is ∫ e^{−y} f dy:
// Gauss-Laguerre quadrature, with errors below 2e-4 sin ψ for κ < 4, and 1e-6 sin ψ for κ < 0.6. In one last step this
// mean replaces f. h is that at the mean time, a third of the time left: its change then cancels to first order.
#pragma once
#include "../../base/math.hpp"

namespace hardlimit::boxes {

// A tangential vector: its components along f and n×f at the begin.
struct SlipVector {
    double along, across;

    double length() const { return math::sqrt(along * along + across * across); }
    friend SlipVector operator+(SlipVector a, SlipVector b) {
        return {a.along + b.along, a.across + b.across};
    }
    friend SlipVector operator*(double x, SlipVector a) { return {x * a.along, x * a.across}; }
};

// A contact whose force falls.
struct FallingForce {
    double stiffness, dashpot,
        mobility;              // k_t, γ_t beside a spring; −dg/dt by a tangential force of one unit
    double limit, fall, bend;  // μ F_n, −d/dt and d²/dt² of it
    double turning;            // rate at which n and the spins turn
    double others;             // rate at which other forces change, or 0

    double left() const { return limit / fall; }  // time to the end
};

class SlipClosing {
public:
    // `slip`: g, `curve`: dg/dt without the force of friction.
    SlipClosing(const FallingForce& force, SlipVector slip, SlipVector curve) {
        const double left = force.left(), k = force.stiffness;
        const double slowed = 0.25 * k * force.mobility * force.limit * left;
        const SlipVector pull =
            k * (slip + (left / 3.0) * curve) + force.dashpot * curve + SlipVector{-slowed, 0.0};
        const double size = pull.length(), per_size = 1.0 / size;
        bend_ = force.bend * left / force.fall;
        rate_ = size / (force.fall * (1.0 - bend_ / 3.0));
        cosine_ = pull.along * per_size, sine_ = pull.across * per_size;
        const double slope = left * k * (curve.along * cosine_ + curve.across * sine_) * per_size;
        growth_ = bend_ + slope;
        const double sine = math::abs(sine_), change = left * k * curve.length() * per_size;
        const double others = left * force.others, swept = left * force.turning;
        error_ = math::min(rate_, 1.0) *
                 (change * (change + others + sine * sine) + swept * swept +
                  sine * (0.1 * slowed * per_size + bend_ * bend_ + 0.1 * others * others));
    }

    // Whether the impulse left, times the error of the mean, is below this.
    bool is_within(double tolerance, const FallingForce& force) const {
        return rate_ < 4.0 && rate_ * cosine_ > -0.9 && force.limit * force.left() * error_ < tolerance;
    }
    // The mean until F_n = 0.
    SlipVector mean() const { return seen(mean_from(cosine_, rate_, growth_, bend_)); }
    // Direction, and mean until then, where the force has fallen to a part x.
    struct Partial {
        SlipVector now, mean;
    };
    Partial until(double x) const {
        const double path = math::log(1.0 / x), gone = 1.0 - x, square = x * x;
        const SlipVector now = turned(cosine_, rate_ * (path + growth_ * (2.0 / 3.0 * path - gone)));
        const SlipVector rest =
            mean_from(now.along, rate_ * (1.0 + growth_ * gone * (2.0 / 3.0)), growth_ * x, bend_ * x);
        // `rest` is seen from f now, whose part across ĥ is now.across.
        const SlipVector all = mean_from(cosine_, rate_, growth_, bend_);
        const SlipVector after{rest.along, rest.across * now.across};
        const double per_part = 1.0 / (1.0 - square);
        return {seen(now), square < 1.0 ? seen(per_part * (all + (-square) * after)) : seen(now)};
    }

private:
    // κ where x = 2/3, the mean x; κ ∝ 1 + growth (1 − x), |dF_n/dt| ∝ 1 − bend (1 − x)
    double rate_, growth_, bend_;
    double cosine_, sine_;  // ĥ
    double error_;          // of the mean

    // f = along ĥ + across (f(0) − cos ψ(0) ĥ)
    static SlipVector turned(double cosine, double v) {
        const double grown = math::exp(v), fallen = 1.0 / grown;
        const double to = (1.0 + cosine) * grown, from = (1.0 - cosine) * fallen, per_sum = 1.0 / (to + from);
        return {(to - from) * per_sum, 2.0 * per_sum};
    }
    static SlipVector mean_from(double cosine, double rate, double growth, double bend) {
        SlipVector sum{};
        for (int i = 0; i < nodes; ++i) {
            const double half = 0.5 * node[i], x = force[i];
            const SlipVector at = turned(cosine, rate * (half + growth * (2.0 / 3.0 * half - (1.0 - x))));
            sum = sum + (weight[i] * (1.0 + bend * (2.0 / 3.0 - x))) * at;
        }
        return sum;
    }
    // In components along f(0) and n×f(0).
    SlipVector seen(SlipVector f) const {
        return {f.along * cosine_ + f.across * sine_ * sine_, (f.along - f.across * cosine_) * sine_};
    }

    static constexpr int nodes = 10;
    static constexpr double node[nodes] = {
        0.1377934705404926, 0.729454549503171,  1.8083429017403159, 3.4014336978548996, 5.552496140063804,
        8.330152746764497,  11.843785837900066, 16.279257831378104, 21.99658581198076,  29.92069701227389};
    static constexpr double weight[nodes] = {
        0.3084411157650173,    0.4011199291552761,    0.2180682876118096,     0.062087456098677773,
        0.0095015169751811,    0.0007530083885875384, 2.8259233495995642e-05, 4.249313984962698e-07,
        1.839564823979633e-09, 9.91182721960906e-13};
    static constexpr double force[nodes] = {
        0.9334230647820767,     0.6943860016512328,    0.40487720682598344,  0.18255261449124996,
        0.06227170871634555,    0.015528528888543657,  0.002680122118347199, 0.00029174544030655304,
        1.6730236513266228e-05, 3.1827549073642893e-07};  // e^{−y/2}
};

}  // namespace hardlimit::boxes
