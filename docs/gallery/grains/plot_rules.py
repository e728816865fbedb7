r"""
Which rule for hard spheres may I use?
======================================

One cooling gas, five times from the same initial state: Newton's equations (black), and hard spheres under four
rules. *constant* and *law* use the restitution of an isolated contact. *tc* makes collisions elastic that
follow another within :math:`t_c` (Luding & McNamara, Granular Matter 1, 113 (1998)), *soft* gives each contact
its duration and rotation (Müller & Pöschel, Phys. Rev. E 87, 033301 (2013)). Bands are standard errors over the
replicas; dots mark significant differences. Contacts are long on purpose, and the example is small, 150
spheres. :doc:`/results` has a grid of densities, durations and restitutions.
"""

import hardlimit as hl

gas = hl.ParticleSystem.random(
    n=150, packing_fraction=0.3, radius=1e-3, density=2500, rms_speed=1.0
)
law = hl.LinearDashpot(stiffness=3e4, restitution=0.9)
compared = hl.fidelity(gas, law=law, until=3e-3, replicas=6, samples=30)
print(compared)

compared.plot()
