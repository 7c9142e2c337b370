"""An object that goes behind something keeps its size and its velocity."""

import numpy as np
import pytest
from msgspec.structs import replace

from motes import Box, Detection
from motes.mot.hiding import Hiding, Sighting, hiding_of
from motes.mot.stages.associate import associate
from scene_objects import DT, RED, config, picture, undetected

SPEED = 50.0
"""In pixels a second: two pixels a frame."""


@pytest.mark.parametrize(
    ("left", "right", "frames", "hiding"),
    [
        (2, 0, 8, Hiding(1, SPEED, 40)),
        (2, 0, 4, None),  # too few to tell
        (2, 2, 8, None),  # in plain sight
        (0, 2, 8, None),  # it comes out
        (4, 0, 8, None),  # the foot that swings, twice as fast
        (0, -2, 8, None),  # it would go the other way
    ],
)
def test_the_hidden_side_stands_while_the_other_goes_on(
    left: int, right: int, frames: int, hiding: Hiding | None
) -> None:
    boxes = [Box(100 + left * n, 50, 40 + (right - left) * n, 30) for n in range(frames)]
    assert hiding_of([Sighting(n * DT, box, SPEED) for n, box in enumerate(boxes)], 40) == hiding
    mirrored = [box._replace(x=-box.x - box.width) for box in boxes]
    found = hiding_of([Sighting(n * DT, box, -SPEED) for n, box in enumerate(mirrored)], 40)
    assert found == (hiding and Hiding(-hiding.side, -hiding.speed, hiding.width))


def test_who_goes_behind_a_wall_is_nearly_where_it_would_be_in_plain_sight() -> None:
    """Of who has just met another one, a side may be the other's."""
    start, wall = Box(20, 30, 40, 30), 100
    alone = undetected(1, picture(0, (start, RED)), start)
    alone = replace(alone, velocity=np.array([SPEED, 0.0]))
    ends = []
    for each in (alone, replace(alone, met=frozenset({2}))):
        for n in range(1, 36):
            x = 20 + SPEED * n * DT
            box = start._replace(x=x, width=min(40.0, wall - x))
            frame = picture(n, (box, RED))
            (each,), *_ = associate([each], [Detection(box)], frame, DT, config())
            each = each.predict(DT)
        hidden = each.occlude(None)
        ends.append(hidden.predicted.box.x + hidden.predicted.box.width)
    assert ends[0] == pytest.approx(20 + SPEED * 36 * DT + 40, abs=4)
    assert ends[1] < wall + 4


def test_few_detections_tell_nothing() -> None:
    """As boxes tremble, four in 0.24 seconds are not enough; seven are."""
    all_of_them = [Sighting(n * DT, Box(100 + 2 * n, 50, 40 - 2 * n, 30), SPEED) for n in range(7)]
    assert hiding_of(all_of_them, 40) == Hiding(1, SPEED, 40)
    assert hiding_of(all_of_them[::2], 40) is None


def test_what_the_camera_moves_does_not_stand_in_the_scene() -> None:
    """It pans by as much as a side seems to move."""
    box = Box(60, 30, 40, 30)
    each = undetected(1, picture(0, (box, RED)), box).detect(box, DT)
    x, y = each.track.ellipse[:2]
    carried = each.carried((x - 5, y + 2), each.origin)
    assert carried.recent[-1].box == box._replace(x=55, y=32)
