"""Threads of a run by steps: every task once, neighbours in turn, whoever comes late or not at all."""

import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    made = tmp_path_factory.mktemp("crew") / "crew"
    flags = ["-std=c++20", "-O2", "-pthread", f"-I{ROOT / 'core'}"]
    subprocess.run(["g++", *flags, str(ROOT / "tests" / "boxes" / "crew.cpp"), "-o", str(made)], check=True)
    return made


def ask(program, *words):
    done = subprocess.run(
        [program, *map(str, words)], capture_output=True, text=True, check=True, timeout=120
    )
    return map(int, done.stdout.split())


@pytest.mark.slow
def test_in_any_order_of_the_threads_each_slab_is_swept_after_those_it_needs(program):
    courses, wrong, apart = ask(program, "schedules")
    assert courses == 585 and wrong == 0 and apart > 100


@pytest.mark.slow
@pytest.mark.parametrize(("threads", "shares"), [(1, 1), (1, 4), (2, 2), (2, 5), (4, 4), (5, 3)])
def test_every_task_is_done_once_though_threads_are_missing_or_late(program, threads, shares):
    tasks, wrong = ask(program, "threads", threads, shares)
    assert tasks > 15_000 and wrong == 0
