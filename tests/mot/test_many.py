"""A scene of very many detections: of too many the surest are taken."""

from __future__ import annotations

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


@pytest.fixture(autouse=True)
def certain(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let no detection be too doubtful."""
    monkeypatch.setattr(track_initiation, "LOWEST", 0.0)


def config(**changes: object) -> SceneConfig:
    """Return a scene whose objects take little time of their own."""
    return replace(SceneConfig(quick(particles=2, places=5)), **changes)


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
