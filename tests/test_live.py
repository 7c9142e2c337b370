"""Live sources against a server that sends, stalls, hangs up and comes back."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from motes import decoder, live
from motes.errors import SourceError
from motes.frame import Frame
from motes.live import Live, open_watched
from motes.video import Source
from motes.writer import VideoWriter
from streams import camera

TIMEOUT = 0.5


@pytest.fixture(autouse=True)
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(decoder, "OPEN_TIMEOUT", TIMEOUT)
    monkeypatch.setattr(decoder, "READ_TIMEOUT", TIMEOUT)
    monkeypatch.setattr(live, "FIRST_PAUSE", 0.05)


def gray(index: int) -> NDArray[np.uint8]:
    return np.full((64, 96, 3), 20 + index % 200, np.uint8)


def frames(film: Source | Live) -> Iterator[Frame | str]:
    """Yield what comes, for no more than some seconds."""
    begun = time.monotonic()
    for news in film:
        yield news
        assert time.monotonic() - begun < 12, "it goes on for ever"


def words(news: Iterator[Frame | str]) -> str:
    """Return what is said next."""
    return next(each for each in news if isinstance(each, str))


def test_a_stall_is_noticed_and_so_is_the_return() -> None:
    with camera(gray) as stream, open_watched(stream.url) as film:
        assert isinstance(film, Live)
        news = frames(film)
        assert isinstance(next(news), Frame)
        stream.stalled.set()
        begun = time.monotonic()
        said = words(news)
        assert "does not answer" in said
        assert "tried again" in said
        assert "secret" not in said
        assert time.monotonic() - begun < TIMEOUT + 1
        stream.stalled.clear()
        assert "is back after" in words(news)
        before, after = next(news), next(news)
        assert isinstance(before, Frame)
        assert isinstance(after, Frame)
        assert before.time < after.time
        assert stream.connections > 1


def test_a_server_that_goes_away_is_retried_with_growing_pauses() -> None:
    with camera(gray) as stream, open_watched(stream.url) as film:
        news = frames(film)
        next(news)
        stream.hung_up.set()
        begun = time.monotonic()
        assert "tried again" in words(news)
        assert time.monotonic() - begun < TIMEOUT + 1
        before = stream.connections
        time.sleep(1.2)  # pauses of 0.05, 0.1, 0.2, 0.4 and 0.8 s
        assert 2 <= stream.connections - before <= 6
        stream.hung_up.clear()
        assert "is back after" in words(news)  # with nothing said in between


def test_who_is_slow_gets_the_newest_frame_and_a_count_of_the_others() -> None:
    """Pictures tell when they were painted; what the container and the network take, stays."""
    with camera(gray) as stream, open_watched(stream.url) as film:
        assert isinstance(film, Live)
        news = frames(film)
        for _ in range(20):  # let what came while it was opened pass
            next(news)
        indices, ages = [], []
        dropped = film.dropped
        for _ in range(6):
            time.sleep(0.1)  # five frames
            frame = next(news)
            assert isinstance(frame, Frame)
            indices.append(frame.index)
            ages.append(time.monotonic() - film._origin - frame.time)
        assert max(ages) < 2 / 50
        lost = indices[-1] - indices[0] - 5
        assert 12 < lost <= film.dropped - dropped


def test_a_camera_without_a_word_is_noticed_by_the_clock() -> None:
    """Drivers may hang where FFmpeg's timeout does not reach."""

    class Silent:
        name = "camera 0"

        def __enter__(self) -> Silent:
            return self

        def __exit__(self, *_: object) -> None: ...

        def __iter__(self) -> Iterator[Frame]:
            yield Frame(0, 0.0, gray(0))
            time.sleep(TIMEOUT + 1.2)
            yield Frame(1, 0.0, gray(0))

    begun = time.monotonic()
    with Live("0", Silent()) as film:  # type: ignore[arg-type]
        news = frames(film)
        assert isinstance(next(news), Frame)
        assert words(news).startswith("camera 0 sends no pictures")
        assert time.monotonic() - begun < TIMEOUT + 1
        assert words(news).startswith("camera 0 is back after 0.")


def test_an_address_that_does_not_answer_yet_is_waited_for() -> None:
    with camera(gray) as stream:
        stream.hung_up.set()
        with open_watched(stream.url) as film:
            news = frames(film)
            assert "tried again" in words(news)
            stream.hung_up.clear()
            assert "is back" in words(news)
            assert isinstance(next(news), Frame)


def test_a_recording_is_read_as_it_is(tmp_path: Path) -> None:
    with VideoWriter(tmp_path / "film.mkv", 25) as writer:
        for index in range(5):
            writer.write(gray(index))
    with open_watched(str(tmp_path / "film.mkv")) as film:
        assert isinstance(film, Source)
        assert len(list(film)) == 5
    with pytest.raises(SourceError, match="There is no file"):
        open_watched(str(tmp_path / "nothing.mkv"))
