"""The models of a column, each described once: name, labels, what it applies to, its limits, its solver.

Python, the command line, sweeps, plots and the page read this table.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Final, Protocol

from . import _core


class Scenario(Protocol):
    """What decides whether a model applies to a column."""

    @property
    def floor(self) -> bool: ...
    @property
    def balls(self) -> Sequence[Any]: ...
    @property
    def laws(self) -> Sequence[Any]: ...


def solvable_exactly(column: Scenario) -> bool:
    """Whether the equations of motion have a piecewise closed form: two balls on a floor under the linear law."""
    if not column.floor or len(column.balls) != 2:
        return False
    floor, pair = column.laws
    return floor.record is pair.record and _core.has_exact_solver(floor.record["name"])


@dataclass(frozen=True)
class Model:
    """One way to compute what a column does."""

    number: int  #: of the core's enum ``Model``
    name: str  #: as in ``hardlimit.sweep(model=…)``
    label: str  #: in a legend
    short: str  #: at the head of a column of a table
    limits: str  #: what it leaves out, or where it fails
    solve: Callable[..., _core.Solution]  #: (core column, until or NaN, …) → solution
    applies: Callable[[Scenario], bool] = lambda column: True
    needs: str = "any column"  #: ``applies`` in words

    def check(self, column: Scenario) -> None:
        """Refuse a column that the model does not apply to.

        Raises
        ------
        ValueError
            If the model does not apply.
        """
        if not self.applies(column):
            raise ValueError(f"column: the {self.name} model is that of {self.needs}")


#: Newton's equations (Eq. 14), with a force for as long as a contact lasts.
NEWTON: Final = Model(
    number=0,
    name="newton",
    label="Newton’s equations",
    short="Newton",
    limits="none beyond those of the contact law",
    solve=_core.newton,
)
#: Appendix A: the upper ball does not act on the lower one.
ADIABATIC: Final = Model(
    number=1,
    name="adiabatic",
    label="adiabatic",
    short="adiabatic",
    limits="exact for R1 ≫ R2; the error falls as the mass ratio m2/m1",
    solve=_core.adiabatic,
    applies=solvable_exactly,
    needs="two balls on a floor under the linear law",
)
#: Instantaneous collisions of two bodies at a time (Eqs. 1–6): the event-driven sequence.
INDEPENDENT: Final = Model(
    number=2,
    name="independent",
    label="independent collisions",
    short="independent",
    limits="right if every contact is over before the next one begins; may end in inelastic collapse",
    solve=_core.independent,
)

#: Name → model, in the order of the core's numbers.
MODELS: Final[Mapping[str, Model]] = MappingProxyType(
    {model.name: model for model in (NEWTON, ADIABATIC, INDEPENDENT)}
)
