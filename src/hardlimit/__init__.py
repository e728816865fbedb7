"""How far can you trust an event-driven simulation? Collisions and Newton's equations, side by side.

All quantities are in SI units. Equations, figures and appendices without another source are those of Müller & Pöschel,
Phys. Rev. E 83, 041304 (2011), "the paper".

Examples
--------
>>> import hardlimit as hl
>>> drop = hl.Column.paper(restitution=0.7, gap=1e-4)  # two balls above a floor
>>> hl.newton(drop).n_contacts, hl.independent(drop).n_contacts
(4, 1)
>>> print(hl.compare(drop).verdict.sentence)
No: all 4 contacts of the balls happen while another contact lasts; for the
separation velocity event-driven gives 3.73 m/s instead of 0.125 m/s.
"""

from . import _core
from .approximations import restitution_pade, restitution_series, usual_damping
from .bodies import FLOOR, Ball
from .column.comparison import Comparison, Verdict, compare
from .column.result import Result
from .column.scenario import PAPER_DENSITY, Column
from .column.solvers import adiabatic, independent, newton
from .contact import Contact, Law
from .convert import convert, convert_back
from .fitting import fit
from .fitting.files import read_measurements
from .fitting.measurements import Impacts, Rebounds
from .fitting.result import Fit
from .laws import *  # noqa: F403
from .laws import LAWS
from .laws import __all__ as _laws
from .oblique import ObliqueDrop, oblique_drop
from .particles.contact_result import ContactResult
from .particles.event_driven import event_driven
from .particles.fidelity import Fidelity, fidelity
from .particles.lammps.folder import lammps_input, lammps_result
from .particles.molecular_dynamics import molecular_dynamics
from .particles.result import ParticleResult
from .particles.resuming import resume
from .particles.system import ParticleSystem
from .stacks import Stack, stack
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
    "Fit",
    "Impacts",
    "Law",
    "ObliqueDrop",
    "ParticleResult",
    "ParticleSystem",
    "Rebounds",
    "Result",
    "Stack",
    "Verdict",
    "adiabatic",
    "compare",
    "convert",
    "convert_back",
    "event_driven",
    "fidelity",
    "fit",
    "independent",
    "lammps_input",
    "lammps_result",
    "molecular_dynamics",
    "newton",
    "oblique_drop",
    "read_measurements",
    "restitution_pade",
    "restitution_series",
    "resume",
    "stack",
    "sweep",
    "usual_damping",
    *(name for name in _laws if name != "LAWS"),
]
del _laws
