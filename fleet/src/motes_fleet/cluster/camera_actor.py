"""A camera that a node of a cluster watches: its actor, and how the program sees it.

Ray finds a node that reaches the camera, and says when the actor has ended. Messages go by a
connection of their own from the actor to the program, in which reports meet: a call of Ray takes
far longer than what is done with a report. Frames stay on the node.
"""

from __future__ import annotations

import os
import secrets
import socket
import time
from collections.abc import Iterator
from contextlib import suppress
from multiprocessing.connection import Connection, wait
from typing import Any

from motes import KnownTarget
from motes.core import WorkerLine
from motes_fleet.cameras.camera_loop import watch_camera
from motes_fleet.cameras.camera_report import CameraEnded, CameraMessage
from motes_fleet.cameras.rig_camera import RigCamera
from motes_fleet.cameras.rig_config import Camera

PLACED_WITHIN = 30.0
"""Seconds from the start of an actor, after which it is reported that it does not run yet."""
SHARE = 0.001
"""Of a node's resource that says what it reaches. The resource names nodes, and limits nothing."""
LOOK = 1.0
"""Least seconds from one question to Ray, whether the actor has ended, to the next."""
PATIENCE = 5.0
"""Seconds within which an actor connects, and then sends its key."""
KEY = 32
"""Bytes of the word by which the program knows the actor that it has started."""
BUFFER = 1 << 15
"""Bytes that a connection holds at each end: a few reports. If the program is slow, cameras wait,
and live ones drop pictures; they do not send old ones."""
ALIVE = {"TCP_KEEPIDLE": 5, "TCP_KEEPINTVL": 1, "TCP_KEEPCNT": 5}
"""Seconds of silence, seconds between questions, and their number: then a node that is gone without
a word ends the connection, also in the middle of a message."""


class CameraActor:
    """Watches a camera. Ray makes an actor of this class.

    Parameters
    ----------
    name
        The camera's, which Ray's dashboard shows.
    """

    def __init__(self, name: str) -> None:
        self._name = name

    def __repr__(self) -> str:
        return f"camera {self._name}"

    def watch(
        self, camera: Camera, seed: int, epoch: float, target: KnownTarget | None,
        program: tuple[str, int], key: bytes,
    ) -> None:  # fmt: skip
        """Watch a camera until it ends, or until nobody listens any more.

        Parameters
        ----------
        camera, seed, target
            As for `watch_camera`.
        epoch
            The reading of `time.time` at time 0 of live frames: clocks of nodes must agree.
        program, key
            Where the program listens, and the word that lets this actor in.
        """
        origin = time.monotonic() - (time.time() - epoch)
        connection = socket.create_connection(program, PATIENCE)
        connection.sendall(key)
        os.dup2(2, 1)  # standard output is for rows
        watch_camera(WorkerLine(pipe_of(connection)), camera, seed, origin, target)


class ClusterCamera(RigCamera):
    """A camera with an actor, seen from the program.

    While `pipe` is a socket, the connection of the actor is awaited.

    Parameters
    ----------
    ray
        The module, connected.
    camera, seed, origin, target
        As for `watch_camera`.
    """

    def __init__(
        self, ray: Any, camera: Camera, seed: int, origin: float, target: KnownTarget | None
    ) -> None:
        epoch = time.time() - (time.monotonic() - origin)
        self._ray, self._camera = ray, camera
        self._actor: Any = None
        super().__init__(camera, seed, epoch, target)

    def _start(self) -> None:
        self.close()
        host = self._ray.util.get_node_ip_address()
        self.pipe = socket.create_server((host, 0))
        self.pipe.settimeout(PATIENCE)
        self._key = secrets.token_bytes(KEY)
        node = self._camera.node
        make = self._ray.remote(CameraActor).options(
            num_cpus=0,
            resources={} if node is None else {node: SHARE},
            scheduling_strategy="SPREAD",
            max_restarts=0,
        )
        self._actor = make.remote(self.name)
        address = self.pipe.getsockname()[:2]
        self._end = self._actor.watch.remote(*self._args, address, self._key)
        self._looked = time.monotonic()
        self._placed_until = self._looked + PLACED_WITHIN

    def listen(self) -> Iterator[CameraMessage | CameraEnded]:
        """Receive its next message, or the connection of its actor."""
        if not isinstance(self.pipe, socket.socket):
            yield from super().listen()
            if self.over:
                self.close()
            return
        with suppress(OSError):  # whoever it was is gone
            connection, _ = self.pipe.accept()
            connection.settimeout(PATIENCE)
            if not secrets.compare_digest(connection.recv(KEY), self._key):
                connection.close()
                return
            self.pipe.close()
            self.pipe = pipe_of(connection)

    def look(self) -> Iterator[CameraMessage | CameraEnded]:
        """Start it again if that is due; ask Ray for its actor, and yield what there is to say."""
        yield from super().look()
        now = time.monotonic()
        if self.over or self.due is not None or now < self._looked + LOOK:
            return
        self._looked = now
        if self._ray.wait([self._end], timeout=0)[0]:
            if self.pipe is None or not wait([self.pipe], 0):  # what it has sent comes first
                self.close()
                self.pipe = None
                yield from self.fail(self._why())
        elif isinstance(self.pipe, socket.socket) and now > self._placed_until:
            self._placed_until = float("inf")
            node = self._camera.node
            having = "" if node is None else f" that has {node!r}"
            yield CameraMessage(self.name, f"it waits for a node{having} to start it.")

    def _lost(self) -> Iterator[CameraMessage | CameraEnded]:
        yield from ()  # Ray will say why

    def _why(self) -> str:
        """Return why the actor has ended."""
        try:
            self._ray.get(self._end)
        except self._ray.exceptions.RayError as error:
            return reason(error)
        return "its process ended"

    def close(self) -> None:
        """End the actor."""
        if self.pipe is not None:
            self.pipe.close()
        if self._actor is not None:
            self._ray.kill(self._actor)


def pipe_of(connection: socket.socket) -> Connection:
    """Return a connection as a pipe that holds little and waits for nothing."""
    connection.settimeout(None)
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    for name, number in ALIVE.items():
        if hasattr(socket, name):
            connection.setsockopt(socket.IPPROTO_TCP, getattr(socket, name), number)
    for side in (socket.SO_SNDBUF, socket.SO_RCVBUF):
        connection.setsockopt(socket.SOL_SOCKET, side, BUFFER)
    return Connection(connection.detach())


def reason(error: Exception) -> str:
    """Return why an actor ended, in one line without its numbers."""
    cause = getattr(error, "cause", None)
    words = " ".join(str(cause or error).split())
    if cause is not None:  # it was raised there
        return f"its process ended with {type(cause).__name__}: {words}"
    if "node has died" in words or "node was terminated" in words:
        return "its node died"
    return "its process ended" + (" with SIGKILL" if "SIGKILL" in words else "")
