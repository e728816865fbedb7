r"""
When does a ball roll down a slope?
===================================

A solid ball and a hollow one are put on planes of all slopes, :math:`\mu = 0.3`. A ball that rolls accelerates with
:math:`g\sin\theta/(1 + q)`, where :math:`q m R^2` is its moment of inertia: 5/7 of what it would do without friction,
3/5 if it is hollow. This takes the friction :math:`m g\sin\theta\,q/(1 + q)`, which Coulomb's law allows up to
:math:`\tan\theta = \kappa\mu`, :math:`\kappa = 1 + 1/q`. A block slides from :math:`\tan\theta = \mu` on; balls from
7/2 and 5/2 times this. On steeper planes both slide alike, with :math:`g(\sin\theta - \mu\cos\theta)`, and spin up
as fast as friction can turn them. The slope is gravity that is not along the normal of the floor (:doc:`/spins`).
"""

import matplotlib.pyplot as plt
import numpy as np

import hardlimit as hl
from hardlimit import plots

mu, g, radius, until = 0.3, 9.81, 1e-3, 0.2
factors = np.array([2 / 5, 2 / 3])  # solid, hollow
rubbing = hl.Friction(mu, damping_ratio=1.0)
law = hl.LinearDashpot(stiffness=1e3, restitution=0.5, friction=rubbing)
balls = hl.ParticleSystem(
    positions=[[0.01, 0.01, radius], [0.01, 0.03, radius]],
    velocities=np.zeros((2, 3)),
    radius=radius,
    density=2500,
    box=[0.3, 0.04, 0.01],
    boundary=["wall", "periodic", "wall"],
    inertia_factor=factors,
)
slopes = np.radians(np.arange(4, 80, 4))
runs = []
for slope in slopes:
    tilted = balls.replace(gravity=g * np.array([np.sin(slope), 0.0, -np.cos(slope)]))
    run = hl.molecular_dynamics(tilted, law=law, until=until, engine="steps", samples=1)
    runs.append(run.system)
speed = np.array([end.velocities[:, 0] for end in runs])
spin = np.array([end.angular_velocities[:, 1] for end in runs])
acceleration, slip = speed / (g * until), 1.0 - radius * spin / speed

theta = np.radians(np.linspace(0.5, 80.0, 300))
with plots.style():
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.0, 3.8), layout="constrained")
    for k, name in enumerate(("solid ball", "hollow ball")):
        q, points = factors[k], {"ms": 4, "color": f"C{k}", "label": name}
        rolls = np.tan(theta) < (1.0 + 1.0 / q) * mu
        slides = np.sin(theta) - mu * np.cos(theta)
        spins = mu * np.cos(theta) / q
        theory = np.where(rolls, np.sin(theta) / (1.0 + q), slides)
        left.plot(np.degrees(theta), theory, color=f"C{k}")
        left.plot(np.degrees(slopes), acceleration[:, k], "o", **points)
        theory = np.where(rolls, 0.0, 1.0 - spins / slides)
        right.plot(np.degrees(theta), theory, color=f"C{k}")
        right.plot(np.degrees(slopes), slip[:, k], "o", **points)
    left.plot(np.degrees(theta), np.sin(theta), "k:", lw=1.2, label="no friction")
    left.set(xlabel="slope [°]", ylabel="acceleration [g]", ylim=(0, 1))
    right.set(xlabel="slope [°]", ylabel="slip over speed of the centre", ylim=(-0.02, 1))
    left.legend()
plt.show()
