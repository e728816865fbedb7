# Written by tools/stubs.py from __init__.py and the laws' records.

from .approximations import restitution_pade as restitution_pade
from .approximations import restitution_series as restitution_series
from .approximations import usual_damping as usual_damping
from .bodies import FLOOR as FLOOR
from .bodies import Ball as Ball
from .column.comparison import Comparison as Comparison
from .column.comparison import Verdict as Verdict
from .column.comparison import compare as compare
from .column.result import Result as Result
from .column.scenario import PAPER_DENSITY as PAPER_DENSITY
from .column.scenario import Column as Column
from .column.solvers import adiabatic as adiabatic
from .column.solvers import independent as independent
from .column.solvers import newton as newton
from .compression import CompressionWarning as CompressionWarning
from .contact import Contact as Contact
from .contact import Law as Law
from .convert import convert as convert
from .convert import convert_back as convert_back
from .laws import LAWS as LAWS
from .laws import LinearDashpot as LinearDashpot
from .laws import Viscoelastic as Viscoelastic
from .laws import Tsuji as Tsuji
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
from .particles.contact_result import ContactResult as ContactResult
from .particles.event_driven import event_driven as event_driven
from .particles.fidelity import Fidelity as Fidelity
from .particles.fidelity import fidelity as fidelity
from .particles.lammps.folder import lammps_input as lammps_input
from .particles.lammps.folder import lammps_result as lammps_result
from .particles.molecular_dynamics import molecular_dynamics as molecular_dynamics
from .particles.result import ParticleResult as ParticleResult
from .particles.resuming import resume as resume
from .particles.system import ParticleSystem as ParticleSystem
from .stacks import Stack as Stack
from .stacks import stack as stack
