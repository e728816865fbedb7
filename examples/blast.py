"""Film of a blast in elastic disks; the shock follows R ∝ √t.

    python examples/blast.py [N] [FILE.gif]

The disks are at rest except those in a small circle, which fly apart. In two dimensions the radius of the shock grows
as R = β (E t²/ρ)^(1/4), with the energy E, the mass density ρ and a number β of order one (L. I. Sedov, J. Appl. Math.
Mech. 10, 241 (1946)).
A million disks took a minute and a half and 0.5 GB; the time grows as N^1.5.
"""

import sys

import matplotlib.animation
import matplotlib.pyplot as plt
import numpy as np

import hardlimit as hl

n = int(float(sys.argv[1])) if len(sys.argv) > 1 else 20_000
path = sys.argv[2] if len(sys.argv) > 2 else "blast.gif"
speed, reach, bins = (
    1.0,
    0.15,
    400,
)  # m/s; final radius for β = 1 over the edge of the box; pixels along an edge of the picture

system = hl.ParticleSystem.random(
    n, packing_fraction=0.15, radius=1e-4, density=2500.0, rms_speed=0.0, dimension=2
)
edge = system.box[0]
from_centre = system.positions - edge / 2
distance = np.hypot(*from_centre.T)
hot = np.flatnonzero(distance < 0.01 * edge)
velocities = np.zeros_like(system.velocities)
velocities[hot] = speed * from_centre[hot] / distance[hot, np.newaxis]
system = system.replace(velocities=velocities)

window = edge / 2 + 2.0 * reach * edge * np.array([-1.0, 1.0])
sedov = (system.kinetic_energy * edge**2 / system.mass.sum()) ** 0.25  # R/√t for β = 1


def picture(time, state):
    """Number of disks in each pixel, and the radius beyond which nothing moves."""
    moves = np.any(state.velocities != 0.0, axis=1)
    x, y = state.positions.T
    counts, _, _ = np.histogram2d(x, y, bins, [window, window])
    front = np.quantile(np.hypot(x[moves] - edge / 2, y[moves] - edge / 2), 0.99)
    return {"counts": counts.T.astype(np.float32), "front": front}


run = hl.event_driven(
    system, restitution=1.0, until=(reach * edge / sedov) ** 2, samples=60, observe=picture, progress=True
)
series = run.series.isel(time=slice(1, None))
late = series.time > series.time[-1] / 10
slope = np.polyfit(np.log(series.time[late]), np.log(series.front[late]), 1)[0]
beta = float((series.front / (sedov * np.sqrt(series.time)))[-1])
print(
    f"{run.n_collisions} collisions; the shock grows as t^{slope:.2f} (Sedov: 0.5), at the end β = {beta:.2f}"
)

figure, axes = plt.subplots(figsize=(6, 6), layout="constrained")
limits = 1e3 * (window - edge / 2)
image = axes.imshow(series.counts[0], cmap="magma", extent=[*limits, *limits], origin="lower")
image.set_clim(0.0, float(np.quantile(series.counts[-1], 0.999)))
axes.set(xlabel="x [mm]", ylabel="y [mm]")


def show(frame):
    image.set_data(series.counts[frame])
    axes.set_title(f"t = {1e3 * float(series.time[frame]):.0f} ms")


matplotlib.animation.FuncAnimation(figure, show, series.sizes["time"]).save(path, fps=15)
figure.savefig(path.rsplit(".", 1)[0] + ".png")
