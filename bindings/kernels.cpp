// The kernels of core/sweep/ and core/boxes/ for one instruction set: compiled once for each, with `hardlimit`
// renamed and HARDLIMIT_KERNEL set to the name of the entry and HARDLIMIT_LANES to the doubles in a register (see
// CMakeLists.txt). The number of lanes changes the speed, never the result.
#include "boxes/kernels/kernel_table.hpp"
#include "sweep/batch.hpp"
#include "sweep/linear_kernel.hpp"
#include "sweep/viscoelastic_kernel.hpp"

namespace {
using Real = hardlimit::Vector<HARDLIMIT_LANES>::Real;
using Wide = hardlimit::Pair<Real>;  // for the kernel that is a long chain of operations
}  // namespace

extern const hardlimit_abi::Kernel HARDLIMIT_KERNEL;
const hardlimit_abi::Kernel HARDLIMIT_KERNEL = {
    HARDLIMIT_KERNEL_NAME, &hardlimit::sweep::solve_batch<Wide>, &hardlimit::sweep::damping_ratios<Real>,
    &hardlimit::sweep::solve_viscoelastic_batch<Real>, &hardlimit::sweep::leave_batch<Real>};

extern const hardlimit_abi::TouchKernels HARDLIMIT_TOUCH_KERNELS;
const hardlimit_abi::TouchKernels HARDLIMIT_TOUCH_KERNELS =
    hardlimit::boxes::touch_kernels<Real>(HARDLIMIT_KERNEL_NAME);
