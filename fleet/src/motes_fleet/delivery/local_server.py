"""A small HTTP server: for pages that a run shows of itself, and for annotation tools.

Nobody who asks can hold it up: a request has a limited time and size, and so has the number of open
connections.
"""

from __future__ import annotations

import io
import threading
import time
from collections.abc import Callable
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any, Self

from motes import ConfigError
from motes.core import foreign
from motes_fleet.delivery.timed_reader import TimedReader

SLOWEST = 5.0
"""Seconds after which a reader that takes nothing is dropped."""
REQUEST = 10.0
"""Seconds within which a request must have arrived whole."""
LARGEST_REQUEST = 64 << 20
"""Bytes of a request."""
CONNECTIONS = 32
"""Connections that are open at once; more are closed unread."""

Answer = Callable[[BaseHTTPRequestHandler], None]


class Server(ThreadingHTTPServer):
    """Serves until it is closed; each request has a thread of its own.

    Parameters
    ----------
    host, port
        Where it listens; port 0 means any that is free.
    answer
        Called with each GET request; it sends the answer.
    post
        Called with each POST request, and its body; none is taken by default.

    Raises
    ------
    ConfigError
        If it cannot listen there.
    """

    daemon_threads = True
    block_on_close = False  # a reader that takes nothing must not hold up the end of the run

    def __init__(
        self,
        host: str,
        port: int,
        answer: Answer,
        post: Callable[[BaseHTTPRequestHandler, bytes], None] | None = None,
    ) -> None:
        class Handler(BaseHTTPRequestHandler):
            def setup(self) -> None:
                super().setup()
                self.rfile.close()
                timed = TimedReader(self.connection, REQUEST, LARGEST_REQUEST)
                self.rfile = io.BufferedReader(timed)

            def do_GET(self) -> None:
                """Answer a request; a reader that goes away is no error."""
                if self.admitted():
                    answer(self)

            def do_POST(self) -> None:
                """Answer a request once it is whole."""
                if not self.admitted():
                    return
                if post is None:
                    reply(self, "text/plain", b"Nothing is taken here.\n", 405)
                    return
                given = self.headers.get("Content-Length") or "0"
                if not (given.isdecimal() and len(given) < 16):
                    reply(self, "text/plain", b"The Content-Length is no number of bytes.\n", 400)
                elif int(given) > LARGEST_REQUEST:
                    reply(self, "text/plain", b"The request is too large.\n", 413)
                else:
                    body = self.rfile.read(int(given))
                    self.connection.settimeout(SLOWEST)
                    post(self, body)

            def admitted(self) -> bool:
                """Return whether the request is of no foreign page; else refuse it."""
                self.connection.settimeout(SLOWEST)
                error = foreign(host, self.headers.get("Host"), self.headers.get("Origin"))
                if error is not None:
                    reply(self, "text/plain", f"{error}\n".encode(), 403)
                return error is None

            def log_message(self, *_: Any) -> None:
                """Log nothing."""

        self._free = threading.BoundedSemaphore(CONNECTIONS)
        if not host:
            raise ConfigError("The host is empty; give this computer's name, or 127.0.0.1.")
        try:
            super().__init__((host, port), Handler)
        except (OSError, OverflowError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            raise ConfigError(
                f"Nothing can be served at {host}:{port}: {reason}; choose another host or port."
            ) from error

    def start(self) -> Self:
        """Serve in a thread, until `close`."""
        threading.Thread(target=self.serve_forever, args=(0.05,), daemon=True).start()
        return self

    def get_request(self) -> Any:
        """Return the next connection; without a free file descriptor, wait a little."""
        try:
            return super().get_request()
        except OSError:
            time.sleep(0.1)  # else it would be tried again at once, for ever
            raise

    def process_request(self, request: Any, client_address: Any) -> None:
        """Answer a request in a thread, unless too many are open."""
        if not self._free.acquire(blocking=False):
            self.shutdown_request(request)
            return
        try:
            super().process_request(request, client_address)
        except BaseException:
            self._free.release()
            raise

    def process_request_thread(self, request: Any, client_address: Any) -> None:
        """Answer a request."""
        try:
            super().process_request_thread(request, client_address)
        finally:
            self._free.release()

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Drop a request that fails, as of a client that has gone; the run goes on."""

    @property
    def address(self) -> str:
        """The address of its first page."""
        host, port = self.server_address[:2]
        return f"http://{host!s}:{port}/"

    def close(self) -> None:
        """Stop serving."""
        self.shutdown()
        self.server_close()


def reply(request: BaseHTTPRequestHandler, kind: str, body: bytes, status: int = 200) -> None:
    """Send a whole answer of a media type."""
    request.send_response(status)
    request.send_header("Content-Type", kind)
    request.send_header("Content-Length", str(len(body)))
    request.send_header("Cache-Control", "no-store")
    request.end_headers()
    request.wfile.write(body)
