"""The methods of OpenCV's trackers."""

from __future__ import annotations

import copy
import inspect
from collections.abc import Callable

import numpy as np
import pytest

from motes import synthetic
from motes.core.errors import ConfigError
from motes.core.track import Status
from motes.sot.opencv_api import OpenCVTracker

CLIP = synthetic.still((160, 120), target=(30, 40), frames=3)
IMAGES = [frame.pixels[:, :, ::-1] for frame, _ in CLIP]
BOX = tuple(round(value) for value in CLIP[0][1][0].ellipse.box)


def test_create_is_the_constructor() -> None:
    tracker, other = OpenCVTracker.create("nummiaro", seed=4), OpenCVTracker("nummiaro", 4)
    for each in (tracker, other):
        assert each.init(IMAGES[0], BOX) is None  # type: ignore[func-returns-value]
    for image in IMAGES[1:]:
        assert tracker.update(image) == other.update(image)
    assert tracker.tracker.info.track.status is Status.TRACKING


@pytest.mark.parametrize("twice", [copy.copy, copy.deepcopy])
def test_a_copy_is_independent(twice: Callable[[OpenCVTracker], OpenCVTracker]) -> None:
    tracker, other = OpenCVTracker("nummiaro"), OpenCVTracker("nummiaro")
    for each in (tracker, other):
        each.init(IMAGES[0], BOX)
    twin = twice(tracker)
    twin.update(IMAGES[1])
    for image in IMAGES[1:]:
        tracker.update(image)
        other.update(image)
        assert tracker.tracker.info.track.ellipse == other.tracker.info.track.ellipse


def test_the_methods_are_those_of_opencv() -> None:
    cv2 = pytest.importorskip("cv2")
    theirs = {name for name in dir(cv2.TrackerMIL) if not name.startswith("_")} - {"Params"}
    assert theirs <= set(dir(OpenCVTracker))


def test_the_same_calls_work_for_both() -> None:
    cv2 = pytest.importorskip("cv2")
    for kind in (cv2.TrackerMIL, OpenCVTracker):
        tracker = kind.create()
        assert tracker.init(IMAGES[0], BOX) is None
        ok, box = tracker.update(IMAGES[1])
        assert ok is True
        assert all(type(value) is int for value in box)
        assert np.abs(np.array(box) - BOX).max() <= 3


def test_nothing_is_created_of_what_is_no_preset() -> None:
    with pytest.raises(ConfigError, match="No preset"):
        OpenCVTracker.create("csrt")
    parameters = [
        inspect.signature(each).parameters for each in (OpenCVTracker, OpenCVTracker.create)
    ]
    assert parameters[0] == parameters[1]


def test_the_confidence_is_that_of_the_track() -> None:
    tracker = OpenCVTracker("nummiaro")
    with pytest.raises(ConfigError, match="no track before init"):
        _ = tracker.track
    image = np.zeros((60, 80, 3), np.uint8)
    image[20:40, 30:50] = 200, 60, 20
    tracker.init(image, (30, 20, 20, 20))
    ok, box = tracker.update(image)
    assert ok
    assert tuple(map(round, tracker.track.box)) == box
    assert tracker.track.confidence > 0.5
