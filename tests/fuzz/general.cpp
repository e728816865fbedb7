// Fuzz target: columns and cradles of one to five balls under any law, with the general solver and the model of
// independent collisions.
#include "check.hpp"
#include "column/rebound.hpp"

namespace {

using namespace hardlimit;
using fuzz::require;

template <class Law>
double speed_of(const column::Column<Law>& c) {
    double speed = c.floor ? column::impact_speed(c.gaps[0], c.velocity[0], c.gravity) : 0.0;
    for (const double v : c.velocity) speed = math::max(speed, math::abs(v));
    return speed;
}

// Initial and largest energy of a run [J].
struct Sizes {
    double initial, largest;
};

// Checks at and between the knots of a run that values are finite, energy never increases and no force is attractive.
Sizes check_course(const column::Solution& s, int balls, double rounding) {
    std::vector<double> times = s.knots();
    std::erase_if(times, [&](double t) { return !(t >= s.first && t <= s.last); });
    if (times.size() > 400) times.resize(400);
    for (std::size_t i = times.size(); i-- > 1;) times.push_back(0.5 * (times[i - 1] + times[i]));
    std::sort(times.begin(), times.end());
    column::States at(times.size(), balls);
    s.sample(times.data(), at);
    double before = math::infinity, initial = 0.0, scale = 0.0;
    for (std::size_t i = 0; i < at.n; ++i) {
        const column::Energies& e = at.total[i];
        const double sum = e.kinetic + e.potential + e.contact;
        require(math::is_finite(sum), "finite energies");
        if (i == 0) initial = sum;
        scale = math::max(scale, e.kinetic + math::abs(e.potential) + e.contact);
        require(sum <= before + rounding * scale, "energy never rises");
        before = sum;
    }
    for (const double f : at.force) require(!(f < 0.0), "no force pulls");
    return {initial, scale};
}

template <class Law>
void check_end(const column::Column<Law>& c, const column::Solution& s) {
    if (c.floor || s.sequence.outcome != Outcome::ok) return;
    const std::vector<double> v = column::final_velocities(s, c.balls);
    for (std::size_t i = 1; i < v.size(); ++i)
        require(v[i] - v[i - 1] >= -1e-10 * speed_of(c), "the balls of a cradle part in the end");
}

template <class Law>
void check(fuzz::Draw<fuzz::Bytes>& draw) {
    const int balls = 1 + draw.below(5);
    const bool floor = balls == 1 || draw.below(3) != 0;
    const auto c = std::make_shared<const column::Column<Law>>(fuzz::draw_column<Law>(draw, balls, floor));
    column::SolveOptions options{.until = draw.often({math::nan}, [&] { return draw.decades(1e-9, 10.0); }),
                                 .general = true,
                                 .max_steps = 1500,
                                 .max_events = 3000};
    for (const auto model : {column::Model::newton, column::Model::independent}) {
        const std::unique_ptr<column::Solution> s = column::solve_column(c, model, options);
        require(s != nullptr, "a solution");
        if (s->sequence.outcome == Outcome::invalid || math::is_nan(s->first)) continue;
        const Sizes energy = check_course(*s, balls, 1e-10);
        // Relative to the largest energy: a heavy ball on a soft floor stores a million times the initial energy.
        if (model == column::Model::newton && s->sequence.outcome != Outcome::unresolved)
            require(s->energy_error * energy.initial <= 1e-9 * energy.largest, "the energy balance");
        if (math::is_nan(options.until)) check_end(*c, *s);
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::Draw<fuzz::Bytes> draw{fuzz::Bytes(data, size)};
    fuzz::with_some_law(draw, [&]<class Law>() { check<Law>(draw); });
    return 0;
}
