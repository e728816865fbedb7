// Bindings of particle simulations: the box, one class for all engines, random packings, the deepest overlap.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <array>
#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "boxes/common/random.hpp"
#include "boxes/common/system_check.hpp"
#include "boxes/hard_spheres/rules/registry.hpp"
#include "boxes/neighbours/overlap.hpp"
#include "contact.hpp"
#include "engines.hpp"

namespace nb = nanobind;
using namespace nb::literals;
namespace hl = hardlimit;
namespace box = hardlimit::boxes;
using hl::bindings::dict_of;
using hl::bindings::In;
using hl::bindings::list_of;
using hl::bindings::make_array;
using hl::bindings::require;
using hl::bindings::require_values;
using hl::bindings::shown;
using hl::bindings::unlocked;
using hl::bindings::Unlocked;
using hl::bindings::value_error;

namespace {

using Rows = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

// --- checks -------------------------------------------------------------------------------------------------

void require_particles(std::size_t n) {
    require(n > 0 && n < (std::size_t{1} << 27),
            "positions: got " + std::to_string(n) + " particles, must be at least 1 and < 2^27");
}

void require_spins(Rows spins, std::size_t n) {
    require_values("spins", spins.size(), 3 * n, "three for each particle, also in two dimensions");
}

// The engines index cells by positions and sizes. Python has checked the values.
void require_no_fault(const box::Fault& fault) {
    require(fault.kind == box::Fault::none,
            "system: got values of particle " + std::to_string(fault.particle) +
                " out of range or out of the box, must be those of a ParticleSystem");
}

// The place of a word among those of an argument.
template <std::size_t n>
int place_of(const char* argument, const std::string& word, const char* const (&words)[n]) {
    const auto* const place = std::ranges::find(words, std::string_view(word));
    require(place != std::end(words), std::string(argument) + ": got " + word + ", must be a known word");
    return static_cast<int>(place - words);
}

// --- the box ------------------------------------------------------------------------------------------------

constexpr const char* boundary_names[] = {"none", "periodic", "wall", "lees-edwards"};

constexpr const char* waveform_names[] = {"none", "sine", "triangle", "parabola"};

// Number of the wall, offset, velocity, amplitude, frequency, phase and waveform.
using WallMotions = std::vector<std::tuple<hl::i64, double, double, double, double, double, std::string>>;

void move_walls(box::Box& made, const WallMotions& moving) {
    for (const auto& [number, offset, velocity, amplitude, frequency, phase, waveform] : moving) {
        const box::WallId id{static_cast<std::int32_t>(number)};
        require(number < 0 && number >= -box::most_walls && made.has_walls(id.axis()),
                "moving_walls: got the number " + std::to_string(number) + ", must be that of a wall");
        box::WallMotion m{offset, velocity, amplitude, frequency, phase / (2.0 * hl::math::pi)};
        m.waveform = static_cast<box::Waveform>(place_of("moving_walls", waveform, waveform_names));
        made.move_wall(id, m);
    }
}

box::Box make_box(const std::vector<double>& edges, const std::vector<std::string>& boundary,
                  const std::optional<std::vector<double>>& gravity, const WallMotions& moving_walls,
                  double shear_rate, double shear_displacement) {
    const std::size_t d = edges.size();
    require(d == 2 || d == 3, "box: got " + std::to_string(d) + " edges, must be 2 or 3");
    require_values("boundary", boundary.size(), d, "one for each axis");
    if (gravity) require_values("gravity", gravity->size(), d, "one for each axis");
    box::Box made;
    made.dimension = static_cast<int>(d);
    for (std::size_t k = 0; k < d; ++k) {
        made.edge[k] = edges[k];
        if (gravity) made.gravity[k] = (*gravity)[k];
        made.boundary[k] = static_cast<box::Boundary>(place_of("boundary", boundary[k], boundary_names));
        if (made.boundary[k] == box::Boundary::lees_edwards)
            made.shear(static_cast<int>(k), shear_rate, shear_displacement);
    }
    move_walls(made, moving_walls);
    return made;
}

nb::tuple boundaries(const box::Box& b) {
    nb::list names;
    for (int k = 0; k < b.dimension; ++k) names.append(boundary_names[static_cast<int>(b.boundary[k])]);
    return nb::tuple(names);
}

auto walls(const box::Box& b, double time) {
    std::vector<std::tuple<hl::i64, double, double>> all;
    for (const box::Wall& w : b.walls()) all.emplace_back(w.id.number, w.position(time), w.velocity(time));
    return all;
}

// --- the engines --------------------------------------------------------------------------------------------

constexpr const hl::bindings::EngineRecord* engines[] = {&hl::bindings::hard_spheres_engine,
                                                         &hl::bindings::newton_events_engine,
                                                         &hl::bindings::newton_steps_engine};

const hl::bindings::EngineRecord& engine_record(const std::string& kind) {
    for (const auto* record : engines)
        if (kind == record->name) return *record;
    throw value_error("kind: got " + kind + ", must be hard_spheres, newton_events or newton_steps");
}

// A law as (name, alternative, parameters, friction), as make_contact takes it.
using Law = std::tuple<std::string, int, std::vector<double>, std::optional<hl::Friction>>;

box::LawChoice law_choice(const Law& law) {
    const auto& [name, alternative, parameters, friction] = law;
    box::LawChoice choice = hl::bindings::law_choice(name, alternative, parameters);
    if (friction) choice.friction = *friction;
    return choice;
}

box::RuleChoice rule_choice(const std::string& name, double restitution, double friction,
                            double tangential_restitution, const std::optional<Law>& law,
                            const std::vector<double>& parameters) {
    box::RuleChoice choice;
    if (law) choice.law = law_choice(*law);
    while (choice.rule < box::rule_count && name != box::rule_records[choice.rule].name) ++choice.rule;
    require(choice.rule < box::rule_count, "rule: got " + name + ", must be a registered rule");
    const box::RuleRecord& record = box::rule_records[choice.rule];
    require(record.takes_restitution || law, "law: got None, must be a law for the rule " + name);
    if (!record.takes_law) choice.law = {};
    if (!choice.law) {
        choice.restitution = restitution;
        choice.friction = friction, choice.tangential_restitution = tangential_restitution;
    }
    require_values("rule_parameters", parameters.size(), static_cast<std::size_t>(record.n_parameters),
                   "those of the rule");
    std::ranges::copy(parameters, choice.parameters);
    return choice;
}

nb::tuple rule_records() {
    const auto parameter = [](const auto& p) {
        return dict_of("name", p.name, "unit", p.unit, "meaning", p.meaning);
    };
    return nb::tuple(list_of(box::rule_records, [&](const box::RuleRecord& r) {
        const auto n = static_cast<std::size_t>(r.n_parameters);
        const auto counts =
            list_of(r.counts, static_cast<std::size_t>(r.n_counts), [](const char* c) { return c; });
        return dict_of("name", r.name, "meaning", r.meaning, "assumes", r.assumes, "source", r.source,
                       "restitution", r.takes_restitution, "law", r.takes_law, "knows_duration",
                       r.knows_duration, "error", r.error, "counts", nb::tuple(counts), "share", r.share,
                       "parameters", nb::tuple(list_of(r.parameters, n, parameter)));
    }));
}

// Columns of the contact log. `lasting`: contacts have a begin and an end; otherwise collisions have one time.
// `rubbing`: with friction.
nb::dict columns(const std::vector<box::ContactRecord>& rows, bool lasting, bool rubbing) {
    nb::dict d;
    const auto column = [&](const char* name, const auto& value) {
        d[name] = hl::bindings::column_of(rows, value);
    };
    using Row = box::ContactRecord;
    column(lasting ? "begin" : "time", [](const Row& r) { return r.begin; });
    if (lasting) column("end", [](const Row& r) { return r.end; });
    column("first", [](const Row& r) { return hl::i64{r.first}; });
    column("second", [](const Row& r) { return hl::i64{r.second}; });
    column("impact_speed", [](const Row& r) { return r.impact_speed; });
    column("separation_speed", [](const Row& r) { return r.separation_speed; });
    if (lasting) column("overlapped", [](const Row& r) { return std::uint8_t{r.overlapped}; });
    if (!rubbing) return d;
    column("tangential_speed", [](const Row& r) { return r.tangential_speed; });
    column("tangential_restitution", [](const Row& r) { return r.tangential_restitution; });
    column("slid", [](const Row& r) { return std::uint8_t{r.slid}; });
    return d;
}

class Engine {
public:
    Engine(const char* kind, std::unique_ptr<box::Engine> engine) : kind_(kind), engine_(std::move(engine)) {}
    Engine(Engine&& other) noexcept : kind_(other.kind_), engine_(std::move(other.engine_)) {}

    const char* kind() const { return kind_; }
    // Throws while another thread is in advance().
    box::Engine& get() const {
        if (running_) throw std::runtime_error("this run is being advanced by another thread");
        return *engine_;
    }

    void advance(double until, hl::u64 max_work, int threads) {
        box::Engine& engine = get();
        const Running running(running_);
        unlocked([&](hl::Stop& stop) {
            engine.advance(until, max_work, threads, stop);
            return true;
        });
    }

private:
    const char* kind_;
    std::unique_ptr<box::Engine> engine_;
    std::atomic<bool> running_{false};

    struct Running {
        std::atomic<bool>& flag;
        explicit Running(std::atomic<bool>& f) : flag(f) { flag = true; }
        ~Running() { flag = false; }
    };
};

Engine make_engine(const std::string& kind, const box::Box& bounds, Rows positions, Rows velocities,
                   In radius, In mass, const std::optional<Rows>& spins,
                   const std::optional<In>& inertia_factor, const std::optional<Law>& law,
                   const std::string& rule, double restitution, double friction,
                   double tangential_restitution, const std::vector<double>& rule_parameters,
                   double time_step, bool log) {
    const hl::bindings::EngineRecord& record = engine_record(kind);
    box::System s{bounds,        positions.shape(0), positions.data(), velocities.data(),
                  radius.data(), mass.data()};
    require_particles(s.n);
    require_values("positions", positions.shape(1), static_cast<std::size_t>(bounds.dimension),
                   "one for each axis of the box");
    require_values("velocities", velocities.size(), positions.size(), "as of positions");
    require_values("radius", radius.size(), s.n, "one for each particle");
    require_values("mass", mass.size(), s.n, "one for each particle");
    if (spins) {
        require_spins(*spins, s.n);
        s.angular_velocity = spins->data();
    }
    if (inertia_factor) {
        require_values("inertia_factor", inertia_factor->size(), s.n, "one for each particle");
        s.inertia_factor = inertia_factor->data();
    }
    hl::bindings::EngineArguments arguments;
    if (kind == "hard_spheres")
        arguments.rule =
            rule_choice(rule, restitution, friction, tangential_restitution, law, rule_parameters);
    else if (law)
        arguments.rule.law = law_choice(*law);
    else
        throw value_error("law: got None, must be a contact law");
    arguments.time_step = time_step;
    arguments.log = log;
    box::Fault fault;
    auto engine = unlocked([&](hl::Stop& stop) {
        fault = box::validate(s);
        return fault.kind == box::Fault::none ? record.make(s, arguments, stop) : nullptr;
    });
    require_no_fault(fault);
    return Engine(record.name, std::move(engine));
}

Engine load_engine(const std::string& kind, const nb::bytes& saved, hl::u64 kicks, double heat) {
    const hl::bindings::EngineRecord& record = engine_record(kind);
    const char* data = saved.c_str();
    const std::size_t n = saved.size();
    auto engine = unlocked([&](hl::Stop&) { return record.load(data, n); });
    if (!engine)
        throw value_error(
            "saved: got " + std::to_string(n) +
            " bytes that are damaged, cut short or of another engine or version, must be what save() "
            "gave");
    engine->kicks = {kicks, heat};
    return Engine(record.name, std::move(engine));
}

nb::bytes save(const Engine& e) {
    const std::vector<char> bytes = e.get().save();
    return nb::bytes(bytes.data(), bytes.size());
}

auto state(const Engine& e) {
    const std::size_t n = e.get().size(), d = static_cast<std::size_t>(e.get().dimension());
    std::vector<double> position(n * d), velocity(n * d);
    e.get().state(position.data(), velocity.data());
    return nb::make_tuple(make_array(std::move(position), {n, d}), make_array(std::move(velocity), {n, d}));
}

auto spins(const Engine& e) {
    if (!e.get().rotates()) throw value_error("spins: got an engine without friction, must be one with it");
    std::vector<double> spin(3 * e.get().size());
    e.get().spins(spin.data());
    return make_array(std::move(spin), {e.get().size(), 3});
}

// The numbers of a field of an observation: arrays have those that belong to the axes of the box.
struct NumbersOfField {
    int dimension;
    std::vector<double>& numbers;

    void operator()(double x) const { numbers.push_back(x); }
    void operator()(hl::u64 count) const { numbers.push_back(static_cast<double>(count)); }
    void operator()(const box::AxialVector& v) const {
        dimension == 2 ? numbers.push_back(v.component[2]) : add(v.component, 3);
    }
    void operator()(const double (&of_axes)[3]) const { add(of_axes, dimension); }
    void operator()(const double (&of_walls)[box::most_walls]) const { add(of_walls, 2 * dimension); }
    // In LAMMPS' order.
    void operator()(const box::SymmetricTensor& t) const {
        for (std::size_t k = 0; k < t.size; ++k)
            if (t.column[k] < dimension) numbers.push_back(t.component[k]);
    }

private:
    void add(const double* values, int n) const { numbers.insert(numbers.end(), values, values + n); }
};

// A field of an observation in Python: a number, or an array.
struct FieldInPython {
    int dimension;

    nb::object operator()(double x) const { return nb::cast(x); }
    nb::object operator()(hl::u64 count) const { return nb::cast(count); }
    template <class Field>
    nb::object operator()(const Field& field) const {
        std::vector<double> numbers;
        NumbersOfField{dimension, numbers}(field);
        if (dimension == 2 && std::is_same_v<Field, box::AxialVector>) return nb::cast(numbers[0]);
        const std::size_t n = numbers.size();
        return nb::cast(make_array(std::move(numbers), {n}));
    }
};

bool needs_friction(box::Sampled by) {
    return by == box::Sampled::with_friction || by == box::Sampled::of_contacts_with_friction;
}

nb::dict observe(const Engine& e) {
    const FieldInPython value_of{e.get().dimension()};
    nb::dict sums;
    const bool rotates = e.get().rotates();
    box::for_fields(e.get().observe(),
                    [&](const char* name, const char*, box::Sampled by, const auto& value) {
                        if (rotates || !needs_friction(by)) sums[name] = value_of(value);
                    });
    return sums;
}

// Calls f(name, value) for the time and all quantities of this observation that the engine samples.
template <class F>
void for_sampled(const box::Engine& e, const box::Observation& o, const F& f) {
    const bool lasting = e.contacts_have_duration();
    f("time", e.time());
    f("heat", e.kicks.heat);
    box::for_fields(o, [&](const char* name, const char*, box::Sampled by, const auto& value) {
        using enum box::Sampled;
        const bool of_engine =
            by == by_all || by == with_friction || (by != never && (by != of_collisions) == lasting);
        if (of_engine && (e.rotates() || !needs_friction(by))) f(name, value);
    });
    if (!lasting) f("n_collisions", o.begun);
}

// One row with the numbers of a sample.
auto sample(const Engine& e) {
    std::vector<double> row;
    row.reserve(64);
    const NumbersOfField add{e.get().dimension(), row};
    for_sampled(e.get(), e.get().observe(), [&](const char*, const auto& value) { add(value); });
    const std::size_t n = row.size();
    return make_array(std::move(row), {n});
}

// The name and the shape of each quantity in such a row.
nb::list sample_fields(const Engine& e) {
    nb::list fields;
    for_sampled(e.get(), {}, [&]<class Field>(const char* name, const Field& value) {
        std::vector<double> numbers;
        NumbersOfField{e.get().dimension(), numbers}(value);
        fields.append(numbers.size() == 1 ? nb::make_tuple(name, nb::make_tuple())
                                          : nb::make_tuple(name, nb::make_tuple(numbers.size())));
    });
    return fields;
}

// The fields of an observation: name, unit, and the engines that sample it.
nb::tuple observed_fields() {
    constexpr std::array samplers{"all", "collisions", "contacts", "all", "contacts", ""};  // by Sampled
    nb::list fields;
    box::for_fields({}, [&](const char* name, const char* unit, box::Sampled by, const auto&) {
        fields.append(dict_of("name", name, "unit", unit, "engines",
                              samplers.at(static_cast<std::size_t>(by)), "friction", needs_friction(by)));
    });
    return nb::tuple(fields);
}

// Counters (names that begin with n_, and largest_cluster) become Python integers.
nb::dict statistics(const Engine& e) {
    nb::dict d;
    for (const box::Statistic& s : e.get().statistics()) {
        if (std::string_view(s.name).starts_with("n_") || std::string_view(s.name) == "largest_cluster")
            d[s.name] = static_cast<hl::i64>(s.value);
        else
            d[s.name] = s.value;
    }
    return d;
}

const char* outcome_name(const Engine& e) {
    return hl::outcome_records[static_cast<int>(e.get().outcome())].name;
}

std::optional<std::tuple<double, std::vector<hl::i64>, std::optional<hl::i64>>> early_end(const Engine& e) {
    if (e.get().outcome() == hl::Outcome::ok) return {};
    const box::EarlyEnd end = e.get().early_end();
    const auto wall = end.wall ? std::optional(end.wall.number) : std::nullopt;
    return std::tuple(end.time, end.particles, wall);
}

// --- initial states -------------------------------------------------------------------------------------------------

nb::object grow_packing(const box::Box& bounds, In radius, hl::u64 seed, const nb::object& progress) {
    box::System s{bounds, radius.size(), nullptr, nullptr, radius.data(), nullptr};
    require_particles(s.n);
    require_no_fault(box::fault_of_sizes(s));
    const std::string fraction = "packing_fraction: got " + shown(s.packing_fraction());
    if (!(s.packing_fraction() < 1.0)) throw value_error(fraction + ", must be < 1");
    bool stopped, refused = false;
    std::optional<std::vector<double>> positions;
    {
        Unlocked open;
        hl::Stop stop = open.stop();
        positions = hl::bindings::grow_packing(s, seed, stop, [&](double share, hl::u64 collisions) {
            if (progress.is_none()) return true;
            open.lock();
            PyObject* answer = PyObject_CallFunction(progress.ptr(), "dK", share, collisions);
            refused = answer == nullptr;
            Py_XDECREF(answer);
            open.unlock();
            return !refused;
        });
        stopped = stop.stopped();
        open.lock();
    }
    if (stopped || refused) throw nb::python_error();
    if (!positions)
        throw value_error(fraction + ", at which no random places without overlap were found, must be lower");
    return nb::cast(make_array(std::move(*positions), {s.n, static_cast<std::size_t>(bounds.dimension)}));
}

auto deepest_overlap(const box::Box& bounds, Rows positions, In radius) {
    require_values("positions", positions.shape(1), static_cast<std::size_t>(bounds.dimension),
                   "one for each axis of the box");
    require_values("radius", radius.size(), positions.shape(0), "one for each particle");
    const box::Overlap found = unlocked([&](hl::Stop& stop) {
        return box::deepest_overlap(bounds, positions.data(), radius.data(), positions.shape(0), stop);
    });
    return std::tuple(found.first, found.second, found.gap);
}

}  // namespace

void bind_boxes(nb::module_& m) {
    m.attr("engine_names") = nb::tuple(list_of(engines, [](const auto* record) { return record->name; }));
    m.attr("rules") = rule_records();
    m.attr("observed_fields") = observed_fields();

    nb::class_<box::Box>(
        m, "Box",
        "Edges [m], boundary of each axis (periodic, wall or lees-edwards), gravity [m/s²]; of each moving wall: its "
        "number as in logs, offset [m], velocity [m/s], amplitude [m], frequency [Hz], phase, waveform (none, sine, "
        "triangle or parabola); of a Lees–Edwards boundary: shear rate [1/s], and displacement of the images beyond "
        "the far side at time 0 [m].")
        .def(nb::new_(&make_box), "edges"_a, "boundary"_a, "gravity"_a.none() = nb::none(),
             "moving_walls"_a = WallMotions(), "shear_rate"_a = 0.0, "shear_displacement"_a = 0.0)
        .def_prop_ro("edges", [](const box::Box& b) { return std::vector(b.edge, b.edge + b.dimension); })
        .def_prop_ro("boundary", &boundaries)
        .def_prop_ro("gravity",
                     [](const box::Box& b) { return std::vector(b.gravity, b.gravity + b.dimension); })
        .def("walls", &walls, "time"_a = 0.0,
             "For each wall: number as in logs (−1 − 2·axis at 0, −2 − 2·axis at L), position [m], velocity "
             "[m/s].");

    nb::class_<Engine>(m, "Engine", "A simulation: an engine and its particles.")
        .def_prop_ro("kind", &Engine::kind)
        .def_prop_ro("n", [](const Engine& e) { return e.get().size(); })
        .def_prop_ro("dimension", [](const Engine& e) { return e.get().dimension(); })
        .def("advance", &Engine::advance, "until"_a, "max_work"_a = ~hl::u64{0}, "threads"_a = 1,
             "Advances to `until` [s]; pauses after `max_work` collisions, events or steps. Pausing does not "
             "change the result.")
        .def_prop_ro("paused", [](const Engine& e) { return e.get().paused(); })
        .def_prop_ro("time", [](const Engine& e) { return e.get().time(); })
        .def_prop_ro("outcome", &outcome_name)
        .def_prop_ro("early_end", &early_end,
                     "Time [s], particles and wall at which a run ended early; otherwise None.")
        .def_prop_ro("work", [](const Engine& e) { return e.get().work(); })
        .def_prop_ro("n_contacts", [](const Engine& e) { return e.get().contacts(); })
        .def_prop_ro("n_logged", [](const Engine& e) { return e.get().logged(); })
        .def("statistics", &statistics)
        .def("state", &state,
             "Current positions [m] and velocities [m/s] of the unfolded paths, (n, d) each.")
        .def_prop_ro("rotates", [](const Engine& e) { return e.get().rotates(); })
        .def("spins", &spins,
             "Current angular velocities [rad/s], (n, 3) also in two dimensions; with friction only.")
        .def(
            "kick",
            [](const Engine& e, Rows velocities, double heat, const std::optional<Rows>& spins) {
                const auto d = static_cast<std::size_t>(e.get().dimension());
                require_values("velocities", velocities.size(), e.get().size() * d, "one for each particle");
                if (e.get().paused() && e.get().contacts_have_duration())
                    throw value_error("velocities: got them during a pause, must be after it");
                if (spins) require_spins(*spins, e.get().size());
                e.get().kick(velocities.data(), spins ? spins->data() : nullptr, heat);
            },
            "velocities"_a, "heat"_a, "spins"_a.none() = nb::none(),
            "Gives all particles new velocities (n, d) [m/s] and spins (n, 3) [rad/s], unless they are None, now, and "
            "counts this kick of a thermostat and its heat [J].")
        .def_prop_ro("n_kicks", [](const Engine& e) { return e.get().kicks.number; })
        .def_prop_ro("heat", [](const Engine& e) { return e.get().kicks.heat; })
        .def("observe", &observe)
        .def("sample", &sample)
        .def("sample_fields", &sample_fields)
        .def_prop_ro("largest_compression",
                     [](const Engine& e) { return e.get().observe().largest_compression; })
        .def(
            "take_log",
            [](const Engine& e) {
                return columns(e.get().take_log(), e.get().contacts_have_duration(), e.get().rotates());
            },
            "Columns of the contact log since the last call.")
        .def(
            "open_contacts",
            [](const Engine& e) {
                return columns(e.get().open_contacts(), e.get().contacts_have_duration(), e.get().rotates());
            },
            "The same for open contacts, whose end is NaN, and for contacts whose cluster has not yet "
            "separated.")
        .def(
            "largest_safety_use",
            [](const Engine& e, int instants) { return e.get().largest_safety_use(instants); }, "instants"_a,
            "Largest fraction of its safety radius that a body in contact currently uses; at most 1.")
        .def("save", &save)
        .def_prop_ro("memory", [](const Engine& e) { return e.get().bytes(); });
    m.def("make_engine", &make_engine, "kind"_a, "box"_a, "positions"_a, "velocities"_a, "radius"_a, "mass"_a,
          nb::kw_only(), "spins"_a.none() = nb::none(), "inertia_factor"_a.none() = nb::none(),
          "law"_a.none() = nb::none(), "rule"_a = "constant", "restitution"_a = hl::math::nan,
          "friction"_a = 0.0, "tangential_restitution"_a = -1.0, "rule_parameters"_a = std::vector<double>(),
          "time_step"_a = 0.0, "log"_a = false);
    m.def("load_engine", &load_engine, "kind"_a, "saved"_a, "n_kicks"_a = hl::u64{0}, "heat"_a = 0.0);
    m.def(
        "random_numbers",
        [](hl::u64 seed, hl::u64 stream, std::size_t n, bool normal) {
            hl::boxes::Random random(seed + 0xd1342543de82ef95ULL * stream);
            std::vector<double> found(n);
            for (double& x : found) x = normal ? random.normal() : random.uniform();
            return make_array(std::move(found), {n});
        },
        "seed"_a, "stream"_a, "n"_a, "normal"_a,
        "Random numbers, standard normal or uniform in [0, 1): the same on every machine.");
    m.def("grow_packing", &grow_packing, "box"_a, "radius"_a, "seed"_a, "progress"_a.none() = nb::none(),
          "Random positions (n, d) without overlap: small particles are inserted, and move and collide "
          "while they grow. progress(fraction of the final radii, collisions) is called at intervals.");
    m.def("deepest_overlap", &deepest_overlap, "box"_a, "positions"_a, "radius"_a,
          "The two particles with the deepest overlap relative to the sum of their radii, and their gap "
          "[m]; −1, −1 and 0 if none overlap.");
}
