"""What was at a place before the target came: an expert, and its part in the tracker."""

import numpy as np
import pytest

from motes import Discriminative, Ellipse, Status, Tracker
from motes.core.frame import FRAME_INTERVAL, Frame
from motes.sot.discriminative.backdrop import EVERY, MEMORY, Backdrop, BackdropModel
from motes.testing import check_expert

SIDE, STEP = 20, 5
"""Of the target, and how far it moves in a frame, in pixels."""
POST = 160.0
"""Where it goes behind a post."""


def blocks(seed: int, side: int, height: int, width: int) -> np.ndarray:
    """Return a texture of squares, with values from 0 to 1."""
    rng = np.random.default_rng(seed)
    small = rng.random((-(-height // side), -(-width // side), 3))
    return small.repeat(side, axis=0).repeat(side, axis=1)[:height, :width]


SCENE = 60 + 90 * blocks(0, 8, 200, 340)
TARGET = np.stack([255 * blocks(1, 5, SIDE, SIDE)[..., 0], *[np.full((SIDE, SIDE), 40)] * 2], -1)


def seen(number: int, x: float | None, camera: int = 0, tilt: int = 0) -> Frame:
    """Return a frame with the target at `x`, if it is seen, and a post that looks like it."""
    pixels = SCENE.copy()
    left = round(POST) - SIDE // 2
    if x is not None:
        at = round(x) - SIDE // 2
        pixels[90 : 90 + SIDE, at : at + SIDE] = TARGET
    pixels[70:130, left : left + SIDE] = 0.5 * SCENE[70:130, left : left + SIDE] + 40
    pixels[90 : 90 + SIDE, left : left + SIDE] = 0.25 * TARGET + 75
    crop = pixels[tilt : 180 + tilt, 20 + camera : 300 + camera]
    return Frame(number, number * FRAME_INTERVAL, np.ascontiguousarray(crop.astype(np.uint8)))


def place(x: float, camera: int = 0, tilt: int = 0) -> Ellipse:
    return Ellipse(x - 20.5 - camera, 99.5 - tilt, SIDE / 2, SIDE / 2)


def known(camera: int = 0) -> BackdropModel:
    """Return the model after the target has come near the post."""
    expert = Backdrop()
    model = expert.learn(seen(0, 60.0), place(60.0))
    for number in range(1, 13):
        frame, x = seen(number, 60.0 + STEP * number), 60.0 + STEP * number
        model = expert.updated(model, frame, expert.look(model, frame, place(x)), place(x), 1.0)
    return model


def voice(model: BackdropModel, frame: Frame, where: Ellipse) -> float:
    expert = Backdrop()
    return expert.log_odds(expert.look(model, frame, where), where)


def test_it_keeps_the_rules() -> None:
    check_expert(Backdrop())


@pytest.mark.parametrize("camera", [0, 13, -16])
def test_what_was_there_before_is_not_the_target(camera: int) -> None:
    model = known()
    assert voice(model, seen(13, None, camera), place(POST, camera)) < -2
    assert voice(model, seen(13, 200.0, camera), place(200.0, camera)) == 0
    assert voice(model, seen(13, None, camera), place(200.0, camera)) < -2  # bare ground


def test_nothing_is_said_of_a_target_that_rests_or_of_a_new_scene() -> None:
    expert, frame = Backdrop(), seen(0, 60.0)
    model = expert.learn(frame, place(60.0))
    for _ in range(3 * EVERY):
        model = expert.updated(model, frame, expert.look(model, frame, place(60.0)), place(60.0), 1)
    assert voice(model, frame, place(60.0)) == 0
    assert voice(model, seen(1, 60.0, 13, 12), place(60.0, 13, 12)) == 0
    other = Frame(1, FRAME_INTERVAL, (255 * blocks(7, 8, 180, 280)).astype(np.uint8))
    assert voice(known(), other, place(POST)) == 0
    before, post = seen(0, None).pixels, np.s_[90:110, 130:150]
    blurred = (0.68 * before + 0.32 * other.pixels).astype(np.uint8)
    blurred[post] = before[post]  # what is inside is the same, but not what is around
    assert voice(known(), Frame(1, FRAME_INTERVAL, blurred), place(POST)) == 0
    assert voice(known(), frame, Ellipse(-40, 40, 10, 10)) == 0
    assert voice(known(), frame, Ellipse(140, 90, 500, 500)) == 0  # it fills the picture


def test_a_place_that_looks_as_before_is_not_kept_as_the_targets() -> None:
    expert, model, where = Backdrop(), known(), place(POST)
    for number in range(13, 13 + 2 * MEMORY * EVERY):
        frame = seen(number, None)
        model = expert.updated(model, frame, expert.look(model, frame, where), where, 1.0)
    assert voice(model, seen(99, None), where) < -2


def test_pictures_are_kept_while_the_target_is_seen() -> None:
    expert, frame, where = Backdrop(), seen(0, 60.0), place(60.0)
    model, counts = expert.learn(frame, where), []
    for number in range(1, 8 * EVERY):
        seen_now = number <= EVERY or number > 3 * EVERY
        sight = expert.look(model, frame, where)
        model = expert.updated(model, frame, sight, where, float(seen_now))
        counts.append(len(model.snapshots))
    assert counts[EVERY - 2 : EVERY] == [1, 2]
    assert counts[3 * EVERY - 1 : 3 * EVERY + 1] == [2, 3]
    assert max(counts) == MEMORY
    assert expert.placed(model, where).snapshots == ()


@pytest.mark.parametrize(("weight", "status"), [(16.0, Status.SEARCHING), (0.0, Status.TRACKING)])
def test_a_target_behind_a_post_is_lost(weight: float, status: Status) -> None:
    """Without the expert the post is followed."""
    tracker = Tracker(Discriminative(backdrop=Backdrop(weight=weight)), seed=0)
    tracker.init(seen(0, 60.0), place(60.0))
    for number in range(1, 21):
        track = tracker.update(seen(number, 60.0 + STEP * number))
    for number in range(21, 36):
        track = tracker.update(seen(number, None))
    assert track.status is status
