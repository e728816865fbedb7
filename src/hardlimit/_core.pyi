from collections.abc import Sequence
from typing import Annotated

import numpy
from numpy.typing import NDArray


version: str = '0.1.0'

def compiler() -> str: ...

outcome_names: tuple = ...

outcome_messages: tuple = ...

deepest_compression: float = 0.5

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

    def compression(self, speed: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> NDArray[numpy.float64]: ...

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

def power_collision(elastic: int, damping: int, attracts: bool, c: float) -> tuple:
    """
    ε, duration, greatest compression and force of X'' + X^(elastic/4) + c X^(damping/4) X' = 0 from speed 1.
    """

def power_damping(elastic: int, damping: int, attracts: bool, restitution: float) -> float:
    """The c of power_collision with this ε in (0, 1]."""

def math(name: str, x: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> NDArray[numpy.float64]:
    """The core's own elementary functions, for their tests."""

def atan2_upper(y: float, x: float) -> float: ...

def model_records() -> list:
    """
    The models of a column in the order of their numbers: name, labels, limits.
    """

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

    @property
    def too_deep(self) -> int: ...

    def largest_compression(self) -> float: ...

    def presses_by(self, part: float) -> bool: ...

    def contacts(self) -> tuple[NDArray[numpy.int32], NDArray[numpy.float64], NDArray[numpy.float64]]: ...

    def rebound_heights(self) -> list[float]:
        """
        Greatest height of each centre after its first bounce [m]; NaN where there is none.
        """

    def final_velocities(self) -> list[float]:
        """Velocities after the last contact that ended [m/s]; NaN at rest."""

    def parting(self, missing: Sequence[int]) -> tuple[NDArray[numpy.float64], NDArray[numpy.float64]]:
        """
        Velocities at the end of the sequence [m/s], in the frame that has fallen freely since time 0, and ends of the last contact of each ball [s]. missing: contacts still to come of each upper pair.
        """

    def sample(self, times: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> tuple[NDArray[numpy.float64], NDArray[numpy.float64], NDArray[numpy.float64], NDArray[numpy.float64], NDArray[numpy.float64], NDArray[numpy.float64], NDArray[numpy.float64]]: ...

def newton(column: Column, until: float, general: bool, tolerance: float) -> Solution: ...

def adiabatic(column: Column, until: float) -> Solution: ...

def independent(column: Column, until: float) -> Solution: ...

def fall_time(gap: float, velocity: float, gravity: float) -> float: ...

def impact_speed(gap: float, velocity: float, gravity: float) -> float: ...

def effective_restitution(relative_velocity: float, impact_speed: float) -> float: ...

def planar_contact(contact: Contact, distance: float, normal_speed: float, tangential_speed: float, gravity: float = 0.0) -> dict:
    """
    The isolated contact of two bodies that touch at this distance of their centres, in the plane of approach: its end, and velocity and shift of the equivalent collision. A wall: infinite distance, gravity pressing against it.
    """

def planar_path(contact: Contact, distance: float, normal_speed: float, tangential_speed: float, times: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], gravity: float = 0.0) -> NDArray[numpy.float64]:
    """
    Compression, its rate and the turn of the line of centres at times since touch [n, 3].
    """

def soft_contacts(own: Contact, own_distance: float, damping_varies: bool, contact: Contact, distance: float, normal_speed: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], tangential_speed: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> NDArray[numpy.float64]:
    """
    Duration, turn, compression left, radial and tangential speed [n, 5] of contacts as an event-driven run computes them, whose polynomials are made for the pair `own`.
    """

def step_errors(contact: Contact, speed: float, time_step: float) -> tuple[float, float, float]:
    """
    The largest errors that steps make in an isolated contact: of ε; of the energy balance, relative to the energy of the impact; of positions after it, relative to the way at the speed of impact in its duration. Infinite where a contact does not end.
    """

def longest_step(contact: Contact, speed: float, error: float) -> float:
    """The longest time step whose `step_errors` are at most `error`."""

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

def has_gpu_kernel(law: str, model: int) -> bool:
    """Whether such points can be computed on a GPU."""

def has_exact_solver(law: str) -> bool:
    """
    Whether the motion of two balls on a floor under this law has a piecewise closed form.
    """

def instruction_sets() -> list[str]: ...

engine_names: tuple = ('hard_spheres', 'newton_events', 'newton_steps')

rules: tuple = ...

class Box:
    """Edges [m], what bounds each axis (periodic or wall), gravity [m/s²]."""

    def __init__(self, edges: Sequence[float], boundary: Sequence[str], gravity: Sequence[float] | None = None) -> None: ...

    @property
    def edges(self) -> list[float]: ...

    @property
    def boundary(self) -> tuple: ...

    @property
    def gravity(self) -> list[float]: ...

    def walls(self, time: float = 0.0) -> list[tuple[int, float, float]]:
        """
        Of each wall its number, as in logs (−1 − 2·axis at 0, −2 − 2·axis at L), position [m], velocity [m/s].
        """

class Engine:
    """An engine with a box of particles in it."""

    @property
    def kind(self) -> str: ...

    @property
    def n(self) -> int: ...

    @property
    def dimension(self) -> int: ...

    def advance(self, until: float, max_work: int = 18446744073709551615, threads: int = 1) -> None:
        """
        To `until` [s]; pauses after so many collisions, events or steps. What was paused goes on with the same bits.
        """

    @property
    def paused(self) -> bool: ...

    @property
    def time(self) -> float: ...

    @property
    def outcome(self) -> str: ...

    @property
    def early_end(self) -> tuple[float, list[int], int | None] | None:
        """
        Time [s], particles and wall where the run ended before its time; None of others.
        """

    @property
    def work(self) -> int: ...

    @property
    def n_contacts(self) -> int: ...

    @property
    def n_logged(self) -> int: ...

    def statistics(self) -> dict: ...

    def state(self) -> tuple:
        """
        Positions [m], along continuous paths, and velocities [m/s] now, (n, d) each.
        """

    def observe(self) -> dict: ...

    @property
    def largest_compression(self) -> float: ...

    def take_log(self) -> dict:
        """Columns of the log since the last call."""

    def open_contacts(self) -> dict:
        """
        The same of contacts that last, whose end is NaN, and of those whose cluster still holds together.
        """

    def safety_used(self, instants: int) -> float:
        """
        The largest share that a body in contact uses, now, of the space that others leave it: at most 1.
        """

    def save(self) -> bytes: ...

    @property
    def memory(self) -> int: ...

def make_engine(kind: str, box: Box, positions: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], velocities: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], radius: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], mass: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], *, law: tuple[str, int, Sequence[float]] | None = None, rule: str = 'constant', restitution: float = float('nan'), rule_parameters: Sequence[float] = [], time_step: float = 0.0, log: bool = False) -> Engine: ...

def load_engine(kind: str, saved: bytes) -> Engine: ...

def grow_packing(box: Box, radius: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], seed: int, progress: object | None = None) -> object:
    """
    Random positions (n, d) of particles that do not overlap: small ones are inserted, which move and collide while they grow. progress(share of the final radii, collisions) is called now and then.
    """

def deepest_overlap(box: Box, positions: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], radius: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> tuple[int, int, float]:
    """
    Two particles and their gap [m], the deepest relative to the sum of the radii; −1, −1 and 0 where none overlap.
    """
