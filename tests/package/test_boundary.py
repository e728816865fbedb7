"""Arguments that reach the compiled core: arrays of the wrong length, type or layout are refused, never written to."""

import math
from typing import Any

import numpy as np
import pytest

import hardlimit as hl
from hardlimit import _core
from hardlimit.sweep.plan import make_plan

COUNT = 8


def run_map(out: dict[str, Any], **changed: Any) -> None:
    plan = make_plan(hl.Column.paper(), "newton", ["t_end"], {"restitution": np.linspace(0.5, 0.9, COUNT)})
    arguments: dict[str, Any] = {
        "law": plan.law,
        "model": 0,
        "alternative": plan.alternative,
        "density_1": plan.densities[0],
        "density_2": plan.densities[1],
        "restitution_at": plan.restitution_at,
        "values": list(plan.values),
        "strides": list(plan.strides),
        "first": 0,
        "count": plan.size,
        "threads": 1,
        "tolerance": math.nan,
        "out": out,
        "progress": None,
    }
    _core.run_map(**(arguments | changed))


def read_only(array: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    array.flags.writeable = False
    return array


BAD_OUTPUTS: dict[str, tuple[Any, type[Exception]]] = {
    "too short": (np.empty(COUNT - 1), ValueError),
    "too long": (np.empty(COUNT + 1), ValueError),
    "single precision": (np.empty(COUNT, np.float32), TypeError),
    "integers": (np.empty(COUNT, np.int64), TypeError),
    "every second": (np.empty(2 * COUNT)[::2], TypeError),
    "two dimensions": (np.empty((COUNT, 1)), TypeError),
    "read-only": (read_only(np.empty(COUNT)), TypeError),
    "a list": ([0.0] * COUNT, TypeError),
    "nothing": (None, TypeError),
}


@pytest.mark.parametrize("which", BAD_OUTPUTS)
def test_a_sweep_writes_only_where_it_fits(which: str) -> None:
    bad, error = BAD_OUTPUTS[which]
    with pytest.raises(error, match="out: t_end"):
        run_map({"t_end": bad})


BAD_MAPS: dict[str, dict[str, Any]] = {
    "alternative": {"alternative": 2},
    "restitution_at": {"restitution_at": 4},
    "law": {"law": "glue"},
    "values": {"values": [np.empty(0)] * _core.law_place(2, 2)},
    "strides": {"strides": [0] * _core.law_place(2, 2)},
    "instruction_set": {"instruction_set": "abacus"},
}


@pytest.mark.parametrize("name", BAD_MAPS)
def test_a_sweep_refuses_what_no_plan_says(name: str) -> None:
    with pytest.raises(ValueError, match=f"^{name}: "):
        run_map({"t_end": np.empty(COUNT)}, **BAD_MAPS[name])


def test_a_force_needs_as_many_rates_as_compressions() -> None:
    contact = hl.LinearDashpot(stiffness=1e6, restitution=0.5).between(hl.Ball(0.01, mass=0.1)).core
    with pytest.raises(ValueError, match="rate: got 2 values, must be 3"):
        contact.force(np.ones(3), np.ones(2))
    strided = contact.force(np.arange(6.0)[::2], np.zeros(3))
    assert strided.tolist() == [0.0, 2e6, 4e6]
    with pytest.raises(TypeError):
        contact.force(np.ones((2, 2)), np.ones((2, 2)))


@pytest.mark.parametrize("parameters", [[], [1e6], [1e6, 0.5, 1.0]])
def test_a_contact_needs_the_parameters_of_its_law(parameters: list[float]) -> None:
    with pytest.raises(ValueError, match=f"parameters: got {len(parameters)} values, must be 2"):
        _core.make_contact("linear", 0, parameters, 0.1, 0.01)


@pytest.mark.parametrize("alternative", [-1, 2, 1000])
def test_a_contact_needs_an_alternative_of_its_law(alternative: int) -> None:
    with pytest.raises(ValueError, match=f"alternative: got {alternative}, must be"):
        _core.make_contact("linear", alternative, [1e6, 0.5], 0.1, 0.01)


@pytest.mark.parametrize("name", ["radius", "contacts", "gaps", "velocity"])
@pytest.mark.parametrize("length", [0, 1, 3])
def test_a_column_needs_one_value_for_each_ball(name: str, length: int) -> None:
    contact = _core.make_contact("linear", 0, [1e6, 0.5], 0.1, 0.01)
    values: dict[str, Any] = {
        "mass": [1.0] * 2,
        "radius": [0.1] * 2,
        "contacts": [contact] * 2,
        "gaps": [0.1] * 2,
        "velocity": [0.0] * 2,
    }
    values[name] = (values[name] * 2)[:length]
    with pytest.raises(ValueError, match=f"{name}: got {length} values, must be 2"):
        _core.make_column(True, 9.81, **values)


def test_a_column_needs_a_ball() -> None:
    with pytest.raises(ValueError, match="mass: got no values"):
        _core.make_column(True, 9.81, [], [], [], [], [])


@pytest.mark.parametrize("method", ["auto", "general"])
@pytest.mark.parametrize("time", [-1.0, 1.0, 1e308, math.inf, math.nan])
def test_a_solution_is_sampled_where_it_is_known(method: Any, time: float) -> None:
    result = hl.newton(hl.Column.paper(restitution=0.7), method=method)
    core = result._core
    with pytest.raises(ValueError, match="times: got "):
        core.sample(np.array([0.0, time]))
    for wrong in (np.zeros((2, 2)), "0.0", None):
        with pytest.raises(TypeError):
            core.sample(wrong)
    once = core.sample(np.array([0.0, 1e-4]))
    again = core.sample(np.array([0.0, 9.0, 1e-4, 9.0])[::2])
    assert all((a == b).all() for a, b in zip(once, again, strict=True))


LONG = pytest.mark.slow  # elastic balls bounce several thousand times


@pytest.mark.parametrize(
    ("model", "restitution"),
    [(model, e) for model in (hl.newton, hl.adiabatic, hl.independent) for e in (0.05, 0.5, 0.9)]
    + [
        pytest.param(hl.newton, 1.0, marks=LONG),
        pytest.param(hl.adiabatic, 1.0, marks=LONG),
        (hl.independent, 1.0),
    ],
)
def test_a_trajectory_far_from_now_ends(model: Any, restitution: float) -> None:
    """The column is at rest, or the time is refused in one line that gives the end of the solution."""
    result = model(hl.Column.paper(restitution=restitution))
    for time in (1e3, 1e12, 1e308):
        try:
            position = result.trajectory([time]).position.values[0]
        except ValueError as refusal:
            assert str(refusal).startswith("times: got ") and "\n" not in str(refusal)
            assert time > 1e3 and (time > 1e9 or restitution == 1.0)
        else:
            assert restitution == 1.0 or position == pytest.approx([0.1, 0.21], abs=1e-5)


BAD_BOXES: dict[str, dict[str, Any]] = {
    "positions": {"positions": np.ones((2, 3))},
    "velocities": {"velocities": np.ones((3, 2))},
    "radius": {"radius": np.full(3, 0.1)},
    "mass": {"mass": np.ones(1)},
    "law": {"law": ("glue", 0, [1.0, 0.5], None)},
    "alternative": {"law": ("linear", 7, [1.0, 0.5], None)},
    "parameters": {"law": ("linear", 0, [1.0], None)},
}


@pytest.mark.parametrize("kind", _core.engine_names)
@pytest.mark.parametrize("name", BAD_BOXES)
def test_no_engine_of_boxes_takes_arguments_of_another_shape(kind: str, name: str) -> None:
    arguments = {
        "positions": np.array([[1.0, 1.0], [3.0, 1.0]]),
        "velocities": np.ones((2, 2)),
        "radius": np.full(2, 0.1),
        "mass": np.ones(2),
        "law": ("linear", 0, [1.0, 0.5], None),
        "time_step": 1e-3,
    }
    bounds = _core.Box([5.0, 5.0], ["periodic", "wall"])
    arguments |= {"rule": "law"} if kind == "hard_spheres" else {}
    assert _core.make_engine(kind, bounds, **arguments).kind == kind
    with pytest.raises(ValueError, match=f"^{name}: got"):
        _core.make_engine(kind, bounds, **(arguments | BAD_BOXES[name]))


def test_engines_of_boxes_refuse_what_makes_no_sense() -> None:
    bounds, row = _core.Box([5.0, 5.0], ["periodic", "wall"]), np.ones((1, 2))
    system = (bounds, row, row, np.ones(1), np.ones(1))
    with pytest.raises(ValueError, match=r"^kind: got springs"):
        _core.make_engine("springs", *system)
    with pytest.raises(ValueError, match=r"^law: got None"):
        _core.make_engine("newton_events", *system)
    engine = _core.make_engine("hard_spheres", *system, restitution=1.0)
    with pytest.raises(ValueError, match=r"^saved: got"):
        _core.load_engine("newton_steps", engine.save())
