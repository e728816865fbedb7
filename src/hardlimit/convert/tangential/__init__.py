"""Tangential models of particle codes: the friction of one contact from the numbers in a code's input.

Each code has a module with a list ``MODELS``. All numbers of a contact are in one system of units, that of the script
or SI.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module, util
from typing import NamedTuple

from ...contact.friction import FrictionTerms
from ..codes import Written
from ..force import Force
from ..formulas import Numbers


@dataclass(frozen=True)
class Tangential:
    """A tangential model of a code, with the numbers of its input; None stands for the default of the code."""

    model: str  #: name in ``MODELS`` of the module of the code
    numbers: Mapping[str, float | None]


class NormalContact(NamedTuple):
    """The normal force of a contact, on which the tangential one may depend."""

    written: Written  #: model of the normal force and pair of bodies
    numbers: Numbers  #: of the normal model
    force: Force


@dataclass(frozen=True)
class TangentialModel:
    """One tangential model of a code."""

    name: str  #: as in the code's input
    numbers: Mapping[str, tuple[float, float, float]]  #: powers of mass, length and time in each of its units
    terms: Callable[[Mapping[str, float | None], NormalContact], FrictionTerms]  #: of one contact
    #: β where the terms do not say all; from its numbers, contact, m_t, impact speed and slip velocity.
    restitution: Callable[[Mapping[str, float | None], NormalContact, float, float, float], float] | None = (
        None
    )


@cache
def models_of(code: str) -> dict[str, TangentialModel]:
    """The tangential models of a code by name; none if they are not known."""
    module = f"{__name__}.{code}"
    models = import_module(module).MODELS if util.find_spec(module) else ()
    return {model.name: model for model in models}
