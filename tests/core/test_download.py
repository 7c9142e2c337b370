"""Downloads are whole or end in one line, from a server on this machine that is good or bad."""

import hashlib
import time
from collections.abc import Iterator
from contextlib import suppress
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Thread

import pytest

from motes.core import download as module
from motes.core.download import download
from motes.core.errors import SourceError

CONTENT = bytes(range(256)) * 1000
DIGEST = hashlib.sha256(CONTENT).hexdigest()


class Server(BaseHTTPRequestHandler):
    """Has the content at /whole, and ways to fail at other paths."""

    def do_GET(self) -> None:
        """Answer as the path says."""
        if self.path == "/moved":
            self.send_response(302)
            self.send_header("Location", "/whole")
            self.end_headers()
            return
        if self.path == "/404":
            self.send_error(404)
            return
        body = CONTENT + b"more" * (self.path == "/longer")
        body = b"x" + body[1:] if self.path == "/other" else body
        self.send_response(200)
        if self.path != "/endless":
            self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        if self.path == "/silent":
            self.connection.recv(1)  # until nobody listens
        elif self.path in ("/slow", "/endless"):
            with suppress(OSError):  # nobody reads on
                while True:
                    self.wfile.write(body if self.path == "/endless" else body[:1])
                    time.sleep(0.02 * (self.path == "/slow"))
        else:
            self.wfile.write(body[: 7000 if self.path == "/cut" else None])

    def log_message(self, *_: object) -> None:
        """Say nothing."""


@pytest.fixture
def address() -> Iterator[str]:
    with ThreadingHTTPServer(("127.0.0.1", 0), Server) as server:
        server.daemon_threads = False  # closing it waits for all answers
        thread = Thread(target=server.serve_forever, args=(0.01,))
        thread.start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()
        thread.join()


@pytest.mark.parametrize("path", ["whole", "moved"])
def test_a_file_is_loaded(address: str, path: str) -> None:
    assert download(f"{address}/{path}", len(CONTENT), DIGEST) == CONTENT


@pytest.mark.parametrize(
    ("path", "words"),
    [
        ("404", "refuses 404: 404 Not Found"),
        ("other", "another file than the one that motes knows"),
        ("longer", "another file than the one that motes knows"),
        ("endless", "another file than the one that motes knows"),
        ("cut", "cut off after 7000 of 256000 bytes; try again"),
        ("silent", "cannot be loaded from 127.0.0.1:.*: timed out; check the connection"),
        ("slow", "it takes longer than 0.2 s"),
    ],
)
def test_what_goes_wrong_is_one_line(
    address: str, path: str, words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "TIMEOUT", 0.3)
    monkeypatch.setattr(module, "LONGEST", 5.0 if path != "slow" else 0.2)
    with pytest.raises(SourceError, match=words) as caught:
        download(f"{address}/{path}", len(CONTENT), DIGEST)
    assert "\n" not in str(caught.value)
