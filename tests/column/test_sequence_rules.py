"""The scalar and the vector implementation of the sequence rules give the same results for any events."""

import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def test_both_sets_of_rules_agree_on_random_events(tmp_path: Path) -> None:
    """Counts, times, velocities and whether the sequence is over, after every event."""
    program = tmp_path / "sequence_rules"
    source = ROOT / "tests" / "column" / "sequence_rules.cpp"
    flags = ["-std=c++20", "-O2", "-ffp-contract=off", f"-I{ROOT / 'core'}"]
    subprocess.run(["g++", *flags, str(source), "-o", str(program)], check=True)
    done = subprocess.run([str(program)], capture_output=True, text=True, check=True)
    compared, finished, followed, separated, different = map(int, done.stdout.split())
    assert different == 0
    # The relevant cases, and unfinished sequences, are frequent.
    assert compared == 100_000
    assert min(finished, compared - finished, followed, separated) > compared // 20
