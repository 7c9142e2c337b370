"""Tracks and frames in one line, as corners and as plain values."""

import json
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace
from numpy.typing import NDArray

from motes.core.geometry import Ellipse
from motes.core.track import BOX, COLUMNS, Status, Track

ELLIPSE = Ellipse(30.0, 40.0, 10.0, 5.0)
TRACK = Track(7, 0.28, ELLIPSE, np.zeros((5, 5)), 0.875, Status.TRACKING, 0.1, 50.0)
OBJECT = replace(TRACK, identity=3, occluded_by=4, label="car")


def test_a_track_is_one_line() -> None:
    line = "Track(frame=7, time=0.280 s, identity={}, status=tracking, "
    line += "box=(20.5, 35.5, 20.0, 10.0), "
    assert str(TRACK) == repr(TRACK) == line.format(1) + "confidence=0.88)"
    assert str(OBJECT) == line.format(3) + "confidence=0.88, occluded_by=4, label='car')"


def test_a_track_as_plain_values() -> None:
    values = TRACK.to_dict()
    assert tuple(values) == COLUMNS
    assert json.loads(json.dumps(values)) == values
    assert values["status"] == "tracking"
    assert type(values["status"]) is str
    assert Ellipse(*(values[name] for name in Ellipse._fields)) == ELLIPSE
    assert (values["frame"], values["time"], values["distance"]) == (7, 0.28, 0.1)


def test_an_object_as_plain_values() -> None:
    values = OBJECT.to_dict()
    assert (values["id"], values["occluded_by"]) == (3, 4)
    x, y, width, height = (values[name] for name in BOX)
    assert OBJECT.box == TRACK.box == (x, y, width, height)
    assert OBJECT.xyxy == (x, y, x + width, y + height)


@pytest.mark.parametrize("number", [np.nan, np.inf])
def test_plain_values_are_valid_json(number: float) -> None:
    numbers = Ellipse(*np.array(ELLIPSE))
    index: Any = np.int64(7)
    track = Track(index, np.float64(0.28), numbers, *_rest(distance=number))
    assert json.loads(json.dumps(track.to_dict(), allow_nan=False))["distance"] is None
    assert json.loads(json.dumps(track.to_dict(), allow_nan=False))["frame"] == 7


def _rest(distance: float = 0.1) -> tuple[NDArray[np.float64], float, Status, float, float]:
    return np.zeros((5, 5)), np.float64(0.875), Status.TRACKING, np.float64(distance), 50.0
