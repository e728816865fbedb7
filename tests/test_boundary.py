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
    "model": {"model": 3},
    "alternative": {"alternative": 2},
    "restitution_at": {"restitution_at": 4},
    "threads": {"threads": 0},
    "law": {"law": "glue"},
    "values": {"values": [np.empty(0)] * _core.law_place(2, 2)},
    "strides": {"strides": [0] * _core.law_place(2, 2)},
    "instruction_set": {"instruction_set": "abacus"},
}


@pytest.mark.parametrize("name", BAD_MAPS)
def test_a_sweep_refuses_what_no_plan_says(name: str) -> None:
    with pytest.raises(ValueError, match=f"^{name}: "):
        run_map({"t_end": np.empty(COUNT)}, **BAD_MAPS[name])
