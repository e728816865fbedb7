"""The models of a column: what the core says of them, what each applies to, and its solver.

Names, labels and limits stand in ``core/column/model.hpp``, where the page reads them, too.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from operator import attrgetter
from types import MappingProxyType
from typing import Any, Final, Protocol

from .. import _core


class Scenario(Protocol):
    """What decides whether a model applies to a column."""

    @property
    def solvable_exactly(self) -> bool: ...


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


def _model(number: int, solve: Callable[..., _core.Solution], **applies: Any) -> Model:
    return Model(number=number, solve=solve, **_core.model_records()[number], **applies)


#: Newton's equations (Eq. 14), with a force for as long as a contact lasts.
NEWTON: Final = _model(0, _core.newton)
#: Appendix A: the upper ball does not act on the lower one.
ADIABATIC: Final = _model(
    1,
    _core.adiabatic,
    applies=attrgetter("solvable_exactly"),
    needs="two balls on a floor under the linear law",
)
#: Instantaneous collisions of two bodies at a time (Eqs. 1–6): the event-driven sequence.
INDEPENDENT: Final = _model(2, _core.independent)

#: Name → model, in the order of the core's numbers.
MODELS: Final[Mapping[str, Model]] = MappingProxyType(
    {model.name: model for model in (NEWTON, ADIABATIC, INDEPENDENT)}
)
