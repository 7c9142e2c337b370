"""Live pictures, over HTTP and in a window."""

from __future__ import annotations

import contextlib
import errno
import http.client
import io
import socket
import sys
import threading
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from functools import partial
from types import SimpleNamespace
from typing import Any
from urllib.parse import urlsplit

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from brokers import PATIENCE, wait_until
from motes import ConfigError
from motes_fleet.delivery import live_picture, local_server
from motes_fleet.delivery.live_picture import Page, PictureWindow, view
from motes_fleet.delivery.local_server import Server, reply


def gray(value: int) -> NDArray[np.uint8]:
    return np.full((32, 48, 3), value, np.uint8)


class Reader:
    """Reads the stream of a page, picture by picture."""

    def __init__(self, address: str) -> None:
        parts = urlsplit(address)
        assert parts.hostname == "127.0.0.1"
        self._connection = http.client.HTTPConnection(parts.hostname, parts.port, timeout=PATIENCE)
        self._connection.request("GET", "/stream")
        self._answer = self._connection.getresponse()
        kind = self._answer.headers["Content-Type"]
        assert kind == "multipart/x-mixed-replace; boundary=picture"

    def next(self) -> int:
        """Return the mean gray level of the next picture."""
        assert self._answer.readline() == b"--picture\r\n"
        assert self._answer.readline() == b"Content-Type: image/jpeg\r\n"
        size = int(self._answer.readline().split()[1])
        self._answer.readline()
        with Image.open(io.BytesIO(self._answer.read(size))) as image:
            mean = np.array(image).mean()
        self._answer.readline()
        return round(float(mean))

    def ended(self) -> bool:
        """Return whether the stream has ended."""
        return self._answer.readline() == b""

    def close(self) -> None:
        """Go away."""
        self._answer.close()
        self._connection.close()


def test_a_page_shows_the_newest_picture_and_ends_with_the_run() -> None:
    page = Page()
    drawn: list[int] = []

    def draw(value: int) -> NDArray[np.uint8]:
        drawn.append(value)
        return gray(value)

    for value in (10, 20, 30):
        page.offer(partial(draw, value))
    assert drawn == []  # nobody looks
    with urllib.request.urlopen(page.address) as answer:
        assert b"/stream" in answer.read()
    first, second = Reader(page.address), Reader(page.address)
    assert (first.next(), second.next()) == (30, 30)
    page.offer(partial(draw, 40))
    assert (first.next(), second.next()) == (40, 40)
    assert drawn == [30, 40]  # both share each picture
    page.close()
    assert first.ended()
    assert second.ended()
    first.close()
    second.close()
    with pytest.raises(urllib.error.URLError):
        urllib.request.urlopen(page.address)


def test_a_slow_browser_misses_pictures_and_holds_up_nobody(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(live_picture, "FASTEST", 0.0)
    page = Page()
    noise = np.random.default_rng(0).integers(0, 256, (600, 800, 3)).astype(np.uint8)
    slow = socket.create_connection(("127.0.0.1", urlsplit(page.address).port or 0))
    slow.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    slow.sendall(b"GET /stream HTTP/1.0\r\nHost: localhost:1\r\n\r\n")
    drawn: list[int] = []

    def draw() -> NDArray[np.uint8]:
        drawn.append(1)
        return noise

    for _ in range(100):  # of which a socket takes some, and then no more
        page.offer(draw)
        time.sleep(0.002)
    assert len(drawn) < 90
    page.close()  # returns, though the browser takes nothing
    slow.close()


def test_foreign_pages_see_nothing() -> None:
    page = Page()
    page.offer(lambda: gray(1))
    for host, path, status in (("evil.example:1", "/", 403), ("localhost:1", "/other", 404)):
        request = urllib.request.Request(page.address + path[1:], headers={"Host": host})
        with pytest.raises(urllib.error.HTTPError) as caught:
            urllib.request.urlopen(request)
        assert caught.value.code == status
        caught.value.close()
    page.close()


class Screen:
    """Stands in for OpenCV with windows."""

    WINDOW_NORMAL = 0
    error = RuntimeError

    def __init__(self, works: bool) -> None:
        self.works, self.shown = works, list[Any]()

    def namedWindow(self, *_: Any) -> None:  # noqa: N802
        """Open a window, if there can be one."""
        if not self.works:
            raise self.error

    def imshow(self, _: str, pixels: NDArray[np.uint8]) -> None:
        """Note a picture."""
        self.shown.append(pixels[0, 0].tolist())

    def waitKey(self, _: int) -> None:  # noqa: N802
        """Do nothing."""

    def destroyAllWindows(self) -> None:  # noqa: N802
        """Note the end."""
        self.shown.append("closed")


def test_a_window_where_there_is_one(monkeypatch: pytest.MonkeyPatch) -> None:
    screen = Screen(works=True)
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setitem(sys.modules, "cv2", screen)
    shown = view()
    assert isinstance(shown, PictureWindow)
    color = np.full((4, 4, 3), (1, 2, 3), np.uint8)
    shown.offer(lambda: color)
    shown.offer(lambda: color)  # too soon after the first
    shown.close()
    assert screen.shown == [[3, 2, 1], "closed"]


@pytest.mark.parametrize("screen", [None, Screen(works=False)])
def test_a_page_where_there_is_no_window(
    screen: Screen | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setitem(sys.modules, "cv2", screen)
    shown = view()
    assert isinstance(shown, Page)
    shown.close()


def test_an_empty_host_opens_nothing_to_others() -> None:
    with pytest.raises(ConfigError, match="The host is empty"):
        Server("", 0, lambda request: None)


@pytest.fixture
def server(monkeypatch: pytest.MonkeyPatch) -> Iterator[Server]:
    """Give a server that repeats what is posted, and has three connections."""
    monkeypatch.setattr(local_server, "CONNECTIONS", 3)
    server = Server(
        "127.0.0.1",
        0,
        lambda request: reply(request, "text/plain", b"hello"),
        lambda request, body: reply(request, "text/plain", body),
    )
    yield server.start()
    server.close()


def asking(server: Server, text: bytes = b"") -> socket.socket:
    """Return a connection on which a text has been sent."""
    place = urlsplit(server.address)
    connected = socket.create_connection((place.hostname or "", place.port or 0), PATIENCE)
    connected.sendall(text)
    return connected


POST = b"POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 9\r\n"


@pytest.fixture
def hasty(server: Server, monkeypatch: pytest.MonkeyPatch) -> Server:
    """Give a server that waits 0.3 s for a request."""
    monkeypatch.setattr(local_server, "REQUEST", 0.3)
    return server


@pytest.mark.parametrize(
    ("begin", "drip"), [(b"", b""), (b"GET / HTT", b"1"), (POST, b""), (POST + b"\r\n1234", b"1")]
)
def test_a_request_that_does_not_end_is_closed(hasty: Server, begin: bytes, drip: bytes) -> None:
    with asking(hasty, begin) as connected:
        connected.settimeout(0.05)
        end = time.monotonic() + PATIENCE
        sent = len(drip)
        while time.monotonic() < end:
            with contextlib.suppress(OSError):  # it is closed
                connected.sendall(drip if sent < 5 else b"")
                sent += len(drip)
            try:
                assert connected.recv(1) == b""
            except TimeoutError:
                continue
            except ConnectionError:
                pass
            return
    raise AssertionError("the connection stays open")


def test_so_many_connections_are_open_and_no_more(server: Server) -> None:
    held = [asking(server) for _ in range(4)]
    with contextlib.suppress(ConnectionResetError):
        assert held[-1].recv(1) == b""
    for connected in held:
        connected.close()
    wait_until(lambda: answered(server))


def answered(server: Server) -> bool:
    with asking(server, b"GET / HTTP/1.0\r\nHost: localhost\r\n\r\n") as connected:
        try:
            return connected.makefile("rb").read().endswith(b"hello")
        except ConnectionResetError:
            return False


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({}, 200),
        ({"Host": "evil.example"}, 403),
        ({"Host": "[::1"}, 403),
        ({"Origin": "http://evil.example"}, 403),
        ({"Origin": "http://["}, 403),
        ({"Origin": "null"}, 403),
        ({"Content-Length": "-5"}, 400),
        ({"Content-Length": "9" * 5000}, 400),
        ({"Content-Length": "999999999"}, 413),
    ],
)
def test_requests_of_others_are_refused(
    server: Server, headers: dict[str, str], status: int
) -> None:
    connection = http.client.HTTPConnection(urlsplit(server.address).netloc, timeout=PATIENCE)
    connection.request("POST", "/", b"" if status != 200 else b"mine", headers)
    answer = connection.getresponse()
    assert answer.status == status
    assert (answer.read() == b"mine") == (status == 200)
    connection.close()


def test_a_server_without_file_descriptors_waits_for_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It must not try again and again without a pause, which takes a whole core."""

    def none_left() -> None:
        raise OSError(errno.EMFILE, "Too many open files")

    pauses: list[float] = []
    monkeypatch.setattr("motes_fleet.delivery.local_server.time.sleep", pauses.append)
    with Server("127.0.0.1", 0, lambda request: None) as server:
        with monkeypatch.context() as context:
            context.setattr(server, "socket", SimpleNamespace(accept=none_left))
            with pytest.raises(OSError, match="Too many"):
                server.get_request()
        assert pauses == [0.1]


def test_a_reader_that_leaves_is_no_error(capsys: pytest.CaptureFixture[str]) -> None:
    page = Page()
    page.offer(lambda: gray(1))
    before = set(threading.enumerate())
    reader = Reader(page.address)
    reader.next()
    (serving,) = set(threading.enumerate()) - before
    reader.close()

    def ended() -> bool:
        page.offer(lambda: gray(1))
        return not serving.is_alive()

    wait_until(ended)
    page.offer(lambda: gray(2))
    other = Reader(page.address)
    assert other.next() == 2
    page.close()
    other.close()
    assert capsys.readouterr().err == ""
