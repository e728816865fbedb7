"""The explorer's page and its server. What the page does in a browser is tested by web/ci.sh."""

import http.client
import json
import math
import re
import shutil
import struct
import subprocess
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

import hardlimit as hl
from hardlimit.explorer import server

ROOT = Path(__file__).resolve().parents[1]
GOLDEN = ROOT / "tests" / "data" / "golden_wasm.json"


@pytest.fixture(scope="module")
def address() -> Iterator[tuple[str, int]]:
    with server.PageServer(0) as running:
        thread = threading.Thread(target=running.serve_forever)
        thread.start()
        yield (server.HOST, running.server_address[1])
        running.shutdown()
        thread.join()


def get(
    address: tuple[str, int], path: str, method: str = "GET"
) -> tuple[int, http.client.HTTPMessage, bytes]:
    connection = http.client.HTTPConnection(*address, timeout=10)
    connection.request(method, path)
    response = connection.getresponse()
    content = response.read()
    connection.close()
    return response.status, response.headers, content


def test_every_file_is_served_with_its_type_and_the_policy(address: tuple[str, int]) -> None:
    files = server.page_files()
    assert set(files) == {"index.html", "main.js", "worker.js", "style.css", "core.wasm", "icon.svg"}
    for name, content in files.items():
        status, headers, body = get(address, f"/{name}")
        assert (status, body) == (200, content)
        assert headers["Content-Security-Policy"] == server.CONTENT_SECURITY_POLICY
        assert headers["X-Content-Type-Options"] == "nosniff"
    assert get(address, "/core.wasm")[1]["Content-Type"] == "application/wasm"


def test_a_link_with_parameters_is_the_page(address: tuple[str, int]) -> None:
    status, _, body = get(address, "/?e=0.8&gap=1e-3")
    assert (status, body) == (200, server.page_files()["index.html"])


@pytest.mark.parametrize("path", ["/nothing", "/../server.py", "/%2e%2e/server.py", "//etc/passwd", "/page/"])
def test_nothing_else_is_served(address: tuple[str, int], path: str) -> None:
    status, headers, _ = get(address, path)
    assert status == 404
    assert "Content-Security-Policy" in headers


def test_head_has_no_body(address: tuple[str, int]) -> None:
    status, headers, body = get(address, "/", "HEAD")
    assert (status, body) == (200, b"")
    assert int(headers["Content-Length"]) == len(server.page_files()["index.html"])


def test_serve_says_where_and_opens_the_browser(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    opened: list[str] = []
    monkeypatch.setattr(server.webbrowser, "open", opened.append)

    def interrupt(self: server.PageServer) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(server.PageServer, "serve_forever", interrupt)
    server.serve(0, open_browser=False)
    assert not opened
    server.serve(0, open_browser=True)
    assert re.fullmatch(r"http://127\.0\.0\.1:\d+/", opened[0])
    assert opened[0] in capsys.readouterr().out


def test_a_busy_port_is_an_error(address: tuple[str, int]) -> None:
    with pytest.raises(OSError):
        server.serve(address[1], open_browser=False)


def test_the_page_asks_nobody_else() -> None:
    """No address of another host in any file; the name of the SVG format is no address to fetch."""
    for name, content in server.page_files().items():
        text = content.decode("latin-1").replace("http://www.w3.org/2000/svg", "")
        assert not re.search(r"https?://|wss?://|//[a-z0-9-]+\.[a-z]{2,}/", text), name


def test_the_page_states_the_policy_of_the_header() -> None:
    html = server.page_files()["index.html"].decode()
    stated = re.search(r'http-equiv="Content-Security-Policy" content="([^"]+)"', html)
    assert stated
    assert stated[1] + "; frame-ancestors 'none'" == server.CONTENT_SECURITY_POLICY
    assert not re.search(r"<script(?! type=\"module\" src=)|<style|\son\w+=|\sstyle=", html)


def decode(digits: str) -> float:
    return math.nan if digits == "nan" else float(struct.unpack(">d", bytes.fromhex(digits))[0])


def test_golden_values_are_those_of_the_package() -> None:
    """The page's golden values hold the bits that Python returns for Fig. 2 and the digits known of it."""
    case = json.loads(GOLDEN.read_text(encoding="utf-8"))["cases"][0]
    runs = {run["model"]: run["run"] for run in case["runs"] if run["until"] == "nan"}
    column = hl.Column.paper()
    for model, result in enumerate([hl.newton(column), hl.adiabatic(column), hl.independent(column)]):
        reply = [decode(x) for x in runs[model]["reply"]]
        assert reply[1] == result.n_contacts
        # Masses differ by rounding: the density times the volume is not multiplied in the same order.
        assert reply[4] == pytest.approx(result.relative_velocity, rel=1e-12)
        assert reply[5] == pytest.approx(result.separation_velocity, rel=1e-12)
    newton = [decode(x) for x in runs[0]["reply"]]
    assert newton[4] == pytest.approx(0.171710897878, abs=1e-9)
    assert newton[3] == pytest.approx(775.172e-6, abs=1e-9)


@pytest.mark.skipif(not shutil.which("g++"), reason="no compiler")
@pytest.mark.slow
def test_golden_values_are_current(tmp_path: Path) -> None:
    subprocess.run([ROOT / "web" / "golden.sh", tmp_path / "golden.json"], check=True)
    assert (tmp_path / "golden.json").read_text() == GOLDEN.read_text()
