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
TIMEOUT: Final = 60.0


class Store:
    """Finished replicas by number, in memory and, with a path, in a file.

    ``facts`` is everything that a replica depends on. A file with other facts is refused.
    """

    def __init__(self, path: Any, facts: Mapping[str, Any]) -> None:
        self.path = None if path is None else checkpoint.checked_path(path, "store")
        self.facts = dict(facts)
        self.replicas: dict[int, Arrays] = {}
        if self.path is not None:
            if self.path.exists():
                self.replicas = self._read(self.path)
            else:
                self._write()

    def add(self, replica: int, arrays: Arrays) -> None:
        self.replicas[replica] = arrays
        self._write()

    def _write(self) -> None:
        """Write all replicas, including those that other processes have added to the file."""
        if self.path is None:
            return
        with saving.locked(self.path, TIMEOUT):
            if self.path.exists():
                self.replicas = self._read(self.path) | self.replicas
            flat = {
                f"{k}/{name}": array for k, arrays in self.replicas.items() for name, array in arrays.items()
            }
            checkpoint.write(self.path, {"kind": KIND, "facts": self.facts}, flat)

    def _read(self, path: Path) -> dict[int, Arrays]:
        try:
            header, flat = checkpoint.read(path)
        except ValueError as error:
            raise ValueError(f"store: {error}") from None
        if header.get("kind") != KIND:
            raise ValueError(
                f"store: {path} is the checkpoint of a run, must be a store of replicas or a new file"
            )
        for name, wanted in self.facts.items():
            kept = header["facts"].get(name)
            if kept != wanted:
                what = f"{name} {_short(kept)}, not {_short(wanted)}"
                if name == "start":  # a digest, which tells the reader nothing
                    what = "another start"
                raise ValueError(f"store: {path} was made with {what}; repeat that call or take another path")
        replicas: dict[int, Arrays] = {}
        for key, array in flat.items():
            replica, name = key.split("/")
            replicas.setdefault(int(replica), {})[name] = array
        return replicas


def _short(fact: Any) -> str:
    text = str(fact)
    return text if len(text) <= validation.MAX_CHARACTERS else f"{text[: validation.MAX_CHARACTERS - 1]}…"


def facts_of(plan: Any, start: str, seed: int) -> dict[str, Any]:
    """Everything that a replica depends on, except its number."""
    facts = vars(plan) | {"models": list(plan.models), "law": repr(plan.law)}
    return {"hardlimit_version": _core.version, "seed": seed, "start": start, **facts}
