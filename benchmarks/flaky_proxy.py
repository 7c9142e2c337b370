"""A proxy before a server that fails some requests, stalls, or loses the connection.

`motes batch` and its tests use it before moto's server, which stands for S3. A lost connection is
lost before the request reaches the server, or after the server has done what it asks for.
"""

from __future__ import annotations

import random
import threading
from collections import Counter
from http.client import HTTPConnection
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any, Literal

Fault = Literal["error", "stall", "lost before", "lost after"]
FAULTS: tuple[Fault, ...] = ("error", "stall", "lost before", "lost after")
HOP = {"connection", "transfer-encoding", "content-length", "expect"}
"""Headers that are the proxy's own."""


class FlakyProxy:
    """A proxy on this machine, in threads.

    Parameters
    ----------
    port
        The port of the server.
    share
        The share of requests that go wrong.
    seed
        Seed of the random numbers.
    stall
        Seconds that a stalled request waits before its connection is closed.

    Attributes
    ----------
    faults
        How often each went wrong.
    requests
        The number of all requests.
    """

    def __init__(self, port: int, share: float, seed: int = 0, stall: float = 30.0) -> None:
        self.faults, self.requests = Counter[Fault](), 0
        self._rng, self._share, self._lock = random.Random(seed), share, threading.Lock()
        self._stopped, self._stall = threading.Event(), stall
        self._port = port
        proxy = self

        class Handler(BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def handle_one_request(self) -> None:
                self.raw_requestline = self.rfile.readline(65537)
                if not self.raw_requestline or not self.parse_request():
                    self.close_connection = True
                    return
                proxy._serve(self)

            def log_message(self, *_: Any) -> None:
                pass

        self._server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self._server.daemon_threads = True
        threading.Thread(target=self._server.serve_forever, daemon=True).start()

    @property
    def address(self) -> str:
        """The address of the proxy."""
        return f"http://127.0.0.1:{self._server.server_address[1]}"

    def close(self) -> None:
        """End the proxy."""
        self._stopped.set()
        self._server.shutdown()
        self._server.server_close()

    def _fault(self) -> Fault | None:
        with self._lock:
            self.requests += 1
            if self._rng.random() >= self._share:
                return None
            fault = self._rng.choice(FAULTS)
            self.faults[fault] += 1
            return fault

    def _serve(self, request: BaseHTTPRequestHandler) -> None:
        """Pass a request on, or do what goes wrong with it."""
        fault, body = self._fault(), _body(request)
        if fault == "error":
            request.send_response(503)
            request.send_header("Content-Length", "0")
            request.end_headers()
            return
        if fault == "stall":
            self._stopped.wait(self._stall)
        if fault in ("stall", "lost before"):
            request.close_connection = True
            return
        server = HTTPConnection("127.0.0.1", self._port, timeout=60)
        headers = {k: v for k, v in request.headers.items() if k.lower() not in HOP}
        server.request(request.command, request.path, body, headers)
        answer = server.getresponse()
        content = answer.read()
        if fault == "lost after":
            request.close_connection = True
            return
        request.send_response(answer.status)
        for name, value in answer.getheaders():
            if name.lower() not in HOP:
                request.send_header(name, value)
        length = answer.getheader("Content-Length", "0") if request.command == "HEAD" else None
        request.send_header("Content-Length", length or str(len(content)))
        request.end_headers()
        if request.command != "HEAD":
            request.wfile.write(content)
        server.close()


def _body(request: BaseHTTPRequestHandler) -> bytes:
    """Read the body of a request, which may come in chunks."""
    if request.headers.get("Expect", "").lower() == "100-continue":
        request.send_response_only(100)
        request.end_headers()
    if "chunked" not in request.headers.get("Transfer-Encoding", "").lower():
        return request.rfile.read(int(request.headers.get("Content-Length") or 0))
    body = b""
    while size := int(request.rfile.readline().split(b";")[0], 16):
        body += request.rfile.read(size)
        request.rfile.readline()
    while request.rfile.readline().strip():
        pass
    return body
