"""How far can you trust an event-driven simulation? Collisions and Newton's equations, side by side."""

from . import _core
from .approximations import restitution_pade, restitution_series, usual_damping
from .bodies import FLOOR, Ball
from .column.comparison import Comparison, Verdict, compare
from .column.result import Result
from .column.scenario import PAPER_DENSITY, Column
from .column.solvers import adiabatic, independent, newton
from .contact import Contact, Law
from .convert import convert, convert_back
from .laws import *  # noqa: F403
from .laws import LAWS
from .laws import __all__ as _laws
from .particles.contact_result import ContactResult
from .particles.event_driven import event_driven
from .particles.fidelity import Fidelity, fidelity
from .particles.lammps.folder import lammps_input, lammps_result
from .particles.molecular_dynamics import molecular_dynamics
from .particles.result import ParticleResult
from .particles.resuming import resume
from .particles.system import ParticleSystem
from .sweep import sweep

__version__: str = _core.version

#: Names of the outcome codes, in the order of their numbers.
OUTCOMES: tuple[str, ...] = _core.outcome_names

__all__ = [
    "FLOOR",
    "LAWS",
    "OUTCOMES",
    "PAPER_DENSITY",
    "Ball",
    "Column",
    "Comparison",
    "Contact",
    "ContactResult",
    "Fidelity",
    "Law",
    "ParticleResult",
    "ParticleSystem",
    "Result",
    "Verdict",
    "adiabatic",
    "compare",
    "convert",
    "convert_back",
    "event_driven",
    "fidelity",
    "independent",
    "lammps_input",
    "lammps_result",
    "molecular_dynamics",
    "newton",
    "restitution_pade",
    "restitution_series",
    "resume",
    "sweep",
    "usual_damping",
    *(name for name in _laws if name != "LAWS"),
]
del _laws
