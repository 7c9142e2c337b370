"""Messages on their way from a queue to a receiver: each is sent until it is confirmed."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from typing import Protocol

from motes import MotesError
from motes.video import pauses
from motes_fleet.delivery.event_queue import MessageQueue

IDLE = 1.0
"""Seconds between two looks at a connection that has nothing to send."""
LAST_CHANCE = 5.0
"""Seconds that a run waits at its end for messages to be delivered."""


class DeliveryError(MotesError):
    """A receiver does not answer, or has refused a message."""


class Receiver(Protocol):
    """Where messages go."""

    name: str
    """Its address without a password; messages in the queue are marked with it."""
    batch: int
    """Largest number of messages that are sent before their confirmations are waited for."""

    def send(self, bodies: Sequence[str]) -> None:
        """Send messages, perhaps none, and wait until all of them are confirmed.

        Raises
        ------
        DeliveryError
            If that fails; all of them are sent again then.
        """

    def close(self) -> None:
        """Close the connection, if there is one; `send` opens it again."""


class Delivery:
    """A thread that takes a receiver's messages from the queue, in order.

    `log` is called with one line of text when the receiver fails, and when it is back.
    """

    def __init__(self, queue: MessageQueue, receiver: Receiver, log: Callable[[str], None]) -> None:
        self.receiver = receiver
        self._queue, self._log = queue, log
        self._failed_at: float | None = None
        self._closing = threading.Event()
        self._until = float("inf")
        self.error: MotesError | None = None
        """Why the thread ended before its time: the queue's file failed, or the receiver's code."""
        self.delivered = 0
        """The number of messages that the receiver has confirmed."""
        self._thread = threading.Thread(target=self._run, name="delivery", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Send what waits, for `LAST_CHANCE` seconds at most, and end the thread."""
        self._until = time.monotonic() + LAST_CHANCE
        self._closing.set()
        self._queue.wake()
        self._thread.join(2 * LAST_CHANCE)

    def _run(self) -> None:
        try:
            self._deliver()
        except MotesError as error:
            self.error = error
        except Exception as error:  # else events would wait unnoticed
            self.error = DeliveryError(f"{self.receiver.name} failed: {error!r}.")
        finally:
            self.receiver.close()

    def _deliver(self) -> None:
        waits = pauses()
        while time.monotonic() < self._until:
            closing = self._closing.is_set()
            wait = 0.0 if closing else IDLE
            messages = self._queue.oldest(self.receiver.name, self.receiver.batch, wait)
            try:
                self.receiver.send([body for _, body in messages])
            except DeliveryError as error:
                self.receiver.close()
                self._report(error)
                if closing and not messages:
                    return
                pause = next(waits)
                if closing:
                    time.sleep(min(pause, max(0.0, self._until - time.monotonic())))
                else:
                    self._closing.wait(pause)
                continue
            self.delivered += len(messages)
            self._queue.remove(messages)
            waits = pauses()
            if self._failed_at is not None:
                seconds, self._failed_at = time.monotonic() - self._failed_at, None
                self._log(f"{self.receiver.name} is back after {seconds:.1f} s.")
            if closing and not messages:
                return

    def _report(self, error: DeliveryError) -> None:
        """Report a failure, unless there was one since the last success."""
        if self._failed_at is None:
            self._failed_at = time.monotonic()
            self._log(f"{error} Events wait, and are sent again with growing pauses.")
