"""Drop three viscoelastic balls and compute their energies until 20 ms after the first floor touch."""

import hardlimit as hl

law = hl.Viscoelastic(youngs_modulus=5e8, poisson_ratio=0.45, restitution=0.8, impact_speed=3.0)
balls = [hl.Ball(radius=r, density=1100) for r in (0.05, 0.03, 0.015)]  # bottom first
column = hl.Column(balls=balls, gaps=[1e-3, 5e-4], height=0.5, law=law)

result = hl.newton(column, until=0.02)
trajectory = result.trajectory()
energy = ["kinetic_energy", "potential_energy", "contact_energy", "dissipated_energy"]
total = sum(trajectory[name] for name in energy)
print(f"{result.n_contacts} contacts between balls; velocities at 20 ms: {result.velocities} m/s")
print(f"energy kept to {float((total.max() - total.min()) / total.mean()):.1e}")
