"""Random scripts whose answer is known, and scripts with random faults."""

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from conftest import draws
from hardlimit.checking.scripts import Description, read
from hardlimit.convert.tangential.lammps import GRANULAR

MODELS = ("hooke {k} {e}", "hertz {k} {e}", "hertz/material {k} {e} 0.3")
#: Tangential models with the names of their numbers, and styles of classic walls.
TANGENTIAL = {model.name: tuple(model.numbers) for model in GRANULAR}
GRAN = ("hooke", "hooke/history", "hertz/history")
DAMPING = ("velocity", "mass_velocity", "viscoelastic", "tsuji", "coeff_restitution")


class Written:
    """A random script of LAMMPS or LIGGGHTS, and what it says."""

    def __init__(self, seed):
        self.random = random.Random(seed)
        self.types = self.random.randint(1, 4)
        self.lines, self.number = [], 0
        self.pairs, self.walls, self.radii = {}, {}, {}

    def choose(self, *values):
        return self.random.choice(values)

    def value(self, low, high):
        return float(f"{self.random.uniform(low, high):.6g}")

    def written(self, value):
        """A number as a word: itself, or through a variable or a formula."""
        self.number += 1
        name, word = f"x{self.number}", repr(value)
        way = self.random.randrange(6)
        if way == 0:
            self.lines.append(f"variable {name} equal {word}*3/3{self.comment()}")
        elif way == 1:
            self.lines.append(f"variable {name} index {word} 7")
        elif way == 2:
            self.lines += [f"variable {name} string 1.0", f"variable {name} string '{word}'"]
        elif way == 3:
            self.lines += [f"variable y{name} equal {word}", f"variable {name} equal v_y{name}+0"]
        else:
            return self.choose(word, f"$({word}+0)", f"'{word}'", f'"{word}"')
        return f"${{{name}}}"

    def comment(self):
        return self.choose("", "", " # pair_coeff * * jkr 1 2 3 4", "\t# & .", " # units cgs")

    def add(self, line):
        """A command with any blanks, continued anywhere between words."""
        words = line.split(" ")
        text = words[0]
        for word in words[1:]:
            text += self.choose(" ", " ", "\t", "  ", " &\n", "&\n ") + word
        self.lines.append(text + self.comment())
        if self.random.random() < 0.2:
            self.lines.append(self.choose("", "# timestep 5", "print 'units si'", "thermo 10"))

    def text(self):
        return "\n".join([*self.lines, "run 10", ""]).replace("\n", self.choose("\n", "\n", "\r\n"))

    def lammps(self):
        self.add("atom_style sphere")
        self.add(f"create_box {self.types} box")
        for kind in range(1, self.types + 1):
            low, high = sorted(self.value(0.1, 1.0) for _ in range(2))
            self.radii[str(kind)] = (0.5 * low, 0.5 * high)
            if self.random.random() < 0.5:
                self.add(
                    f"fix i{kind} all pour 9 {kind} 7 region box diam range {self.written(low)} {self.written(high)}"
                )
            else:
                self.radii[str(kind)] = (0.5 * low, 0.5 * low)
                self.add(f"create_atoms {kind} box")
                self.add(f"set type {kind} diameter {self.written(low)}")
        self.add("pair_style granular")
        every = range(1, self.types + 1)
        for first, second in [(0, 0), *[tuple(sorted(self.random.choices(every, k=2))) for _ in range(3)]]:
            words, model = self.model()
            names = [str(k) if k else "*" for k in (first, second)]
            self.add(f"pair_coeff {' '.join(names)} {words}")
            for i in [first] if first else every:
                for j in [second] if second else every:
                    if i <= j:
                        self.pairs[str(i), str(j)] = model
        for k in range(self.random.randint(0, 2)):
            classic = self.random.random() < 0.5
            words, model = self.classic() if classic else self.model()
            self.walls[f"w{k}"] = model
            kind = "" if classic else "granular "
            self.add(f"fix w{k} all wall/gran {kind}{words} zplane {self.written(0.0)} NULL")

    def liggghts(self):
        every = range(self.types)
        moduli, ratios = ([self.value(low, high) for _ in every] for low, high in ((1e6, 1e8), (0.1, 0.4)))
        restitutions = {(i, j): self.value(0.1, 0.9) for i in every for j in every if i <= j}
        self.add(f"create_box {self.types} box")
        mu = self.value(0.1, 0.9)
        matrix = [self.written(restitutions[min(i, j), max(i, j)]) for i in every for j in every]
        for name, words in (
            ("youngsModulus peratomtype", [self.written(x) for x in moduli]),
            ("poissonsRatio peratomtype", [self.written(x) for x in ratios]),
            (f"coefficientRestitution peratomtypepair {self.types}", matrix),
            (f"coefficientFriction peratomtypepair {self.types}", [self.written(mu)] * self.types**2),
        ):
            self.add(f"fix p{len(self.lines)} all property/global {name} {' '.join(words)}")
        limited = self.choose("", " limitForce on")
        friction, damping = self.choose("history", "no_history", "off", ""), self.choose(None, "on", "off")
        tangential = f" tangential {friction}" if friction else ""
        last = [limited, "" if damping is None else f" tangential_damping {damping}"]
        self.random.shuffle(last)
        self.add(f"pair_style gran model hertz{tangential}{self.choose('', ' cohesion off')}{''.join(last)}")
        for k in every:
            radius = self.value(0.1, 1.0)
            self.radii[str(k + 1)] = (radius, radius)
            template = f"atom_type {k + 1} density constant 2500 radius constant {self.written(radius)}"
            self.add(f"fix t{k} all particletemplate/sphere 7 {template}")
        names = " ".join(f"t{k} 1.0" for k in every)
        self.add(f"fix d all particledistribution/discrete 7 {self.types} {names}")
        self.add("fix ins all insert/pack seed 7 distributiontemplate d")
        end = self.random.choice(every)
        self.add(
            f"fix w all wall/gran model hertz{tangential} primitive type {end + 1} "
            f"zplane {self.written(0.0)}{''.join(last)}"
        )

        def contact(i, j):
            effective = 1.0 / sum((1.0 - ratios[k] ** 2) / moduli[k] for k in (i, j))
            shear = 1.0 / sum(2.0 * (2.0 - ratios[k]) * (1.0 + ratios[k]) / moduli[k] for k in (i, j))
            numbers = (mu, {"on": 1.0, "off": 0.0}.get(damping), shear)
            force = (f"hertz {friction}", *numbers) if friction not in ("", "off") else None
            return restitutions[min(i, j), max(i, j)], effective, bool(limited), force

        self.pairs = {(str(i + 1), str(j + 1)): contact(i, j) for i, j in restitutions}
        self.walls = {(str(i + 1), "wall"): contact(i, end) for i in every}

    def model(self):
        """The words of a model of pair granular, and its settings."""
        k, e = self.value(1e4, 1e6), self.value(0.1, 0.9)
        damping, limited = self.choose(None, *DAMPING), self.choose("", " limit_damping")
        shape = self.choose(*MODELS)
        words = shape.format(k=self.written(k), e=self.written(e))
        name = self.choose(*(model for model in TANGENTIAL if "material" in shape or "mindlin" not in model))
        numbers = {each: self.value(0.1, 9.0) for each in TANGENTIAL[name]}
        if "mindlin" in name and name != "mindlin_classic" and self.random.random() < 0.5:
            numbers["stiffness"] = None
        places = ["NULL" if x is None else self.written(x) for x in numbers.values()]
        parts = [f" tangential {name} {' '.join(places)}", f" damping {damping}" if damping else "", limited]
        self.random.shuffle(parts)
        normal = [shape.split()[0], k, e] + ([0.3] if "material" in shape else [])
        return words + "".join(parts), (normal, damping or "viscoelastic", bool(limited), name, numbers)

    def classic(self):
        """The words of a classic wall, and its settings."""
        style, k, c, mu = self.choose(*GRAN), self.value(1e4, 1e6), self.value(1.0, 9.0), self.value(0.1, 0.9)
        stiffness, damping = (self.choose(None, self.value(1.0, 9.0)) for _ in range(2))
        flag, limited = self.choose(0, 1), self.choose("", " limit_damping")
        spring, dashpot = ("NULL" if x is None else self.written(x) for x in (stiffness, damping))
        words = f"{style} {self.written(k)} {spring} {self.written(c)} {dashpot} {self.written(mu)} {flag}{limited}"
        numbers = {"stiffness": stiffness, "damping": damping if flag else 0.0, "coefficient": mu}
        if style == "hooke":
            del numbers["stiffness"]
        rubs = style != "hooke" or flag
        normal = ["gran/hertz" if style == "hertz/history" else "gran/hooke", k, c]
        return words, (normal, None, bool(limited), *((f"gran/{style}", numbers) if rubs else (None, None)))


@pytest.mark.parametrize("seed", range(100))
def test_random_scripts(seed):
    written = Written(seed)
    written.lammps()
    stage = read(written.text()).stages[-1]
    expected = {(pair, None): model for pair, model in written.pairs.items()}
    expected |= {
        ((str(k), "wall"), wall): m for wall, m in written.walls.items() for k in range(1, written.types + 1)
    }
    contacts = {}
    for contact in stage.contacts:
        name, *numbers = contact.settings["normal"].words
        normal = [name, *(pytest.approx(float(x), rel=1e-12) for x in numbers)]
        force = contact.tangential
        numbers = force and {name: x and pytest.approx(x, rel=1e-12) for name, x in force.numbers.items()}
        contacts[contact.types, contact.wall] = (
            normal,
            contact.settings["damping"].words[0] if "damping" in contact.settings else None,
            "limit_damping" in contact.settings,
            force and force.model,
            numbers,
        )
        assert contact.friction == (force.numbers["coefficient"] if force else 0.0)
    assert contacts == expected
    assert {kind: grains.radii for kind, grains in stage.grains.items()} == {
        kind: pytest.approx(radii) for kind, radii in written.radii.items()
    }


@pytest.mark.parametrize("seed", range(30))
def test_random_scripts_of_liggghts(seed):
    written = Written(seed)
    written.liggghts()
    stage = read(written.text()).stages[-1]
    contacts = {}
    for contact in stage.contacts:
        names = ("coefficientRestitution", "youngsModulus", "poissonsRatio")
        restitution, modulus, ratio = (float(contact.settings[name].words[0]) for name in names)
        effective = 0.5 * modulus / (1.0 - ratio**2)
        limited = "limitForce" in contact.settings
        force = contact.tangential and (
            contact.tangential.model,
            *(contact.tangential.numbers[name] for name in ("coefficient", "tangential_damping")),
            pytest.approx(contact.tangential.numbers["shear_modulus"], rel=1e-12),
        )
        contacts[contact.types] = (restitution, pytest.approx(effective, rel=1e-12), limited, force)
        assert contact.friction == (0.0 if force is None else force[1])
    assert contacts == {**written.pairs, **written.walls}
    assert {kind: grains.radii for kind, grains in stage.grains.items()} == written.radii


# --- faults -----------------------------------------------------------------------------------------------------


def whole(seed):
    written = Written(seed)
    written.lammps()
    return written.text()


LIGGGHTS = """units si
fix m1 all property/global youngsModulus peratomtype 5e6 2e7
fix m2 all property/global poissonsRatio peratomtype 0.45 0.3
fix m3 all property/global coefficientRestitution peratomtypepair 2 0.9 0.5 0.5 0.7
pair_style gran model hertz tangential history
fix pts1 all particletemplate/sphere 15485863 atom_type 1 density constant 2500 radius constant 0.0015
fix pdd1 all particledistribution/discrete 32452843 1 pts1 1.0
fix ins all insert/pack seed 1 distributiontemplate pdd1
fix w1 all wall/gran model hertz tangential history primitive type 2 zplane 0.0
group a type 1
set group a diameter 0.1 density 2000
if "1 > 0" then "run 10" else "jump SELF x"
"""
YADE = """from yade import pack
m = O.materials.append(FrictMat(young=1e7, poisson=.3, density=2500, label='glass'))
sp = pack.SpherePack()
sp.makeCloud((0, 0, 0), (1, 1, 1), rMean=.05, rRelFuzz=.2)
sp.toSimulation(material=m)
for i in range(3):
    O.bodies.append([sphere((0, 0, i), .1 * (i + 1)), wall(0, axis=2)])
O.engines = [ForceResetter(), InteractionLoop([], [Ip2_FrictMat_FrictMat_MindlinPhys(
    en=MatchMaker(matches=((m, m, .7),)))], [Law2_ScGeom_MindlinPhys_Mindlin()]), NewtonIntegrator(gravity=(0, 0, -9))]
O.dt = .3 * PWaveTimeStep()
O.run(10)
"""
LOG = "LAMMPS (22 Jul 2025)\n" + whole(1)
#: Pieces that are put into scripts.
SIGNS = [*"&\n\"'$(){}[]^*#-0=:,\t\0é", '"""', "${", "$(", "**", "1e999", "nan", "inf", "-1", "100000", "v_x"]
COMMANDS = [
    "label a\n",
    "jump SELF a\n",
    "next x1\n",
    "include x\n",
    "if 1 then run\n",
    "clear\n",
    "run",
    "set",
    "fix",
]
PIECES = st.sampled_from([*SIGNS, *COMMANDS, "lambda: 0", "O.", "type", "peratomtypepair"])


@draws(300)
@given(
    text=st.sampled_from([*map(whole, range(6)), LIGGGHTS, YADE, LOG]),
    changes=st.lists(st.tuples(st.integers(0, 10**6), st.integers(0, 12), PIECES), max_size=6),
    code=st.sampled_from([None, "lammps", "liggghts", "yade"]),
)
def test_faulty_scripts_give_a_description_or_one_line(text, changes, code):
    """Text is cut out and pieces are put in at random places."""
    for place, cut, piece in changes:
        at = place % (len(text) + 1)
        text = text[:at] + piece + text[at + cut :]
    check(text, code)


@draws(200)
@given(text=st.text(max_size=200), code=st.sampled_from([None, "lammps", "liggghts", "yade"]))
def test_any_text(text, code):
    check(text, code)


def check(text, code):
    try:
        assert isinstance(read(text, code=code), Description)
    except (ValueError, FileNotFoundError) as error:  # a single word is a path
        line = str(error)
        assert line and "\n" not in line and len(line) < 600
