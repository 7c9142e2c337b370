"""Several cameras at once, each with a scene in a process of its own.

Frames stay in the process that reads them, which sends a small `CameraReport` of each. Here, the
objects of all cameras get their identities in the rig, and cameras learn what to expect.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator, Mapping, Sequence
from multiprocessing.connection import wait
from typing import Self

from motes import KnownTarget
from motes.core import blocked_signals
from motes_fleet.cameras.camera_report import CameraEnded, CameraMessage, CameraReport
from motes_fleet.cameras.reidentification import CrossCameraAssociation
from motes_fleet.cameras.rig_camera import RigCamera
from motes_fleet.cameras.rig_config import Rig, neighbors_of

LOOK = 0.2
"""Seconds after which cameras are looked at, though none has sent anything."""


class RigRunner:
    """Watches the cameras of a rig: a context manager and an iterator of their reports.

    It yields in the order of time: each `CameraReport`, with the identities in the rig of its
    objects by their identities in the camera; and each `CameraMessage` and `CameraEnded`. It ends
    when all cameras have ended. A process that dies is started again. All processes end with the
    context, and with the main process, for whatever reason.

    Parameters
    ----------
    rig, seed
        The cameras, and the seed of their random numbers.
    target
        A known target for which all cameras wait, in place of all objects. Its identity is 1.
    """

    def __init__(self, rig: Rig, seed: int = 0, target: KnownTarget | None = None) -> None:
        self.handover = CrossCameraAssociation(rig, known_target=target is not None)
        origin = time.monotonic()
        with blocked_signals():
            self._cameras = [RigCamera(camera, seed, origin, target) for camera in rig.camera]
        cameras = {camera.name: camera for camera in self._cameras}
        self._near = {
            name: [cameras[each] for each in (name, *near)]
            for name, near in neighbors_of(rig).items()
        }

    def __iter__(
        self,
    ) -> Iterator[tuple[CameraReport, Mapping[int, int]] | CameraMessage | CameraEnded]:
        while any(not camera.over or camera.reports for camera in self._cameras):
            for camera in self._cameras:
                yield from camera.look()
            pipes = {
                camera.pipe: camera
                for camera in self._cameras
                if camera.pipe is not None and not camera.over
            }
            for pipe in wait([*pipes], LOOK):
                yield from pipes[pipe].listen()  # type: ignore[index]
            while (report := next_report(self._cameras, self.handover)) is not None:
                yield report, self.handover.update(report)
                announce(report, self._near[report.camera], self.handover)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        with blocked_signals():
            for camera in self._cameras:
                camera.close()


def announce(
    report: CameraReport, near: Sequence[RigCamera], handover: CrossCameraAssociation
) -> None:
    """Send live cameras the objects that they may expect after a report of one near them."""
    for camera in near:
        if camera.listens:
            camera.send_arrivals(handover.arrivals(camera.name, report.time))


def next_report(
    cameras: Sequence[RigCamera], handover: CrossCameraAssociation
) -> CameraReport | None:
    """Return the next report of some cameras; None while none may be used yet.

    Reports of live cameras are used as they come. Those of recordings, and what recordings are
    sent, have an order that depends on the times of frames alone, so results do not depend on
    the speed of the processes.
    """
    for camera in cameras:
        if camera.live and camera.reports:
            return camera.reports.popleft()
    recordings = [camera for camera in cameras if not camera.live]
    while recordings:
        events = [(*camera.upcoming()[:2], n) for n, camera in enumerate(recordings)]
        when, kind, n = min(events)
        camera = recordings[n]
        if when == math.inf or not camera.upcoming()[2]:
            return None
        if kind == 0:
            return camera.reports.popleft()
        assert camera.next is not None
        camera.go(handover.arrivals(camera.name, camera.next))
    return None
