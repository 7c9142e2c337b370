"""Live sources against a server that sends, stalls, hangs up and comes back."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.typing import NDArray

from motes import Frame, Source
from motes.video import decoder, pauses
from motes_fleet.cameras import live
from motes_fleet.cameras.live import Live, open_watched
from streams import camera
from waiting import wait_until

TIMEOUT = 0.5
LONG = 60.0
"""Seconds that nothing takes on any machine."""


@pytest.fixture(autouse=True)
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(decoder, "OPEN_TIMEOUT", TIMEOUT)
    monkeypatch.setattr(decoder, "READ_TIMEOUT", TIMEOUT)
    monkeypatch.setattr(live, "pauses", partial(pauses, 0.05))


def gray(index: int) -> NDArray[np.uint8]:
    return np.full((64, 96, 3), 20 + index % 200, np.uint8)


class Camera:
    """A source of frames."""

    name = "camera 0"

    def __init__(self, frames: Iterator[Frame]) -> None:
        self._frames = frames

    def __enter__(self) -> Camera:
        return self

    def __exit__(self, *_: object) -> None: ...

    def __iter__(self) -> Iterator[Frame]:
        return self._frames


def frames(film: Source | Live) -> Iterator[Frame | str]:
    """Yield what comes, for no more than some time."""
    begun = time.monotonic()
    for news in film:
        yield news
        assert time.monotonic() - begun < 600, "it goes on for ever"


def words(news: Iterator[Frame | str], part: str) -> str:
    """Return the next message that has a part; a slow machine may make a source stall by itself."""
    return next(each for each in news if isinstance(each, str) and part in each)


def picture(news: Iterator[Frame | str]) -> Frame:
    """Return the next frame."""
    return next(each for each in news if isinstance(each, Frame))


@pytest.mark.slow
def test_a_stall_is_noticed_and_so_is_the_return() -> None:
    with camera(gray) as stream, open_watched(stream.url) as film:
        assert isinstance(film, Live)
        news = frames(film)
        picture(news)
        stream.stalled.set()
        said = words(news, "does not answer")
        assert "tried again" in said
        assert "secret" not in said
        stream.stalled.clear()
        words(news, "is back after")
        before, after = picture(news), picture(news)
        assert before.time < after.time
        assert stream.connections > 1


@pytest.mark.slow
def test_a_server_that_goes_away_is_retried_with_growing_pauses() -> None:
    with camera(gray) as stream, open_watched(stream.url) as film:
        news = frames(film)
        picture(news)
        begun = time.monotonic()
        stream.hung_up.set()
        words(news, "tried again")
        wait_until(lambda: stream.refusals >= 4)
        assert time.monotonic() - begun > 0.1 + 0.2 + 0.4  # from one refusal to the next
        stream.hung_up.clear()
        said = next(each for each in news if isinstance(each, str))
        assert "is back after" in said  # with nothing said in between


def test_who_is_slow_gets_the_newest_frame_and_a_count_of_the_others(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Frames have the time at which they came, on the reader's clock."""
    clock, burst, taken = SimpleNamespace(now=100.0), threading.Semaphore(0), threading.Event()
    monkeypatch.setattr(live, "time", SimpleNamespace(monotonic=lambda: clock.now))

    def scripted() -> Iterator[Frame]:
        for index in range(100):
            if index % 5 == 0:
                taken.set()  # all of the last burst
                burst.acquire()
            clock.now += 0.04
            yield Frame(index, index / 25, gray(index))

    with Live("0", Camera(scripted())) as film:  # type: ignore[arg-type]
        news = iter(film)
        assert taken.wait(LONG)
        for count in range(1, 7):
            taken.clear()
            burst.release()
            assert taken.wait(LONG)
            frame = next(news)
            assert isinstance(frame, Frame)
            assert frame.pixels[0, 0, 0] == gray(5 * count - 1)[0, 0, 0]
            assert frame.index == 5 * count - 1
            assert film.dropped == 4 * count
            assert frame.time == pytest.approx(clock.now - 100.0, abs=1e-9)


@pytest.mark.slow
def test_a_camera_without_a_word_is_noticed_by_the_clock() -> None:
    """Drivers may hang where FFmpeg's timeout does not reach."""
    noticed = threading.Event()

    def silent() -> Iterator[Frame]:
        yield Frame(0, 0.0, gray(0))
        noticed.wait()
        yield Frame(1, 0.0, gray(0))

    with Live("0", Camera(silent())) as film:  # type: ignore[arg-type]
        news = frames(film)
        picture(news)
        assert words(news, "no pictures").startswith("camera 0 sends no pictures")
        noticed.set()
        assert words(news, "back").startswith("camera 0 is back after ")


def test_an_address_that_does_not_answer_yet_is_waited_for() -> None:
    with camera(gray) as stream:
        stream.hung_up.set()
        with open_watched(stream.url) as film:
            news = frames(film)
            words(news, "tried again")
            stream.hung_up.clear()
            words(news, "is back")
            assert picture(news).pixels.shape == (64, 96, 3)
