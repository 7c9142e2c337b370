"""Pipes: read as files are, and stopped while they are silent."""

from __future__ import annotations

import contextlib
import os
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from clips import clip, remuxed
from motes.core.errors import SourceError
from motes.video.sources import is_recorded, open_source


@contextlib.contextmanager
def sent(data: bytes, folder: Path) -> Iterator[tuple[str, Callable[[], None]]]:
    """Give a FIFO into which data are written, and a function that closes it at the other end."""
    path = folder / "pipe"
    os.mkfifo(path)
    closing = threading.Event()

    def write() -> None:
        with contextlib.suppress(BrokenPipeError), path.open("wb", buffering=0) as pipe:
            pipe.write(data)
            closing.wait()

    thread = threading.Thread(target=write)
    thread.start()
    try:
        yield str(path), closing.set
    finally:
        closing.set()
        thread.join()


@pytest.mark.parametrize("ending", ["ts", "mkv", "mp4"])
def test_a_pipe_gives_the_pictures_of_the_file(tmp_path: Path, ending: str) -> None:
    path = clip(tmp_path / f"film.{ending}", 30)
    with open_source(path) as file:
        expected = list(file)
    with sent(path.read_bytes(), tmp_path) as (name, close):
        close()
        assert not is_recorded(name)
        with open_source(name) as piped:
            frames = list(piped)
            assert piped.report.problems is None
    assert [frame.time for frame in frames] == [frame.time for frame in expected]
    for frame, other in zip(frames, expected, strict=True):
        assert np.array_equal(frame.pixels, other.pixels)


def test_an_interrupt_ends_the_opening_of_a_silent_pipe(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object) -> object:
        time.sleep(0.1)
        raise KeyboardInterrupt

    with sent(b"G", tmp_path) as (name, _):
        monkeypatch.setattr("concurrent.futures.Future.result", interrupted)
        with pytest.raises(KeyboardInterrupt):
            open_source(name)
    assert not [each for each in threading.enumerate() if "ThreadPool" in each.name]


@pytest.mark.parametrize("frames", [10, pytest.param(70, marks=pytest.mark.slow)])
def test_an_mp4_with_its_index_at_the_end_is_told_from_a_damaged_one(
    tmp_path: Path, frames: int
) -> None:
    film = clip(tmp_path / "film.mp4", frames, width=160, height=120, noisy=True)
    with sent(remuxed(film), tmp_path) as (name, close):
        close()
        with pytest.raises(SourceError, match=r"index at the end.*give the file, or send MPEG-TS"):
            list(open_source(name))
