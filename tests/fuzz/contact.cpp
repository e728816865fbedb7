// Fuzz target: one contact under any law, with parameters over many decades or any values that the law's record allows;
// and one with friction.
#include "check.hpp"
#include "contact/frictional_impact.hpp"

namespace {

using namespace hardlimit;
using Draw = fuzz::Draw<fuzz::Bytes>;

// Any finite double within the range of a parameter.
double any_number(Draw& draw, const Parameter& p) {
    const double low = math::max(p.lowest, 0.0), bits = draw.between(-1.0, 1.0);
    if (p.highest < math::infinity) return p.lowest + (p.highest - p.lowest) * draw.between(1e-9, 1.0);
    return low + math::exp(700.0 * bits);
}

template <class Law>
Law any_law(Draw& draw, PairGeometry pair) {
    if (draw.below(4) != 0) return fuzz::Material<Law>(draw).between(pair);
    const LawRecord& record = Law::record;
    const int alternative = draw.below(record.n_alternatives);
    double p[2 * max_parameters] = {};
    for (int i = 0; i < record.n_common; ++i) p[i] = any_number(draw, record.common[i]);
    for (int i = 0; i < record.n_in_alternative[alternative]; ++i)
        p[record.n_common + i] = any_number(draw, record.alternatives[alternative][i]);
    return Law::from_parameters(alternative, p, pair);
}

template <class Law>
bool usable(const Law& law) {
    double constants[max_parameters];
    law.values(constants);
    for (int i = 0; i < Law::record.n_constants; ++i)
        if (!(math::abs(constants[i]) < 1e150) || (constants[i] != 0.0 && constants[i] < 1e-150))
            return false;
    return true;
}

// Checks that the slack never grows with the rate, is positive only while the bodies separate, and has zero force.
template <class Law>
void check_slack(const Law& law, double speed) {
    double before = math::infinity;
    for (int i = -8; i <= 8; ++i) {
        const double rate = speed * i / 8.0, depth = math::max(law.slack(rate).depth, 0.0);
        fuzz::require(depth <= before, "the slack never grows with the rate");
        before = depth;
        fuzz::require(rate < 0.0 || depth == 0.0, "a slack only where the bodies separate");
        if (!(depth > 0.0)) continue;
        const double s = onset_root<Law::onset_power>(depth), elastic = law.elastic_force(s);
        if (!(elastic > 1e-250) || !(elastic < 1e250)) continue;
        fuzz::require(math::abs(law.force(s, rate)) <= 1e-9 * elastic, "no force at the slack");
        fuzz::require(law.force(1.001 * s, rate) > 0.0, "a force beyond the slack");
    }
}

template <class Law>
void check_collision(const Law& law, double speed, double mass) {
    const double restitution = law.restitution(speed, mass), duration = law.duration(speed, mass);
    fuzz::require(restitution >= 0.0 && restitution <= 1.0, "restitution in [0, 1]");
    fuzz::require(duration > 0.0, "a duration above zero");
    fuzz::require(law.restitution(speed, mass) == restitution, "the same numbers again");
    for (const double s : {1e-6, 1e-3, 1.0}) {
        fuzz::require(law.energy(s) >= 0.0, "no energy below zero");
        fuzz::require(law.elastic_force(s) <= law.elastic_force(2.0 * s),
                      "an elastic force that never falls");
    }
}

// Friction of any model; constants of a linear law over more decades, whose closed form takes few steps.
contact::FrictionalContact draw_frictional(Draw& draw) {
    const bool linear = draw.below(2) == 0;
    const int powers[] = {0, 1, 2, 4, 6};
    const FrictionModelRecord& model = friction_models[linear ? 0 : draw.below(6)];
    const double wide = linear ? 1e9 : 1e2;
    const auto constant = [&] { return draw.often({0.0}, [&] { return draw.decades(1.0 / wide, wide); }); };
    contact::FrictionalContact c{{linear ? 4 : 6, linear ? 0 : powers[draw.below(5)], draw.below(3) == 0},
                                 {1.0, constant()},
                                 1.0,
                                 draw.between(0.1, 1.0),
                                 {}};
    c.friction = {.coefficient = draw.often({0.0, math::infinity}, [&] { return draw.decades(1e-9, 1e9); }),
                  .stiffness = {constant(), linear ? 0 : 2 * draw.below(2)},
                  .damping = {constant(), linear ? 0 : powers[draw.below(5)]},
                  .loading = model.loading,
                  .unloading = model.unloading,
                  .limit = draw.below(2) == 0 ? SlipLimit::total : SlipLimit::spring};
    return c;
}

void check_impact(Draw& draw) {
    const contact::FrictionalContact c = draw_frictional(draw);
    const double speed = draw.often({1.0}, [&] { return draw.decades(1e-3, 1e3); });
    const double slip = draw.often({0.0, 1.0}, [&] { return draw.decades(1e-9, 1e9); });
    contact::impact::NoObserver observer;
    const contact::FrictionalImpact r = contact::frictional_impact(c, speed, slip, observer);
    const double beta = contact::tangential_restitution(c, speed, slip);
    fuzz::require(beta == r.tangential_restitution || (beta != beta && !r.solved), "the same numbers again");
    if (!r.solved) return;
    fuzz::require(r.duration > 0.0, "a duration above zero");
    fuzz::require(r.restitution >= -1e-9 && r.restitution <= 1.0 + 1e-9, "restitution in [0, 1]");
    const bool conserves =
        c.friction.stiffness.power == 0 && c.friction.loading == 0 && c.friction.unloading == 0;
    if (conserves && !(c.friction.damping.factor > 0.0))
        fuzz::require(math::abs(beta) <= 1.0 + 1e-9, "a constant spring never gains");
    const double most = c.friction.coefficient * r.normal_impulse;
    if (!c.powers.attracts && c.friction.limit == SlipLimit::total)
        fuzz::require(r.tangential_impulse <= most + 1e-9 * (most + c.tangential_mass * slip),
                      "no more than Coulomb's impulse");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    Draw draw{fuzz::Bytes(data, size)};
    fuzz::with_some_law(draw, [&]<class Law>() {
        const double mass = draw.decades(1e-15, 1e6), radius = draw.decades(1e-7, 1e3);
        const double speed = draw.decades(1e-9, 1e4);
        const Law law = any_law<Law>(draw, {mass, radius});
        const double restitution = law.restitution(speed, mass);
        if (!usable(law)) return;  // checked only to return
        (void)restitution;
        check_collision(law, speed, mass);
        check_slack(law, speed);
    });
    check_impact(draw);
    return 0;
}
