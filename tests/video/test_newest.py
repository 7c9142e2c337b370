"""Frames of a live source that come too fast are left out; none of a recording is."""

from __future__ import annotations

import queue
import time
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motes.core.errors import SourceError
from motes.core.frame import Frame
from motes.video import newest
from motes.video.newest import Newest
from waiting import wait_until

PIXELS = np.zeros((4, 4, 3), np.uint8)


class Film:
    """A source that gives frames when it is told."""

    def __init__(self, *, realtime: bool = True, error: Exception | None = None) -> None:
        self.realtime, self._error = realtime, error
        self.report = SimpleNamespace(late=0)
        self.taken = 0
        self._orders: queue.Queue[bool] = queue.Queue()

    def give(self, count: int) -> None:
        """Give so many frames."""
        for _ in range(count):
            self._orders.put(True)

    def stop(self) -> None:
        """End after them."""
        self._orders.put(False)

    def __iter__(self) -> Iterator[Frame]:
        while self._orders.get():
            self.taken += 1
            yield Frame(self.taken - 1, self.taken / 25, PIXELS, arrived=time.monotonic())
        if self._error is not None:
            raise self._error


def reading(film: Any) -> Newest:
    return Newest(film)


def test_old_frames_are_left_out_and_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(newest, "LONGEST_WAIT", -1.0)  # any wait is too long
    film = Film()
    with reading(film) as frames:
        each = iter(frames)
        film.give(5)
        wait_until(lambda: film.taken == 5 and film.report.late == 4)
        assert next(each).index == 4
        film.give(1)
        assert next(each).index == 5
        film.stop()
        assert list(each) == []
    assert film.report.late == 4


def test_a_recording_waits(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(newest, "LONGEST_WAIT", -1.0)
    film = Film(realtime=False)
    with reading(film) as frames:
        film.give(5)
        film.stop()
        assert [frame.index for frame in frames] == list(range(5))


def test_errors_come_after_the_frames(monkeypatch: pytest.MonkeyPatch) -> None:
    film = Film(realtime=False, error=SourceError("broken"))
    with reading(film) as frames:
        film.give(2)
        film.stop()
        each = iter(frames)
        assert [next(each).index, next(each).index] == [0, 1]
        with pytest.raises(SourceError, match="broken"):
            next(each)
