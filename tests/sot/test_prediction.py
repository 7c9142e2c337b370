"""The prediction: how far the camera has moved, which motion goes on, and in which light."""

import math

import numpy as np
import pytest
from msgspec.structs import replace
from numpy.typing import NDArray

from motes import Frame, Tracker
from motes.core.geometry import Ellipse, iou
from motes.sot.discriminative import prediction
from motes.sot.discriminative.prediction import (
    UNNOTICED,
    Light,
    Prediction,
    camera_shift,
    overlap,
    small_picture,
    spectrum_of,
)
from textured import HEIGHT, WIDTH, seen, textured

NOTHING = np.zeros((1, 1), np.float32), np.zeros((1, 1), np.complex64)
"""A small picture, and its transform."""


@pytest.fixture(scope="module")
def scene() -> NDArray[np.uint8]:
    return textured()


@pytest.mark.parametrize(("dx", "dy"), [(0, 0), (7, 0), (-12, 5), (30, -21), (2, 3)])
def test_the_shift_of_the_scene_is_measured(scene: NDArray[np.uint8], dx: int, dy: int) -> None:
    before, after = seen(scene, 100, 100), seen(scene, 100 - dx, 100 - dy)
    one, other = (spectrum_of(small_picture(each)) for each in (before, after))
    shift = camera_shift(one, other, after)
    np.testing.assert_allclose(shift, (dx, dy), atol=1.0)


@pytest.mark.parametrize(
    ("camera", "target", "model"),
    [
        ((9.0, 4.0), (0.0, 0.0), 0),  # the camera follows the target
        ((9.0, -4.0), (9.0, -4.0), 1),  # the target rests in the scene
        ((-5.0, 0.0), (8.0, 3.0), 2),  # it goes on, and the camera's motion says nothing of it
    ],
)
def test_the_model_with_the_least_error_is_followed(
    camera: tuple[float, float], target: tuple[float, float], model: int
) -> None:
    rng = np.random.default_rng(1)
    history = prediction.MotionHistory(*NOTHING, np.zeros(2), np.zeros(2), np.zeros(4))
    place = Ellipse(50.0, 50.0, 10.0, 10.0)
    for _ in range(12):
        sway = rng.choice([-1.0, 1.0])  # of the camera: no model of steady motion foresees it
        moved = sway * np.array(camera)
        velocity = sway * np.array(target) if model == 1 else np.array(target)
        steady = history.velocity
        shifts = np.array([np.zeros(2), moved, steady, moved + steady - history.camera])
        sight = Prediction(*NOTHING, shifts, (NOTHING[0], NOTHING[0]))
        after = place._replace(x=place.x + velocity[0], y=place.y + velocity[1])
        history = sight.update(history, place, after)
        place = after
    assert np.argmin(history.errors) == model
    np.testing.assert_array_equal(sight.likeliest(history), sight.shifts[model])


def test_a_target_is_expected_as_near_as_predictions_were_right() -> None:
    target = Ellipse(50.0, 60.0, 10.0, 10.0)
    history = prediction.MotionHistory(*NOTHING, np.zeros(2), np.array([3.0, 0]), np.full(4, 0.1))
    assert history.transition(target) is None  # nothing has been compared
    assert history.leap(target, target) == 0
    history = replace(history, seen=1)
    transition = history.transition(target)
    assert transition is not None
    assert transition[:2] == target[:2]
    assert transition.sigma == pytest.approx(20 * (0.05 + 2 * 0.1))
    places = np.array([[50.0, 60.0], [55.0, 60.0], [50.0, 70.0]])
    np.testing.assert_allclose(transition.log_density(places), [0, -0.5, -2.0])
    moves = [history.leap(target, target._replace(x=x)) for x in (53.0, 58.0, 43.0)]
    np.testing.assert_allclose(moves, [0, 0.5, 2.0])


def test_a_target_that_is_not_seen_rests_in_the_scene() -> None:
    history = prediction.MotionHistory(*NOTHING, np.zeros(2), np.ones(2), np.arange(4.0))
    shifts = np.array([[0.0, 0.0], [3.0, 4.0], [1.0, 1.0], [4.0, 5.0]])
    sight = Prediction(*NOTHING, shifts, (NOTHING[0], NOTHING[0]))
    after = sight.update(history, Ellipse(5.0, 5.0, 2.0, 2.0), None)
    np.testing.assert_array_equal(after.velocity, (3, 4))
    np.testing.assert_array_equal(after.camera, (3, 4))
    np.testing.assert_array_equal(after.errors, history.errors)


def test_pictures_are_compared_at_rest_if_a_shift_is_wrong(
    scene: NDArray[np.uint8], monkeypatch: pytest.MonkeyPatch
) -> None:
    history, after = prediction.started(small_picture(seen(scene, 100, 100))), seen(scene, 110, 94)
    picture = small_picture(after)
    assert small_picture(after) is picture  # other trackers of the frame take the same one
    before, now = prediction.predictions(history, picture, after).shared
    assert before.shape == now.shape
    assert now.shape < picture.shape
    assert np.abs(now - before).mean() < 0.5 * np.abs(picture - history.picture).mean()
    for wrong in (60.0, float(WIDTH)):
        monkeypatch.setattr(prediction, "camera_shift", lambda *_, x=wrong: np.array((x, 0.0)))
        sight = prediction.predictions(history, picture, after)
        assert sight.shared == (history.picture, picture)


def test_a_wrong_prediction_is_checked_at_the_last_place(
    scene: NDArray[np.uint8], monkeypatch: pytest.MonkeyPatch
) -> None:
    still, place = [seen(scene, 100, 100, index) for index in range(14)], Ellipse(150, 110, 12, 12)
    tracker = Tracker(seed=0)
    tracker.init(still[0], place)
    for frame in still[1:8]:
        tracker.update(frame)
    monkeypatch.setattr(Prediction, "likeliest", lambda self, history: np.array([60.0, 0.0]))
    for frame in still[8:]:
        assert iou(tracker.update(frame).box, place.box) > 0.8


def after(frame: Frame, *frames: Frame, shift: tuple[float, float] = (0, 0)) -> Light:
    """Return the light after frames, of which each is moved by the same shift."""
    light, before = Light(), small_picture(frame)
    for each in frames:
        now = small_picture(each)
        light = light.followed(*overlap(before, now, np.array(shift), each))
        before = now
    return light


@pytest.mark.parametrize("factor", [0.55, 0.8, 1.15])
def test_another_light_is_measured_and_taken_off(scene: NDArray[np.uint8], factor: float) -> None:
    usual, lit = seen(scene, 100, 100), seen(scene, 100, 100, 1, factor)
    light = after(usual, lit)
    assert light.level == pytest.approx(math.log(factor), abs=0.02)
    assert after(usual, lit, lit).level == light.level
    whole = factor * usual.pixels.astype(float) <= 255  # what became white stays so
    restored = light.taken_off(lit)
    assert (restored.index, restored.time) == (lit.index, lit.time)
    off = np.abs(restored.pixels.astype(float) - usual.pixels)[whole]
    assert off.max() <= 4
    assert off.mean() < 2


def test_a_camera_that_moves_is_no_change_of_the_light(scene: NDArray[np.uint8]) -> None:
    # The scene is brighter to the right: without the shift, the pan would seem to be a lamp.
    ramp = np.linspace(0.3, 1, scene.shape[1])[:, None]
    brighter = (scene * ramp).astype(np.uint8)
    usual, moved = seen(brighter, 100, 100), seen(brighter, 200, 130, 1)
    assert abs(after(usual, moved, shift=(-100, -30)).level) < 0.03
    assert after(usual, moved).level > 0.1
    dim = seen(brighter, 200, 130, 1, 0.7)
    level = after(usual, dim, shift=(-100, -30)).level
    assert level == pytest.approx(math.log(0.7), abs=0.03)


def test_frames_in_the_usual_light_are_left(scene: NDArray[np.uint8]) -> None:
    usual = seen(scene, 100, 100)
    assert Light(0.9 * UNNOTICED).taken_off(usual) is usual
    assert Light(-1.1 * UNNOTICED).taken_off(usual) is not usual


@pytest.mark.parametrize("gray", [0, 255])
def test_black_and_white_pictures_say_nothing(scene: NDArray[np.uint8], gray: int) -> None:
    usual = seen(scene, 100, 100)
    flat = Frame(1, 0.04, np.full((HEIGHT, WIDTH, 3), gray, np.uint8))
    assert after(usual, flat).level == 0
    assert after(usual, usual, shift=(WIDTH, 0)).level == 0  # no part is in both


def test_light_changes_by_a_factor_of_two_at_most_and_fades(scene: NDArray[np.uint8]) -> None:
    usual, dim = seen(scene, 100, 100), seen(scene, 100, 100, 1, 0.3)
    assert after(usual, dim).level == pytest.approx(-math.log(2))
    assert Light(0.5).learned(0.04).level == 0.5 * 0.96


def test_the_first_errors_are_averaged_and_later_ones_run() -> None:
    history = prediction.MotionHistory(*NOTHING, np.zeros(2), np.zeros(2), np.zeros(4))
    place, means = Ellipse(50.0, 50.0, 10.0, 10.0), []
    for distance in (20.0, 0.0, 4.0, *9 * [0.0], 20.0):  # what the first model misses, in pixels
        shifts = np.zeros((4, 2))
        sight = Prediction(*NOTHING, shifts, (NOTHING[0], NOTHING[0]))
        history = sight.update(history, place, place._replace(x=place.x + distance))
        means.append(history.errors[0])
    # A side is 20 pixels.
    np.testing.assert_allclose(means[:3], [1.0, 0.5, 1.2 / 3])
    np.testing.assert_allclose(means[9], 1.2 / 10)
    np.testing.assert_allclose(means[12], 0.9 * means[11] + 0.1 * 1.0)
    assert history.seen == 13
