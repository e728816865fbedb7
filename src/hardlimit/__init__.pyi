# Written by tools/stubs.py from __init__.py and the laws' records.

from .column.comparison import Comparison as Comparison
from .column.comparison import Verdict as Verdict
from .column.comparison import compare as compare
from .column.result import Result as Result
from .column.scenario import PAPER_DENSITY as PAPER_DENSITY
from .column.scenario import Column as Column
from .column.solvers import adiabatic as adiabatic
from .column.solvers import independent as independent
from .column.solvers import newton as newton
from .contact.approximations import restitution_pade as restitution_pade
from .contact.approximations import restitution_series as restitution_series
from .contact.approximations import usual_damping as usual_damping
from .contact.balls import FLOOR as FLOOR
from .contact.balls import Ball as Ball
from .contact.compression import CompressionWarning as CompressionWarning
from .contact.contact import Contact as Contact
from .contact.contact import Law as Law
from .contact.laws import LAWS as LAWS
from .contact.laws import LinearDashpot as LinearDashpot
from .contact.laws import Viscoelastic as Viscoelastic
from .contact.laws import Tsuji as Tsuji
from .convert import convert as convert
from .convert import convert_back as convert_back
from .sweep import sweep as sweep
__version__: str
OUTCOMES: tuple[str, ...]
from .fitting import fit as fit
from .fitting.files import read_measurements as read_measurements
from .fitting.measurements import Impacts as Impacts
from .fitting.measurements import Rebounds as Rebounds
from .fitting.result import Fit as Fit
from .oblique import ObliqueDrop as ObliqueDrop
from .oblique import oblique_drop as oblique_drop
from .boxes.hard_spheres import event_driven as event_driven
from .fidelity_study import Fidelity as Fidelity
from .fidelity_study import fidelity as fidelity
from .boxes.lammps.folder import lammps_input as lammps_input
from .boxes.lammps.folder import lammps_result as lammps_result
from .boxes.newton import molecular_dynamics as molecular_dynamics
from .boxes.result import ContactResult as ContactResult
from .boxes.result import ParticleResult as ParticleResult
from .boxes.resume import resume as resume
from .boxes.system import ParticleSystem as ParticleSystem
from .stacks import Stack as Stack
from .stacks import stack as stack
