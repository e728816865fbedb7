"""Bounces of a ball on a shaken floor, and the profile of a shaken box by both models."""

import math

import driver
import numpy as np
from matplotlib.figure import Figure

import hardlimit as hl

G, FREQUENCY = 9.81, 30.0
OMEGA = 2.0 * math.pi * FREQUENCY


def phases(gamma: float, restitution: float) -> np.ndarray:
    """Phases of the last bounces of one ball, in periods."""
    wall = hl.MovingWall(gamma * G / OMEGA**2, FREQUENCY)
    omega_v = math.pi * (1.0 - restitution) / (1.0 + restitution)
    start = 0.5 if gamma < omega_v else math.acos(omega_v / gamma)
    wall = hl.MovingWall(wall.amplitude, FREQUENCY, phase=start)
    ball = hl.ParticleSystem(
        [[0.5, 0.01 + wall.displacement()]],
        [[0.0, 0.501 * G / FREQUENCY]],
        0.01,
        mass=0.01,
        box=1.0,
        boundary="wall",
        gravity=G,
        walls={"y-": wall},
    )
    run = hl.event_driven(ball, restitution=restitution, until=100.0, max_collisions=600, log=True)
    return (run.collisions.time.values[-60:] * FREQUENCY + start / (2.0 * math.pi)) % 1.0


def profile(soft: bool) -> tuple[np.ndarray, np.ndarray]:
    """Packing fraction over the height [m] of a shaken box, mean of the second half of a run."""
    radius = 1e-3
    box = hl.ParticleSystem.random(
        500,
        0.04,
        radius,
        2500.0,
        0.3,
        boundary=["periodic", "periodic", "wall"],
        gravity=G,
        walls={"z-": hl.MovingWall(1e-3, 50.0)},
        seed=1,
    )
    bins = np.linspace(0.0, 0.04, 41)
    seen: list[np.ndarray] = []

    def observe(time: float, now: hl.ParticleSystem) -> dict[str, float]:
        if time > 1.0:
            seen.append(np.histogram(now.positions[:, 2], bins)[0])
        return {}

    law = hl.LinearDashpot(stiffness=3e4, restitution=0.9)
    if soft:
        hl.molecular_dynamics(box, law=law, until=2.0, engine="events", samples=1600, observe=observe)
    else:
        hl.event_driven(
            box, restitution=0.9, rule="tc", contact_duration=5e-6, until=2.0, samples=1600, observe=observe
        )
    volume = box.box[0] * box.box[1] * (bins[1] - bins[0])
    solid = 4.0 / 3.0 * math.pi * radius**3
    return 0.5 * (bins[1:] + bins[:-1]), np.mean(seen, axis=0) * solid / volume


def draw() -> dict[str, Figure]:
    figure = Figure(figsize=(10.0, 4.2), layout="constrained")
    left, right = figure.subplots(1, 2)
    e = 0.6
    lower = math.pi * (1.0 - e) / (1.0 + e)
    upper = math.hypot(lower, 2.0 * (1.0 + e * e) / (1.0 + e) ** 2)
    for gamma in np.linspace(1.02 * lower, 1.62, 300):
        at = phases(gamma, e)
        left.plot(np.full(len(at), gamma), at, ",", color="tab:blue")
    left.axvline(upper, color="tab:red", lw=1.0)
    left.text(upper, 0.6, " period doubles", color="tab:red", transform=left.get_xaxis_transform())
    left.set(xlabel="Γ = A ω²/g", ylabel="phase of the bounces [periods]", title=f"One ball, ε = {e}")
    for soft, style, name in ((False, "o", "hard spheres, rule tc"), (True, "-", "Newton's equations")):
        height, fraction = profile(soft)
        right.plot(1e3 * height, fraction, style, ms=4, label=name)
    right.set(xlabel="height [mm]", ylabel="packing fraction", title="500 spheres, 1 mm at 50 Hz, ε = 0.9")
    right.legend()
    return {"shake.png": figure}


if __name__ == "__main__":
    driver.main(driver.Study(file=__file__, draw=draw, dpi=110), __doc__)
