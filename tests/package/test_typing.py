"""Type checking of user code: every public name is typed, and arrays are distinguished from numbers."""

import subprocess
import sys
from pathlib import Path

import pytest

import hardlimit as hl

USER = """
import numpy as np
from numpy.typing import NDArray
from typing import assert_type

import hardlimit as hl
from hardlimit import {laws}

law: hl.Law = LinearDashpot(stiffness=1e6, restitution=0.5)
ball = hl.Ball(0.01, density=2500.0)
contact = law.between(ball, hl.FLOOR)
speeds = np.linspace(0.1, 1.0, 5)
Floats = NDArray[np.float64]

assert_type(contact.restitution(), float)
assert_type(contact.restitution(2), float)
assert_type(contact.restitution(speeds), Floats)
assert_type(contact.duration([0.5, 1.0]), Floats)
assert_type(contact.force(1e-6), float)
assert_type(contact.force(1e-6, -1.0), float)
assert_type(contact.force(speeds, 0.0), Floats)
assert_type(contact.force(1e-6, speeds), Floats)
assert_type(contact.energy(1e-6), float)
assert_type(contact.energy(speeds), Floats)
assert_type(contact.effective_mass, float)
assert_type(law.replace(restitution=0.7), hl.Law)
assert_type(Tsuji(elastic_prefactor=1e9, restitution=0.5).restitution, float)
assert_type(hl.restitution_series(0.1), float)
assert_type(hl.restitution_pade(speeds), Floats)
assert_type(hl.usual_damping(0.5, 1e6, 0.1), float)
result: hl.Result = hl.newton(hl.Column.paper(law=law))
box = hl.ParticleSystem.random(8, 0.1, 1e-3, 2500.0, 1.0)
run = hl.event_driven(box.replace(gravity=9.81, box=[0.1, 0.1, 0.2]), law=law, until=1.0)
assert_type(run, hl.ParticleResult)
assert_type(run.system.positions, Floats)
"""

WRONG = """
import hardlimit as hl

hl.LinearDashpot(stifness=1e6, restitution=0.5)
hl.LinearDashpot(stiffness="hard", restitution=0.5)
hl.Column.paper().contacts[0].force("deep")
"""

# Checking these would take most of the time, and no asserted type comes from them.
SETTINGS = """
[mypy]
[mypy-xarray.*,pandas.*,matplotlib.*]
follow_imports = skip
"""


@pytest.mark.slow
def test_a_type_checker_accepts_what_is_right_and_sees_what_is_wrong(tmp_path):
    """mypy --strict on user files outside this repository."""
    laws = ", ".join(law.__name__ for law in hl.LAWS.values())
    (tmp_path / "right.py").write_text(USER.format(laws=laws), encoding="utf-8")
    (tmp_path / "wrong.py").write_text(WRONG, encoding="utf-8")
    (tmp_path / "mypy.ini").write_text(SETTINGS, encoding="utf-8")
    command = [sys.executable, "-m", "mypy", "--strict", "--no-error-summary", "right.py", "wrong.py"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    errors = [line for line in done.stdout.splitlines() if " error: " in line]
    assert [line.split(" error: ")[0] for line in errors] == ["wrong.py:4:", "wrong.py:5:", "wrong.py:6:"], (
        done.stdout + done.stderr
    )


def test_the_stub_names_what_the_package_offers():
    """Every public name is declared; the stub itself is compared with tools/stubs.py in CI."""
    stub = (Path(hl.__file__).parent / "__init__.pyi").read_text(encoding="utf-8")
    for name in hl.__all__:
        assert f"import {name} as {name}\n" in stub or f"\n{name}: " in stub, name
