"""Detectors that start a tracker."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from motes.core.detection import Detection, best
from motes.core.errors import MissingDependencyError
from motes.core.frame import Frame
from motes.core.geometry import Box
from motes.mot.detection.pretrained import FaceDetector

FRAME = Frame(0, 0.0, np.zeros((80, 100, 3), np.uint8))


def test_the_surest_is_taken() -> None:
    first, second = Detection(Box(1, 1, 9, 9), 0.3), Detection(Box(40, 40, 9, 9), 0.7)
    assert best([first, second], FRAME) is second
    assert best([second, first], FRAME) is second
    assert best([], FRAME) is None
    assert best([first, Detection(Box(2, 2, 5, 5), 0.3)], FRAME) is first


@pytest.mark.parametrize(
    "box",
    [
        Box(-9, 5, 10, 10),
        Box(97, 5, 10, 10),
        Box(5, 77, 10, 10),
        Box(5, -9, 10, 10),
        Box(0, 0, 101, 10),
        Box(0, 0, 10, 81),
        Box(5, 5, 1.5, 10),
        Box(5, 5, 10, 0),
    ],
)
def test_what_no_tracker_could_start_on_is_left_out(box: Box) -> None:
    assert best([Detection(box, 9.0)], FRAME) is None
    other = Detection(Box(5, 5, 10, 10), 0.1)
    assert best([Detection(box, 9.0), other], FRAME) is other


def test_without_dlib_the_remedy_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "dlib", None)
    with pytest.raises(MissingDependencyError, match=r"pip install 'motes\[faces\]'"):
        FaceDetector()
