"""The models of a column: what the core says of them, what each applies to, and its solver.

Names, labels and limits stand in ``core/column/model.hpp``, where the page reads them, too.
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


def _model(number: int, solve: Callable[..., _core.Solution], **applies: Any) -> Model:
    return Model(number=number, solve=solve, **_core.model_records()[number], **applies)


#: Newton's equations (Eq. 14), with a force for as long as a contact lasts.
NEWTON: Final = _model(0, _core.newton)
#: Appendix A: the upper ball does not act on the lower one.
ADIABATIC: Final = _model(
    1, _core.adiabatic, applies=solvable_exactly, needs="two balls on a floor under the linear law"
)
#: Instantaneous collisions of two bodies at a time (Eqs. 1–6): the event-driven sequence.
INDEPENDENT: Final = _model(2, _core.independent)

#: Name → model, in the order of the core's numbers.
MODELS: Final[Mapping[str, Model]] = MappingProxyType(
    {model.name: model for model in (NEWTON, ADIABATIC, INDEPENDENT)}
)
