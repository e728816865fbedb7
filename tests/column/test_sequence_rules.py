"""The scalar and the vector implementation of the sequence rules give the same results for any events."""

from pathlib import Path

from conftest import output_of


def test_both_sets_of_rules_agree_on_random_events(tmp_path: Path) -> None:
    """Counts, times, velocities and whether the sequence is over, after every event."""
    compared, finished, followed, separated, different = map(
        int, output_of("column/sequence_rules.cpp", tmp_path).split()
    )
    assert different == 0
    # The relevant cases, and unfinished sequences, are frequent.
    assert compared == 100_000
    assert min(finished, compared - finished, followed, separated) > compared // 20
