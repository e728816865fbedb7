"""Today's three bindings behind the interface of the one binding to come; goes when that is merged."""

from __future__ import annotations

import math
from typing import Any

from .. import _core

CLASSES: dict[str, Any] = {
    "hard_spheres": _core.HardSpheres,
    "newton_events": _core.NewtonEvents,
    "newton_steps": _core.NewtonSteps,
}
COLLISIONS = ("time", "first", "second", "impact_speed", "separation_speed")
CONTACTS = ("begin", "end", "first", "second", "impact_speed", "separation_speed", "overlapped")


class Engine:
    def __init__(self, kind: str, compiled: Any) -> None:
        self.kind, self.compiled, self._until = kind, compiled, 0.0

    def advance(self, until: float, max_work: int = 2**62, threads: int = 1) -> None:
        if self.kind == "hard_spheres":
            self._until = until
            self.compiled.advance(until, self.compiled.n_rows + max_work)
        elif self.kind == "newton_steps":
            self.compiled.advance(until, threads, max_work)
        else:
            self.compiled.advance(until, max_work)

    @property
    def paused(self) -> bool:
        if self.kind == "hard_spheres":
            return bool(self.outcome == "ok" and self.time < self._until)
        return bool(self.compiled.paused)

    @property
    def n_contacts(self) -> int:
        name = {"hard_spheres": "n_rows", "newton_events": "contacts_reached", "newton_steps": "n_contacts"}
        return int(getattr(self.compiled, name[self.kind]))

    @property
    def n_logged(self) -> int:
        name = {"hard_spheres": "n_rows", "newton_events": "n_logged", "newton_steps": "n_ended"}
        return int(getattr(self.compiled, name[self.kind]))

    def observe(self) -> dict[str, Any]:
        seen = dict(self.compiled.observe())
        if self.kind == "hard_spheres":
            seen |= {"n_contacts": self.compiled.n_rows, "n_pairs": self.compiled.n_pairs}
        return seen

    def statistics(self) -> dict[str, Any]:
        names = {
            "hard_spheres": ("n_events", "n_walls", "n_elastic_by_tc", "n_soft", "n_soft_third_body"),
            "newton_events": ("n_events", "largest_cluster", "cluster_share"),
            "newton_steps": ("time_step", "n_steps", "n_lists", "skin"),
        }
        return {name: getattr(self.compiled, name) for name in names[self.kind]}

    @property
    def largest_compression(self) -> float:
        return float(self.compiled.observe()["largest_compression"])

    def take_log(self) -> dict[str, Any]:
        names = COLLISIONS if self.kind == "hard_spheres" else CONTACTS
        return dict(zip(names, self.compiled.take_log(), strict=True))

    def open_contacts(self) -> dict[str, Any]:
        return dict(zip(CONTACTS, self.compiled.open_contacts(), strict=True))

    def __getattr__(self, name: str) -> Any:
        return getattr(self.compiled, name)


def make_engine(
    kind: str,
    *arguments: Any,
    law: Any = None,
    rule: str | None = None,
    restitution: float = math.nan,
    rule_parameters: Any = (),
    time_step: float = 0.0,
    log: bool = False,
) -> Engine:
    own: list[Any] = []
    if kind == "hard_spheres":
        own = [rule, restitution, law, *(rule_parameters or [math.nan]), log]
    else:
        own = [law, *([time_step] if kind == "newton_steps" else []), log]
    return Engine(kind, CLASSES[kind](*arguments, *own))


def load_engine(kind: str, saved: bytes) -> Engine:
    return Engine(kind, CLASSES[kind].load(saved))
