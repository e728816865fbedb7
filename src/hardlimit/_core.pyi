from collections.abc import Sequence
from typing import Annotated

import numpy
from numpy.typing import NDArray


version: str = '0.1.0'

outcome_names: tuple = ...

outcome_messages: tuple = ...

def law_records() -> list:
    """What the registered contact laws state about themselves."""

class Contact:
    """One contact: law, effective mass and radius."""

    @property
    def effective_mass(self) -> float: ...

    @property
    def effective_radius(self) -> float: ...

    def values(self) -> list[float]: ...

    def force(self, compression: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], rate: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> NDArray[numpy.float64]: ...

    def restitution(self, speed: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> NDArray[numpy.float64]: ...

    def duration(self, speed: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> NDArray[numpy.float64]: ...

    def energy(self, compression: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> NDArray[numpy.float64]: ...

def make_contact(law: str, alternative: int, parameters: Sequence[float], effective_mass: float, effective_radius: float) -> Contact: ...

def effective(a: float, b: float) -> float:
    """a b/(a + b), also for an infinite partner."""

def viscoelastic_restitution(x: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> NDArray[numpy.float64]: ...

def viscoelastic_duration(x: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> NDArray[numpy.float64]: ...

def viscoelastic_series(x: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], terms: int = 10) -> NDArray[numpy.float64]: ...

series_terms: int = 10

def viscoelastic_pade(x: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], numerator: int, denominator: int) -> NDArray[numpy.float64]: ...

def linear_restitution(damping_ratio: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> NDArray[numpy.float64]: ...

def linear_duration(damping_ratio: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> NDArray[numpy.float64]: ...

def math(name: str, x: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> NDArray[numpy.float64]:
    """The core's own elementary functions, for their tests."""

def atan2_upper(y: float, x: float) -> float: ...

class Column:
    """A column of balls in SI units."""

def make_column(floor: bool, gravity: float, mass: Sequence[float], radius: Sequence[float], contacts: Sequence[Contact], gaps: Sequence[float], velocity: Sequence[float]) -> Column: ...

class Solution:
    """What a solver found."""

    @property
    def n_contacts(self) -> int: ...

    @property
    def t_end(self) -> float: ...

    @property
    def t_floor_end(self) -> float: ...

    @property
    def relative_velocity(self) -> float: ...

    @property
    def separation_velocity(self) -> float: ...

    @property
    def outcome(self) -> int: ...

    @property
    def t_first(self) -> float: ...

    @property
    def t_last(self) -> float: ...

    @property
    def steps(self) -> int: ...

    @property
    def energy_error(self) -> float: ...

    def contacts(self) -> tuple[NDArray[numpy.int32], NDArray[numpy.float64], NDArray[numpy.float64]]: ...

    def rebound_heights(self) -> list[float]:
        """
        Greatest height of each centre after its first bounce [m]; NaN where there is none.
        """

    def final_velocities(self) -> list[float]:
        """Velocities after the last contact that ended [m/s]; NaN at rest."""

    def sample(self, times: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> tuple[NDArray[numpy.float64], NDArray[numpy.float64], NDArray[numpy.float64], NDArray[numpy.float64], NDArray[numpy.float64], NDArray[numpy.float64], NDArray[numpy.float64]]: ...

def newton(column: Column, until: float, general: bool, tolerance: float) -> Solution: ...

def adiabatic(column: Column, until: float) -> Solution: ...

def independent(column: Column, until: float) -> Solution: ...

def fall_time(gap: float, velocity: float, gravity: float) -> float: ...

def impact_speed(gap: float, velocity: float, gravity: float) -> float: ...

def effective_restitution(relative_velocity: float, impact_speed: float) -> float: ...

def swept_parameters(balls: int) -> list:
    """
    The parameters of a column that can be swept: name, places in a point, unit, meaning and range.
    """

def law_place(contact: int, balls: int) -> int:
    """
    Where the law of a contact begins in a point, 0 = floor; of contact = balls, the length of a point.
    """

def ball_mass(density: float, radius: float) -> float:
    """Mass of a solid sphere [kg]."""

def run_map(law: str, model: int, alternative: int, density_1: bool, density_2: bool, restitution_at: int, values: Sequence[Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]], strides: Sequence[int], first: int, count: int, threads: int, tolerance: float, out: dict, progress: object | None, instruction_set: str = 'auto') -> list: ...

def run_columns(law: str, model: int, alternative: int, density: Sequence[bool], values: Sequence[Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]], strides: Sequence[int], first: int, count: int, threads: int, tolerance: float, out: dict, progress: object | None) -> None: ...

def has_kernel(law: str, model: int) -> bool:
    """
    Whether points of two balls go through a vector kernel under this law and model.
    """

def instruction_sets() -> list[str]: ...
