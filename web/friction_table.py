"""Writes src/gas/friction_table.json: what friction adds to the law of the error of disks with linear springs.

For the page of the gas. The theory is hardlimit/boxes/frictional_error.py, which takes a second for each point of this
table.
"""

import json
from pathlib import Path

from hardlimit import Friction, LinearDashpot
from hardlimit.boxes import error_law, frictional_error
from hardlimit.boxes.frictional_error import Setting

DIMENSION = 2
#: Values of the table: ε, μ (below the first one in proportion), k_t/k_n.
RESTITUTION = [0.4, 0.55, 0.7, 0.8, 0.9, 0.95, 0.98, 1.0]
COEFFICIENT = [error_law.WEAK, 0.1, 0.15, 0.2, 0.3, 0.45, 0.7, 1.0]
RATIO = [0.2, 2 / 7, 0.36, 0.45, 0.6, 0.72, 0.85, 1.02, 1.2]


def row(restitution: float, coefficient: float, ratio: float) -> list[float]:
    """Changes of a by the energy in contacts, of a D 2^D φ χ by their turn, of a D 2^D φ χ/s by pressure; the energy in
    tangential springs; mean T_r/T."""
    law = LinearDashpot(
        stiffness=1.0, restitution=restitution, friction=Friction(coefficient, stiffness_ratio=ratio)
    )
    setting = Setting(DIMENSION, restitution, law.friction, 1.0, 0.5)
    terms = frictional_error.terms(setting, *error_law.LINEAR, error_law.DELAYED)
    smooth = 0.75 - error_law.DELAYED * (1.0 - restitution**2)
    turn = (DIMENSION - 1) * error_law.LINEAR.mean_compression
    pressure = terms.pressure + error_law.LINEAR.mean_compression
    energy = terms.energy - smooth / DIMENSION
    numbers = energy, terms.turn - turn, pressure, terms.spring, terms.temperature_ratio
    return [float(f"{number:.4g}") for number in numbers]


if __name__ == "__main__":
    table = {
        "restitution": RESTITUTION,
        "coefficient": COEFFICIENT,
        "ratio": [round(x, 4) for x in RATIO],
        "third": frictional_error.THIRD[0],
        "bar": frictional_error.BAR,
        "measured": dict(zip(("μ", "ρ", "γ", "ε"), frictional_error.MEASURED.values(), strict=True)),
        "rows": [row(e, mu, k) for e in RESTITUTION for mu in COEFFICIENT for k in RATIO],
    }
    text = json.dumps(table, ensure_ascii=False, separators=(",", ":"))
    Path(__file__).with_name("src").joinpath("gas", "friction_table.json").write_text(
        text + "\n", encoding="utf-8"
    )
