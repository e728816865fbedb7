"""The systems of a script: contacts of runs of the same kind, in the same units."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from . import answer, corrections, drive, dumps, remarks, stated, surroundings
from .contacts import Case, CheckedContact, Surroundings
from .options import CHOSEN_SPEEDS, Options
from .result import Inferred
from .scripts import Bath, Stage
from .supplied import SCALES
from .units import contact_in_si


@dataclass(frozen=True)
class System:
    """The contacts of all runs of the same kind (see :func:`kinds_of`), in the same units."""

    last: Stage  #: its last run
    supply: drive.Drive | None  #: what determines the speed, in SI units
    options: Options
    gas: Surroundings
    speeds: tuple[float, ...]
    examined: Sequence[tuple[Case, CheckedContact]]
    question: answer.Question
    inferred: tuple[Inferred, ...] = ()  #: what follows from the script, in its units

    @property
    def newest(self) -> list[CheckedContact]:
        """The contacts of the last run of which some are known, in the units of the script."""
        stage = max((row.stage for _, row in self.examined), default=0)
        return [row for _, row in self.examined if row.stage == stage]

    @property
    def rows(self) -> list[CheckedContact]:
        """The contacts in SI units."""
        return [contact_in_si(case, row, self.last.units) for case, row in self.examined]

    @property
    def inferred_in_si(self) -> Iterator[Inferred]:
        """What follows from the script, in SI units."""
        _, length, time = SCALES[self.last.units]
        for number in self.inferred:
            yield number._replace(value=number.value * length / time) if number.what == "speed" else number

    @property
    def at(self) -> str:
        """The chosen speed of the largest numbers; empty if speeds are given, or nothing depends on them."""
        estimated = any(number.what == "speed" for number in self.inferred)
        known = self.speeds or self.options.drive or all(row.speed is None for _, row in self.examined)
        known = known or estimated
        return "" if known else " at 1 m/s"

    def missing(self, states: Sequence[dumps.State]) -> tuple[str, ...]:
        """What is not known, in words."""
        if self.question.never_meet:
            return ()
        return remarks.missing(self.newest, self.gas, self.speeds, self.options.drive)

    def remarks(self, several: bool) -> Iterator[str]:
        """Remarks on the contacts, which name their units if the script has several."""
        plain = self.last.units == "lj"
        speeds = self.speeds or tuple(number.value for number in self.inferred if number.what == "speed")
        for note in remarks.on_contacts(
            self.examined, self.newest, self.options, self.gas, speeds, self.at, plain
        ):
            yield f"In {self.last.units} units: {note}" if several else note

    def corrected(
        self, code: str, several: bool, largest: corrections.LargestStep | None = None
    ) -> Iterator[str]:
        """Corrected lines, which name their units if the script has several.

        ``largest``: the longest time step of a state in which contacts last.
        """
        accepted = self.options.restitution_error
        for line in corrections.lines(code, self.examined, accepted, not self.at, largest):
            yield f"{line}{';' if '#' in line else '  #'} {self.last.units} units" if several else line


#: Units, dimension, shear rate, bath, and other drives in words.
Kind = tuple[str, int, float | None, Bath | None, str]


def kinds_of(stages: Sequence[Stage]) -> list[Kind]:
    """The kind of system of each stage, which decides what it is judged by: that of the last run before ``clear``."""
    last = {stage.system: stage for stage in stages}
    ends = (last[stage.system] for stage in stages)
    return [
        (end.units, end.dimension, end.shear_rate, end.bath, drive.words_of(end, drive.support(end)))
        for end in ends
    ]


def systems_of(
    stages: Sequence[Stage],
    kinds: Sequence[Kind],
    contacts: Sequence[Case],
    options: Options,
    states: Sequence[dumps.State],
) -> Iterator[System]:
    """The systems of a script. A dump is one of the last."""
    for kind in dict.fromkeys(kinds):
        own = [case for case in contacts if kinds[case.stage - 1] == kind]
        runs = [stage for stage, other in zip(stages, kinds, strict=True) if other == kind]
        yield _system(runs, own, options, states if kind == kinds[-1] else ())


def _system(
    runs: Sequence[Stage], contacts: Sequence[Case], options: Options, states: Sequence[dumps.State]
) -> System:
    """The system of some runs."""
    last = runs[-1]
    scales = _, length, time = SCALES[last.units]
    plain = last.units == "lj"
    purpose = options.drive or drive.of_stage(last, *scales)
    measured = options.speeds or any(state.temperature for state in states)
    supply = options.drive if measured else purpose
    drive_option = "" if options.drive is None else options.drive.option
    driven, purpose = (source and source.in_units(*scales) for source in (supply, purpose))
    options = replace(
        options,
        speeds=tuple(v * time / length for v in options.speeds),
        drive=driven,
        load=options.load.in_units(*scales, last.dimension),
    )
    gas, speeds = surroundings.gas(options, states, last.dimension)
    gas = replace(gas, quantity="cooling" if purpose is None else purpose.quantity)
    packing = stated.packing_fraction(last) if gas.packing_fraction is None else None
    if packing is not None:
        gas = replace(gas, packing_fraction=packing.value)
    speed = None if speeds or driven else stated.speed(runs)
    at = speeds if speed is None else (speed.value,)
    chosen = () if plain or at or driven else tuple(v * time / length for v in CHOSEN_SPEEDS)
    examined = surroundings.examined(contacts, gas, at, driven, purpose, chosen)
    support = drive.support(last)
    moving = (kind.radii[1] for kind in last.grains.values() if kind.radii and not kind.frozen)
    largest = max(moving, default=None)
    option = (
        "" if plain else drive.option_of(support, last.gravity or 0.0, largest, last.dimension, length, time)
    )
    heats_spins = purpose is not None and purpose.heats_spins
    question = answer.Question(
        gas.quantity,
        bool(states),
        drive.words_of(last, support),
        option,
        heats_spins=heats_spins,
        drive_option=drive_option,
    )
    return System(
        last=last,
        supply=supply,
        options=options,
        gas=gas,
        speeds=at if speed is not None and speed.decides else speeds,
        examined=examined,
        question=question,
        inferred=tuple(number for number in (packing, speed) if number is not None),
    )
