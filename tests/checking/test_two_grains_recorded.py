"""ε and steps of a contact as ``check`` prints them, against those recorded with two grains in LIGGGHTS and YADE."""

import csv
import tomllib
from pathlib import Path

import pytest
from stand_ins import stand_ins
from test_reading_back import rows_and_back

import hardlimit as hl

HERE = Path(__file__).parent
SCRIPTS = {
    table["name"]: table
    for table in tomllib.loads((HERE / "data/two_grains.toml").read_text(encoding="utf-8"))["script"]
}
with (HERE.parent / "data/script_restitution.csv").open(encoding="utf-8") as file:
    MEASURED = {row["script"]: row for row in csv.DictReader(file)}


@pytest.mark.parametrize("name", SCRIPTS)
def test_restitution_is_that_in_the_code(name, monkeypatch):
    """``convert_back`` has the same ε and contact time as ``check``, of all contacts of the script."""
    stand_ins(monkeypatch)
    script, real = SCRIPTS[name], MEASURED[name]
    verdict = hl.check(script["text"], speed=script["speed"])
    row = next(row for row in verdict.rows if list(row.types) == script["types"])
    assert verdict.code == name.split()[0] and not verdict.unknown
    assert row.restitution == pytest.approx(float(real["restitution"]), abs=3e-4)
    assert row.steps_per_contact == pytest.approx(int(real["steps"]), abs=2)
    for row, obtained in rows_and_back(verdict, script["text"], script["speed"]):
        assert obtained.restitution == pytest.approx(row.restitution, rel=1e-9), row
        assert obtained.duration == pytest.approx(row.duration, rel=1e-9), row


def test_every_script_was_measured():
    assert list(MEASURED) == list(SCRIPTS)
