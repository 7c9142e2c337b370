"""A studio that runs in this process or in one of its own, and a page without a browser."""

from __future__ import annotations

import re
import select
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from typing import Any

import httpx
import msgspec
import pytest
import uvicorn
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

from clips import write_film
from motes.synthetic import still
from motes_studio import film_worker
from motes_studio.messages import Item, Message, Progress, Reply, Rows, State, WholeSession
from motes_studio.safety import Guard, Limits
from motes_studio.serve import listening, settings
from motes_studio.server import AGAIN, app
from motes_studio.studio import Studio
from waiting import PATIENCE, source

FRAMES = 40
CLIP = still((96, 80), target=(30, 40), frames=100)
BOX = (30.0, 25.0, 30.0, 40.0)
SLOW = "particles = 400000"
"""A configuration whose run goes on while a test acts, on any computer: 0.1 s or more a frame."""
ACTIVE = ("waiting", "running")


def film(path: Path, frames: int = FRAMES) -> Path:
    """Write a film with a target in `BOX`."""
    write_film(path, islice(CLIP, frames))
    return path


PROGRAM = """
import sys
from motes.cli import main
from motes_studio import film_worker

film_worker.NICENESS = 0
sys.exit(main())
"""
"""motes whose workers do not wait for other processes: tests wait for them."""


class Program:
    """`motes studio` in a process of its own, which ends with a `with`."""

    def __init__(self, folder: Path, data: Path, port: int = 0) -> None:
        command = [sys.executable, "-c", PROGRAM, "studio", str(folder), "--port", str(port)]
        self.process = subprocess.Popen(
            [*command, "--data", str(data), "--headless"], stderr=subprocess.PIPE, text=True
        )
        assert self.process.stderr is not None
        assert select.select([self.process.stderr], [], [], PATIENCE)[0]
        found = re.search(r"http://127\.0\.0\.1:(\d+)/", self.process.stderr.readline())
        assert found is not None
        self.address, self.port = found.group(), int(found.group(1))

    def client(self) -> httpx.Client:
        """Return a client of it."""
        return httpx.Client(base_url=self.address.rstrip("/"), timeout=PATIENCE)

    def __enter__(self) -> Program:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def kill(self) -> None:
        """End the server as a power cut does."""
        self.process.kill()
        self._ended()

    def close(self) -> None:
        """End the server as a user does."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        self._ended()

    def _ended(self) -> None:
        self.process.wait(PATIENCE)
        assert self.process.stderr is not None
        self.process.stderr.close()


@contextmanager
def running(
    folder: Path, data: Path, *, limits: Limits | None = None, token: str | None = None
) -> Iterator[httpx.Client]:
    """Run a studio in a thread, and give a client of it.

    By default a worker may be silent for long: where other processes are busy, it imports for a
    minute what it needs, before its first sign of life.
    """
    opened = listening("127.0.0.1", 0)
    port = opened.getsockname()[1]
    guard = Guard("127.0.0.1", token)
    server = uvicorn.Server(
        settings(app(Studio(folder, data, limits or Limits(silence=PATIENCE)), guard))
    )
    thread = threading.Thread(target=server.run, args=([opened],))
    thread.start()
    try:
        with (
            pytest.MonkeyPatch.context() as patch,
            httpx.Client(base_url=f"http://127.0.0.1:{port}", timeout=PATIENCE) as client,
        ):
            patch.setattr(film_worker, "NICENESS", 0)
            yield client
    finally:
        server.should_exit = True
        thread.join()
        opened.close()


class Page:
    """What a page does: it sends commands, and keeps what it is sent.

    It has the newest state, the rows by object and frame, and all other messages.
    """

    def __init__(self, socket: ClientConnection) -> None:
        self._socket = socket
        self._id = 0
        self.session: WholeSession
        self.jobs: dict[int, Progress] = {}
        self.rows: dict[int, dict[int, Any]] = {}
        self.messages: list[Message] = []
        self.until(lambda: hasattr(self, "session"))

    def until(self, done: Callable[[], object]) -> None:
        """Receive until something is so; fail if it never is."""
        end = time.monotonic() + PATIENCE
        while not done():
            try:
                self._take(self._socket.recv(timeout=max(0.0, end - time.monotonic())))
            except TimeoutError:
                seen = f"the last: {self.messages[-3:]}"
                raise AssertionError(f"waited in vain: {source(done)}; {seen}") from None

    def until_left(self) -> None:
        """Receive until the server lets the page come again."""
        with pytest.raises(ConnectionClosed) as closed:
            self.until(lambda: False)
        assert closed.value.rcvd is not None
        assert closed.value.rcvd.code == AGAIN

    def _take(self, text: str | bytes) -> None:
        message = msgspec.json.decode(text, type=Message)
        if isinstance(message, State):
            self.session = message.session
            self.jobs = {each.job: each for each in message.session.jobs}
        elif isinstance(message, Rows):
            if message.reset:
                self.rows.pop(message.object, None)
            for row in message.rows:
                self.rows.setdefault(message.object, {})[row.frame] = row
        else:
            self.messages.append(message)
            if isinstance(message, Progress):
                self.jobs[message.job] = message

    def raw(self, text: str) -> None:
        """Send a text."""
        self._socket.send(text)

    def ask(self, kind: str, **fields: Any) -> Reply:
        """Send a command, and return the reply."""
        self._id += 1
        number = self._id
        self.raw(msgspec.json.encode({"type": kind, "id": number, **fields}).decode())
        self.until(lambda: any(isinstance(m, Reply) and m.id == number for m in self.messages))
        return next(m for m in self.messages if isinstance(m, Reply) and m.id == number)

    def do(self, kind: str, **fields: Any) -> Reply:
        """Send a command that succeeds."""
        reply = self.ask(kind, **fields)
        assert reply.error is None, reply.error
        return reply

    def of(self, kind: type[Any]) -> list[Any]:
        """Return the messages of a type so far."""
        return [message for message in self.messages if isinstance(message, kind)]

    def drawn(self, **fields: Any) -> int:
        """Draw an object in `BOX` of the first frame, and return its number."""
        given = {"name": "disk", "color": "#0072b2", "frame": 0, "region": BOX, **fields}
        number = self.do("add_object", **{"preset": "mean_shift", **given}).object
        assert number is not None
        return number

    def tracked(self, *objects: int) -> None:
        """Track objects, and wait for the result."""
        job = self.do("track", objects=[*objects]).job
        self.settle()
        assert job is not None
        assert self.jobs[job].status == "done", self.jobs[job].error

    def settle(self) -> None:
        """Wait until all jobs have ended, and all rows are results."""
        self.until(lambda: not any(each.status in ACTIVE for each in self.jobs.values()))
        self.until(
            lambda: all(self.final(each.object) for each in self.session.objects if each.tracked)
        )

    def final(self, number: int) -> bool:
        """Return whether all rows of an object are results."""
        item = self.item(number)
        rows = self.rows.get(number, {})
        return all(t in rows and rows[t].final for t in range(item.first, item.last + 1))

    def has(self, number: int) -> bool:
        """Return whether there is an object."""
        return any(each.object == number for each in self.session.objects)

    def item(self, number: int) -> Item:
        """Return an object."""
        return next(each for each in self.session.objects if each.object == number)


@contextmanager
def looking(client: httpx.Client, session: str) -> Iterator[Page]:
    """Give a page that looks at a session."""
    address = str(client.base_url).replace("http", "ws").rstrip("/")
    cookies = "; ".join(f"{name}={value}" for name, value in client.cookies.items())
    headers = {"Cookie": cookies} if cookies else {}
    path = f"{address}/api/sessions/{session}/ws"
    with connect(path, max_size=None, additional_headers=headers) as socket:
        yield Page(socket)


def begin(client: httpx.Client, name: str = "film.mkv") -> str:
    """Make a session, and return its name."""
    answer = client.post("/api/sessions", json={"film": name, "anew": True})
    assert answer.status_code == 201, answer.text
    return str(answer.json()["id"])
