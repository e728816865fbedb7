"""Speed-up of two threads on the map of map_linear.py, in wall time.

    python benchmarks/threads.py [--size 1000] [--write]

Two threads need two idle cores: CPU/wall of two threads is then near 2.
"""

from __future__ import annotations

import numpy as np
from harness import Method, arguments, interleave, publish, table

import hardlimit as hl


def main() -> None:
    a = arguments(__doc__, 1000, 9)
    axes = {"restitution": np.linspace(0.3, 1.0, a.size), "gap": np.geomspace(1e-6, 1e-2, a.size)}
    column = hl.Column.paper()
    methods = [Method(f"{k}", "", lambda k=k: hl.sweep(column, threads=k, **axes), a.size**2) for k in (1, 2)]
    interleave(methods, a.repetitions)
    single = methods[0]
    rows = []
    for m in methods:
        wall, cpu = np.array(m.wall), np.array(m.cpu)
        row = [m.name, f"{1 / np.median(wall):.3g}", f"{1 / wall.min():.3g}", f"{np.median(cpu / wall):.2f}"]
        ratios = np.median(np.array(single.wall) / wall), min(single.wall) / wall.min()
        rows.append([*row, *(f"{ratio:.2f}" for ratio in ratios)])
    head = ["threads", "points/s (median wall)", "points/s (best)", "CPU/wall"]
    head += ["speed-up (median)", "speed-up (best)"]
    publish("threads", table(head, rows), a.write)


if __name__ == "__main__":
    main()
