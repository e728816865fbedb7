"""Serves the explorer page on this machine: static files, nothing computed, nothing fetched."""

import contextlib
import webbrowser
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib import resources
from urllib.parse import urlsplit

HOST = "127.0.0.1"

# The page's own <meta> says the same, for copies served by others; frame-ancestors only works as a header.
CONTENT_SECURITY_POLICY = (
    "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'; style-src 'self'; "
    "img-src 'self' data: blob:; connect-src 'self'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'"
)

TYPES = {
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".svg": "image/svg+xml",
    ".wasm": "application/wasm",
}


def page_files() -> dict[str, bytes]:
    """The files of the page by name."""
    folder = resources.files("hardlimit.explorer") / "page"
    return {
        entry.name: entry.read_bytes()
        for entry in folder.iterdir()
        if entry.is_file() and any(entry.name.endswith(ending) for ending in TYPES)
    }


class PageServer(ThreadingHTTPServer):
    """Holds the files in memory: no request can reach anything else."""

    daemon_threads = True

    def __init__(self, port: int) -> None:
        self.files = page_files()
        super().__init__((HOST, port), PageHandler)

    @property
    def url(self) -> str:
        return f"http://{HOST}:{self.server_address[1]}/"


class PageHandler(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    server_version = "hardlimit"
    sys_version = ""

    def do_GET(self) -> None:
        self.reply(with_body=True)

    def do_HEAD(self) -> None:
        self.reply(with_body=False)

    def reply(self, with_body: bool) -> None:
        assert isinstance(self.server, PageServer)
        name = urlsplit(self.path).path.lstrip("/") or "index.html"
        body = self.server.files.get(name)
        found = body is not None
        if body is None:
            body = b"not found\n"
        self.send_response(HTTPStatus.OK if found else HTTPStatus.NOT_FOUND)
        ending = name[name.rfind(".") :]
        self.send_header("Content-Type", TYPES[ending] if found else "text/plain; charset=utf-8")
        self.send_header("Content-Length", str(len(body)))
        self.send_header("Content-Security-Policy", CONTENT_SECURITY_POLICY)
        self.send_header("Cross-Origin-Resource-Policy", "same-origin")
        self.send_header("X-Content-Type-Options", "nosniff")
        self.send_header("Referrer-Policy", "no-referrer")
        self.send_header("Cache-Control", "no-cache")
        self.end_headers()
        if with_body:
            self.wfile.write(body)

    def log_message(self, format: str, *args: object) -> None:
        """Requests are not logged."""


def serve(port: int, open_browser: bool) -> None:
    """Serve the page until interrupted. Port 0 takes a free one."""
    with PageServer(port) as server:
        print(f"The explorer is at {server.url} (Ctrl-C ends it)", flush=True)
        if open_browser:
            webbrowser.open(server.url)
        with contextlib.suppress(KeyboardInterrupt):
            server.serve_forever()
