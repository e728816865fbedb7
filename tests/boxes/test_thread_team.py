"""ThreadTeam of the time-stepping engine: every task is done once per phase, even if threads are late or absent."""

import subprocess

import pytest

from conftest import compiled


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    return compiled("boxes/thread_team.cpp", tmp_path_factory.mktemp("thread_team"))


@pytest.mark.slow
@pytest.mark.parametrize(("threads", "partitions"), [(1, 1), (1, 4), (2, 2), (2, 5), (4, 4), (5, 3)])
def test_every_task_is_done_once_though_threads_are_missing_or_late(program, threads, partitions):
    done = subprocess.check_output([program, str(threads), str(partitions)], text=True, timeout=120)
    tasks, wrong = map(int, done.split())
    assert tasks == 3000 * partitions and wrong == 0
