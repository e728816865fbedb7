"""Measurement of how long contacts last in dense flow, and whether hard spheres follow it (see driver.py).

300 spheres under Lees–Edwards shear at constant volume as in dense_flow.py. Newton's equations: the mean duration of a
contact over that of a collision of two grains, and the coordination number, over the inertial number
I = γ̇ d √(ρ/p), at three stiffnesses. Hard spheres with the same ε and friction: the strain at which they collapse.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any, Final

import driver
import numpy as np
import xarray as xr
from dense_flow import DENSITY, RATE_OF, SLOW, N
from driver import Point
from matplotlib.figure import Figure

import hardlimit as hl
from hardlimit.checking import at_rest
from hardlimit.plots.style import PAGE_WIDTH, PALETTE, style

FRICTIONS: Final = (0.1, 0.3, 0.5, 0.7, 1.0)
RESTITUTIONS: Final = (0.5, 0.7, 0.9, 0.98)
STIFFNESSES: Final = (1e3, 1e4, 1e5)  #: stiffness numbers, roughly
LOOSER: Final = (0.2, 0.1, 0.06, 0.035, 0.02, 0.01)
#: Other friction is measured at these: stiffness and restitutions.
OTHERS: Final = (1e4, (0.5, 0.9))
HARD: Final = 0.0  #: stands for the stiffness of hard spheres
#: In slower flows hard spheres collide too often to be run; and at these frictions only soft ones are.
SLOWEST_HARD, SOFT_ONLY = 0.02, (0.1, 1.0)
STRAINS: Final = (1.5, 1.5)
ROWS: Final = 30  #: samples
VALUES: Final = {
    "packing_fraction": ("1", "packing fraction"),
    "inertial_number": ("1", "inertial number"),
    "kappa": ("1", "stiffness number"),
    "duration": ("1", "mean duration of a contact over that of a collision"),
    "coordination": ("1", "open contacts of a grain"),
    "pressure": ("1", "pressure over ρ (γ̇ d)²"),
    "strain": ("1", "strain at the end of the run"),
}


def points(_: int) -> Iterator[Point]:
    for mu in FRICTIONS:
        for restitution in RESTITUTIONS:
            for stiffness in (HARD, *STIFFNESSES):
                usual = mu == 0.5 or (stiffness in (HARD, OTHERS[0]) and restitution in OTHERS[1])
                for looser in LOOSER:
                    runs = stiffness != HARD or (looser >= SLOWEST_HARD and mu not in SOFT_ONLY)
                    if usual and runs:
                        yield mu, restitution, stiffness, looser


def run(point: Point, replica: int) -> dict[str, Any]:
    """Means over the second half of the strain."""
    mu, restitution, stiffness, looser = point
    hard = stiffness == HARD
    phi = SLOW[mu] - looser
    rate = looser / RATE_OF * math.sqrt(1.0 / ((STIFFNESSES[-1] if hard else stiffness) * DENSITY))
    start = hl.ParticleSystem.random(
        N, phi, 0.5, DENSITY, rate, seed=replica,
        boundary=("periodic", "lees-edwards", "periodic"), shear_rate=rate,
    )  # fmt: skip
    law = hl.LinearDashpot(stiffness=1.0, restitution=restitution, friction=hl.Friction(mu))
    options: dict[str, Any] = {"law": law, "until": sum(STRAINS) / rate, "samples": ROWS}
    if hard:
        result: Any = hl.event_driven(start, **options)
    else:
        result = hl.molecular_dynamics(
            start, engine="steps", restitution_error=0.05, threads=1, log=True, **options
        )
    values = {"packing_fraction": phi, "strain": float(result.series.time[-1]) * rate}
    if result.outcome != "ok":
        return values
    pressure = float(result.series.pressure[1 + ROWS // 2 :].mean())
    values |= {
        "inertial_number": rate * math.sqrt(DENSITY / pressure),
        "pressure": pressure / (DENSITY * rate**2),
    }
    return values if hard else values | durations(result, law) | {"kappa": 1.0 / pressure}


def durations(result: Any, law: hl.LinearDashpot) -> dict[str, float]:
    """Of the contacts that begin in the second half, but not at its end; open ones last to the end at least."""
    grain = hl.Ball(0.5, density=DENSITY)
    until = float(result.series.time[-1])
    begin, end = result.log[:2]
    counted = (begin > 0.5 * until) & (begin < 0.9 * until)
    lasted = np.where(np.isnan(end), until, end)[counted] - begin[counted]
    return {
        "duration": float(lasted.mean()) / float(law.between(grain, grain).duration(1.0)),
        "coordination": 2.0 * float(lasted.sum()) / (0.4 * until * N),
    }


def draw(data: xr.Dataset) -> Mapping[str, Figure]:
    """The mean duration over I, and the I from which check calls a flow collisional, at the median stiffness number."""
    with style():
        figure = Figure(figsize=(PAGE_WIDTH, 3.2), layout="constrained")
        panels = figure.subplots(1, len(STIFFNESSES), sharey=True)
        for axes, stiffness in zip(panels, STIFFNESSES, strict=True):
            for colour, restitution in zip(PALETTE.values(), RESTITUTIONS, strict=False):
                rows = data.sel(friction=0.5, restitution=restitution, stiffness=stiffness).mean("replica")
                axes.plot(rows.inertial_number, rows.duration, "o-", ms=3, lw=0.6, color=colour,
                          label=f"ε = {restitution:g}")  # fmt: skip
                border = at_rest.collisional_from(restitution, float(rows.kappa.median()), 0.5)
                axes.axvline(border, color=colour, ls=":", lw=0.8)
            axes.axhline(at_rest.SEPARATED_FROM, color="k", lw=0.6)
            axes.set(xscale="log", yscale="log", xlabel="inertial number $I$")
            kappa = float(data.sel(friction=0.5, stiffness=stiffness).kappa.median())
            digit, power = f"{kappa:.0e}".split("e")
            axes.set_title(rf"$\kappa_p \approx {digit}\cdot 10^{int(power)}$")
        panels[0].set_ylabel("mean duration of a contact/$t_c$")
        panels[0].legend()
    return {"lasting_contacts.png": figure}


def tables(data: xr.Dataset) -> str:
    """One row a setting: Newton's equations, and beside them hard spheres."""
    rows = []
    for mu in data.friction.values:
        for restitution in data.restitution.values:
            for stiffness in STIFFNESSES:
                for looser in data.looser.values:
                    at = data.sel(friction=mu, restitution=restitution, looser=looser).mean("replica")
                    newton, hard = at.sel(stiffness=stiffness), at.sel(stiffness=HARD)
                    if not np.isfinite(newton.duration):
                        continue
                    strain = float(hard.strain)
                    ends = f"collapse at {strain:.2f}" if strain < 0.999 * sum(STRAINS) else (
                        f"{float(hard.pressure / newton.pressure):.2f}"
                    )  # fmt: skip
                    values = [
                        f"{float(newton[name]):{form}}"
                        for name, form in {
                            "packing_fraction": ".3f", "inertial_number": ".2f", "kappa": ".0f",
                            "coordination": ".2f", "duration": ".2f",
                        }.items()
                    ]  # fmt: skip
                    rows.append([mu, restitution, *values, "" if math.isnan(strain) else ends])
    return driver.table("μ | ε | φ | I | κ_p | contacts of a grain | duration/t_c | hard spheres", rows)


STUDY: Final = driver.Study(
    file=__file__,
    points=points,
    run=run,
    replicas=1,
    values=VALUES,
    draw=draw,
    tables=tables,
    axes=lambda: {
        "friction": list(FRICTIONS),
        "restitution": list(RESTITUTIONS),
        "stiffness": [HARD, *STIFFNESSES],
        "looser": list(LOOSER),
    },
)

if __name__ == "__main__":
    driver.main(STUDY, __doc__)
