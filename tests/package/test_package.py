"""The namespace of ``import hardlimit``: the public names and nothing else."""

import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import hardlimit as hl

PUBLIC = {
    "FLOOR", "LAWS", "OUTCOMES", "PAPER_DENSITY", "Ball", "Column", "Comparison", "Contact", "ParticleSystem", "Result",
    "ColumnVerdict", "adiabatic", "compare", "event_driven", "independent", "newton", "resume", "sweep",
}  # fmt: skip


def test_nothing_leaks():
    """Every name is public, a dunder name, or a module of the package."""
    listing = "import hardlimit; print(*dir(hardlimit))"
    names = set(
        subprocess.run(
            [sys.executable, "-c", listing], capture_output=True, text=True, check=True
        ).stdout.split()
    )
    folder = Path(hl.__file__).parent
    modules = {
        path.name.split(".")[0] for path in folder.iterdir() if path.suffix in (".py", ".so", ".pyd", "")
    } | {"_core", *hl._MODULES}  # elsewhere in an editable install, or in a package of ours
    dunders = {name for name in names if name.startswith("__") and name.endswith("__")}
    assert names - dunders - modules == set(hl.__all__) - modules
    assert set(hl.__all__) <= names


def test_public_names():
    laws = {law.__name__ for law in hl.LAWS.values()}
    assert set(hl.__all__) >= PUBLIC | laws
    assert len(hl.__all__) == len(set(hl.__all__)) and not any(name.startswith("_") for name in hl.__all__)
    for name in hl.__all__:
        assert getattr(hl, name) is not None
        assert name.isupper() or getattr(hl, name).__doc__, name


def test_import_is_light():
    """Plotting, tables, maps on disk and processes are imported only on first use."""
    listing = "import hardlimit, sys; print(*sys.modules)"
    loaded = subprocess.run(
        [sys.executable, "-c", listing], capture_output=True, text=True, check=True
    ).stdout.split()
    late = {"matplotlib", "rich", "xarray", "zarr", "h5py", "click", "multiprocessing", "importlib.metadata"}
    late |= {
        "hardlimit.boxes",
        "hardlimit.fitting",
        "hardlimit.oblique",
        "hardlimit.stacks",
        "concurrent.futures",
    }
    assert not late & set(loaded)


def test_help_is_light():
    """Listing the commands imports none of them."""
    listing = "import sys; from hardlimit.cli import main; main(['--help'], standalone_mode=False); print(*sys.modules)"
    loaded = subprocess.run(
        [sys.executable, "-c", listing], capture_output=True, text=True, check=True
    ).stdout.split()
    assert {name for name in loaded if name.startswith("hardlimit.cli.")} == {"hardlimit.cli.program"}


def test_what_is_not_there():
    with pytest.raises(AttributeError, match="module 'hardlimit' has no attribute 'fitt'"):
        hl.fitt  # noqa: B018


def test_two_builds_at_once_share_no_folder():
    """scikit-build-core makes a temporary folder for each build unless the settings name one."""
    with open(Path(__file__).resolve().parents[2] / "pyproject.toml", "rb") as file:
        settings = tomllib.load(file)["tool"]["scikit-build"]
    assert settings["minimum-version"] and "build-dir" not in settings
