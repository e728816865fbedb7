"""Mutation tests: put deliberate faults into the headers, one at a time, and check that the named tests fail.

    python tools/faults.py [--only NAME ...] [--work DIRECTORY]

Requires what an editable install requires, in an environment without hardlimit. The faults are in
`tools/faults.toml`. The package is built once into the working directory. For each fault only the files of bindings/
that include it are recompiled, without optimisation, and linked before all others, so that the linker takes the faulty
copy of each function (`-z muldefs`: the first definition counts). `verdicts.json` there keeps the verdicts; a fault
whose text, headers and tests are unchanged is not tried again, nor is a test that passed without a fault. The exit
status is 1 if a fault survives or could not be tried.
"""

import argparse
import hashlib
import json
import os
import shlex
import shutil
import subprocess
import sys
import tomllib
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
FAULTS = ROOT / "tools" / "faults.toml"

#: Exit statuses of pytest; any other one, such as that of a crash or a timeout, means that the fault is caught.
SURVIVED, NOT_RUN = 0, {2, 3, 4, 5}
#: A file of bindings/ that CMakeLists.txt compiles alone and as it is: its command serves for all of them.
ALONE = "hard_spheres"


@dataclass(frozen=True)
class Fault:
    """A textual change of a header, and the tests that must fail with it."""

    name: str
    file: str  #: below core/
    old: str
    new: str
    why: str
    tests: list[str]
    #: Files of bindings/, without suffix; by default those of `unit_of`.
    units: list[str] = field(default_factory=list)

    def apply(self, core: Path) -> None:
        """Put the fault into the headers below `core`; ValueError unless the old text occurs exactly once."""
        header = core / self.file
        text = header.read_text(encoding="utf-8")
        if text.count(self.old) != 1:
            raise ValueError(
                f"{self.name}: the old text occurs {text.count(self.old)} times in {self.file}, must be once"
            )
        header.write_text(text.replace(self.old, self.new), encoding="utf-8")


def unit_of(test: str) -> str:
    """The file of bindings/ that a test needs: that of its folder or, for boxes, that of its name."""
    _, room, name = Path(test.split("::")[0]).with_suffix("").parts
    folders = {"contact": "contacts", "convert": "contacts", "column": "columns"}
    return folders.get(room, name.removeprefix("test_"))


def read_faults() -> list[Fault]:
    """The faults in the order of the file."""
    entries = tomllib.loads(FAULTS.read_text(encoding="utf-8"))["fault"]
    return [Fault(**({"units": [unit_of(entry["tests"][0])]} | entry)) for entry in entries]


def digest(text: str, tests: list[str], source: Path) -> str:
    """A hash of a text, of these tests and of everything compiled."""
    hash_of = hashlib.sha256(text.encode())
    for folder in ("core", "bindings"):
        for path in sorted((source / folder).rglob("*.?pp")):
            hash_of.update(path.read_bytes())
    for test in sorted({t.split("::")[0] for t in tests}):
        hash_of.update((source / test).read_bytes())
    return hash_of.hexdigest()


class Workplace:
    """A copy of the source tree, its build, and a package folder in which the extension is replaced."""

    def __init__(self, folder: Path) -> None:
        self.source, self.site, self.log = folder / "source", folder / "site", folder / "pytest.log"
        self.build = self.source / "build" / "sound"
        self.copy_tree()
        settings = [f"-Cbuild-dir={self.build}", "-Ccmake.args=-G Ninja;-DCMAKE_EXPORT_COMPILE_COMMANDS=ON"]
        shutil.rmtree(self.build.parent / "compiled", ignore_errors=True)  # which would replace the build
        subprocess.run(
            [sys.executable, "-m", "pip", "install", "-q", "--no-deps", "--no-build-isolation", "--upgrade",
             "--target", str(self.site), *settings, str(self.source)],
            check=True,
        )  # fmt: skip
        (self.extension,) = (self.site / "hardlimit").glob("_core*.so")
        self.sound = self.extension.read_bytes()
        commands = json.loads((self.build / "compile_commands.json").read_text(encoding="utf-8"))
        (self.command,) = (shlex.split(c["command"]) for c in commands if c["file"].endswith(f"/{ALONE}.cpp"))

    def copy_tree(self) -> None:
        """Copy the files known to git; unchanged files keep their times, so that the build is incremental."""
        listed = subprocess.run(
            ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
            cwd=ROOT, check=True, capture_output=True, text=True,
        ).stdout.split("\0")  # fmt: skip
        for name in filter(None, listed):
            there, here = self.source / name, ROOT / name
            if not here.is_file() or (there.is_file() and there.read_bytes() == here.read_bytes()):
                continue
            there.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(here, there)

    def link_command(self) -> list[str]:
        """The link command of the extension."""
        command = ["ninja", "-t", "commands", self.extension.name]
        done = subprocess.run(command, cwd=self.build, check=True, capture_output=True, text=True)
        shown = done.stdout.splitlines()
        (link,) = (line for line in shown if f"-o {self.extension.name}" in line and " -shared " in line)
        return next(shlex.split(part) for part in link.split(" && ") if f"-o {self.extension.name}" in part)

    def is_imported(self) -> bool:
        """Whether tests import the package of this folder: the hook of an editable install would go before it."""
        command = [sys.executable, "-c", "import hardlimit; print(hardlimit.__file__)"]
        origin = subprocess.run(
            command,
            env=os.environ | {"PYTHONPATH": str(self.site)},
            check=True,
            capture_output=True,
            text=True,
        ).stdout
        return Path(origin).is_relative_to(self.site)

    def make_faulty(self, fault: Fault) -> None:
        """Compile the units of the fault and link them before all others."""
        link = self.link_command()
        first = next(i for i, word in enumerate(link) if word.endswith(".o"))
        for unit in fault.units:
            target = str(self.build / f"faulty-{unit}.o")
            command = [word.replace(f"bindings/{ALONE}.cpp", f"bindings/{unit}.cpp") for word in self.command]
            command[command.index("-o") + 1] = target
            subprocess.run([*command, "-O0", "-w"], cwd=self.build, check=True)
            link.insert(first, target)
        link[link.index("-o") + 1] = str(self.extension)
        subprocess.run([*link, "-Wl,-z,muldefs"], cwd=self.build, check=True)

    def run_tests(self, tests: list[str]) -> int:
        """Exit status of pytest over these tests in the copy; its output goes to `self.log`."""
        environment = os.environ | {"PYTHONPATH": str(self.site)}
        options = ["-q", "-x", "-n", "0", "-p", "no:cacheprovider", "--timeout", "300"]
        # -m "": with slow tests and all draws of properties.
        command = [sys.executable, "-m", "pytest", *options, "-m", ""]
        with self.log.open("w", encoding="utf-8") as log:
            return subprocess.run(
                [*command, *tests], cwd=self.source, env=environment, stdout=log, stderr=subprocess.STDOUT
            ).returncode

    def try_fault(self, fault: Fault) -> str:
        """The verdict: caught, survived, or why the fault could not be tried. Restores the headers."""
        header = self.source / "core" / fault.file
        text, times = header.read_text(encoding="utf-8"), header.stat()
        try:
            fault.apply(self.source / "core")
            if fault.units:
                self.make_faulty(fault)
            status = self.run_tests(fault.tests)
        except subprocess.CalledProcessError:
            return "does not compile"
        finally:
            header.write_text(text, encoding="utf-8")
            os.utime(header, ns=(times.st_atime_ns, times.st_mtime_ns))
            self.extension.write_bytes(self.sound)
        if status in NOT_RUN:
            return f"tests not run: pytest exits with {status}"
        return "survived" if status == SURVIVED else "caught"


def main() -> int:
    """Try the faults and print a table of verdicts."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--only", nargs="+", metavar="NAME", help="names of faults; all by default")
    parser.add_argument("--work", type=Path, default=ROOT / "build" / "faults", help="working directory")
    options = parser.parse_args()
    faults = [f for f in read_faults() if not options.only or f.name in options.only]
    workplace = Workplace(options.work.resolve())
    if not workplace.is_imported():
        print("The tests would import an installed hardlimit. Use an environment without it.")
        return 1
    tests = sorted({test for fault in faults for test in fault.tests})
    kept = options.work / "verdicts.json"
    verdicts = json.loads(kept.read_text(encoding="utf-8")) if kept.exists() else {}
    tests = [test for test in tests if verdicts.get(test) != digest(test, [test], workplace.source)]
    if tests and workplace.run_tests(tests) != 0:
        print("The tests do not pass without a fault:", workplace.log.read_text(encoding="utf-8"), sep="\n")
        return 1
    verdicts |= {test: digest(test, [test], workplace.source) for test in tests}
    bad = 0
    for fault in faults:
        key = digest(repr(fault), fault.tests, workplace.source)
        if key not in verdicts:
            verdicts[key] = workplace.try_fault(fault)
            kept.write_text(json.dumps(verdicts), encoding="utf-8")
        bad += verdicts[key] != "caught"
        print(f"{verdicts[key]:20} {fault.name:22} {fault.file:36} {fault.why}", flush=True)
    print(f"{len(faults)} faults, {bad} not caught")
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main())
