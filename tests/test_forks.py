"""A child of `fork` has none of its parent's threads: it goes on, or says what to do."""

import os
from functools import cache
from pathlib import Path

import pytest

import motes
from forks import in_a_child

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork here")


@cache
def clip() -> list[motes.Frame]:
    return [frame for frame, _ in motes.synthetic.demo((96, 72), frames=30)]


def test_trackers_go_on() -> None:
    with motes.Trackers("nummiaro", threads=2) as trackers:
        trackers.init(clip()[0], [(20, 20, 20, 20)] * 4)
        trackers.update(clip()[1])
        assert in_a_child(lambda: len(trackers.update(clip()[2]))) == "4"
        assert in_a_child(trackers.close) == "None"
        assert len(trackers.update(clip()[2])) == 4


@pytest.mark.slow
def test_frames_are_read_by_one_process(tmp_path: Path) -> None:
    """Both would move on in the same file: the parent has all of its frames."""
    path = tmp_path / "film.mp4"
    with motes.VideoWriter(path, fps=25) as writer:
        for frame in clip()[:9]:
            writer.write(frame.pixels)
        assert "written by another process" in in_a_child(lambda: writer.write(clip()[9].pixels))
        assert in_a_child(writer.close) == "None"
        for frame in clip()[9:]:
            writer.write(frame.pixels)
    with motes.open_source(str(path)) as frames:
        next(frames)
        assert "read by another process" in in_a_child(lambda: len(list(frames)))
        assert len(list(frames)) == len(clip()) - 1
    watched = motes.Scene(lambda frame: []).watch(clip())
    next(watched)
    assert "read by another process" in in_a_child(lambda: len(list(watched)))
    assert len(list(watched)) == len(clip()) - 1
