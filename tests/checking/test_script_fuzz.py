"""Each statement of our own scripts, left out or changed: the answer changes, or the statement is quoted."""

import ast
import random
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest
import test_friction_in_lammps as in_lammps_oblique
import test_two_grains_in_lammps as in_lammps
from stand_ins import stand_ins

import hardlimit as hl
from conftest import slow
from hardlimit.checking.scripts import Description, read
from hardlimit.checking.scripts.statements import logical_lines

DATA = Path(__file__).parent / "data"
NUMBER = re.compile(r"(?<![\w.])(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?(?![\w.])")
#: A keyword right before a number, in scripts of LAMMPS and LIGGGHTS, and in calls of YADE.
KEYWORD = re.compile(r"(?<=\s)[a-z_/]+(?=\s+[-+\d.$])|\b[a-z_]+(?==[-+\d.])", re.IGNORECASE)

#: What changes no contact; «» stands around what is left out or changed.
HARMLESS = re.compile(
    "|".join(
        (
            # output, communication, geometry, velocities, names
            r"^«?(thermo|print|neighbor|neigh_modify|communicate|comm_modify|newton|processors|atom_modify)\b",
            r"^«?(boundary|region|lattice|create_box|atom_style|velocity|label|group|unfix ins)\b",
            r"^«(pair_style granular|pair_coeff \* \*|clear)»$",
            r"^«?O\.bodies\[-?«?\d+»?\]\.state\.vel",
            r"^fix \w+ all (gravity \S+ \w+ .*«|mesh/surface .*(«scale»|scale «))|^«fix \w+ \w+ (nve/|enforce2d)",
            # where, how often and in what proportion grains are made
            r"^(create_atoms|set (type|atom|group)|fix \w+ all pour|.* insert/pack) .*«(?!diam|dens|distrib)[\w.-]+»",
            r"^«?(set|create_atoms) «?(atom|type|\d+)»? .*(vz|single)",
            r"distribution/discrete|particletemplate/sphere (\d+ )?«|«particletemplate",
            r"sphere\(\([^)]*«|(facet\(\[|box\(\(|wall\().*«|«material»|for (z|k) in .*«|(=|append\()mat\)+»$",
            # the place of a wall, and numbers of a tangential force without friction
            r"[xyz]plane «|tangential linear_nohistory «\S+» 0(\.0)?( |$)",
            # what only two walls, or no grains, have; a value that stays what it was
            r"«set type 2 diameter 0\.01 density 4000»",
            r"(kt|gammat) peratomtypepair 2 (?P<k>\S+) (?P=k) (?P=k) «",
            r"0\.9 0\.35 0\.35 «0\.1»|(damping|betas)=«0\.0»|^if .*«|^«?v(ariable (z|e index|gap))?\b",
            r"coefficientFriction «?peratomtypepair»? (1 «?0\.[01]»?|2 («?0»? ?){4}|2 \S+ \S+ \S+ «)",
            r"linear_nohistory «0» 0( zplane|$)",  # x_t without friction
            # YADE: places and numbers of bodies, words of the command line, what only a run shows
            r"makeCloud\([^r]*«|geom\.facet\w+\(.*«|«?gap»?=|in range\(«|sys\.argv.*«",
            r"^«(O\.saveTmp|O\.periodic|plot\.)|etaRoll»?=|\(1e7, «4e7»\)|materialId=\w+, .*«(radius|0)",
            r"radians\(«20»\), label='steel'",  # the smaller angle counts
        )
    )
)


def scripts() -> dict[str, str]:
    """The scripts by name."""
    recorded = tomllib.loads((DATA / "two_grains.toml").read_text(encoding="utf-8"))["script"]
    texts = {entry["name"]: entry["text"] for entry in recorded}
    for name, (lines, speed) in in_lammps.PAIRS.items():
        texts[f"lammps {name}"] = in_lammps.script(lines, speed, 1e-6, 4600)
    for name, (wall, speed) in in_lammps.WALLS.items():
        texts[f"lammps {name}"] = in_lammps.script(in_lammps.COEFFICIENT, speed, 1e-6, 4600, wall)
    for name, setting in (in_lammps_oblique.SETTINGS | in_lammps_oblique.SCALED).items():
        lines, wall = (in_lammps.COEFFICIENT, setting.lines) if setting.wall else (setting.lines, "")
        texts[f"lammps friction {name}"] = in_lammps.script(lines, 0.5, 1e-6, 4600, wall)
    for name, (lines, fixes) in in_lammps.STANDING.items():
        texts[f"lammps {name}"] = in_lammps.script(lines, 0.5, 1e-6, 4600, fixes=fixes)
    paths = [*(DATA / "fuzz").iterdir(), Path(__file__).parents[2] / "examples/in.granular_gas"]
    return texts | {path.name: path.read_text(encoding="utf-8") for path in sorted(paths)}


SCRIPTS = scripts()
FEW = (
    "lammps_three_types",
    "lammps friction mixed mindlin",
    "lammps friction wall hooke/history",
    "liggghts_hopper",
    "yade ViscElMat tc en",
)


def statements(text: str) -> Iterator[tuple[int, int]]:
    """Where each statement begins and ends."""
    ends = [0]
    for line in text.splitlines(keepends=True):
        ends.append(ends[-1] + len(line))
    if "O.engines" in text:
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.Assign | ast.Expr | ast.AugAssign):
                yield ends[node.lineno - 1] + node.col_offset, ends[node.end_lineno - 1] + node.end_col_offset
        return
    for number, _ in logical_lines(text.removesuffix("\n")):
        last = number
        while text[ends[last - 1] : ends[last]].partition("#")[0].rstrip().endswith("&"):
            last += 1
        yield ends[number - 1], ends[last] - text[: ends[last]].endswith("\n")


def mutants(text: str) -> Iterator[tuple[str, str]]:
    """Each statement with its change marked, and the script with it, whose lines keep their numbers."""
    for begin, end in statements(text):
        statement = text[begin:end]
        code = re.sub(r"#.*", lambda comment: " " * len(comment[0]), statement)
        if not code.strip():
            continue
        nothing = "pass" if "O.engines" in text else ""
        yield f"«{flat(code)}»", text[:begin] + nothing + "\n" * statement.count("\n") + text[end:]
        for match in (*NUMBER.finditer(code), *KEYWORD.finditer(code)):
            first, last = match.span()
            marked = flat(f"{code[:first]}«{match[0]}»{code[last:]}")
            yield marked, text[: begin + first] + other(match[0]) + text[begin + last :]


def flat(statement: str) -> str:
    return " ".join(statement.replace("&", " ").split())


def other(word: str) -> str:
    """Another number, or a misspelt word."""
    if not NUMBER.fullmatch(word):
        return f"{word}x"
    return str(int(word) + 1) if word.isdecimal() else f"{0.87 * float(word) or 0.13:.6g}"


def answer(text: str) -> object:
    try:
        return hl.check(text, speed=0.5, packing_fraction=0.1).to_dict()
    except (ValueError, SyntaxError) as error:
        return str(error)


def description(text: str) -> object:
    try:
        return read(text)
    except (ValueError, SyntaxError) as error:
        return str(error)


@pytest.mark.parametrize("name", [name if name in FEW else slow(name) for name in SCRIPTS])
def test_no_statement_is_dropped_in_silence(name, monkeypatch):
    """What the reader takes from the script changes; so does the answer, in some of the changes drawn at random."""
    stand_ins(monkeypatch)
    text = SCRIPTS[name]
    before = description(text)
    assert isinstance(before, Description), before
    changes = [change for change in mutants(text) if not HARMLESS.search(change[0])]
    silent = [marked for marked, changed in changes if description(changed) == before]
    assert changes
    assert not silent
    # Properties may be those of pairs that the script does not have; what is deleted may be the default, or hold grains
    # that do not move anyway.
    deleted = ("«O.dt = 1e-8»", "«fix hold still freeze»")
    used = [change for change in changes if "property/global" not in change[0] and change[0] not in deleted]
    drawn = random.Random(name).sample(used, min(4, len(used)))
    before = answer(text)
    assert not [marked for marked, changed in drawn if answer(changed) == before]
