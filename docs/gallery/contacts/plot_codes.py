"""
What do other codes make of 0.7?
================================

The input of each particle code says 0.7; the plot shows the restitution that results from its force, between two
grains and at a wall. LAMMPS has a keyword that decides whether the force may be attractive at the end of a contact;
YADE halves the mass at a wall. :func:`hardlimit.convert` gives the input with which each code has 0.7
(:doc:`/convert`, which also says which codes were run and which were only compared with their sources).
"""

import matplotlib.pyplot as plt

import hardlimit as hl
from hardlimit import plots

grain = hl.Ball(radius=5e-4, density=2500)
wanted = {"restitution": 0.7, "speed": 1.0, "youngs_modulus": 1e8, "poisson_ratio": 0.3}
models = [  # code, model, law
    ("chrono", "hooke", "linear"),
    ("kratos", "linear", "linear"),
    ("kratos", "hertz", "tsuji"),
    ("lammps", "hooke-restitution", "linear"),
    ("lammps", "hertz-restitution", "tsuji"),
    ("lammps", "hertz-tsuji", "tsuji"),
    ("liggghts", "hertz", "tsuji"),
    ("mercurydpm", "hertz", "tsuji"),
    ("mfix", "lsd", "linear"),
    ("mfix", "hertzian", "tsuji"),
    ("mujoco", "direct", "linear"),
    ("yade", "viscel-tc-en", "linear"),
    ("yade", "viscel-young-en", "linear"),
    ("yade", "hertz-en", "tsuji"),
]
restitutions = {}
for code, model, law in models:
    for attraction in (False, True):
        conversion = hl.convert(
            grain, **wanted, law=law, code=code, model=model, attraction=attraction
        )
        (entry,) = conversion.models
        name = f"{entry.code.title} {model}{', attracts' if entry.attraction else ''}"
        restitutions[name] = [contact.usual_restitution for contact in entry.contacts]

with plots.style(ytick__minor__visible=False):
    figure, ax = plt.subplots(figsize=(7.0, 0.8 + 0.2 * len(restitutions)))
    rows = range(len(restitutions))
    pair, wall = zip(*restitutions.values(), strict=True)
    ax.axvline(0.7, color="black", lw=0.8)
    ax.plot(wall, rows, "s", mfc="none", color="C1", label="at a wall")
    ax.plot(pair, rows, ".", color="C0", label="between two grains")
    ax.set_yticks(rows, restitutions)
    ax.invert_yaxis()
    ax.set(xlabel=r"$\varepsilon$ obtained with 0.7 in the input")
    ax.legend(loc="upper right")
plt.show()
