"""Local server of the explorer page: static files only."""

import contextlib
import sys
import webbrowser
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib import resources
from urllib.parse import parse_qs

HOST = "127.0.0.1"

#: Host names that the server accepts. Any other name in the Host header belongs to a foreign site that was made to
#: resolve to this machine (DNS rebinding).
OWN_NAMES = (HOST, "localhost")

#: A connection is closed after this time without data [s].
TIMEOUT = 30.0

# The <meta> of the page has the same policy, for copies on other servers.
PAGE_POLICY = (
    "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self' blob:; style-src 'self'; "
    "img-src 'self' data: blob:; connect-src 'self'; base-uri 'none'; form-action 'none'"
)

# Framing, which only a header can control: the whole page in no frame, single panels in pages on this machine (slides,
# notebooks, the documentation).
WHOLE_PAGE_IN_FRAMES = "frame-ancestors 'none'"
PANEL_IN_FRAMES = "frame-ancestors 'self' http://127.0.0.1:* http://localhost:*"

TYPES = {
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".svg": "image/svg+xml",
    ".wasm": "application/wasm",
}


def page_files() -> dict[str, bytes]:
    """The files of the page, by name."""
    folder = resources.files("hardlimit.explorer") / "page"
    return {
        entry.name: entry.read_bytes()
        for entry in folder.iterdir()
        if entry.is_file() and any(entry.name.endswith(ending) for ending in TYPES)
    }


class PageServer(ThreadingHTTPServer):
    """A server with the files of the page in memory, so that no request can reach any other file.

    Port 0 takes a free port. A connection is closed after ``silence`` [s] without data.
    """

    daemon_threads = True

    def __init__(self, port: int, silence: float = TIMEOUT) -> None:
        self.files = page_files()
        self.silence = silence
        super().__init__((HOST, port), PageHandler)

    @property
    def url(self) -> str:
        return f"http://{HOST}:{self.server_address[1]}/"

    @property
    def own_hosts(self) -> frozenset[str]:
        """Accepted Host headers; browsers omit port 80."""
        port = self.server_address[1]
        names = {f"{name}:{port}" for name in OWN_NAMES}
        return frozenset(names | set(OWN_NAMES) if port == 80 else names)

    def handle_error(self, request: object, client_address: object) -> None:
        """Report errors, except that of a browser that closes the connection during a response."""
        if not isinstance(sys.exception(), ConnectionError | TimeoutError):
            super().handle_error(request, client_address)  # type: ignore[arg-type]


class PageHandler(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    server_version = "hardlimit"
    sys_version = ""
    server: PageServer

    def setup(self) -> None:
        super().setup()
        self.connection.settimeout(self.server.silence)

    def do_GET(self) -> None:
        self.reply(with_body=True)

    def do_HEAD(self) -> None:
        self.reply(with_body=False)

    @property
    def policy(self) -> str:
        """The Content-Security-Policy of the response."""
        query = parse_qs(self.path.partition("#")[0].partition("?")[2])
        return f"{PAGE_POLICY}; {PANEL_IN_FRAMES if 'panel' in query else WHOLE_PAGE_IN_FRAMES}"

    def reply(self, with_body: bool) -> None:
        name = self.path.partition("?")[0].partition("#")[0].removeprefix("/") or "index.html"
        status, content_type, body = HTTPStatus.NOT_FOUND, "text/plain; charset=utf-8", b"not found\n"
        if self.headers.get("Host", "").lower() not in self.server.own_hosts:
            status, body = HTTPStatus.MISDIRECTED_REQUEST, b"another host\n"
        elif name in self.server.files:
            status, content_type = HTTPStatus.OK, TYPES[name[name.rfind(".") :]]
            body = self.server.files[name]
        self.answer(status, content_type, body, with_body)

    def answer(self, status: HTTPStatus, content_type: str, body: bytes, with_body: bool) -> None:
        self.send_response(status)
        self.send_header("Content-Type", content_type)
        self.send_header("Content-Length", str(len(body)))
        self.send_header("Content-Security-Policy", self.policy)
        self.send_header("Cross-Origin-Resource-Policy", "same-origin")
        self.send_header("X-Content-Type-Options", "nosniff")
        self.send_header("Referrer-Policy", "no-referrer")
        self.send_header("Cache-Control", "no-cache")
        self.end_headers()
        if with_body:
            self.wfile.write(body)

    def log_message(self, format: str, *args: object) -> None:
        """Log no requests."""


def serve(port: int, open_browser: bool, page: str = "") -> None:
    """Serve the pages until interrupted, and open one of them. Port 0 takes a free port.

    Raises a ValueError if the port is taken or may not be used.
    """
    try:
        server = PageServer(port)
    except OSError as error:
        need = "must be free (0 takes a free one)"
        raise ValueError(f"port: got {port}, {need}: {error.strerror or error}") from None
    with server:
        print(f"The explorer is at {server.url}{page} (Ctrl-C ends it)", flush=True)
        if open_browser:
            webbrowser.open(server.url + page)
        with contextlib.suppress(KeyboardInterrupt):
            server.serve_forever()
