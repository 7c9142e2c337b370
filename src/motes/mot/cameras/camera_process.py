"""A camera in a process of its own, seen from the main process."""

from __future__ import annotations

from collections.abc import Iterator

from motes.core.worker_processes import cause, started
from motes.mot.cameras.camera_loop import watch_camera
from motes.mot.cameras.camera_report import CameraEnded, CameraMessage
from motes.mot.cameras.rig_camera import RigCamera
from motes.mot.cameras.rig_config import Camera
from motes.sot.known_target import KnownTarget


class CameraProcess(RigCamera):
    """A camera whose process runs `watch_camera`."""

    def __init__(
        self, camera: Camera, seed: int, origin: float, target: KnownTarget | None = None
    ) -> None:
        self._args = camera, seed, origin, target
        super().__init__(camera.name)

    def _start(self) -> None:
        self.process, self.pipe = started(watch_camera, *self._args)

    def _lost(self) -> Iterator[CameraMessage | CameraEnded]:
        self.process.join()
        yield from self.fail(f"its process ended with {cause(self.process.exitcode)}")

    def close(self) -> None:
        """End the process."""
        self.process.kill()
        self.process.join()
        if self.pipe is not None:
            self.pipe.close()
