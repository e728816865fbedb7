"""The explorer's page and its server. What the page does in a browser is tested by web/ci.sh."""

import contextlib
import http.client
import json
import math
import re
import runpy
import shutil
import socket
import struct
import subprocess
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

import hardlimit as hl
from hardlimit.explorer import server

ROOT = Path(__file__).resolve().parents[2]
GOLDEN = ROOT / "tests" / "data" / "golden_wasm.json"


@contextlib.contextmanager
def serving(running: server.PageServer) -> Iterator[server.PageServer]:
    with running:
        thread = threading.Thread(target=running.serve_forever)
        thread.start()
        yield running
        running.shutdown()
        thread.join()


@pytest.fixture(scope="module")
def address() -> Iterator[tuple[str, int]]:
    with serving(server.PageServer(0)) as running:
        yield (server.HOST, running.server_address[1])


Address = tuple[str, int]


def get(address: Address, path: str, method: str = "GET") -> tuple[int, http.client.HTTPMessage, bytes]:
    connection = http.client.HTTPConnection(*address, timeout=10)
    connection.request(method, path)
    response = connection.getresponse()
    content = response.read()
    connection.close()
    return response.status, response.headers, content


def test_every_file_is_served_with_its_type_and_the_policy(address: tuple[str, int]) -> None:
    files = server.page_files()
    code = {"index.html", "first.js", "main.js", "tools.js", "worker.js", "style.css", "icon.svg"}
    gas = {"gas.html", "gas.js", "gas_worker.js", "gas.css", "gas.wasm", "gas_friction.wasm"}
    assert set(files) == code | gas | {"core.wasm", "maps.wasm"}
    for name, content in files.items():
        status, headers, body = get(address, f"/{name}")
        assert (status, body) == (200, content)
        assert headers["Content-Security-Policy"] == f"{server.PAGE_POLICY}; {server.WHOLE_PAGE_IN_FRAMES}"
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


@pytest.mark.parametrize(
    ("path", "in_frames"),
    [
        ("/?panel=film&e=0.8", server.PANEL_IN_FRAMES),
        ("/index.html?e=0.8&panel=map#top", server.PANEL_IN_FRAMES),
        ("/", server.WHOLE_PAGE_IN_FRAMES),
        ("/?panels=film", server.WHOLE_PAGE_IN_FRAMES),
        ("/?e=panel", server.WHOLE_PAGE_IN_FRAMES),
        ("/#?panel=film", server.WHOLE_PAGE_IN_FRAMES),
        ("//[?story=drop", server.WHOLE_PAGE_IN_FRAMES),
    ],
)
def test_only_single_panels_may_be_framed(address: tuple[str, int], path: str, in_frames: str) -> None:
    """Pages on this machine may frame a panel; no page may frame the whole page."""
    assert get(address, path)[1]["Content-Security-Policy"] == f"{server.PAGE_POLICY}; {in_frames}"


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
    server.serve(0, open_browser=True, page="gas.html")
    assert re.fullmatch(r"http://127\.0\.0\.1:\d+/", opened[0]) and opened[1].endswith("/gas.html")
    said = capsys.readouterr().out
    assert opened[0] in said and opened[1] in said


def test_a_busy_port_is_refused(address: tuple[str, int]) -> None:
    with pytest.raises(ValueError, match=rf"port: got {address[1]}, must be free \(0 takes a free one\): \w"):
        server.serve(address[1], open_browser=False)


def exchange(address: tuple[str, int], request: bytes) -> bytes:
    """The complete response to raw bytes."""
    with socket.create_connection(address, timeout=30) as connection:
        connection.sendall(request)
        return b"".join(iter(lambda: connection.recv(65536), b""))


@pytest.mark.parametrize(
    "host", ["evil.example", "evil.example:{port}", "127.0.0.1", "localhost:1", "[::1]:{port}", ""]
)
def test_a_foreign_host_is_not_answered(address: tuple[str, int], host: str) -> None:
    """Such requests come from a page of another site whose name was made to resolve to this machine."""
    lines = ["GET / HTTP/1.1", f"Host: {host.format(port=address[1])}", "Connection: close", "", ""]
    answer = exchange(address, "\r\n".join(lines).encode())
    assert answer.startswith(b"HTTP/1.1 421 ") and b"<html" not in answer
    without = exchange(address, b"GET / HTTP/1.1\r\nConnection: close\r\n\r\n")
    assert without.startswith(b"HTTP/1.1 421 ")


@pytest.mark.parametrize("name", ["127.0.0.1", "localhost", "LocalHost"])
def test_this_machine_is_answered(address: tuple[str, int], name: str) -> None:
    lines = ["GET / HTTP/1.1", f"Host: {name}:{address[1]}", "Connection: close", "", ""]
    assert exchange(address, "\r\n".join(lines).encode()).startswith(b"HTTP/1.1 200 ")


@pytest.mark.parametrize(
    "path", ["http://[::1/x", "//[", "http://]/", "/%ff%00", "*", "?", "#", "/index.html/"]
)
def test_invalid_addresses_are_not_reported(
    address: tuple[str, int], path: str, capfd: pytest.CaptureFixture[str]
) -> None:
    lines = [f"GET {path} HTTP/1.1", f"Host: 127.0.0.1:{address[1]}", "Connection: close", "", ""]
    status = exchange(address, "\r\n".join(lines).encode()).split(b" ", 2)[1]
    assert status == (b"200" if path in ("?", "#") else b"404")
    assert capfd.readouterr().err == ""


class Ends:
    """Counts closed connections of a server, so that a test can wait for one."""

    def __init__(self, running: server.PageServer, monkeypatch: pytest.MonkeyPatch) -> None:
        self.done = threading.Semaphore(0)
        shutdown = running.shutdown_request

        def ended(request: socket.socket) -> None:
            shutdown(request)
            self.done.release()

        monkeypatch.setattr(running, "shutdown_request", ended)

    def wait(self) -> bool:
        return self.done.acquire(timeout=60)


def test_a_connection_closed_by_the_browser_is_not_reported(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    with serving(server.PageServer(0)) as running:
        running.files = {"index.html": bytes(50_000_000)}  # more than the sockets hold
        ends = Ends(running, monkeypatch)
        address = (server.HOST, running.server_address[1])
        with socket.create_connection(address, timeout=30) as browser:
            browser.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))  # close by reset
            browser.sendall(f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{address[1]}\r\n\r\n".encode())
            assert browser.recv(100).startswith(b"HTTP/1.1 200")
        assert ends.wait()
    assert capfd.readouterr().err == ""


def test_other_errors_of_the_server_are_reported(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    with serving(server.PageServer(0)) as running:
        monkeypatch.setattr(running, "files", None)
        ends = Ends(running, monkeypatch)
        address = (server.HOST, running.server_address[1])
        exchange(address, f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{address[1]}\r\n\r\n".encode())
        assert ends.wait()
    assert "TypeError" in capfd.readouterr().err


@pytest.mark.parametrize("sent", [b"", b"GET / HT", b"GET / HTTP/1.1\r\nHost: 127", b"GET / HTTP/1.1\r\n"])
def test_a_silent_connection_is_closed(sent: bytes, capfd: pytest.CaptureFixture[str]) -> None:
    with serving(server.PageServer(0, silence=0.1)) as running:
        assert exchange((server.HOST, running.server_address[1]), sent) == b""
    assert capfd.readouterr().err == ""


def test_the_page_loads_nothing_from_other_hosts() -> None:
    """No file has the address of another host, except the name of the SVG format."""
    files = server.page_files()
    assert len(files) > 3 and "index.html" in files
    for name, content in files.items():
        text = content.decode("latin-1").replace("http://www.w3.org/2000/svg", "")
        assert not re.search(r"https?://|wss?://|//[a-z0-9-]+\.[a-z]{2,}/", text), name


def test_the_page_states_the_policy_of_the_header() -> None:
    html = server.page_files()["index.html"].decode()
    stated = re.search(r'http-equiv="Content-Security-Policy" content="([^"]+)"', html)
    assert stated
    assert stated[1] == server.PAGE_POLICY
    assert not re.search(r"<script(?!( type=\"module\")? src=)|<style|\son\w+=|\sstyle=", html)


def decode(digits: str) -> float:
    return math.nan if digits == "nan" else float(struct.unpack(">d", bytes.fromhex(digits))[0])


def test_golden_values_are_those_of_the_package() -> None:
    """The golden values of the page agree with Python for Fig. 2."""
    case = json.loads(GOLDEN.read_text(encoding="utf-8"))["cases"][0]
    runs = {run["model"]: run["run"] for run in case["runs"] if run["until"] == "nan"}
    column = hl.Column.paper()
    for model, result in enumerate([hl.newton(column), hl.adiabatic(column), hl.independent(column)]):
        reply = [decode(x) for x in runs[model]["reply"]]
        assert reply[1] == result.n_contacts
        # Masses differ by rounding: density and volume are multiplied in a different order.
        assert reply[4] == pytest.approx(result.relative_velocity, rel=1e-12)
        assert reply[5] == pytest.approx(result.separation_velocity, rel=1e-12)
    newton = [decode(x) for x in runs[0]["reply"]]
    assert newton[4] == pytest.approx(0.171710897878, abs=1e-9)
    assert newton[3] == pytest.approx(775.172e-6, abs=1e-9)


@pytest.mark.skipif(not shutil.which("g++"), reason="no compiler")
@pytest.mark.slow
def test_golden_values_are_current(tmp_path: Path) -> None:
    subprocess.run([ROOT / "tests" / "web" / "golden.sh", tmp_path / "golden.json"], check=True)
    assert (tmp_path / "golden.json").read_text() == GOLDEN.read_text()


@pytest.mark.slow
def test_the_table_of_the_gas_is_of_the_present_theory_of_friction() -> None:
    """After a change of the theory, `python web/friction_table.py` and `web/build.sh` renew it."""
    program = runpy.run_path(str(ROOT / "web/friction_table.py"))
    table = json.loads((ROOT / "web/src/gas/friction_table.json").read_text(encoding="utf-8"))
    theory = program["frictional_error"]
    assert (*table["third"], *table["bar"]) == (*theory.THIRD[0], *theory.BAR)
    axes = [program[name] for name in ("RESTITUTION", "COEFFICIENT", "RATIO")]
    place = [2, 4, 6]
    index = (place[0] * len(axes[1]) + place[1]) * len(axes[2]) + place[2]
    row = program["row"](*(axis[i] for axis, i in zip(axes, place, strict=True)))
    assert table["rows"][index] == pytest.approx(row, rel=1e-3)
    assert len(table["rows"]) == math.prod(map(len, axes))
