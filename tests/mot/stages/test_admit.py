"""Objects that another camera has announced."""

from __future__ import annotations

import numpy as np
import pytest

from motes.core.detection import Detection
from motes.core.geometry import Box, Ellipse, iou
from motes.mot.expected import CUE, Expected
from motes.mot.scene import SceneState, step
from motes.mot.stages.admit import admit
from scene_objects import DT, RED, config, picture, visible

BOX = Box(60, 40, 20, 30)
FRAME = picture(3, (BOX, RED))
PLACE = Ellipse.from_box(BOX)


def expected(at: Ellipse = PLACE, *, certain: bool = True, spread: float = 2.0) -> Expected:
    """Return that something red is expected, moving to the right."""
    spreads = spread, spread, 0.3, 0.3, 0.0
    samples = np.random.default_rng(0).normal(at, spreads, (50, 5))
    return Expected(7, samples, np.array([50.0, 0.0]), CUE.learn(FRAME, PLACE), certain)


def admitted(*free: Box, objects: tuple[Box, ...] = (), frame=FRAME, **how):  # type: ignore[no-untyped-def]
    there = [visible(n + 1, frame, box) for n, box in enumerate(objects)]
    found = [Detection(box) for box in free]
    return admit(0, len(there), [expected(**how)], there, found, frame, config())


@pytest.mark.parametrize("certain", [True, False])
def test_an_expected_object_begins_with_its_first_detection(certain: bool) -> None:
    other = Box(150, 40, 20, 30)
    (begun,), keys, free = admitted(other, BOX, certain=certain)
    assert begun.detected
    assert begun.track.box == pytest.approx(BOX)
    assert begun.public_track.velocity == (50.0, 0.0)
    assert keys == {begun.identity: 7}
    assert [each.box for each in free] == [other]
    assert begun.identity == 1


def test_its_filter_begins_with_the_given_samples_and_model() -> None:
    (begun,), *_ = admitted()
    np.testing.assert_array_equal(begun.state.models["color"].histogram, expected().model.histogram)
    centers = config().tracker.motion.ellipses(begun.state.states)[:, :2]
    np.testing.assert_allclose(centers, expected().samples[:, :2])


def test_a_certain_one_needs_no_detection() -> None:
    (begun,), *_ = admitted()
    assert not begun.detected
    assert iou(np.array(begun.track.box), np.array([BOX]))[0] > 0.7
    assert admitted(certain=False) == ([], {}, [])


def test_a_scene_begins_it_two_frames_before_a_birth() -> None:
    for arriving, first in ([expected()], 0), ([], 2):
        state = SceneState()
        for index in range(3):
            frame = picture(index, (BOX, RED))
            state, info = step(0, state, frame, DT, [Detection(BOX)], config(), arriving)
            arriving = []
            assert bool(info.tracks) is (index >= first)


def test_a_part_at_the_border_is_enough() -> None:
    """The camera sees the first 6 of 20 columns; most samples have their centers outside."""
    shown = Box(0, 40, 6, 30)
    frame = picture(3, (shown, RED))
    (begun,), *_ = admitted(shown, frame=frame, at=PLACE._replace(x=-4.0))
    assert begun.detected
