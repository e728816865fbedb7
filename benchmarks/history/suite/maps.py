"""Maps of two balls on one thread, and what the first one costs in a fresh process."""

import subprocess
import sys

import numpy as np

import hardlimit as hl
from suite.columns import LAWS


class Map:
    """ε over Δh, as in Fig. 4."""

    params = tuple(LAWS)
    param_names = ("law",)

    def setup(self, law: str) -> None:
        self.column = hl.Column.paper(law=LAWS[law])
        side = 300 if law == "linear" else 60
        self.axes = {"restitution": np.linspace(0.3, 1.0, side), "gap": np.geomspace(1e-6, 1e-2, side)}

    def time_map(self, law: str) -> None:
        hl.sweep(self.column, threads=1, **self.axes)

    def peakmem_map(self, law: str) -> None:
        hl.sweep(self.column, threads=1, **self.axes)


class FreshProcess:
    """Start-up."""

    params = ("import hardlimit", "import hardlimit as hl; hl.newton(hl.Column.paper())")
    param_names = ("code",)

    def time_start(self, code: str) -> None:
        subprocess.run([sys.executable, "-c", code], check=True)
