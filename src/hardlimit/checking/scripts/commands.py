"""Commands of LAMMPS and LIGGGHTS in the order in which they run: variables, include files, loops and conditions.

Formats and rules: docs.lammps.org, pages Commands_parse, variable, if, jump, next and include.
"""

from __future__ import annotations

import gzip
import itertools
import os
import re
import zlib
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Final

from . import formulas
from .description import WANTED
from .reader import names
from .statements import Branch, Place, Statement, Undefined, logical_lines, refusal, refused, scan, split

VARIABLE: Final = re.compile(
    r"\$(?:\{(\w+)\}|(\w)|\(([^()]*(?:\([^()]*(?:\([^()]*\)[^()]*)*\)[^()]*)*)\))", re.ASCII
)
FORMAT: Final = re.compile(r"%[-+ 0#]*\d{0,3}(?:\.\d{1,3})?[aefgAEFG]")
INTEGER_FORMAT: Final = re.compile(r"%[-+ 0]*\d{0,3}[di]")
NAMES: Final = re.compile(r"\$\{(\w+)\}|\$(\w)|\bv_(\w+)", re.ASCII)
UNRESOLVED: Final = re.compile(r"\$(?:\{\w*\}|\(|\w)")
#: A comparison of two words in a condition, and what is no word there.
EQUAL: Final = re.compile(r"([^\s()&|!=<>^]+)\s*(==|!=)\s*([^\s()&|!=<>^]+)")
NUMBERS: Final = re.compile(r"[-+*/%.\d][-+*/%.\deE]*|.*\b[vcf]_.*|[.\d].*")
#: What is before the command in ``partition yes|no N command``.
AFTER_PARTITION: Final = re.compile(r"\s*partition\s+\S+\s+\S+\s*")
#: Styles that do not redefine an existing variable.
KEPT: Final = ("index", "loop", "world", "universe", "uloop", "file", "atomfile", "getenv")
#: Deepest nesting of include files and of variables.
DEEPEST: Final = 20
MAX_STATEMENTS: Final = 1_000_000
MAX_VALUES: Final = 1_000_000
LARGEST_FILE: Final = 200_000_000  #: bytes
USE_LOG: Final = "give the log instead, in which loops and conditions are resolved"
#: Constants of formulas.
LOGICAL: Final = {
    **dict.fromkeys(("yes", "on", "true"), 1.0),
    **dict.fromkeys(("no", "off", "false"), 0.0),
}
#: Commands that cannot change contacts, grains or the time step.
SILENT: Final = names("""
print log echo shell dump dump_modify undump thermo thermo_style thermo_modify write_restart write_data write_dump
restart write_coeff compute uncompute compute_modify info timer
""")


#: Commands that may be given twice.
REPEATABLE: Final = names("unfix fix_modify timestep neigh_modify reset_timestep")


@dataclass(frozen=True)
class Variable:
    """A variable of an input script."""

    style: str
    values: Sequence[str]  #: the formula alone for equal
    at: int = 0
    fixed: bool = False  #: given on the command line


@dataclass
class Variables:
    """All variables with their values."""

    known: dict[str, Variable] = field(default_factory=dict)
    keywords: dict[str, float] = field(default_factory=dict)  #: other names of formulas, such as dt
    used: dict[str, int] = field(default_factory=dict)  #: at which command a value was asked for last
    now: int = 0  #: number of the command that is read; −1 if its values do not count as used

    def define(self, words: Sequence[str]) -> None:
        """As the command ``variable``."""
        if len(words) < 2:
            return
        name, style, *values = words
        old = self.known.get(name)
        if style == "delete":
            self.known.pop(name, None)
        elif old is not None and (old.fixed or style in KEPT):
            return
        elif style in ("loop", "uloop"):
            self.known[name] = Variable("index", _loop(values))
        elif style == "getenv":
            value = os.environ.get(values[0]) if values else None
            self.known[name] = Variable("index" if value is not None else "unknown", (value or "",))
        elif style in ("equal", "internal", "atom", "vector"):
            self.known[name] = Variable("equal", (" ".join(values),))
        elif style == "string":
            self.known[name] = Variable(style, tuple(map(self.substitute, values)))
        elif style == "format":
            self.known[name] = Variable(style, tuple(values))
        elif style in ("index", "universe"):  # one partition takes the values of universe one after another
            self.known[name] = Variable("index", tuple(values))
        elif style == "world":  # the first partition has the first value
            self.known[name] = Variable("index", tuple(values[:1]))
        else:
            self.known[name] = Variable("unknown", tuple(values))

    def step(self, names: Sequence[str]) -> bool:
        """As the command ``next``; False if the values are exhausted, which deletes the variables."""
        going = True
        for name in names:
            variable = self.known.get(name)
            if variable is not None:
                self.known[name] = replace(variable, at=variable.at + 1)
                going = going and variable.at + 1 < len(variable.values)
        if not going:
            for name in names:
                self.known.pop(name, None)
        return going

    def text(self, name: str, depth: int = 0) -> str | None:
        """The text that replaces ``${name}``; None if it is not known."""
        if self.now >= 0:
            self.used[name] = self.now
        variable = self.known.get(name)
        if variable is None or depth > DEEPEST:
            return None
        if variable.style == "equal":
            number = self.number(variable.values[0], depth + 1)
            return None if number is None else f"{number:.15g}"
        if variable.style == "format" and len(variable.values) == 2:
            number = self.of(variable.values[0], depth + 1)
            return None if number is None else _formatted(variable.values[1], number)
        if variable.style in ("index", "string") and variable.at < len(variable.values):
            return variable.values[variable.at]
        return None

    def of(self, name: str, depth: int = 0) -> float | None:
        """The number of a variable."""
        text = self.text(name, depth)
        return None if text is None else self.number(text, depth + 1)

    def number(self, formula: str, depth: int = 0) -> float | None:
        """The value of a formula with ``v_name``."""

        def named(name: str) -> float | None:
            if name.startswith("v_"):
                return self.of(name[2:], depth + 1)
            return LOGICAL.get(name, self.keywords.get(name))

        if depth > DEEPEST:
            return None
        return formulas.value(self.substitute(formula, depth + 1) if "$" in formula else formula, named)

    def replaced(self, match: re.Match[str], depth: int = 0) -> str:
        """The text for a match of ``VARIABLE``; the match itself if its value is not known."""
        if match[3] is None:
            text = self.text(match[1] or match[2], depth)
            return match[0] if text is None else text
        formula, _, form = match[3].partition(":")
        number = self.number(formula, depth)
        if number is None:
            return match[0]
        return (_formatted(form, number) or match[0]) if form else repr(number)

    def substitute(self, text: str, depth: int = 0) -> str:
        """A text with its variables replaced."""
        return VARIABLE.sub(lambda match: self.replaced(match, depth), text)

    def missing(self, text: str, depth: int = 0) -> Iterator[str]:
        """Names of variables in a text that have no value, or of those on which they depend."""
        for plain, letter, inner in NAMES.findall(text):
            name = plain or letter or inner
            variable = self.known.get(name)
            if depth > DEEPEST or self.text(name) is not None:
                continue
            causes = [] if variable is None else list(self.missing(" ".join(variable.values), depth + 1))
            yield from causes or [name]


def merge(known: dict[str, Variable], others: Mapping[str, Variable]) -> None:
    """After a condition that only a run knows: a variable without one value has none."""
    for name in dict.fromkeys([*known, *others]):
        if known.get(name) != others.get(name):
            known[name] = Variable("unknown", ())


def _loop(values: Sequence[str]) -> Sequence[str]:
    """Values of ``loop N [pad]`` or ``loop N1 N2 [pad]``."""
    pad = values[-1:] == ["pad"]
    ends = [int(value) for value in values if value.isdigit()]
    if not 1 <= len(ends) <= 2 or len(ends) + pad != len(values):
        return ()
    first, last = (1, ends[0]) if len(ends) == 1 else (ends[0], ends[1])
    if last - first > MAX_VALUES:
        return ()
    return tuple(str(k).zfill(len(str(last)) if pad else 0) for k in range(first, last + 1))


def of_first_partition(words: Sequence[str]) -> bool:
    """Whether the first partition runs ``partition yes|no N command``, with N such as ``1``, ``2*`` or ``*3``."""
    low, star, _ = (*words, "", "")[1].partition("*")
    first = low in ("", "1") if star else low == "1"
    return first == ((*words, "")[0] == "yes")


def _formatted(form: str, number: float) -> str | None:
    if FORMAT.fullmatch(form):
        return form % number
    return form % int(number) if INTEGER_FORMAT.fullmatch(form) else None


@dataclass
class Frame:
    """A file that is being read."""

    file: str
    folder: Path | None  #: of include files; None for a text
    lines: list[tuple[int, str]]
    at: int = 0
    number: int = field(default_factory=itertools.count().__next__)

    @property
    def place(self) -> Place:
        """The line that is read next."""
        return self.number, self.at

    @cached_property
    def labels(self) -> dict[str, int]:
        """Places of labels."""
        labels: dict[str, int] = {}
        for k, (_, line) in enumerate(self.lines):
            words = line.split(maxsplit=2)
            if words[:1] == ["label"] and len(words) > 1:
                labels.setdefault(words[1].partition("#")[0], k)
        return labels


@dataclass(frozen=True)
class Round:
    """One round of a loop."""

    commands: Sequence[Statement | None]
    others: Mapping[str, Variable]  #: variables at its end, without those that count the rounds
    end: int  #: number of commands that were read until then

    @cached_property
    def plain(self) -> list[object]:
        """What it says."""
        return [plain(command) for command in self.commands]


def plain(statement: Statement | None) -> object:
    """A command without the values that it prints."""
    if statement is None:
        return None
    inner = [[plain(each) for each in branch.statements] for branch in statement.branches]
    return statement.file, statement.line, statement.words, inner


def is_repeatable(statement: Statement) -> bool:
    """Whether a command that is given again leaves everything as it is, but for the number of steps."""
    command, words = statement.words[0], [*statement.words[1:], "", "", ""]
    if command == "if":
        return all(
            branch.place is None and not branch.ends and all(map(is_repeatable, branch.statements))
            for branch in statement.branches
        )
    if command == "fix":
        return not words[2].startswith(("insert", "pour", "deposit", "adapt", "particle"))
    if command == "run":
        return words[0].isdecimal() and len(words[0]) < 10
    if command == "set":
        return words[2].startswith("property/atom")
    return command in REPEATABLE


@dataclass
class Commands:
    """The commands of an input script as they run: include, jump, next and if are followed."""

    text: str
    file: str = ""
    folder: Path | None = None
    variables: Variables = field(default_factory=Variables)
    silent: Collection[str] = SILENT  #: commands in which values do not matter

    def __post_init__(self) -> None:
        self.frames = [Frame(self.file, self.folder, logical_lines(self.text))]
        self.skip_jump, self.may_quit, self.trying, self.count = False, False, False, 0
        self.exits: dict[Place, dict[str, Variable]] = {}  #: variables at labels to which conditions may lead
        self.repeated: dict[Place, dict[str, Variable]] = {}  #: variables when a jump led back
        self.passed: dict[Place, dict[str, Variable]] = {}  #: variables at a label
        self.again: set[Place] = set()  #: conditions that led back
        self.read: list[Statement | None] = []  #: commands so far that a loop repeats; None for another one
        self.rounds: dict[Place, Round] = {}  #: of loops, by the jump at their end
        self.stepped: list[str] = []  #: variables of the last ``next``

    def __iter__(self) -> Iterator[Statement]:
        while self.frames:
            yield from self._step()

    def _step(self) -> Iterator[Statement]:
        """The next line."""
        frame = self.frames[-1]
        if frame.at >= len(frame.lines):
            self.frames.pop()
            return
        line, raw = frame.lines[frame.at]
        place = frame.place
        frame.at += 1
        if place in self.exits:
            merge(self.variables.known, self.exits.pop(place))
            yield Statement(line, ("label",), raw, file=frame.file, place=place)
        yield from self._run(frame, line, raw)

    def _run(self, frame: Frame, line: int, raw: str, depth: int = 0) -> Iterator[Statement]:
        """One command."""
        pieces, quote = scan(raw)
        if quote:
            raise refusal(line, raw, f"close its quotes {quote}", frame.file)
        first = raw.split(maxsplit=1)[:1]
        self.variables.now = -1 if first and first[0] in self.silent else len(self.read)
        code = "".join(text if quoted else self.variables.substitute(text) for text, quoted in pieces)
        self.variables.now = len(self.read)
        words = split(code)
        if not words:
            return
        self.count += 1
        if self.count > MAX_STATEMENTS:
            raise refusal(line, raw, f"be part of a shorter loop; {USE_LOG}", frame.file)
        wanted = WANTED.search(raw[sum(len(text) for text, _ in pieces) :])
        text = code if wanted is None else f"{code.rstrip()}  {wanted[0]}"
        statement = Statement(line, words, text, file=frame.file)
        if words[0] == "variable":
            if words[2:3] == ("world",) and len(words) > 4 and words[1] not in self.variables.known:
                yield replace(statement, words=("partition", *words))
            self.variables.define(words[1:])
        else:
            yield from self._follow(frame, statement, depth)

    def _follow(self, frame: Frame, statement: Statement, depth: int) -> Iterator[Statement]:
        command, *words = statement.words
        if command == "next":
            self.skip_jump, self.stepped = not self.variables.step(words), words
        elif command == "jump":
            yield from self._jump(frame, statement)
        elif command == "include":
            if len(self.frames) > DEEPEST:
                raise refused(statement, "be nested less deeply")
            self.frames.append(self._opened(frame, statement))
        elif command == "if":
            if depth > DEEPEST:
                raise refused(statement, "be nested less deeply")
            for each in self._choose(frame, statement, depth):
                self.read.append(each if is_repeatable(each) else None)
                yield each
        elif command == "run" and "every" in words:
            self.read.append(None)
            yield from self._interrupted(frame, statement, depth)
        elif command == "partition":
            if depth > DEEPEST:
                raise refused(statement, "be nested less deeply")
            yield statement
            if of_first_partition(words):
                yield from self._run(
                    frame, statement.line, AFTER_PARTITION.sub("", statement.text, count=1), depth + 1
                )
        elif command == "quit":
            self.frames.clear()
        elif command == "label":
            self.passed[frame.number, frame.at - 1] = dict(self.variables.known)
        else:
            if command not in SILENT:
                self.read.append(statement if is_repeatable(statement) else None)
            yield statement

    def _interrupted(self, frame: Frame, statement: Statement, depth: int) -> Iterator[Statement]:
        """``run N every M`` with commands after each part; the steps of the last parts are not counted."""
        k = statement.words.index("every")
        whole, every, inner = statement.words[:k], statement.words[k + 1 : k + 2], statement.words[k + 2 :]
        statements = [
            command
            for text in inner
            if text != "NULL"
            for command in self._run(frame, statement.line, text, depth + 1)
        ]
        changing = [command for command in statements if command.words[0] not in SILENT]
        yield replace(statement, words=("run", *every) if changing else whole)
        if changing:
            yield from changing
            yield replace(statement, words=("run", "", *whole[2:]))

    def _jump(self, frame: Frame, statement: Statement) -> Iterator[Statement]:
        if self.skip_jump:
            self.skip_jump = False
            return
        target, *label = statement.words[1:] or ("SELF",)
        if target not in ("SELF", frame.file):
            self.frames.pop()
            self.frames.append(self._opened(frame, statement))
        again = self.frames[-1]
        if label and label[0] not in again.labels:
            raise refused(statement, f"name a label of the file, not {label[0]}")
        at = again.labels[label[0]] if label else 0
        if again is frame and at < frame.at and not self.trying and not self._changed(frame):
            self._leave(frame, statement)
        else:
            if again is frame and at < frame.at and not self.trying:
                yield from self._skipped(frame.place)
            again.at = at

    def _skipped(self, place: Place) -> Iterator[Statement]:
        """One round with long runs for those of a loop that would repeat the last two, but for its last round."""
        others = {name: each for name, each in self.variables.known.items() if name not in self.stepped}
        start = self.rounds[place].end if place in self.rounds else 0
        this = Round(self.read[start:], others, len(self.read))
        before, self.rounds[place] = self.rounds.get(place), this
        loops = [self.variables.known.get(name) for name in self.stepped]
        left = min((len(loop.values) - 1 - loop.at for loop in loops if loop is not None), default=0)
        if before is None or left < 1 or None in loops or None in this.commands:
            return
        used = any(self.variables.used.get(name, -1) >= start for name in self.stepped)
        if used or this.plain != before.plain or others != before.others:
            return
        for name, loop in zip(self.stepped, loops, strict=True):
            if loop is not None:
                self.variables.known[name] = replace(loop, at=loop.at + left)
        for command in filter(None, this.commands):
            if command.words[0] == "run" and "upto" not in command.words:
                yield replace(command, words=("run", str(left * int(command.words[1])), *command.words[2:]))
            else:
                yield command

    def _changed(self, frame: Frame) -> bool:
        """Whether variables have changed since the jump back before this line was taken last."""
        now = dict(self.variables.known)
        before = self.repeated.get(frame.place)
        self.repeated[frame.place] = now
        return now != before

    def _leave(self, frame: Frame, statement: Statement) -> None:
        """Go on after a loop that only a condition ends which a run knows."""
        ahead = [at for file, at in self.exits if file == frame.number and at >= frame.at]
        if ahead:
            frame.at = min(ahead)
        elif self.may_quit:
            self.frames.clear()
        else:
            raise refused(statement, f"be part of a shorter loop; {USE_LOG}")

    def _opened(self, frame: Frame, statement: Statement) -> Frame:
        if len(statement.words) < 2:
            raise refused(statement, "name a file")
        if UNRESOLVED.search(statement.words[1]):
            raise Undefined(statement)
        name = statement.words[1]
        if frame.folder is None:
            raise refused(statement, "be in a file, to which it is relative")
        text, path = None, Path(name)
        for folder in dict.fromkeys((self.folder or frame.folder, frame.folder)):
            text = text_of(folder / path)
            if text is not None:
                return Frame(name, (folder / path).parent, logical_lines(text))
        raise refused(statement, "name a file that can be read")

    def _choose(self, frame: Frame, statement: Statement, depth: int) -> Iterator[Statement]:
        """Follow the branch of ``if`` whose condition holds; where only a run knows it, read all that may."""
        possible: list[Sequence[str]] = []
        known = True
        for condition, commands in _branches(statement):
            holds = self._condition(condition)
            known = known and holds is not None
            if holds is not False:
                possible.append(commands)
            if holds:
                break
        else:
            possible.append(())
        if known:
            for inner in possible[0]:
                yield from self._run(frame, statement.line, inner, depth + 1)
        elif not all(split(text)[:1] and split(text)[0] in SILENT for inner in possible for text in inner):
            branches, variables = list[Branch](), list[dict[str, Variable]]()
            label: Place | None = None
            for part in possible:
                before = dict(self.variables.known)
                branch, back = self._tried(frame, statement, part, depth)
                branches.append(branch)
                label = back or label
                if branch.place:
                    merge(
                        self.exits.setdefault(branch.place, dict(self.variables.known)), self.variables.known
                    )
                elif not branch.ends:
                    variables.append(dict(self.variables.known))
                self.variables.known = before
            going = [branch for branch in branches if not branch.ends and not branch.place]
            self.may_quit = self.may_quit or len(going) < len(branches)
            if variables:
                self.variables.known = variables[0]
                for others in variables[1:]:
                    merge(self.variables.known, others)
            elif places := [branch.place[1] for branch in branches if branch.place]:
                frame.at = min(places)
            else:
                self.frames.clear()
            if label:
                self._repeat(frame, label)
            yield replace(statement, branches=tuple(branches))

    def _repeat(self, frame: Frame, label: Place) -> None:
        """Read a loop once more whose number of rounds only a run knows, without the variables that it changes."""
        before, known = self.passed.get(label, {}), self.variables.known
        changed = [name for name in {**before, **known} if before.get(name) != known.get(name)]
        if before and changed and frame.place not in self.again:
            self.again.add(frame.place)
            known.update(dict.fromkeys(changed, Variable("unknown", ())))
            frame.at = label[1]

    def _tried(
        self, frame: Frame, statement: Statement, commands: Sequence[str], depth: int
    ) -> tuple[Branch, Place | None]:
        """The commands of a branch with where it leads, and a label before it to which it leads back."""
        frames, at, statements = list(self.frames), frame.at, list[Statement]()
        skip_jump, trying = self.skip_jump, self.trying
        self.trying = True
        for inner in commands:
            statements += self._run(frame, statement.line, inner, depth + 1)
            while len(self.frames) > len(frames):  # an include file
                statements += self._step()
            if self.frames != frames or frame.at != at:
                break
        ends, place, ahead = not self.frames, frame.place, frame.at - at
        if self.frames and self.frames[-1] is not frame:
            raise refused(statement, f"have a condition that is known without running; {USE_LOG}")
        self.frames, frame.at, self.skip_jump, self.trying = frames, at, skip_jump, trying
        branch = Branch(tuple(statements), place if ahead > 0 and not ends else None, ends)
        return branch, place if ahead < 0 and not ends else None

    def _condition(self, text: str) -> bool | None:
        plain = self.variables.substitute(text)
        if UNRESOLVED.search(plain):
            return None
        number = self.variables.number(EQUAL.sub(_same_words, plain))
        return None if number is None else bool(number)


def _branches(statement: Statement) -> Iterator[tuple[str, Sequence[str]]]:
    """Conditions and commands of ``if``."""
    words = statement.words[1:]
    starts = [0, *(k for k, word in enumerate(words) if word in ("elif", "else") and k > 0), len(words)]
    for a, b in itertools.pairwise(starts):
        part = words[a:b]
        body = part[1:] if part[:1] in (("elif",), ("else",)) else part
        if part[:1] == ("else",):
            yield "1", body
        elif body[1:2] == ("then",):
            yield body[0], body[2:]
        elif part[:1] == ("elif",) and body:
            yield body[0], body[1:]  # LAMMPS has no "then" here
        else:
            raise refused(statement, "be if condition then commands")


def _same_words(match: re.Match[str]) -> str:
    """A comparison of two words as 1 or 0; that of numbers as it is."""
    words = [word.strip("\"'") for word in (match[1], match[3])]
    if any(NUMBERS.fullmatch(word) for word in words):
        return match[0]
    return f" {int((words[0] == words[1]) == (match[2] == '=='))} "


def text_of(path: Path) -> str | None:
    """The text of a file; None if it cannot be read."""
    try:
        if not path.is_file() or path.stat().st_size > LARGEST_FILE:
            return None
        if path.suffix != ".gz":
            return path.read_text("utf-8", errors="replace")
        with gzip.open(path, "rt", encoding="utf-8", errors="replace") as file:
            return file.read(LARGEST_FILE)
    except (OSError, ValueError, EOFError, zlib.error):
        return None


def given(values: Mapping[str, str]) -> Variables:
    """Variables of the command line, which a script does not redefine."""
    return Variables(
        {name: Variable("index", tuple(text.split()) or ("",), fixed=True) for name, text in values.items()}
    )


def is_variable(word: str) -> bool:
    """Whether a word contains a variable."""
    return word.startswith("v_") or UNRESOLVED.search(word) is not None
