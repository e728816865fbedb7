"""Location of events: a function that is slightly below zero within a step, and positive at both ends."""

from pathlib import Path

from conftest import output_of


def test_no_dip_below_zero_is_missed(tmp_path: Path) -> None:
    """Depths from 1e-12 to 0.1 in the unit of the function; the first of its two zeros is located."""
    tried, missed, seen, largest = output_of("base/event_location.cpp", tmp_path).split()
    assert int(tried) > 3_000
    assert int(missed) == 0 and int(seen) == 0
    assert float(largest) < 1e-14
