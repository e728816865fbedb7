r"""
Why do I get more restitution than I requested?
===============================================

Most particle codes compute the damping from :math:`\zeta = -\ln\varepsilon/\sqrt{\pi^2 + \ln^2\varepsilon}`. This is
right for a contact that ends when the bodies separate, after a phase in which the dashpot attracts them. If the code
clips this attraction, the contact ends earlier and the restitution is higher: 0.7 becomes 0.718, 0.3 becomes 0.397. The
exact relation, :math:`\varepsilon = \exp[-(\pi - 2\varphi)\tan\varphi]` with :math:`\sin\varphi = \beta/\omega_0`
(Schwager & Pöschel, Granular Matter 9, 465 (2007)), has a solution for every :math:`\varepsilon`; the laws of this
package use it.
"""

import matplotlib.pyplot as plt
import numpy as np

import hardlimit as hl
from hardlimit import plots

ball, stiffness = hl.Ball(radius=0.01, density=2500), 1e5
requested = np.linspace(0.02, 1.0, 99)
usual = [
    hl.LinearDashpot(
        stiffness=stiffness, damping=hl.usual_damping(e, stiffness, ball.mass)
    )
    .between(ball)
    .restitution()
    for e in requested
]
exact = [
    hl.LinearDashpot(stiffness=stiffness, restitution=e).between(ball).restitution()
    for e in requested
]

with plots.style():
    figure, ax = plt.subplots(figsize=(4.6, 4.2))
    ax.plot(requested, usual, label="usual formula, force never attractive")
    ax.plot(requested, exact, color="black", ls=(0, (5, 2)), label="exact damping")
    for e in (0.3, 0.7):
        usual_value = float(np.interp(e, requested, usual))
        ax.plot(e, usual_value, "o", ms=4, color="C0")
        ax.annotate(
            f"{e:g} → {usual_value:.3f}",
            (e, usual_value),
            xytext=(-6, 5),
            textcoords="offset points",
            ha="right",
        )
    ax.set(
        xlabel=r"$\varepsilon$ requested",
        ylabel=r"$\varepsilon$ obtained",
        xlim=(0, 1),
        ylim=(0, 1.02),
    )
    ax.legend(loc="lower right")
plt.show()
