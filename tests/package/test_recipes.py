"""A contact law and a collision rule each take one header and one registry entry: the steps of CONTRIBUTING.md, in a
copy of the tree, and what users then do with them."""

import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
LAW = ROOT / "tests" / "contact" / "conical.hpp"
RULE = ROOT / "tests" / "boxes" / "threshold.hpp"

pytestmark = [pytest.mark.slow, pytest.mark.timeout(1800)]

LAW_IN_COLUMNS = """
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

LAW_IN_BOXES = """
import json
import hardlimit as hl
law = hl.Conical(cone_stiffness=1e9, restitution=0.7)
gas = hl.ParticleSystem.random(27, 0.2, radius=1e-3, density=2500.0, rms_speed=0.1)
answer = hl.check(gas, law=law)
ball = hl.Ball(1e-3, density=2500.0)
wanted = hl.convert(ball, restitution=0.7, speed=0.1, duration=1e-4, law="conical")
try:
    hl.molecular_dynamics(gas, law=law, until=1e-3, engine="lammps")
except ValueError as error:
    refusal = str(error)
compared = hl.fidelity(gas, law=law, until=0.01, samples=2)
compared.plot().savefig("fidelity.png")
print(json.dumps({
    "sentence": answer.sentence,
    "restitution": answer.contacts.restitution.values.tolist(),
    "spring": answer.rows[0].spring, "unit": answer.rows[0].stiffness_unit,
    "stiffness": wanted.contacts[0].stiffness, "duration": wanted.contacts[0].duration, "models": wanted.models,
    "reached": law.replace(cone_stiffness=wanted.contacts[0].stiffness).between(ball, ball).duration(0.1),
    "refusal": refusal, "models_compared": compared.models, "outcomes": compared.outcomes("newton"),
}))
"""

NEW_RULE = """
import json
import hardlimit as hl
gas = hl.ParticleSystem.random(27, 0.2, radius=1e-3, density=2500.0, rms_speed=0.01)
runs = {
    rule: hl.event_driven(gas, restitution=0.5, rule=rule, max_collisions=5000)
    for rule in ("constant", "threshold")
}
runs["adjustable"] = hl.event_driven(
    gas, restitution=0.5, rule="adjustable", threshold_speed=0.01, max_collisions=5000, checkpoint="rule.npz"
)
runs["adjustable"].save("rule.nc")
law = hl.LinearDashpot(stiffness=1e3, restitution=0.5)
compared = hl.fidelity(gas, law=law, until=0.1, samples=2, replicas=2)
compared.plot().savefig("fidelity.png")
try:
    hl.error_law(packing_fraction=0.2, restitution=0.5, rule="threshold")
except ValueError as error:
    refusal = str(error)
print(json.dumps({
    "speeds": {rule: (run.system.granular_temperature / run.system.n) ** 0.5 for rule, run in runs.items()},
    "loaded": hl.load("rule.nc").settings.report(), "resumed": hl.resume("rule.npz", max_collisions=5100).n_collisions,
    "table": runs["threshold"]._repr_html_(), "report": runs["threshold"].settings.report(),
    "models": compared.models, "predicted": compared.predicted("threshold").reason, "summary": str(compared),
    "refusal": refusal, "rules": hl.check(gas, law=law).contacts.rule.values.tolist(),
}))
"""

Run = Callable[..., str]


def steps(section: str) -> list[str]:
    """The commands of a section of CONTRIBUTING.md, in order."""
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    own = text.split(f"## {section}\n")[1].split("\n## ")[0]
    blocks = re.findall(r"```\w*\n(.*?)```", own, flags=re.S)
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
        "CXXFLAGS": "-O0",
    }
    return os.environ | changed


def add(tree: Path, header: Path, room: str, include_before: str, *entries: str) -> None:
    """Steps 1 and 2 of both recipes: the header, and its include and last entries in the registry of its room."""
    shutil.copy(header, tree / "core" / room)
    registry = tree / "core" / room / "registry.hpp"
    text = registry.read_text(encoding="utf-8")
    include = f'#include "{include_before}"\n'
    assert include in text
    text = text.replace(include, f'#include "{header.name}"\n{include}')
    for entry in entries:
        text = re.sub(r"\n    X\((\w+)\)\n", rf"\n    X(\1) \\\n    X({entry})\n", text, count=1)
    registry.write_text(text, encoding="utf-8")


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the tree with the law and the rule."""
    path = tmp_path_factory.mktemp("recipes") / "tree"
    copy_of_the_tree(path)
    add(path, LAW, "contact", "linear_dashpot.hpp", "Conical")
    add(path, RULE, "boxes/hard_spheres/rules", "constant.hpp", "Threshold", "AdjustableThreshold")
    return path


@pytest.fixture(scope="module")
def python(tree: Path) -> Run:
    """Runs Python with the package built from the tree by the commands of "Add a law"."""
    packages = tree.parent / "packages"
    packages.mkdir()
    # An editable install imports the package from its checkout, whatever the path.
    drop = "import sys\nsys.meta_path = [f for f in sys.meta_path if 'ScikitBuild' not in type(f).__name__]\n"
    (packages / "sitecustomize.py").write_text(drop, encoding="utf-8")
    run = partial(subprocess.run, env=environment(packages), capture_output=True, text=True, check=False)
    commands = steps("Add a law")
    assert len(commands) >= 3
    for command in commands:
        command = command.replace("NAME", "conical")
        done = run(command, shell=True, cwd=tree)
        assert done.returncode == 0, f"{command}\n{done.stdout[-3000:]}\n{done.stderr[-3000:]}"
        if "pytest" in command:
            assert int(re.search(r"(\d+) passed", done.stdout)[1]) > 30

    def output(*arguments: str) -> str:
        done = run([sys.executable, *arguments], cwd=tree.parent)
        assert done.returncode == 0, f"{arguments}\n{done.stdout[-3000:]}\n{done.stderr[-3000:]}"
        return done.stdout

    return output


def test_a_law_works_in_columns_and_sweeps(tree: Path, python: Run) -> None:
    output = json.loads(python("-c", LAW_IN_COLUMNS))
    assert output["outcome"] == "ok" and output["contacts"] >= 1
    assert output["energy_error"] < 1e-10
    assert output["independent"] == pytest.approx(0.7, rel=1e-12)
    assert output["read"][0][3] == pytest.approx(0.7, rel=1e-10)
    assert output["read"][1][1] == pytest.approx(output["turn"], rel=1e-10)
    assert output["swept"] == pytest.approx([output["velocity"]], rel=1e-9)
    stubs = tree / "src" / "hardlimit" / "contact" / "laws.pyi"
    assert "class Conical(Law)" in stubs.read_text(encoding="utf-8")
    python(str(tree / "docs" / "generate.py"))
    assert "## Conical" in (tree / "docs" / "generated" / "laws.md").read_text(encoding="utf-8")


def test_a_law_works_in_boxes_checks_and_conversions(python: Run) -> None:
    output = json.loads(python("-c", LAW_IN_BOXES))
    assert output["sentence"].startswith(("Yes", "No", "Cannot be said: event-driven cools"))
    assert output["restitution"] == pytest.approx([0.7] * len(output["restitution"]), rel=1e-9)
    assert output["spring"][0] == "cone_stiffness" and output["unit"] == "Pa"
    assert output["reached"] == pytest.approx(output["duration"], rel=1e-9)
    assert output["duration"] == pytest.approx(1e-4, rel=1e-9) and output["models"] == []
    assert "must be one of linear" in output["refusal"] and "lammps" in output["refusal"]
    assert output["models_compared"] == ["newton", "constant", "law", "tc", "soft", "threshold"]


def test_a_law_works_on_the_command_line(python: Run) -> None:
    law = ("--law", "conical", "--cone-stiffness", "1e9")
    box = ("--n", "27", "--packing-fraction", "0.2", "--radius", "1mm")
    python("-m", "hardlimit", "gas", *box, *law, "--restitution", "0.7", "--max-collisions", "100")
    bead = ("--radius", "1mm", "--density", "2500", "--restitution", "0.7")
    text = " ".join(
        python("-m", "hardlimit", "convert", *bead, "--law", "conical", "--duration", "1e-4s").split()
    )
    assert "N/m^2" in text and "N s/m^1.5" in text
    python("-m", "hardlimit", "check", *bead, *law, "--speed", "0.1", "--packing-fraction", "0.2")
    python("-m", "hardlimit", "check", str(ROOT / "examples" / "in.granular_gas"), "--speed", "0.1")
    contact = ("--radius", "1mm", "--density", "2500", *law, "--restitution", "0.7")
    python("-m", "hardlimit", "contact", *contact, "--plot", "contact.png")


def test_a_rule_works_in_boxes_and_comparisons(tree: Path, python: Run) -> None:
    output = json.loads(python("-c", NEW_RULE))
    assert output["speeds"]["adjustable"] == output["speeds"]["threshold"]
    assert output["loaded"] == "adjustable, restitution 0.5, threshold speed 0.01 m/s"
    assert output["resumed"] == 5100
    assert output["speeds"]["threshold"] > 3.0 * output["speeds"]["constant"]
    assert output["report"] == "threshold, restitution 0.5" and "threshold" in output["table"]
    assert output["models"] == ["newton", "constant", "law", "tc", "soft", "threshold"]
    assert output["predicted"] == "the law of the error does not know it" and "threshold" in output["summary"]
    assert output["refusal"] == "rule: got 'threshold', must be one of constant, law, tc, soft"
    assert output["rules"] == ["constant", "law", "tc", "soft"]
    python(str(tree / "docs" / "generate.py"))
    assert "`threshold`" in (tree / "docs" / "generated" / "rules.md").read_text(encoding="utf-8")


def test_a_rule_works_on_the_command_line(python: Run) -> None:
    box = ("--n", "27", "--packing-fraction", "0.2", "--radius", "1mm", "--rule", "threshold")
    python(
        "-m", "hardlimit", "gas", *box, "--restitution", "0.7", "--max-collisions", "100", "--plot", "gas.png"
    )
    adjustable = (*box[:-1], "adjustable", "--threshold-speed", "1cm/s")
    python("-m", "hardlimit", "gas", *adjustable, "--restitution", "0.7", "--max-collisions", "100")
