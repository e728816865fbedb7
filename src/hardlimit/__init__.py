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
No: all 4 ball–ball contacts overlap another contact in time; the event-driven
separation velocity is 3.73 m/s instead of 0.125 m/s.
"""

from importlib import import_module

from . import _core
from .column.comparison import ColumnVerdict, Comparison, compare
from .column.result import Result
from .column.scenario import PAPER_DENSITY, Column
from .column.solvers import adiabatic, independent, newton
from .contact.approximations import restitution_pade, restitution_series, usual_damping
from .contact.balls import FLOOR, Ball
from .contact.compression import CompressionWarning
from .contact.contact import Contact, Law
from .contact.friction import Friction
from .contact.impact import Impact
from .contact.laws import *  # noqa: F403
from .contact.laws import LAWS
from .contact.laws import __all__ as _laws
from .convert import convert
from .sweep import sweep

__version__: str = _core.version

#: Names of the outcome codes, in the order of their numbers.
OUTCOMES: tuple[str, ...] = _core.outcome_names

#: Modules of the names that are imported at first use. A drop needs none of them, and their import takes as long as it.
_LATER = {
    "fitting": ("fit",),
    "fitting.files": ("read_measurements",),
    "fitting.measurements": ("Impacts", "Rebounds"),
    "fitting.result": ("Fit",),
    "saved": ("load",),
    "contact.oblique_impact": ("ObliqueImpact", "oblique_impact"),
    "oblique": ("ObliqueDrop", "oblique_drop"),
    "boxes.checkpoint": ("CheckpointWarning",),
    "boxes.hard_spheres": ("event_driven",),
    "fidelity_study": ("Fidelity", "fidelity"),
    "boxes.lammps.folder": ("lammps_input", "lammps_result"),
    "boxes.newton": ("molecular_dynamics",),
    "boxes.result": ("ContactResult", "ParticleResult"),
    "boxes.resume": ("resume",),
    "boxes.system": ("ParticleSystem",),
    "boxes.thermostats": ("Andersen", "RandomKicks"),
    "boxes.walls": ("MovingWall",),
    "stacks": ("Stack", "stack"),
    "checking.checking": ("check",),
    "checking.reading_back": ("convert_back",),
    "boxes.error_law": ("ErrorLaw", "error_law"),
    "checking.result": ("Verdict",),
}

#: Modules that are imported at first use, by the packages that they belong to.
_MODULES = {"measure": "", "theory": "boxes."}

__all__ = [
    "FLOOR",
    "LAWS",
    "OUTCOMES",
    "PAPER_DENSITY",
    "Ball",
    "Column",
    "ColumnVerdict",
    "Comparison",
    "CompressionWarning",
    "Contact",
    "Friction",
    "Impact",
    "Law",
    "Result",
    "adiabatic",
    "compare",
    "convert",
    "independent",
    "newton",
    "restitution_pade",
    "restitution_series",
    "sweep",
    "usual_damping",
    *(name for names in _LATER.values() for name in names),
    *(name for name in _laws if name != "LAWS"),
]
del _laws


def __getattr__(name: str) -> object:
    if name in _MODULES:
        return import_module(f".{_MODULES[name]}{name}", __name__)
    for module, names in _LATER.items():
        if name in names:
            globals()[name] = attribute = getattr(import_module(f".{module}", __name__), name)
            return attribute
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__, *_MODULES} - {"import_module", "_LATER", "_MODULES"})
