// Bindings of the maps: hand over arrays, run the threads with the interpreter unlocked, stay interruptible.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <chrono>

#include "contact/registry.hpp"
#include "sweep/map.hpp"

namespace nb = nanobind;
using namespace nb::literals;
namespace hl = hardlimit;
namespace sw = hardlimit::sweep;

extern const hardlimit_abi::Kernel hardlimit_kernel_base, hardlimit_kernel_avx2, hardlimit_kernel_avx512;

namespace {

using Values = nb::ndarray<const double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Bytes = nb::ndarray<std::uint8_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
using Doubles = nb::ndarray<double, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

double* doubles(const nb::dict& out, const char* name) {
    return out.contains(name) ? nb::cast<Doubles>(out[name]).data() : nullptr;
}
std::uint8_t* bytes(const nb::dict& out, const char* name) {
    return out.contains(name) ? nb::cast<Bytes>(out[name]).data() : nullptr;
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

using Worker = void (*)(sw::Job&, hl::u64);

Worker worker_for(const std::string& law) {
#define HL_WORKER(Law) \
    if (law == hl::contact::Law::record.name) return &sw::work<hl::contact::Law>;
    HARDLIMIT_LAWS(HL_WORKER)
#undef HL_WORKER
    throw nb::value_error(("law: unknown name " + law).c_str());
}

// Points first … first + count − 1 of the map. Returns the contact counts above 255 as (point, count).
nb::list run_map(const std::string& law, int model, int alternative, bool density_1, bool density_2,
                 int restitution_at, const std::vector<Values>& values, const std::vector<hl::u64>& strides,
                 hl::u64 first, hl::u64 count, int threads, double tolerance, const nb::dict& out,
                 nb::object progress, const std::string& instruction_set) {
    if (values.size() != sw::parameter_count || strides.size() != sw::parameter_count)
        throw nb::value_error("values: wrong number of parameters");
    sw::Job job{};
    for (int i = 0; i < sw::parameter_count; ++i)
        job.axes.axis[i] = {values[i].data(), strides[i], values[i].shape(0)};
    job.setting = {static_cast<sw::Model>(model), alternative, density_1, density_2, restitution_at};
    job.kernel = kernel_named(instruction_set);
    job.log2_tolerance = hl::math::log(tolerance) / hl::math::log(2.0);
    job.first = first;
    job.count = count;
    job.out = {bytes(out, "n_contacts"),
               bytes(out, "outcome"),
               doubles(out, "relative_velocity"),
               doubles(out, "separation_velocity"),
               doubles(out, "effective_restitution"),
               doubles(out, "restitution_ratio"),
               doubles(out, "t_end"),
               doubles(out, "t_floor_end")};
    const Worker worker = worker_for(law);
    const hl::u64 block = std::max<hl::u64>(1, std::min<hl::u64>(4096, count / (8 * threads) + 1));
    bool interrupted = false;
    {
        nb::gil_scoped_release unlocked;
        std::vector<std::thread> pool;
        job.running = threads;
        for (int i = 0; i < threads; ++i) pool.emplace_back(worker, std::ref(job), block);
        const auto finished = [&job] {
            std::unique_lock lock(job.guard);
            return job.finished.wait_for(lock, std::chrono::milliseconds(100),
                                         [&job] { return job.running == 0; });
        };
        while (!finished()) {
            nb::gil_scoped_acquire locked;
            if (PyErr_CheckSignals() != 0) interrupted = true;
            if (!interrupted && !progress.is_none()) {
                try {
                    progress(job.done.load());
                } catch (nb::python_error& e) {
                    e.restore();
                    interrupted = true;
                }
            }
            if (interrupted) job.stop = true;
            if (interrupted) break;
        }
        for (std::thread& t : pool) t.join();
    }
    if (interrupted) throw nb::python_error();
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
