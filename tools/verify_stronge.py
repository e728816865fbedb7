"""Write elastic contacts by pooltool's resolver of Stronge's compliant contact: tangential velocities after them.

    python tools/verify_stronge.py tests/data/pooltool_stronge.csv

``pip install pooltool-billiards`` in an environment of its own: it brings a renderer, whose version does not matter
here (0.6.0 asks for one that is not on PyPI: install it with --no-deps, the rest by hand). The columns are inputs and
outputs of its function, in its signs: both velocities are negative before the contact. It takes ρ = ω_t²/ω_n² between
1 and 4. With a restitution below 1 its normal force is not ours: its stiffness is larger by 1/ε² while the bodies part.
"""

import math
from importlib.metadata import version

import numpy as np
import recorded
from pooltool.physics.resolve.stronge_compliant import (
    resolve_collinear_compliant_frictional_inelastic_collision as resolve,
)

COLUMNS = [
    "version",
    "friction",
    "inertia_factor",
    "stiffness_ratio",
    "tangential",
    "normal",
    "tangential_after",
]


def main() -> None:
    arguments = recorded.command_line(__doc__).parse_args()
    r = np.random.default_rng(1)
    rows = []
    for _ in range(200):
        friction, q, speed = (
            r.uniform(0.02, 1.2),
            r.choice([0.4, 0.5, 2 / 3, r.uniform(0.1, 1.0)]),
            r.uniform(0.1, 10.0),
        )
        kappa = 1 + 1 / q
        ratio = r.uniform(1.001, 1.999) ** 2 / kappa
        slip = math.exp(r.uniform(math.log(0.003), math.log(4.0))) * kappa * friction * speed
        after, _ = resolve(-slip, -speed, 1.0, kappa, 1.0, friction, 1.0, 1.0, 1 / ratio)
        numbers = map(float, (friction, q, ratio, -slip, -speed, after))
        rows.append(dict(zip(COLUMNS, (version("pooltool-billiards"), *numbers), strict=True)))
    recorded.write(arguments.file, COLUMNS, rows)


if __name__ == "__main__":
    main()
