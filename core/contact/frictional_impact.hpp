// One contact with friction and a fixed normal, in units of the user (scaled_impact.hpp has the equations): by closed
// forms (linear_impact.hpp) where they hold, by integration at order 8 (power_impact.hpp) elsewhere.
#pragma once
#include "linear_impact.hpp"
#include "power_impact.hpp"

namespace hardlimit::contact {

// A contact in units of the user.
struct FrictionalContact {
    Powers powers;
    Coefficients normal;
    double mass, tangential_mass;  // m and m_t
    FrictionTerms friction;

    HL_FN bool linear() const { return powers.elastic == 4; }
    // L and L/v at this speed.
    HL_FN double length_unit(double speed) const {
        if (linear()) return speed * time_unit(speed);
        return math::pow(mass / normal.elastic * speed * speed, 4.0 / (powers.elastic + 4));
    }
    HL_FN double time_unit(double speed) const {
        return linear() ? math::sqrt(mass) / math::sqrt(normal.elastic) : length_unit(speed) / speed;
    }
    HL_FN ScaledImpact scaled(double speed, double slip) const {
        const double unit = length_unit(speed), time = time_unit(speed);
        const PowerTerm k = friction.stiffness, c = friction.damping;
        const auto in_units = [&](double factor, int power) {
            return power == 0 ? factor : factor * math::pow(unit, 0.25 * power);
        };
        const bool constant = linear() && k.power == 0;
        const double square = constant ? mass / normal.elastic : time * time;
        return {powers,
                in_units(normal.damping, powers.damping) * time / mass,
                {in_units(k.factor, k.power) * square / tangential_mass, k.power},
                {in_units(c.factor, c.power) * time / tangential_mass, c.power},
                friction.loading,
                friction.unloading,
                friction.limit,
                limit(speed / slip)};
    }

private:
    // M; also where the speed or the slip velocity is infinite.
    HL_FN double limit(double speed_ratio) const {
        const double mu = friction.coefficient;
        return mu == 0.0 || mu == math::infinity ? mu : mu * (mass / tangential_mass) * speed_ratio;
    }
};

// Energies at the end of a contact and those lost [J]. They add up to the kinetic energy at touch of the relative
// motion, m v²/2 + m_t g_0²/2.
//   normal_spring       of the compression with which a dissipative contact ends
//   tangential_spring   of the spring at the end, if k_t is constant; otherwise the spring has no energy of its own
//   normal_damping      work of the damping of the normal force
//   tangential_damping  work of γ_t g while the surfaces stick
//   friction            the rest of the work of the tangential force. Under SlipLimit::total with γ_t > 0 it may be
//                       negative: the limit then sets the spring against the slip. Without a constant k_t it includes
//                       what the spring does not give back, negative if it gives more
struct ImpactEnergies {
    double normal, tangential;  // kinetic
    double normal_spring, tangential_spring, normal_damping, tangential_damping, friction;
};

// Result of one contact [s, N s, J].
struct FrictionalImpact {
    bool solved;                                 // within the number of steps allowed
    double restitution, tangential_restitution;  // ε = 0 and an infinite duration if the bodies stay together
    double duration, normal_impulse, tangential_impulse;
    ImpactEnergies energies;
};

// Calls use(solution) with the solution that is exact for this contact.
template <class Use>
HL_FN auto with_solution(const ScaledImpact& of, const Use& use) {
    if (LinearImpact::solves(of)) {
        LinearImpact motion(of);
        return use(motion);
    }
    PowerImpact motion(of);
    return use(motion);
}

// Calls sink(slips, begin, end) for each interval of stick or slip, from the pieces of a solution. What happens within
// rounding error of touch or takes no time is left out.
template <class Sink>
class Intervals {
public:
    HL_FN explicit Intervals(Sink& sink) : sink_(sink) {}
    template <class At>
    HL_FN void operator()(Surfaces surfaces, double begin, double end, const At& /*at*/) {
        constexpr double touch = 1e-30;
        if (end < touch || !(end - begin > 4.0 * math::epsilon * end)) return;
        const bool slips = surfaces == Surfaces::slip;
        if (slips != slips_ && end_ > 0.0) finish(begin);
        slips_ = slips;
        end_ = end;
    }
    HL_FN void finish(double end) {
        sink_(slips_, begin_, end);
        begin_ = end;
    }
    HL_FN void finish() { finish(end_); }

private:
    Sink& sink_;
    bool slips_ = false;
    double begin_ = 0.0, end_ = 0.0;
};

// β of one contact with this slip velocity at touch; NaN if it takes too many steps. Without slip velocity: the limit
// of a small one.
HL_FN double tangential_restitution(const FrictionalContact& contact, double speed, double slip) {
    return with_solution(contact.scaled(speed, math::abs(slip)), [](auto& motion) {
        impact::NoObserver observer;
        return motion.run(observer) ? -motion.state().slip : math::nan;
    });
}

// The contact with a slip velocity >= 0 at touch. The observer gets the scaled pieces and, by finish(state), the end.
template <class Observer>
HL_FN FrictionalImpact frictional_impact(const FrictionalContact& contact, double speed, double slip,
                                         Observer& observer) {
    const ScaledImpact scaled = contact.scaled(speed, slip);
    return with_solution(scaled, [&](auto& motion) -> FrictionalImpact {
        const bool over = motion.run(observer);
        const impact::State end = motion.state();
        observer.finish(end);
        const impact::Work work = motion.work();
        const double m = contact.mass, m_t = contact.tangential_mass;
        const double normal = m * speed * speed, tangential = m_t * slip * slip;
        const double rebound = motion.over() ? -end.rate : 0.0;
        const double power = 0.25 * contact.powers.elastic + 1.0;
        const PowerTerm& k = scaled.stiffness;
        const bool stores = k.power == 0 && scaled.loading == 0 && scaled.unloading == 0;
        const double stored = !stores ? 0.0 : k.factor > 0.0 ? 0.5 * end.spring / k.factor * end.spring : 0.0;
        return {over && math::is_finite(end.slip),
                rebound,
                -end.slip,
                motion.over() ? end.time * contact.time_unit(speed) : math::infinity,
                m * speed * (1.0 + rebound),
                m_t * slip * (1.0 - end.slip),
                {0.5 * normal * rebound * rebound, 0.5 * tangential * end.slip * end.slip,
                 normal * math::pow(math::max(end.compression, 0.0), power) / power, tangential * stored,
                 normal * work.normal_damping, tangential * work.damping,
                 tangential * (work.slipping + (work.sticking - stored))}};
    });
}

}  // namespace hardlimit::contact
