"""Measurement of packings of soft grains that a periodic cell presses together without gravity, by coefficient of
friction and by preparation (see driver.py).

300 spheres of mean diameter 1 and density 6/π, k = 1, in LAMMPS, since our own boxes do not shrink. The cell shrinks
alike along all axes from random places without contacts until a pressure appears, its barostat brings it to the
pressures of five stiffness numbers κ = k/(p d), and it rests at each of them.
"""

from __future__ import annotations

import dataclasses
import math
import subprocess
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Final, NamedTuple

import driver
import numpy as np
import xarray as xr
from driver import Point
from matplotlib.figure import Figure
from packings import DENSITY, VALUES, shown

import hardlimit as hl
from hardlimit.boxes.box import Floats
from hardlimit.boxes.lammps import program
from hardlimit.checking import at_rest
from hardlimit.measure import stability
from hardlimit.plots.style import PAGE_WIDTH, PALETTE, style

N: Final = 300
LEVELS: Final = (1e5, 10**4.5, 1e4, 10**3.5, 1e3)
#: Levels of cells of their own, at :data:`HASTE` times the rates.
SOFT: Final = (10**2.5, 1e2, 10**1.5, 10**1.25)
HASTE: Final = 5.0
TIME_STEP: Final = 0.15  #: t_c/15
#: Rate of strain along each axis [√(k/m)] from the end of the first compression to the first level, and at most there.
ONSET, ADJUSTED = 1e-5, 2e-6
REST: Final = 1000.0  #: time at each level, once the mean pressure over MEAN is within 5 % of it
SLOW: Final = {0.0: 4.0, 1.0: 4.0}  #: grains of these frictions take longer by a factor
MEAN, LONGEST = 150.0, 15000.0  #: the longest time until then
MODULUS: Final = 0.2  #: about the bulk modulus of the packings [k/d]
FRICTIONS: Final = (0.0, 0.1, 0.3, 0.5, 0.577, 1.0)
#: Largest differences of the pressure, and of the kinetic energy over N p²d⁴/k, of a packing that counts as at rest.
NEAR, QUIET = 0.02, 0.5
KEPT: Final = (
    "packing_fraction",
    "pressure",
    "coordination",
    "mechanical",
    "rattlers",
    "overlap",
    "deepest",
    "energy",
)


class Preparation(NamedTuple):
    """How a cell is filled and compressed, and what its grains are."""

    fraction: float = 0.3  #: packing fraction at the start
    rate: float = 1e-4  #: rate of strain along each axis of the first compression [√(k/m)]
    smooth: bool = False  #: without friction up to the first level
    spread: float = 0.0  #: radii are uniform between 1 ∓ this of their mean
    stiffness_ratio: float = 2.0 / 7.0  #: k_t/k
    restitution: float = 0.5
    first: int = 0  #: the level at whose pressure the first compression ends
    soft: bool = False  #: whether it goes through the soft levels, from 10³ on

    @property
    def levels(self) -> tuple[float, ...]:
        return (LEVELS[-1], *SOFT) if self.soft else LEVELS

    @property
    def haste(self) -> float:
        return HASTE if self.soft else 1.0


PREPARATIONS: Final = {
    "loose": Preparation(),
    "fast": Preparation(rate=1e-3),
    "slow": Preparation(rate=1e-5),
    "dense start": Preparation(fraction=0.55),
    "smooth first": Preparation(smooth=True),
    "radii ± 20 %": Preparation(spread=0.2),
    "k_t = k": Preparation(stiffness_ratio=1.0),
    "ε = 0.9": Preparation(restitution=0.9),
    "at once, ε = 0.9": Preparation(restitution=0.9, first=3),
    "soft": Preparation(soft=True),
}


# --- runs ---------------------------------------------------------------------------------------------------


def radii_of(spread: float, seed: int) -> Floats:
    """Radii of the mean 1/2."""
    radii = np.random.default_rng(seed).uniform(1.0 - spread, 1.0 + spread, N)
    return np.asarray(0.5 * radii / radii.mean())


def script(mu: float, how: Preparation) -> str:
    """The input script of LAMMPS, which writes K.dump at the level K."""
    steps, first = round(SLOW.get(mu, 1.0) * REST / how.haste / TIME_STEP), 1.0 / how.levels[how.first]

    def law(friction: float) -> str:
        tangential = f"linear_history {how.stiffness_ratio!r} 0.0 {friction!r}"
        return (
            f"pair_coeff * * hooke 1.0 {how.restitution!r} damping coeff_restitution tangential {tangential}"
        )

    def shrunk(rate: float, by: float) -> list[str]:
        """Until the pressure is that of the first level, or by a strain."""
        return [
            f"fix stop all halt 20 v_pressure > {first!r} error continue message no",
            "fix shrink all deform 1 " + " ".join(f"{axis} trate {-rate!r}" for axis in "xyz") + " remap x",
            f"run {round(by / rate / TIME_STEP)}",
            "unfix shrink",
            "unfix stop",
        ]

    def adjusted(pressure: float) -> list[str]:
        rate, mean = ADJUSTED * how.haste, round(MEAN / TIME_STEP)
        period = min(200.0, pressure / (3.0 * MODULUS * rate))
        return [
            f"fix press all press/berendsen iso {pressure!r} {pressure!r} {period!r} modulus {MODULUS}",
            f"fix mean all ave/time 10 {mean // 10} {mean} v_pressure",
            f"variable near equal abs(f_mean/{pressure!r}-1)",
            f"fix stop all halt {mean} v_near < 0.05 error continue message no",
            f"run {round(LONGEST / TIME_STEP)}",
            "unfix stop",
            f"run {steps}",
            "unfix mean\nunfix press",
        ]

    lines = [
        "units lj\natom_style sphere\nboundary p p p\nnewton off\ncomm_modify vel yes\nread_data start.data",
        "pair_style granular",
        law(0.0 if how.smooth else mu),
        "neighbor 0.15 bin\nfix move all nve/sphere\nthermo_style custom step press ke\nthermo_modify norm no",
        f"timestep {TIME_STEP!r}\nvariable pressure equal press",
        *shrunk(how.rate, 0.35),
        f"run {steps}",
        *shrunk(ONSET * how.haste, 0.1),
    ]
    for k, level in enumerate(how.levels):
        if k < how.first:
            continue
        lines += adjusted(1.0 / level)
        if how.smooth and k == 0:
            lines += [law(mu), *adjusted(1.0 / level)]
        lines.append(
            f"write_dump all custom {k}.dump x y z radius vx vy vz modify format float %.17g sort id"
        )
    return "\n".join(lines)


def pressed(mu: float, preparation: str, replica: int) -> dict[str, list[float]]:
    """Values at each level."""
    how = PREPARATIONS[preparation]
    radii = radii_of(how.spread, replica)
    start = hl.ParticleSystem.random(N, how.fraction, radii, DENSITY, 0.0, seed=replica)
    rows = zip((2.0 * start.radius).tolist(), start.positions.tolist(), strict=True)
    atoms = [f"{k} 1 {d!r} {DENSITY!r} {x!r} {y!r} {z!r}" for k, (d, (x, y, z)) in enumerate(rows, 1)]
    edges = [f"0 {float(edge)!r} {axis}lo {axis}hi" for edge, axis in zip(start.box, "xyz", strict=True)]
    head = ["spheres", "", f"{N} atoms", "1 atom types", *edges, "", "Atoms # sphere", ""]
    lammps = program.find(1)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "start.data").write_text("\n".join([*head, *atoms, ""]))
        (folder / "in.pressed").write_text(script(mu, how))
        command = [lammps.path, "-in", "in.pressed", "-log", "none"]
        subprocess.run(command, cwd=folder, env=lammps.environment(), capture_output=True, check=True)
        values = {
            level: at_level(folder / f"{k}.dump") for k, level in enumerate(how.levels) if k >= how.first
        }
    return {
        name: [values[level][name] if level in values else math.nan for level in LEVELS + SOFT]
        for name in KEPT
    }


def at_level(path: Path) -> dict[str, float]:
    """Values of a packing at rest in a periodic cell, whose contacts have k = 1."""
    lines = path.read_text().splitlines()
    ends = np.array([line.split() for line in lines[5:8]], float)
    rows, edges = np.loadtxt(lines[9:]), ends[:, 1] - ends[:, 0]
    radius, mass = rows[:, 3], DENSITY * 4.0 / 3.0 * math.pi * rows[:, 3] ** 3
    at = np.mod(rows[:, :3] - ends[:, 0], edges)
    system = hl.ParticleSystem(at, 0.0 * at, radius, mass=mass, box=edges, allowed_overlap=0.2)
    of = stability.network(system, 0.0)
    ends_of = radius[of.first], radius[of.second]
    volume, counts = float(np.prod(edges)), of.counts(N)
    deep = of.overlap / np.minimum(*ends_of)
    pressure = float((of.overlap * (sum(ends_of) - of.overlap)).sum()) / (3.0 * volume)
    return {
        "packing_fraction": float((radius**3).sum()) * 4.0 / 3.0 * math.pi / volume,
        "pressure": pressure,
        "coordination": float(counts.mean()),
        "mechanical": float(counts[counts >= 2].mean()),
        "rattlers": float((counts < 2).mean()),
        "overlap": float(deep.mean()),
        "deepest": float(deep.max()),
        "energy": 0.5 * float(mass @ (rows[:, 4:7] ** 2).sum(1)) / (N * pressure**2),
    }


# --- grid -----------------------------------------------------------------------------------------------------


def points(_: int) -> Iterator[Point]:
    """A run has the values at all levels."""
    for mu in FRICTIONS:
        yield mu, "loose", None
    for preparation in PREPARATIONS:
        if preparation not in ("loose", "soft"):
            yield 0.5, preparation, None
    for mu in FRICTIONS:
        if mu in at_rest.PRESSED:
            yield mu, "soft", None


def run(point: Point, replica: int) -> dict[str, list[float]]:
    mu, preparation, _ = point
    return pressed(mu, preparation, replica)


def axes() -> Mapping[str, Any]:
    return {"friction": list(FRICTIONS), "preparation": list(PREPARATIONS), "level": list(LEVELS + SOFT)}


def gather(runs: list[driver.Run]) -> xr.Dataset:
    """The values of packings that have come to rest at the pressure of their level.

    Not at rest were two of three smooth ones at κ = 1e5, and those of fast compressions, which end far from contact.
    """
    ds = driver.gathered(dataclasses.replace(STUDY, gather=None), runs)
    return ds.where((abs(ds.pressure * ds.level - 1.0) < NEAR) & (ds.energy < QUIET))


# --- results --------------------------------------------------------------------------------------------------


def carrying(ds: xr.Dataset) -> xr.DataArray:
    """φ z."""
    return ds.packing_fraction * ds.coordination


def expected(mu: float, spread: float, kappa: float) -> float:
    """φ z by the formula of ``hardlimit check``."""
    return at_rest.pressed(mu).carrying(kappa, 3, spread / math.sqrt(3.0))


def tables(ds: xr.Dataset) -> str:
    rows = []
    for mu, preparation, _ in points(0):
        if preparation == "soft":
            continue
        here = ds.sel(friction=mu, preparation=preparation)
        spread = PREPARATIONS[preparation].spread
        values = [shown(carrying(here).sel(level=level), 2) for level in LEVELS[::-1]]
        over = [float((carrying(here).sel(level=k) / expected(mu, spread, k)).mean()) for k in LEVELS]
        known = [value for value in over if math.isfinite(value)]
        at = here.sel(level=1e4 if PREPARATIONS[preparation].first == 0 else LEVELS[3])
        rows.append(
            (mu, preparation, shown(at.packing_fraction, 3), shown(at.coordination, 2),
             shown(at.rattlers, 1, 100.0), *values, f"{min(known):.2f} to {max(known):.2f}")
        )  # fmt: skip
    levels = " | ".join(f"φz at {level:.3g}" for level in LEVELS[::-1])
    hard = driver.table(f"μ | preparation | φ | z | rattlers [%] | {levels} | over the formula", rows)
    return f"{hard}\n\n{of_soft(ds)}"


def of_soft(ds: xr.Dataset) -> str:
    rows = []
    for mu, level in ((mu, level) for mu in at_rest.PRESSED for level in SOFT):
        at = ds.sel(friction=mu, preparation="soft", level=level)
        over = float(carrying(at).mean()) / expected(mu, 0.0, level)
        rows.append(
            (mu, f"{level:.3g}", shown(at.packing_fraction, 3), shown(at.coordination, 2),
             shown(carrying(at), 2), f"{over:.2f}", shown(at.overlap, 1, 100.0), shown(at.deepest, 0, 100.0))
        )  # fmt: skip
    return driver.table("μ | κ_p | φ | z | φz | over the formula | δ/R [%] | deepest [%]", rows)


def draw(ds: xr.Dataset) -> Mapping[str, Figure]:
    """φ z over the stiffness number: by friction, and by preparation at μ = 0.5."""
    with style():
        figure = Figure(figsize=(PAGE_WIDTH, 2.9), layout="constrained")
        by_friction, by_preparation = figure.subplots(1, 2, sharey=True)
        colors = list(PALETTE.values())
        kappa = np.geomspace(14.0, 1.4e5, 100)
        for color, mu in zip(colors, FRICTIONS, strict=False):
            points_of(by_friction, ds.sel(friction=mu, preparation="loose"), color, f"μ = {mu:g}")
            if mu in at_rest.PRESSED:
                points_of(by_friction, ds.sel(friction=mu, preparation="soft"), color, None, "s")
            by_friction.plot(kappa, [expected(mu, 0.0, k) for k in kappa], color=color, lw=0.8, zorder=0)
        markers = "osv^D<>*PX"
        for k, name in enumerate(PREPARATIONS):
            points_of(
                by_preparation,
                ds.sel(friction=0.5, preparation=name),
                colors[k % len(colors)],
                name.replace("k_t", "$k_t$"),
                markers[k],
            )
        band = [
            [side * expected(0.5, 0.0, k) for k in kappa]
            for side in (at_rest.PREPARED[0], at_rest.PREPARED[1])
        ]
        by_preparation.fill_between(kappa, *band, color="0.85", lw=0.0, zorder=-1)
        for ax in (by_friction, by_preparation):
            ax.set(xscale="log", xlabel=r"$\kappa_p$")
            ax.legend(fontsize="x-small", ncols=2)
        by_friction.set(ylabel=r"$\phi z$", ylim=(1.8, 7.0))
    return {"pressed_cells.png": figure}


def points_of(ax: Any, here: xr.Dataset, color: str, name: str | None, marker: str = "o") -> None:
    """The means with their errors."""
    rows = []
    for level in LEVELS + SOFT:
        values = carrying(here).sel(level=level)
        if values.notnull().any():
            error = driver.mean(values)[1]
            rows.append((level, float(values.mean()), 0.0 if math.isnan(error) else error))
    x, y, error = np.array(rows).T
    ax.errorbar(x, y, error, fmt=marker, ms=3.5, color=color, label=name)


STUDY = driver.Study(
    file=__file__,
    points=points,
    run=run,
    replicas=3,
    values={name: VALUES[name] for name in KEPT},
    axes=axes,
    gather=gather,
    draw=draw,
    tables=tables,
)

if __name__ == "__main__":
    driver.main(STUDY, __doc__)
