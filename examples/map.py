"""Map the number of contacts, and the error of the event-driven model, over restitution and gap."""

import numpy as np

import hardlimit as hl
from hardlimit import plots

axes = {"restitution": np.linspace(0.4, 1.0, 80), "gap": np.geomspace(1e-6, 1e-2, 80)}
newton = hl.sweep(hl.Column.paper(), **axes)
collisions = hl.sweep(hl.Column.paper(), model="independent", **axes)

plots.save(plots.count_map(newton), "contacts.png")
plots.save(plots.difference_map(newton, collisions), "difference.png")
print(f"up to {int(newton.n_contacts.max())} contacts")
