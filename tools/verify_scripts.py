"""Run the collisions of tests/checking/data/two_grains.toml in LIGGGHTS and YADE; write ε and the steps of a contact.

    python tools/verify_scripts.py tests/data/script_restitution.csv

Requires the programs ``liggghts`` and ``yade`` in PATH (Debian has both). The rows of a missing code stay.
"""

import re
import shutil
import tempfile
import tomllib
from pathlib import Path

import recorded
from verify_codes import Measured, results

SCRIPTS = Path(__file__).parents[1] / "tests/checking/data/two_grains.toml"
VERSIONS = {"liggghts": "3.8.0 (Debian 3.8.0+repack1-9)", "yade": "2023.02a (Debian)"}
#: Lines before the last run, which print the relative velocity at each step.
LIGGGHTS = """
variable separation equal {}
thermo_style custom step v_separation
thermo_modify format 2 "RESULT %.15g"
thermo 1
"""
#: Lines instead of the last run.
YADE = r"""
for _ in range(\1):
    print("RESULT", repr(float(O.bodies[1].state.vel[2] - O.bodies[0].state.vel[2])))
    O.step()
print("RESULT", repr(float(O.bodies[1].state.vel[2] - O.bodies[0].state.vel[2])))
"""


def measured(code: str, text: str, wall: bool, speed: float) -> Measured:
    """ε and the duration of the contact in the real code."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "floor.stl").write_text(recorded.floor(2.0))
        if code == "liggghts":
            speed /= 0.01 if "units cgs" in text else 1.0
            before, run, steps = text.rpartition("run ")
            lines = LIGGGHTS.format("vz[1]" if wall else "vz[2]-vz[1]")
            (folder / "in.script").write_text(f"{before}{lines}{run}{steps}")
            speeds = results(["liggghts", "-in", "in.script", "-log", "none"], folder)
        else:
            (folder / "script.py").write_text(re.sub(r"O\.run\((\d+), True\)", YADE, text))
            speeds = results(["yade", "-n", "-x", "script.py"], folder)
        return Measured.of([v / speed for v in speeds], 1.0)


def main() -> None:
    arguments = recorded.arguments(__doc__)
    rows = recorded.rows_of(arguments.file)
    scripts = tomllib.loads(SCRIPTS.read_text(encoding="utf-8"))["script"]
    for script in scripts:
        name = script["name"]
        code = name.split()[0]
        if arguments.only in name and shutil.which(code):
            outcome = measured(code, script["text"], script["types"][1] == "wall", script["speed"])
            rows[name] = {
                "script": name,
                "version": VERSIONS[code],
                "restitution": f"{outcome.restitution:.6f}",
                "steps": round(outcome.duration),
            }
            print(name, f"{outcome.restitution:.6f}", round(outcome.duration), flush=True)
    known = (rows[script["name"]] for script in scripts if script["name"] in rows)
    recorded.write(arguments.file, ["script", "version", "restitution", "steps"], known)


if __name__ == "__main__":
    main()
