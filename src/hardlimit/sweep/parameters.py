"""Parameters that can be swept, from the core's table, with their indices in a point's row of numbers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from .. import _core


@dataclass(frozen=True)
class Parameter:
    """A parameter that can be swept."""

    name: str
    #: The name without the number of a ball, gap or contact.
    kind: str
    #: Indices of its values; a name without number has those of all balls, gaps or contacts.
    indices: tuple[int, ...]
    unit: str
    meaning: str
    #: Range, for ``validation.number``.
    limits: Mapping[str, Any]
    #: Indices of values that it replaces: a radius ratio replaces the lower radius.
    overrides: tuple[int, ...] = ()


def geometry(balls: int) -> dict[str, Parameter]:
    """The parameters of a column except those of its law."""
    parameters = [p for row in _core.swept_parameters(balls) for p in _named(row, balls)]
    return {p.name: p for p in parameters}


def _named(row: dict[str, Any], balls: int) -> Iterator[Parameter]:
    """The parameters of a row of the core's table: the name alone and, for several balls or gaps, numbered names."""
    name, per, indices = row["name"], row["per"], tuple(range(row["first"], row["first"] + row["count"]))
    unit, meaning = row["unit"], row["meaning"]
    limits = {"lowest": row["lowest"], "lowest_allowed": row["lowest_allowed"]}
    if name == "radius_ratio":
        if balls == 2:
            lower = next(r["first"] for r in _core.swept_parameters(balls) if r["name"] == "radius")
            yield Parameter(
                name=name,
                kind=name,
                indices=indices,
                unit=unit,
                meaning=meaning,
                limits=limits,
                overrides=(lower,),
            )
        return
    if not indices:
        return
    whose = {"column": "", "ball": " of every ball", "gap": ""}
    yield Parameter(name, name, indices, unit, meaning + whose[per], limits)
    if per == "column" or (per == "gap" and balls == 2):
        return
    for i, index in enumerate(indices, 1):
        which = f" of ball {i} (1 = lowest)" if per == "ball" else f", of balls {i} and {i + 1} (1 = lowest)"
        yield Parameter(f"{name}_{i}", name, (index,), unit, meaning + which, limits)


def of_law(record: dict[str, Any], alternative: int, balls: int) -> dict[str, Parameter]:
    """The parameters of a law, for all contacts and for each contact."""
    parameters: dict[str, Parameter] = {}
    for i, row in enumerate([*record["common"], *record["alternatives"][alternative]]):
        name, unit, meaning = row["name"], row["unit"], row["meaning"]
        limits = {k: row[k] for k in ("lowest", "highest", "lowest_allowed", "highest_allowed")}
        indices = tuple(_core.law_place(contact, balls) + i for contact in range(balls))
        parameters[name] = Parameter(name, name, indices, unit, meaning, limits)
        for contact, index in enumerate(indices):
            full_name, of = f"{name}_{contact_name(contact)}", contact_meaning(contact)
            parameters[full_name] = Parameter(full_name, name, (index,), unit, f"{meaning}, {of}", limits)
    return parameters


def contact_name(contact: int) -> str:
    """``floor`` or ``pair_1``, numbered as in ``Result.contacts``: 0 = floor and lowest ball."""
    return "floor" if contact == 0 else f"pair_{contact}"


def contact_meaning(contact: int) -> str:
    """Description of a contact."""
    return "contact with the floor" if contact == 0 else f"contact of balls {contact} and {contact + 1}"
