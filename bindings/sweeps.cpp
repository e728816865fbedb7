// Bindings of the parameter maps: pass the arrays, run the threads without the interpreter lock, handle interrupts.
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "contact.hpp"
#include "processor.hpp"
#include "sweep/column_map.hpp"
#include "sweep/map.hpp"
#include "sweep/parameter_table.hpp"

namespace nb = nanobind;
using namespace nb::literals;
namespace hl = hardlimit;
namespace sw = hardlimit::sweep;
using hl::bindings::require;
using hl::bindings::value_error;
using Values = hl::bindings::In;

namespace {

// The caller's output array for one variable, never a converted copy; null if not requested.
template <class T>
T* output(const nb::dict& out, const char* name, hl::u64 count) {
    using Array = nb::ndarray<T, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
    if (!out.contains(name)) return nullptr;
    Array array;
    const std::string type = sizeof(T) == 1 ? "uint8" : sizeof(T) == 4 ? "uint32" : "float64";
    if (!nb::try_cast(out[name], array, false))
        throw nb::type_error(("out: " + std::string(name) + " must be a contiguous, writable array of " +
                              type + " in one dimension")
                                 .c_str());
    require(array.shape(0) == count, "out: " + std::string(name) + " has " + std::to_string(array.shape(0)) +
                                         " values, must have " + std::to_string(count));
    return array.data();
}

// Available kernels in order of preference; the last one runs on every processor.
std::vector<const hardlimit_abi::Kernel*> kernels() {
    std::vector<const hardlimit_abi::Kernel*> found;
    for (int set = hl::bindings::instruction_set(); set >= 0; --set)
        found.push_back(hl::bindings::sweep_kernels[set]);
    return found;
}

const hardlimit_abi::Kernel* kernel_named(const std::string& name) {
    if (name == "scalar") return nullptr;
    for (const hardlimit_abi::Kernel* k : kernels())
        if (name == k->name || name == "auto") return k;
    throw value_error("instruction_set: " + name + " is not available here");
}

// Entry points of the maps for one law.
struct LawEntry {
    const hl::LawRecord* record;
    void (*work)(sw::Job&, hl::u64, hl::Stop&);
    void (*work_columns)(sw::ColumnJob&, hl::u64, hl::Stop&);
    bool (*has_kernel)(sw::Model);
    bool on_gpu, exact;
};

LawEntry law_named(const std::string& law) {
    return hl::boxes::with_law<LawEntry>(hl::bindings::law_index(law), []<class Law>() {
        return LawEntry{&Law::record,
                        &sw::work<Law>,
                        &sw::work_columns<Law>,
                        &sw::Vectorised<Law>::covers,
                        sw::Vectorised<Law>::on_gpu,
                        hl::column::has_exact_solver<Law>};
    });
}

std::vector<sw::Axis> axes_of(int balls, const std::vector<Values>& values,
                              const std::vector<hl::u64>& strides) {
    const auto numbers = static_cast<std::size_t>(sw::law_of(balls, balls));
    require(values.size() == numbers, "values: wrong number of parameters");
    require(strides.size() == numbers, "strides: wrong number of parameters");
    std::vector<sw::Axis> axes;
    for (std::size_t i = 0; i < numbers; ++i) {
        require(values[i].shape(0) > 0, "values: must not be empty");
        require(strides[i] > 0, "strides: must be >= 1");
        axes.push_back({values[i].data(), strides[i], values[i].shape(0)});
    }
    return axes;
}

sw::Outputs outputs(const nb::dict& out, hl::u64 count) {
    sw::Outputs o{
        output<std::uint8_t>(out, "n_contacts", count), output<std::uint8_t>(out, "outcome", count), {}};
    for (int k = 0; k < sw::quantity_count; ++k)
        o.quantity[k] = output<double>(out, sw::quantity_names[k], count);
    return o;
}

// Runs the job without the interpreter lock. An exception from `progress` or a signal handler ends it.
template <class Job>
void run(Job& job, void (*work)(Job&, hl::u64, hl::Stop&), hl::u64 most, int threads,
         const nb::object& progress) {
    const hl::u64 share = job.count / (8 * static_cast<hl::u64>(threads)) + 1;
    const hl::u64 size = std::min<hl::u64>(most, share), batches = (job.count + size - 1) / size;
    bool raised = false;
    {
        hl::bindings::Unlocked open;
        const auto watch = [&] {
            open.lock();
            raised = PyErr_CheckSignals() != 0;
            if (!raised && !progress.is_none()) {
                try {
                    progress(job.done.load());
                } catch (nb::python_error& e) {
                    e.restore();
                    raised = true;
                }
            }
            open.unlock();
            return raised;
        };
        const int wanted = static_cast<int>(std::min<hl::u64>(static_cast<hl::u64>(threads), batches));
        hl::ThreadPool().run(wanted, open.period, [&](hl::Stop& stop) { work(job, size, stop); }, watch);
    }
    if (raised) throw nb::python_error();
}

// Solves points first … first + count − 1 of a two-ball map. Returns the contact counts above 255 as (point, count).
nb::list run_map(const std::string& law, int model, int alternative, bool density_1, bool density_2,
                 int restitution_at, const std::vector<Values>& values, const std::vector<hl::u64>& strides,
                 hl::u64 first, hl::u64 count, int threads, double tolerance, const nb::dict& out,
                 nb::object progress, const std::string& instruction_set) {
    const LawEntry entry = law_named(law);
    hl::bindings::require_alternative(*entry.record, alternative);
    require(restitution_at >= -1 && restitution_at < hl::max_parameters,
            "restitution_at: must be a field among the parameters of the law, or -1");
    sw::Job job{};
    job.axes = axes_of(2, values, strides);
    job.setting = {static_cast<sw::Model>(model), alternative, density_1, density_2, restitution_at};
    if (!entry.has_kernel(job.setting.model) && !hl::math::is_nan(tolerance))
        job.setting.tolerance = tolerance;
    job.kernel = kernel_named(instruction_set);
    job.log2_tolerance = hl::math::log(tolerance) / hl::math::log(2.0);
    job.first = first;
    job.count = count;
    job.out = outputs(out, count);
    const bool ordered = entry.has_kernel(job.setting.model) && job.is_list();
    run(job, entry.work, ordered ? sw::ListOrder::most : 4096, threads, progress);
    nb::list large;
    for (const sw::LargeCount& k : job.large) large.append(nb::make_tuple(k.point, k.count));
    return large;
}

// The same for columns of any number of balls, point by point. `density` has one entry for each ball.
void run_columns(const std::string& law, int model, int alternative, const std::vector<bool>& density,
                 const std::vector<Values>& values, const std::vector<hl::u64>& strides, hl::u64 first,
                 hl::u64 count, int threads, double tolerance, const nb::dict& out, nb::object progress) {
    const LawEntry entry = law_named(law);
    hl::bindings::require_alternative(*entry.record, alternative);
    const int balls = static_cast<int>(density.size());
    require(static_cast<sw::Model>(model) != sw::Model::adiabatic || (balls == 2 && entry.exact),
            "model: the adiabatic one is that of two balls under a law with an exact solver");
    const hl::u64 of_balls = count * density.size();
    sw::ColumnJob job{};
    job.axes = axes_of(balls, values, strides);
    job.first = first;
    job.count = count;
    job.out = {output<std::uint32_t>(out, "n_contacts", count),
               output<std::uint8_t>(out, "outcome", count),
               output<double>(out, "t_end", count),
               output<double>(out, "t_floor_end", count),
               output<double>(out, "rebound_height", of_balls),
               output<double>(out, "final_velocity", of_balls)};
    job.setting = {.model = static_cast<sw::Model>(model),
                   .alternative = alternative,
                   .density = {density.begin(), density.end()},
                   .tolerance = tolerance,
                   .rebound_heights = job.out.rebound_height != nullptr,
                   .final_velocities = job.out.final_velocity != nullptr};
    run(job, entry.work_columns, 64, threads, progress);
}

// The parameters that can be swept for a column of N balls, with their indices in the row of a point.
nb::list swept_parameters(int balls) {
    constexpr const char* per[] = {"column", "ball", "gap"};
    return hl::bindings::list_of(sw::swept_records, [&](const sw::SweptRecord& r) {
        return hl::bindings::dict_of("name", r.name, "per", per[static_cast<int>(sw::per(r.field))], "first",
                                     sw::first_of(r.field, balls), "count", sw::count_of(r.field, balls),
                                     "unit", r.unit, "meaning", r.meaning, "lowest", r.lowest,
                                     "lowest_allowed", r.lowest_allowed);
    });
}

}  // namespace

void bind_sweep(nb::module_& m) {
    m.def("swept_parameters", &swept_parameters, "balls"_a,
          "The column parameters that can be swept: name, indices in the row of a point, unit, meaning and "
          "range.");
    m.def("law_place", &sw::law_of, "contact"_a, "balls"_a,
          "Index of a contact's first law parameter in the row of a point, 0 = floor; for contact = balls, "
          "the length of the row.");
    m.def(
        "ball_mass", [](double density, double radius) { return sw::ball_mass(density, true, radius); },
        "density"_a, "radius"_a, "Mass of a solid sphere [kg].");
    m.def("run_map", &run_map, "law"_a, "model"_a, "alternative"_a, "density_1"_a, "density_2"_a,
          "restitution_at"_a, "values"_a, "strides"_a, "first"_a, "count"_a, "threads"_a, "tolerance"_a,
          "out"_a, "progress"_a.none(), "instruction_set"_a = "auto");
    m.def("run_columns", &run_columns, "law"_a, "model"_a, "alternative"_a, "density"_a, "values"_a,
          "strides"_a, "first"_a, "count"_a, "threads"_a, "tolerance"_a, "out"_a, "progress"_a.none());
    m.def(
        "has_kernel",
        [](const std::string& law, int model) {
            return law_named(law).has_kernel(static_cast<sw::Model>(model));
        },
        "law"_a, "model"_a, "Whether two-ball points of this law and model are solved by a vector kernel.");
    m.def(
        "has_gpu_kernel",
        [](const std::string& law, int model) {
            const LawEntry entry = law_named(law);
            return entry.on_gpu && entry.has_kernel(static_cast<sw::Model>(model));
        },
        "law"_a, "model"_a, "Whether such points can be solved on a GPU.");
    m.def(
        "has_exact_solver", [](const std::string& law) { return law_named(law).exact; }, "law"_a,
        "Whether two balls on a floor have a piecewise closed-form solution under this law.");
    m.def("instruction_sets", [] {
        std::vector<std::string> names;
        for (const hardlimit_abi::Kernel* k : kernels()) names.emplace_back(k->name);
        return names;
    });
}
