"""The models of a column: description, condition of applicability, and solver of each.

Names, labels and limits come from ``core/column/model.hpp``, which the explorer page uses as well.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from operator import attrgetter
from types import MappingProxyType
from typing import Any, Final, Protocol

from .. import _core


class Scenario(Protocol):
    """The properties of a column that determine whether a model applies."""

    @property
    def solvable_exactly(self) -> bool: ...


@dataclass(frozen=True)
class Model:
    """One model of a column."""

    number: int  #: in the core's enum ``Model``
    name: str  #: as in ``hardlimit.sweep(model=…)``
    label: str  #: for legends
    short: str  #: for table headers
    limits: str  #: effects that it neglects, or conditions under which it fails
    solve: Callable[..., _core.Solution]  #: (core column, ``until`` or NaN, …) → solution
    applies: Callable[[Scenario], bool] = lambda column: True
    needs: str = "any column"  #: describes ``applies``


def _model(number: int, solve: Callable[..., _core.Solution], **applies: Any) -> Model:
    return Model(number=number, solve=solve, **_core.model_records()[number], **applies)


#: Newton's equations (Eq. 14) with contact forces.
NEWTON: Final = _model(0, _core.newton)
#: The upper ball does not act on the lower one (Appendix A).
ADIABATIC: Final = _model(
    1,
    _core.adiabatic,
    applies=attrgetter("solvable_exactly"),
    needs="two balls on a floor under the linear law",
)
#: Instantaneous collisions, as in an event-driven simulation (Eqs. 1–6).
INDEPENDENT: Final = _model(2, _core.independent)

#: Name → model, in the order of the core's numbers.
MODELS: Final[Mapping[str, Model]] = MappingProxyType(
    {model.name: model for model in (NEWTON, ADIABATIC, INDEPENDENT)}
)
