"""Adding a contact law takes one header and one registry entry: the steps of CONTRIBUTING.md, in a copy of the tree."""

import json
import os
import re
import shutil
import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
LAW = ROOT / "tests" / "contact" / "conical.hpp"

USE = """
import json
import numpy as np
import hardlimit as hl
from hardlimit import _core
law = hl.Conical(cone_stiffness=1e9, restitution=0.7)
column = hl.Column.paper(law=law)
drop = hl.newton(column)
ball = hl.Ball(0.01, density=840.0)
contact = law.between(ball, ball).core
oblique = _core.planar_contact(contact, 0.02, 1.0, 0.5)
read = _core.soft_contacts(contact, 0.02, False, contact, 0.02, np.array([1.0, 1.0]), np.array([0.0, 0.5]))
print(json.dumps({
    "outcome": drop.outcome, "contacts": drop.n_contacts, "energy_error": drop.energy_error,
    "independent": hl.independent(column).effective_restitution,
    "swept": hl.sweep(column, restitution=[0.7]).relative_velocity.values.tolist(),
    "velocity": drop.relative_velocity,
    "turn": oblique["turn"], "read": read.tolist(),
}))
"""


def steps() -> list[str]:
    """The commands of the section "Add a law", in order."""
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    section = text.split("## Add a law\n")[1].split("\n## ")[0]
    blocks = re.findall(r"```\w*\n(.*?)```", section, flags=re.S)
    return [line.strip() for block in blocks for line in block.splitlines() if line.strip()]


def copy_of_the_tree(to: Path) -> None:
    left = shutil.ignore_patterns(
        ".git", "build", "_build", "dist", "node_modules", "__pycache__", ".*_cache"
    )
    shutil.copytree(ROOT, to, ignore=left)


def environment(packages: Path) -> dict[str, str]:
    """Environment in which pip installs to ``packages``, and Python imports from there first."""
    changed = {
        "PATH": os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]]),
        "PYTHONPATH": str(packages),
        "PIP_TARGET": str(packages),
        "PIP_NO_DEPS": "1",
        "PIP_NO_BUILD_ISOLATION": "0",  # pip reads a false value as "without isolation"
        # Halves the compile time and does not affect the test.
        "SKBUILD_CMAKE_BUILD_TYPE": "None",
        "CXXFLAGS": "-O1",
    }
    return os.environ | changed


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_the_steps_of_the_documentation_add_a_law(tmp_path):
    tree, packages = tmp_path / "tree", tmp_path / "packages"
    copy_of_the_tree(tree)
    # Step 1, the header; step 2, its entry.
    shutil.copy(LAW, tree / "core" / "contact")
    registry = tree / "core" / "contact" / "registry.hpp"
    text = registry.read_text(encoding="utf-8")
    include = '#include "conical.hpp"\n'
    text = text.replace('#include "linear_dashpot.hpp"\n', include + '#include "linear_dashpot.hpp"\n')
    text = re.sub(r"\n    X\(", r"\n    X(Conical) \\\n    X(", text, count=1)
    registry.write_text(text, encoding="utf-8")
    run = partial(subprocess.run, env=environment(packages), capture_output=True, text=True)
    commands = steps()
    assert len(commands) >= 4
    for command in commands:
        command = command.replace("NAME", "conical")
        done = run(command, shell=True, cwd=tree, check=False)
        assert done.returncode == 0, f"{command}\n{done.stdout[-3000:]}\n{done.stderr[-3000:]}"
        if "pytest" in command:
            assert int(re.search(r"(\d+) passed", done.stdout)[1]) > 30
    used = run([sys.executable, "-c", USE], cwd=tmp_path, check=True)
    output = json.loads(used.stdout)
    assert output["outcome"] == "ok" and output["contacts"] >= 1
    assert output["energy_error"] < 1e-10
    assert output["independent"] == pytest.approx(0.7, rel=1e-12)
    assert output["read"][0][3] == pytest.approx(0.7, rel=1e-10)
    assert output["read"][1][1] == pytest.approx(output["turn"], rel=1e-10)
    assert output["swept"] == pytest.approx([output["velocity"]], rel=1e-9)
    stubs = tree / "src" / "hardlimit" / "contact" / "laws.pyi"
    assert "class Conical(Law)" in stubs.read_text(encoding="utf-8")
    assert "## Conical" in (tree / "docs" / "generated" / "laws.md").read_text(encoding="utf-8")
