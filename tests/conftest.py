"""What several test files share: the reference data, random columns, two balls at given masses."""

import csv
import gc
import json
import math
import os
import signal
import subprocess
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from filelock import FileLock
from hypothesis import settings
from hypothesis import strategies as st

import hardlimit as hl

DATA = Path(__file__).parent / "data"

# The same examples on every machine; a slow shared one is no failure.
settings.register_profile("hardlimit", deadline=None, derandomize=True, database=None)
settings.load_profile("hardlimit")

# A shell starts what it puts in the background with Ctrl-C ignored, and children inherit that: undo it for the
# tests that interrupt one.
signal.signal(signal.SIGINT, signal.default_int_handler)

#: Examples of a property with the fast tests, where it has more.
FEW = 4

_few = True
_worker = os.environ.get("PYTEST_XDIST_WORKER", "")  #: gw0, gw1, … with xdist

TWO_BALL_TABLES = ["two_ball_paper", "two_ball_ratio", "two_ball_wide"]

#: Constants of common solids, by name of the parameter; of others the middle of the accepted range.
TYPICAL = {
    "stiffness": 1e7,
    "youngs_modulus": 1e9,
    "poisson_ratio": 0.3,
    "elastic_prefactor": 1e9,
}


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--rows", type=int, default=None, help="of each table in test_reference.py, at random")


def pytest_configure(config: pytest.Config) -> None:
    global _few
    _few = "not slow" in config.option.markexpr
    # pytest expands the asserts of a file into objects that live until its end. To look for cycles among all that
    # collection makes takes longer than to make it.
    gc.disable()


class Backwards(pytest.Dir):
    """A folder whose last file is collected first."""

    def collect(self) -> Iterable[pytest.Item | pytest.Collector]:
        return reversed(list(super().collect()))


def pytest_collect_directory(path: Path, parent: pytest.Collector) -> pytest.Collector | None:
    """Every second worker begins at the last file. Where two meet, each reads what the other has compiled."""
    return Backwards.from_parent(parent, path=path) if _worker.endswith(tuple("13579")) else None


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    if _worker:
        items.sort(key=lambda item: item.path.parts)


def pytest_collection_finish() -> None:
    gc.freeze()
    gc.set_threshold(50_000)  # the default, 700, spends a fiftieth of the time on looking for cycles
    gc.enable()


def refusal(call: Callable[[], object]) -> str:
    """The message of the ValueError that a call raises: one line."""
    with pytest.raises(ValueError) as error:
        call()
    assert "\n" not in str(error.value)
    return str(error.value)


def compiled(program: str, folder: Path, *flags: str) -> Path:
    """The program made from the headers and a source such as ``contact/engagement.cpp``: once for all workers of a run.

    ``folder``: a temporary folder of a test, beside which the programs are kept.
    """
    tests = Path(__file__).parent
    # Most of the time goes into reading the headers; -O1 takes a fifth less of it than -O2.
    command = [
        "g++",
        "-std=c++20",
        "-O1",
        "-ffp-contract=off",
        "-Wno-psabi",
        "-pthread",
        f"-I{tests.parent / 'core'}",
    ]
    built = (folder.parents[1] if _worker else folder.parent) / program.replace("/", "-")
    with FileLock(f"{built}.lock"):
        if not built.exists():
            subprocess.run([*command, *flags, str(tests / program), "-o", f"{built}.part"], check=True)
            os.rename(f"{built}.part", built)
    return built


def output_of(program: str, folder: Path, *flags: str, stdin: str = "") -> str:
    """What a compiled program of the tests prints; ``stdin`` is its input."""
    built = compiled(program, folder, *flags)
    return subprocess.run([built], input=stdin, capture_output=True, text=True, check=True).stdout


def draws(most: int, few: int = FEW, **others: Any) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Settings of a property: ``few`` examples with the fast tests, ``most`` of them with the slow ones."""

    def decorate(test: Callable[..., None]) -> Callable[..., None]:
        if _few:
            return settings(max_examples=min(most, few), **others)(test)
        return pytest.mark.slow(settings(max_examples=most, **others)(test))

    return decorate


def slow(*values: object) -> Any:
    """Parameters with which a test is one of the slow ones."""
    return pytest.param(*values, marks=pytest.mark.slow)


def wait_until(condition: Callable[[], object], timeout: float = 30.0) -> None:
    """Return once ``condition()`` is true, or fail after ``timeout`` seconds."""
    deadline = time.monotonic() + timeout
    while not condition():
        assert time.monotonic() < deadline, "what was waited for did not happen"
        time.sleep(0.01)


def table(name: str) -> list[dict[str, str]]:
    with open(DATA / f"{name}.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert rows, name
    return rows


def columns_json() -> list[dict]:
    return json.loads((DATA / "columns.json").read_text(encoding="utf-8"))


def number(field: str) -> float:
    """A field of a table; an empty one is NaN."""
    return float(field) if field else math.nan


def two_ball_column(row: dict[str, str]) -> hl.Column:
    """The drop of one row of the linear two-ball tables."""
    law = hl.LinearDashpot(stiffness=float(row["stiffness_N_m"]), restitution=float(row["restitution"]))
    density = float(row["density_kg_m3"])
    balls = [hl.Ball(float(row[f"radius_{i}_m"]), density=density) for i in (1, 2)]
    return roomy(hl.Column(balls, [float(row["gap_m"])], float(row["height_m"]), law))


def roomy(column: hl.Column, scale: float = 100.0) -> hl.Column:
    """The same masses in larger balls: under the linear law radii only decide when a contact is too deep."""
    balls = [hl.Ball(scale * ball.radius, mass=ball.mass) for ball in column.balls]
    return column.replace(balls=balls, height=balls[0].radius + column.drop_height)


def too_deep_later() -> hl.Column:
    """A column whose result is ok, with a contact that becomes too deep soon after the sequence."""
    balls = [hl.Ball(0.0575, density=261.0), hl.Ball(0.0492, density=408.0), hl.Ball(0.00189, density=7080.0)]
    constants = (3.46e7, 0.093), (5.39e6, 0.9), (1.4e4, 0.413)
    laws = [hl.LinearDashpot(stiffness=k, restitution=e) for k, e in constants]
    return hl.Column(balls, [1.57e-5, 0.0], 1.01, laws, [0.886, -1.607, -0.138], 100.0)


def typical(p: dict) -> float:
    """A value for a parameter of a law, also of a law that these tests have never heard of."""
    bounded = math.isfinite(p["lowest"]) and math.isfinite(p["highest"])
    middle = 0.5 * (p["lowest"] + p["highest"]) if bounded else max(p["lowest"], 0.0) + 1e7
    return TYPICAL.get(p["name"], middle)


def alternative(name: str, restitution: bool) -> list[dict]:
    """The first set of parameters of a law that has a restitution among them, or that has none."""
    record = hl.LAWS[name].record
    chosen = next(
        c for c in record["alternatives"] if restitution is any(p["name"] == "restitution" for p in c)
    )
    return [*record["common"], *chosen]


def law_of(name: str, restitution: float, speed: float = 1.0) -> hl.Law:
    """A law of the given kind whose contacts have ``restitution`` at ``speed``."""
    values = {"restitution": restitution, "impact_speed": speed}
    parameters = alternative(name, restitution=True)
    return hl.LAWS[name](**{p["name"]: values.get(p["name"], typical(p)) for p in parameters})


def damping_name(name: str) -> str:
    """The material constant of a law that damps: what it takes where it takes no restitution."""
    with_restitution = {p["name"] for p in alternative(name, restitution=True)}
    (damping,) = (
        p["name"] for p in alternative(name, restitution=False) if p["name"] not in with_restitution
    )
    return damping


def damped(name: str, damping: float) -> hl.Law:
    """A law of the given kind with this material constant of damping."""
    parameters = alternative(name, restitution=False)
    known = {damping_name(name): damping}
    return hl.LAWS[name](**{p["name"]: known.get(p["name"], typical(p)) for p in parameters})


def dimension(unit: str) -> tuple[float, float, float]:
    """Exponents of mass, length and time of a unit such as ``N s/m^1.5``."""
    base = {
        "1": (0, 0, 0), "kg": (1, 0, 0), "m": (0, 1, 0), "s": (0, 0, 1), "N": (1, 1, -2), "Pa": (1, -1, -2),
    }  # fmt: skip
    total = [0.0, 0.0, 0.0]
    for sign, part in zip((1.0, -1.0), unit.split("/"), strict=False):
        for factor in part.split():
            name, _, power = factor.partition("^")
            for i, exponent in enumerate(base[name]):
                total[i] += sign * float(power or 1.0) * exponent
    mass, length, time = total
    return mass, length, time


def falling(masses, gaps, law, *, radius=0.02, speed=1.0, gravity=0.0) -> hl.Column:
    """Balls that all move down at ``speed``, the lowest one touching the floor."""
    balls = [hl.Ball(radius, mass=m) for m in masses]
    return hl.Column(balls, gaps, radius, law, velocities=-speed, gravity=gravity)


def long_after(column: hl.Column, method: str = "general") -> hl.Result:
    """The column a thousand durations of its floor contact later."""
    duration = column.contacts[0].duration(column.impact_speed)
    return hl.newton(column, until=1e3 * duration, method=method)


def log_floats(low: float, high: float) -> st.SearchStrategy[float]:
    """Floats spread evenly over decades."""
    return st.floats(math.log(low), math.log(high)).map(math.exp)


restitutions = st.one_of(
    st.floats(0.05, 1.0), st.sampled_from([1.0, math.exp(-2.0), math.exp(-math.pi / 2.0), 0.999, 0.01])
)


@st.composite
def laws(draw, restitution=restitutions) -> hl.Law:
    name = draw(st.sampled_from(sorted(hl.LAWS)))
    return law_of(name, draw(restitution), draw(log_floats(0.3, 3.0)))


@st.composite
def columns(draw, law=None, least=2, most=5, gravity=None) -> hl.Column:
    """Random columns of a few balls above a floor."""
    n = draw(st.integers(least, most))
    radii = [draw(log_floats(3e-3, 3e-2)) for _ in range(n)]
    gaps = [draw(st.one_of(st.just(0.0), log_floats(1e-7, 1e-3))) for _ in range(n - 1)]
    fall = draw(log_floats(1e-2, 0.5))
    density = draw(log_floats(500.0, 8000.0))
    chosen = draw(laws()) if law is None else draw(law)
    g = draw(st.sampled_from([9.81, 1.62])) if gravity is None else gravity
    speed = 0.0 if g > 0.0 else -draw(log_floats(0.2, 3.0))
    balls = [hl.Ball(r, density=density) for r in radii]
    return hl.Column(balls, gaps, radii[0] + fall, chosen, velocities=speed, gravity=g)


@st.composite
def free_columns(draw, law=None, least=2, most=5) -> hl.Column:
    """Random balls in a row that run into each other, without floor and gravity."""
    n = draw(st.integers(least, most))
    balls = [hl.Ball(draw(log_floats(3e-3, 3e-2)), density=2500.0) for _ in range(n)]
    gaps = [draw(st.one_of(st.just(0.0), log_floats(1e-7, 1e-3))) for _ in range(n - 1)]
    velocities = sorted((0.01 * draw(st.integers(-200, 200)) for _ in range(n)), reverse=True)
    if velocities[0] == velocities[-1]:
        velocities[0] += 1.0
    return hl.Column.cradle(balls, velocities, draw(laws()) if law is None else draw(law), gaps)


def lattice(n=27, dimension=3, seed=0, spread=1.0, **changes) -> hl.ParticleSystem:
    """Grains near the points of a lattice, with random velocities; radii from 1 mm to 1 mm/spread."""
    rng = np.random.default_rng(seed)
    along = max(2, math.ceil(n ** (1.0 / dimension)))
    points = np.stack(np.meshgrid(*[np.arange(along)] * dimension, indexing="ij"), -1).reshape(-1, dimension)
    at = (points[:n] + 0.5) * 3e-3 + rng.uniform(-0.4e-3, 0.4e-3, (n, dimension))
    radius = 1e-3 * spread ** -rng.random(n)
    velocities = rng.normal(size=(n, dimension))
    values = {"density": 2500.0, "box": [along * 3e-3] * dimension}
    return hl.ParticleSystem(at, velocities, radius, **(values | changes))
