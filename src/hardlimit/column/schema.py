"""What a TOML file of a column may hold: one structure of msgspec for each of its tables."""

from __future__ import annotations

from typing import Any

from msgspec import Struct, defstruct

from ..contact.contact import law_parameters
from ..contact.laws import LAWS

#: A number in SI units, or a text with its unit such as "1 mm".
Quantity = float | str


class BallTable(Struct, forbid_unknown_fields=True):
    """``[[balls]]``: radius [m], and density [kg/m³] or mass [kg]."""

    radius: Quantity
    density: Quantity | None = None
    mass: Quantity | None = None


def _law_table(name: str) -> type[Struct]:
    """``[law]`` of one registered law: its name and its parameters."""
    fields: list[Any] = [(key, Quantity | None, None) for key in law_parameters(LAWS[name])]
    made: type[Struct] = defstruct(
        LAWS[name].__name__, fields, tag_field="name", tag=name, forbid_unknown_fields=True
    )
    return made


LAW_TABLES = {name: _law_table(name) for name in LAWS}


def any_law() -> Any:
    """The union of all laws; the ``name`` of a table says which is meant."""
    first, *others = LAW_TABLES.values()
    union: Any = first
    for other in others:
        union = union | other
    return union


#: The top level of the file. ``law`` and ``laws`` have a type that depends on which laws are registered.
ColumnTable: Any = defstruct(
    "ColumnTable",
    [
        ("balls", list[BallTable]),
        ("cradle", bool, False),
        ("height", Quantity | None, None),
        ("gravity", Quantity | None, None),
        ("gaps", Quantity | list[Quantity] | None, None),
        ("velocities", Quantity | list[Quantity] | None, None),
        ("law", any_law() | None, None),
        ("laws", list[any_law()] | None, None),  # type: ignore[misc]
    ],
    forbid_unknown_fields=True,
)
