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
    """Records of the registered contact laws."""

def friction_record() -> dict:
    """Parameters, models and limits of friction."""

class Friction:
    """Friction as the user gives it; NaN: not given."""

    def __init__(self, model: int, limit: int, coefficient: float, stiffness_ratio: float, stiffness: float, damping_ratio: float, damping: float) -> None: ...

class Contact:
    """One contact: law, effective mass and radius."""

    @property
    def effective_mass(self) -> float: ...

    @property
    def effective_radius(self) -> float: ...

    def values(self) -> list[float]: ...

    @property
    def coefficients(self) -> tuple[float, float] | None:
        """
        K and C of the force K ξ^p + C ξ^q dξ/dt; None if the force is not of this form.
        """

    @property
    def friction_terms(self) -> tuple:
        """
        μ, k_t and four times its power, γ_t and four times its power, m while the compression grows and while it falls, number of the limit.
        """

    def force(self, compression: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], rate: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> NDArray[numpy.float64]: ...

    def restitution(self, speed: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> NDArray[numpy.float64]: ...

    def duration(self, speed: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> NDArray[numpy.float64]: ...

    def compression(self, speed: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> NDArray[numpy.float64]: ...

    def energy(self, compression: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> NDArray[numpy.float64]: ...

def make_contact(law: str, alternative: int, parameters: Sequence[float], effective_mass: float, effective_radius: float, friction: Friction | None = None) -> Contact: ...

def tangential_restitution(powers: tuple[int, int, bool], coefficients: tuple[float, float], effective_mass: float, tangential_mass: float, terms: tuple[float, float, int, float, int, int, int, int], speed: float, slip: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> NDArray[numpy.float64]:
    """β of a contact at each slip velocity at touch."""

def frictional_impact(powers: tuple[int, int, bool], coefficients: tuple[float, float], effective_mass: float, tangential_mass: float, terms: tuple[float, float, int, float, int, int, int, int], speed: float, slip: float, times: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> dict:
    """
    A contact with this slip velocity at touch: result, intervals of stick and slip, and the motion at the times, which do not decrease.
    """

def inverse_tangential_mass(mass: float, inertia_factor: float, other_mass: float, other_inertia_factor: float) -> float:
    """1/m_t = 1/m_n + R_i²/I_i + R_j²/I_j; masses of walls are infinite."""

def effective(a: float, b: float) -> float:
    """a b/(a + b); also if one of them is infinite."""

def viscoelastic_restitution(x: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> NDArray[numpy.float64]: ...

def viscoelastic_duration(x: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> NDArray[numpy.float64]: ...

series_coefficients: tuple = ...

def linear_restitution(damping_ratio: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> NDArray[numpy.float64]: ...

def linear_duration(damping_ratio: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> NDArray[numpy.float64]: ...

def power_collision(elastic: int, damping: int, attracts: bool, c: float) -> tuple:
    """
    ε, duration, largest compression and force of X'' + X^(elastic/4) + c X^(damping/4) X' = 0, X(0) = 0, X'(0) = 1.
    """

def power_damping(elastic: int, damping: int, attracts: bool, restitution: float) -> float:
    """The damping c for which power_collision gives this ε in (0, 1]."""

def math(name: str, x: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> NDArray[numpy.float64]:
    """The core's elementary functions, for tests."""

def atan2_upper(y: float, x: float) -> float: ...

def model_records() -> list:
    """
    The models of a column, in order of their numbers: name, labels, limits.
    """

class Column:
    """A column of balls in SI units."""

def make_column(floor: bool, gravity: float, mass: Sequence[float], radius: Sequence[float], contacts: Sequence[Contact], gaps: Sequence[float], velocity: Sequence[float]) -> Column: ...

class Solution:
    """Result of a column solver."""

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
        Largest height of each centre after its first bounce [m]; NaN where there is none.
        """

    def final_velocities(self) -> list[float]:
        """Velocities after the last contact that ended [m/s]; NaN at rest."""

    def sample(self, times: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> tuple[NDArray[numpy.float64], NDArray[numpy.float64], NDArray[numpy.float64], NDArray[numpy.float64], NDArray[numpy.float64], NDArray[numpy.float64], NDArray[numpy.float64]]: ...

def newton(column: Column, until: float, general: bool, tolerance: float) -> Solution: ...

class Comparison:
    """Independent collisions compared with Newton's equations."""

    @property
    def answer(self) -> str: ...

    @property
    def ground(self) -> str: ...

    @property
    def overlapping(self) -> int: ...

    @property
    def error(self) -> float: ...

    @property
    def independent(self) -> float: ...

    @property
    def newton(self) -> float: ...

    @property
    def ball(self) -> int: ...

    @property
    def later(self) -> bool: ...

def compare(newton: Solution, independent: Solution, tolerance: float) -> Comparison: ...

def adiabatic(column: Column, until: float) -> Solution: ...

def independent(column: Column, until: float) -> Solution: ...

def fall_time(gap: float, velocity: float, gravity: float) -> float: ...

def impact_speed(gap: float, velocity: float, gravity: float) -> float: ...

def effective_restitution(relative_velocity: float, impact_speed: float) -> float: ...

def planar_contact(contact: Contact, distance: float, normal_speed: float, tangential_speed: float, gravity: float = 0.0) -> dict:
    """
    Isolated contact of two bodies whose centres are at this distance at touch, in the plane of approach: its end, and velocity and displacement of the equivalent collision. For a wall: infinite distance; gravity presses against it.
    """

def planar_path(contact: Contact, distance: float, normal_speed: float, tangential_speed: float, times: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], gravity: float = 0.0) -> NDArray[numpy.float64]:
    """
    Compression, its rate and rotation angle of the line of centres at times since touch [n, 3].
    """

def soft_contacts(own: Contact, own_distance: float, damping_varies: bool, contact: Contact, distance: float, normal_speed: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], tangential_speed: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> NDArray[numpy.float64]:
    """
    Duration, rotation angle, final compression, radial and tangential speed [n, 5] of contacts, as computed by an event-driven run whose polynomials were fitted for the pair `own`.
    """

def turning_contact(contact: Contact, distance: float, arm: float, rotational_ratio: float, normal: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], velocity: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], spin: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> dict:
    """
    Isolated contact with friction of two bodies, the second relative to the first: its end. The normal points from the first to the second. For a wall: infinite distance; arm: the radius.
    """

def turning_path(contact: Contact, distance: float, arm: float, rotational_ratio: float, normal: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], velocity: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], spin: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], times: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> NDArray[numpy.float64]:
    """
    States at times since touch [n, 17], up to the end of the contact: shift, velocity, spin, normal, normal force, tangential force on the second body, whether the surfaces slip.
    """

def step_errors(contact: Contact, speed: float, time_step: float) -> tuple[float, float, float]:
    """
    Largest errors of fixed time steps in an isolated contact: of ε; of the energy balance, relative to the impact energy; of positions after it, relative to impact speed times duration. Infinite if a contact does not end.
    """

def longest_step(contact: Contact, speed: float, error: float) -> float:
    """Longest time step whose `step_errors` are at most `error`."""

def swept_parameters(balls: int) -> list:
    """
    The column parameters that can be swept: name, indices in the row of a point, unit, meaning and range.
    """

def law_place(contact: int, balls: int) -> int:
    """
    Index of a contact's first law parameter in the row of a point, 0 = floor; for contact = balls, the length of the row.
    """

def ball_mass(density: float, radius: float) -> float:
    """Mass of a solid sphere [kg]."""

def run_map(law: str, model: int, alternative: int, density_1: bool, density_2: bool, restitution_at: int, values: Sequence[Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]], strides: Sequence[int], first: int, count: int, threads: int, tolerance: float, out: dict, progress: object | None, instruction_set: str = 'auto') -> list: ...

def run_columns(law: str, model: int, alternative: int, density: Sequence[bool], values: Sequence[Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]], strides: Sequence[int], first: int, count: int, threads: int, tolerance: float, out: dict, progress: object | None) -> None: ...

def has_kernel(law: str, model: int) -> bool:
    """
    Whether two-ball points of this law and model are solved by a vector kernel.
    """

def has_gpu_kernel(law: str, model: int) -> bool:
    """Whether such points can be solved on a GPU."""

def has_exact_solver(law: str) -> bool:
    """
    Whether two balls on a floor have a piecewise closed-form solution under this law.
    """

def instruction_sets() -> list[str]: ...

engine_names: tuple = ('hard_spheres', 'newton_events', 'newton_steps')

rules: tuple = ...

observed_fields: tuple = ...

class Box:
    """
    Edges [m], boundary of each axis (periodic, wall or lees-edwards), gravity [m/s²]; of each moving wall: its number as in logs, offset [m], velocity [m/s], amplitude [m], frequency [Hz], phase, waveform (none, sine, triangle or parabola); of a Lees–Edwards boundary: shear rate [1/s], and displacement of the images beyond the far side at time 0 [m].
    """

    def __init__(self, edges: Sequence[float], boundary: Sequence[str], gravity: Sequence[float] | None = None, moving_walls: Sequence[tuple[int, float, float, float, float, float, str]] = [], shear_rate: float = 0.0, shear_displacement: float = 0.0) -> None: ...

    @property
    def edges(self) -> list[float]: ...

    @property
    def boundary(self) -> tuple: ...

    @property
    def gravity(self) -> list[float]: ...

    def walls(self, time: float = 0.0) -> list[tuple[int, float, float]]:
        """
        For each wall: number as in logs (−1 − 2·axis at 0, −2 − 2·axis at L), position [m], velocity [m/s].
        """

class Engine:
    """A simulation: an engine and its particles."""

    @property
    def kind(self) -> str: ...

    @property
    def n(self) -> int: ...

    @property
    def dimension(self) -> int: ...

    def advance(self, until: float, max_work: int = 18446744073709551615, threads: int = 1) -> None:
        """
        Advances to `until` [s]; pauses after `max_work` collisions, events or steps. Pausing does not change the result.
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
        Time [s], particles and wall at which a run ended early; otherwise None.
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
        Current positions [m] and velocities [m/s] of the unfolded paths, (n, d) each.
        """

    @property
    def rotates(self) -> bool: ...

    def spins(self) -> NDArray[numpy.float64]:
        """
        Current angular velocities [rad/s], (n, 3) also in two dimensions; with friction only.
        """

    def kick(self, velocities: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], heat: float, spins: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)] | None = None) -> None:
        """
        Gives all particles new velocities (n, d) [m/s] and spins (n, 3) [rad/s], unless they are None, now, and counts this kick of a thermostat and its heat [J].
        """

    @property
    def n_kicks(self) -> int: ...

    @property
    def heat(self) -> float: ...

    def observe(self) -> dict: ...

    def sample(self) -> NDArray[numpy.float64]: ...

    def sample_fields(self) -> list: ...

    @property
    def largest_compression(self) -> float: ...

    def take_log(self) -> dict:
        """Columns of the contact log since the last call."""

    def open_contacts(self) -> dict:
        """
        The same for open contacts, whose end is NaN, and for contacts whose cluster has not yet separated.
        """

    def largest_safety_use(self, instants: int) -> float:
        """
        Largest fraction of its safety radius that a body in contact currently uses; at most 1.
        """

    def save(self) -> bytes: ...

    @property
    def memory(self) -> int: ...

def make_engine(kind: str, box: Box, positions: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], velocities: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], radius: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], mass: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], *, spins: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)] | None = None, inertia_factor: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)] | None = None, law: tuple[str, int, Sequence[float], Friction | None] | None = None, rule: str = 'constant', restitution: float = float('nan'), friction: float = 0.0, tangential_restitution: float = -1.0, rule_parameters: Sequence[float] = [], time_step: float = 0.0, log: bool = False) -> Engine: ...

def load_engine(kind: str, saved: bytes, n_kicks: int = 0, heat: float = 0.0) -> Engine: ...

def random_numbers(seed: int, stream: int, n: int, normal: bool) -> NDArray[numpy.float64]:
    """
    Random numbers, standard normal or uniform in [0, 1): the same on every machine.
    """

def grow_packing(box: Box, radius: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)], seed: int, progress: object | None = None) -> object:
    """
    Random positions (n, d) without overlap: small particles are inserted, and move and collide while they grow. progress(fraction of the final radii, collisions) is called at intervals.
    """

def deepest_overlap(box: Box, positions: Annotated[NDArray[numpy.float64], dict(shape=(None, None), order='C', device='cpu', writable=False)], radius: Annotated[NDArray[numpy.float64], dict(shape=(None,), order='C', device='cpu', writable=False)]) -> tuple[int, int, float]:
    """
    The two particles with the deepest overlap relative to the sum of their radii, and their gap [m]; −1, −1 and 0 if none overlap.
    """

class ErrorLaw:
    """The coefficient a, its standard error, and 2k of the rule tc."""

    def __init__(self, coefficient: float, coefficient_error: float, decay: float) -> None: ...

    @property
    def coefficient(self) -> float: ...

    @property
    def coefficient_error(self) -> float: ...

    @property
    def decay(self) -> float: ...

    def error(self, tc_nu: float) -> float: ...

    def error_bar(self, tc_nu: float) -> float: ...

    def largest_tc_nu(self, limit: float) -> float: ...

def error_law(dimension: int, packing_fraction: float, restitution: float, rule: str, energy: float, damping: float, mean_compression: float, mean_duration: float) -> ErrorLaw:
    """The law for a rule, and a contact law with these exponents and means."""

def error_law_inelastic(dimension: int, packing_fraction: float, x: float) -> float:
    """
    a of the linear law at x = 1 − ε², without correlations of the velocities.
    """

def hard_sphere_fluid(dimension: int, packing_fraction: float) -> tuple[float, float, float, float]:
    """χ, D φ χ'/χ, s = −g'(d⁺) d/χ, and D 2^D φ χ."""

error_law_measured: tuple = ((0.05, 0.7, 0.6), (0.02, 0.5, 0.4))

error_law_measured_hertz: tuple = ((0.4, 0.6, 0.8), (0.05, 0.5, 0.6))

error_law_measured_tc_nu: float = 0.3

error_law_nearly_elastic: float = 0.99
