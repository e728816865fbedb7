"""The rules of the sequence stand twice, for a drop and for many side by side: both give the same for any events."""

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
    # What the rules are about has come up often, and so has a sequence that is not over yet.
    assert compared == 100_000
    assert min(finished, compared - finished, followed, separated) > compared // 20
