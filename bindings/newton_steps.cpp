// Binding of the engine that takes small steps: arrays in and out, the threads run with the interpreter unlocked.
#include "particles/newton_steps.hpp"

#include <nanobind/stl/array.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include <array>
#include <memory>
#include <string>
#include <tuple>
#include <variant>

#include "arrays.hpp"
#include "contact.hpp"

namespace nb = nanobind;
using namespace nb::literals;
namespace hl = hardlimit;
namespace hp = hardlimit::particles;
namespace steps = hardlimit::particles::steps;
using hl::bindings::In;
using hl::bindings::make_array;

namespace {

using Table = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Numbers = std::vector<double>;

void require(bool met, const char* what) {
    if (!met) throw nb::value_error(what);
}

// A law as (name, alternative, parameters), as make_contact takes it.
using LawChoice = std::tuple<std::string, int, Numbers>;

std::vector<char> letters(const std::string& text) { return {text.begin(), text.end()}; }
std::string name_in(const std::vector<char>& letters) { return {letters.begin(), letters.end()}; }

// What a run is made of, beside the state.
struct Setting {
    steps::Box box{};
    Numbers mass, radius;   // [N]
    std::vector<char> law;  // its name
    int alternative = 0;
    Numbers parameters;
    double time_step = 0.0;
    bool log = false;

    template <class Archive>
    void exchange(Archive& archive) {
        archive(box), archive(mass), archive(radius), archive(law), archive(alternative), archive(parameters);
        archive(time_step), archive(log);
    }
};

// The engine of any law.
class Engine {
public:
    virtual ~Engine() = default;
    virtual void advance(double until, std::uint64_t most_steps, int threads, const nb::object& progress) = 0;
    virtual bool paused() const = 0;
    virtual double time() const = 0;
    virtual std::uint64_t steps_taken() const = 0;
    virtual std::uint64_t lists_made() const = 0;
    virtual double skin() const = 0;
    virtual hl::Outcome outcome() const = 0;
    virtual const steps::ContactLog& log() const = 0;
    virtual void state(double* position, double* velocity) const = 0;
    virtual hp::StepsObservables observe() const = 0;
    virtual std::vector<steps::Row> take_log() = 0;
    virtual std::vector<steps::Row> open_contacts() const = 0;
    virtual void save(hp::Writer& writer) = 0;
};

template <class Law>
class EngineOf : public Engine {
public:
    template <class... Arguments>
    explicit EngineOf(Arguments&&... arguments) : steps_(std::forward<Arguments>(arguments)...) {}

    void advance(double until, std::uint64_t most_steps, int threads, const nb::object& progress) override {
        bool raised = false;
        {
            hl::bindings::Unlocked open;
            const auto watch = [&] {
                open.lock();
                raised = PyErr_CheckSignals() != 0;
                if (!raised && !progress.is_none()) {
                    try {
                        progress(steps_.time_reached(), steps_.contacts_reached());
                    } catch (nb::python_error& e) {
                        e.restore();
                        raised = true;
                    }
                }
                open.unlock();
                return raised;
            };
            steps_.advance(until, most_steps, threads, open.period, watch);
        }
        if (raised) throw nb::python_error();
    }
    bool paused() const override { return steps_.paused(); }
    double time() const override { return steps_.time(); }
    std::uint64_t steps_taken() const override { return steps_.steps_taken(); }
    std::uint64_t lists_made() const override { return steps_.lists_made(); }
    double skin() const override { return steps_.skin(); }
    hl::Outcome outcome() const override { return steps_.outcome(); }
    const steps::ContactLog& log() const override { return steps_.log(); }
    void state(double* position, double* velocity) const override { steps_.state(position, velocity); }
    hp::StepsObservables observe() const override { return steps_.observe(); }
    std::vector<steps::Row> take_log() override { return steps_.take_log(); }
    std::vector<steps::Row> open_contacts() const override { return steps_.open_contacts(); }
    void save(hp::Writer& writer) override { steps_.save(writer); }

private:
    hp::NewtonSteps<Law> steps_;
};

// visit.operator()<Law>() for the law of this name.
template <class Visit>
auto with_law(const std::string& name, const Visit& visit) {
#define HL_LAW(Law) \
    if (name == hl::contact::Law::record.name) return visit.template operator()<hl::contact::Law>();
    HARDLIMIT_LAWS(HL_LAW)
#undef HL_LAW
    throw nb::value_error(("law: unknown name " + name).c_str());
}

template <class Law>
steps::PairLaws<Law> laws_of(const Setting& s) {
    const hl::LawRecord& record = Law::record;
    require(s.alternative >= 0 && s.alternative < record.n_alternatives,
            "alternative: the law has no such set of parameters");
    const int wanted = record.n_common + record.n_in_alternative[s.alternative];
    require(s.parameters.size() == static_cast<std::size_t>(wanted), "parameters: wrong number of values");
    return {s.alternative, s.parameters, s.mass, s.radius};
}

Numbers numbers(In array) { return {array.data(), array.data() + array.shape(0)}; }
// [N, d] as [3 N], with zeros where there is no third axis.
Numbers in_three(Table table) {
    const std::size_t n = table.shape(0), d = table.shape(1);
    Numbers out(3 * n, 0.0);
    for (std::size_t i = 0; i < n; ++i)
        std::copy_n(table.data() + d * i, d, out.begin() + static_cast<long>(3 * i));
    return out;
}
auto rows(const Numbers& three, int dimension) {
    const auto d = static_cast<std::size_t>(dimension);
    Numbers out;
    for (std::size_t at = 0; at < three.size(); at += 3)
        out.insert(out.end(), three.begin() + static_cast<long>(at),
                   three.begin() + static_cast<long>(at + d));
    return make_array(std::move(out), {three.size() / 3, d});
}

class NewtonSteps {
public:
    NewtonSteps(Table positions, Table velocities, In radius, In mass, const Numbers& box,
                const std::vector<bool>& periodic, const Numbers& gravity, const LawChoice& law,
                double time_step, bool log) {
        const std::size_t n = positions.shape(0), d = positions.shape(1);
        require(n > 0 && n < (std::size_t{1} << steps::Pair::bits),
                "positions: must be 1 to 2^27 - 1 bodies");
        require(d == 2 || d == 3, "positions: must have two or three columns");
        require(velocities.shape(0) == n && velocities.shape(1) == d,
                "velocities: must have the shape of positions");
        require(radius.shape(0) == n && mass.shape(0) == n,
                "radius | mass: must be one number for each body");
        require(box.size() == d && periodic.size() == d && gravity.size() == d,
                "box | periodic | gravity: must be one for each axis");
        require(time_step > 0.0, "time_step: must be > 0");
        setting_.mass = numbers(mass), setting_.radius = numbers(radius);
        const auto& [name, alternative, parameters] = law;
        setting_.law = letters(name), setting_.alternative = alternative, setting_.parameters = parameters;
        setting_.time_step = time_step, setting_.log = log;
        setting_.box.dimension = static_cast<int>(d);
        for (std::size_t axis = 0; axis < d; ++axis) {
            setting_.box.edge[axis] = box[axis];
            setting_.box.periodic[axis] = periodic[axis];
            setting_.box.gravity[axis] = gravity[axis];
        }
        const Numbers position = in_three(positions), velocity = in_three(velocities);
        engine_ = with_law(name, [&]<class Law>() -> std::unique_ptr<Engine> {
            return std::make_unique<EngineOf<Law>>(setting_.box, position, velocity, laws_of<Law>(setting_),
                                                   time_step, log);
        });
    }
    static std::unique_ptr<NewtonSteps> load(nb::bytes state) {
        hp::Reader reader(state.c_str(), state.size());
        require(reader.whole(), "state: not a saved run, or damaged");
        std::vector<char> mark;
        reader(mark);
        require(name_in(mark) == version, "state: not of a run by steps of this version");
        std::unique_ptr<NewtonSteps> made(new NewtonSteps);
        Setting& s = made->setting_;
        s.exchange(reader);
        made->engine_ = with_law(name_in(s.law), [&]<class Law>() -> std::unique_ptr<Engine> {
            return std::make_unique<EngineOf<Law>>(s.box, laws_of<Law>(s), s.mass.size(), s.time_step, s.log,
                                                   reader);
        });
        require(!reader.failed(), "state: damaged");
        return made;
    }
    nb::bytes save() {
        hp::Writer writer;
        writer(letters(version));
        setting_.exchange(writer);
        engine_->save(writer);
        const std::vector<char> bytes = writer.finish();
        return nb::bytes(bytes.data(), bytes.size());
    }

    Engine& engine() { return *engine_; }
    const Engine& engine() const { return *engine_; }
    const Setting& setting() const { return setting_; }

private:
    static constexpr const char* version = "NewtonSteps 1";
    Setting setting_;
    std::unique_ptr<Engine> engine_;

    NewtonSteps() = default;
};

nb::tuple state(const NewtonSteps& run) {
    Numbers position(3 * run.setting().mass.size()), velocity(position.size());
    run.engine().state(position.data(), velocity.data());
    const int d = run.setting().box.dimension;
    return nb::make_tuple(rows(position, d), rows(velocity, d));
}

nb::dict observe(const NewtonSteps& run) {
    const hp::StepsObservables seen = run.engine().observe();
    nb::dict d;
    d["kinetic_energy"] = seen.kinetic;
    d["potential_energy"] = seen.potential;
    d["contact_energy"] = seen.contact;
    d["dissipated_energy"] = seen.dissipated;
    const auto axes = static_cast<std::size_t>(run.setting().box.dimension);
    d["momentum"] = make_array(Numbers(seen.momentum, seen.momentum + axes), {axes});
    d["virial"] = seen.virial;
    d["kinetic_integral"] = nb::none();
    d["n_in_contact"] = seen.in_contact;
    return d;
}

nb::tuple columns(const std::vector<steps::Row>& rows) {
    const std::size_t n = rows.size();
    Numbers begin, end, impact, separation;
    std::vector<std::int64_t> first, second;
    std::vector<std::uint8_t> overlapped;
    for (const steps::Row& r : rows) {
        begin.push_back(r.begin), end.push_back(r.end);
        first.push_back(r.first), second.push_back(r.second);
        impact.push_back(r.impact_speed), separation.push_back(r.separation_speed);
        overlapped.push_back(r.overlapped);
    }
    return nb::make_tuple(make_array(std::move(begin), {n}), make_array(std::move(end), {n}),
                          make_array(std::move(first), {n}), make_array(std::move(second), {n}),
                          make_array(std::move(impact), {n}), make_array(std::move(separation), {n}),
                          make_array(std::move(overlapped), {n}));
}

void bind_engine(nb::module_& m) {
    nb::class_<NewtonSteps>(m, "NewtonSteps",
                            "Newton's equations for a box of spheres or disks in small equal steps.")
        .def(nb::init<Table, Table, In, In, const Numbers&, const std::vector<bool>&, const Numbers&,
                      const LawChoice&, double, bool>(),
             "positions"_a, "velocities"_a, "radius"_a, "mass"_a, "box"_a, "periodic"_a, "gravity"_a, "law"_a,
             "time_step"_a, "log"_a = false)
        .def(
            "advance",
            [](NewtonSteps& run, double until, int threads, std::uint64_t most_steps,
               const nb::object& progress) {
                require(threads >= 1, "threads: must be >= 1");
                require(most_steps >= 1, "most_steps: must be >= 1");
                run.engine().advance(until, most_steps, threads, progress);
            },
            "until"_a, "threads"_a = 1, "most_steps"_a = ~std::uint64_t{0}, "progress"_a = nb::none(),
            "To `until` [s], or so many steps of the way; what was paused goes on with the same bits.")
        .def_prop_ro("paused", [](const NewtonSteps& run) { return run.engine().paused(); })
        .def_prop_ro("time", [](const NewtonSteps& run) { return run.engine().time(); })
        .def_prop_ro("time_step", [](const NewtonSteps& run) { return run.setting().time_step; })
        .def_prop_ro("n_steps", [](const NewtonSteps& run) { return run.engine().steps_taken(); })
        .def_prop_ro("n_lists", [](const NewtonSteps& run) { return run.engine().lists_made(); })
        .def_prop_ro("skin", [](const NewtonSteps& run) { return run.engine().skin(); })
        .def_prop_ro("n_contacts", [](const NewtonSteps& run) { return run.engine().log().begun(); })
        .def_prop_ro("n_pairs", [](const NewtonSteps& run) { return run.engine().log().pairs(); })
        .def_prop_ro("n_ended", [](const NewtonSteps& run) { return run.engine().log().ended(); })
        .def_prop_ro("n_overlapped", [](const NewtonSteps& run) { return run.engine().log().overlapped(); })
        .def_prop_ro("outcome",
                     [](const NewtonSteps& run) {
                         return hl::outcome_records[static_cast<int>(run.engine().outcome())].name;
                     })
        .def("state", &state, "Positions along the unfolded paths and velocities (N, d) at `time`.")
        .def("observe", &observe)
        .def(
            "take_log", [](NewtonSteps& run) { return columns(run.engine().take_log()); },
            "Contacts that ended since the last call: begin, end, first, second, impact_speed, separation_speed, "
            "overlapped.")
        .def(
            "open_contacts", [](const NewtonSteps& run) { return columns(run.engine().open_contacts()); },
            "The same of contacts that last; their end is NaN.")
        .def("save", &NewtonSteps::save)
        .def_static("load", &NewtonSteps::load, "state"_a);
}

}  // namespace

void bind_newton_steps(nb::module_& m) {
    bind_engine(m);
    using hl::bindings::Contact;
    m.def(
        "restitution_error",
        [](const Contact& c, double speed, double time_step) {
            return std::visit(
                [&](const auto& law) {
                    return steps::restitution_error(law, c.pair.effective_mass, speed, time_step);
                },
                c.law);
        },
        "contact"_a, "speed"_a, "time_step"_a,
        "The largest error of the coefficient of restitution that steps make; NaN where a contact does not end.");
    m.def(
        "longest_step",
        [](const Contact& c, double speed, double error) {
            return std::visit(
                [&](const auto& law) {
                    return steps::longest_step(law, c.pair.effective_mass, speed, error);
                },
                c.law);
        },
        "contact"_a, "speed"_a, "error"_a,
        "The longest time step whose error of the restitution is at most `error`.");
}
