"""Time of one solve, including Python. Goals: two-ball drop below 100 µs, general-solver drop below 5 ms.

python benchmarks/solve_speed.py
"""

from collections.abc import Callable
from timeit import Timer

import hardlimit as hl


def best(call: Callable[[], object]) -> float:
    """Seconds for one call, the best of five runs."""
    timer = Timer(call)
    number, _ = timer.autorange()
    return min(timer.repeat(repeat=5, number=number)) / number


def main() -> None:
    drop = hl.Column.paper(0.7)
    balls = [hl.Ball(0.1, density=840.0), hl.Ball(0.01, density=840.0)]
    soft = hl.Viscoelastic(youngs_modulus=6e9, poisson_ratio=0.45, restitution=0.7, impact_speed=3.0)
    hertz = hl.Column(balls, [1e-4], 0.6, soft)
    cases: dict[str, tuple[Callable[[], object], float]] = {
        "newton, two balls, linear": (lambda: hl.newton(drop).relative_velocity, 100e-6),
        "the same with a new column": (lambda: hl.newton(hl.Column.paper(0.7)).relative_velocity, 100e-6),
        "adiabatic": (lambda: hl.adiabatic(drop).relative_velocity, 100e-6),
        "independent": (lambda: hl.independent(drop).relative_velocity, 100e-6),
        "newton, general solver": (lambda: hl.newton(drop, method="general").relative_velocity, 5e-3),
        "newton, viscoelastic": (lambda: hl.newton(hertz).relative_velocity, 5e-3),
    }
    for name, (call, goal) in cases.items():
        seconds = best(call)
        verdict = "ok" if seconds < goal else "MISSED"
        print(f"{name:30s} {1e6 * seconds:9.1f} µs   goal {1e6 * goal:6.0f} µs   {verdict}")


if __name__ == "__main__":
    main()
