"""A small HTTP server in a thread, for pages that a run shows of itself."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

from motes.core.errors import ConfigError

SLOWEST = 5.0
"""Seconds after which a reader that takes nothing is dropped."""


class Server(ThreadingHTTPServer):
    """Serves until it is closed; each request has a thread of its own.

    Parameters
    ----------
    host, port
        Where it listens; port 0 means any that is free.
    answer
        Called with each GET request; it sends the answer.

    Raises
    ------
    ConfigError
        If it cannot listen there.
    """

    daemon_threads = True
    block_on_close = False  # a reader that takes nothing must not hold up the end of the run

    def __init__(
        self, host: str, port: int, answer: Callable[[BaseHTTPRequestHandler], None]
    ) -> None:
        class Handler(BaseHTTPRequestHandler):
            timeout = SLOWEST

            def do_GET(self) -> None:
                """Answer a request; a reader that goes away is no error."""
                with contextlib.suppress(OSError):
                    answer(self)

            def log_message(self, *_: Any) -> None:
                """Log nothing."""

        try:
            super().__init__((host, port), Handler)
        except (OSError, OverflowError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            raise ConfigError(
                f"Nothing can be served at {host}:{port}: {reason}; choose another port."
            ) from error
        threading.Thread(target=self.serve_forever, args=(0.05,), daemon=True).start()

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Drop a request that fails; the run goes on."""

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
