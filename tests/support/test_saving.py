"""Files that are written as a whole: what a killed process leaves, several writers at once, failures."""

import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from conftest import slow
from hardlimit.support import saving

KILLED = """
import os, signal, sys
from pathlib import Path
from hardlimit.support import saving
with saving.whole(sys.argv[1]) as unfinished:
    unfinished.write_bytes(b"half of it" * 100)
    os.kill(os.getpid(), signal.SIGKILL)
"""

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals and locks of files")


def names(folder: Path) -> set[str]:
    return {entry.name for entry in folder.iterdir()}


@pytest.mark.parametrize("name", ["run.ck", *map(slow, ("no_ending", "Δ" * 120 + ".ck", "a." + "b" * 100))])
def test_what_a_killed_process_leaves_is_taken_over(name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_bytes(b"former")
    killed = subprocess.run([sys.executable, "-c", KILLED, str(path)], check=False)
    assert killed.returncode == -signal.SIGKILL
    assert path.read_bytes() == b"former" and len(names(tmp_path)) == 2
    saving.write(path, b"new")
    assert path.read_bytes() == b"new" and names(tmp_path) == {name}


def test_two_writers_at_once_do_not_mix(tmp_path: Path) -> None:
    """The last one to finish wins, each time a complete file; none is left."""
    path = tmp_path / "run.ck"
    with saving.whole(path) as first:
        first.write_bytes(b"first")
        with saving.whole(path) as second:
            second.write_bytes(b"second")
            assert first != second
        assert path.read_bytes() == b"second"
    assert path.read_bytes() == b"first" and names(tmp_path) == {"run.ck"}

    def write(letter: bytes) -> None:
        for _ in range(50):
            saving.write(path, letter * 10_000)

    writers = [threading.Thread(target=write, args=(letter,)) for letter in (b"a", b"b", b"c")]
    for writer in writers:
        writer.start()
    while any(writer.is_alive() for writer in writers):
        content = path.read_bytes()
        assert content == b"first" or (len(content) == 10_000 and len(set(content)) == 1)
    assert names(tmp_path) == {"run.ck"}


def test_a_block_that_fails_leaves_the_former_file(tmp_path: Path) -> None:
    path = tmp_path / "run.ck"
    path.write_bytes(b"former")
    with pytest.raises(KeyboardInterrupt), saving.whole(path) as unfinished:
        unfinished.write_bytes(b"new")
        raise KeyboardInterrupt
    with pytest.raises(OSError, match=r"run\.ck: cannot be written: mine"), saving.whole(path):
        raise OSError("mine")
    assert path.read_bytes() == b"former" and names(tmp_path) == {"run.ck"}


def test_a_file_written_in_place_has_one_writer(tmp_path: Path) -> None:
    path = tmp_path / "run.xyz"
    refused = pytest.raises(ValueError, match=r"run\.xyz is being written by another process")
    with saving.exclusive(path), refused, saving.exclusive(path):
        pass
    with saving.exclusive(path):
        pass


def test_a_lock_is_removed_and_keeps_others_out(tmp_path: Path) -> None:
    """Three threads count in a file: none of the counts is lost while the lock comes and goes."""
    path = tmp_path / "count"
    path.write_text("0")

    def count() -> None:
        for _ in range(30):
            with saving.locked(path, 30.0):
                before = int(path.read_text())
                os.sched_yield()
                path.write_text(str(before + 1))

    threads = [threading.Thread(target=count) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert path.read_text() == "90" and names(tmp_path) == {"count"}
