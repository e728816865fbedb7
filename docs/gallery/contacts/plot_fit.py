r"""
Which law did I measure?
========================

A ball of unknown material is dropped three times, and a microphone records eleven impacts of each drop to 0.2 ms.
The durations of two successive flights give :math:`\varepsilon = T'/T` at the speed :math:`gT/2` (Bernstein,
Am. J. Phys. 45, 41 (1977)). The fit selects the law that describes the data, gives an interval for its parameter, and
says whether the data exclude the other laws; the lower panel shows the deviations in standard errors. The data are
computed from viscoelastic spheres with noise, and the fit finds this law. :doc:`/fit` treats measured data, which are
harder.
"""

import numpy as np

import hardlimit as hl

law = hl.Viscoelastic(
    youngs_modulus=1e9, poisson_ratio=0.3, restitution=0.85, impact_speed=1.0
)
contact, noise = law.between(hl.Ball(0.01, density=1000.0)), np.random.default_rng(2)
drops = []
for height in (0.9, 0.5, 0.2):  # m
    speed, times = np.sqrt(2.0 * 9.81 * height), [0.0]
    for _ in range(10):
        speed *= contact.restitution(speed)
        times.append(times[-1] + 2.0 * speed / 9.81)
    drops.append(np.array(times) + noise.normal(0.0, 2e-4, len(times)))

fit = hl.fit(hl.Impacts.of_times(drops, 2e-4))
print(fit.verdict)
print(f"ε at {fit.law.impact_speed:g} m/s: {fit.parameters['restitution']}")

fit.plot()
