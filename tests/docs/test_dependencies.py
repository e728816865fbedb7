"""Every package that an installation brings is told in the documentation, with its licence and why it is there."""

import importlib.metadata
import re
import tomllib
from email.message import Message
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
PAGE = (ROOT / "docs" / "dependencies.md").read_text(encoding="utf-8")
#: name → (where it is asked for, licence, reason)
ROWS = {
    name: (extras, licence, reason)
    for name, extras, licence, reason in re.findall(
        r"^\| `([^`]+)` \| ([^|]+) \| ([^|]+) \| ([^|]+) \|$", PAGE, re.M
    )
}
ASKED = {"base": PROJECT["dependencies"], **PROJECT["optional-dependencies"]}


def names(requirements: list[str]) -> set[str]:
    return {re.match(r"[\w.-]+", text)[0].lower() for text in requirements}


def test_the_page_has_what_pyproject_asks_for() -> None:
    for name, (extras, _, _) in ROWS.items():
        where = {group for group, requirements in ASKED.items() if name in names(requirements)}
        assert set(extras.split(", ")) == where, name
    assert set(ROWS) == set().union(*map(names, ASKED.values()))


def stated_licence(name: str) -> str:
    """What the metadata of an installed package says of its licence, all places together."""
    metadata = importlib.metadata.metadata(name)
    classified = [c for c in metadata.get_all("Classifier", []) if c.startswith("License")]
    first_line = (metadata.get("License") or "").strip().partition("\n")[0]
    return " ".join([metadata.get("License-Expression") or "", first_line, *classified])


#: What stands in metadata for a licence.
WORDS = {
    "BSD-3-Clause": "BSD",
    "BSD-2-Clause": "BSD",
    "MIT": "MIT",
    "Apache-2.0": "Apache",
    "MPL-2.0": "MPL|Mozilla",
    "LGPL-2.1-or-later": "LGPL|Lesser",
    "GPL-2.0-only": "GPL",
    "PSF-2.0": "PSF|Python Software Foundation|Matplotlib",
    "MIT-CMU": "MIT-CMU|HPND",
    "proprietary": "Proprietary|NVIDIA",
}


@pytest.mark.parametrize("name", sorted(ROWS))
def test_licences_are_those_of_the_installed_packages(name: str) -> None:
    licence = ROWS[name][1]
    alternatives = [WORDS[part] for part in re.split(r" AND | OR ", licence)]
    try:
        stated = stated_licence(name)
    except importlib.metadata.PackageNotFoundError:
        assert not {"base", "test"} & set(ROWS[name][0].split(", ")), (
            f"{name} must be installed for the tests"
        )
        pytest.skip(f"{name} is not installed here")
    assert re.search("|".join(alternatives), stated), (name, stated)


def test_a_licence_that_is_not_stated_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.metadata, "metadata", lambda _: Message())
    assert stated_licence("numpy").strip() == ""
    with pytest.raises(AssertionError):
        test_licences_are_those_of_the_installed_packages("numpy")
