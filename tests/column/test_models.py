"""The table of models is the only description of the models, and it agrees with the core."""

import html
import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import hardlimit as hl
from command_line import run
from conftest import columns, draws, free_columns, refusal
from hardlimit import plots
from hardlimit.column.models import MODELS

CORE = Path(__file__).resolve().parents[2] / "core"
every_model = pytest.mark.parametrize("model", MODELS.values(), ids=list(MODELS))


def solve(model, column, **options):
    return getattr(hl, model.name)(column, **options)


def test_numbers_are_those_of_the_core():
    enums = [
        body
        for path in CORE.rglob("*.hpp")
        for body in re.findall(r"enum class Model[^{]*\{([^}]*)\}", path.read_text(encoding="utf-8"))
    ]
    assert enums
    for body in enums:
        names = [entry.partition("=")[0].strip() for entry in body.split(",")]
        assert names == list(MODELS)
        assert [int(n) for n in re.findall(r"= (\d+)", body)] in ([], [0, 1, 2])
    assert [model.number for model in MODELS.values()] == list(range(len(MODELS)))


@every_model
def test_a_model_names_itself(model):
    assert MODELS[model.name] is model
    for text in (model.label, model.short, model.limits, model.needs):
        assert text and "\n" not in text
    result = solve(model, hl.Column.paper())
    assert result.model == model.name and html.escape(model.limits) in result._repr_html_()
    with pytest.raises(TypeError):
        MODELS[model.name] = None


@every_model
@draws(30)
@given(column=st.one_of(columns(least=1, most=3), free_columns(most=3)))
def test_a_model_takes_what_it_applies_to(model, column):
    if model.applies(column):
        assert solve(model, column, until=1e-6).column is column
    else:
        refused = refusal(lambda: solve(model, column))
        assert refused == f"column: the {model.name} model applies only to {model.needs}"


@draws(30)
@given(column=st.one_of(columns(least=1, most=3), free_columns(most=3)))
def test_columns_that_are_solvable_exactly(column):
    assert hl.newton(column, until=1e-6).method.endswith("exact") == column.solvable_exactly
    if column.solvable_exactly:
        assert "exact" in hl.newton(column, until=1e-6, method="exact").method
    else:
        with pytest.raises(ValueError, match="method: got 'exact', must be auto or general"):
            hl.newton(column, method="exact")


@every_model
def test_sweeps_know_the_model(model):
    """A sweep uses the right model number: the map contains the results of the model's solver."""
    column = hl.Column.paper(0.6, 1e-4, 3.0)
    dataset = hl.sweep(column, model=model.name, gap=[1e-4, 2e-3])
    wanted = [solve(model, column.replace(gaps=gap)).relative_velocity for gap in (1e-4, 2e-3)]
    assert dataset.relative_velocity.values == pytest.approx(wanted, rel=1e-12)
    assert dataset.attrs["model"] == model.name
    others = {
        m.name: hl.sweep(column, model=m.name, gap=[1e-4]).relative_velocity.values for m in MODELS.values()
    }
    assert len({float(v[0]) for v in others.values()}) == len(MODELS)


def test_labels_are_those_of_the_description():
    comparison = hl.compare(hl.Column.paper())
    (legend,) = plots.heights(*comparison.results).legends
    labels = [text.get_text() for text in legend.get_texts()]
    assert all(any(model.label in label for label in labels) for model in MODELS.values())
    shown = run("drop").stdout
    assert any(set(line.split()) == {model.short for model in MODELS.values()} for line in shown.splitlines())
    assert all(f"<th>{model.short}</th>" in comparison._repr_html_() for model in MODELS.values())
