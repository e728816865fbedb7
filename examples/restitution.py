"""Compute the damping for a given restitution, and the restitution that the formula in common use gives."""

import hardlimit as hl

ball = hl.Ball(radius=0.01, density=2500)
stiffness = 1e5
print("asked   damping [N s/m]   usual formula [N s/m]   obtained with it")
for requested in (0.9, 0.7, 0.5, 0.3, 0.1):
    contact = hl.LinearDashpot(stiffness=stiffness, restitution=requested).between(ball)
    usual = hl.usual_damping(requested, stiffness, contact.effective_mass)
    obtained = hl.LinearDashpot(stiffness=stiffness, damping=usual).between(ball).restitution()
    print(f"{requested:5.1f} {contact.damping:17.4f} {usual:23.4f} {obtained:18.4f}")
