# Written by tools/stubs.py from the laws' records.

from .contact import Law
from .friction import Friction

__all__ = ["LAWS", "LinearDashpot", "Viscoelastic", "Tsuji"]

LAWS: dict[str, type[Law]]

class LinearDashpot(Law):
    def __init__(
        self,
        *,
        stiffness: float,
        restitution: float | None = None,
        damping: float | None = None,
        friction: Friction | None = None,
    ) -> None: ...
    stiffness: float
    restitution: float
    damping: float

class Viscoelastic(Law):
    def __init__(
        self,
        *,
        youngs_modulus: float,
        poisson_ratio: float,
        dissipative_time: float | None = None,
        restitution: float | None = None,
        impact_speed: float | None = None,
        friction: Friction | None = None,
    ) -> None: ...
    youngs_modulus: float
    poisson_ratio: float
    dissipative_time: float
    restitution: float
    impact_speed: float

class Tsuji(Law):
    def __init__(
        self,
        *,
        elastic_prefactor: float | None = None,
        restitution: float | None = None,
        damping_coefficient: float | None = None,
        youngs_modulus: float | None = None,
        poisson_ratio: float | None = None,
        friction: Friction | None = None,
    ) -> None: ...
    elastic_prefactor: float
    restitution: float
    damping_coefficient: float
    youngs_modulus: float
    poisson_ratio: float
