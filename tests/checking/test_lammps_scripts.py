"""What is read from scripts of LAMMPS: words, variables, types, sizes, walls, stages."""

import gzip
import math

import pytest

from hardlimit.checking.scripts import read

BOX = "region box block 0 1 0 1 0 1\ncreate_box 2 box\n"
PAIR = "pair_style granular\npair_coeff * * hooke 1e5 0.5 damping coeff_restitution tangential linear_nohistory 0 0\n"
POUR = "fix ins all pour 10 1 1 region box diam one 0.02 dens 2500 2500\n"
BASE = f"units si\natom_style sphere\n{BOX}{PAIR}{POUR}"


def stage(text, **more):
    """The last stage of a script."""
    return read(text, **more).stages[-1]


def normal(text, types=("1", "1"), **more):
    """Words of the normal force of a pair of types."""
    contact = [contact for contact in stage(text, **more).contacts if contact.types == types]
    assert len(contact) == 1
    return contact[0].settings["normal"].words


def refused(text, **more):
    with pytest.raises(ValueError) as caught:
        read(text, **more)
    line = str(caught.value)
    assert "\n" not in line
    return line


# --- words and variables ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "lines,stiffness",
    [
        ("pair_coeff * * hooke 1e5 &\n 0.5\n", 1e5),
        ("pair_coeff * * hooke 1&\ne5 0.5\n", 1e5),
        ("pair_coeff\t*\t*\thooke 1e5\t0.5\r\n", 1e5),
        ("pair_coeff * * hooke 1e5 0.5 # pair_coeff * * hooke 1e6 0.5 &\n", 1e5),
        (
            "# pair_coeff * * jkr 1 1 1 1 &\npair_coeff * * hooke 9 9\npair_coeff * * hooke '1e5' \"0.5\"\n",
            1e5,
        ),
        ('print """\npair_coeff * * hooke 7 7\n"""\npair_coeff * * hooke 1e5 0.5\n', 1e5),
        ("variable k equal 1e5\npair_coeff * * hooke ${k} 0.5\n", 1e5),
        ("variable k index 1e5 2e5\npair_coeff * * hooke $k 0.5\n", 1e5),
        ("variable k string 1e5\nvariable k string 2e5\npair_coeff * * hooke $k 0.5\n", 2e5),
        ("variable k index 1e5\nvariable k index 2e5\npair_coeff * * hooke $k 0.5\n", 1e5),
        (
            "variable k equal 1e5\nvariable k equal v_k0\nvariable k0 equal 3e5\npair_coeff * * hooke $k 0.5\n",
            3e5,
        ),
        ("variable words string 'hooke 1e5 0.5'\npair_coeff * * ${words}\n", 1e5),
        ("variable a equal 5\nvariable words string 'hooke 1e${a} 0.5'\npair_coeff * * ${words}\n", 1e5),
        ("pair_coeff * * hooke $(10^5) 0.5\n", 1e5),
        ("pair_coeff * * hooke $(-2^2*25000) 0.5\n", 1e5),  # the sign binds tighter than ^
        ("pair_coeff * * hooke $(2^3^2) 0.5\n", 64.0),  # from the left
        ("pair_coeff * * hooke $(PI*1e5:%.2f) 0.5\n", 314159.27),
        ("pair_coeff * * hooke $(sqrt(16)+ln(exp(2))+log(1000)+abs(-1)) 0.5\n", 10.0),
        ("pair_coeff * * hooke $(ternary(2>1,5,6)+floor(2.7)+ceil(2.1)+round(2.5)+round(-2.5)) 0.5\n", 11.0),
        ("pair_coeff * * hooke $(1e5*(1<2 && 3!=4)) 0.5\n", 1e5),
        ("variable x equal 3\nvariable k format x %.1e\npair_coeff * * hooke $k 0.5\n", 3.0),
        ("variable k getenv HARDLIMIT_STIFFNESS\npair_coeff * * hooke $k 0.5\n", 4e5),
        ("variable i loop 3\nvariable k equal v_i*1e5\nnext i\npair_coeff * * hooke $k 0.5\n", 2e5),
        ("timestep 1e-3\npair_coeff * * hooke $(1/dt) 0.5\n", 1000.0),
    ],
)
def test_words_are_those_of_lammps(lines, stiffness, monkeypatch):
    monkeypatch.setenv("HARDLIMIT_STIFFNESS", "4e5")
    words = normal(f"{BOX}{POUR}pair_style granular\n{lines}run 1\n")
    assert words[0] == "hooke" and float(words[1]) == pytest.approx(stiffness, rel=1e-12)


def test_variables_of_the_command_line_win():
    text = f"variable e index 0.5\nvariable e equal 0.6\n{BOX}{POUR}pair_style granular\npair_coeff * * hooke 1e5 $e\n"
    assert normal(text) == ("hooke", "1e5", "0.6")
    assert normal(text, variables={"e": "0.7"}) == ("hooke", "1e5", "0.7")


def test_an_unknown_variable_is_refused_where_it_matters():
    line = refused(f"{BOX}{POUR}pair_style granular\npair_coeff * * hooke ${{k}} 0.5\nrun 1\n")
    assert line.startswith("input: line 5: got 'pair_coeff * * hooke ${k} 0.5', must ") and "--var" in line
    assert "--var" in refused(f"{BASE}timestep ${{dt}}\nrun 1\n")
    description = read(f"{BASE}dump d all atom ${{n}} d.txt\nthermo $n\nrun ${{steps}}\n")
    assert description.stages[0].steps is None and not description.unknown


def test_include_files_are_relative_to_the_script(tmp_path):
    (tmp_path / "more").mkdir()
    (tmp_path / "in.main").write_text(f"{BOX}{POUR}variable k equal 1e5\ninclude more/in.pair\nrun 5\n")
    (tmp_path / "more" / "in.pair").write_text("pair_style granular\ninclude in.coeff\n")
    (tmp_path / "more" / "in.coeff").write_text("pair_coeff * * hooke $k 0.5\n")
    description = read(tmp_path / "in.main").stages[0].contacts[0]
    assert description.settings["normal"].words == ("hooke", "100000", "0.5")
    assert description.quotes[0].file == "in.coeff" and description.quotes[0].line == 1
    (tmp_path / "more" / "in.coeff").unlink()
    assert refused(tmp_path / "in.main").startswith(
        "more/in.pair: line 2: got 'include in.coeff', must name a file"
    )
    assert "must be in a file" in refused(f"include a.in\n{PAIR}")


@pytest.mark.slow
def test_loops_and_conditions():
    text = f"""{BOX}{POUR}pair_style granular
variable k index 1e5 2e5 3e5
label again
pair_coeff * * hooke $k 0.5
run 10
next k
jump SELF again
if "2 > 1 && a == a" then "timestep 1e-4" "timestep 1e-5" else "timestep 1"
if "2 < 1" then "timestep 1" elif "a != b" "timestep 2e-5" else "timestep 3"
"""
    description = read(text.replace('"timestep 2e-5"', 'then "timestep 2e-5"') + "run 20\n").stages
    assert [stage.contacts[0].settings["normal"].words[1] for stage in description] == [
        "1e5",
        "2e5",
        "3e5",
        "3e5",
    ]
    assert [stage.time_step for stage in description] == [0.005, 0.005, 0.005, 2e-5]
    assert [stage.time_step_given for stage in description] == [False, False, False, True]
    assert [stage.steps for stage in description] == [10, 10, 10, 20]
    forever = refused(f"{BASE}label a\nrun 1\njump SELF a\n")
    assert "shorter loop" in forever and "log" in forever
    assert "label" in refused(f"{BASE}jump SELF nowhere\n")


#: A condition that only a run knows.
QUIET = 'if "${e} < 1e-6" then'
KE = f"{BASE}variable e equal ke\n"


@pytest.mark.parametrize(
    "lines,steps",
    [
        (f"{QUIET} 'print yes' else 'print no'\nrun 9\n", 9),
        (f"{QUIET} 'fix lb all balance 0 1.1 shift z 5 1.1'\nrun 9\n", 9),
        (f"{QUIET} 'undump d' 'dump d all atom 5 x' else 'thermo 7'\nrun 9\n", 9),
        (f"run 2\n{QUIET} quit\nrun 7\n", 9),
        (f"{QUIET} 'timestep 1e-8'\nrun 9\n", 9),  # as it was
        (f"{QUIET} 'fix g all gravity 1 vector 0 0 -1' 'unfix g'\nrun 9\n", 9),
        (f"label a\nrun 4\n{QUIET} 'jump SELF b'\njump SELF a\nlabel b\nrun 1\n", 9),
        (f"label a\nrun 9\n{QUIET} quit\njump SELF a\n", 18),
        (
            f"variable i loop 2\nlabel a\nrun 4\n{QUIET} 'jump SELF b'\nnext i\njump SELF a\nlabel b\nrun 1\n",
            9,
        ),
        (f"run 4\n{QUIET} 'run 4'\nrun 5\n", None),
        (
            f"{QUIET} 'variable k equal 1e5' else 'variable k equal 1e5'\npair_coeff * * hooke $k 0.5\nrun 9\n",
            9,
        ),
    ],
)
def test_conditions_that_only_a_run_knows_and_that_touch_no_contact(lines, steps):
    description = read(KE + lines)
    assert (
        [stage.steps for stage in description.stages] == [steps]
        and not description.unknown
        and not description.invalidates
    )
    assert description.stages[0].contacts and description.stages[0].time_step == 1e-8


@pytest.mark.parametrize(
    "branch,what",
    [
        ("'timestep 1e-6'", "the time step"),
        ("'timestep 1e-6' else 'timestep 1e-5'", "the time step"),
        ("'pair_coeff 1 1 hooke 2e5 .5'", "contacts"),
        ("'fix g all gravity 9.81 vector 0 0 -1'", "gravity"),
        ("'fix p all pour 9 1 1 region box diam one 0.04 dens 2500 2500'", "grains"),
        ("'fix w all wall/gran granular hooke 1 .5 zplane 0 NULL'", "contacts"),
        ("'fix v all viscous 1'", "viscous drag (viscous)"),
        ("'fix d all deform 1 xy erate 0.1'", "what drives the grains"),
        ("'fix d all deform 1 x erate -0.1'", "pressure"),
        ("'jump SELF far'\ntimestep 1e-6\nlabel far", "the time step"),
        ("'jump SELF far'\nfix v all viscous 1\nlabel far", "viscous drag (viscous)"),
        ("'include more.in'", "the time step"),
    ],
)
def test_branches_that_differ_are_quoted(branch, what, tmp_path):
    """What may be one or the other is not known; the rest is as without the condition."""
    (tmp_path / "more.in").write_text("timestep 1e-6\n")
    (tmp_path / "in.main").write_text(f"{KE}run 5\n{QUIET} {branch}\nrun 7\n")
    description = read(tmp_path / "in.main")
    before, after = description.stages[0], description.stages[-1]
    (quote,) = description.unknown
    assert not after.pressed and not after.driven and after.shear_rate is None
    assert quote.line == 10 and f"branches differ in {what}" in quote.text and not description.invalidates
    assert (after.time_step is None) == (what == "the time step")
    pairs = [contact for contact in after.contacts if not contact.wall]
    assert (pairs == list(before.contacts)) == ("pair_coeff" not in branch) and after.gravity is None
    assert len(pairs) == len(after.contacts)
    assert (after.grains["1"].radii == (0.01, 0.01)) == (what != "grains")
    assert before.contacts and before.time_step == 1e-8 and before.grains["1"].radii == (0.01, 0.01)


def test_what_a_condition_leaves_unknown_is_refused_where_it_matters():
    lines = (
        f"{QUIET} 'variable k equal 1e5' else 'variable k equal 2e5'\npair_coeff * * hooke $k 0.5\nrun 1\n"
    )
    assert "values for k: give them with --var" in refused(KE + lines)
    rounds = "variable k equal 1e5\nlabel a\npair_coeff * * hooke $k 0.5\nrun 5\nvariable k equal 2*$k\n"
    assert "values for k" in refused(f"{KE}{rounds}{QUIET} 'jump SELF a'\nrun 1\n")
    counted = f"variable n equal 0\nlabel a\nrun 5\nvariable n equal $n+1\n{QUIET} 'jump SELF a'\nrun 1\n"
    assert read(KE + counted).stages[0].contacts
    jumps = f"{QUIET} 'jump SELF b'\nrun 5\nquit\nlabel b\ntimestep 3\nrun 6\n"
    assert "give the log" in refused(KE + jumps)
    assert "values for mode" in refused(f"{BASE}if '${{mode}} == x' then 'timestep 1e-6'\nrun 1\n")


def test_all_variables_without_a_value_are_named():
    lines = "variable kn equal 2*v_k\npair_coeff * * hooke ${kn} $e\ntimestep ${dt}\n"
    lines += (
        "fix w all wall/gran granular hooke ${kw} 0.5 zplane 0 NULL\nfix g all gravity ${g} vector 0 0 -1\n"
    )
    line = refused(f"{BASE}{lines}dump d all atom ${{n}} x\nrun ${{steps}}\n")
    assert (
        line.startswith("input: line 9: ") and "values for k, e, dt, kw and g: give them with --var" in line
    )
    assert "values for dt and file: " in refused(
        f"{BASE}timestep ${{dt}}\ninclude ${{file}}\ntimestep ${{x}}\n"
    )
    values = {"k": "1e5", "e": "0.5", "dt": "1e-5", "kw": "1", "g": "9.8"}
    assert read(f"{BASE}{lines}run 1\n", variables=values).stages[0].gravity == 9.8


def test_commands_inside_a_run_and_of_some_partitions():
    description = read(f"{BASE}run 100 every 10 'print x' 'variable y equal ke'\n")
    assert [(stage.time_step, stage.steps) for stage in description.stages] == [(1e-8, 100)]
    description = read(f"{BASE}run 100 every 10 'timestep 1e-6'\nrun 5\n")
    assert [(stage.time_step, stage.steps) for stage in description.stages] == [(1e-8, 10), (1e-6, None)]
    assert not read(f"{BASE}run 100 every 10 \"if '$(ke) < 1' then quit\"\nrun 5\n").unknown


@pytest.mark.parametrize(
    "number,runs", [("1", True), ("*", True), ("*3", True), ("1*2", True), ("2", False), ("2*", False)]
)
def test_several_partitions_are_read_as_the_first_one(number, runs):
    """LIGGGHTS itself runs these commands if it has one partition."""
    for style in ("yes", "no"):
        description = read(f"{BASE}partition {style} {number} timestep 1e-6\nrun 5\n")
        assert description.stages[0].time_step == (1e-6 if runs == (style == "yes") else 1e-8)
        assert not description.unknown and "as the first one runs it" in description.warnings[0].what
    nested = "partition yes 1 " * 30
    assert "nested less deeply" in refused(f"{BASE}{nested}timestep 1e-6\nrun 5\n")


def test_values_of_partitions():
    """The first partition has the first value of world; one alone takes all those of universe, one after another."""
    text = f"variable s world 1e-6 2e-6\n{BASE}fix move all nve/sphere\ntimestep $s\nrun 5\n"
    (own,) = read(text).warnings
    assert stage(text).time_step == 1e-6 and own.quote.text == "variable s world 1e-6 2e-6"
    stated = read(text, variables={"s": "2e-6"})
    assert stated.stages[0].time_step == 2e-6 and not stated.warnings
    assert not read(text.replace("world 1e-6 2e-6", "world 1e-6")).warnings
    for style in ("universe 1e-6 2e-6", "index 1e-6 2e-6"):
        loop = f"variable s {style}\n{BASE}label a\ntimestep $s\nrun 5\nnext s\njump SELF a\n"
        assert [each.time_step for each in read(loop).stages] == [1e-6, 2e-6]
    counted = read(f"variable k uloop 3\n{BASE}label a\ntimestep ${{k}}e-6\nrun 5\nnext k\njump SELF a\n")
    assert [each.time_step for each in counted.stages] == [1e-6, 2e-6, 3e-6]


@pytest.mark.parametrize(
    "region,wall,moves",
    [
        ("block 0 1 0 1 0 v_top", "region piston", True),
        ("block 0 1 0 1 0 1 move NULL NULL v_top", "region piston", True),
        ("cylinder z 0 0 v_top 0 1", "region piston", True),
        ("block 0 1 0 1 0 v_fixed", "region piston", False),
        ("block 0 1 0 1 0 1", "region piston", False),
        ("block 0 1 0 1 0 1", "zplane 0 v_top", True),
        ("block 0 1 0 1 0 1", "zplane v_fixed NULL", False),
    ],
)
def test_walls_that_move_by_a_variable(region, wall, moves):
    lines = f"variable top equal ramp(1,0.5)\nvariable fixed equal 2*3\nregion piston {region}\n"
    description = read(f"{BASE}{lines}fix w all wall/gran/region granular hooke 1 .5 {wall}\nrun 1\n")
    assert any("moving wall" in note.what for note in description.ignored) == moves
    assert [stage.wall for stage in description.stages[0].contacts] == [None, "w"]


ROUNDS = 100_000
LOOP = f"""{BASE}variable i loop {ROUNDS}
label again
{{}}
run 10
next i
jump SELF again
run 7
"""


@pytest.mark.parametrize(
    "body,steps",
    [
        ("", [10 * ROUNDS + 7]),
        ("fix b all deform 1 x erate -1", [10 * ROUNDS + 7]),
        ("print $i\nset group all property/atom q 1", [10 * ROUNDS + 7]),
        ("variable f equal v_i\nthermo_style custom step v_f", [10 * ROUNDS + 7]),
        ("timestep 1e-6\nrun 5\ntimestep 1e-7", [5, 10] * 3 + [5 * (ROUNDS - 4), 10 * (ROUNDS - 4), 5, 17]),
    ],
)
def test_equal_rounds_of_a_long_loop_are_read_once(body, steps):
    """They would be more commands than are read at most, 10⁶, or take seconds."""
    description = read(LOOP.format(body))
    assert [stage.steps for stage in description.stages] == steps
    assert sum(steps) == 10 * ROUNDS + 7 + (5 * ROUNDS if "run" in body else 0)


@pytest.mark.parametrize(
    "body,steps,radii",
    [
        ("timestep (1+$i)*1e-6", None, None),
        ("timestep $(v_i*1e-6)", 40, (0.01, 0.01)),
        ("variable s equal v_i*1e-6\nvariable t equal v_s\ntimestep $t", 40, (0.01, 0.01)),
        ("if '$i == 33' then 'timestep 1e-6'", 2, (0.01, 0.01)),
        ("run 9 every 3 'timestep 1e-6'", 2, (0.01, 0.01)),
        ("if '$i == 33' then 'set group all diameter 0.03'", 2, (0.015, 0.015)),
        ("set group all diameter $(v_i*0.001)", 40, (0.02, 0.02)),
        ("fix g all gravity v_h chute 0\nvariable h equal v_i", 40, (0.01, 0.01)),
        ("fix ins all pour 1 1 $i region box diam one 0.02 dens 2500 2500", 1, (0.01, 0.01)),
    ],
)
def test_rounds_that_differ_are_read_one_by_one(body, steps, radii):
    text = LOOP.format(body).replace(str(ROUNDS), "40")
    if steps is None:
        refused(text)
        return
    description = read(text)
    assert len(description.stages) == steps and description.stages[-1].grains["1"].radii == radii
    counted = [stage.contents.count for stage in description.stages[-1:]]
    assert "pour 1 1" not in body or counted == [50.0]
    assert "every" not in body or description.stages[0].steps == 3


@pytest.mark.slow
def test_long_loops():
    text = f"""{KE}variable i loop 2000
label again
variable seed equal 1000+$i
variable d equal 0.04-0.02*(v_i<1999)
fix ins all pour 10 1 ${{seed}} region box diam one $d dens 2500 2500
run 10
unfix ins
{QUIET} 'jump SELF done'
print "again"
thermo 10
next i
jump SELF again
label done
run 10
"""
    description = read(text)
    assert sum(stage.steps for stage in description.stages) == 20_010
    # The loop may end before its last round.
    assert [stage.grains["1"].radii for stage in description.stages] == [(0.01, 0.01), (0.01, 0.02), None]


# --- pairs ------------------------------------------------------------------------------------------------------

#: A box with grains of four types.
FOUR_TYPES = """region box block 0 1 0 1 0 1
create_box 4 box
create_atoms 1 box
create_atoms 2 box
create_atoms 3 box
create_atoms 4 box
"""


def test_wildcards_and_overrides():
    text = f"""{FOUR_TYPES}pair_style granular
pair_coeff * * hooke 1 0.1
pair_coeff 1*2 3* hooke 2 0.2
pair_coeff 3 2 hooke 3 0.3
pair_coeff *2 *2 hooke 4 0.4
pair_coeff 4 * hooke 5 0.5
run 1
"""
    expected = {
        "11": "4",
        "12": "4",
        "13": "2",
        "14": "2",
        "22": "4",
        "23": "3",
        "24": "2",
        "33": "1",
        "34": "1",
    }
    for pair, stiffness in {**expected, "44": "5"}.items():
        assert normal(text, tuple(pair))[1] == stiffness, pair


def test_wildcards_hold_for_types_that_are_not_known_yet(tmp_path):
    """LAMMPS knows all types from the file; ε of 1–2 is that of the first line, not the mean of 0.5 and 0.9."""
    pairs = "pair_style granular\npair_coeff * * hooke 1e5 0.5 damping coeff_restitution\n"
    second = "pair_coeff 2 2 hooke 1e5 0.9 damping coeff_restitution\n"
    for source in ("read_restart old", "read_data none"):
        text = f"units si\natom_style sphere\n{source}\n{pairs}{second}run 1\n"
        assert normal(text, ("1", "2"))[2] == "0.5" and normal(text, ("2", "2"))[2] == "0.9"
    (tmp_path / "one.data").write_text("\n1 atoms\n1 atom types\n\nAtoms\n\n1 1 0.02 2500 0.5 0.5 0.5\n")
    reads = "units si\natom_style sphere\nread_data one.data extra/atom/types 1\n"
    (tmp_path / "in.more").write_text(
        f"{reads}{pairs}create_atoms 2 single 0.1 0.1 0.1\nset type 2 diameter 0.01\nrun 1\n"
    )
    types = [stage.types for stage in read(tmp_path / "in.more").stages[-1].contacts]
    assert types == [("1", "1"), ("1", "2"), ("2", "2")]


def test_adhesion_concerns_the_types_of_its_line():
    """Also types that only this line makes known."""
    head = "units si\natom_style sphere\nread_restart old\npair_style granular\n"
    for pair, types in (("3 3", ("3",)), ("1 2", ("1", "2"))):
        text = f"{head}pair_coeff {pair} jkr 1e5 0.1 0.3 1 damping viscoelastic\nrun 1\n"
        assert [note.types for note in read(text).invalidates] == [types]


@pytest.mark.parametrize("model", ["jkr", "dmt"])
def test_adhesion_whose_constant_is_0_is_none(model):
    """A force of Hertz then, also between two types, one of which has a constant."""
    head = f"{BOX}create_atoms 1 box\ncreate_atoms 2 box\npair_style granular\n"
    numbers = "damping velocity tangential none"
    text = f"{head}pair_coeff 1 1 {model} 1e6 4 0.3 0.0 {numbers}\npair_coeff 2 2 {model} 3e6 9 0.2 7 {numbers}\n"
    wall = f"fix w all wall/gran granular {model} 1e6 4 0.3 0 {numbers} zplane 0 NULL\n"
    description = read(f"{text}{wall}run 1\n")
    contacts = {(stage.types, stage.wall): stage for stage in description.stages[0].contacts}
    material = ("hertz/material", "1e6", "4", "0.3")
    for ends in ((("1", "1"), None), (("1", "wall"), "w"), (("2", "wall"), "w")):
        assert contacts[ends].settings["normal"].words == material and not contacts[ends].adhesion
    modulus = 1.0 / ((1.0 - 0.09) / 1e6 + (1.0 - 0.04) / 3e6)
    words = contacts[("1", "2"), None].settings["normal"].words
    assert words[0] == "hertz" and [float(x) for x in words[1:]] == pytest.approx([4.0 / 3.0 * modulus, 6.0])
    assert [contact.types for contact in contacts.values() if contact.adhesion] == [("2", "2")]
    assert [(note.what, note.types) for note in description.invalidates] == [(f"adhesion ({model})", ("2",))]
    later = read(f"{text}pair_coeff * * hooke 1e5 4 {numbers}\nrun 1\n")
    assert not later.invalidates  # a later line overrides an earlier one


def test_mixing_is_that_of_lammps():
    """Geometric means; moduli in series."""
    both = f"{BOX}create_atoms 1 box\ncreate_atoms 2 box\npair_style granular\n"
    mixed = normal(f"{both}pair_coeff 1 1 hooke 1e4 0.4\npair_coeff 2 2 hooke 4e4 0.9\nrun 1\n", ("1", "2"))
    assert mixed[0] == "hooke" and [float(x) for x in mixed[1:]] == pytest.approx([2e4, 0.6])
    text = f"{both}pair_coeff 1 1 hertz/material 1e6 0.4 0.3\npair_coeff 2 2 hertz/material 3e6 0.9 0.2 limit_damping\n"
    pair = next(contact for contact in stage(f"{text}run 1\n").contacts if contact.types == ("1", "2"))
    modulus = 1.0 / ((1.0 - 0.09) / 1e6 + (1.0 - 0.04) / 3e6)
    words = pair.settings["normal"].words
    assert words[0] == "hertz" and [float(x) for x in words[1:]] == pytest.approx([4.0 / 3.0 * modulus, 0.6])
    assert "limit_damping" in pair.settings and len(pair.quotes) == 2
    own = f"{text}pair_coeff 1 2 hertz/material 5e6 0.5 0.3\nrun 1\n"
    assert normal(own, ("1", "2")) == ("hertz/material", "5e6", "0.5", "0.3")
    differ = read(f"{both}pair_coeff 1 1 hooke 1 0.4\npair_coeff 2 2 hertz 1 0.9\nrun 1\n")
    assert [stage.types for stage in differ.stages[0].contacts] == [("1", "1"), ("2", "2")] and len(
        differ.unknown
    ) == 2


def test_defaults_that_carry_physics():
    """Without the keyword damping, the second number is no ε."""
    stage_now = stage(
        f"{BOX}{POUR}pair_style granular\npair_coeff * * hertz/material 1e9 0.7 0.3\nrun 1\n"
    ).contacts[0]
    assert stage_now.settings["damping"].words == ("viscoelastic",)
    stage_now = stage(
        f"{BOX}{POUR}pair_style gran/hooke/history/omp 1e5 NULL 50 NULL 0.5 1 limit_damping\nrun 1\n"
    )
    settings = stage_now.contacts[0].settings
    assert settings["normal"].words == ("gran/hooke", "1e5", "50") and settings["limit_damping"].words == ()


def test_hybrid_styles():
    text = f"""{BOX}create_atoms 1 box
create_atoms 2 box
pair_style hybrid granular gran/hooke 7 NULL 8 NULL 0.5 1 lj/cut 2.5
pair_coeff 1 1 granular hooke 1e5 0.5 damping velocity
pair_coeff 2 2 gran/hooke
pair_coeff 1 2 lj/cut 1.0 1.0
run 1
"""
    description = read(text)
    assert normal(text)[1] == "1e5" and normal(text, ("2", "2")) == ("gran/hooke", "7", "8")
    assert len(description.stages[0].contacts) == 2 and "lj/cut" in description.invalidates[0].what


def test_units_and_their_time_steps():
    steps = {"lj": 0.005, "real": 1.0, "metal": 0.001, "si": 1e-8, "cgs": 1e-8, "electron": 0.001}
    for units, step in {**steps, "micro": 2.0, "nano": 4.5e-4}.items():
        description = read(f"units {units}\n{BOX}{PAIR}{POUR}run 1\n")
        assert (description.stages[0].units, description.stages[0].units_given) == (units, True)
        assert (description.stages[0].time_step, description.stages[0].time_step_given) == (step, False)
    description = read(f"{BOX}{PAIR}{POUR}timestep 0.1\nrun 1\n")
    last = description.stages[0]
    assert (last.units, last.units_given, last.time_step) == ("lj", False, 0.1)


def test_units_reset_the_time_step():
    """As LAMMPS warns: "Changing timestep from … due to changing units"."""
    description = read(f"timestep 1e-5\nunits si\n{BOX}{PAIR}{POUR}run 1\n")
    assert (description.stages[0].time_step, description.stages[0].time_step_given) == (1e-8, False)


def test_styles_of_the_run():
    assert not read(f"{BASE}run_style verlet\nrun 1\n").unknown
    assert len(read(f"{BASE}run_style respa 2 2 inner 1 outer 2\nrun 1\n").unknown) == 1


# --- grains -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "lines,radii,densities,masses",
    [
        ("fix i all pour 9 1 1 region box", (0.5, 0.5), (1.0, 1.0), None),
        ("fix i all pour 9 1 1 region box diam one 0.02 dens 1 2", (0.01, 0.01), (1.0, 2.0), None),
        ("fix i all pour 9 1 1 diam range 0.02 0.06 region box dens 3 3", (0.01, 0.03), (3.0, 3.0), None),
        (
            "fix i all pour 9 1 1 diam poly 3 .02 .5 .06 .2 .04 .3 region box dens 3 3",
            (0.01, 0.03),
            (3.0, 3.0),
            None,
        ),
        ("create_atoms 1 box", (0.5, 0.5), (1.0, 1.0), None),
        ("create_atoms 1 box\nset type 1 diameter 0.2 density 5", (0.1, 0.1), (5.0, 5.0), None),
        (
            "create_atoms 1 box\nset type 1 diameter 0.2",
            (0.1, 0.1),
            None,
            (math.pi / 6.0,) * 2,
        ),  # keeps its mass
        ("create_atoms 1 box\nset type * mass 3 diameter 0.2", (0.1, 0.1), None, (3.0, 3.0)),
        (
            "create_atoms 1 box\nset atom * diameter 0.2 density/disc 5",
            (0.1, 0.1),
            None,
            (0.05 * math.pi,) * 2,
        ),
        ("create_atoms 1 box\nset group all diameter 0.2 density 5", (0.1, 0.1), (5.0, 5.0), None),
        ("create_atoms 1 box\nset atom 7 diameter 0.2 density 5", (0.1, 0.5), (1.0, 5.0), None),
        ("create_atoms 1 box\nset region half diameter v_d density 5", None, (1.0, 5.0), None),
        (
            "create_atoms 1 box\nvariable d equal 2/10\nset type 1 diameter v_d density 5",
            (0.1, 0.1),
            (5.0, 5.0),
            None,
        ),
        ("read_data missing.data", None, None, None),
        ("read_restart old", None, None, None),
    ],
)
def test_sizes(lines, radii, densities, masses):
    grains = stage(f"{BOX}{PAIR}{lines}\nrun 1\n").grains["1"]
    for here, expected in ((grains.radii, radii), (grains.densities, densities), (grains.masses, masses)):
        assert here == (None if expected is None else pytest.approx(expected))


def test_sizes_of_several_types():
    text = f"""{BOX}{PAIR}create_atoms 1 box
group small type 1
set group all type/fraction 2 0.5 7
set type 1 diameter 0.2 density 5
set type 2 diameter 0.4 density 6
fix i all pour 9 2 1 diam range 0.3 0.9 region box dens 7 7
run 1
"""
    grains = stage(text).grains
    assert grains["1"].radii == (0.1, 0.1) and grains["2"].radii == (0.15, 0.45)
    assert grains["2"].densities == (6.0, 7.0)
    assert list(stage(f"{BOX}{PAIR}create_atoms 1 box\nset type 1 type 2\nrun 1\n").grains) == ["2"]


def test_data_files(tmp_path):
    (tmp_path / "grains.data").write_text("""grains

4 atoms
2 atom types

0 1 xlo xhi

Atoms # sphere

1 1 0.02 2500 0 0 0
2 1 0.04 2600 0 0 0
3 2 0.5 1000 0 0 0  # large
4 2 0.5 1000 0 0 0 0 0 0

Velocities

1 1 1 1 0 0 0
""")
    script = tmp_path / "in.data"
    script.write_text(f"atom_style sphere\nread_data grains.data\n{PAIR}run 1\n")
    grains = read(script).stages[0].grains
    assert grains["1"].radii == (0.01, 0.02) and grains["1"].densities == (2500.0, 2600.0)
    assert grains["2"].radii == (0.25, 0.25)
    packed = gzip.compress((tmp_path / "grains.data").read_bytes())
    (tmp_path / "grains.data.gz").write_bytes(packed)
    script.write_text(f"atom_style sphere\nread_data grains.data.gz\n{PAIR}run 1\n")
    assert read(script).stages[0].grains == grains
    (tmp_path / "grains.data.gz").write_bytes(packed[:40])
    assert read(script).stages[0].grains["1"].radii is None and len(read(script).unknown) == 1
    script.write_text(f"atom_style hybrid sphere charge\nread_data grains.data\n{PAIR}run 1\n")
    (tmp_path / "grains.data").write_text(
        (tmp_path / "grains.data").read_text().replace("# sphere", "# hybrid")
    )
    description = read(script)
    assert description.stages[0].grains["1"].radii is None and len(description.unknown) == 1


def test_data_files_that_are_added(tmp_path):
    (tmp_path / "one.data").write_text("\n1 atoms\n2 atom types\n\nAtoms\n\n1 1 0.02 2500 0.5 0.5 0.5\n")
    script = tmp_path / "in.more"
    reads = "read_data one.data extra/atom/types 1\nread_data one.data add append offset 2 0 0 0 0\n"
    script.write_text(f"units si\natom_style sphere\n{reads}{PAIR}run 1\n")
    assert list(read(script).stages[0].grains) == ["1", "3"]
    with (tmp_path / "one.data").open("a") as file:
        file.write("\nPairIJ Coeffs # granular\n\n1 1 hooke 1e5 0.5\n")
    assert [quote.text.partition(" (")[2] for quote in read(script).unknown] == [
        "its pair coefficients are not read)"
    ] * 2


def test_pairs_that_are_excluded_and_grains_that_are_deleted():
    text = f"{FOUR_TYPES}group a type 3 4\npair_style gran/hooke 1 NULL 1 NULL 0 0\n{{}}\nrun 1\n"

    def pairs(line):
        return ["".join(contact.types) for contact in stage(text.format(line)).contacts]

    every = ["11", "12", "13", "14", "22", "23", "24", "33", "34", "44"]
    assert pairs("neigh_modify delay 0") == every
    assert pairs("neigh_modify every 1 exclude type 2 1 exclude type 4 4") == [
        pair for pair in every if pair not in ("12", "44")
    ]
    assert pairs("neigh_modify exclude group a a") == [
        pair for pair in every if pair not in ("33", "34", "44")
    ]
    assert pairs("neigh_modify exclude group a a\nneigh_modify exclude none") == every
    assert pairs("delete_atoms group a") == ["11", "12", "22"]
    assert pairs("region r block 0 1 0 1 0 1\ndelete_atoms region r") == every


def test_molecules(tmp_path):
    (tmp_path / "pair.mol").write_text("two\n\n2 atoms\n\nTypes\n\n1 1\n2 2\n\nDiameters\n\n1 0.2\n2 0.4\n")
    script = tmp_path / "in.mol"
    lines = "molecule m pair.mol\nfix r all rigid/small molecule mol m\nfix i all pour 5 0 1 region box mol m rigid r\n"
    script.write_text(f"{BOX}{PAIR}{lines}run 1\n")
    description = read(script)
    assert {kind: stage.radii for kind, stage in description.stages[0].grains.items()} == {
        "1": (0.1, 0.1),
        "2": (0.2, 0.2),
    }
    assert any("clumps" in finding.what for finding in description.invalidates)


def test_frozen_grains():
    text = f"""{BOX}{PAIR}create_atoms 1 box
create_atoms 2 box
group floor type 2
group mobile subtract all floor
{{}}
run 1
"""
    for lines in ("fix 1 all nve/sphere\nfix 2 floor freeze", "fix 1 mobile nve/sphere"):
        grains = stage(text.format(lines)).grains
        assert (grains["1"].frozen, grains["2"].frozen) == (False, True)
    for lines in ("fix 1 all nve/sphere", "group some id 1 2\nfix 1 all nve\nfix 2 some freeze", ""):
        assert not any(grains.frozen for grains in stage(text.format(lines)).grains.values())
    for lines, counted in (
        ("fix 1 all nve/sphere\nfix 2 floor freeze", False),
        ("fix 1 mobile nve/sphere", True),
        ("fix 1 mobile nve/sphere\nfix 2 floor nve/noforce", True),
        ("fix 1 mobile nve/sphere\nfix 2 floor move linear 1 0 0", True),
        ("fix 1 all nve/sphere\nfix 2 floor setforce 0 0.0 0", True),
    ):
        floor = stage(text.format(lines)).grains["2"]
        assert floor.frozen and floor.counted is counted
    assert not stage(text.format("fix 1 all nve\nfix 2 floor setforce NULL NULL 0")).grains["2"].frozen


def test_set_changes_the_grains_with_these_numbers():
    text = f"{BOX}{PAIR}create_atoms 1 single 0 0 0\ncreate_atoms 1 single 0 0 .5\ncreate_atoms 2 single 0 .5 .5\n"
    for lines, first, second in (
        ("set atom 1 diameter .2\nset atom 2 diameter .4", (0.1, 0.2), (0.5, 0.5)),
        ("set atom 1*2 diameter .2", (0.1, 0.1), (0.5, 0.5)),
        ("set atom 2* diameter .2", (0.1, 0.5), (0.1, 0.1)),
        ("set atom * diameter .2", (0.1, 0.1), (0.1, 0.1)),
        ("set atom 2 type 2\nset type 1 diameter .2", (0.1, 0.1), (0.5, 0.5)),
        ("create_atoms 1 box\nset atom 1*4 diameter .2", (0.1, 0.5), (0.1, 0.1)),
    ):
        grains = stage(f"{text}{lines}\nrun 1\n").grains
        assert (grains["1"].radii, grains["2"].radii) == (first, second), lines


@pytest.mark.parametrize(
    "words,understood",
    [
        ("densty 2500", False),
        ("diameter/fraction 0.1 0.5 7", False),
        ("diameter 0.1 densty 2500", False),
        ("diameter", False),
        ("type/fraction 2 1.5 7", False),
        ("density 2500 vx 1 vy 2 mol 3 image 0 1 0 quat 1 0 0 90 d_own 3 i2_more[2] 4", True),
        ("omega 1 2 3 type/fraction 2 0.5 7 diameter 0.1", True),
    ],
)
def test_all_words_of_set_are_understood_or_quoted(words, understood):
    line = f"set type 1 {words}"
    description = read(f"{BOX}{PAIR}create_atoms 1 box\n{line}\nrun 1\n")
    assert [quote.text.startswith(line) for quote in description.unknown] == [True] * (not understood)


def test_fractions_of_types():
    """All, none or some of the grains become another type."""
    text = f"{BOX}{PAIR}create_atoms 1 box\nset type 1 {{}}\nrun 1\n"
    for words, types in (
        ("type/fraction 2 0.5 7", "12"),
        ("type/fraction 2 1.0 7", "2"),
        ("type/fraction 2 0 7", "1"),
        ("type/ratio 2 1 7", "2"),
        ("type/subset 2 0 7", "1"),
        ("type/subset 2 9 7", "12"),
    ):
        assert "".join(stage(text.format(words)).grains) == types, words


def test_files_that_cannot_be_read_say_why(tmp_path):
    script = tmp_path / "in.data"
    (tmp_path / "molecular.data").write_text("\n1 atoms\n\nAtoms # full\n\n1 1 1 0 0 0 0\n")
    for line, why in (
        ("read_data none.data", "cannot be opened"),
        ("read_data molecular.data", "only atom style sphere is read"),
        ("read_restart old", "such files are not read"),
    ):
        script.write_text(f"atom_style sphere\n{line}\n{PAIR}run 1\n")
        assert [quote.text for quote in read(script).unknown] == [f"{line} ({why})"]
    (quote,) = read(f"read_data none.data\n{PAIR}run 1\n").unknown
    assert "give the script as a file" in quote.text


def test_no_damping():
    words = normal(
        f"{BOX}pair_style granular\npair_coeff * * hertz 1e5 0.5 damping none tangential none\nrun 1\n"
    )
    assert words == ("hertz", "1e5", "0")


# --- walls, stages, notes ---------------------------------------------------------------------------------------


def test_walls_have_their_own_numbers():
    text = f"""{BASE}create_atoms 2 box
group big type 2
fix w1 all wall/gran hertz/history 7 NULL 8 NULL 0.5 1 limit_damping zplane 0 NULL
fix w2 big wall/gran granular hooke 9 0.9 damping coeff_restitution tangential none zcylinder 0.5 wiggle z 1 2
fix w3 all wall/gran/region granular hertz/material 1e6 0.9 0.3 region drum contacts
run 1
unfix w2
run 1
"""
    text = "region blade block 0 1 0 1 0 1 rotate v_t 0 0 0 0 0 1\nregion drum intersect 2 box blade\n" + text
    description = read(text)
    first, second = description.stages
    walls = [
        (contact.types, contact.wall, contact.settings["normal"].words[0])
        for contact in first.contacts
        if contact.wall
    ]
    assert walls == [
        (("1", "wall"), "w1", "gran/hertz"),
        (("2", "wall"), "w1", "gran/hertz"),
        (("2", "wall"), "w2", "hooke"),
        (("1", "wall"), "w3", "hertz/material"),
        (("2", "wall"), "w3", "hertz/material"),
    ]
    assert {contact.wall for contact in second.contacts if contact.wall} == {"w1", "w3"}
    said = " ".join(note.what for note in description.ignored)
    assert (
        "curvature" in said
        and "moving wall (wiggle)" in said
        and "moving wall (region)" in said
        and "tangential" in said
    )


def test_settings_that_change_are_stages():
    text = f"{BASE}timestep 1e-5\nrun 100\nunfix ins\nrun 100\ntimestep 2e-5\nrun 7\nrun 1000 upto\nclear\n"
    description = read(text).stages
    assert [(stage.time_step, stage.steps) for stage in description] == [(1e-5, 200), (2e-5, 800)]
    again = read(text + BASE.replace("1e5", "3e5") + "run 5\n").stages
    assert len(again) == 3 and again[2].contacts[0].settings["normal"].words[1] == "3e5"
    assert again[2].time_step == 1e-8


def test_groups():
    """A wall acts on the types of its group."""
    text = f"""{FOUR_TYPES}group a type 1
group b type 2:3
group c type > 3
group d union a c
group e subtract all a b
group f intersect b all
group g type <> 2 3
group h empty
group a type 3
pair_style gran/hooke 1 NULL 1 NULL 0 0
"""
    for name, types in {
        "a": "13",
        "b": "23",
        "c": "4",
        "d": "14",
        "e": "4",
        "f": "23",
        "g": "23",
        "h": "",
    }.items():
        contact = stage(
            f"{text}fix w {name} wall/gran hooke 1 NULL 1 NULL 0 0 zplane 0 NULL\nrun 1\n"
        ).contacts
        assert "".join(contact.types[0] for contact in contact if contact.wall) == types, name


def test_a_group_that_is_not_defined_is_quoted():
    (quote,) = read(f"{BASE}fix 1 grains nve/sphere\nrun 1\n").unknown
    assert quote.text == "fix 1 grains nve/sphere (the group grains is not defined)"
    assert not read(f"{BASE}group grains region box\nfix 1 grains nve/sphere\nrun 1\n").unknown


def test_labels_of_types():
    text = (
        f"{BOX}labelmap atom 1 sand 2 glass\ncreate_atoms sand box\ncreate_atoms 2 box\npair_style granular\n"
    )
    text += "pair_coeff sand sand hooke 1 0.1\npair_coeff sand glass hooke 2 0.2\nset type glass diameter 0.2\nrun 1\n"
    assert normal(text)[1] == "1" and normal(text, ("1", "2"))[1] == "2"
    assert stage(text).grains["2"].radii == (0.1, 0.1)


def test_time_steps_that_adapt():
    description = read(
        f"{BASE}timestep 1e-6\nfix d all dt/reset 10 NULL 1e-6 0.1\nrun 1\nreset_timestep 0\nrun 5 upto\n"
    )
    assert [(stage.time_step, stage.steps) for stage in description.stages] == [(None, 6)]
    assert any("adapts" in note.what for note in description.ignored)


def test_gravity_dimension_and_steps():
    text = f"dimension 2\n{BOX}{PAIR}{POUR}fix g all gravity 9.81 vector 0 -1 0\nrun 10\n"
    description = read(text)
    assert (
        description.stages[0].dimension == 2
        and description.stages[0].gravity == 9.81
        and description.stages[0].numerical_damping is None
    )
    assert read(f"{BASE}run 10\n").stages[0].gravity is None


@pytest.mark.parametrize(
    "lines,expected",
    [
        ("fix a all gravity 3 vector 1 0 0\nfix b all gravity 4 vector 0 -1 0", (5.0, (0.6, -0.8, 0.0))),
        ("fix a all gravity 3 vector 0 0 -1\nfix b all gravity 3 vector 0 0 1", (None, None)),
        ("fix a one gravity 3 vector 0 0 -1\nfix b two gravity 3 vector 0 0 -1", (3.0, (0.0, 0.0, -1.0))),
        (
            "fix a one gravity 3 vector 0 0 -1\nfix b two gravity 4 vector 0 0 -1",
            "fix b two gravity 4 vector 0 0 -1",
        ),
        (
            "fix a one gravity 3 vector 0 0 -1\nfix b all gravity 3 vector 0 0 -1",
            "fix b all gravity 3 vector 0 0 -1",
        ),
        (
            "variable g equal ramp(0,9.81)\nfix a all gravity 3 vector 0 0 -1\nfix b all gravity v_g vector 0 0 -1",
            "fix b all gravity v_g vector 0 0 -1",
        ),
    ],
)
def test_several_gravities_add_up(lines, expected):
    """Unless they act on different grains: then one that differs is quoted."""
    description = read(f"{BASE}group one type 1\ngroup two type 2\n{lines}\nrun 10\n")
    if isinstance(expected, str):
        assert [quote.text for quote in description.unknown] == [expected]
    else:
        stage = description.stages[0]
        assert not description.unknown
        assert stage.gravity == pytest.approx(expected[0]) and stage.down == pytest.approx(expected[1])


@pytest.mark.parametrize(
    "line,what",
    [
        ("fix v all viscous 0.1", "viscous drag"),
        ("fix v all damping/cundall 0.8 0.8", "damping beside contacts"),
        ("fix v all langevin 1 2 1 7", "thermostat"),
        ("fix v all rigid molecule", "clumps"),
        ("bond_style harmonic", "bonds"),
        ("atom_style bpm/sphere", "bonds"),
        ("atom_style ellipsoid", "no spheres"),
        ("pair_coeff 1 1 jkr 1e6 0.5 0.3 10 damping tsuji tangential none", "adhesion (jkr)"),
        ("pair_coeff 1 1 mdr 5e6 .4 1.9e5 2 .5 .2 damping mdr 1 tangential none", "plastic"),
        ("fix w all wall/gran granular dmt 1e6 .5 .3 1 zplane 0 NULL", "adhesion (dmt)"),
    ],
)
def test_what_makes_hard_spheres_wrong(line, what):
    assert any(what in finding.what for finding in read(f"{BASE}{line}\nrun 1\n").invalidates)


def test_words_of_2026_leave_the_normal_contact():
    """Friction with two coefficients is named; elastic-plastic-adhesive normal models have no ε."""
    for word in ("linear_history/static", "mindlin/static"):
        text = (
            BASE
            + f"pair_coeff * * hooke 1e5 0.5 tangential {word} 2e4 1.0 0.5 0.4 damping coeff_restitution\nrun 1\n"
        )
        description = read(text)
        assert not description.unknown and f"tangential {word}" in [note.what for note in description.ignored]
        assert normal(text) == ("hooke", "1e5", "0.5")
    for words in ("epa_linear 1e5 0.5 2 1e4 0.05 0.1", "epa_nonlinear 1e7 0.5 0.3 0.5 0 1e3 1.5 1"):
        description = read(BASE + f"pair_coeff * * {words} tangential mindlin/static NULL 1 0.5 0.4\nrun 1\n")
        assert [finding.what for finding in description.invalidates] == [
            f"plastic deformation ({words.split()[0]})"
        ]
        assert not description.unknown and all(stage.adhesion for stage in description.stages[0].contacts)
    strange = read(BASE + "pair_coeff * * hooke 1e5 0.5 tangential mindlin/magic 1 2 3\nrun 1\n").unknown
    assert [quote.part for quote in strange] == ["tangential mindlin/magic"]


def test_what_is_unknown_is_quoted():
    lines = ["fix new all granular/magic 1", "strange command", "pair_coeff 1 1 hooke 1e5 0.5 damping magic"]
    lines += ["group a typ 1", "create_atoms 1 rndom 5 7 box", "fix g all gravity 9.81 vetor 0 0 -1"]
    text = BASE + "\n".join(lines) + "\nrun 1\n"
    description = read(text)
    assert [quote.text for quote in description.unknown] == lines
    assert [text.splitlines()[quote.line - 1] for quote in description.unknown] == lines
    harmless = "thermo 10\ndump d all custom 1 d id x\nfix a all ave/time 1 1 1 c_x\ncompute x all ke\nneighbor 1 bin\n"
    assert not read(f"{BASE}{harmless}fix e all enforce2d\nfix n all nve/sphere disc\nrun 1\n").unknown


def test_what_is_not_granular_is_refused():
    assert refused("hello\n") == "script: has no granular contacts of lammps, liggghts, yade"
    for text in ("hello\nworld\n", "pair_style lj/cut 2.5\npair_coeff 1 1 1 1\nrun 1\n"):
        assert refused(text, code="lammps") == "script: has no granular contacts"
    with pytest.raises(FileNotFoundError, match=r"\A/no/such/file: no such file\Z"):
        read("/no/such/file")
    assert refused("/tmp") == "/tmp: cannot be read: must be a text file of at most 200 MB"
    assert "must be one of lammps, liggghts, yade" in refused(BASE, code="mfix")
    assert refused(3).startswith("script: got 3")


def test_groups_of_atoms_and_of_regions_that_are_frozen():
    """Atoms by number have known types; those of a region may be any, so some grains of each type stand still."""
    atoms = BASE.replace(POUR, "create_atoms 1 single 0 0 0\ncreate_atoms 2 single 0 0 1\n")
    grains = stage(f"{atoms}group low id 1\nfix 1 low freeze\nfix 2 all nve\nrun 1\n").grains
    assert (grains["1"].frozen, grains["2"].frozen, grains["1"].counted) == (True, False, False)
    grains = stage(f"{atoms}group up id 2\nfix 2 up nve\nrun 1\n").grains
    assert (grains["1"].frozen, grains["2"].frozen) == (True, False)
    grains = stage(f"{BASE}group low region box\nfix 1 low freeze\nfix 2 all nve\nrun 1\n").grains
    assert grains["1"].partly_frozen and not grains["1"].frozen and not grains["1"].counted


@pytest.mark.parametrize(
    "words,low,up",
    [
        ("> 0", True, True),
        (">= 1", True, True),
        ("> 1", False, True),
        ("<> 1 1", True, False),
        ("!= 1", False, True),
    ],
)
def test_groups_of_atoms_by_a_comparison(words, low, up):
    atoms = BASE.replace(POUR, "create_atoms 1 single 0 0 0\ncreate_atoms 2 single 0 0 1\n")
    grains = stage(f"{atoms}group some id {words}\nfix 1 some freeze\nfix 2 all nve\nrun 1\n").grains
    assert (grains["1"].frozen, grains["2"].frozen) == (low, up)


def test_all_atoms_by_number_are_all_atoms():
    """Also where numbers are not known: none keeps the diameter 1 that ``create_atoms`` gives it."""
    atoms = BASE.replace(POUR, "create_atoms 1 box\n")
    for words, radii in (("id >= 1", (0.002, 0.002)), ("id >= 2", (0.002, 0.5))):
        text = f"{atoms}group some {words}\nset group some diameter 0.004\nfix 2 all nve\nrun 1\n"
        assert stage(text).grains["1"].radii == radii


def test_elif_has_no_then():
    lines = (
        "variable m index hard\n"
        "if \"$m == soft\" then 'variable k equal 1e4' elif \"$m == hard\" 'variable k equal 2e5' "
        "else 'variable k equal 3e5'\npair_coeff * * hooke $k 0.5\n"
    )
    assert normal(BASE + lines)[1] == "200000"


def test_edges_of_the_box(tmp_path):
    """In units of a lattice, from a data file, and after a change of the boundaries alone."""
    head = "units lj\natom_style sphere\nlattice sc 1.0\n"
    created = "region box block 0 4 0 5 0 6\ncreate_box 1 box\ncreate_atoms 1 single 1 1 1\n"
    run = "pair_style gran/hooke 1e4 NULL 10 NULL 0 0\npair_coeff * *\nfix move all nve/sphere\nrun 1\n"

    def edges(text):
        (tmp_path / "in.box").write_text(f"{text}{run}", encoding="utf-8")
        return read(tmp_path / "in.box").stages[-1].edges

    assert edges(head + created) == (4.0, 5.0, 6.0)
    assert edges(head.replace("sc 1.0", "sc 0.125") + created) == (8.0, 10.0, 12.0)
    assert edges(f"{head}{created}change_box all boundary p p f\n") == (4.0, 5.0, 6.0)
    assert edges(f"{head}{created}change_box all x final 0 3\n") == (None, None, None)
    data = "\n\n1 atoms\n1 atom types\n0 2 xlo xhi\n0 3 ylo yhi\n-1 3 zlo zhi\n\nAtoms # sphere\n\n1 1 1.0 1.0 1 1 1\n"
    (tmp_path / "data.grains").write_text(data, encoding="utf-8")
    assert edges("units lj\natom_style sphere\nread_data data.grains\n") == (2.0, 3.0, 4.0)
