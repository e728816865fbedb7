"""One driver for all studies: run the points of a grid, resume, collect the replicas, compute errors, draw.

    python studies/NAME.py measure [STORE] [--replicas N] [--part K/N]
    python studies/NAME.py collect [STORE ...]
    python studies/NAME.py draw [FOLDER]

``measure`` appends one line for each run to the file STORE and skips runs that are in it. ``--part 1/8`` takes every
eighth run, for eight parallel jobs with a store each. ``collect`` writes all runs to NAME.nc beside the study. ``draw``
makes the figures of docs/images and prints the tables of the documentation. A study without a grid only draws.
"""

from __future__ import annotations

import argparse
import json
import math
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

import hardlimit as hl
from hardlimit import plots
from hardlimit.fidelity_study import statistics
from hardlimit.support import saving
from hardlimit.support.estimate import Estimate
from hardlimit.support.progress import bar

IMAGES = Path(__file__).resolve().parents[1] / "docs" / "images"
UNKNOWN: Estimate[float] = Estimate(*(math.nan,) * 4)

Point = tuple[Any, ...]  # levels of the axes; None: the run holds for all levels of that axis
Run = dict[str, Any]  # point, replica, values; no values if it ended early


@dataclass(frozen=True)
class Study:
    """Grid and figures of a study."""

    file: str  #: its script
    draw: Callable[..., Mapping[str, Figure]]  #: the figures by file names, from the data if there is a grid
    tables: Callable[[xr.Dataset], str] | None = None  #: Markdown
    points: Callable[[int], Iterable[Point]] | None = None  #: the grid for each replica
    run: Callable[[Point, int], Mapping[str, Any]] | None = None  #: values at a point in a replica
    replicas: int = 1
    values: Mapping[str, tuple[str, str]] | None = None  #: unit and meaning of each value
    axes: Callable[[], Mapping[str, Sequence[Any]]] | None = None  #: levels of each axis
    gather: Callable[[list[Run]], xr.Dataset] | None = None  #: if not :func:`gathered`
    about: Mapping[str, Any] | None = None  #: attributes of the data
    dpi: int = 150

    @property
    def data(self) -> Path:
        return Path(self.file).with_suffix(".nc")


# --- runs ---------------------------------------------------------------------------------------------------


def runs_of(stores: Iterable[Path]) -> list[Run]:
    return [json.loads(line) for store in stores if store.exists() for line in store.read_text().splitlines()]


def measure(study: Study, store: Path, replicas: int, part: str = "1/1") -> None:
    """Append the values of each point and replica that is not in the store."""
    assert study.points and study.run
    key = json.dumps
    known = {key([run["point"], run["replica"]]) for run in runs_of([store])}
    first, parts = map(int, part.split("/"))
    grid = [(point, replica) for replica in range(replicas) for point in study.points(replica)]
    mine = grid[first - 1 :: parts]
    with warnings.catch_warnings(), store.open("a", buffering=1) as out, bar(store.stem, "runs") as report:
        warnings.simplefilter("ignore", hl.CompressionWarning)
        for done, (point, replica) in enumerate(mine):
            report(done, len(mine))
            if key([point, replica]) not in known:
                values = study.run(point, replica)
                out.write(key({"point": point, "replica": replica, "values": values}) + "\n")


def collect(study: Study, stores: Sequence[Path]) -> None:
    """Write the data of a study; NaN where a run is missing or ended early."""
    runs = runs_of(stores)
    ds = study.gather(runs) if study.gather else gathered(study, runs)
    source = f"hardlimit {hl.__version__}, studies/{Path(study.file).name}"
    saving.dataset(ds.assign_attrs(source=source, **(study.about or {})), study.data)


def gathered(study: Study, runs: Sequence[Run]) -> xr.Dataset:
    """The values over the axes of the grid and the replicas."""
    assert study.axes and study.values
    axes = {name: list(levels) for name, levels in study.axes().items()}
    shape = *map(len, axes.values()), 1 + max(run["replica"] for run in runs)
    arrays = {name: np.full(shape, math.nan) for name in study.values}
    for run in runs:
        levels = zip(axes.values(), run["point"], strict=True)
        at = *(slice(None) if level is None else axis.index(level) for axis, level in levels), run["replica"]
        for name, value in run["values"].items():
            arrays[name][at] = value
    return labelled(study.values, (*axes, "replica"), arrays).assign_coords(axes)


def listed(
    runs: Sequence[Run], known: Sequence[Any], models: Sequence[str], values: Mapping[str, tuple[str, str]]
) -> xr.Dataset:
    """The values over a list of named tuples, the models and the replicas; a run's point ends with its model."""
    shape = len(known), len(models), 1 + max(run["replica"] for run in runs)
    arrays = {name: np.full(shape, math.nan, np.float32) for name in values}
    places = {tuple(point): i for i, point in enumerate(known)}
    for run in runs:
        *point, model = run["point"]
        for name, value in run["values"].items():
            at = places[tuple(point)], models.index(model), run["replica"]
            arrays[name][at] = math.nan if value is None else value
    columns = {name: ("point", [getattr(point, name) for point in known]) for name in known[0]._fields}
    ds = labelled(values, ("point", "model", "replica"), arrays)
    return ds.assign_coords(columns | {"model": list(models)})


def points_of(ds: xr.Dataset, kind: Callable[..., Any]) -> list[Any]:
    """The named tuples of :func:`listed`."""
    columns = [ds[name].values.tolist() for name in kind._fields]
    return [kind(*row) for row in zip(*columns, strict=True)]


def labelled(
    meanings: Mapping[str, tuple[str, str]], dims: Sequence[str], arrays: Mapping[str, Any]
) -> xr.Dataset:
    """Arrays with their units and meanings."""
    return xr.Dataset(
        {
            name: (dims, arrays[name], {"units": unit, "long_name": text})
            for name, (unit, text) in meanings.items()
        }
    )


# --- errors -------------------------------------------------------------------------------------------------


def mean(values: xr.DataArray) -> tuple[float, float]:
    """The mean over replicas with its standard error; NaN for fewer than two."""
    known = values.dropna("replica")
    n = known.sizes["replica"]
    if n < 2:
        return math.nan, math.nan
    return float(known.mean()), float(known.std(ddof=1)) / math.sqrt(n)


def ratio(upper: xr.DataArray, lower: xr.DataArray, power: float = 1.0) -> tuple[float, float]:
    """(⟨upper⟩/⟨lower⟩)^power − 1 with its standard error; the replicas of the two are independent."""
    (numerator, error), (denominator, other_error) = mean(upper), mean(lower)
    value = (numerator / denominator) ** power
    return value - 1.0, abs(power * value) * math.hypot(error / numerator, other_error / denominator)


def paired(upper: xr.DataArray, lower: xr.DataArray) -> Estimate[float]:
    """⟨upper⟩/⟨lower⟩ − 1; a replica of the two shares its start. Unknown with fewer than three."""
    pair = np.array([upper, lower], float)
    pair = pair[:, np.isfinite(pair).all(axis=0)]
    if pair.shape[1] < 3:
        return UNKNOWN
    return Estimate(*(float(part) for part in statistics.relative_difference(*pair)))


# --- pictures and tables ------------------------------------------------------------------------------------


def table(head: str, rows: Iterable[Iterable[object]]) -> str:
    """A table as Markdown with the minus sign of print."""
    lines = ["| " + " | ".join(map(str, row)).replace("-", "−") + " |" for row in rows]
    return "\n".join([f"| {head} |", "|" + "---|" * (head.count("|") + 1), *lines])


def draw(study: Study, folder: Path = IMAGES) -> None:
    data = [xr.load_dataset(study.data)] if study.run else []
    for name, figure in study.draw(*data).items():
        print(plots.save(figure, folder / name, study.dpi))
    if study.tables:
        print(f"\n{study.tables(*data)}")


def linear_law(restitution: float, ball: hl.Ball, duration: float) -> hl.LinearDashpot:
    """The linear law with this restitution and duration of a contact of two balls [s]."""
    unit = hl.LinearDashpot(stiffness=1.0, restitution=restitution)
    return unit.replace(stiffness=float(unit.between(ball, ball).duration(1.0) / duration) ** 2)


def main(study: Study, text: str | None) -> None:
    """The command line of a study."""
    parser = argparse.ArgumentParser(description=text, formatter_class=argparse.RawDescriptionHelpFormatter)
    tasks = parser.add_subparsers(dest="task", required=True)
    tasks.add_parser("draw").add_argument("folder", nargs="?", type=Path, default=IMAGES)
    if study.run:
        store = Path(f"{Path(study.file).stem}.jsonl")
        task = tasks.add_parser("measure")
        task.add_argument("store", nargs="?", type=Path, default=store)
        task.add_argument("--replicas", type=int, default=study.replicas, help=f"[{study.replicas}]")
        task.add_argument("--part", default="1/1", help="K/N: every Nth run")
        tasks.add_parser("collect").add_argument("stores", nargs="*", type=Path, default=[store])
    arguments = parser.parse_args()
    if arguments.task == "draw":
        draw(study, arguments.folder)
    elif arguments.task == "collect":
        collect(study, arguments.stores)
    else:
        measure(study, arguments.store, arguments.replicas, arguments.part)
