"""A program that gets the reports of simulated cameras by connections; see `handover.py`.

One process stands for the actors of all cameras: first at full speed, then with 25 reports a second
for each. The program associates the reports, and writes their rows.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import socket
import tempfile
import threading
import time
from collections.abc import Iterator
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from motes.core.types import Floats
from motes.rows.schema import CAMERA
from motes.rows.writer import TrackWriter
from motes_fleet.cameras.camera_report import CameraEnded, CameraMessage, CameraReady
from motes_fleet.cameras.rig import RigRunner
from motes_fleet.cameras.rig_camera import RigCamera
from motes_fleet.cameras.rig_config import Camera
from motes_fleet.cluster.camera_actor import pipe_of
from motes_fleet.commands.watch_rig import picture
from motes_lab.report.tables import Cell, Row, number
from simulated_cameras import Building, Simulation

NAME = 64
"""Bytes in which a connection says which camera it is."""


class Simulated(RigCamera):
    """A live camera at the other end of a connection."""

    def __init__(self, camera: Camera, line: Connection) -> None:
        self._line = line
        super().__init__(camera, 0, 0.0)

    def _start(self) -> None:
        self.pipe = self._line

    def _lost(self) -> Iterator[CameraMessage | CameraEnded]:
        raise RuntimeError(f"{self.name} is lost")

    def close(self) -> None:
        """Close the connection."""
        self._line.close()


def _send(
    building: Building, people: float, seconds: float, rate: float | None,
    program: tuple[str, int], result: Any,
) -> None:  # fmt: skip
    """Send the reports of all cameras, at full speed or at a rate; give the time of each."""
    reports = [*Simulation(building, seconds, people).reports()]
    lines = {}
    for camera in building.rig().camera:
        connection = socket.create_connection(program)
        connection.sendall(camera.name.encode().ljust(NAME))
        lines[camera.name] = pipe_of(connection)
    for name, line in lines.items():
        line.send_bytes(msgspec.msgpack.encode(CameraReady(name, True)))
    threading.Thread(target=_drain, args=([*lines.values()],), daemon=True).start()
    data = [(lines[each.camera], msgspec.msgpack.encode(each)) for each in reports]
    sent, begun = [], time.monotonic()
    for n, (line, message) in enumerate(data):
        if rate is not None:
            time.sleep(max(begun + n / rate - time.monotonic(), 0))
        sent.append(time.monotonic())
        line.send_bytes(message)
    for name, line in lines.items():
        line.send_bytes(msgspec.msgpack.encode(CameraEnded(name, 1)))
    keys = [(each.camera, each.frame) for each in reports]
    result.recv()  # until all is read
    result.send(dict(zip(keys, sent, strict=True)))


def _drain(lines: list[Connection]) -> None:
    """Read what the program sends, as actors do."""
    with contextlib.suppress(OSError, EOFError):
        while True:
            for line in wait(lines):
                line.recv_bytes()  # type: ignore[union-attr]


def _run(
    building: Building, people: float, seconds: float, rate: float | None
) -> tuple[float, Floats]:
    """Return the reports for a second of the program's core, and the seconds of each report."""
    rig, lines = building.rig(), dict[str, Connection]()
    ours, theirs = multiprocessing.Pipe()
    with socket.create_server(("127.0.0.1", 0), backlog=len(rig.camera)) as server:
        program = server.getsockname()
        arguments = building, people, seconds, rate, program, theirs
        sender = multiprocessing.get_context("spawn").Process(target=_send, args=arguments)
        sender.start()
        for _ in rig.camera:
            connection, _ = server.accept()
            name = connection.recv(NAME, socket.MSG_WAITALL).decode().rstrip()
            lines[name] = pipe_of(connection)

    def start(camera: Camera, *_: object) -> Simulated:
        return Simulated(camera, lines[camera.name])

    used, begun = dict[tuple[str, int], float](), 0.0
    with tempfile.TemporaryDirectory() as folder:
        output = str(Path(folder) / "rows.csv")
        with TrackWriter(output, further=[CAMERA]) as rows, RigRunner(rig, start=start) as watching:
            for news in watching:
                if isinstance(news, tuple):
                    rows.add(picture(*news))
                    begun = begun or time.process_time()
                    used[news[0].camera, news[0].frame] = time.monotonic()
            taken = time.process_time() - begun
            ours.send(None)
            sent = ours.recv()
    sender.join()
    return len(used) / taken, np.array([used[key] - sent[key] for key in used])


def measure(building: Building, people: float, seconds: float) -> Row:
    """Return the cameras, the rate of reports at full speed, and the latency at 25 frames a second.

    Latency is from the moment at which a camera sends a report to its rows.
    """
    cameras = building.rows * building.columns
    rate, _ = _run(building, people, seconds, None)
    _, latency = _run(building, people, seconds, 25 * cameras)
    late = (float(1e3 * each) for each in (np.median(latency), np.quantile(latency, 0.99)))
    return Cell(f"{cameras}"), Cell(f"{rate:,.0f}"), *(number(each, 1) for each in late)
