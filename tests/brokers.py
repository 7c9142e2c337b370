"""A real MQTT broker on this machine, and one who listens to it."""

import contextlib
import shutil
import socket
import subprocess
import threading
import time
from pathlib import Path
from typing import Any, Self

import pytest

from waiting import PATIENCE as PATIENCE, wait_until as wait_until


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as found:
        port: int = found.getsockname()[1]
        return port


class Broker:
    """Mosquitto, on one port over all its lives; sessions survive in a file."""

    def __init__(self, folder: Path) -> None:
        found = shutil.which("mosquitto", path="/usr/sbin:/usr/local/sbin:/usr/bin:/usr/local/bin")
        if found is None:
            pytest.skip("there is no mosquitto; install it, as with apt-get install mosquitto")
        self.port, self._program = free_port(), found
        self._file = folder / "mosquitto.conf"
        self._file.write_text(
            f"listener {self.port} 127.0.0.1\nallow_anonymous true\nuser root\n"
            f"persistence true\npersistence_location {folder}/\n"
            "autosave_on_changes true\nautosave_interval 1\n"
        )
        self._process: subprocess.Popen[bytes] | None = None

    def start(self) -> None:
        """Start it, and wait until it answers."""
        self._process = subprocess.Popen(
            [self._program, "-c", self._file], stderr=subprocess.DEVNULL
        )
        wait_until(self._answers)

    def _answers(self) -> bool:
        try:
            socket.create_connection(("127.0.0.1", self.port), 1).close()
        except OSError:
            return False
        return True

    def kill(self) -> None:
        """Kill it at once."""
        assert self._process is not None
        self._process.kill()
        self._process.wait()

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.kill()


class SlowBroker:
    """Speaks as much of MQTT as a publisher needs, as slowly as it is told.

    It does not answer the packets in `silent`: "connect", "publish". `texts` is what was published
    under topics, in order; the same again if it was not confirmed.
    """

    def __init__(self) -> None:
        self.silent: set[str] = set()
        self.drips = False
        self.texts: list[tuple[str, str]] = []
        self._server = socket.create_server(("127.0.0.1", 0))
        self.port: int = self._server.getsockname()[1]
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self) -> None:
        with contextlib.suppress(OSError):
            while True:
                connected = self._server.accept()[0]
                threading.Thread(target=self._talk, args=(connected,), daemon=True).start()

    def _talk(self, connected: socket.socket) -> None:
        with connected, contextlib.suppress(OSError), connected.makefile("rb") as file:
            while head := file.read(1):
                length, shift = 0, 0
                while True:
                    (byte,) = file.read(1)
                    length, shift = length | (byte & 127) << shift, shift + 7
                    if byte < 128:
                        break
                self._answer(connected, head[0] >> 4, file.read(length))

    def _answer(self, connected: socket.socket, kind: int, body: bytes) -> None:
        if kind == 1 and "connect" not in self.silent:
            self._send(connected, b"\x20\x02\x00\x00")
        elif kind == 3:
            size = int.from_bytes(body[:2], "big")
            topic, number, text = body[2 : 2 + size], body[2 + size : 4 + size], body[4 + size :]
            self.texts.append((topic.decode(), text.decode()))
            if "publish" not in self.silent:
                self._send(connected, b"\x40\x02" + number)
        elif kind == 12:
            self._send(connected, b"\xd0\x00")

    def _send(self, connected: socket.socket, packet: bytes) -> None:
        for i in range(len(packet)):
            time.sleep(0.02 if self.drips else 0)
            connected.sendall(packet[i : i + 1])

    def close(self) -> None:
        """Answer nobody any more."""
        self._server.close()


class Listener:
    """Takes all messages under a pattern, also those of the time when it was away."""

    def __init__(self, port: int, pattern: str) -> None:
        from paho.mqtt.client import Client
        from paho.mqtt.enums import CallbackAPIVersion

        self.heard: list[tuple[str, str]] = []
        self._client: Any = Client(CallbackAPIVersion.VERSION2, "listener", clean_session=False)
        ready: list[bool] = []
        self._client.on_message = self._take
        self._client.on_subscribe = lambda *_: ready.append(True)
        self._client.connect("127.0.0.1", port)
        self._client.subscribe(pattern, 1)
        self._client.loop_start()
        wait_until(lambda: ready)

    def _take(self, _: Any, __: Any, message: Any) -> None:
        self.heard.append((message.topic, message.payload.decode()))

    def texts(self, topic: str) -> list[str]:
        """Return all messages under a topic."""
        return [text for under, text in self.heard if under == topic]

    def close(self) -> None:
        """Go away; the broker keeps what comes meanwhile."""
        self._client.disconnect()
        self._client.loop_stop()
