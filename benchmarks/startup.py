"""Time to the first result in a fresh process.

python benchmarks/startup.py [--repetitions 7] [--write]
"""

from __future__ import annotations

import numpy as np
from harness import arguments, fresh_process, publish, table

OURS = "import hardlimit as hl, numpy as np; "
POINT = (
    "import numpy as np; from peers import scaled, {0}; "
    "p = scaled.Points(*(np.array([x]) for x in (0.7, 1e-4, 0.1, 0.01, 5e7))); "
    "print({0}.run(p, {1}).n_contacts)"
)
CASES = [
    ("Python and NumPy alone", "import numpy"),
    ("import hardlimit", "import hardlimit"),
    ("hardlimit --help", "from hardlimit.cli import main; main(['--help'], 'hardlimit')"),
    ("hl.newton, one drop", OURS + "print(hl.newton(hl.Column.paper()).n_contacts)"),
    (
        "hl.sweep, map of 100×100",
        OURS + "print(hl.sweep(hl.Column.paper(), restitution=np.linspace(0.3, 1, 100),"
        " gap=np.geomspace(1e-6, 1e-2, 100)).n_contacts.max().item())",
    ),
    ("numba RK4, one drop", POINT.format("linear_numba", "'RK4', 0.042")),
    ("heyoka.py scalar, one drop", POINT.format("linear_heyoka", "'scalar', 1e-7")),
]


def main() -> None:
    a = arguments(__doc__, 0, 5)
    times = {name: [] for name, _ in CASES}
    for repetition in range(a.repetitions + 1):  # the first fills the file cache
        for name, code in CASES:
            wall, cpu, _ = fresh_process(code)
            if repetition > 0:
                times[name].append((wall, cpu))
    rows = []
    for name, measured in times.items():
        wall, cpu = np.array(measured).T
        rows.append([name, f"{np.median(wall):.2f}", f"{wall.min():.2f}", f"{np.median(cpu):.2f}"])
    head = ["fresh process", "wall [s], median", "wall [s], best", "CPU [s], median"]
    publish("startup", table(head, rows), a.write)


if __name__ == "__main__":
    main()
