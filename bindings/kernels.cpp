// Compiles the kernels of core/sweep/ and core/boxes/ for one instruction set. CMakeLists.txt compiles this file once
// for each, with the namespace `hardlimit` renamed, HARDLIMIT_KERNEL set to the name of the table and HARDLIMIT_LANES
// to the number of doubles in a register. Results do not depend on the number of lanes.
#include "boxes/kernels/kernel_table.hpp"
#include "sweep/batch.hpp"
#include "sweep/linear_kernel.hpp"
#include "sweep/viscoelastic_kernel.hpp"

namespace {
using Real = hardlimit::Vector<HARDLIMIT_LANES>::Real;
using Wide = hardlimit::Pair<Real>;  // two registers, for the kernel that is bound by latency
}  // namespace

extern const hardlimit_abi::Kernel HARDLIMIT_KERNEL;
const hardlimit_abi::Kernel HARDLIMIT_KERNEL = {
    HARDLIMIT_KERNEL_NAME, &hardlimit::sweep::solve_batch<Wide>, &hardlimit::sweep::damping_ratios<Wide>,
    &hardlimit::sweep::solve_viscoelastic_batch<Real>, &hardlimit::sweep::leave_batch<Real>};

extern const hardlimit_abi::TouchKernels HARDLIMIT_TOUCH_KERNELS;
const hardlimit_abi::TouchKernels HARDLIMIT_TOUCH_KERNELS =
    hardlimit::boxes::touch_kernels<Real>(HARDLIMIT_KERNEL_NAME);
