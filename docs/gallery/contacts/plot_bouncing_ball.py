r"""
A bouncing ball against the hard-sphere limit
=============================================

A ball falls on a floor and bounces. A hard sphere rises to :math:`\varepsilon^{2n} h_0` after the n-th bounce. A soft
one stays on the floor for a time :math:`t_c`, in which gravity acts against its force. MFiX (case DEM02) and LAMMPS
verify their contact forces with this problem. Both curves are exact here: parabolas and damped oscillations with
gravity, joined at touch and where the force ends. The rebound approaches that of the hard sphere as :math:`t_c g/v`,
the change of velocity by gravity during a contact, relative to the impact speed. Later bounces are slower, and a soft
ball departs from the hard one a little more at each.
"""

import matplotlib.pyplot as plt
import numpy as np

import hardlimit as hl
from hardlimit import plots

fall, restitution = 0.05, 0.8  # [m]
ball = hl.Ball(radius=0.1, density=2600)


def drop(stiffness):
    """The ball above a floor of this stiffness [N/m]."""
    law = hl.LinearDashpot(stiffness=stiffness, restitution=restitution)
    return hl.Column([ball], [], ball.radius + fall, law)


def rebounds(result):
    """Heights [m] that the ball reaches between its contacts."""
    end, begin = result.contacts.end.values, result.contacts.begin.values
    flights = [np.linspace(*times, 401) for times in zip(end, begin[1:], strict=False)]
    return [
        float(result.trajectory(times).position.max()) - ball.radius for times in flights
    ]


until, bounces = 0.68, np.arange(1, 4)
limit = fall * restitution ** (2 * bounces)
hard = hl.independent(drop(1e5), until=until)
times = np.linspace(-0.1, until, 1200)
with plots.style():
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.0, 3.6))
    for stiffness, color in ((5e5, "C1"), (5e6, "C0")):
        path = hl.newton(drop(stiffness), until=until).trajectory(times)
        left.plot(
            times,
            path.position[:, 0] - ball.radius,
            color=color,
            label=f"{stiffness / 1e6:g} MN/m",
        )
    left.plot(
        times,
        hard.trajectory(times).position[:, 0] - ball.radius,
        "k--",
        lw=1.0,
        label="hard sphere",
    )
    left.axhline(0.0, color="0.6", lw=0.8)
    left.set(
        xlabel="time after the first touch [s]", ylabel="gap between ball and floor [m]"
    )
    left.legend(loc="upper right")

    stiffnesses = np.geomspace(5e5, 1e9, 25)
    heights = np.array(
        [rebounds(hl.newton(drop(k), until=until))[: len(bounces)] for k in stiffnesses]
    )
    duration = [float(drop(k).contacts[0].duration(1.0)) for k in stiffnesses]
    speed = np.sqrt(2.0 * 9.81 * fall)
    for n, marker in zip(bounces, "osd", strict=True):
        error = np.abs(heights[:, n - 1] / limit[n - 1] - 1.0)
        right.loglog(
            np.array(duration) * 9.81 / speed, error, marker, ms=4, label=f"bounce {n}"
        )
    right.set(xlabel=r"$t_c\,g/v$", ylabel="relative difference of the height")
    right.legend()
plt.show()
