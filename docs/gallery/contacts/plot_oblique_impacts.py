r"""
Oblique impacts, measured and computed
======================================

Kharaz, Gorham and Salman, Powder Technology 120, 281 (2001), shot 5 mm spheres of aluminium oxide at a glass anvil
(3.9 m/s, :math:`\varepsilon = 0.98`, :math:`\mu = 0.092`). Shown is the ratio of the tangential velocities of the
centre after and before, :math:`e_t = 1 - (1+\beta)/\kappa`. Nothing is fitted: the ratio of the stiffnesses, 0.859,
follows from the elastic constants of both materials. The rule of a constant :math:`\beta_0`, which event-driven
simulations use, needs a value to be chosen, and misses the minimum near 20°. Below 5° all of them fail.
"""

import matplotlib.pyplot as plt
import numpy as np

import hardlimit as hl
from hardlimit import plots

angles = np.radians(
    [1.84, 3.70, 9.50, 20.01, 30.13, 39.38, 49.69, 60.02, 71.07, 79.23, 85.17]
)
measured = np.array(
    [0.793, 0.745, 0.673, 0.597, 0.688, 0.771, 0.848, 0.901, 0.937, 0.970, 0.979]
)
mu, epsilon, speed, kappa = 0.092, 0.98, 3.9, 3.5
ball = hl.Ball(radius=2.5e-3, density=4000)
normal = {"linear": {"stiffness": 1e7, "restitution": epsilon}}
normal["hertz"] = {
    "youngs_modulus": 1e11,  # has no effect on β of elastic spheres
    "poisson_ratio": 0.24,
    "restitution": epsilon,
    "impact_speed": speed,
}


def ratio(law, angle):
    """e_t at each angle of impact, at the speed of the experiment."""
    contact = law.between(ball)
    beta = [contact.tangential_restitution(a, speed=speed * np.cos(a)) for a in angle]
    return 1.0 - (1.0 + np.array(beta)) / kappa


models = {
    "linear, spring": hl.LinearDashpot(
        **normal["linear"], friction=hl.Friction(mu, 0.859)
    )
}
for name in ("mindlin", "mindlin_force", "mindlin_rescale", "mindlin_rescale_force"):
    friction = hl.Friction(mu, 0.859, model=name)
    models[f"Hertz, {name}"] = hl.Viscoelastic(**normal["hertz"], friction=friction)
for label, law in models.items():
    square = (ratio(law, angles) - measured) ** 2
    rms, above = np.sqrt([square.mean(), square[2:].mean()])
    print(f"{label}: rms {rms:.3f}, above 9° {above:.3f}")

fine = np.radians(np.linspace(0.5, 88.0, 176))
constant = np.minimum(0.3, -1.0 + kappa * mu * (1.0 + epsilon) / np.tan(fine))
with plots.style():
    figure, ax = plt.subplots(figsize=(7.0, 4.4))
    for label, law in models.items():
        ax.plot(np.degrees(fine), ratio(law, fine), label=label)
    ax.plot(
        np.degrees(fine),
        1.0 - (1.0 + constant) / kappa,
        "k--",
        lw=1.2,
        label=r"constant $\beta_0 = 0.3$",
    )
    ax.plot(np.degrees(angles), measured, "ko", ms=5, label="measured")
    ax.set(
        xlabel="angle of impact [°]", ylabel=r"$v_t'/v_t$ of the centre", xlim=(0.0, 90.0)
    )
    ax.legend(fontsize=8)
plt.show()
