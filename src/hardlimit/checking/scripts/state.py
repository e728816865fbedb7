"""The state of a LAMMPS or LIGGGHTS simulation as its script is read: groups, grains, fixes, time step, stages."""

from __future__ import annotations

import copy
import math
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final, Self

from ...support.formatting import listed
from . import conditions, filling, free_fall, gravity, motion, population, restart, set_command
from .commands import SILENT, UNRESOLVED, USE_LOG, Variables, is_variable, text_of
from .description import (
    WALL,
    ContactSettings,
    Description,
    Direction,
    Grains,
    Motion,
    Note,
    Quote,
    Settings,
    Stage,
)
from .formulas import NUMBER
from .granular_words import unaccelerated
from .gravity import DIRECTIONS
from .groups import MAX_TYPES, Group, Groups
from .population import Batch, Population
from .reader import names
from .statements import Branch, Place, Refusal, Statement, Undefined, refused

#: Default time step of each system of units.
TIME_STEPS: Final = {
    "lj": 0.005,
    "real": 1.0,
    "metal": 0.001,
    "si": 1e-8,
    "cgs": 1e-8,
    "electron": 0.001,
    "micro": 2.0,
    "nano": 4.5e-4,
}
#: q of the moment of inertia q m R² of a sphere and of a disk.
SPHERE, DISK = 0.4, 0.5
#: Grains that ``create_atoms`` makes: radius 0.5, density 1.
CREATED: Final = Batch((0.5, 0.5), (1.0, 1.0))
MAX_FORKS: Final = 3  #: states at a label with which a new one is compared
ZEROS: Final = {"0", "0.0", "0."}
PLACES: Final = {"box", "region", "single", "random", "mesh"}
#: Section of a data file with contacts.
COEFFICIENTS: Final = re.compile(r"^\s*Pair(?:IJ)? Coeffs\b", re.MULTILINE)
#: Commands that are read below, or that affect neither contacts nor grains.
HARMLESS: Final = SILENT | names("""
angle_coeff angle_style atom_modify balance boundary box change_box comm_modify comm_style communicate create_bonds
delete_bonds dihedral_coeff dihedral_style displace_atoms improper_coeff improper_style kspace_modify
label lattice log mass min_modify min_style minimize modify_timing neb neighbor newton package partition
processors replicate rerun reset_atom_ids reset_atoms reset_ids reset_mol_ids reset_timestep shell thermo_log
special_bonds suffix velocity hard_particles soft_particles next jump fix_modify bond_coeff pair_modify pair_write
group2ndx ndx2group quit partitioner_style extract_surface extrude_surface
""")
#: Fixes that only observe, or affect how the program runs.
HARMLESS_FIX_NAMES: Final = """
ave/ print store/ balance enforce2d property/atom vector recenter check/timestep dt/reset halt restart massflow/mesh
mesh/surface mesh/volume particledistribution contacthistory particletemplate/sphere particletemplate/fragments
property/global region/variable limit/property/atom
neigh_history NEIGH_HISTORY momentum nve/noforce diam/max calculate/ contactproperty/ contactcounter/ pair
"""
HARMLESS_FIXES: Final = tuple(HARMLESS_FIX_NAMES.split())
#: Fixes whose effect is not in their own words, or has none.
ELSEWHERE: Final = (*HARMLESS_FIXES, "pour", "deposit", "insert")
#: What the settings of contacts do not depend on.
NO_SETTINGS: Final = names("""
variables folder version code types_seen part ignored invalidates warnings unknown refused stages last granular
changed_since undefined forks system log_name unclear steps_done regions fixes time_step filling wanted
""")
#: Fixes that move grains whatever forces act on them.
PRESCRIBED: Final = ("nve/noforce", "move")
INTEGRATORS: Final = ("nve", "nvt", "npt", "nph", "rigid", "poems", "multisphere", "brownian", "move")
#: Fixes that add forces beside contacts, or break grains, with the words for the report.
FORCES: Final = {
    "viscous": "viscous drag",
    "drag": "drag",
    "damping/cundall": "damping beside contacts",
    "langevin": "a thermostat",
    "nvt": "a thermostat",
    "npt": "a thermostat and a barostat",
    "nph": "a barostat",
    "temp/": "a thermostat",
    "press/": "a barostat",
    "brownian": "Brownian dynamics",
    "couple/cfd": "drag of a fluid",
    "lb/": "drag of a fluid",
    "buoyancy": "buoyancy",
    "lubricat": "lubrication",
    "efield": "an electric field",
    "addforce": "an additional force",
    "spring": "springs",
    "bond": "bonds",
    "rheo": "a fluid",
    "sph": "a fluid",
    "nve/limit": "limited displacements",
    "forcecontrol/region": "forces that control a stress or a velocity",
    "break/particle": "grains that break",
}
UNMOVED: Final = "no fix integrates the motion of the grains, which stand still without one"
CLUMPS: Final = ("rigid", "poems", "multisphere", "particletemplate/multi", "shake", "rattle", "nve/asphere")
CLUMP_STYLES: Final = ("ellipsoid", "line", "tri", "body", "superquadric", "convexhull", "bpm")


@dataclass(frozen=True)
class Fix:
    """A fix that is in force."""

    statement: Statement
    group: str
    style: str
    words: tuple[str, ...]  #: after the style


def integrates(fix: Fix) -> bool:
    """Whether a fix moves grains as the forces on them say."""
    return fix.style.startswith(INTEGRATORS) and not fix.style.startswith(PRESCRIBED)


def still(stage: Stage) -> bool:
    """Whether no force moves a grain in a run."""
    return bool(stage.grains) and all(kind.frozen for kind in stage.grains.values())


@dataclass
class State(Groups):
    """Commands that LAMMPS and LIGGGHTS share; a subclass reads the contacts."""

    variables: Variables
    folder: Path | None = None
    version: str | None = None
    code: str = "lammps"
    types_seen: int = 0  #: largest type in a dump
    part: bool = False  #: whether this is a part of a script, at whose end the settings matter
    wanted: restart.Wanted | None = None  #: the restart file whose contents are asked for

    def __post_init__(self) -> None:
        self.begin()
        self.last: Statement | None = None
        self.granular = False  #: whether there are granular contacts, understood or not
        self.changed_since = True  #: whether settings may differ from those of the last stage
        self.undefined: dict[str, Statement] = {}  #: variables without a value, and where they matter
        self.forks: dict[Place, list[tuple[Statement, State]]] = {}  #: states that go on at a later label
        self.system = 0  #: its number
        self.reset()

    def reset(self) -> None:
        """As the command ``clear``."""
        self.units, self.units_given, self.dimension = "lj", False, 3
        self.forget_groups()
        self.population = Population()
        self.fixes: dict[str, Fix] = {}
        self.targets: dict[str, str] = {}  #: of servos, from ``fix_modify``
        self.time_step: float | None = None
        self.steps_done, self.atom_style = 0, ""
        self.log_name = ""
        self.molecules: dict[str, list[tuple[int, Batch]]] = {}
        self.regions: dict[str, tuple[str, ...]] = {}
        self.excluded: dict[tuple[str, str], None] = {}  #: pairs of types that do not meet
        self.unclear: dict[conditions.Part, None] = {}  #: what depends on a condition that only a run knows
        self.edges: dict[str, float] = {}  #: of the box
        self.filling = filling.Filling()
        self.squeezed: list[Note] = []  #: commands that shrank the box
        self.integrates = False  #: whether a fix has moved grains as forces say
        self.variables.keywords["dt"] = TIME_STEPS[self.units]

    # --- what subclasses provide --------------------------------------------------------------------------------

    def contacts(self) -> Iterator[ContactSettings]:
        """The settings that hold now."""
        raise NotImplementedError

    def own_fix(self, fix: Fix) -> bool:
        """Read a fix; False if it is not one of contacts or insertions of this code."""
        raise NotImplementedError

    # --- reading ------------------------------------------------------------------------------------------------

    def read(self, statements: Iterator[Statement]) -> Description:
        """Read all statements."""
        try:
            for statement in statements:
                self.statement(statement)
        except Undefined as error:  # the file that comes next
            self.missing(error.statement)
        except Refusal:
            if not self.undefined:
                raise
        if self.undefined:
            raise self.without_values()
        for (condition, _), *_ in self.forks.values():
            raise refused(condition, f"have a condition that is known without running; {USE_LOG}")
        self.note_still_grains()
        if (self.part or not self.stages) and self.last is not None and self.changed_since:
            self.stage(self.last.quote, None)
        if not self.granular or not self.stages:
            raise ValueError("script: has no granular contacts")
        self.leave_out_still_ends()
        return self.described()

    def note_still_grains(self) -> None:
        """Warn if no fix has moved the grains of the last run."""
        ran = self.stages and self.stages[-1].system == self.system
        if ran and self.population.batches and not (self.integrates or self.part or self.unknown):
            self.warnings[Note(UNMOVED, None, self.stages[-1].quote)] = None

    def leave_out_still_ends(self) -> None:
        """Leave out runs at the end of a system in which no grain moves, as heat in a bed that rests, after others."""
        for k in range(len(self.stages) - 1, 0, -1):
            last, before = self.stages[k], self.stages[k - 1]
            ends = k + 1 == len(self.stages) or self.stages[k + 1].system != last.system
            if ends and before.system == last.system and still(last) and before.grains:
                del self.stages[k]

    def without_values(self) -> ValueError:
        """The error that names all variables whose values are missing."""
        names = [name for name in self.undefined if name]
        what = f"values for {listed(names)}" if names else "variables that are known"
        return refused(
            next(iter(self.undefined.values())), f"have {what}: give them with --var, or {USE_LOG}"
        )

    def statement(self, statement: Statement) -> None:
        """Read one statement."""
        command = statement.words[0]
        if self.deforms_already(statement):
            return
        self.changed_since = self.changed_since or (command != "run" and command not in HARMLESS)
        own = getattr(self, f"command_{command}", None)
        if own is not None:
            try:
                own(statement)
            except Undefined as error:
                self.missing(error.statement)
        elif command not in HARMLESS:
            self.unknown[statement.quote] = None

    def deforms_already(self, statement: Statement) -> bool:
        """Whether a ``fix deform`` goes on as it is, as in loops of servo controls, which have thousands of runs."""
        active = self.fixes.get((*statement.words, "")[1]) if statement.words[0] == "fix" else None
        return active is not None and active.style == "deform" and active.statement.words == statement.words

    def missing(self, statement: Statement) -> None:
        """Note the variables of a statement that have no value."""
        for name in list(self.variables.missing(statement.text)) or [""]:
            self.undefined.setdefault(name, statement)

    def understood(self, statement: Statement, read: Callable[[], object], contacts: bool = True) -> bool:
        """Whether a statement is understood. If not, it is quoted, or refused if a variable in it is not known.

        ``contacts``: whether the force of contacts depends on it.
        """
        try:
            read()
        except ValueError as error:
            if UNRESOLVED.search(statement.text):
                raise Undefined(statement) from None
            self.refused |= {str(error): None} if contacts else {}
            part = getattr(error, "part", "")
            whole = part == " ".join(statement.text.split())
            self.unknown[replace(statement.quote, part="" if whole else part)] = None
            return False
        return True

    def number(self, statement: Statement, word: str) -> float:
        """A number of a statement, or of a variable ``v_name``."""
        if NUMBER.fullmatch(word):
            return float(word)
        value = self.variables.of(word[2:]) if word.startswith("v_") else None
        if value is None:
            raise self.no_number(statement, "a number", word)
        return value

    def resolve(self, statement: Statement, settings: Settings) -> Settings:
        """Settings whose numbers are all known."""
        for name, setting in settings.items():
            for word in setting.words:
                if is_variable(word):
                    raise self.no_number(statement, f"a number for {name}", word)
        return settings

    def no_number(self, statement: Statement, what: str, word: str) -> ValueError:
        """The error for a word that is no number, or a variable without a known value."""
        return Undefined(statement) if is_variable(word) else refused(statement, f"have {what}, not {word}")

    # --- conditions that only a run knows -----------------------------------------------------------------------

    def command_if(self, statement: Statement) -> None:
        """Read all branches that may run. What all leave alike stays; the rest is not known from then on."""
        if not any(
            command.words[0] not in HARMLESS for branch in statement.branches for command in branch.statements
        ):
            for branch in statement.branches:
                self.fork(statement, branch, self)
                if any(command.words[0] == "velocity" for command in branch.statements):
                    self.filling.velocities_known = False
            return
        ends = [(branch, self.after(branch)) for branch in statement.branches]
        going = [end for branch, end in ends if not branch.ends and not branch.place]
        leading = [end for branch, end in ends if branch.place]
        for branch, end in ends:
            self.fork(statement, branch, end)
        before = self.stages
        vars(self).update(vars((going or leading or [self])[0].copied()))
        for _, end in ends:
            self.ignored |= end.ignored
            self.warnings |= end.warnings
            self.unknown |= end.unknown
            self.refused |= end.refused
            self.undefined |= end.undefined
        self.stages = self.joined(before, [end.stages for _, end in ends])
        self.variables.keywords["dt"] = self.time_step or TIME_STEPS[self.units]
        for end in going[1:]:
            self.compare(statement, end)

    def fork(self, condition: Statement, branch: Branch, end: State) -> None:
        """Keep the state with which a branch goes on at a later label."""
        if branch.place:
            known = self.forks.setdefault(branch.place, [])
            if not any(end.as_well(state) for _, state in known[-MAX_FORKS:]):
                known.append((condition, end.copied()))

    def command_label(self, statement: Statement) -> None:
        """A label to which branches lead that leave out what was read since."""
        if statement.place:
            for condition, end in self.forks.pop(statement.place, ()):
                self.compare(condition, end)

    def after(self, branch: Branch) -> Self:
        """The state after the commands of a branch."""
        keywords, end = dict(self.variables.keywords), self.copied()
        for statement in branch.statements:
            end.statement(statement)
        self.variables.keywords = keywords
        return end

    def copied(self) -> Self:
        """A copy that changes on its own."""
        new = copy.copy(self)
        for name, value in vars(self).items():
            if name == "population":
                batches = {kind: list(each) for kind, each in value.batches.items()}
                new.population = replace(value, batches=batches)
            elif name == "filling":
                new.filling = value.copied()
            elif isinstance(value, list | dict) and name != "forks":
                setattr(new, name, copy.copy(value))
        return new

    def joined(self, before: Sequence[Stage], ends: Sequence[Sequence[Stage]]) -> list[Stage]:
        """The stages before a condition, and those of all its branches."""
        stages = list(before)
        for stage in (stage for end in ends for stage in end[len(before) :]):
            if not any(conditions.settings_of(other) == conditions.settings_of(stage) for other in stages):
                stages.append(stage)
        if stages and any(list(end) != list(before) for end in ends):
            k = max(0, len(before) - 1)
            stages[k:] = [replace(stage, steps=None) for stage in stages[k:]]
        return stages

    def as_well(self, other: State) -> bool:
        """Whether all settings on which contacts depend now or later are those of another state."""
        fixes, others = (
            {name: fix for name, fix in state.fixes.items() if not fix.style.startswith(ELSEWHERE)}
            for state in (self, other)
        )
        values = [
            (value, getattr(other, name)) for name, value in vars(self).items() if name not in NO_SETTINGS
        ]
        values += [(fixes, others), (self.step_now(), other.step_now())]
        return all(a == b or conditions.plain(a) == conditions.plain(b) for a, b in values)

    def compare(self, condition: Statement, other: State) -> None:
        """Note what a branch leaves in another state, and quote its condition."""
        if self.filling != other.filling:
            self.filling.forget()
        forces = [note for note in self.invalidates if note not in other.invalidates]
        differ = list(forces or set(other.invalidates) - set(self.invalidates))
        for note in forces:
            del self.invalidates[note]
        what = [f"{note.what}" for note in differ]
        if not self.as_well(other):
            quote = condition.quote
            parts = list(conditions.differences(self.now(quote, None), other.now(quote, None)))
            self.unclear |= dict.fromkeys(parts)
            what += [str(part[0]) for part in parts] or ["what follows"]
        if what:
            if conditions.CONTACTS in what:
                must = f"have a condition that is known without running; {USE_LOG}"
                self.refused[str(refused(condition, must))] = None
            words = listed(list(dict.fromkeys(what)))
            self.quote_with(condition, f"only a run knows the condition; branches differ in {words}")
            if any(name not in self.variables.known for name in self.variables.missing(condition.text)):
                self.missing(condition)

    def quote_with(self, statement: Statement, reason: str = "") -> None:
        """Quote a statement that is not understood, with the reason."""
        quote = statement.quote
        if not any((other.file, other.line) == (quote.file, quote.line) for other in self.unknown):
            self.unknown[replace(quote, text=f"{quote.text} ({reason})" if reason else quote.text)] = None

    # --- settings of the run ------------------------------------------------------------------------------------

    def command_units(self, statement: Statement) -> None:
        if len(statement.words) != 2 or statement.words[1] not in TIME_STEPS:
            raise refused(statement, f"be units {', '.join(TIME_STEPS)}")
        self.units, self.units_given, self.time_step = statement.words[1], True, None  # also in LAMMPS
        self.variables.keywords["dt"] = TIME_STEPS[self.units]

    def command_dimension(self, statement: Statement) -> None:
        if statement.words[1:] not in (("2",), ("3",)):
            raise refused(statement, "be dimension 2 or 3")
        self.dimension = int(statement.words[1])

    def command_timestep(self, statement: Statement) -> None:
        step = self.number(statement, (*statement.words, "")[1])
        if step <= 0.0:
            raise refused(statement, "have a positive time step")
        self.time_step = self.variables.keywords["dt"] = step
        self.last = statement

    def command_atom_style(self, statement: Statement) -> None:
        words = [word for word in statement.words[1:] if not word.isdecimal()]
        self.atom_style = " ".join(words)
        for word in words:
            if word.startswith(CLUMP_STYLES):
                what = (
                    "bonds between grains"
                    if word.startswith("bpm")
                    else f"grains that are no spheres ({word})"
                )
                self.invalidate(what, statement)

    def command_bond_style(self, statement: Statement) -> None:
        if statement.words[1:2] not in (("none",), ("zero",)):
            self.invalidate("bonds between grains", statement)

    def command_kspace_style(self, statement: Statement) -> None:
        if statement.words[1:2] != ("none",):
            self.invalidate("long-range forces", statement)

    def command_partition(self, statement: Statement) -> None:
        """A command, or a value of a variable, for some partitions only."""
        what = "several partitions run this script at once; it is read as the first one runs it"
        if not any(note.what == what for note in self.warnings):
            self.warnings[Note(what, None, statement.quote)] = None

    def command_log(self, statement: Statement) -> None:
        self.log_name = statement.words[1] if len(statement.words) > 1 else ""

    def command_run_style(self, statement: Statement) -> None:
        if statement.words[1:2] not in (("verlet",), ("verlet/split",)):
            self.unknown[statement.quote] = None

    def command_neigh_modify(self, statement: Statement) -> None:
        """Pairs of types that do not meet: ``exclude type I J`` or ``exclude group A B``."""
        words = statement.words
        for k, word in enumerate(words[:-1]):
            if word == "exclude" and words[k + 1] == "none":
                self.excluded = {}
            elif word == "exclude" and words[k + 1] in ("type", "group"):
                typed = words[k + 1] == "type"
                ends = [
                    Group(frozenset(self.types_of(word)), True) if typed else self.members(word)
                    for word in words[k + 2 : k + 4]
                ]
                if len(ends) == 2 and all(end.whole for end in ends):
                    pairs = [(i, j) for i in self.within(ends[0]) for j in self.within(ends[1])]
                    self.excluded |= dict.fromkeys((str(min(pair)), str(max(pair))) for pair in pairs)

    def command_delete_atoms(self, statement: Statement) -> None:
        """Grains of whole types may be deleted; of others, some may be left."""
        words = statement.words
        group = self.members(words[2]) if words[1:2] == ("group",) and len(words) > 2 else Group(None, False)
        if group.whole:
            self.filling.census.remove(self.within(group))
            for kind in self.within(group):
                self.population.batches.pop(kind, None)
        else:
            self.filling.census.complete = False

    def command_clear(self, statement: Statement) -> None:
        self.note_still_grains()
        self.system += 1
        self.reset()

    def command_reset_timestep(self, statement: Statement) -> None:
        count = (*statement.words, "")[1]
        self.steps_done = int(count) if count.isdecimal() and len(count) < 19 else 0

    def command_run(self, statement: Statement) -> None:
        words = statement.words
        count = words[1] if len(words) > 1 else ""
        steps: int | None = None
        if NUMBER.fullmatch(count) and float(count) < 1e18:
            steps = int(float(count))
            if "upto" in words:
                steps = max(0, steps - self.steps_done)
            self.steps_done += steps
        if steps == 0:
            self.last = statement
            return
        self.stage(statement.quote, steps)

    def command_minimize(self, statement: Statement) -> None:
        self.filling.apart = math.inf  # grains that overlap move apart

    def stage(self, quote: Quote, steps: int | None) -> None:
        """Note what holds now. A run with the same settings as that before continues its stage."""
        self.note_stage(quote, steps)
        self.filling.apart = math.inf

    def note_stage(self, quote: Quote, steps: int | None) -> None:
        """The stage of a run, or a longer one before it."""
        filling.lengthen(self, steps)
        if self.stages and not self.changed_since:
            self.longer(steps, filling.contents(self, self.stages[-1]))
            return
        self.changed_since = False
        new = conditions.without(self.now(quote, steps), self.unclear)
        self.note_adhesion(new.contacts)
        self.note_friction(new.contacts)
        if self.continues(new):
            self.longer(steps, filling.contents(self, self.stages[-1]))
        else:
            self.stages.append(new)

    def now(self, quote: Quote, steps: int | None) -> Stage:
        """What holds now."""
        grains = {str(kind): self.grains(kind) for kind in self.present()}
        pressed, driven, shear_rate, bath = motion.driven(self)
        now = Stage(
            quote=quote,
            time_step=self.step_now(),
            time_step_given=self.time_step is not None,
            steps=steps,
            contacts=tuple(contact for contact in self.contacts() if contact.types not in self.excluded),
            grains=grains,
            gravity=gravity.strength(self),
            numerical_damping=None,
            down=gravity.down(self),
            pressed=pressed,
            pressure=motion.pressure(self),
            uniaxial=motion.uniaxial(self),
            edges=tuple(self.edges.get(axis) for axis in motion.AXES),
            driven=driven,
            shear_rate=shear_rate,
            bath=bath,
            units=self.units,
            units_given=self.units_given,
            dimension=self.dimension,
            system=self.system,
        )
        return replace(now, contents=filling.contents(self, now))

    def grains(self, kind: int) -> Grains:
        """The grains of a type as they are now."""
        disks = self.code == "liggghts" and self.dimension == 2
        frozen, freezes = self.frozen(kind), self.stopped("freeze", kind)
        holding = ("freeze", "setforce", *PRESCRIBED)
        partly = [style for style in holding if not frozen and self.stopped(style, kind, False)]
        grains = self.population.grains(
            kind, str(kind), frozen, not freezes and "freeze" not in partly, disks, bool(partly)
        )
        own = self.inertia_factor(kind)
        if grains.pair is not None:
            first, second = (replace(each, frozen=frozen, inertia_factor=own) for each in grains.pair)
            grains = replace(grains, pair=(first, second))
        return replace(grains, inertia_factor=own)

    def note_adhesion(self, contacts: Sequence[ContactSettings]) -> None:
        """Note the statements that make contacts adhesive or plastic, each with all types that it concerns."""
        for contact in contacts:
            if contact.adhesion:
                same = [
                    n for n in self.invalidates if (n.what, n.quote) == (contact.adhesion, contact.quotes[0])
                ]
                types = {*contact.types, *(name for note in same for name in note.types or ())} - {WALL}
                for note in same:
                    del self.invalidates[note]
                note = Note(contact.adhesion, tuple(sorted(types, key=int)), contact.quotes[0])
                self.invalidates[note] = None

    def note_friction(self, contacts: Sequence[ContactSettings]) -> None:
        """Note what the friction of the contacts really does."""

    def warn(self, what: str, contact: ContactSettings) -> None:
        """Add a note, one for all types that it concerns."""
        same = [note for note in self.warnings if note.what == what]
        types = {*contact.types, *(name for note in same for name in note.types or ())} - {WALL}
        quote = same[0].quote if same else next(iter(contact.quotes), None)
        notes = [note for note in self.warnings if note.what != what]
        new = Note(what, tuple(sorted(types, key=int)), quote)
        at = list(self.warnings).index(same[0]) if same else len(notes)
        self.warnings = dict.fromkeys([*notes[:at], new, *notes[at:]])

    def step_now(self) -> float | None:
        """The time step; None if a fix changes it."""
        if any(fix.style.startswith("dt/reset") for fix in self.fixes.values()):
            return None
        return TIME_STEPS[self.units] if self.time_step is None else self.time_step

    # --- grains -------------------------------------------------------------------------------------------------

    def command_create_box(self, statement: Statement) -> None:
        self.types = max(self.types, min(self.type_of((*statement.words, "")[1]), MAX_TYPES))
        filling.read_box(self, (*statement.words, "", "")[2])
        self.note_edges()

    def note_edges(self) -> None:
        """The edges of the box between its ends."""
        self.edges |= {motion.AXES[k]: high - low for k, (low, high) in self.filling.box.items()}

    def command_change_box(self, statement: Statement) -> None:
        if statement.words[2:3] == ("boundary",) and len(statement.words) == 6:
            self.filling.boundary = statement.words[3:]
            return
        kind, _ = motion.deformation(self, statement.words[2:])
        self.edges, self.filling.box = {}, {}
        if kind == "pressed":
            self.squeezed.append(Note("change_box", None, statement.quote))

    def command_region(self, statement: Statement) -> None:
        if len(statement.words) > 2:
            self.regions[statement.words[1]] = statement.words[2:]
            filling.read_region(self, statement)

    def command_lattice(self, statement: Statement) -> None:
        filling.read_lattice(self, statement)

    def command_boundary(self, statement: Statement) -> None:
        if len(statement.words) == 4:
            self.filling.boundary = statement.words[1:]

    def command_replicate(self, statement: Statement) -> None:
        filling.replicate(self, statement.words[1:])

    def command_velocity(self, statement: Statement) -> None:
        filling.read_velocity(self, statement)

    def command_displace_atoms(self, statement: Statement) -> None:
        self.filling.launches.append(free_fall.UNKNOWN)

    def parts_of(self, region: str) -> dict[str, tuple[str, ...]]:
        """A region, or those of which it is a union or an intersection."""
        parts: dict[str, tuple[str, ...]] = {}
        pending = [region]
        while pending:
            name = pending.pop()
            words = self.regions.get(name, ())
            if name not in parts:
                parts[name] = words
                if words[:1] and words[0] in ("union", "intersect"):
                    pending += words[2:]
        return parts

    def command_create_atoms(self, statement: Statement) -> None:
        words = statement.words
        kind = self.type_of(words[1]) if len(words) > 1 else 0
        if not set(words[2:3]) <= PLACES:
            self.unknown[statement.quote] = None
        template = words[words.index("mol") + 1 : words.index("mol") + 2] if "mol" in words else ()
        if template:
            self.add_molecule(statement, template[0], kind)
        elif 1 <= kind <= MAX_TYPES:
            filling.create_atoms(self, kind, words[2:])
            single = words[2:3] == ("single",)
            self.population.add(
                kind, replace(CREATED, atom=self.population.next_atom()) if single else CREATED
            )
            for k, word in enumerate(words[:-2]):
                if word == "basis" and self.type_of(words[k + 2]):
                    self.population.add(self.type_of(words[k + 2]), CREATED)
        else:
            self.elsewhere(statement)

    def add_molecule(self, statement: Statement, template: str, offset: int) -> None:
        """Grains of a molecule file."""
        self.filling.launches.append(free_fall.UNKNOWN)
        if template not in self.molecules:
            self.elsewhere(statement)
            return
        for kind, batch in self.molecules[template]:
            if 1 <= kind + offset <= MAX_TYPES:
                self.population.add(kind + offset, batch)

    def command_molecule(self, statement: Statement) -> None:
        batches: list[tuple[int, Batch]] = []
        words = statement.words[1:]
        for name in words[1:]:
            text = None if self.folder is None else text_of(self.folder / name)
            if text is None:
                if not batches:
                    self.unknown[statement.quote] = None
                break
            try:
                batches += population.molecule(text)
            except (ValueError, KeyError, IndexError):
                self.unknown[statement.quote] = None
                return
        if batches:
            self.molecules[words[0]] = batches
            if len(batches) > 1:
                self.invalidate("molecules of several grains", statement)

    def elsewhere(self, statement: Statement, reason: str = "") -> None:
        """Grains whose sizes are not in the script."""
        self.population.from_elsewhere()
        self.filling.forget()
        self.quote_with(statement, reason)

    def command_read_data(self, statement: Statement) -> None:
        words = statement.words
        name = (*words, "")[1]
        text = None if self.folder is None else text_of(self.folder / name)
        if text is None:
            why = "cannot be opened" if self.folder else "give the script as a file, to which it is relative"
            self.elsewhere(statement, why)
            return
        more = words[words.index("extra/atom/types") + 1 :][:1] if "extra/atom/types" in words else []
        shift = words[words.index("offset") + 1 :][:1] if "offset" in words else []
        offset = self.type_of(shift[0]) if shift else 0
        types = population.header(text, "atom types") + (self.type_of(more[0]) if more else 0) + offset
        self.types = min(max(self.types, types), MAX_TYPES)
        for name in words[words.index("group") + 1 :][:1] if "group" in words else ():
            self.groups.setdefault(name, Group(None, False))
        if COEFFICIENTS.search(text):
            self.quote_with(statement, "its pair coefficients are not read")
        if population.header(text, "bonds"):
            self.invalidate("bonds between grains", statement)
        try:
            grains = list(population.atoms(text, self.atom_style))
        except (ValueError, IndexError):
            grains = []
        filling.read_data(self, text, grains, offset)
        self.note_edges()
        batches = population.merged(iter(grains))
        if not batches:
            self.elsewhere(statement, "only atom style sphere is read")
        for kind, batch in batches.items():
            if 1 <= kind + offset <= MAX_TYPES:
                self.population.add(kind + offset, batch)

    def command_write_restart(self, statement: Statement) -> None:
        restart.written(self, (*statement.words, "")[1])

    def command_read_restart(self, statement: Statement) -> None:
        """The grains of a restart file are those of the script beside this one that writes it."""
        known = restart.find(self, (*statement.words, "")[1])
        if known is None or (self.units_given and self.units != known[1].units):
            self.command_read_dump(statement)
            return
        writer, file = known
        self.units, self.units_given, self.dimension = file.units, True, file.dimension
        self.variables.keywords["dt"] = self.time_step or TIME_STEPS[self.units]
        self.types, self.groups, self.edges = max(self.types, file.types), file.groups, file.edges
        self.population = file.population
        self.filling = replace(file.filling, regions=self.filling.regions, lattice=self.filling.lattice)
        what = f"the grains of the restart file are taken as {writer} makes them, which writes it"
        self.warnings[Note(what, None, statement.quote)] = None

    def command_read_dump(self, statement: Statement) -> None:
        self.elsewhere(statement, "such files are not read")

    def command_set(self, statement: Statement) -> None:
        set_command.read(self, statement)

    def changed(self, keyword: str, value: float | None) -> Callable[[Batch], Batch]:
        """What a keyword of ``set`` does to grains. In LAMMPS, another diameter leaves the mass as it is."""
        same = None if value is None else (value, value)
        if keyword == "diameter":
            radius = None if value is None else 0.5 * value
            return lambda batch: batch.with_mass_of(3).with_radius(radius)
        if keyword == "density/disc":
            return lambda batch: replace(batch, densities=same, masses=None).with_mass_of(2)
        if keyword == "shape":
            return lambda batch: replace(batch, radii=None)
        if keyword == "mass":
            return lambda batch: replace(batch, densities=None, masses=same)
        return lambda batch: replace(batch, densities=same, masses=None)

    # --- fixes --------------------------------------------------------------------------------------------------

    def command_fix(self, statement: Statement) -> None:
        words = statement.words
        if len(words) < 4:
            self.unknown[statement.quote] = None
            return
        if words[2] not in self.groups and not self.population.elsewhere:
            self.quote_with(statement, f"the group {words[2]} is not defined")
        fix = Fix(statement, words[2], unaccelerated(words[3]), words[4:])
        self.fixes[words[1]] = fix
        self.integrates |= integrates(fix)
        self.targets.pop(words[1], None)
        if not self.own_fix(fix):
            self.other_fix(fix)

    def command_fix_modify(self, statement: Statement) -> None:
        words = statement.words
        if words[2:3] in (("servo/target_val",), ("target_val",)) and len(words) == 4:
            self.targets[words[1]] = words[3]
            self.changed_since = True

    def command_unfix(self, statement: Statement) -> None:
        self.fixes.pop((*statement.words, "")[1], None)

    def other_fix(self, fix: Fix) -> None:
        """A fix beside contacts and insertions."""
        style, group = fix.style, self.members(fix.group)
        types = None if group.types is None else tuple(str(kind) for kind in sorted(group.types))
        known = style.startswith((*HARMLESS_FIXES, *INTEGRATORS, "freeze", "gravity", "lebc"))
        if style.startswith(CLUMPS):
            self.invalidate(f"clumps ({style})", fix.statement, types)
        elif style.startswith("heat"):
            self.ignore(f"heat ({style})", fix.statement, types)
        elif style.startswith(("move", "deform")):
            self.ignore(f"prescribed motion ({style})", fix.statement, types)
        elif style.startswith("langevin") and motion.bath(self, fix) is not None:
            self.ignore(f"a thermostat ({style})", fix.statement, types)
        elif style == "adapt" and ("diameter" in fix.words or "diameter/disc" in fix.words):
            self.elsewhere(fix.statement)
        elif style == "gravity" and fix.words[1:2] not in DIRECTIONS:
            self.unknown[fix.statement.quote] = None
        elif style.startswith("dt/reset"):
            self.ignore("a time step that adapts (dt/reset)", fix.statement)
        elif style == "chem/shrink/core":
            self.ignore(
                "masses that reactions change (chem/shrink/core): those at the start count", fix.statement
            )
        elif style == "scale/diameter" and self.shrinks(fix):
            self.ignore(
                "diameters that a region reduces (scale/diameter): those outside count", fix.statement
            )
        elif style == "remove":
            self.filling.census.complete = False
            self.ignore("grains that are removed (remove)", fix.statement, types)
        elif style == "setforce" and set(fix.words[:3]) <= {*ZEROS, "NULL"}:
            self.ignore("forces set to zero (setforce)", fix.statement, types)
        else:
            what = next((what for start, what in FORCES.items() if style.startswith(start)), "")
            if what:
                self.invalidate(f"{what} ({style})", fix.statement, types)
                if style == "break/particle":
                    self.warnings[
                        Note("numbers are those of grains before they break", types, fix.statement.quote)
                    ] = None
                if style.startswith("damping/"):
                    self.refused[str(refused(fix.statement, f"be without {what}"))] = None
            elif not known:
                self.unknown[fix.statement.quote] = None

    def shrinks(self, fix: Fix) -> bool:
        """Whether ``scale/diameter`` makes no grain larger than it is outside the region."""
        at = fix.words.index("scale") + 1 if "scale" in fix.words[:-1] else len(fix.words) - 1
        scale = self.coefficient(fix.words[at]) if fix.words else None
        return scale is not None and 0.0 < scale <= 1.0

    def invalidate(self, what: str, statement: Statement, types: tuple[str, ...] | None = None) -> None:
        """Note what makes hard spheres wrong."""
        self.invalidates[Note(what, types, statement.quote)] = None

    def ignore(self, what: str, statement: Statement, types: tuple[str, ...] | None = None) -> None:
        """Note what leaves head-on collisions as they are."""
        self.ignored[Note(what, types, statement.quote)] = None

    def frozen(self, kind: int) -> bool:
        """Whether no contact changes the velocity of a grain of a type."""
        groups = [self.members(fix.group) for fix in self.fixes.values() if integrates(fix)]
        unsaid = not self.integrates and not groups
        integrated = unsaid or any(group.types is None or kind in group.types for group in groups)
        return not integrated or self.stopped("freeze", kind) or self.stopped("setforce", kind)

    def integrators_of(self, kind: int) -> list[Fix]:
        """The fixes that move grains of a type."""
        return [
            fix
            for fix in self.fixes.values()
            if fix.style.startswith(INTEGRATORS) and kind in self.within(self.members(fix.group))
        ]

    def inertia_factor(self, kind: int) -> float:
        """q of the moment of inertia q m R² with which the grains of a type spin; infinite if their spins stay."""
        return SPHERE

    def stopped(self, style: str, kind: int, whole: bool = True) -> bool:
        """Whether a fix that holds grains, as ``setforce`` with three zeros, acts on all of a type, or on some."""
        return any(
            fix.style == style
            and (style != "setforce" or (len(fix.words) >= 3 and set(fix.words[:3]) <= ZEROS))
            and (self.members(fix.group).whole or not whole)
            and kind in self.within(self.members(fix.group))
            for fix in self.fixes.values()
        )

    def walls_of(self, group: str) -> list[int]:
        """The types that meet the wall of a group."""
        return list(self.within(self.members(group)))

    def wall_contact(
        self,
        kind: int,
        name: str,
        settings: Settings,
        *,
        quotes: tuple[Quote, ...],
        pushes: tuple[Direction, ...] | None,
        friction: float | None,
        motion: Motion | None,
    ) -> ContactSettings:
        """A contact with a wall."""
        return ContactSettings(
            (str(kind), WALL), name, settings, quotes, pushes=pushes, friction=friction, motion=motion
        )

    def coefficient(self, word: str) -> float | None:
        """A number that need not be known."""
        value = float(word) if NUMBER.fullmatch(word) else None
        return self.variables.of(word[2:]) if word.startswith("v_") else value
