"""Peak memory of a sweep in a fresh process; goal: less than 64 MiB beyond its outputs.

    python benchmarks/memory.py [--size 2000] [--write]

`beyond outputs` is the peak of resident memory, minus resident memory before the call with everything imported, minus
the bytes of the result.
"""

from __future__ import annotations

from harness import arguments, fresh_process, publish, table

MIB = 1 << 20

CODE = """
import numpy as np, xarray, hardlimit as hl
def status(key):
    with open('/proc/self/status') as f:
        return next(int(line.split()[1]) * 1024 for line in f if line.startswith(key))
before = status('VmRSS')
ds = hl.sweep(hl.Column.paper(), {arguments}
    restitution=np.linspace(0.3, 1.0, {n}), gap=np.geomspace(1e-6, 1e-2, {n}))
print(before, status('VmHWM'), ds.nbytes)
"""


def main() -> None:
    a = arguments(__doc__, 2000)
    rows = []
    for what, settings in (
        ("all variables, 1 thread", "threads=1,"),
        ("all variables, 2 threads", "threads=2,"),
        ("counts only, 1 thread", "threads=1, variables=['n_contacts'],"),
    ):
        *_, printed = fresh_process(CODE.format(arguments=settings, n=a.size))
        before, peak, outputs = (int(x) for x in printed.split())
        beyond = peak - before - outputs
        cells = [f"{x / MIB:.1f}" for x in (outputs, before, peak, beyond)]
        rows.append([what, f"{a.size}×{a.size}", *cells])
    head = ["sweep", "points", "outputs [MiB]", "process before [MiB]", "peak [MiB]", "beyond outputs [MiB]"]
    publish("memory", table(head, rows), a.write)


if __name__ == "__main__":
    main()
