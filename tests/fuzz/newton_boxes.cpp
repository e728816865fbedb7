// Fuzz target: small boxes in the event-driven engine for Newton's equations, with all boundaries and laws, without and
// with friction. Each runs for some contacts, is saved and loaded, and continues.
#include <algorithm>
#include <cstdlib>
#include <memory>
#include <vector>

#include "boxes/newton_events/engine.hpp"
#include "small_box.hpp"

namespace {

using namespace hardlimit;
using namespace hardlimit::boxes;
using fuzz::kernels;
using fuzz::require;
using Draw = fuzz::Draw<fuzz::Bytes>;

// A box with speeds and gravity scaled so that its total energy can compress a contact by a given fraction of the
// smallest radius.
template <class Law>
struct Case : fuzz::SmallBox {
    std::vector<double> v;  // [N d]
    LawChoice choice;
    PairLaws<Law> laws;
    double energy = 0.0, momentum = 0.0;  // upper bounds [J], [kg m/s]
    double depth = 0.0;                   // of the softest contact at this energy [m]
    double until = 0.0;                   // [s]
    double least_restitution = 1.0;       // of an isolated contact at these speeds

    explicit Case(Draw& draw)
        : fuzz::SmallBox(draw, 3, 4.2001, true),
          choice(fuzz::law_choice<Law>(fuzz::Material<Law>(draw))),
          laws(NewtonSetting(s, choice, true).laws<Law>()) {
        const double smallest = *std::min_element(radius.begin(), radius.end());
        depth = draw.decades(1e-6, 0.02) * smallest;
        double total = 0.0;
        energy = math::infinity;
        for (std::size_t i = 0; i < s.n; ++i) {
            total += mass[i];
            for (std::int64_t j = -1; j < static_cast<std::int64_t>(s.n); ++j)
                energy = math::min(energy, of_depth(static_cast<std::int64_t>(i), j, depth));
        }
        const double unit = math::sqrt(2.0 * energy / (s.box.dimension * total)) / speed;
        const double fall = draw.decades(1e-3, 1.0);
        for (int k = 0; k < s.box.dimension; ++k)
            s.box.gravity[k] *= 0.1 * fall * unit * unit * speed * speed / s.box.edge[k];
        for (const double component : velocity) v.push_back(unit * component);
        s.box.shear_rate *= unit;
        s.velocity = v.data();
        for (std::size_t i = 0; i < s.n; ++i)
            for (std::int64_t j = -1; j < static_cast<std::int64_t>(s.n); ++j) {
                const double other = j < 0 ? math::infinity : mass[static_cast<std::size_t>(j)];
                const double of_pair = laws(static_cast<std::int64_t>(i), j)
                                           .restitution(unit * speed, effective(mass[i], other));
                least_restitution = math::min(least_restitution, of_pair);
            }
        const double fast = unit * speed, slow = laws(0, -1).duration(fast, mass[0]);
        until =
            draw.below(2) == 0 ? draw.decades(0.1, 100.0) * slow : draw.decades(0.01, 30.0) * large / fast;
        momentum = 3.0 * total * fast;
        if (draw.below(2) == 0) add_friction(draw, fast);
    }
    void add_friction(Draw& draw, double fast) {
        Friction& f = choice.friction = fuzz::some_friction(draw, Law::onset_power == 1);
        if (f.limit == SlipLimit::spring && f.model != FrictionModel::none)
            f.damping_ratio = 0.0;  // the engine is not given jumps of a force
        add_spins(draw, fast);
    }

    Law law(std::int64_t i, std::int64_t j) const { return laws(i, j); }
    double of_depth(std::int64_t i, std::int64_t j, double depth) const {
        return laws(i, j).energy(onset_root<Law::onset_power>(depth));
    }
};

// Everything that an engine reports about its state.
struct Seen {
    Observation sums;
    std::vector<double> position, velocity;  // [N d]
    std::vector<double> spin;                // [3 N]
    std::vector<ContactRecord> open;

    explicit Seen(const Engine& e)
        : sums(e.observe()),
          position(e.size() * static_cast<std::size_t>(e.dimension())),
          velocity(position.size()),
          spin(3 * e.size()),
          open(e.open_contacts()) {
        e.state(position.data(), velocity.data());
        e.spins(spin.data());
    }
};

template <class Law>
class Run {
public:
    explicit Run(const Case<Law>& c)
        : c_(c), engine_(make_newton_events(c.s, c.choice, true, of(c))), start_(engine_->observe()) {}

    // Advances, and checks the state.
    void advance(double until) {
        const double before = engine_->time();
        Stop never;
        engine_->advance(until, most_events, 1, never);
        require(engine_->time() >= before && engine_->time() <= until, "time goes on");
        check();
    }
    std::vector<char> save() const { return engine_->save(); }
    // Advances both the saved run and the loaded one.
    void compare(const std::vector<char>& bytes, double until) {
        const auto again = load_newton_events(bytes.data(), bytes.size(), of(c_));
        require(again != nullptr, "what was saved can be loaded");
        Stop never;
        const double from = engine_->time();
        for (const double part : {0.001, 0.1, 0.4, 1.0}) {
            const double next = from + part * (until - from);
            again->advance(next, most_events, 1, never);
            advance(next);
            const Seen a(*engine_), b(*again);
            require(engine_->time() == again->time() && a.position == b.position &&
                        a.velocity == b.velocity && a.spin == b.spin,
                    "what was loaded goes on with the same bits");
            require(numbers(a.sums) == numbers(b.sums), "what was loaded adds up the same bits");
        }
    }

private:
    static constexpr std::uint64_t most_events = 50;  // per call of advance()
    const Case<Law>& c_;
    std::unique_ptr<Engine> engine_;
    Observation start_;
    double dissipated_ = 0.0;
    double slack_ = 0.0;  // energy of overlaps without force, recovered if they engage again [J]

    static const hardlimit_abi::TouchKernels& of(const Case<Law>& c) {
        return c.wide ? kernels<8> : kernels<2>;
    }
    // The bytes of all fields.
    static std::vector<char> numbers(const Observation& o) {
        std::vector<char> bytes;
        for_fields(o, [&](const char*, const char*, Sampled, const auto& value) {
            const auto* const first = reinterpret_cast<const char*>(&value);
            bytes.insert(bytes.end(), first, first + sizeof value);
        });
        return bytes;
    }
    static double sum(const Observation& o) {
        return o.kinetic_energy + o.rotational_energy + o.potential_energy + o.contact_energy +
               o.dissipated_energy - o.shear_work;
    }

    void check() {
        const Seen now(*engine_);
        const std::size_t d = static_cast<std::size_t>(c_.s.box.dimension);
        for (const auto* numbers : {&now.position, &now.velocity, &now.spin})
            for (const double value : *numbers)
                require(math::is_finite(value), "finite places and velocities");
        // Shear heats the bodies without bound.
        const bool heated = c_.s.box.is_sheared() && engine_->outcome() == Outcome::too_deep;
        require(engine_->outcome() == Outcome::ok || heated, "so few bodies are resolved");
        double scale = c_.energy + math::abs(start_.potential_energy) + now.sums.kinetic_energy +
                       start_.rotational_energy + now.sums.rotational_energy +
                       math::abs(now.sums.friction_loss) + math::abs(now.sums.shear_work);
        for (std::size_t i = 0; i < c_.s.n; ++i)
            for (int k = 0; k < c_.s.box.dimension; ++k)
                scale += c_.mass[i] *
                         math::abs(c_.s.box.gravity[k] * now.position[d * i + static_cast<std::size_t>(k)]);
        // The integration error is about 1e-11 of the energy per step, with tens of steps in each contact. A
        // compression has the rounding error of the positions from which it is computed.
        const double farthest = math::max(math::max(c_.s.box.edge[0], c_.s.box.edge[1]), c_.s.box.edge[2]);
        const double of_contact = 5e-10 + 20.0 * math::epsilon * farthest / c_.depth;
        const double balance = 1e-9 + of_contact * static_cast<double>(now.sums.begun);
        require(math::abs(sum(now.sums) - sum(start_)) <= balance * scale, "energy is balanced");
        // The limit may set springs against the slip, and histories may gain energy.
        require(engine_->rotates() || now.sums.dissipated_energy >= dissipated_ - slack_ - 1e-9 * scale,
                "what is lost is lost");
        dissipated_ = now.sums.dissipated_energy;
        bool free = true;
        for (int k = 0; k < c_.s.box.dimension; ++k)
            free = free && c_.s.box.is_periodic(k) && c_.s.box.gravity[k] == 0.0;
        for (int k = 0; free && k < c_.s.box.dimension; ++k)
            require(math::abs(now.sums.momentum[k] - start_.momentum[k]) <= 1e-10 * c_.momentum,
                    "momentum is kept");
        check_overlaps(now, scale);
        require(engine_->largest_safety_use(5) <= 1.0, "true paths keep to the space that is left to them");
        for (const ContactRecord& row : engine_->take_log())
            require(row.begin >= 0.0 && row.end >= row.begin && row.end <= engine_->time() &&
                        (row.second < 0 || row.first < row.second),
                    "contacts begin and end");
    }

    // Checks that no overlap is deeper than the total energy allows, and that overlapping bodies that approach are in
    // contact.
    void check_overlaps(const Seen& now, double energy) {
        slack_ = 0.0;
        const auto n = static_cast<std::int64_t>(c_.s.n);
        const int d = c_.s.box.dimension;
        for (std::int64_t i = 0; i < n; ++i) {
            for (std::int64_t j = i + 1; j < n; ++j) {
                double square = 0.0, inwards = 0.0, r[3] = {}, v[3] = {};
                for (int k = 0; k < d; ++k) {
                    const auto a = static_cast<std::size_t>(d * i + k),
                               b = static_cast<std::size_t>(d * j + k);
                    r[k] = now.position[b] - now.position[a];
                    v[k] = now.velocity[b] - now.velocity[a];
                }
                v[0] += c_.s.box.to_minimum_image(r, engine_->time());
                for (int k = 0; k < d; ++k) square += r[k] * r[k], inwards -= r[k] * v[k];
                check_overlap(now, i, j, c_.radius[i] + c_.radius[j] - math::sqrt(square), inwards, energy);
            }
            for (int k = 0; k < c_.s.box.dimension; ++k) {
                if (!c_.s.box.has_walls(k)) continue;
                const auto a = static_cast<std::size_t>(d * i + k);
                const double at = now.position[a], speed = now.velocity[a];
                for (const bool high : {false, true}) {
                    const Wall wall = c_.s.box.wall(k, high);
                    check_overlap(now, i, wall.id.number, c_.radius[i] - wall.distance(at, engine_->time()),
                                  -wall.inward() * speed, energy);
                }
            }
        }
    }
    void check_overlap(const Seen& now, std::int64_t i, std::int64_t j, double depth, double inwards,
                       double energy) {
        const double reach = c_.radius[i] + (j < 0 ? 0.0 : c_.radius[j]);
        if (!(depth > 0.0)) return;
        const double compression = c_.of_depth(i, math::max(j, std::int64_t{-1}), depth);
        const bool known = std::any_of(now.open.begin(), now.open.end(), [&](const ContactRecord& row) {
            return row.first == i && row.second == j && math::is_nan(row.end);
        });
        if (!known) slack_ += compression;
        if (!(depth > 1e-10 * reach)) return;
        require(compression <= 1.001 * energy, "no contact is missed");
        require(known || !(inwards > 0.0), "who approaches within reach is in contact");
    }
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    Draw draw{fuzz::Bytes(data, size)};
    fuzz::with_some_law(draw, [&]<class Law>() {
        const Case<Law> c(draw);
        if (validate(c.s).kind != Fault::none || !(c.energy > 0.0) || !math::is_finite(c.until)) return;
        if (!(c.least_restitution > 1e-3)) return;  // creeping contacts need too many steps
        Run<Law> run(c);
        const double first = draw.between(0.0, c.until);
        run.advance(first);
        run.compare(run.save(), c.until);
    });
    return 0;
}
