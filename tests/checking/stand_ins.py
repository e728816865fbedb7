"""A stand-in for the numbers of friction, for tests that ask for something else."""

import pytest

from hardlimit.checking import contacts


def stand_ins(monkeypatch: pytest.MonkeyPatch) -> None:
    """Replace the numbers of friction, which take long, by one that changes with everything they depend on."""

    def stand_in(case, first, second, speed, dimension):
        if case.friction.coefficient == 0.0 or case.friction.terms is None:
            return {}
        force = case.force(first, second, speed)
        if isinstance(force, contacts.AdhesiveForce):
            return {}
        contact = contacts.friction.contact_of(case.friction.terms, force, (first, second), speed)
        text = repr((contact, case.time_step, dimension))
        return {"limit": "total", "stiffness_ratio": float(int.from_bytes(text.encode()) % 1000003)}

    monkeypatch.setattr(contacts, "_friction", stand_in)
    monkeypatch.setattr(contacts, "_with_friction", lambda *arguments: {})
