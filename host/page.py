"""A page for the browser that shows a machine while it is followed: where the tool is, how far it may go.

Served to this computer alone, and to pages of its own. The page draws with Plotly, of the Python package of
that name, and needs no network; what happens comes as server-sent events, the newest state twenty times a
second at most. A browser can change nothing, and is given what was made before the machine started: bytes, by
threads that wait for it, and let others go on.
"""

import atexit
import json
import threading
import time
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from triaxis.golden.errors import InputError
from triaxis.host.stl import Facets

_LEAST_SECONDS = 0.05
# Of a browser that says nothing, or reads nothing; and how many there may be at a time.
_PATIENCE_SECONDS, _MOST = 5, 16
# A browser that went away is noticed by writing to it.
_QUIET_SECONDS = 1.0
# What browsers are given for the last news, where the command ends.
_LAST_SECONDS = 0.5
_TEXT, _SCRIPT, _JSON = "text/html; charset=utf-8", "text/javascript", "application/json"

State = dict[str, Any]


def mesh_of(facets: Facets) -> dict[str, list[float] | list[int]]:
    """Return facets (N, 3, 3) as Plotly's mesh3d has them: vertices x, y, z, and three of them by number."""
    vertices, numbers = np.unique(facets.reshape(-1, 3).astype(np.float64), axis=0, return_inverse=True)
    faces = numbers.reshape(-1, 3).T
    return {name: array.tolist() for name, array in zip("xyzijk", (*vertices.T, *faces), strict=True)}


def line_of(points: npt.NDArray[np.float64]) -> dict[str, list[float]]:
    """Return points (N, 3) as coordinates x, y, z."""
    return {name: column.tolist() for name, column in zip("xyz", points.T, strict=True)}


class Page:
    """A page at an address of this computer, from when it is made until the process ends."""

    def __init__(self, port: int) -> None:
        """Serve at a port, 0 for any that is free; raise InputError where that, or Plotly, is not there."""
        try:
            self._plotly = import_module("plotly.offline").get_plotlyjs().encode()
        except ImportError as error:
            raise InputError("--page: plotly is not installed: pip install plotly") from error
        self._page = Path(__file__).with_name("page.html").read_bytes()
        self._changed = threading.Condition()
        self._scene = b"{}"
        self._state: State = {}
        self._version, self._since = 0, time.monotonic()
        try:
            self._server = _Server(("127.0.0.1", port), self._handler())
        except (OSError, OverflowError) as error:
            raise InputError(
                f"--page {port}: {getattr(error, 'strerror', None) or error}: name another"
            ) from error
        threading.Thread(target=self._server.serve_forever, daemon=True).start()
        # What was sent to each browser; each is to have the last news before the process ends.
        self._sent: dict[int, int] = {}
        atexit.register(self._send_last)

    @property
    def address(self) -> str:
        """Return where the page is."""
        return f"http://127.0.0.1:{self._server.server_address[1]}/"

    def show(self, tool: Facets, work: Facets, ends: npt.NDArray[np.float64], title: str) -> None:
        """Show a tool in its own frame, a workpiece, and the ends (N, 3) of the pieces, in millimetres.

        It takes a second for 100,000 facets, in which no machine may wait.
        """
        scene = {"tool": mesh_of(tool), "work": mesh_of(work), "path": line_of(ends), "title": title}
        made = json.dumps(scene).encode()
        with self._changed:
            self._scene = made
        self.tell(scene=self._version + 1, pieces=len(ends) - 1, permitted=0, verdict=None, stopped=None)

    def tell(self, **changes: object) -> None:
        """Change what the page says; a verdict begins to age."""
        with self._changed:
            self._state |= changes
            if "verdict" in changes:
                self._since = time.monotonic()
            self._version += 1
            self._changed.notify_all()

    def _send_last(self) -> None:
        with self._changed:
            self._changed.wait_for(
                lambda: all(sent == self._version for sent in self._sent.values()), _LAST_SECONDS
            )

    def _handler(self) -> type[BaseHTTPRequestHandler]:
        page = self

        class Handler(BaseHTTPRequestHandler):
            timeout = _PATIENCE_SECONDS

            def do_GET(self) -> None:
                own = f"127.0.0.1:{page._server.server_address[1]}"
                answers = {
                    "/": (_TEXT, page._page),
                    "/plotly.js": (_SCRIPT, page._plotly),
                    "/scene": (_JSON, page._scene),
                }
                # Of a page of another address, which may have a name for this one.
                if self.headers.get("Host") != own:
                    self.send_error(HTTPStatus.FORBIDDEN)
                elif self.path == "/states":
                    self._begin("text/event-stream")
                    page._send_states(self)
                elif self.path in answers:
                    kind, content = answers[self.path]
                    self._begin(kind)
                    self.wfile.write(content)
                else:
                    self.send_error(HTTPStatus.NOT_FOUND)

            def _begin(self, kind: str) -> None:
                self.send_response(HTTPStatus.OK)
                self.send_header("Content-Type", kind)
                self.send_header("Cache-Control", "no-store")
                self.end_headers()

            # Not among what the command prints.
            def log_message(self, format: str, *args: object) -> None:  # noqa: A002
                return

        return Handler

    def _send_states(self, handler: BaseHTTPRequestHandler) -> None:
        sent, browser = -1, threading.get_ident()
        try:
            while True:
                with self._changed:
                    self._sent[browser] = sent
                    if self._version == sent:
                        self._changed.wait(_QUIET_SECONDS)
                    age = time.monotonic() - self._since
                    sent, state = self._version, self._state | {"age": round(1000 * age)}
                handler.wfile.write(f"data: {json.dumps(state)}\n\n".encode())
                handler.wfile.flush()
                with self._changed:
                    self._sent[browser] = sent
                    self._changed.notify_all()
                time.sleep(_LEAST_SECONDS)
        # The browser has gone.
        except OSError:
            return
        finally:
            with self._changed:
                self._sent.pop(browser, None)
                self._changed.notify_all()


class _Server(ThreadingHTTPServer):
    """Serves so many connections at a time, and no more; one that fails is of no interest."""

    daemon_threads = True

    def __init__(self, *arguments: Any) -> None:
        """Begin."""
        super().__init__(*arguments)
        self._free = threading.BoundedSemaphore(_MOST)

    def process_request(self, request: Any, client_address: Any) -> None:
        """Serve it by a thread, where there is one left."""
        if self._free.acquire(blocking=False):
            super().process_request(request, client_address)
        else:
            self.shutdown_request(request)

    def process_request_thread(self, request: Any, client_address: Any) -> None:
        """Serve it."""
        try:
            super().process_request_thread(request, client_address)
        finally:
            self._free.release()

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Say nothing: a browser went away."""
