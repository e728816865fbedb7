r"""
How fast does a granular gas cool?
==================================

A thousand spheres in a periodic box lose a fifth of the energy of approach in every collision
(:math:`\varepsilon = 0.9`). Haff's law (J. Fluid Mech. 134, 401 (1983)),

.. math:: T(t) = \frac{T(0)}{\left[1 + (1-\varepsilon^2)\,\nu(0)\,t/6\right]^2},

describes the temperature with no free parameter if :math:`\nu(0)` is Enskog's collision rate. Collision rate
and pressure (Carnahan & Starling, with Jenkins & Richman's factor for :math:`\varepsilon`) follow from the
measured temperature. The law holds while the gas is homogeneous. In a larger, denser or more dissipative gas
clusters form earlier.
"""

import hardlimit as hl

gas = hl.ParticleSystem.random(
    n=1000, packing_fraction=0.1, radius=1e-3, density=2500, rms_speed=1.0
)
gas = hl.event_driven(
    gas, restitution=1.0, max_collisions=10_000, samples=1
).system  # an equilibrium to begin with
run = hl.event_driven(gas, restitution=0.9, until=0.5, samples=40)
print(f"{2 * run.n_pairs / gas.n:.0f} collisions of each sphere")

run.plot()
