r"""
Is the series for viscoelastic spheres accurate?
================================================

The restitution of viscoelastic spheres depends on one number,
:math:`x = \frac32 A (\rho/m_\mathrm{eff})^{2/5} v^{1/5}`. There are a power series in :math:`\sqrt x` (Eq. B3; Schwager
& Pöschel, Phys. Rev. E 78, 051304 (2008)) and Padé approximants of it (Müller & Pöschel, Phys. Rev. E 84, 021302
(2011)). The plot compares both with the solution of the collision. The series is excellent for weak damping and
useless beyond :math:`x \approx 0.6`, where more terms make it worse; the error of the Padé approximant [3/6] is below
7e-4 everywhere.
"""

import matplotlib.pyplot as plt
import numpy as np

import hardlimit as hl
from hardlimit import plots

contact = hl.Viscoelastic(
    youngs_modulus=1e9, poisson_ratio=0.3, dissipative_time=1e-4
).between(hl.Ball(0.01, density=1000))
x = np.geomspace(0.02, 20.0, 300)
speed = (x / (1.5 * contact.dissipative_time)) ** 5 * (
    contact.effective_mass / contact.elastic_prefactor
) ** 2
exact = contact.restitution(speed)

with plots.style():
    figure, (upper, lower) = plt.subplots(2, 1, figsize=(7.0, 4.8), sharex=True)
    upper.semilogx(x, exact, color="black", lw=2.0, label="exact")
    published = {
        "series, 5 terms": hl.restitution_series(x, terms=5),
        "series, 10 terms": hl.restitution_series(x),
        "Padé [1/4]": hl.restitution_pade(x, 1, 4),
        "Padé [3/6]": hl.restitution_pade(x, 3, 6),
    }
    for (name, values), line in zip(
        published.items(), ("-", "-", (0, (4, 2)), (0, (4, 2))), strict=True
    ):
        upper.plot(x, values, ls=line, label=name)
        lower.loglog(x, abs(values - exact), ls=line)
    upper.set(ylabel=r"$\varepsilon$", ylim=(0, 1.02), xlim=(x[0], x[-1]))
    upper.legend()
    lower.set(xlabel="$x$", ylabel="error", ylim=(1e-9, 1.0))
    figure.align_ylabels()
plt.show()
