"""The pages for browsers of this computer, each made anew when it is asked for, and the logs they name."""

import os
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from urllib.parse import unquote, urlsplit

from triaxis.golden.errors import InputError
from triaxis.sim.paths import BUILD
from triaxis.verif.results.database import DATABASE
from triaxis.verif.results.pages import FOLDER, INDEX, page

# Where the pages are in build/: so that they name logs as the files do.
_PAGES = f"/{FOLDER.name}/"


def _log(path: str) -> bytes | None:
    """Return a log of build/, None where there is none of that name."""
    file = Path(os.path.realpath(BUILD / path.replace("\0", "").lstrip("/")))
    inside = file.is_relative_to(os.path.realpath(BUILD)) and file.suffix == ".log"
    return file.read_bytes() if inside and file.is_file() else None


def server(port: int, database: Path = DATABASE) -> ThreadingHTTPServer:
    """Return what serves the pages, 0 for any port that is free; raise InputError where that is not there."""

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            port = self.connection.getsockname()[1]
            path = unquote(urlsplit(self.path).path)
            # Of a page of another address, which may have a name for this one.
            if self.headers.get("Host") not in (f"127.0.0.1:{port}", f"localhost:{port}"):
                self.send_error(HTTPStatus.FORBIDDEN, "this is for browsers of this computer")
            elif path == "/":
                self.send_response(HTTPStatus.FOUND)
                self.send_header("Location", _PAGES + INDEX)
                self.end_headers()
            elif path.startswith(_PAGES):
                try:
                    made = page(path.removeprefix(_PAGES), database)
                except InputError as error:
                    self.send_error(HTTPStatus.INTERNAL_SERVER_ERROR, explain=str(error))
                else:
                    self._send("text/html; charset=utf-8", None if made is None else made.encode())
            else:
                self._send("text/plain; charset=utf-8", _log(path))

        def _send(self, kind: str, content: bytes | None) -> None:
            if content is None:
                self.send_error(HTTPStatus.NOT_FOUND)
                return
            self.send_response(HTTPStatus.OK)
            self.send_header("Content-Type", kind)
            self.send_header("Content-Length", str(len(content)))
            self.send_header("Cache-Control", "no-store")
            self.end_headers()
            self.wfile.write(content)

        # Not among what the command prints.
        def log_message(self, format: str, *args: object) -> None:  # noqa: A002
            return

    try:
        return ThreadingHTTPServer(("127.0.0.1", port), Handler)
    except (OSError, OverflowError) as error:
        raise InputError(
            f"--serve {port}: {getattr(error, 'strerror', None) or error}: name another"
        ) from error
