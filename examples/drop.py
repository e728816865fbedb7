"""Solve one drop with instantaneous collisions and under Newton's equations."""

import hardlimit as hl

column = hl.Column.paper(restitution=0.7, gap=1e-4)  # Fig. 2: 10 cm and 1 cm, 0.1 mm apart
newton = hl.newton(column)
collisions = hl.independent(column)

print(newton.contacts.to_dataframe())
for result in (newton, collisions):
    print(f"{result.model:12s} {result.n_contacts} contacts, {result.separation_velocity:.4f} m/s apart")

newton.plot().savefig("forces.png")
