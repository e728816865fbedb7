"""Fits: impacts computed from a law with noise, rebounds of two balls, and a published relation for ice.

The data of the first two are computed, not measured. Those of the last are points of a published fit to measurements.
"""

import driver
import numpy as np

import hardlimit as hl
from hardlimit import plots


def impacts():
    """Impact times of three drops of one ball, as from a microphone; ε decreases with the speed."""
    law = hl.Viscoelastic(youngs_modulus=1e9, poisson_ratio=0.3, restitution=0.85, impact_speed=1.0)
    contact, rng = law.between(hl.Ball(0.01, density=1000.0)), np.random.default_rng(2)
    drops = []
    for height in (0.9, 0.5, 0.2):
        speed, times = float(np.sqrt(2.0 * 9.81 * height)), [0.0]
        for _ in range(10):
            speed *= float(contact.restitution(speed))
            times.append(times[-1] + 2.0 * speed / 9.81)
        drops.append(np.array(times) + rng.normal(0.0, 2e-4, len(times)))
    return hl.fit(hl.Impacts.of_times(drops, 2e-4))


def rebounds():
    """Separation velocities of the paper's two balls over the gap."""
    column, rng = hl.Column.paper(restitution=0.7), np.random.default_rng(4)
    gaps = np.geomspace(1e-4, 3e-3, 14)
    values = [hl.newton(column.replace(gaps=gap)).separation_velocity for gap in gaps]
    noisy = np.array(values) + rng.normal(0.0, 0.03, gaps.size)
    return hl.fit(hl.Rebounds.of_column(column, "separation_velocity", noisy, 0.03, gap=gaps), "linear")


def ice():
    """ε = 0.32 v^(-0.234), v in cm/s: frosted ice spheres, Bridges, Hatzes & Lin, Nature 309, 333 (1984).

    Points of this relation, each with an uncertainty of 0.02 in ε.
    """
    speed = np.geomspace(0.02, 5.0, 30)  # [cm/s]
    return hl.fit(hl.Impacts.of_restitution(1e-2 * speed, 0.32 * speed**-0.234, 0.02))


def draw():
    fits = {"impacts": impacts(), "rebounds": rebounds(), "ice": ice()}
    for fit in fits.values():
        print(fit)
    return {f"fit_{name}.png": plots.fit(fit) for name, fit in fits.items()}


if __name__ == "__main__":
    driver.main(driver.Study(file=__file__, draw=draw, dpi=110), __doc__)
