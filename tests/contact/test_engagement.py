"""Engagement of a slack pair in free flight: the search for any law agrees with the closed form."""

import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.slow
def test_the_search_agrees_with_the_closed_form(tmp_path):
    """Differences up to 1e-8 follow from the condition of the problem: two nearly equal zeros."""
    program = tmp_path / "engagement"
    source = ROOT / "tests" / "contact" / "engagement.cpp"
    flags = ["-std=c++20", "-O2", "-ffp-contract=off", f"-I{ROOT / 'core'}"]
    subprocess.run(["g++", *flags, str(source), "-o", str(program)], check=True)
    compared, worst, only_one = subprocess.run(
        [str(program)], capture_output=True, text=True, check=True
    ).stdout.split()
    assert int(compared) > 20_000 and int(only_one) == 0
    assert float(worst) < 1e-7
