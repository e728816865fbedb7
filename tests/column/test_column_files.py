"""Columns as TOML: written columns are read back bit for bit; invalid input is refused in one line."""

import math
from pathlib import Path

import pytest
from hypothesis import given

import hardlimit as hl
from conftest import columns, draws, free_columns, refusal
from hardlimit.column import files

GOOD = """
height = 0.6
gaps = [1e-4]

[[balls]]
radius = 0.1
density = 840.0

[[balls]]
radius = 0.01
density = 840.0

[law]
name = "linear"
stiffness = 5e7
restitution = 0.7
"""


def written(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "column.toml"
    path.write_text(text, encoding="utf-8")
    return path


@draws(25)
@given(columns())
def test_columns_survive_writing(column: hl.Column) -> None:
    assert files.loads(files.dumps(column)) == column


@draws(10)
@given(free_columns())
def test_cradles_survive_writing(column: hl.Column) -> None:
    assert files.loads(files.dumps(column)) == column


def test_one_law_for_each_contact() -> None:
    laws = [hl.LinearDashpot(stiffness=1e6, damping=d) for d in (0.0, 3.0)]
    column = hl.Column([hl.Ball(0.1, mass=1.0), hl.Ball(0.05, density=100.0)], 1e-3, 0.4, laws, [-1.0, 0.5])
    text = files.dumps(column)
    assert text.count("[[laws]]") == 2 and "mass = 1.0" in text and "velocities = [-1.0, 0.5]" in text
    assert files.loads(text) == column


def test_file(tmp_path: Path) -> None:
    assert files.read(written(tmp_path, GOOD)) == hl.Column.paper()
    files.write(hl.Column.paper(gap=0.0), tmp_path / "other.toml")
    assert files.read(tmp_path / "other.toml").gaps == (0.0,)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("height = 0.6", "height = 0.6\nhieght = 1", "hieght: unknown"),
        ("height = 0.6", "", "height: missing"),
        ("height = 0.6", "height = 0.05", "height: got 0.05, must be >= 0.1"),
        ("height = 0.6", "height = nan", "height: got nan, must be finite"),
        ("height = 0.6", "height = '0.6'", "height: got '0.6', must be a number"),
        ("gaps = [1e-4]", "", "gaps: missing"),
        ("gaps = [1e-4]", "gaps = [-1e-4]", "gaps[0]: got -0.0001, must be >= 0"),
        ("gaps = [1e-4]", "gaps = [0, 0]", "gaps: got 2 values, must be 1"),
        ("gaps = [1e-4]", "gaps = [1e-4]\ngravity = -1", "gravity: got -1"),
        ("radius = 0.01", "radius = 0", "balls[1].radius: got 0, must be > 0"),
        ("radius = 0.01", "", "balls[1].radius: missing"),
        ("radius = 0.01", "radius = 0.01\ncolour = 'red'", "balls[1].colour: unknown"),
        ("radius = 0.01", "radius = 0.01\nmass = 1", "balls[1].density | mass: got both"),
        ("restitution = 0.7", "restitution = 1.5", "law.restitution: got 1.5, must be in (0, 1]"),
        ("restitution = 0.7", "", "law.restitution | damping: got neither"),
        ("restitution = 0.7", "restitution = 0.7\ndamping = 1", "law.restitution | damping"),
        ("restitution = 0.7", "bounce = 0.7", "law.bounce: unknown"),
        ('name = "linear"', 'name = "cubic"', "law.name: got 'cubic', must be one of linear, viscoelastic"),
        ("[law]", "[later]", "later: unknown"),
        ("gaps = [1e-4]", "gaps = [1e-4]\ncradle = true", "height: got 0.6, must be left out for a cradle"),
        ("gaps = [1e-4]", "gaps = [1e-4]\nlaws = []", "law | laws: got both"),
        ("[law]", "[law", "not valid TOML"),
    ],
)
def test_refused(tmp_path: Path, old: str, new: str, message: str) -> None:
    text = GOOD.replace(old, new, 1)
    assert text != GOOD
    path = written(tmp_path, text)
    refused = refusal(lambda: files.read(path))
    assert message in refused and str(path) in refused


def test_cradle_may_state_that_there_is_no_gravity() -> None:
    text = files.dumps(
        hl.Column.cradle([hl.Ball(0.1, mass=1.0)] * 2, [1, 0], hl.LinearDashpot(stiffness=1e6, damping=3.0))
    )
    assert files.loads("gravity = 0.0\n" + text) == files.loads(text)
    with pytest.raises(ValueError, match=r"gravity: got 9\.81, must be 0"):
        files.loads("gravity = 9.81\n" + text)


def test_broken_toml_says_where(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"line 2, column"):
        files.read(written(tmp_path, "height = 0.6\ngaps = = 3\n"))


def test_missing_file() -> None:
    with pytest.raises(FileNotFoundError, match=r"^nowhere\.toml: no such file$"):
        files.read("nowhere.toml")


def test_not_text(tmp_path: Path) -> None:
    path = tmp_path / "binary.toml"
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ValueError, match="not valid TOML"):
        files.read(path)


def test_unwritable_file(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="cannot be written"):
        files.write(hl.Column.paper(), tmp_path / "no folder" / "column.toml")


def test_changes() -> None:
    base = files.of_column(hl.Column.paper())
    changed = files.with_balls(base, radius_ratio=5.0).column()
    assert changed == hl.Column.paper(radius_ratio=5.0)
    changed = files.with_motion(files.with_law(base, None, {"damping": 3.0}), gaps=[0.0]).column()
    assert changed.laws[0].parameters == {"stiffness": 5e7, "damping": 3.0} and changed.gaps == (0.0,)
    three = files.with_balls(base, radii=[0.1, 0.05, 0.02])
    assert len(files.with_motion(three).column().gaps) == 2


def test_parameters_decide_the_law() -> None:
    base = files.of_column(hl.Column.paper())
    hertz = {"youngs_modulus": 5e7, "poisson_ratio": 0.45, "dissipative_time": 0.0}
    assert files.with_law(base, None, hertz).laws == (hl.Viscoelastic(**hertz),)
    with pytest.raises(ValueError, match=r"bounce: unknown for the law linear"):
        files.with_law(base, None, {"bounce": math.nan})
