// Bindings of boxes of particles: arrays in, an engine that runs with the interpreter unlocked, arrays out.
#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "arrays.hpp"
#include "boxes/hard_spheres/check.hpp"
#include "boxes/hard_spheres/growth.hpp"
#include "boxes/hard_spheres/make_engine.hpp"
#include "early_end.hpp"
#include "touch_kernels.hpp"

namespace nb = nanobind;
using namespace nb::literals;
namespace hl = hardlimit;
namespace box = hardlimit::boxes;
using hl::bindings::early_end_text;
using hl::bindings::EarlyEnd;
using hl::bindings::In;
using hl::bindings::make_array;
using hl::bindings::touch_kernels;
using hl::bindings::Unlocked;

namespace {

using Rows = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

std::string in_words(double x) {
    char text[32];
    PyOS_snprintf(text, sizeof text, "%.16g", x);
    return text;
}
nb::builtin_exception refusal(const std::string& line) { return nb::value_error(line.c_str()); }

void require_values(const char* name, std::size_t got, std::size_t wanted, const char* what) {
    if (got != wanted)
        throw refusal(std::string(name) + ": got " + std::to_string(got) + " values, must be " +
                      std::to_string(wanted) + ", " + what);
}

void require_particles(std::size_t n) {
    if (n == 0) throw refusal("positions: got no particles, must be at least one");
    if (n >= (std::size_t{1} << 28))
        throw refusal("positions: got " + std::to_string(n) + " particles, must be < 2^28");
}

// What Python gives of the box, checked as far as lengths go.
void set_box(box::Setting& s, int dimension, const std::vector<double>& edge,
             const std::vector<bool>& periodic, const std::vector<double>& gravity) {
    if (dimension != 2 && dimension != 3)
        throw refusal("positions: got " + std::to_string(dimension) + " columns, must be 2 or 3");
    const std::size_t d = static_cast<std::size_t>(dimension);
    require_values("box", edge.size(), d, "one for each axis");
    require_values("periodic", periodic.size(), d, "one for each axis");
    require_values("gravity", gravity.size(), d, "one for each axis");
    s.dimension = dimension;
    s.kernels = &touch_kernels();
    for (std::size_t k = 0; k < d; ++k) {
        s.edge[k] = edge[k];
        s.periodic[k] = periodic[k];
        s.gravity[k] = gravity[k];
        if (!hl::math::is_finite(gravity[k]))
            throw refusal("gravity: got " + in_words(gravity[k]) + ", must be finite");
    }
}

std::string of_particle(const char* name, std::size_t i) {
    return std::string(name) + "[" + std::to_string(i) + "]: got ";
}

std::string in_words(const box::Fault& f, const box::Setting& s) {
    const std::size_t axis = static_cast<std::size_t>(f.axis);
    const std::string edge = in_words(s.edge[axis]), along = " along axis " + std::to_string(f.axis);
    switch (f.kind) {
        case box::Fault::not_finite:
            return "positions, velocities: got a value of particle " + std::to_string(f.particle) +
                   " that is not finite, must be finite";
        case box::Fault::radius:
            return of_particle("radius", f.particle) + in_words(f.value) + ", must be > 0 and finite";
        case box::Fault::mass:
            return of_particle("mass", f.particle) + in_words(f.value) + ", must be > 0 and finite";
        case box::Fault::box:
            return "box: got " + edge + along + ", must be >= " + in_words(f.value) +
                   ", the largest diameter";
        case box::Fault::outside:
            return of_particle("positions", f.particle) + in_words(f.value) + along +
                   ", must be >= 0 and <= " + edge;
        case box::Fault::none:
            break;
    }
    return {};
}

// A law as (name, alternative, parameters), as make_contact takes it.
using LawChoice = std::tuple<std::string, int, std::vector<double>>;

void set_law(box::RuleChoice& choice, const LawChoice& law) {
    const auto& [name, alternative, parameters] = law;
    int place = 0;
    const auto consider = [&](const hl::LawRecord& record) {
        if (name == record.name) {
            choice.law = place;
            if (alternative < 0 || alternative >= record.n_alternatives)
                throw refusal("alternative: got " + std::to_string(alternative) +
                              ", must be a set of parameters of the law");
            const int wanted = record.n_common + record.n_in_alternative[alternative];
            require_values("parameters", parameters.size(), static_cast<std::size_t>(wanted),
                           "those of the law");
        }
        ++place;
    };
#define HL_CONSIDER(Law) consider(hl::contact::Law::record);
    HARDLIMIT_LAWS(HL_CONSIDER)
#undef HL_CONSIDER
    if (choice.law < 0) throw refusal("law: got " + name + ", must be a registered law");
    choice.alternative = alternative;
    std::copy(parameters.begin(), parameters.end(), choice.parameters);
}

box::RuleChoice make_rule(const std::string& rule, double restitution, const std::optional<LawChoice>& law,
                          double contact_duration) {
    box::RuleChoice choice;
    if (rule != "constant" && rule != "tc" && rule != "law" && rule != "soft")
        throw refusal("rule: got " + rule + ", must be constant, tc, law or soft");
    if ((rule == "law" || rule == "soft") && !law)
        throw refusal("law: got None, must be a law for the rule " + rule);
    choice.soft = rule == "soft";
    if (law && rule != "constant")
        set_law(choice, *law);
    else if (restitution >= 0.0 && restitution <= 1.0)
        choice.restitution = restitution;
    else
        throw refusal("restitution: got " + in_words(restitution) + ", must be >= 0 and <= 1");
    if (rule == "tc") {
        if (!(contact_duration >= 0.0))
            throw refusal("contact_duration: got " + in_words(contact_duration) + ", must be >= 0");
        choice.contact_duration = contact_duration;
    }
    return choice;
}

// Looks at the signals, and tells Python how far a run is.
class Watch {
public:
    Watch(Unlocked& open, const box::Engine& engine, const nb::object& progress)
        : open_(open), engine_(engine), progress_(progress) {}

    hl::Stop stop() { return hl::Stop(&ask, this); }

private:
    using Clock = std::chrono::steady_clock;
    static constexpr std::chrono::milliseconds between_reports{100};

    Unlocked& open_;
    const box::Engine& engine_;
    const nb::object& progress_;
    Clock::time_point look_ = Clock::now() + Unlocked::period, report_ = Clock::now() + between_reports;

    static bool ask(void* of) {
        Watch& self = *static_cast<Watch*>(of);
        const Clock::time_point now = Clock::now();
        if (now < self.look_) return false;
        self.look_ = now + Unlocked::period;
        if (self.open_.signalled()) return true;
        if (self.progress_.is_none() || now < self.report_) return false;
        self.report_ = now + between_reports;
        return !self.report();
    }
    // Whether Python took it without an exception, which else waits to be thrown.
    bool report() {
        open_.lock();
        const box::Counts c = engine_.counts();
        PyObject* answer = PyObject_CallFunction(progress_.ptr(), "dL", engine_.time(), c.pairs + c.walls);
        const bool taken = answer != nullptr;
        Py_XDECREF(answer);
        open_.unlock();
        return taken;
    }
};

class HardSpheres {
public:
    explicit HardSpheres(std::unique_ptr<box::Engine> engine) : engine_(std::move(engine)) {}
    HardSpheres(HardSpheres&& other) noexcept : engine_(std::move(other.engine_)) {}

    // Refused while another thread is in advance().
    const box::Engine& engine() const {
        if (running_) throw std::runtime_error("this run is being advanced by another thread");
        return *engine_;
    }
    box::Engine& engine() { return const_cast<box::Engine&>(std::as_const(*this).engine()); }

    void advance(double until, hl::i64 most_rows, const nb::object& progress) {
        if (hl::math::is_nan(until)) throw refusal("until: got nan, must be a time");
        box::Engine& e = engine();
        running_ = true;
        bool stopped;
        {
            Unlocked open;
            Watch watch(open, e, progress);
            hl::Stop stop = watch.stop();
            e.advance(until, most_rows, stop);
            stopped = stop.stopped();
            open.lock();
        }
        running_ = false;
        if (stopped) throw nb::python_error();
    }

private:
    std::unique_ptr<box::Engine> engine_;
    std::atomic<bool> running_{false};
};

HardSpheres make_hard_spheres(Rows positions, Rows velocities, In radius, In mass,
                              const std::vector<double>& edge, const std::vector<bool>& periodic,
                              const std::vector<double>& gravity, const std::string& rule, double restitution,
                              const std::optional<LawChoice>& law, double contact_duration, bool log) {
    box::Setting s{};
    set_box(s, static_cast<int>(positions.shape(1)), edge, periodic, gravity);
    s.n = positions.shape(0);
    require_particles(s.n);
    require_values("velocities", velocities.size(), positions.size(), "as of positions");
    require_values("radius", radius.size(), s.n, "one for each particle");
    require_values("mass", mass.size(), s.n, "one for each particle");
    s.position = positions.data();
    s.velocity = velocities.data();
    s.radius = radius.data();
    s.mass = mass.data();
    const box::RuleChoice choice = make_rule(rule, restitution, law, contact_duration);
    box::Fault fault;
    std::unique_ptr<box::Engine> engine = hl::bindings::unlocked([&](hl::Stop& stop) {
        fault = box::fault_of(s);
        return fault.kind == box::Fault::none ? box::make_engine(s, choice, log, stop) : nullptr;
    });
    if (!engine) throw refusal(in_words(fault, s));
    return HardSpheres(std::move(engine));
}

template <int d>
auto grow(const box::Setting& s, hl::u64 seed, const nb::object& progress) {
    bool grown, stopped, refused = false;
    std::vector<double> positions;
    {
        Unlocked open;
        hl::Stop stop = open.stop();
        box::Grow<d> growth(s, seed);
        grown = growth.run(stop, [&](box::GrowthReport r) {
            if (progress.is_none()) return true;
            open.lock();
            PyObject* answer = PyObject_CallFunction(progress.ptr(), "dL", r.share, r.collisions);
            refused = answer == nullptr;
            Py_XDECREF(answer);
            open.unlock();
            return !refused;
        });
        positions = std::move(growth).positions();
        stopped = stop.stopped();
        open.lock();
    }
    if (stopped || refused) throw nb::python_error();
    if (!grown)
        throw refusal("packing_fraction: got " + in_words(box::packing_fraction(s)) +
                      ", at which random places without overlap were not found, must be lower");
    return make_array(std::move(positions), {s.n, static_cast<std::size_t>(d)});
}

nb::object grow_packing(std::size_t n, int dimension, In radius, const std::vector<double>& edge,
                        const std::vector<bool>& periodic, hl::u64 seed, const nb::object& progress) {
    box::Setting s{};
    set_box(s, dimension, edge, periodic, std::vector<double>(edge.size()));
    require_particles(n);
    require_values("radius", radius.size(), n, "one for each particle");
    s.n = n;
    s.radius = radius.data();
    const box::Fault fault = box::fault_of_sizes(s);
    if (fault.kind != box::Fault::none) throw refusal(in_words(fault, s));
    if (!(box::packing_fraction(s) < 1.0))
        throw refusal("packing_fraction: got " + in_words(box::packing_fraction(s)) + ", must be < 1");
    return dimension == 2 ? nb::cast(grow<2>(s, seed, progress)) : nb::cast(grow<3>(s, seed, progress));
}

HardSpheres load(const nb::bytes& saved) {
    const char* data = saved.c_str();
    const std::size_t n = saved.size();
    auto engine =
        hl::bindings::unlocked([&](hl::Stop&) { return box::load_engine(data, n, touch_kernels()); });
    if (!engine)
        throw refusal("saved: got " + std::to_string(n) +
                      " bytes that are damaged, cut short or of another version, must be what save() gave");
    return HardSpheres(std::move(engine));
}

nb::bytes save(const HardSpheres& h) {
    const std::vector<char> bytes = h.engine().save();
    return nb::bytes(bytes.data(), bytes.size());
}

auto state(const HardSpheres& h) {
    const box::Engine& e = h.engine();
    const std::size_t n = e.size(), d = static_cast<std::size_t>(e.dimension());
    std::vector<double> position(n * d), velocity(n * d);
    e.state(position.data(), velocity.data());
    return nb::make_tuple(make_array(std::move(position), {n, d}), make_array(std::move(velocity), {n, d}));
}

nb::dict observe(const HardSpheres& h) {
    const box::Engine& e = h.engine();
    const box::Observation o = e.observe();
    const std::size_t d = static_cast<std::size_t>(e.dimension());
    nb::dict seen;
    seen["kinetic_energy"] = o.kinetic_energy;
    seen["potential_energy"] = o.potential_energy;
    seen["momentum"] = make_array(std::vector<double>(o.momentum, o.momentum + d), {d});
    seen["dissipated_energy"] = o.dissipated_energy;
    seen["virial"] = o.virial;
    seen["kinetic_integral"] = o.kinetic_integral;
    seen["largest_compression"] = e.largest_compression();
    return seen;
}

auto take_log(HardSpheres& h) {
    box::Log log = h.engine().take_log();
    const std::size_t n = log.time.size();
    return nb::make_tuple(make_array(std::move(log.time), {n}), make_array(std::move(log.first), {n}),
                          make_array(std::move(log.second), {n}),
                          make_array(std::move(log.impact_speed), {n}),
                          make_array(std::move(log.separation_speed), {n}));
}

const char* outcome_name(const HardSpheres& h) {
    return hl::outcome_records[static_cast<int>(h.engine().outcome())].name;
}
EarlyEnd early_end(const HardSpheres& h) {
    if (h.engine().outcome() == hl::Outcome::ok) return {};
    const auto [time, first, second] = h.engine().early_end();
    if (second < 0) return std::tuple(time, std::vector{first}, std::optional(second));
    return std::tuple(time, std::vector{first, second}, std::optional<hl::i64>());
}

}  // namespace

void bind_particles(nb::module_& m) {
    nb::class_<HardSpheres>(m, "HardSpheres",
                            "Hard spheres or disks in a box, moved from collision to collision.")
        .def(nb::new_(&make_hard_spheres), "positions"_a, "velocities"_a, "radius"_a, "mass"_a, "box"_a,
             "periodic"_a, "gravity"_a, "rule"_a, "restitution"_a, "law"_a.none(), "contact_duration"_a,
             "log"_a)
        .def("advance", &HardSpheres::advance, "until"_a, "max_rows"_a = 0, "progress"_a.none() = nb::none(),
             "To `until` [s] or to the instant of row number `max_rows` of the log (0: no limit). "
             "progress(time, rows) is called about every 0.1 s.")
        .def_prop_ro("time", [](const HardSpheres& h) { return h.engine().time(); })
        .def_prop_ro("n_events", [](const HardSpheres& h) { return h.engine().events(); })
        .def_prop_ro("n_rows",
                     [](const HardSpheres& h) {
                         const box::Counts c = h.engine().counts();
                         return c.pairs + c.walls;
                     })
        .def_prop_ro("n_pairs", [](const HardSpheres& h) { return h.engine().counts().pairs; })
        .def_prop_ro("n_walls", [](const HardSpheres& h) { return h.engine().counts().walls; })
        .def_prop_ro("n_elastic_by_tc",
                     [](const HardSpheres& h) { return h.engine().counts().elastic_by_tc; })
        .def_prop_ro("n_soft", [](const HardSpheres& h) { return h.engine().counts().soft; })
        .def_prop_ro("n_soft_third_body",
                     [](const HardSpheres& h) { return h.engine().counts().soft_third_body; })
        .def_prop_ro("outcome", &outcome_name)
        .def_prop_ro("early_end", &early_end, early_end_text)
        .def("state", &state, "Positions [m], along continuous paths, and velocities [m/s] now.")
        .def("observe", &observe)
        .def("take_log", &take_log, "Time, first, second and impact speed of the rows since the last call.")
        .def("save", &save)
        .def_static("load", &load, "saved"_a)
        .def_prop_ro("memory", [](const HardSpheres& h) { return h.engine().bytes(); });
    m.def(
        "grow_packing", &grow_packing, "n"_a, "dimension"_a, "radius"_a, "box"_a, "periodic"_a, "seed"_a,
        "progress"_a.none() = nb::none(),
        "Random positions (n, dimension) of particles that do not overlap: small ones thrown in, which move and "
        "collide while they grow. progress(share of the final radii, collisions) is called now and then.");
}
