"""A camera whose process is an actor on another node, seen from where its reports meet."""

from __future__ import annotations

import msgspec

from motes.cluster.camera_actor import OPEN
from motes.mot.cameras.camera_report import Arrival
from motes.mot.cameras.messages import Go
from motes.mot.cameras.rig_camera import RigCamera

KEPT = 2 * (OPEN + 1)
"""Number of answers that are kept. A camera has at most `OPEN` unanswered messages, with a
`NextFrame` between any two of them and after the last one."""


class RemoteCamera(RigCamera):
    """A camera with an actor. It is a value: it starts nothing, sends nothing and knows no clock.

    Attributes
    ----------
    clock
        The time of what happens to it, in seconds.
    life
        How often its actor was started again; messages of earlier lives are refused.
    turn
        The number of the next message of this life.
    answers
        The encoded answers to the last messages, by their numbers.
    """

    def __init__(self, name: str) -> None:
        self.clock, self.life = 0.0, 0
        super().__init__(name)

    def _start(self) -> None:
        self.turn, self.answers = 0, dict[int, bytes]()
        self._announced: int | None = None

    def _send(self, arrivals: tuple[Arrival, ...]) -> None:
        assert self._announced is not None
        self.answer(self._announced, Go(arrivals))

    def _now(self) -> float:
        return self.clock

    def expect_go(self, number: int) -> None:
        """Note that a message announces a frame: its answer comes when the recording may go on."""
        self._announced = number

    def answer(self, number: int, go: Go) -> None:
        """Keep the answer to a message until the camera has it for certain."""
        self.answers[number] = msgspec.msgpack.encode(go)
        for old in [each for each in self.answers if each < self.turn - KEPT]:
            del self.answers[old]

    def begin_life(self) -> None:
        """Wait for the messages of another actor."""
        self.life += 1
        self.start()
