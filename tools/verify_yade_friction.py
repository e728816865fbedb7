"""Run the oblique collisions of tests/checking/data/yade_friction.toml in YADE; write β.

    python tools/verify_yade_friction.py tests/data/yade_friction.csv

Requires the program ``yade`` in PATH (Debian has it). Each script runs with 30 angles of impact. The velocity of the
surfaces comes from velocities and spins of both bodies, in random shares; spins along the normal twist the spring.
"""

import math
import random
import subprocess
import tempfile
import tomllib
from pathlib import Path

import recorded

SCRIPTS = Path(__file__).parents[1] / "tests/checking/data/yade_friction.toml"
VERSION = "2023.02a (Debian)"
ANGLES = 30
COLUMNS = ["script", "version", "angle", "tangential_restitution"]
#: Runs a script once for each tuple: velocity of the second body, spins of both.
LOOP = r"""
import os
script = {!r}
for case in {!r}:
    O.reset()
    exec(script.rpartition("O.run(")[0])
    first, second = O.bodies[0], O.bodies[1]
    radii = [getattr(body.shape, "radius", 0.0) for body in (first, second)]
    share = 0.0 if first.state.blockedDOFs else case[3]
    def slip():
        spin = radii[0] * first.state.angVel + radii[1] * second.state.angVel
        g = second.state.vel - first.state.vel - spin.cross(Vector3(0, 0, 1))
        return Vector3(g[0], g[1], 0)
    along = Vector3(case[1], case[2], 0)
    around = Vector3(0, 0, 1).cross(along)
    second.state.vel = case[4] * along - Vector3(0, 0, case[0])
    left = (1 - case[4]) / radii[1] * (1 - share)
    second.state.angVel = -left * around + Vector3(0, 0, case[5] * case[0] / radii[1])
    if share:
        first.state.angVel = -(1 - case[4]) / radii[0] * share * around
    before = slip()
    exec("O.run(" + script.rpartition("O.run(")[2])
    if any(each.isReal and each.phys.normalForce.norm() for each in O.interactions):
        print("RESULT", "touch", flush=True)
    after = slip()
    print("RESULT", repr(-after.dot(before) / before.dot(before)), before.norm() / case[0], flush=True)
os._exit(0)
"""


def measured(script: dict) -> list[tuple[float, float]]:
    """Angle of impact [rad] and β of each collision."""
    draw = random.Random(script["name"])
    angles = sorted(draw.uniform(0.0, 0.5 * math.pi) for _ in range(ANGLES))
    cases = []
    for angle in angles:
        speed, turn = script["speed"] * math.tan(angle), draw.uniform(0.0, 2.0 * math.pi)
        shares = draw.uniform(0.0, 1.0), draw.uniform(0.0, 1.0), draw.uniform(-1.0, 1.0)
        cases.append((script["speed"], speed * math.cos(turn), speed * math.sin(turn), *shares))
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "script.py").write_text(LOOP.format(script["text"], cases))
        done = subprocess.run(
            ["yade", "-n", "-x", "script.py"], cwd=folder, capture_output=True, text=True, timeout=600
        )
    lines = [line.split()[1:] for line in done.stdout.splitlines() if line.startswith("RESULT")]
    assert len(lines) == ANGLES, (script["name"], lines[-3:], done.stderr[-800:])
    for angle, (_, tangent) in zip(angles, lines, strict=True):
        assert math.isclose(float(tangent), math.tan(angle), rel_tol=1e-9), (script["name"], angle, tangent)
    return [(angle, float(line[0])) for angle, line in zip(angles, lines, strict=True)]


def main() -> None:
    arguments = recorded.arguments(__doc__)
    rows = recorded.all_rows_of(arguments.file)
    scripts = tomllib.loads(SCRIPTS.read_text(encoding="utf-8"))["script"]
    for script in scripts:
        if arguments.only in script["name"]:
            results = measured(script)
            rows[script["name"]] = [
                dict(zip(COLUMNS, (script["name"], VERSION, f"{x:.12f}", f"{beta:.6f}"), strict=True))
                for x, beta in results
            ]
            print(script["name"], *(f"{beta:.3f}" for _, beta in results[::6]), flush=True)
    recorded.write(
        arguments.file, COLUMNS, (row for script in scripts for row in rows.get(script["name"], []))
    )


if __name__ == "__main__":
    main()
