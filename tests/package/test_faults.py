"""The deliberate faults of tools/faults.py refer to existing headers and tests."""

import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

import faults  # noqa: E402

FAULTS = faults.read_faults()


@pytest.mark.parametrize("fault", FAULTS, ids=lambda f: f.name)
def test_a_fault_changes_what_is_there(fault: faults.Fault, tmp_path: Path) -> None:
    """The old text of each fault occurs once, and its tests and translation units exist."""
    there = tmp_path / fault.file
    there.parent.mkdir(parents=True, exist_ok=True)
    before = (ROOT / "core" / fault.file).read_text(encoding="utf-8")
    there.write_text(before, encoding="utf-8")
    fault.apply(tmp_path)
    assert there.read_text(encoding="utf-8") != before
    assert all((ROOT / "bindings" / f"{unit}.cpp").is_file() for unit in fault.units)
    assert fault.tests
    for test in fault.tests:
        path, _, name = test.partition("::")
        source = (ROOT / path).read_text(encoding="utf-8")
        assert not name or f"\ndef {name.split('[')[0]}(" in source


def test_there_are_enough_and_no_name_is_used_twice() -> None:
    assert len(FAULTS) >= 30
    assert len({f.name for f in FAULTS}) == len(FAULTS)
    assert len({f.file for f in FAULTS}) >= 15


def test_text_that_has_gone_is_refused(tmp_path: Path) -> None:
    (tmp_path / FAULTS[0].file).parent.mkdir(parents=True)
    (tmp_path / FAULTS[0].file).write_text("", encoding="utf-8")
    with pytest.raises(ValueError, match="occurs 0 times"):
        FAULTS[0].apply(tmp_path)
