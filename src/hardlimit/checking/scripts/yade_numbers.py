"""The numbers of a contact in YADE: those of its two materials and of the functor that makes it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from .description import WALL
from .population import union
from .python import Instance
from .statements import refusal
from .yade_scene import Scene


class Contact(NamedTuple):
    """Two materials, their functor, and the size of a wall over that of the sphere if the second is one."""

    scene: Scene
    functor: Instance
    ends: tuple[int, int]  #: numbers of the materials
    wall: float | None = None
    kind: str = ""  #: of the wall

    @property
    def pair(self) -> tuple[Instance, Instance]:
        """The materials."""
        return self.scene.materials[self.ends[0]], self.scene.materials[self.ends[1]]

    @property
    def types(self) -> tuple[str, str]:
        """Their names."""
        first, second = (self.scene.name(k) for k in self.ends)
        return first, second if self.wall is None else WALL

    @property
    def physics(self) -> str:
        """The name of the interaction, such as ``FrictPhys``."""
        return self.functor.name.rpartition("_")[2]

    @property
    def laws(self) -> list[Instance]:
        """The laws of this interaction."""
        return [law for law in self.scene.used("Law2_") if f"_{self.physics}_" in law.name]

    def both(self, name: str) -> tuple[float, float]:
        """A number of the two materials."""
        first, second = (self.scene.number(material, name) for material in self.pair)
        return first, second

    def have(self, *names: str) -> bool:
        """Whether both materials have these numbers."""
        return all(name in material.attributes for material in self.pair for name in names)

    @property
    def has_duration(self) -> bool:
        """Whether ViscElPhys computes springs and dashpots from tc, en and et."""
        return self.have("tc", "en", "et") or {"tc", "en", "et"} <= self.functor.attributes.keys()

    def mean(self, name: str) -> float | None:
        """A number of the functor, or the mean of the two materials; None if the functor has none for them."""
        return self.matched(name) if name in self.functor.attributes else 0.5 * sum(self.both(name))

    def in_series(self, name: str) -> float:
        """Twice the number of two springs or dashpots in series; a zero is left out."""
        values = self.both(name)
        inverse = sum(1.0 / value for value in values if value)
        return values[0] if values[0] == values[1] else 2.0 / inverse

    def mean_modulus(self, young: tuple[float, float]) -> float | None:
        """The modulus of two springs 2 Y R in series; None if the sizes of grains differ as well as the moduli.

        At a wall of size s: 2 s Y/(1 + s) is 2 s Y₁ Y₂/(Y₁ + s Y₂).
        """
        first, second = young
        if self.wall is not None:
            larger = 1.0 + self.wall
            return first * (1.0 if math.isinf(self.wall) else larger * second / (first + self.wall * second))
        if first == second:
            return first
        sizes = union([sphere.radii for sphere in self.scene.spheres() if sphere.material in self.ends])
        return None if sizes is None or sizes[0] != sizes[1] else 2.0 * first * second / (first + second)

    def matched(self, name: str, values: tuple[float, float] | None = None) -> float | None:
        """A number of the functor: the same for all contacts, or that of a MatchMaker; None if it has none.

        ``values``: of the two materials, which a MatchMaker mixes for two that it does not list.
        """
        value = self.functor.attributes[name]
        if isinstance(value, Instance) and value.name == "MatchMaker":
            for entry in entries(value):
                if sorted(entry[:2]) == sorted(self.ends):
                    return entry[2]
            value = value.attributes.get("val") if values is None else mixed(value, values)
            if value is None:
                return None
        if isinstance(value, bool) or not isinstance(value, int | float):
            must = f"have a known number for {name}"
            raise refusal(self.functor.line, self.functor.text, must, self.scene.file)
        return float(value)


def entries(matcher: Instance) -> Iterator[tuple[int, int, float]]:
    """Entries (number, number, value) of a MatchMaker."""
    matches = matcher.argument(0, "matches", ())
    for entry in matches if isinstance(matches, list | tuple) else ():
        numbers = isinstance(entry, list | tuple) and all(isinstance(x, int | float) for x in entry)
        if numbers and len(entry) == 3:
            yield int(entry[0]), int(entry[1]), float(entry[2])


def mixed(matcher: Instance, values: tuple[float, float]) -> float | None:
    """The number of a MatchMaker for two that it does not list; None if that is not known."""
    first, second = values
    mixes: Mapping[str, Any] = {
        "avg": 0.5 * (first + second),
        "min": min(values),
        "max": max(values),
        "harmAvg": 2.0 * first * second / (first + second) if first + second else 0.0,
        "zero": 0.0,
        "val": matcher.attributes.get("val"),
    }
    value = mixes.get(matcher.attributes.get("algo", "avg"))
    return float(value) if isinstance(value, int | float) else None
