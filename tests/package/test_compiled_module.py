"""The store of compiled modules, which makes a second install of the same sources fast."""

import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
CMAKE = shutil.which("cmake")
pytestmark = pytest.mark.skipif(not CMAKE, reason="cmake is not installed here")


@pytest.fixture
def tree(tmp_path):
    """A small project with the script under test."""
    for name in ("tools", "core", "bindings"):
        (tmp_path / name).mkdir()
    shutil.copy(ROOT / "tools" / "compiled_module.cmake", tmp_path / "tools")
    for name in ("CMakeLists.txt", "core/a.hpp", "bindings/a.cpp", "module"):
        (tmp_path / name).write_text(name)
    return tmp_path


def cmake(tree, *lines):
    """The value of RESULT after these lines."""
    script = tree / "script.cmake"
    beginning = (
        'include("${CMAKE_CURRENT_LIST_DIR}/tools/compiled_module.cmake")\nset(Python_EXECUTABLE true)\n'
    )
    script.write_text(beginning + "\n".join(lines) + '\nmessage(STATUS "${RESULT}")\n')
    done = subprocess.run([CMAKE, "-P", script], capture_output=True, text=True, check=True, cwd=tree)
    return done.stdout.strip().removeprefix("-- ")


def store(tree, settings="s", sources="${now}"):
    cmake(
        tree,
        "hash_sources(now)",
        f'store_module("{tree}/build/compiled/{settings}" {sources} "{tree}/module")',
    )


def taken(tree, settings="s"):
    place = f'"{tree}/build/compiled/{settings}" ${{now}} "{tree}/taken" RESULT'
    return cmake(tree, "hash_sources(now)", f"take_module({place})") == "1"


def stored(tree):
    return sorted(file.name.split("-")[0] for file in (tree / "build" / "compiled").iterdir())


def test_a_module_is_taken_for_the_same_sources_and_settings(tree):
    assert not taken(tree)
    store(tree)
    assert taken(tree) and (tree / "taken").read_text() == "module"
    assert not taken(tree, settings="other flags")
    for name in ("core/a.hpp", "bindings/a.cpp", "CMakeLists.txt"):
        file = tree / name
        file.write_text("changed")
        assert not taken(tree), name
        file.write_text(name)
        assert taken(tree), name
    (tree / "core" / "new.hpp").write_text("")
    assert not taken(tree)


def test_one_module_is_kept_for_the_same_settings(tree):
    store(tree)
    store(tree, settings="other")
    (tree / "build" / "compiled" / "s-killedInstall").write_text("half a mod")
    (tree / "core" / "a.hpp").write_text("changed")
    store(tree)
    assert stored(tree) == ["other", "s"]
    assert taken(tree) and not taken(tree, settings="other")


def test_sources_that_changed_during_the_build_store_nothing(tree):
    store(tree, sources="0123")
    assert not (tree / "build").exists()


def test_a_module_that_cannot_be_loaded_is_not_taken(tree):
    store(tree)
    place = f'"{tree}/build/compiled/s" ${{now}} "{tree}/taken" RESULT'
    load_fails = ("hash_sources(now)", "set(Python_EXECUTABLE false)", f"take_module({place})")
    assert cmake(tree, *load_fails) == "0"


def test_a_folder_that_cannot_be_written_is_no_error(tree):
    (tree / "build").write_text("a file, in place of the folder")
    store(tree)
    assert not taken(tree)
