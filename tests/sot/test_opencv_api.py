"""The methods of OpenCV's trackers."""

from __future__ import annotations

import inspect
from collections.abc import Callable

import numpy as np
import pytest

from motes import synthetic
from motes.core.errors import ConfigError, SourceError
from motes.sot.opencv_api import OpenCVTracker

CLIP = synthetic.still((160, 120), target=(30, 40), frames=3)
IMAGES = [frame.pixels[:, :, ::-1] for frame, _ in CLIP]
BOX = tuple(round(value) for value in CLIP[0][1][0].ellipse.box)


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


def test_create_is_the_constructor() -> None:
    made, created = (
        inspect.signature(each).parameters for each in (OpenCVTracker, OpenCVTracker.create)
    )
    assert made == created


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda: OpenCVTracker.create("csrt"), ConfigError, "No preset"),
        (lambda: OpenCVTracker().init(IMAGES[0], (30, 36, 10)), ConfigError, "A box has 4 numbers"),
        (lambda: OpenCVTracker().init(IMAGES[0], None), ConfigError, "got None"),  # type: ignore[arg-type]
        (lambda: OpenCVTracker().init(None, BOX), SourceError, "no picture"),  # type: ignore[arg-type]
        (lambda: OpenCVTracker().update(IMAGES[0]), ConfigError, "no target yet"),
        (lambda: OpenCVTracker().track, ConfigError, "no track before init"),
    ],
)
def test_what_is_refused(call: Callable[[], object], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        call()


def test_found_and_confident_is_what_is_tracked() -> None:
    tracker = OpenCVTracker("nummiaro")
    image = np.zeros((60, 80, 3), np.uint8)
    image[20:40, 30:50] = 200, 60, 20
    tracker.init(image, (30, 20, 20, 20))
    ok, box = tracker.update(image)
    assert ok
    assert tuple(map(round, tracker.track.box)) == box
    assert tracker.track.confidence > 0.5
    answers = [tracker.update(np.zeros_like(image))[0] for _ in range(6)]
    assert answers[-1] is False
