// Binding of the engine that takes small steps: arrays in and out, the threads run with the interpreter unlocked.
#include "boxes/newton_steps/engine.hpp"
#include "boxes/newton_steps/time_step.hpp"

#include <nanobind/stl/tuple.h>
#include <nanobind/stl/unique_ptr.h>

#include <memory>
#include <string>
#include <tuple>
#include <variant>

#include "newton_boxes.hpp"

namespace nb = nanobind;
using namespace nb::literals;
namespace hl = hardlimit;
namespace hp = hardlimit::boxes;
namespace steps = hardlimit::boxes::steps;
using namespace hl::bindings;

namespace {

struct Setting : BoxSetting {
    using BoxSetting::BoxSetting;
    double time_step = 0.0;

    template <class Archive>
    void exchange(Archive& archive) {
        BoxSetting::exchange(archive);
        archive(time_step);
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
    virtual std::vector<hl::i64> ended_by() const = 0;
    virtual hl::i64 ended_at_wall() const = 0;
    virtual double largest_compression() const = 0;
    virtual const steps::ContactLog& log() const = 0;
    virtual void state(double* position, double* velocity) const = 0;
    virtual hp::StepsObservables observe() const = 0;
    virtual std::vector<hp::ContactRecord> take_log() = 0;
    virtual std::vector<hp::ContactRecord> open_contacts() const = 0;
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
    std::vector<hl::i64> ended_by() const override { return steps_.ended_by(); }
    hl::i64 ended_at_wall() const override { return steps_.ended_at_wall(); }
    double largest_compression() const override { return steps_.largest_compression(); }
    const steps::ContactLog& log() const override { return steps_.log(); }
    void state(double* position, double* velocity) const override { steps_.state(position, velocity); }
    hp::StepsObservables observe() const override { return steps_.observe(); }
    std::vector<hp::ContactRecord> take_log() override { return steps_.take_log(); }
    std::vector<hp::ContactRecord> open_contacts() const override { return steps_.open_contacts(); }
    void save(hp::Writer& writer) override { steps_.save(writer); }

private:
    hp::NewtonSteps<Law> steps_;
};

class NewtonSteps {
public:
    NewtonSteps(Table positions, Table velocities, In radius, In mass, const Numbers& box,
                const std::vector<bool>& periodic, const Numbers& gravity, const LawChoice& law,
                double time_step, bool log) {
        require(time_step > 0.0, "time_step: must be > 0");
        setting_ = {positions, velocities, radius, mass, box, periodic, gravity, law, log};
        setting_.time_step = time_step;
        const Numbers position = in_three(positions), velocity = in_three(velocities);
        engine_ = with_law(name_in(setting_.law), [&]<class Law>() -> std::unique_ptr<Engine> {
            return std::make_unique<EngineOf<Law>>(setting_.box, position, velocity, setting_.laws<Law>(),
                                                   time_step, log);
        });
    }
    static std::unique_ptr<NewtonSteps> load(nb::bytes state) {
        std::unique_ptr<NewtonSteps> made(new NewtonSteps);
        auto& s = made->setting_;
        made->engine_ = loaded(mark, state, s, [&](hp::Reader& reader) {
            return with_law(name_in(s.law), [&]<class Law>() -> std::unique_ptr<Engine> {
                return std::make_unique<EngineOf<Law>>(s.box, s.laws<Law>(), s.mass.size(), s.time_step,
                                                       s.log, reader);
            });
        });
        return made;
    }
    nb::bytes save() { return saved(mark, setting_, *engine_); }

    Engine& engine() { return *engine_; }
    const Engine& engine() const { return *engine_; }
    const Setting& setting() const { return setting_; }

private:
    static constexpr const char* mark = "NewtonSteps 6";
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
    d["largest_compression"] = run.engine().largest_compression();
    d["n_in_contact"] = seen.in_contact;
    const steps::ContactLog& log = run.engine().log();
    d["n_contacts"] = log.begun();
    d["n_pairs"] = log.pairs();
    d["n_ended"] = log.ended();
    d["n_overlapped"] = log.overlapped();
    return d;
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
        .def_prop_ro(
            "early_end", [](const NewtonSteps& run) { return early_end(run.engine()); }, early_end_text)
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
        "step_errors",
        [](const Contact& c, double speed, double time_step) {
            return std::visit(
                [&](const auto& law) {
                    const steps::ContactErrors found =
                        steps::contact_errors(law, c.pair.effective_mass, speed, time_step);
                    return std::tuple(found.restitution, found.energy, found.position);
                },
                c.law);
        },
        "contact"_a, "speed"_a, "time_step"_a,
        "The largest errors that steps make in an isolated contact: of ε; of the energy balance, relative to the "
        "energy of the impact; of positions after it, relative to the way at the speed of impact in its duration. "
        "Infinite where a contact does not end.");
    m.def(
        "longest_step",
        [](const Contact& c, double speed, double error) {
            return std::visit(
                [&](const auto& law) {
                    return steps::longest_step(law, c.pair.effective_mass, speed, error);
                },
                c.law);
        },
        "contact"_a, "speed"_a, "error"_a, "The longest time step whose `step_errors` are at most `error`.");
}
