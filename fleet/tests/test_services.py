"""The adapter for CVAT, called as its agent does."""

from typing import Any

import pytest
from PIL import Image

from motes import Box
from motes.core import iou
from motes.synthetic import crowd
from motes_fleet.services import cvat_agent

SIZE = (160, 120)


def frames(count: int) -> list[tuple[Any, Box]]:
    """Return the pictures of a moving target, with its boxes."""
    return [(frame.pixels, truths[0].ellipse.box) for frame, truths in crowd(SIZE, (24, 30), count)]


def test_the_box_of_a_polygon_is_around_it() -> None:
    box = cvat_agent.box_of([5.0, 1.0, 9.0, 3.0, 4.0, 8.0])
    assert box == Box(4, 1, 5, 7)
    assert cvat_agent.corners_of(box) == [4, 1, 9, 8]


def test_cvats_agent_runs_the_function() -> None:
    sdk = pytest.importorskip(
        "cvat_sdk.auto_annotation",
        reason="cvat-sdk is not installed; try it in an environment of its own",
    )
    function = cvat_agent.create()
    assert function.spec.supported_shape_types == {"rectangle"}
    film = frames(5)
    first = function.preprocess_image(None, Image.fromarray(film[0][0]))
    shape = sdk.TrackableShape(type="rectangle", points=cvat_agent.corners_of(film[0][1]))
    state = function.init_tracking_state(None, first, shape)
    for pixels, truth in film[1:]:
        image = function.preprocess_image(None, Image.fromarray(pixels))
        found = function.track(None, image, state)
        assert found.type == "rectangle"
        assert iou(cvat_agent.box_of(found.points), truth) > 0.6
