"""Run oblique collisions in LIGGGHTS with the scripts of tests/checking/data/liggghts_friction.toml; write β.

    python tools/verify_liggghts_friction.py tests/data/liggghts_friction.csv

Each script collides thirty grains with a wall, or with others, at random angles of impact, directions and spins.
Requires the program ``liggghts`` in PATH (Debian has it).
"""

import math
import random
import subprocess
import tempfile
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import recorded

SCRIPTS = Path(__file__).parents[1] / "tests/checking/data/liggghts_friction.toml"
VERSION = "3.8.0 (Debian 3.8.0+repack1-9)"
ANGLES = 30
COLUMNS = ["script", "version", "tan_angle", "restitution", "tangential_restitution"]
#: Distance of the surfaces at the start, in impact speeds times steps.
GAP = 2.3
#: Lines after those of the grains.
RUN = """
fix move all nve/sphere
timestep {time_step}
dump end all custom {steps} dump.end id vx vy vz omegax omegay omegaz
dump_modify end format "%d %.15g %.15g %.15g %.15g %.15g %.15g"
thermo 1000000
run {steps}
"""


Bodies = list[tuple[np.ndarray, np.ndarray, np.ndarray]]
Z = np.array([0.0, 0.0, 1.0])
#: Turns z to y: in two dimensions, grains collide along y.
TURN = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])


def bodies(script: dict[str, Any], tangents: list[float], draw: random.Random) -> Bodies:
    """Position, velocity and spin of both bodies of each collision; the first one, at rest, may be a wall."""
    placed: Bodies = []
    speed, gap = script["speed"], GAP * script["speed"] * script["time_step"]
    wall, (a, b) = script["types"][1] == "wall", script["radii"]
    for k, tangent in enumerate(tangents):
        angle, share = draw.uniform(0.0, 2.0 * np.pi), draw.uniform(0.0, 1.0)
        if script["dimension"] == 2:
            angle = math.pi * (angle > math.pi)
        vector = tangent * speed * np.array([np.cos(angle), np.sin(angle), 0.0])
        spin = share * np.array([vector[1], -vector[0], 0.0])  # −spin × z = share · vector
        first = 0.0 if wall or k % 2 else 0.5
        place = np.array([0.01 * (k % 6 - 2.5), 0.01 * (k // 6 - 2.0), 0.0])
        if script["dimension"] == 2:
            place = np.array([place[0], 0.0, place[1]])
        placed.append((place, np.zeros(3), first * spin / a))
        above = place + ((0.0 if wall else a) + b + gap) * Z
        placed.append((above, (1.0 - share) * vector - speed * Z, (1.0 - first) * spin / b))
    return placed


def grains(script: dict[str, Any], placed: Bodies) -> str:
    """The lines that make the bodies, without walls."""
    wall = script["types"][1] == "wall"
    lines: list[str] = []
    flat = script["dimension"] == 2
    for k, vectors in enumerate(placed):
        if wall and k % 2 == 0:
            continue
        number, end = (k // 2 if wall else k) + 1, k % 2
        x, v, w = ((TURN @ vector if flat else vector).tolist() for vector in vectors)
        kind = script["types"][0 if wall else end]
        lines += [
            f"create_atoms {kind} single {x[0]!r} {x[1]!r} {x[2]!r} units box",
            f"set atom {number} diameter {2 * script['radii'][end]!r} density {script['densities'][end]!r}",
            f"set atom {number} vx {v[0]!r} vy {v[1]!r} vz {v[2]!r}",
            f"set atom {number} omegax {w[0]!r} omegay {w[1]!r} omegaz {w[2]!r}",
        ]
    return "\n".join(lines)


def surface_velocities(script: dict[str, Any], rows: np.ndarray) -> np.ndarray:
    """Velocity of the surface of each second body relative to that of the first, from velocities and spins."""
    a, b = script["radii"]
    if script["types"][1] == "wall":
        return rows[:, :3] - b * np.cross(rows[:, 3:], Z)
    first, second = rows[0::2], rows[1::2]
    return second[:, :3] - first[:, :3] - np.cross(a * first[:, 3:] + b * second[:, 3:], Z)


def velocities_after(text: str, steps: int, time_step: float) -> np.ndarray:
    """Velocities and spins of all grains of a script after a run, one row for each."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "floor.stl").write_text(recorded.floor(0.08))
        (folder / "in.script").write_text(text + RUN.format(steps=steps, time_step=time_step))
        command = ["liggghts", "-in", "in.script", "-log", "none"]
        done = subprocess.run(command, cwd=folder, capture_output=True, timeout=600)
        if done.returncode or not (folder / "dump.end").exists():
            raise RuntimeError((done.stdout + done.stderr)[-1500:].decode(errors="replace"))
        dump = (folder / "dump.end").read_text().rpartition("ITEM: ATOMS")[2].splitlines()[1:]
    return np.array(sorted([float(x) for x in line.split()] for line in dump))[:, 1:]


def measured(script: dict[str, Any], tangents: list[float], seed: str) -> tuple[np.ndarray, np.ndarray]:
    """ε and β of each collision."""
    placed = bodies(script, tangents, random.Random(seed))
    before = np.array([[*v, *w] for _, v, w in placed])
    if script["types"][1] == "wall":
        before = before[1::2]
    text = script["text"].replace("{grains}", grains(script, placed))
    after = velocities_after(text, script["steps"], script["time_step"])
    if script["dimension"] == 2:
        after = np.hstack([after[:, :3] @ TURN, after[:, 3:] @ TURN])
    old, new = surface_velocities(script, before), surface_velocities(script, after)
    reversed_share = (old[:, :2] * new[:, :2]).sum(axis=1) / (old[:, :2] ** 2).sum(axis=1)
    return -new[:, 2] / old[:, 2], -reversed_share


def main() -> None:
    arguments = recorded.arguments(__doc__)
    rows = recorded.all_rows_of(arguments.file)
    scripts = tomllib.loads(SCRIPTS.read_text(encoding="utf-8"))["script"]
    for script in scripts:
        name = script["name"]
        if arguments.only not in name:
            continue
        draw = random.Random(name)
        tangents = sorted(float(f"{np.tan(np.radians(draw.uniform(1.0, 85.0))):.6g}") for _ in range(ANGLES))
        restitution, tangential = measured(script, tangents, f"directions of {name}")
        rows[name] = [
            dict(zip(COLUMNS, (name, VERSION, tangent, f"{e:.6f}", f"{beta:.6f}"), strict=True))
            for tangent, e, beta in zip(tangents, restitution, tangential, strict=True)
        ]
        print(name, f"ε {restitution.min():.5f} to {restitution.max():.5f}", flush=True)
    recorded.write(
        arguments.file, COLUMNS, (row for script in scripts for row in rows.get(script["name"], []))
    )


if __name__ == "__main__":
    main()
