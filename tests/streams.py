"""A real camera on this machine: MPEG-TS over HTTP, that can stall, hang up and go away."""

import contextlib
import socket
import threading
import time
from collections.abc import Callable, Iterator

import av
import numpy as np
from numpy.typing import NDArray

RATE = 50
Paint = Callable[[int], NDArray[np.uint8]]
Answer = Callable[[socket.socket, int], None]


class _Wire:
    """What PyAV writes into."""

    def __init__(self, connection: socket.socket) -> None:
        self._connection = connection

    def write(self, data: bytes) -> int:
        self._connection.sendall(data)
        return len(data)


class Stream:
    """Serves pictures to one reader at a time.

    `stalled` stops the pictures, `hung_up` ends the connection and refuses the next ones.
    """

    def __init__(self, paint: Paint) -> None:
        self._paint = paint
        self.stalled, self.hung_up, self._done = (threading.Event() for _ in range(3))
        self.connections = self.refusals = 0
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.url = f"http://user:secret@127.0.0.1:{self._listener.getsockname()[1]}/camera"
        self._begun = time.monotonic()
        threading.Thread(target=self._serve, daemon=True).start()

    def _serve(self) -> None:
        with contextlib.suppress(OSError):
            while True:
                connection, _ = self._listener.accept()
                self.connections += 1
                with connection, contextlib.suppress(OSError, av.FFmpegError):
                    if self.hung_up.is_set():
                        self.refusals += 1
                    else:
                        self._answer(connection)

    def _answer(self, connection: socket.socket) -> None:
        connection.recv(4096)
        connection.sendall(b"HTTP/1.0 200 OK\r\nContent-Type: video/mp2t\r\n\r\n")
        file = av.open(_Wire(connection), "w", format="mpegts", options={"flush_packets": "1"})
        size = self._paint(0).shape
        stream = file.add_stream("libx264", rate=RATE)
        stream.height, stream.width, _ = size
        stream.pix_fmt = "yuv420p"
        stream.options = {"tune": "zerolatency", "preset": "ultrafast", "g": "10"}
        first = None
        while not (self._done.is_set() or self.hung_up.is_set()):
            if self.stalled.is_set():
                connection.settimeout(0.02)
                with contextlib.suppress(TimeoutError):
                    if not connection.recv(1):
                        return  # the reader went away
                connection.settimeout(None)
                continue
            index = int((time.monotonic() - self._begun) * RATE)
            first = index if first is None else first
            frame = av.VideoFrame.from_ndarray(self._paint(index), format="rgb24")
            frame.pts = index - first
            for packet in stream.encode(frame):
                file.mux(packet)
            time.sleep(max(0.0, self._begun + (index + 1) / RATE - time.monotonic()))

    def close(self) -> None:
        """Hang up for good."""
        self._done.set()
        self._listener.close()


@contextlib.contextmanager
def camera(paint: Paint) -> Iterator[Stream]:
    stream = Stream(paint)
    try:
        yield stream
    finally:
        stream.close()


@contextlib.contextmanager
def server(answer: Answer) -> Iterator[str]:
    """Call `answer` with each connection and its number from 0, in a thread; yield the address."""
    listener = socket.create_server(("127.0.0.1", 0))

    def one(connection: socket.socket, number: int) -> None:
        with connection, contextlib.suppress(OSError):
            connection.recv(4096)
            answer(connection, number)

    def serve() -> None:
        with contextlib.suppress(OSError):
            for number in range(1000):
                each = listener.accept()[0], number
                threading.Thread(target=one, args=each, daemon=True).start()

    threading.Thread(target=serve, daemon=True).start()
    try:
        yield f"http://user:secret@127.0.0.1:{listener.getsockname()[1]}/camera"
    finally:
        listener.close()
