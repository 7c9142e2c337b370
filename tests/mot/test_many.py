"""A scene of very many detections: its work grows with their number, and there is a limit."""

from __future__ import annotations

import sys
import tracemalloc
from typing import NamedTuple

import numpy as np
import pytest
from msgspec.structs import replace

from motes.core.detection import Detection
from motes.core.frame import Frame
from motes.core.geometry import Box
from motes.mot import track_initiation
from motes.mot.boxes import as_rows
from motes.mot.scene import Scene
from motes.mot.scene_config import DetectionSelection, Initiation, SceneConfig
from motes.mot.track_initiation import SCORES, TrackInitiation
from scene_objects import grid, quick

GRAY = np.full((480, 640, 3), 100, np.uint8)
BORN, HIDDEN, FRAMES = 3, 4, 7
"""Objects are born in the frame before; from then on, half of them have no detection, then all."""


@pytest.fixture(autouse=True)
def certain(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let no detection be too doubtful."""
    monkeypatch.setattr(track_initiation, "LOWEST", 0.0)


class Work(NamedTuple):
    """What the frames after the births took: calls of functions, and bytes at a time."""

    calls: int
    bytes: int


def config(**changes: object) -> SceneConfig:
    """Return a scene whose objects take little time of their own."""
    return replace(SceneConfig(quick(particles=2, places=5)), **changes)


def found(index: int, count: int) -> list[Detection]:
    """Return objects, a double of each, and things that are born nowhere."""
    boxes, rng = grid(count, 0.36), np.random.default_rng(index)
    shown = boxes[::2] if index == HIDDEN else boxes
    noise = np.hstack([rng.uniform(0, 400, (count, 2)), boxes[:, 2:]])
    kinds = [(shown, 1.0), (shown + 0.01, 0.9)] + [(noise, 0.5)] * (index >= BORN)
    return [Detection(Box(*box), score) for some, score in kinds for box in some.tolist()]


def work(count: int) -> Work:
    """Follow so many objects, all detected, half of them hidden, and found again; count."""
    there: list[Detection] = []
    scene, calls = Scene(lambda _: there, config()), 0

    def called(_frame: object, event: str, _argument: object) -> None:
        nonlocal calls
        calls += event in ("call", "c_call")

    before = sys.getprofile()
    for index in range(FRAMES):
        there = found(index, count)
        frame = Frame(index, index / 5, GRAY)
        if index < BORN:
            scene.update(frame)
            continue
        if index == BORN:
            assert scene.created == count
            tracemalloc.start()
        sys.setprofile(called)
        try:
            scene.update(frame)
        finally:
            sys.setprofile(before)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert count < scene.created < 1.5 * count  # the hidden half was found, and little noise came
    return Work(calls, peak)


@pytest.mark.slow
def test_four_times_the_objects_take_four_times_the_work() -> None:
    """Sixteen times, if anything was asked of each pair; the work is counted, not timed."""
    work(80)  # imports, also those that only many need
    few, many = work(20), work(80)
    assert many.calls < 6 * few.calls
    assert many.bytes < 6 * few.bytes


def test_of_too_many_detections_the_surest_are_taken_and_that_is_told_once() -> None:
    there = [Detection(Box(*box), score) for score, box in enumerate(grid(12, 0.36).tolist())]
    eight = config(detections=DetectionSelection(limit=8))
    scene = Scene(lambda _: there, eight)
    for index in range(4):
        scene.update(Frame(index, index / 25, GRAY))
    assert scene.created == 8
    assert scene.warnings == {
        "limit": "Frame 0: there are 12 detections; only the 8 surest are taken."
    }


def test_how_sure_detections_are_is_judged_by_all_of_a_large_frame(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The surest come first, so that the last ones alone would let too many pass."""
    monkeypatch.setattr(track_initiation, "LOWEST", 0.1)
    births, count = TrackInitiation(), 4 * SCORES
    scored = [Detection(Box(*box), -i) for i, box in enumerate(grid(count, 0.36).tolist())]
    after, _ = births.with_scores(scored, scored).update(
        0.0, scored, as_rows(()), 0.2, Initiation()
    )
    assert len(after.candidates) == 0.9 * count
