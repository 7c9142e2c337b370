"""Several cameras at once: each with a scene in a process of its own, from which sightings come.

Frames stay in the process that reads them. What its scene says of a frame travels as a small
`CameraReport`, and only here do the cameras' objects get identities that hold for all of them.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from multiprocessing.connection import wait
from typing import Self

from motes.core.worker_processes import blocked_signals
from motes.mot.cameras.camera_process import CameraProcess
from motes.mot.cameras.camera_report import CameraReport
from motes.mot.cameras.camera_reporter import CameraEnded, CameraMessage
from motes.mot.cameras.reidentification import CrossCameraAssociation
from motes.mot.cameras.rig_config import Rig

WAITING = 100
"""So many reports of a recording wait for the other cameras before it has to wait as well."""


class RigRunner:
    """The cameras of a rig, watched: a context manager and an iterator of what they tell.

    In the order of time it yields each `CameraReport`, with the identities in the rig of its
    objects by those that they have in their camera; and each `CameraMessage` and `CameraEnded`. It
    ends when every camera has. Their processes end with the context, and with this process,
    whatever ends it; one that dies is started again.

    Parameters
    ----------
    rig
        Which cameras, and how they are joined.
    seed
        Of the random numbers.

    Attributes
    ----------
    pids
        Process identifiers by the cameras' names.
    """

    def __init__(self, rig: Rig, seed: int = 0) -> None:
        self.handover = CrossCameraAssociation(rig)
        origin = time.monotonic()
        with blocked_signals():
            self._eyes = [CameraProcess(camera, seed, origin) for camera in rig.camera]

    @property
    def pids(self) -> dict[str, int | None]:
        """Process identifiers by the cameras' names."""
        return {eye.name: eye.process.pid for eye in self._eyes}

    def __iter__(
        self,
    ) -> Iterator[tuple[CameraReport, Mapping[int, int]] | CameraMessage | CameraEnded]:
        while any(not eye.over or eye.reports for eye in self._eyes):
            for eye in self._eyes:
                eye.revive()
            listening = {
                eye.pipe: eye
                for eye in self._eyes
                if not eye.over and eye.due is None and len(eye.reports) < WAITING
            }
            pauses = [eye.due - time.monotonic() for eye in self._eyes if eye.due is not None]
            if listening or pauses:
                for pipe in wait(list(listening), max(min(pauses), 0) if pauses else None):
                    yield from listening[pipe].listen()  # type: ignore[index]
            while (report := self._next()) is not None:
                yield report, self.handover.update(report)

    def _next(self) -> CameraReport | None:
        """Return the report that comes next in time; None while an earlier one may still come."""
        waiting = [eye for eye in self._eyes if eye.reports]
        if not waiting or any(eye.behind for eye in self._eyes):
            return None
        return min(waiting, key=lambda eye: eye.reports[0].time).reports.popleft()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        with blocked_signals():
            for eye in self._eyes:
                eye.process.kill()
                eye.process.join()
                eye.pipe.close()


# In a camera's process
