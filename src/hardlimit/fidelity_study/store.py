"""A file of finished replicas, which is rewritten each time another replica is finished."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from .. import _core
from ..boxes import checkpoint
from ..support import saving, validation
from .replica import Arrays

#: Kind of checkpoint in the header of the file.
KIND: Final = "fidelity"

#: Time to wait while another process writes [s]; longer than the largest store takes.
PATIENCE: Final = 60.0


class Store:
    """Finished replicas by number, in memory and, with a path, in a file.

    ``facts`` is everything that a replica depends on. A file with other facts is refused.

    Raises
    ------
    ValueError
        If the file is not a store, is damaged, or is of another version or other facts; names it.
    OSError
        If it cannot be written; names it.
    """

    def __init__(self, path: Any, facts: Mapping[str, Any]) -> None:
        self.path = None if path is None else _checked(path)
        self.facts = dict(facts)
        self.replicas: dict[int, Arrays] = {}
        if self.path is not None:
            if self.path.exists():
                self.replicas = self._read(self.path)
            else:
                self._keep()

    def add(self, replica: int, arrays: Arrays) -> None:
        """Add a replica, and write it to the file."""
        self.replicas[replica] = arrays
        self._keep()

    def _keep(self) -> None:
        """Write all replicas, including those that other processes have added to the file."""
        if self.path is None:
            return
        with saving.locked(self.path, PATIENCE):
            if self.path.exists():
                self.replicas = self._read(self.path) | self.replicas
            flat = {
                f"{k}/{name}": array for k, found in self.replicas.items() for name, array in found.items()
            }
            checkpoint.write(self.path, {"kind": KIND, "facts": self.facts}, flat)

    def _read(self, path: Path) -> dict[int, Arrays]:
        try:
            header, flat = checkpoint.read(path)
        except ValueError as error:
            raise ValueError(f"store: {error}") from None
        if header.get("kind") != KIND:
            raise ValueError(
                f"store: {path} is a checkpoint of a run, must be a store of hl.fidelity or a new file"
            )
        for name, wanted in self.facts.items():
            kept = header["facts"].get(name)
            if kept != wanted:
                what = f"{name} {_short(kept)}, not {_short(wanted)}"
                raise ValueError(f"store: {path} was made with {what}; repeat that call or take another path")
        found: dict[int, Arrays] = {}
        for key, array in flat.items():
            replica, name = key.split("/")
            found.setdefault(int(replica), {})[name] = array
        return found


def _short(fact: Any) -> str:
    text = str(fact)
    return text if len(text) <= validation.MAX_CHARACTERS else f"{text[: validation.MAX_CHARACTERS - 1]}…"


def _checked(path: Any) -> Path:
    try:
        return checkpoint.checked_path(path)
    except ValueError as error:
        raise ValueError(str(error).replace("checkpoint:", "store:", 1)) from None


def facts_of(plan: Any, start: str, seed: int) -> dict[str, Any]:
    """Everything that a replica depends on, except its number."""
    return {
        "hardlimit_version": _core.version,
        "models": list(plan.models),
        "law": repr(plan.law),
        "until": plan.until,
        "samples": plan.samples,
        "restitution": plan.restitution,
        "contact_duration": plan.contact_duration,
        "engine": plan.engine,
        "seed": seed,
        "start": start,
    }
