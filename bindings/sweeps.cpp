// Bindings of the maps: hand over arrays, run the threads with the interpreter unlocked, stay interruptible.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "contact/registry.hpp"
#include "interpreter.hpp"
#include "sweep/map.hpp"

namespace nb = nanobind;
using namespace nb::literals;
namespace hl = hardlimit;
namespace sw = hardlimit::sweep;

extern const hardlimit_abi::Kernel hardlimit_kernel_base, hardlimit_kernel_avx2, hardlimit_kernel_avx512;

namespace {

using Values = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

// Where one variable goes: the caller's own array, never a converted copy; null if it is not wanted.
template <class T>
T* output(const nb::dict& out, const char* name, hl::u64 count) {
    using Array = nb::ndarray<T, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
    if (!out.contains(name)) return nullptr;
    Array array;
    const std::string type = sizeof(T) == 1 ? "uint8" : "float64";
    if (!nb::try_cast(out[name], array, false))
        throw nb::type_error(("out: " + std::string(name) + " must be a contiguous, writable array of " +
                              type + " in one dimension")
                                 .c_str());
    if (array.shape(0) != count)
        throw nb::value_error(("out: " + std::string(name) + " has " + std::to_string(array.shape(0)) +
                               " values, must have " + std::to_string(count))
                                  .c_str());
    return array.data();
}

// Kernels in the order of preference; the last one runs anywhere.
std::vector<const hardlimit_abi::Kernel*> kernels() {
    std::vector<const hardlimit_abi::Kernel*> found;
#if defined(HARDLIMIT_X86)
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw"))
        found.push_back(&hardlimit_kernel_avx512);
    if (__builtin_cpu_supports("avx2")) found.push_back(&hardlimit_kernel_avx2);
#endif
    found.push_back(&hardlimit_kernel_base);
    return found;
}

const hardlimit_abi::Kernel* kernel_named(const std::string& name) {
    if (name == "scalar") return nullptr;
    for (const hardlimit_abi::Kernel* k : kernels())
        if (name == k->name || name == "auto") return k;
    throw nb::value_error(("instruction_set: " + name + " is not available here").c_str());
}

using Worker = void (*)(sw::Job&, hl::u64, hl::Stop&);

struct LawEntry {
    const hl::LawRecord& record;
    Worker worker;
};

LawEntry law_named(const std::string& law) {
#define HL_LAW(Law) \
    if (law == hl::contact::Law::record.name) return {hl::contact::Law::record, &sw::work<hl::contact::Law>};
    HARDLIMIT_LAWS(HL_LAW)
#undef HL_LAW
    throw nb::value_error(("law: unknown name " + law).c_str());
}

void require(bool met, const char* what) {
    if (!met) throw nb::value_error(what);
}

void set_axes(sw::Axes& axes, const std::vector<Values>& values, const std::vector<hl::u64>& strides) {
    require(values.size() == sw::parameter_count, "values: wrong number of parameters");
    require(strides.size() == sw::parameter_count, "strides: wrong number of parameters");
    for (std::size_t i = 0; i < sw::parameter_count; ++i) {
        require(values[i].shape(0) > 0, "values: must not be empty");
        require(strides[i] > 0, "strides: must be >= 1");
        axes.axis[i] = {values[i].data(), strides[i], values[i].shape(0)};
    }
}

sw::Outputs outputs(const nb::dict& out, hl::u64 count) {
    return {output<std::uint8_t>(out, "n_contacts", count),
            output<std::uint8_t>(out, "outcome", count),
            output<double>(out, "relative_velocity", count),
            output<double>(out, "separation_velocity", count),
            output<double>(out, "effective_restitution", count),
            output<double>(out, "restitution_ratio", count),
            output<double>(out, "t_end", count),
            output<double>(out, "t_floor_end", count)};
}

// Works through the job with the interpreter unlocked; what the caller's `progress` or a signal handler raises ends it.
void run(sw::Job& job, Worker worker, int threads, const nb::object& progress) {
    const hl::u64 share = job.count / (8 * static_cast<hl::u64>(threads)) + 1;
    const hl::u64 block = std::min<hl::u64>(4096, share), blocks = (job.count + block - 1) / block;
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
        const int wanted = static_cast<int>(std::min<hl::u64>(static_cast<hl::u64>(threads), blocks));
        hl::Team().run(wanted, open.period, [&](hl::Stop& stop) { worker(job, block, stop); }, watch);
    }
    if (raised) throw nb::python_error();
}

// Points first … first + count − 1 of the map. Returns the contact counts above 255 as (point, count).
nb::list run_map(const std::string& law, int model, int alternative, bool density_1, bool density_2,
                 int restitution_at, const std::vector<Values>& values, const std::vector<hl::u64>& strides,
                 hl::u64 first, hl::u64 count, int threads, double tolerance, const nb::dict& out,
                 nb::object progress, const std::string& instruction_set) {
    const LawEntry entry = law_named(law);
    require(model >= 0 && model <= static_cast<int>(sw::Model::independent), "model: must be 0, 1 or 2");
    require(alternative >= 0 && alternative < entry.record.n_alternatives,
            "alternative: the law has no such set of parameters");
    require(restitution_at >= -1 && restitution_at < hl::max_parameters,
            "restitution_at: must be a place among the parameters of the law, or -1");
    require(threads >= 1, "threads: must be >= 1");
    sw::Job job{};
    set_axes(job.axes, values, strides);
    job.setting = {static_cast<sw::Model>(model), alternative, density_1, density_2, restitution_at};
    job.kernel = kernel_named(instruction_set);
    job.log2_tolerance = hl::math::log(tolerance) / hl::math::log(2.0);
    job.first = first;
    job.count = count;
    job.out = outputs(out, count);
    run(job, entry.worker, threads, progress);
    nb::list large;
    for (const sw::LargeCount& k : job.large) large.append(nb::make_tuple(k.point, k.count));
    return large;
}

}  // namespace

void bind_sweep(nb::module_& m) {
    m.attr("sweep_parameters") = sw::parameter_count;
    m.attr("max_law_parameters") = hl::max_parameters;
    m.def("run_map", &run_map, "law"_a, "model"_a, "alternative"_a, "density_1"_a, "density_2"_a,
          "restitution_at"_a, "values"_a, "strides"_a, "first"_a, "count"_a, "threads"_a, "tolerance"_a,
          "out"_a, "progress"_a.none(), "instruction_set"_a = "auto");
    m.def("instruction_sets", [] {
        std::vector<std::string> names;
        for (const hardlimit_abi::Kernel* k : kernels()) names.emplace_back(k->name);
        return names;
    });
}
