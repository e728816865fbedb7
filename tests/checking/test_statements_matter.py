"""Statements of scripts for grains at rest, shaken, sheared, pressed and in gases, left out, changed or added.

Each changes what the reader takes from a script, or is quoted, or belongs to the kinds that change no number.
"""

import dataclasses
import random
import re
import shutil
import tomllib
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from stand_ins import stand_ins
from test_script_fuzz import DATA, NUMBER, mutants

import hardlimit as hl
from conftest import draws, slow
from hardlimit.checking import contacts, systems
from hardlimit.checking.scripts import Quote, Setting, read

#: Files that scripts include.
PARTS = (".inc", ".data", ".gz", ".txt", ".stl")
SCRIPTS = {
    path.name: path
    for path in (
        *sorted((DATA / "states").iterdir()),
        *sorted((DATA / "fuzz").iterdir()),
        Path(__file__).parents[2] / "examples/in.granular_gas",
    )
    if path.suffix not in PARTS
}
FEW = ("lammps_chute", "lammps_barostat", "lammps_shear_cell", "liggghts_settled_bed", "yade_shaken_bed")
#: Kinds of statements that change no number; «» stands around what is left out or changed.
INERT = {
    "output": r"^«?(thermo|fix_modify|compute|dump|print)\b|^«(plot\.|O\.(saveTmp|pause)|O\.run\(1000)",
    "how the program runs": r"^«?(neighbor|neigh_modify|comm_modify|communicate|newton|atom_modify)\b",
    "where grains are": r"^«?(region|boundary|create_box|atom_style)\b|^create_atoms \d+ (random \S+ |single ).*«"
    r"|^lattice (sc «|sq \S+ origin .*«)",
    "how they are inserted": r"^fix \w+ all (pour \S+ \S+ «|pour .* (vol|«vol)|insert/\S+ .*«)|«?particledist\S+ .*",
    "random numbers": r"particletemplate/sphere «|\bseed=?«|\b«?seed»?=",
    "how fast they start": r"^«?velocity|state\.vel =|^«?(variable (speed|deep|inside|vx)|g, height)\b",
    "the place and size of walls": r"plane .*«|(region|cylinder) .*«|scale»|scale «|mesh/surface .*«",
    "words that mean nothing to the code, or their default": r"«(atom_type|particletemplate/sphere)»|^«dimension 3»",
    "the sign of a direction alone": r"gravity \S+ vector .*«1(\.0)?»",
    "integration, which is taken for granted": r"^«fix \w+ \w+ (nve/sphere|enforce2d)",
    "pair styles given by their coefficients": r"^«pair_(style granular|coeff \* \*)»$",
    "properties of walls among themselves": r"\(«?1»?, «?1»?, «?0\.5»?\)\)|(pair [23] .*|density=|poisson=)«\S+»"
    r"(,.*label=\"(walls|steel|floor)|$)",
    "values that are not reached": r"^variable (e|mu) index .*«|^if .*«"
    r"|^«?variable (drag|zero|area|p|n|sink|lift|angle)\b",
    "groups that nothing uses": r"^«?group (ball|large|small|base)\b",
    "a friction of zero": r"coefficientFriction «?peratomtypepair»? 1 «?0\.0|^«fix m4 .* 0\.0»",
    "grains that are the default": r"^«?set «?type»? «?1»? .*diameter 1\.0 density|^set type 1\*«2»",
    "numbers of forces that no contact has": r"fix (press|slow) .*«|^«unfix slow|CohFrictMat\(.*«",
    "where bodies of YADE are, and how many": r"makeCloud\(\([^r]*«|«?num»?=|«(300|0\.95)»"
    r"|O\.(cell|periodic)\b|facet\w*\(.*«|(box|sphere|wall)\(\(?[^)]*«|gap»?="
    r"|regularHexa\([^r]*«|aabbWalls|^«?mn, mx|^«?n, |in range\(.*«"
    r"|layer\(«|layer\(\S+ \S+ «"
    r"|^O\.run\(«|box\(.*«|wall\(max.*«|sphere\(\(0\.002 \* \(.*«.*\), 8e-4",
    "a triaxial test, whose grains are pressed": r"^«?(triax|sigma)|(TriaxController|StressController)\(.*«",
    "words of the command line": r"sys\.argv|^scale = ",
    "where and how often factories make grains": r"Factory\(.*(?<!rMin=)(?<!rMax=)«",
    "the larger angle of friction of two": r"frictionAngle=«|setContactFriction\(«|etaRoll=«",
    "objects that are not used": r"^«?(last|ids|big|shell|grains|wheel|o\.materials)\b",
}
HARMLESS = re.compile("|".join(INERT.values()))
#: A cloud whose spheres a controller makes larger, to sizes that are not known.
GROWING = ("yade_triaxial_walls", "«sp = pack.SpherePack()»")


def plain(value):
    """What a script says, without its lines and their numbers."""
    if isinstance(value, Quote):
        return None
    if isinstance(value, Setting):
        return value.words
    if dataclasses.is_dataclass(value):
        return {field.name: plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, dict):
        return {name: plain(item) for name, item in value.items()}
    return [plain(item) for item in value] if isinstance(value, list | tuple) else value


def taken(text, folder):
    """What the reader takes from a script, and the lines that are quoted as not understood or ignored."""
    (folder / "script").write_text(text, encoding="utf-8")
    try:
        script = read(folder / "script")
    except ValueError as error:
        return str(error), set()
    quotes = [*script.unknown, *(note.quote for note in script.ignored)]
    return plain(script), {quote.line for quote in quotes if quote is not None}


def copied(name, folder):
    """The text of a script, whose parts are copied to a folder."""
    for path in SCRIPTS[name].parent.iterdir():
        if path.suffix in PARTS:
            shutil.copy(path, folder)
    return SCRIPTS[name].read_text(encoding="utf-8")


@pytest.mark.parametrize("name", [name if name in FEW else slow(name) for name in SCRIPTS])
def test_each_statement_matters_or_is_quoted(name, tmp_path):
    text = copied(name, tmp_path)
    before, _ = taken(text, tmp_path)
    assert not isinstance(before, str), before
    silent = []
    for marked, changed in mutants(text):
        after, quoted = taken(changed, tmp_path)
        pairs = zip(text.split("\n"), changed.split("\n"), strict=True)
        line = next(k for k, (old, new) in enumerate(pairs, 1) if old != new)
        if after == before and line not in quoted and not HARMLESS.search(marked):
            silent.append(marked)
    assert [marked for marked in silent if (name, marked) != GROWING] == []


# --- statements that are added ----------------------------------------------------------------------------------

ADDED = tomllib.loads((DATA / "added_statements.toml").read_text(encoding="utf-8"))


@pytest.mark.parametrize("code", ADDED)
def test_an_added_statement_is_noticed_unless_it_changes_no_number(code, tmp_path):
    text = copied(ADDED[code]["script"], tmp_path)
    before, _ = taken(text, tmp_path)
    begin = text.rindex("O.run" if code == "yade" else "run ")
    line = text.count("\n", 0, begin) + 1

    def noticed(statement):
        after, quoted = taken(f"{text[:begin]}{statement}\n{text[begin:]}", tmp_path)
        return after != before or line in quoted

    seen, inert = (ADDED[code][name].strip().splitlines() for name in ("seen", "inert"))
    assert not [statement for statement in seen if not noticed(statement)]
    assert not set(seen) & set(inert)


# --- answers ------------------------------------------------------------------------------------------------------


def answer(text, folder):
    """The answer as JSON has it, without quotes of the script."""
    (folder / "script").write_text(text, encoding="utf-8")
    try:
        return re.sub(r"(script, )?line \d+: [^']*", "", str(hl.check(folder / "script").to_dict()))
    except ValueError as error:
        return str(error)


@pytest.mark.parametrize("name", [name if name in FEW[:2] else slow(name) for name in SCRIPTS])
def test_what_is_taken_changes_the_answer(name, tmp_path, monkeypatch):
    """Numbers of contacts, grains and time steps, of changes drawn at random."""
    stand_ins(monkeypatch)
    monkeypatch.setattr(systems, "CHOSEN_SPEEDS", (0.1,))
    text = copied(name, tmp_path)
    before, first = taken(text, tmp_path)[0], answer(text, tmp_path)
    numbers = r"timestep|O\.dt =|density|diameter|young|gravity «|gran(ular)? hooke|hertz"
    changes = [change for change in mutants(text) if re.search(numbers, change[0])]
    for marked, changed in random.Random(name).sample(changes, min(2, len(changes))):
        if taken(changed, tmp_path)[0] != before:
            assert answer(changed, tmp_path) != first or HARMLESS.search(marked), marked


# --- random faults ------------------------------------------------------------------------------------------------

FAULTS = (
    "0",
    "-1",
    "1e300",
    "-1e-300",
    "nan",
    "inf",
    "1e999",
    "",
    "x",
    "v_x",
    "${x}",
    "$(1/0)",
    "*",
    '"',
    "(",
    "&",
)


@slow
@draws(40, 400)
@given(name=st.sampled_from(sorted(SCRIPTS)), seed=st.integers(0, 2**32), count=st.integers(1, 4))
def test_random_faults_give_an_answer_or_one_line(tmp_path_factory, name, seed, count):
    chosen, folder = random.Random(seed), tmp_path_factory.mktemp("faults")
    text = copied(name, folder)
    for _ in range(count):
        words = list(re.finditer(r"[^\s,()\[\]]+", text))
        word = chosen.choice(words)
        other = chosen.choice((*FAULTS, chosen.choice(words)[0]))
        if NUMBER.fullmatch(word[0]) and chosen.random() < 0.3:
            other = f"{float(word[0]) * 10.0 ** chosen.randint(-12, 12):g}"
        text = text[: word.start()] + other + text[word.end() :]
    (folder / "script").write_text(text, encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(contacts, "_friction", lambda *arguments: {})
        try:
            assert hl.check(folder / "script", speed=0.5, packing_fraction=0.1).sentence
        except ValueError as error:
            assert "\n" not in str(error)
    shutil.rmtree(folder)
