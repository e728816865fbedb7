// Binding of the engine that goes from event to event: arrays in and out, runs with the interpreter unlocked.
#include "boxes/newton_events/engine.hpp"

#include <nanobind/stl/unique_ptr.h>

#include <memory>
#include <string>

#include "newton_boxes.hpp"
#include "touch_kernels.hpp"

namespace nb = nanobind;
using namespace nb::literals;
namespace hl = hardlimit;
namespace hp = hardlimit::boxes;
using namespace hl::bindings;

namespace {

// The engine of any law.
class Engine {
public:
    virtual ~Engine() = default;
    virtual void advance(double until, std::uint64_t most_events, hl::Stop& stop) = 0;
    virtual bool paused() const = 0;
    virtual double time() const = 0;
    virtual std::uint64_t events() const = 0;
    virtual std::uint64_t contacts_reached() const = 0;
    virtual std::uint64_t contacts_logged() const = 0;
    virtual hl::Outcome outcome() const = 0;
    virtual std::vector<hl::i64> ended_by() const = 0;
    virtual hl::i64 ended_at_wall() const = 0;
    virtual int largest_cluster() const = 0;
    virtual double cluster_share() const = 0;
    virtual hp::NewtonObservation observe() const = 0;
    virtual double safety_radius_used(int instants) const = 0;
    virtual std::vector<hp::ContactRecord> take_log() = 0;
    virtual void save(hp::Writer& writer) const = 0;
};

template <class Law>
class EngineOf : public Engine {
public:
    template <class... Arguments>
    explicit EngineOf(Arguments&&... arguments) : run_(std::forward<Arguments>(arguments)...) {}

    void advance(double until, std::uint64_t most_events, hl::Stop& stop) override {
        run_.advance(until, most_events, stop);
    }
    bool paused() const override { return run_.paused(); }
    double time() const override { return run_.time(); }
    std::uint64_t events() const override { return run_.events(); }
    std::uint64_t contacts_reached() const override { return run_.contacts_reached(); }
    std::uint64_t contacts_logged() const override { return run_.contacts_logged(); }
    hl::Outcome outcome() const override { return run_.outcome(); }
    std::vector<hl::i64> ended_by() const override { return run_.ended_by(); }
    hl::i64 ended_at_wall() const override { return run_.ended_at_wall(); }
    int largest_cluster() const override { return run_.largest_cluster(); }
    double cluster_share() const override { return run_.cluster_share(); }
    hp::NewtonObservation observe() const override { return run_.observe(); }
    double safety_radius_used(int instants) const override { return run_.safety_radius_used(instants); }
    std::vector<hp::ContactRecord> take_log() override { return run_.take_log(); }
    void save(hp::Writer& writer) const override { run_.save(writer); }

private:
    hp::NewtonEvents<Law> run_;
};

class NewtonEvents {
public:
    NewtonEvents(Table positions, Table velocities, In radius, In mass, const Numbers& box,
                 const std::vector<bool>& periodic, const Numbers& gravity, const LawChoice& law, bool log)
        : setting_(positions, velocities, radius, mass, box, periodic, gravity, law, log) {
        const Numbers position = in_three(positions), velocity = in_three(velocities);
        engine_ = with_law(name_in(setting_.law), [&]<class Law>() -> std::unique_ptr<Engine> {
            return std::make_unique<EngineOf<Law>>(setting_.box, position, velocity, setting_.laws<Law>(),
                                                   log, touch_kernels());
        });
    }
    static std::unique_ptr<NewtonEvents> load(nb::bytes state) {
        std::unique_ptr<NewtonEvents> made(new NewtonEvents);
        auto& s = made->setting_;
        made->engine_ = loaded(mark, state, s, [&](hp::Reader& reader) {
            return with_law(name_in(s.law), [&]<class Law>() -> std::unique_ptr<Engine> {
                return std::make_unique<EngineOf<Law>>(s.box, s.laws<Law>(), s.mass.size(), s.log,
                                                       touch_kernels(), reader);
            });
        });
        return made;
    }
    nb::bytes save() { return saved(mark, setting_, *engine_); }

    // Where Ctrl-C was pressed, the run stays where it had got to.
    void advance(double until, std::uint64_t most_events) {
        require(most_events >= 1, "most_events: must be >= 1");
        unlocked([&](hl::Stop& stop) {
            engine_->advance(until, most_events, stop);
            return true;
        });
    }

    Engine& engine() { return *engine_; }
    const Engine& engine() const { return *engine_; }
    const BoxSetting& setting() const { return setting_; }

private:
    static constexpr const char* mark = "NewtonEvents 8";
    BoxSetting setting_;
    std::unique_ptr<Engine> engine_;

    NewtonEvents() = default;
};

nb::tuple state(const NewtonEvents& run) {
    const hp::NewtonObservation seen = run.engine().observe();
    const int d = run.setting().box.dimension;
    return nb::make_tuple(rows(seen.position, d), rows(seen.velocity, d));
}

nb::dict observe(const NewtonEvents& run) {
    const hp::NewtonObservation seen = run.engine().observe();
    nb::dict d;
    d["kinetic_energy"] = seen.kinetic;
    d["potential_energy"] = seen.potential;
    d["contact_energy"] = seen.contact;
    d["dissipated_energy"] = seen.dissipated;
    const auto axes = static_cast<std::size_t>(run.setting().box.dimension);
    d["momentum"] = make_array(Numbers(seen.momentum, seen.momentum + axes), {axes});
    d["virial"] = seen.virial;
    d["kinetic_integral"] = nb::none();
    d["largest_compression"] = seen.largest_compression;
    d["n_in_contact"] = seen.in_contact;
    d["n_contacts"] = seen.begun;
    d["n_pairs"] = seen.begun_pairs;
    d["n_ended"] = seen.ended;
    d["n_overlapped"] = seen.overlapped;
    return d;
}

}  // namespace

void bind_newton_events(nb::module_& m) {
    nb::class_<NewtonEvents>(m, "NewtonEvents", "Newton's equations for a box of spheres or disks by events.")
        .def(nb::init<Table, Table, In, In, const Numbers&, const std::vector<bool>&, const Numbers&,
                      const LawChoice&, bool>(),
             "positions"_a, "velocities"_a, "radius"_a, "mass"_a, "box"_a, "periodic"_a, "gravity"_a, "law"_a,
             "log"_a = false)
        .def("advance", &NewtonEvents::advance, "until"_a, "most_events"_a = ~std::uint64_t{0},
             "To `until` [s], or so many events of the way; what was paused goes on with the same bits.")
        .def_prop_ro("paused", [](const NewtonEvents& run) { return run.engine().paused(); })
        .def_prop_ro("time", [](const NewtonEvents& run) { return run.engine().time(); })
        .def_prop_ro("n_events", [](const NewtonEvents& run) { return run.engine().events(); })
        .def_prop_ro(
            "contacts_reached", [](const NewtonEvents& run) { return run.engine().contacts_reached(); },
            "Contacts so far, but for those that began in a cluster that is still together.")
        .def_prop_ro(
            "n_logged", [](const NewtonEvents& run) { return run.engine().contacts_logged(); },
            "Contacts known to be over.")
        .def_prop_ro("largest_cluster",
                     [](const NewtonEvents& run) { return run.engine().largest_cluster(); })
        .def(
            "safety_radius_used",
            [](const NewtonEvents& run, int instants) { return run.engine().safety_radius_used(instants); },
            "instants"_a,
            "Largest part of its safety radius that a body in contact uses, at most 1. For tests.")
        .def_prop_ro("cluster_share", [](const NewtonEvents& run) { return run.engine().cluster_share(); })
        .def_prop_ro("outcome",
                     [](const NewtonEvents& run) {
                         return hl::outcome_records[static_cast<int>(run.engine().outcome())].name;
                     })
        .def_prop_ro(
            "early_end", [](const NewtonEvents& run) { return early_end(run.engine()); }, early_end_text)
        .def("state", &state, "Positions along the unfolded paths and velocities (N, d) at `time`.")
        .def("observe", &observe)
        .def(
            "take_log", [](NewtonEvents& run) { return columns(run.engine().take_log()); },
            "Contacts known to be over since the last call: begin, end, first, second, impact_speed, "
            "separation_speed, overlapped.")
        .def(
            "open_contacts", [](const NewtonEvents& run) { return columns(run.engine().observe().open); },
            "The same of contacts that last, whose end is NaN, and of those whose cluster is still together.")
        .def("save", &NewtonEvents::save)
        .def_static("load", &NewtonEvents::load, "state"_a);
}
