"""What a camera usually sees: the pictures that are kept, and their usual colors."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from motes import kernels
from motes.mot.detection.background_model import DENSEST, HALF, KEPT, Preview, usual_colors

Pictures = NDArray[np.uint8]


def usual_by_numpy(pictures: Pictures) -> Pictures:
    """Return the usual colors; all are sorted by brightness, and all groups compared."""
    count, group = len(pictures), math.ceil(len(pictures) * DENSEST)
    times = np.arange(count)
    times = times[np.argsort(np.minimum(times, times[::-1]), kind="stable")]
    brightness = pictures.sum(axis=3, dtype=int)
    order = times[np.argsort(brightness[times], axis=0, kind="stable")]
    ranked = np.take_along_axis(brightness, order, axis=0)
    width = ranked[group - 1 :] - ranked[: count - group + 1]
    groups = np.lib.stride_tricks.sliding_window_view(order, group, axis=0)
    passing = np.ptp(groups, axis=3) < count / 2
    first = np.where(passing, width + 3 * 256, width).argmin(axis=0)
    chosen = np.take_along_axis(order, first + np.arange(group)[:, None, None], axis=0)
    own = np.take_along_axis(pictures, chosen[..., None], axis=0)
    usual: Pictures = np.rint(own.mean(axis=0)).astype(np.uint8)
    return usual


@pytest.mark.parametrize("count", [1, 2, 3, 7, 16, 30, KEPT])
@pytest.mark.parametrize("levels", [5, 256])
def test_usual_colors_equal_those_by_numpy(count: int, levels: int) -> None:
    """With few levels many pictures are equally bright, and many groups equally close."""
    rng = np.random.default_rng(count)
    pictures = rng.integers(256 - levels, 256, (count, 4, 71, 3)).astype(np.uint8)
    np.testing.assert_array_equal(usual_colors(pictures), usual_by_numpy(pictures))


def test_a_ground_without_noise_is_found_behind_who_passes() -> None:
    """Its pictures are equal to the bit, as in drawn film and where a codec repeats a picture."""
    ground = np.full((6, 40, 3), 120, np.uint8)
    pictures = np.stack([ground] * 30)
    for index, picture in enumerate(pictures):
        left, right = max(3 * index - 50, 0), max(3 * index - 30, 0)
        picture[:, left:right] = 160, 100, 98  # nearly the ground's brightness
    np.testing.assert_array_equal(usual_colors(pictures), ground)


def test_the_usual_colors_are_found_though_objects_cover_them_most_of_the_time() -> None:
    """Of 31 frames 12 show the ground; the median is that of the objects."""
    rng = np.random.default_rng(0)
    ground = np.array([120, 110, 100])
    pictures = np.empty((31, 8, 9, 3), np.uint8)
    for index, picture in enumerate(pictures):
        color = ground if index % 5 in (0, 1) and index < 30 else rng.integers(0, 80, 3)
        picture[:] = np.clip(color + rng.integers(-3, 4, (8, 9, 3)), 0, 255)
    assert np.abs(usual_colors(pictures) - ground).max() <= 4
    assert np.abs(np.median(pictures, axis=0) - ground).max() > 20


@pytest.mark.parametrize(
    ("shape", "group", "out"),
    [
        ((0, 4, 9), 1, (4, 9)),
        ((KEPT + 1, 4, 9), 11, (4, 9)),
        ((3, 4, 9), 0, (4, 9)),
        ((3, 4, 9), 4, (4, 9)),
        ((3, 4, 10), 1, (4, 10)),
        ((3, 4, 9), 1, (3, 9)),
    ],
)
def test_the_kernel_refuses_what_does_not_fit(
    shape: tuple[int, ...], group: int, out: tuple[int, int]
) -> None:
    with pytest.raises(ValueError, match="up to 31 pictures"):
        kernels.preview.usual_colors(np.zeros(shape, np.uint8), group, np.zeros(out, np.uint8))


def test_the_pictures_that_are_kept_are_spread_over_all_the_time() -> None:
    preview, told = Preview(), []
    for number in range(200):
        picture = np.full((2, 3, 3), number, np.uint8)
        if preview.add(picture):
            told.append(number)
        picture[:] = 255  # a caller may write the next one there
        kept = preview.pictures[:, 0, 0, 0].tolist()
        step = kept[1] if number else 1
        assert kept == list(range(0, number + 1, step))[:KEPT]
        assert len(kept) >= min(number + 1, HALF)
    assert told == [15, 30, 60, 120]
