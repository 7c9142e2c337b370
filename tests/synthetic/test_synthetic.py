"""The rendered clips and painted films against what their pixels show."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from motes import ConfigError, Ellipse, synthetic
from motes.synthetic import Pitch, Street, Target
from motes.synthetic.clips import Clip, Stem
from motes.synthetic.painted_film import PaintedFilm
from motes.synthetic.scenery import backdrop

CLIPS: list[Callable[..., Clip]] = [
    synthetic.demo,
    synthetic.jumping,
    synthetic.turning,
    synthetic.rolling,
    synthetic.growing,
    synthetic.occluded,
    synthetic.crossing,
    synthetic.still,
]
SMALL = (160, 120)


def masks(clip: Clip) -> NDArray[np.bool_]:
    """Return (frames, H, W): where the first target shows, as its color makes a difference."""
    first, second = (
        np.stack(
            [
                frame.pixels
                for frame, _ in replace(
                    clip, targets=(Target(clip.targets[0].states, (color,) * 3), *clip.targets[1:])
                )
            ]
        ).astype(int)
        for color in ((250, 0, 250), (0, 250, 0))
    )
    # The skin's rim has about 0.6 of the full difference, and half of that where it is half seen.
    return np.asarray(np.abs(first - second).sum(axis=3) > 0.3 * 3 * 227)


def moments(mask: NDArray[np.bool_]) -> Ellipse:
    """Return the ellipse with a mask's center and second moments; theta in [-π/2, π/2]."""
    y, x = np.nonzero(mask)
    values, vectors = np.linalg.eigh(np.cov(x, y, bias=True))
    theta = math.atan(vectors[1, 1] / vectors[0, 1])
    return Ellipse(x.mean(), y.mean(), 2 * math.sqrt(values[1]), 2 * math.sqrt(values[0]), theta)


def test_the_truth_is_the_ellipse_that_the_pixels_show() -> None:
    rng = np.random.default_rng(4)
    states = rng.uniform((50, 50, 20, 0.4, -math.pi), (110, 70, 45, 0.8, math.pi), (30, 5))
    states[:, 3] *= states[:, 2]
    states[0, 4], states[1, 4] = 0, math.pi / 2
    clip = Clip(SMALL, (Target(states),))
    for mask, (_, (truth,)) in zip(masks(clip), clip, strict=True):
        found = moments(mask)
        assert found[:4] == pytest.approx(truth.ellipse[:4], abs=0.3)
        difference = (found.theta - truth.ellipse.theta + math.pi / 2) % math.pi - math.pi / 2
        assert math.degrees(abs(difference)) < 1


def test_a_part_of_a_clip_is_no_frame() -> None:
    with pytest.raises(TypeError, match="slice"):
        synthetic.demo(SMALL, frames=3)[:2]  # type: ignore[index]


def test_the_visible_fraction_is_that_of_the_pixels() -> None:
    places = [(60, 60), (2, 60), (-10, 60), (80, 118), (155, -5), (75, 60), (100, 60), (300, 60)]
    states = np.array([[x, y, 30, 18, 0.4] for x, y in places], float)
    clip = Clip(SMALL, (Target(states),), (Stem(90, 30, 0.2),))
    for mask, (_, (truth,)) in zip(masks(clip), clip, strict=True):
        assert truth.visible == pytest.approx(mask.sum() / truth.ellipse.area, abs=0.02)
        assert 0 <= truth.visible <= 1


def test_a_target_in_front_hides_the_one_behind() -> None:
    states = np.array([[[80.0, 60, 30, 20, 0.0]], [[100.0, 64, 28, 20, 0.5]]])
    clip = Clip(SMALL, (Target(states[0]), Target(states[1])))
    behind, front = clip[0][1]
    assert front.visible == pytest.approx(1, abs=0.01)
    assert behind.visible == pytest.approx(masks(clip).sum() / behind.ellipse.area, abs=0.02)
    assert 0.3 < behind.visible < 0.7


def test_a_target_that_is_not_visible_leaves_no_trace() -> None:
    clip = synthetic.occluded(SMALL)
    states = clip.targets[0].states
    other = replace(clip, targets=(Target(states, ((255, 0, 255),) * 3),))
    without = replace(clip, targets=(Target(states + np.array([9000, 0, 0, 0, 0])),))
    hidden = [index for index, (_, (truth,)) in enumerate(clip) if truth.visible == 0]
    assert len(hidden) >= 12
    for index in hidden:
        assert np.array_equal(clip[index][0].pixels, other[index][0].pixels)
    middle = hidden[6]  # at either end of its way behind the stem its shadow may still be seen
    assert np.array_equal(clip[middle][0].pixels, without[middle][0].pixels)


def test_the_texture_turns_with_the_target() -> None:
    states = np.array([[79.5, 59.5, 40, 40, quarter * math.pi / 2] for quarter in range(4)])
    clip = Clip(SMALL, (Target(states),))
    y, x = np.mgrid[-59.5:60, -79.5:80]
    inside = np.hypot(x, y)[:, 20:-20] < 38
    upright = clip[0][0].pixels[:, 20:-20].astype(float)
    for quarter in range(4):
        turned = np.rot90(upright, -quarter)  # clockwise, as theta
        pixels = clip[quarter][0].pixels[:, 20:-20].astype(float)
        assert np.abs(pixels - turned)[inside].mean() < 8
        if quarter:
            assert np.abs(pixels - upright)[inside].mean() > 30


@pytest.mark.slow
@pytest.mark.parametrize("make", CLIPS)
def test_every_clip_is_the_same_each_time_in_any_order(make: Callable[..., Clip]) -> None:
    clip, again = make(SMALL, frames=12, seed=5), make(SMALL, frames=12, seed=5)
    last = again[11][0].pixels
    for index, (frame, truths) in enumerate(clip):
        assert frame.index == index
        assert frame.time == pytest.approx(index / 25)
        assert frame.pixels.shape == (120, 160, 3)
        assert frame.pixels.dtype == np.uint8
        assert frame.pixels.flags.c_contiguous
        assert frame.pixels.flags.writeable
        assert len(truths) == len(clip.targets)
    assert np.array_equal(frame.pixels, last)
    assert np.array_equal(frame.pixels, clip[-1][0].pixels)
    assert not np.array_equal(frame.pixels, make(SMALL, frames=12, seed=6)[11][0].pixels)
    assert np.array_equal(again.targets[0].states, make(SMALL, frames=12).targets[0].states)
    with pytest.raises(IndexError):
        clip[12]


def test_equal_seeds_give_equal_scenery() -> None:
    first = backdrop(5, SMALL, (Stem(90, 30, 0.2),))
    backdrop.cache_clear()
    for one, other in zip(first, backdrop(5, SMALL, (Stem(90, 30, 0.2),)), strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.slow
@pytest.mark.parametrize("size", [(32, 32), (96, 32)])
@pytest.mark.parametrize("make", CLIPS)
def test_odd_sizes(make: Callable[..., Clip], size: tuple[int, int]) -> None:
    options = {"length": 1} if make is synthetic.occluded else {}
    frame, _ = make(size, **options)[3]
    assert (frame.width, frame.height) == size


def test_what_cannot_be_rendered_is_refused() -> None:
    with pytest.raises(ConfigError, match="hides the target for 200 frames; choose a shorter"):
        synthetic.occluded(length=200)
    with pytest.raises(ConfigError, match="20x480 is too small; take 32x32"):
        synthetic.demo((20, 480))
    with pytest.raises(ConfigError, match="ask for 1 or more"):
        synthetic.demo(frames=0)


FILMS = [Street, Pitch]


@pytest.mark.parametrize("film", FILMS)
def test_equal_seeds_give_equal_frames(film: Callable[[int], PaintedFilm]) -> None:
    (first, truths), (again, _) = film(3)[40], film(3)[40]
    assert (first.pixels == again.pixels).all()
    assert (first.pixels != film(4)[40][0].pixels).any()
    assert first.pixels.shape == (270, 480, 3)
    assert first.index == 40
    assert first.time == pytest.approx(1.6)
    assert truths == film(4)[40][1]  # the seed does not move what is followed
    assert len(film(3)) == 200


@pytest.mark.parametrize("film", FILMS)
def test_what_moves_is_in_the_boxes_of_the_truth(film: Callable[[int], PaintedFilm]) -> None:
    made = film(0)
    before, after = (made.picture(time).reduce(2) for time in (60, 60.5))
    moved = np.abs(np.asarray(after, int) - np.asarray(before)).sum(axis=2) > 60
    if film is Pitch:  # the camera moves all else
        moved[:90] = False
    covered = np.zeros_like(moved)
    for box in made.boxes(60):
        top, left = max(round(box.y) - 3, 0), max(round(box.x) - 4, 0)
        bottom, right = round(box.y + box.height) + 9, round(box.x + box.width) + 18  # shadows
        covered[top : max(bottom, 0), left : max(right, 0)] = True
    assert moved.sum() > 150
    assert (moved & ~covered).sum() < (0.02 if film is Street else 0.5) * moved.sum()


def test_a_car_is_hidden_behind_the_lorry_and_seen_again() -> None:
    street = Street()
    visible = [street.truths(index)[0].visible for index in range(len(street))]
    assert visible[30] == pytest.approx(1)
    assert min(visible[60:100]) < 0.2
    assert max(visible[100:130]) > 0.9
