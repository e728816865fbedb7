"""Speed of engine="cuda" on a map of counts and velocities, and its upper limit: FP64 rate over operations per point.

    python benchmarks/gpu.py [points along each axis]

The operations of a point are counted on the processor (operations.cpp), so the limit needs no GPU. README.md has what
was measured on an H200, and what bounds it.
"""

import ctypes
import functools
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

import hardlimit as hl
from hardlimit.sweep.engines import cuda, cuda_device
from hardlimit.sweep.plan import Plan, make_plan

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "tests" / "sweep"))
from emulated_gpu import Emulated, build  # noqa: E402

VARIABLES = ["n_contacts", "relative_velocity", "separation_velocity"]

#: FP64 instructions of a correctly rounded division and root on their usual path, approximately.
DIVISION, ROOT = 10, 10

#: FP64 instructions per second without tensor cores: multiprocessors · lanes · clock.
RATES = {"H200": 132 * 64 * 1.98e9, "H100": 132 * 64 * 1.98e9, "A100": 108 * 32 * 1.41e9}


def fig4(side: int) -> Plan:
    """Fig. 4 (top) of the paper."""
    axes = {"restitution": np.linspace(0.4, 1.0, side), "gap": np.geomspace(1e-6, 1e-2, side)}
    return make_plan(hl.Column.paper(), "newton", VARIABLES, axes)


def scattered(points: int) -> Plan:
    """The same ranges as an unordered list of points: the worst case for threads of a warp."""
    import xarray as xr

    rng = np.random.default_rng(1)
    axes = {"restitution": rng.uniform(0.4, 1.0, points), "gap": 10.0 ** rng.uniform(-6, -2, points)}
    lists = {name: xr.DataArray(v, dims="point") for name, v in axes.items()}
    return make_plan(hl.Column.paper(), "newton", VARIABLES, lists)


def count_operations(plan: Plan) -> tuple[float, float]:
    """FP64 instructions per point, and the useful share of those that a warp issues."""
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(1) as pool:
        library = build(HERE / "operations.cpp", Path(folder) / "operations.so")
        gpu = Emulated(library)
        cuda.compute_on(gpu, plan, 1, pool, lambda _: None)
        counts = (ctypes.c_long * 6)()
        gpu.library.operations(counts)
    useful, issued = (n[0] + DIVISION * n[1] + ROOT * n[2] for n in (counts[:3], counts[3:]))
    print(
        f"  per point: {counts[0] / plan.size:.0f} + − × and comparisons, "
        f"{counts[1] / plan.size:.1f} divisions, {counts[2] / plan.size:.1f} roots"
    )
    return useful / plan.size, useful / issued


def floor() -> None:
    """Print the limit that the arithmetic sets."""
    for name, plan in {"grid": fig4(64), "unordered list": scattered(4096)}.items():
        print(f"{name}, {plan.size} points")
        each, busy = count_operations(plan)
        print(f"  {each:.0f} FP64 instructions per point, {100 * busy:.0f} % of the threads of a warp busy")
        for model, rate in RATES.items():
            print(
                f"  {model}: at most {rate / each:.2e} points/s, {busy * rate / each:.2e} with idle threads"
            )


def rate(points: int, run: Callable[[], None]) -> str:
    """Points per second: the median of five runs after a warm-up."""
    seconds = []
    for _ in range(6):
        start = time.perf_counter()
        run()
        seconds.append(time.perf_counter() - start)
    return f"{points:.1e} points, {points / statistics.median(seconds[1:]):.2e} points/s"


def measure(gpu: cuda_device.Gpu, side: int) -> None:
    """Print the speed of a whole sweep, with results in host memory."""
    for name, plan in {"grid": fig4(side), "unordered list": scattered(side * side)}.items():
        with ThreadPoolExecutor(4) as pool:
            sweep = functools.partial(cuda.compute_on, gpu, plan, 4, pool, lambda _: None)
            speed = rate(plan.size, sweep)
        print(f"{gpu.name}: {name}, {speed}")


def kernel_alone(gpu: cuda_device.Gpu, side: int) -> None:
    """Print the speed of the kernel, with results left on the device."""
    plan = fig4(side)
    slot = cuda.Slot(gpu, plan, plan.size)

    def run() -> None:
        slot.start(plan, copy_out=False)
        gpu.wait(slot.stream)

    print(f"{gpu.name}: kernel alone, {rate(plan.size, run)}")


def main() -> None:
    side = int(sys.argv[1]) if len(sys.argv) > 1 else 8192
    floor()
    try:
        gpu = cuda_device.open_gpu()
    except (ImportError, ValueError) as missing:
        print(missing)
        return
    kernel_alone(gpu, min(side, 4096))
    measure(gpu, side)


if __name__ == "__main__":
    main()
