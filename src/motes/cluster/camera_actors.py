"""The actors of a rig's cameras, as the program keeps them: started, watched and started again."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from motes.cluster.camera_actor import CameraActor
from motes.mot.cameras.messages import CameraMessage
from motes.mot.cameras.rig_config import Camera, Rig
from motes.sot.known_target import KnownTarget

PLACED_WITHIN = 30.0
"""Seconds from the start of an actor, after which it is reported that it does not run yet."""
SHARE = 0.001
"""Of a node's resource that says what it reaches. The resource names nodes, and limits nothing."""
LOOK = 0.2
"""Least seconds from one look at all actors to the next, which takes 0.6 ms for 1,000 of them."""


@dataclass
class _Life:
    """An actor of a camera: its handle, the end of its work, and until when it should run."""

    number: int
    actor: Any
    end: Any
    placed: Any
    due: float


class CameraActors:
    """The actors of a rig's cameras. They belong to the program, and outlive handover actors.

    Parameters
    ----------
    ray
        The module, connected.
    rig
        The cameras.
    handovers
        The handles of the handover actors that get their reports, by the cameras' names.
    seed, epoch, target
        As for `CameraActor.watch`.
    """

    def __init__(
        self, ray: Any, rig: Rig, handovers: Mapping[str, Any],
        seed: int, epoch: float, target: KnownTarget | None,
    ) -> None:  # fmt: skip
        self._ray, self._handovers, self._args = ray, handovers, (seed, epoch, target)
        self._cameras = {camera.name: camera for camera in rig.camera}
        self._due: dict[str, tuple[float, int]] = {}
        self._lives: dict[str, _Life] = {}
        self._looked = -float("inf")
        for name in self._cameras:
            self._start(name, 0)

    def start_after(self, pause: float, name: str, life: int) -> None:
        """Start a camera again after some seconds."""
        self._due[name] = (time.monotonic() + pause, life)

    def look(self) -> Iterator[CameraMessage]:
        """Start what is due, and report to handover actors what has ended; yield what waits."""
        now = time.monotonic()
        if now < self._looked + LOOK:
            return
        self._looked = now
        for name, (due, life) in [*self._due.items()]:
            if due <= now:
                del self._due[name]
                self._start(name, life)
        waiting = {life.end: name for name, life in self._lives.items()}
        if waiting:
            for end in self._ray.wait([*waiting], num_returns=len(waiting), timeout=0)[0]:
                self._note_end(waiting[end])
        yield from self._late(now)

    def close(self) -> None:
        """End all actors."""
        for life in self._lives.values():
            self._ray.kill(life.actor)

    def _start(self, name: str, life: int) -> None:
        camera = self._cameras[name]
        make = self._ray.remote(CameraActor).options(
            num_cpus=0,
            resources={} if camera.node is None else {camera.node: SHARE},
            scheduling_strategy="SPREAD",
            max_restarts=0,
        )
        actor = make.remote(self._handovers[name], name, life)
        placed = actor.__ray_ready__.remote()
        end = actor.watch.remote(camera, *self._args)
        self._lives[name] = _Life(life, actor, end, placed, time.monotonic() + PLACED_WITHIN)

    def _note_end(self, name: str) -> None:
        life = self._lives.pop(name)
        try:
            self._ray.get(life.end)
            why = "its process ended"
        except self._ray.exceptions.RayError as error:
            why = reason(error)
        self._ray.kill(life.actor)
        self._handovers[name].died.remote(name, life.number, why)

    def _late(self, now: float) -> Iterator[CameraMessage]:
        """Yield once of each actor that no node has started in time."""
        for name, life in self._lives.items():
            if now < life.due:
                continue
            life.due = float("inf")
            if not self._ray.wait([life.placed], timeout=0)[0]:
                yield CameraMessage(name, f"it waits for a node{_having(self._cameras[name])}.")


def _having(camera: Camera) -> str:
    return " to start it" if camera.node is None else f" that has {camera.node!r} to start it"


def reason(error: Exception) -> str:
    """Return why an actor ended, in one line without its numbers."""
    words = " ".join(str(error).split())
    if "node has died" in words or "node was terminated" in words:
        return "its node died"
    return "its process ended" + (" with SIGKILL" if "SIGKILL" in words else "")
