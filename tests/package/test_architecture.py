"""Dependencies have one direction: includes of C++ headers and imports of Python modules.

The layers of the Python modules are checked by import-linter (pyproject.toml).
"""

import ast
import re
import unicodedata
from pathlib import Path, PurePosixPath

ROOT = Path(__file__).resolve().parents[2]
CORE = ROOT / "core"
PACKAGE = ROOT / "src" / "hardlimit"

# A header may include headers of its own folder and of folders of a lower rank. "." is core/ itself.
RANK = {
    "base": 0,
    "contact": 1,
    "column": 2,
    "column/exact": 3,
    "column/general": 3,
    "sweep": 5,
    "boxes/common": 2,
    "boxes/kernels": 3,
    "boxes/neighbours": 4,
    "boxes/binary_contact": 4,
    "boxes/queue": 5,
    "boxes/hard_spheres/rules": 5,
    "boxes/hard_spheres": 6,
    "boxes/newton_events/cluster": 5,
    "boxes/newton_events": 6,
    "boxes/newton_steps": 6,
}

# No Python, no input or output, no libm: math.hpp has elementary functions that are bit-identical everywhere.
FORBIDDEN_INCLUDE = re.compile(
    r"Python\.h|nanobind|pybind11|c?math(\.h)?|c?stdio(\.h)?|iostream|fstream|sstream"
)

# Names of compilers, devices and platforms. The builtins for infinity and NaN are exempt: they are constants that
# every supported compiler has.
PLATFORM = re.compile(
    r"__CUDA\w*|__NVCC__|__GNUC__|__clang__|_MSC_VER|__wasm\w*|__EMSCRIPTEN__|__AVX\w*|__SSE\w*|__x86_64__|__aarch64__"
    r"|__attribute__|__device__|__host__|__global__|#\s*pragma\s+(?:GCC|clang)\b"
    r"|__builtin_(?!huge_val\b|nan\b)\w+"
)

# These may import the package as a user does; all other modules import modules.
USERS_OF_THE_PACKAGE = {"__main__", "cli", "explorer", "paper"}


# The headers that choose among the solvers; each solver has its own folder.
RANK_OF_FILE = {"column/solve.hpp": 4, "column/rebound.hpp": 4}


def rank(path: PurePosixPath) -> int:
    return RANK_OF_FILE.get(str(path), RANK[str(path.parent)])


def headers() -> dict[PurePosixPath, str]:
    return {
        PurePosixPath(path.relative_to(CORE).as_posix()): path.read_text(encoding="utf-8")
        for path in sorted(CORE.rglob("*.hpp"))
    }


def without_comments(text: str) -> str:
    return re.sub(r"//[^\n]*|/\*.*?\*/", "", text, flags=re.DOTALL)


def included(path: PurePosixPath, name: str) -> PurePosixPath:
    """Path relative to core/ of the file that #include "name" in the header at ``path`` refers to."""
    parts: list[str] = []
    for part in (path.parent / name).parts:
        if part == "..":
            parts.pop()
        else:
            parts.append(part)
    return PurePosixPath(*parts)


def include_faults(files: dict[PurePosixPath, str]) -> list[str]:
    faults = []
    for path, text in files.items():
        for opening, name in re.findall(r'#\s*include\s*([<"])([^>"]+)[>"]', without_comments(text)):
            if FORBIDDEN_INCLUDE.search(name) and not (opening == '"' and name.endswith("math.hpp")):
                faults.append(f"{path} includes {name}")
            if opening == "<":
                continue
            target = included(path, name)
            if target not in files:
                faults.append(f"{path} includes {name}, which does not exist")
            elif target.parent != path.parent and rank(target) >= rank(path):
                faults.append(f"{path} includes {target}, against the direction")
    return faults


def platform_faults(files: dict[PurePosixPath, str]) -> list[str]:
    return [
        f"{path} mentions {name}"
        for path, text in files.items()
        if path != PurePosixPath("base/portable.hpp")
        for name in PLATFORM.findall(without_comments(text))
    ]


def package_import_faults(module: str, source: str) -> list[str]:
    """Imports of the package hardlimit, instead of one of its modules, in the module hardlimit.a.b."""
    if module.split(".")[0] in USERS_OF_THE_PACKAGE:
        return []
    faults = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names if alias.name == "hardlimit"]
        elif isinstance(node, ast.ImportFrom):
            from_package = node.module == "hardlimit" if node.level == 0 else node.module is None
            from_package = from_package and node.level in (0, module.count(".") + 1)
            names = [a.name for a in node.names if from_package and not is_module(a.name)]
        else:
            continue
        faults += [f"{module}, line {node.lineno}: imports {name} from the package itself" for name in names]
    return faults


def is_module(name: str) -> bool:
    return name == "_core" or (PACKAGE / f"{name}.py").exists() or (PACKAGE / name / "__init__.py").exists()


def test_headers_include_in_one_direction() -> None:
    assert include_faults(headers()) == []


def test_every_folder_of_headers_has_a_rank() -> None:
    assert {str(path.parent) for path in headers()} <= RANK.keys()


def test_only_portable_names_a_platform() -> None:
    assert platform_faults(headers()) == []


def test_modules_do_not_import_the_package() -> None:
    faults = []
    for path in sorted(PACKAGE.rglob("*.py")):
        module = ".".join(path.relative_to(PACKAGE).with_suffix("").parts)
        if module != "__init__":
            faults += package_import_faults(module, path.read_text(encoding="utf-8"))
    assert faults == []


def test_the_checks_see_faults() -> None:
    files = {
        PurePosixPath("base/math.hpp"): "#include <cmath>\nint a = __builtin_clz(1);  // __builtin_ctz",
        PurePosixPath("base/portable.hpp"): "#if defined(__CUDACC__)\n#endif",
        PurePosixPath("contact/law.hpp"): '#include "../column/state.hpp"\n#include "../base/math.hpp"',
        PurePosixPath("column/state.hpp"): '#include "../contact/law.hpp"\n#ifdef __GNUC__\n#endif',
        PurePosixPath("column/solver.hpp"): '#include "../sweep/lanes.hpp"\ndouble nan = __builtin_nan("");',
    }
    assert include_faults(files) == [
        "base/math.hpp includes cmath",
        "contact/law.hpp includes column/state.hpp, against the direction",
        "column/solver.hpp includes ../sweep/lanes.hpp, which does not exist",
    ]
    assert platform_faults(files) == [
        "base/math.hpp mentions __builtin_clz",
        "column/state.hpp mentions __GNUC__",
    ]
    assert package_import_faults("laws", "import hardlimit as hl")
    assert package_import_faults("laws", "from . import newton")
    assert package_import_faults("laws", "from hardlimit import newton")
    assert not package_import_faults(
        "laws", "from . import _core\nfrom ._core import x\nimport hardlimit.column"
    )
    assert not package_import_faults("paper.figures", "import hardlimit as hl")


def test_no_line_of_cpp_is_too_long() -> None:
    """clang-format breaks code at 110 columns but not comments; combining characters take no column."""
    folders = ["core", "bindings", "tests", "benchmarks", "web"]
    sources = [path for folder in folders for path in (ROOT / folder).rglob("*.?pp")] + [
        *ROOT.glob("core/**/*.cu")
    ]
    long = [
        f"{path.relative_to(ROOT)}, line {number}"
        for path in sources
        if "node_modules" not in path.parts
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1)
        if sum(not unicodedata.combining(letter) for letter in line) > 120
    ]
    assert long == []


def test_usable_processors_are_counted_in_one_place() -> None:
    files = [
        p.name
        for p in PACKAGE.rglob("*.py")
        if re.search(r"sched_getaffinity|cpu_count", p.read_text("utf-8"))
    ]
    assert files == ["machine.py"]
