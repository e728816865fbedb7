// Fuzz target: small boxes under Newton's equations by events, of every kind and under every law: some contacts,
// then saved, loaded and gone on with.
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

// Speeds and gravity such that all energy together compresses a contact by a part of the smallest radius.
template <class Law>
struct Case : fuzz::SmallBox {
    Box box{};
    std::vector<double> x, v;  // [3 N]
    PairLaws<Law> laws;
    double energy = 0.0, momentum = 0.0;  // the most there can be [J], [kg m/s]
    double depth = 0.0;                   // to which it compresses the softest contact [m]
    double until = 0.0;                   // [s]
    double least_restitution = 1.0;       // of an isolated contact at the speed there is

    explicit Case(Draw& draw) : fuzz::SmallBox(draw, 3, 4.2001), laws(make_laws(draw)) {
        const double smallest = *std::min_element(radius.begin(), radius.end());
        depth = draw.decades(1e-6, 0.02) * smallest;
        double total = 0.0;
        energy = math::infinity;
        for (std::size_t i = 0; i < s.n; ++i) {
            total += mass[i];
            for (std::int64_t j = -1; j < static_cast<std::int64_t>(s.n); ++j)
                energy = math::min(energy, of_depth(static_cast<std::int64_t>(i), j, depth));
        }
        const double unit = math::sqrt(2.0 * energy / (s.dimension * total)) / speed;
        box.dimension = s.dimension;
        const double fall = draw.decades(1e-3, 1.0);
        for (int k = 0; k < s.dimension; ++k) {
            box.edge[k] = s.edge[k];
            box.boundary[k] = s.box.boundary[k];
            box.gravity[k] = 0.1 * s.gravity[k] * fall * unit * unit * speed * speed / s.edge[k];
        }
        x.assign(3 * s.n, 0.0), v.assign(3 * s.n, 0.0);
        for (std::size_t i = 0; i < s.n; ++i)
            for (int k = 0; k < s.dimension; ++k) {
                const std::size_t to = 3 * i + static_cast<std::size_t>(k);
                const std::size_t from =
                    i * static_cast<std::size_t>(s.dimension) + static_cast<std::size_t>(k);
                x[to] = position[from], v[to] = unit * velocity[from];
            }
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
    }

    Law law(std::int64_t i, std::int64_t j) const { return laws(i, j); }
    double of_depth(std::int64_t i, std::int64_t j, double depth) const {
        return laws(i, j).energy(onset_root<Law::onset_power>(depth));
    }

private:
    PairLaws<Law> make_laws(Draw& draw) const {
        const fuzz::Material<Law> material(draw);
        const LawRecord& record = Law::record;
        const int n = record.n_common + record.n_in_alternative[material.alternative];
        return {material.alternative, {material.parameters, material.parameters + n}, mass, radius};
    }
};

template <class Law>
class Run {
public:
    using Engine = NewtonEvents<Law>;
    using Survey = typename Engine::Survey;

    explicit Run(const Case<Law>& c)
        : c_(c),
          engine_(std::make_unique<Engine>(c.box, c.x, c.v, c.laws, true, of(c))),
          start_(engine_->survey()) {}

    // So far, and what must be true there.
    void advance(double until) {
        const double before = engine_->time();
        Stop never;
        engine_->advance(until, most_events, never);
        require(engine_->time() >= before && engine_->time() <= until, "time goes on");
        check();
    }
    std::vector<char> save() const {
        Writer writer;
        engine_->save(writer);
        return writer.finish();
    }
    // Goes on with both, the one that was saved and the one that was loaded.
    void compare(const std::vector<char>& bytes, double until) {
        Reader reader(bytes.data(), bytes.size());
        require(reader.whole(), "what was saved is whole");
        Engine again(c_.box, c_.laws, c_.s.n, true, of(c_), reader);
        require(!reader.failed(), "what was saved can be loaded");
        Stop never;
        again.advance(until, most_events, never);
        advance(until);
        const Survey a = engine_->survey(), b = again.survey();
        require(engine_->time() == again.time() && a.position == b.position && a.velocity == b.velocity,
                "what was loaded goes on with the same bits");
        require(a.begun == b.begun && a.ended == b.ended && a.dissipated == b.dissipated,
                "what was loaded counts the same");
    }

private:
    static constexpr std::uint64_t most_events = 50;  // of an advance
    const Case<Law>& c_;
    std::unique_ptr<Engine> engine_;
    Survey start_;
    double dissipated_ = 0.0;
    double slack_ = 0.0;  // of what overlaps without force: not lost where it is pressed again [J]

    static const hardlimit_abi::TouchKernels& of(const Case<Law>& c) {
        return c.wide ? kernels<8> : kernels<2>;
    }
    static double sum(const Survey& s) { return s.kinetic + s.potential + s.contact + s.dissipated; }

    void check() {
        const Survey now = engine_->survey();
        for (const auto* numbers : {&now.position, &now.velocity})
            for (const double value : *numbers)
                require(math::is_finite(value), "finite places and velocities");
        require(engine_->outcome() == Outcome::ok, "so few bodies are resolved");
        double scale = c_.energy + math::abs(start_.potential) + now.kinetic;
        for (std::size_t i = 0; i < c_.s.n; ++i)
            for (int k = 0; k < c_.s.dimension; ++k)
                scale += c_.mass[i] *
                         math::abs(c_.box.gravity[k] * now.position[3 * i + static_cast<std::size_t>(k)]);
        // Contacts are integrated to about 1e-11 of the energy in a step, and there are tens of steps in each. A
        // compression is known to the rounding of the places it is the difference of.
        const double farthest = math::max(math::max(c_.box.edge[0], c_.box.edge[1]), c_.box.edge[2]);
        const double of_contact = 5e-10 + 20.0 * math::epsilon * farthest / c_.depth;
        const double balance = 1e-9 + of_contact * static_cast<double>(now.begun);
        require(math::abs(sum(now) - sum(start_)) <= balance * scale, "energy is balanced");
        require(now.dissipated >= dissipated_ - slack_ - 1e-9 * scale, "what is lost is lost");
        dissipated_ = now.dissipated;
        bool free = true;
        for (int k = 0; k < c_.s.dimension; ++k)
            free = free && c_.box.wraps(k) && c_.box.gravity[k] == 0.0;
        for (int k = 0; free && k < c_.s.dimension; ++k)
            require(math::abs(now.momentum[k] - start_.momentum[k]) <= 1e-10 * c_.momentum,
                    "momentum is kept");
        check_overlaps(now, scale);
        require(engine_->margin_used(5) <= 1.0, "true paths keep to the space that is left to them");
        for (const ContactRecord& row : engine_->take_log())
            require(row.begin >= 0.0 && row.end >= row.begin && row.end <= engine_->time() &&
                        (row.second < 0 || row.first < row.second),
                    "contacts begin and end");
    }

    // Nobody is deeper in another one than all energy could press him; who approaches there is in contact.
    void check_overlaps(const Survey& now, double energy) {
        slack_ = 0.0;
        const auto n = static_cast<std::int64_t>(c_.s.n);
        for (std::int64_t i = 0; i < n; ++i) {
            for (std::int64_t j = i + 1; j < n; ++j) {
                double square = 0.0, inwards = 0.0;
                for (int k = 0; k < c_.s.dimension; ++k) {
                    const auto a = static_cast<std::size_t>(3 * i + k),
                               b = static_cast<std::size_t>(3 * j + k);
                    double r = now.position[b] - now.position[a];
                    if (c_.box.wraps(k)) r -= c_.box.edge[k] * math::round_small(r / c_.box.edge[k]);
                    square += r * r;
                    inwards -= r * (now.velocity[b] - now.velocity[a]);
                }
                check_overlap(now, i, j, c_.radius[i] + c_.radius[j] - math::sqrt(square), inwards, energy);
            }
            for (int k = 0; k < c_.s.dimension; ++k) {
                if (c_.box.wraps(k)) continue;
                const auto a = static_cast<std::size_t>(3 * i + k);
                const double at = now.position[a], speed = now.velocity[a];
                check_overlap(now, i, -1 - 2 * k, c_.radius[i] - at, -speed, energy);
                check_overlap(now, i, -2 - 2 * k, c_.radius[i] - (c_.box.edge[k] - at), speed, energy);
            }
        }
    }
    void check_overlap(const Survey& now, std::int64_t i, std::int64_t j, double depth, double inwards,
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
        if (fault_of(c.s).kind != Fault::none || !(c.energy > 0.0) || !math::is_finite(c.until)) return;
        if (!(c.least_restitution > 1e-3)) return;  // what creeps takes steps without number
        Run<Law> run(c);
        const double first = draw.between(0.0, c.until);
        run.advance(first);
        run.compare(run.save(), c.until);
    });
    return 0;
}
