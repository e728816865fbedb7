"""Every name of the package has its publications, and the BibTeX is complete."""

import re
from pathlib import Path

import pytest
from click import Context

import hardlimit as hl
from command_line import run
from hardlimit import _core
from hardlimit.boxes.engines import NEWTON
from hardlimit.boxes.rules import RULES
from hardlimit.cli import main
from hardlimit.support import citations


def test_every_model_law_rule_engine_and_figure_has_a_topic() -> None:
    topics = citations.topics()
    assert set(topics["models"]) == {record["name"] for record in _core.model_records()}
    assert set(topics["laws"]) == set(hl.LAWS)
    assert set(topics["rules"]) == set(RULES)
    assert set(topics["engines"]) == set(NEWTON)
    commands = {name.replace("-", "_") for name in main.list_commands(Context(main))}
    assert set(topics["tools"]) <= commands & set(hl.__all__)
    folder = Path(hl.__file__).parent / "paper"
    assert {f"fig{f.stem.removeprefix('figure')}" for f in folder.glob("figure*.py")} == set(
        topics["figures"]
    )


def every_topic() -> list[str]:
    return [name for names in citations.topics().values() for name in names]


def test_bibtex_is_complete_and_has_each_publication_once() -> None:
    entries = citations.bibtex(*every_topic()).split("\n\n")
    assert len(entries) == 1 + len(citations.publications(*every_topic()))
    keys = [re.match(r"@(software|article|book)\{(\w+),\n", entry)[2] for entry in entries]
    assert len(set(keys)) == len(keys)
    for entry in entries[1:]:
        assert entry.count("{") == entry.count("}")
        assert re.search(r"author = \{\S.*\},", entry) and re.search(r"title = \{\{\S.*\}\},", entry)
        assert re.search(r"year = \{\d{4}\},", entry) and re.search(r"doi = \{10\.\d{4,}/\S+\},", entry)


def test_every_publication_is_used() -> None:
    assert set(citations.publications(*every_topic())) == set(citations._references()["publications"])


def test_the_command_prints_the_publications() -> None:
    assert run("cite", "tc", "newton").stdout == citations.bibtex("tc", "newton")
    table = run("cite").stdout
    assert all(name in table for name in every_topic())


def test_an_unknown_topic_is_refused() -> None:
    with pytest.raises(ValueError, match=r"^topic: got 'gravity', must be one of newton, "):
        citations.bibtex("newton", "gravity")
