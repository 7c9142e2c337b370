"""A camera whose process is an actor on another node, seen from where its reports meet."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterable

import msgspec

from motes.cluster.camera_actor import CameraActor
from motes.mot.cameras.camera_report import Arrival
from motes.mot.cameras.messages import CameraEnded, CameraMessage, Go
from motes.mot.cameras.rig_camera import RigCamera
from motes.mot.cameras.rig_config import Camera
from motes.sot.known_target import Target

PLACED_WITHIN = 30.0
"""Seconds from the start of an actor, after which it is reported that it does not run yet."""
SHARE = 0.001
"""Of a node's resource that says what it reaches. The resource names nodes, and limits nothing."""


class RemoteCamera(RigCamera):
    """A camera with an actor.

    Parameters
    ----------
    camera, seed, epoch, target
        As for `CameraActor.watch`.
    tell
        Gets what happens to the actor.
    """

    def __init__(
        self, camera: Camera, seed: int, epoch: float, target: Target | None,
        tell: Callable[[Iterable[CameraMessage | CameraEnded]], None],
    ) -> None:  # fmt: skip
        self._camera, self._args = camera, (camera, seed, epoch, target)
        self._tell, self._life = tell, 0
        self._early: dict[int, asyncio.Event] = {}
        self._answer: asyncio.Future[bytes | None] | None = None
        super().__init__(camera.name)

    def _start(self) -> None:
        self._turn = 0
        self._task = asyncio.ensure_future(self._keep_alive(self._life))

    def _send(self, arrivals: tuple[Arrival, ...]) -> None:
        if self._answer is not None and not self._answer.done():
            self._answer.set_result(msgspec.msgpack.encode(Go(arrivals)))

    def _end_life(self) -> None:
        """Take no more messages of this life: its process may go on where its node seems dead."""
        self._life += 1
        if self._answer is not None and not self._answer.done():
            self._answer.set_result(None)
        for waiting in self._early.values():
            waiting.set()
        self._early.clear()

    async def turn(self, life: int, number: int) -> bool:
        """Wait for the messages before one, as Ray keeps no order; return whether to use it."""
        if life == self._life and number != self._turn:
            waiting = self._early[number] = asyncio.Event()
            await waiting.wait()
        if life != self._life:
            return False
        self._turn += 1
        if (following := self._early.pop(self._turn, None)) is not None:
            following.set()
        return True

    def expect_go(self) -> asyncio.Future[bytes | None]:
        """Return the answer to a `NextFrame`; it comes when the recording may go on."""
        self._answer = asyncio.get_running_loop().create_future()
        return self._answer

    async def _keep_alive(self, life: int) -> None:
        """Start an actor, wait for its end, and start another one unless the camera has ended."""
        import ray

        loop = asyncio.get_running_loop()
        node = self._camera.node
        actor = (
            ray.remote(CameraActor)
            .options(
                num_cpus=0,
                resources={} if node is None else {node: SHARE},
                scheduling_strategy="SPREAD",
                max_restarts=0,
                name=f"camera {self.name}, life {life}",
            )
            .remote(ray.get_runtime_context().current_actor, life)
        )
        late = loop.call_later(PLACED_WITHIN, self._report_late)
        try:
            await actor.watch.remote(*self._args)
            why = "its process ended"
        except ray.exceptions.RayError as error:
            why = reason(error)
        late.cancel()
        ray.kill(actor)
        if self.over:
            return
        self._end_life()
        self._tell(self.fail(why))
        if self.due is not None:
            await asyncio.sleep(max(self.due - loop.time(), 0))
            self.start()

    def _report_late(self) -> None:
        """Report that the actor has not sent anything yet."""
        if not self._turn:
            where = "" if self._camera.node is None else f" that has {self._camera.node!r}"
            text = f"it waits for a node{where} to start it."
            self._tell([CameraMessage(self.name, text)])


def reason(error: Exception) -> str:
    """Return why an actor ended, in one line without its numbers."""
    words = " ".join(str(error).split())
    if "node has died" in words or "node was terminated" in words:
        return "its node died"
    return "its process ended" + (" with SIGKILL" if "SIGKILL" in words else "")
