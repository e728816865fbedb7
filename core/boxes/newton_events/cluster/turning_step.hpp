// A step of a cluster in which a single contact is open, between two bodies with friction under a linear law, by power
// series in time (binary_contact/turning_series.hpp) from the present state of this contact. All other bodies fly.
#pragma once
#include "../../binary_contact/turning_series.hpp"
#include "events.hpp"
#include "integrator.hpp"

namespace hardlimit::boxes {

template <FrictionalLaw Law>
class TurningStep final : public StepSeries {
    using Normal = typename Law::Frictionless;

public:
    // The pair, or −1 if the present contacts need another method.
    static int pair_of(const ContactNetwork<Law>& network) {
        int only = -1;
        for (int i = 0; i < static_cast<int>(network.pairs.size()); ++i) {
            if (network.pairs[i].state != ContactState::closed) continue;
            if (only >= 0) return -1;
            only = i;
        }
        if (only < 0) return -1;
        const ContactPair<Law>& q = network.pairs[only];
        const FrictionTerms& f = q.law.friction;
        // Otherwise T may follow its limit without slip.
        const bool limited = f.limit == SlipLimit::total || f.damping.factor == 0.0;
        const bool applies = q.second >= 0 && !q.image_moves && f.coefficient > 0.0 && limited &&
                             TurningSeries<Normal>::applies(f);
        return applies ? only : -1;
    }

    TurningStep(const ContactNetwork<Law>& network, const StateVector& state, int pair, double precision)
        : network_(network),
          state_(state),
          q_(network.pairs[pair]),
          pair_(pair),
          now_(SurfacePair<Law>(state.at(network), pair)),
          series_(series_at(precision)) {}

    // Length of the step [s], at most `most`; `event`: of the pair at its end.
    double bound(double most, PairEvent& event) {
        using Event = TurningSeries<Normal, true>::Event;
        const ContactEvent change = next_surface_events(q_)[1];
        const auto to = series_.bound(most, q_.surfaces.fresh, change != ContactEvent::none);
        if (to.event == Event::ends) event = {ContactEvent::ends, pair_};
        if (to.event == Event::changes) event = {change, pair_};
        return to.length;
    }

    void move(double t, double* y) override {
        const StateLayout& at = state_.layout;
        const double* from = state_.y.data();
        std::copy(state_.y.begin(), state_.y.end(), y);
        y[at.time()] = state_.time() + t;
        for (int i = 0; i < at.members(); ++i) fly(i, from + at.velocity(i), t, y);
        const auto end = series_.after(t);
        const Vector3 v = relative(from + at.velocity(q_.first), from + at.velocity(q_.second));
        const Vector3 moved = end.shift - t * v, gained = end.velocity - v, spun = end.spin - touch_.spin;
        const double mass = touch_.effective_mass;
        add(q_.first, -1.0, mass, moved, gained, spun, y);
        add(q_.second, 1.0, mass, moved, gained, spun, y);
        std::ranges::copy(end.memory, y + at.surface(pair_));
        y[at.surface(pair_) + 3] = 0.0;
    }
    void add_sums(double t, double* y) override {
        const StateLayout& at = state_.layout;
        const auto taken = series_.until(t);
        y[at.loss()] += taken.damping + taken.rubbed;
        y[at.rubbed()] += taken.rubbed;
        for (std::size_t k = 0; k < SymmetricTensor::size; ++k)
            y[static_cast<std::size_t>(at.virial()) + k] += taken.tensor.component[k];
    }

private:
    const ContactNetwork<Law>& network_;
    const StateVector& state_;
    const ContactPair<Law>& q_;
    const int pair_;
    const SurfacePair<Law> now_;
    TurningApproach touch_{};
    TurningSeries<Normal, true> series_;

    static Vector3 relative(const double* a, const double* b) { return vector_at(b) - vector_at(a); }

    TurningSeries<Normal, true> series_at(double precision) {
        const StateLayout& at = state_.layout;
        const double* y = state_.y.data();
        const Member &a = network_.members[q_.first], &b = network_.members[q_.second];
        const double stiffness = q_.law.coefficients().elastic, depth = now_.g.depth, rate = now_.g.rate;
        const double period = math::sqrt(q_.mass / stiffness);
        const double unit = math::sqrt(rate * rate + (depth / period) * (depth / period));
        const auto lever = [&](int member) {
            return network_.members[member].radius * network_.members[member].radius /
                   network_.rotations[member].inertia;
        };
        touch_ = {.effective_mass = q_.mass,
                  .distance = q_.contact_distance,
                  .arm = q_.contact_distance,
                  .rotational_ratio = q_.mass * (lever(q_.first) + lever(q_.second)),
                  .normal = now_.g.normal,
                  .velocity = relative(y + at.velocity(q_.first), y + at.velocity(q_.second)) +
                              (rate - unit) * now_.g.normal,
                  .spin = (1.0 / q_.contact_distance) * (a.radius * vector_at(y + at.spin(q_.first)) +
                                                         b.radius * vector_at(y + at.spin(q_.second)))};
        const PlanarMotion<Normal> units(q_.law, TurningMotion<Normal>::approach_of(touch_), unit * period);
        return {q_.law, touch_, units,
                WithinContact{depth, rate, q_.surfaces.slips ? now_.direction() : now_.memory(),
                              q_.surfaces.slips, q_.surfaces.frozen},
                precision};
    }
    void fly(int member, const double* velocity, double t, double* y) const {
        double *x = y + state_.layout.position(member), *v = y + state_.layout.velocity(member);
        for (std::size_t k = 0; k < 3; ++k) {
            x[k] += t * (velocity[k] + 0.5 * network_.gravity[k] * t);
            v[k] += t * network_.gravity[k];
        }
    }
    // Adds a body's part of the relative motion.
    void add(int member, double sign, double mass, const Vector3& moved, const Vector3& gained,
             const Vector3& spun, double* y) const {
        const StateLayout& at = state_.layout;
        const double share = sign * mass / network_.members[member].mass;
        const double lever =
            network_.members[member].radius * touch_.arm / network_.rotations[member].inertia;
        const double turned = mass * lever / touch_.rotational_ratio;
        for (std::size_t k = 0; k < 3; ++k) {
            y[static_cast<std::size_t>(at.position(member)) + k] += share * moved[k];
            y[static_cast<std::size_t>(at.velocity(member)) + k] += share * gained[k];
            y[static_cast<std::size_t>(at.spin(member)) + k] += turned * spun[k];
        }
    }
};

}  // namespace hardlimit::boxes
