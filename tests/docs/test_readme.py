"""What the README shows is true: the Python session gives the printed results."""

import doctest
import re
from pathlib import Path

README = (Path(__file__).resolve().parents[2] / "README.md").read_text(encoding="utf-8")


def test_python_session() -> None:
    sessions = re.findall(r"```pycon\n(.*?)```", README, flags=re.DOTALL)
    assert sessions
    for session in sessions:
        test = doctest.DocTestParser().get_doctest(session, {}, "README.md", "README.md", 0)
        report: list[str] = []
        result = doctest.DocTestRunner(verbose=False).run(test, out=report.append)
        assert result.failed == 0, "".join(report)


def test_links_lead_to_files() -> None:
    targets = re.findall(r"\]\((?!https?:)([^)#]+)\)", README)
    root = Path(__file__).resolve().parents[2]
    assert [target for target in targets if not (root / target).exists()] == []
