"""The kernels of the background beside plain numpy, SciPy and OpenCV."""

from operator import attrgetter
from typing import Any

import numpy as np
import pytest
import scipy
from numpy.typing import NDArray

from backgrounds import NEEDS_CV2
from motes import kernels
from motes.kernels.structures import HoldLimits, LightLimits, MixtureLearning
from motes.mot.detection.background_model import Mixture
from motes.mot.detection.planes import Planes, planes_of, window_sums
from oracles import mosaic

Mask = NDArray[np.uint8]
SIZES = [(1, 1), (2, 3), (7, 70), (60, 130)]


def picture_of(planes: Planes) -> Mask:
    """Return the picture (H, W, 3) of planes."""
    return np.ascontiguousarray(np.moveaxis(planes, 0, 2))


def random_planes(size: tuple[int, int], seed: int = 0) -> Planes:
    return np.random.default_rng(seed).integers(0, 256, (3, *size)).astype(np.uint8)


def random_mask(size: tuple[int, int], share: float = 0.6, seed: int = 0) -> Mask:
    return (np.random.default_rng(seed).random(size) < share).astype(np.uint8)


def around(plane: NDArray[Any], reach: int) -> NDArray[Any]:
    """Return the values around each pixel (H, W, n, n), mirrored past the border."""
    padded = np.pad(plane, reach, mode="reflect")
    return np.lib.stride_tricks.sliding_window_view(padded, (2 * reach + 1,) * 2)


def test_a_picture_is_exposed_in_any_order_of_its_bytes() -> None:
    tables = np.random.default_rng(0).integers(0, 256, (3, 256)).astype(np.uint8)
    rgb = mosaic(0, 9, 11)
    expected = np.stack([tables[c][rgb[:, :, c]] for c in range(3)])
    bgr = rgb[:, :, ::-1].copy()[:, :, ::-1]
    for picture in (rgb, bgr, np.dstack([rgb, rgb])[:, :, :3]):
        np.testing.assert_array_equal(planes_of(picture, tables), expected)
    np.testing.assert_array_equal(picture_of(planes_of(rgb)), rgb)
    gray = np.broadcast_to(rgb[:, :, :1], rgb.shape)
    np.testing.assert_array_equal(planes_of(gray), np.moveaxis(gray, 2, 0))


@pytest.mark.parametrize("factor", [0.3, 1.0, 2.7])
def test_another_light_in_any_order_of_the_bytes(factor: float) -> None:
    rgb = mosaic(0, 9, 11)
    bgr = rgb[:, :, ::-1].copy()[:, :, ::-1]
    gray = np.broadcast_to(rgb[:, :, :1], rgb.shape)
    for picture in (rgb, bgr, gray, np.dstack([rgb, rgb])[:, :, :3], rgb[2:7, 1:9]):
        out = np.empty(picture.shape, np.uint8)
        kernels.planes.relight(picture, factor, out)
        expected = np.minimum(np.floor(factor * picture.astype(float) + 0.5), 255)
        assert np.abs(out - expected).max() <= (factor != 1)


@pytest.mark.parametrize("side", [1, 3, 4])
def test_mean_green_of_blocks_in_any_order_of_the_bytes(side: int) -> None:
    rgb = mosaic(0, 9, 11)
    bgr = rgb[:, :, ::-1].copy()[:, :, ::-1]
    gray = np.broadcast_to(rgb[:, :, :1], rgb.shape)
    for picture in (rgb, bgr, gray, np.dstack([rgb, rgb])[:, :, :3]):
        out = np.empty((9 // side, 11 // side), np.float32)
        kernels.planes.green_means(picture, side, out)
        green = picture[: len(out) * side, : out.shape[1] * side, 1].astype(np.float32)
        blocks = green.reshape(len(out), side, -1, side)
        np.testing.assert_array_equal(out, blocks.sum(axis=(1, 3)) / np.float32(side**2))


@pytest.mark.parametrize("size", SIZES)
def test_window_sums(size: tuple[int, int]) -> None:
    planes = random_planes(size)
    expected = [around(plane.astype(int), 1).sum(axis=(2, 3)) for plane in planes]
    np.testing.assert_array_equal(window_sums(planes), expected)


def steps(green: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the gradients in x and in y, 0 at the border."""
    across, down = np.zeros_like(green), np.zeros_like(green)
    across[:, 1:-1] = (green[:, 2:] - green[:, :-2]) / 2
    down[1:-1] = (green[2:] - green[:-2]) / 2
    return across, down


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("share", [0.0, 0.05, 0.6])
def test_without_light(size: tuple[int, int], share: float) -> None:
    """A scene whose light changes from left to right, with noise."""
    mask, rng = random_mask(size, share), np.random.default_rng(1)
    usual = 60 + random_planes(size) // 2
    light = np.linspace(0.4, 1.4, size[1])
    now = np.clip(usual * light + rng.normal(0, 15, usual.shape), 0, 255).astype(np.uint8)
    limits = LightLimits(0.5, 1.25, 20.0, 12.0)
    out = np.empty_like(mask)
    kernels.illumination.without_light(mask, window_sums(now), window_sums(usual), limits, out)
    seen, had = window_sums(now) / 9, window_sums(usual) / 9
    factor = (seen.sum(axis=0) + 1) / (had.sum(axis=0) + 1)
    tint = np.abs(seen - factor * had).max(axis=0)
    pairs = zip(steps(seen[1]), steps(had[1]), strict=True)
    edges = mask * sum(np.abs(one - factor * other) for one, other in pairs)
    count = around(mask.astype(int), 2).sum(axis=(2, 3))
    texture = around(edges, 2).sum(axis=(2, 3)) / np.maximum(count, 1)
    same = (factor > 0.5) & (factor < 1.25) & (tint < 20) & (texture < 12)
    np.testing.assert_array_equal(out, mask * ~same)
    if size == SIZES[-1] and share:
        assert 0.02 < (mask & same).sum() / mask.sum() < 0.9


def test_without_tremble() -> None:
    planes, mask = random_planes((9, 40)), random_mask((9, 40))
    low, high = np.sort([random_planes((9, 40), 1), random_planes((9, 40), 2)], axis=0)
    out = np.empty_like(mask)
    kernels.illumination.without_tremble(mask, planes, low, high, out)
    apart = ((planes < low) | (planes > high)).any(axis=0)
    np.testing.assert_array_equal(out, mask * apart)


@pytest.mark.parametrize("size", SIZES)
def test_components(size: tuple[int, int]) -> None:
    mask = random_mask(size, 0.5)
    labels = np.empty(size, np.int32)
    parts = kernels.components.label(mask, labels)
    expected, count = scipy.ndimage.label(mask, np.ones((3, 3)))
    np.testing.assert_array_equal(labels, expected)
    boxes = scipy.ndimage.find_objects(expected)
    assert parts.tolist() == [
        [x.start, y.start, x.stop - x.start, y.stop - y.start, int((labels == number).sum())]
        for number, (y, x) in enumerate(boxes, start=1)
    ]
    assert len(parts) == count


@pytest.mark.parametrize("size", SIZES)
def test_holes(size: tuple[int, int]) -> None:
    outline, before, mask = (random_mask(size, share, seed=7) for share in (0.7, 0.5, 0.1))
    expected = mask | (before & (scipy.ndimage.binary_fill_holes(outline) & (outline == 0)))
    kernels.components.fill_holes(outline, before, mask)
    np.testing.assert_array_equal(mask, expected)


def test_gradients_along_outlines() -> None:
    mask, (_, learned, now) = random_mask((20, 30), 0.9), random_planes((20, 30))
    picture = np.dstack([255 - now, now, learned])
    boxes = np.array([[0, 0, 30, 20], [3, 4, 5, 6], [29, 19, 1, 1], [0, 0, 1, 1]])
    found = np.empty((4, 2))
    kernels.ghosts.outline_gradients(mask, picture, learned, boxes, found)
    padded = np.pad(mask, 1, mode="edge")
    sides = padded[:-2, 1:-1], padded[2:, 1:-1], padded[1:-1, :-2], padded[1:-1, 2:]
    outline = np.any([side != mask for side in sides], axis=0)
    for column, plane in enumerate((now, learned)):
        wide = np.pad(plane.astype(int), 1, mode="edge")
        edges = np.abs(wide[2:, 1:-1] - wide[:-2, 1:-1]) + np.abs(wide[1:-1, 2:] - wide[1:-1, :-2])
        for (x, y, width, height), sums in zip(boxes, found, strict=True):
            here = slice(max(y - 1, 0), y + height + 1), slice(max(x - 1, 0), x + width + 1)
            assert sums[column] == (edges * outline)[here].sum()


@pytest.mark.parametrize("count", [1, 40, 641])
def test_how_far_a_shifted_picture_is_from_the_background(count: int) -> None:
    """The medians of many ratios are found otherwise than those of few."""
    rng, rgb = np.random.default_rng(0), mosaic(0, 60, 80)
    pixels = rng.integers([[4], [4], [0]], [[56], [76], [256]], (3, count)).astype(np.int32)
    shifts = np.array([[0, 0], [4, -3], [-4, 3], [1, 2]], np.int32)
    for picture in (rgb, rgb[:, :, ::-1].copy()[:, :, ::-1], np.dstack([rgb, rgb])[:, :, :3]):
        found = np.empty((4, count))
        kernels.sway.misfits(picture, pixels, shifts, 30, found)
        (rows, columns, usual), (x, y) = pixels, shifts.T[:, :, None]
        green = rgb[rows + y, columns + x, 1]
        gains = np.median(usual / np.maximum(green, 1), axis=1, keepdims=True)
        np.testing.assert_array_equal(found, np.minimum(np.abs(gains * green - usual), 30))
    for picture, some in ((rgb, 10 * shifts), (rgb[:8], shifts), (rgb[:, :8], shifts)):
        with pytest.raises(ValueError, match="misfits needs rows, columns"):
            kernels.sway.misfits(picture, pixels, some, 30, found)
    for far, place in ((-(2**31), (4, 4)), (2**31 - 1, (55, 75))):  # all shifts stay inside
        here, at_border = np.full((3, count), 99, np.int32), np.empty((4, count))
        here[:2] = np.array(place)[:, None]
        kernels.sway.misfits(rgb, here, shifts, 30, at_border)
        here[:2] = far
        kernels.sway.misfits(rgb, here, shifts, 30, found)
        np.testing.assert_array_equal(found, at_border)


def test_what_is_kept_of_the_background() -> None:
    rng, size = np.random.default_rng(0), (6, 50)
    since, clean = rng.uniform(0, 9, size), random_planes(size, 1)
    now, mask, known = random_planes(size), random_mask(size), random_mask(size, seed=1)
    held = (mask > 0) & (10 - since < np.where(known, 7.0, 3.0))
    expected = np.where(held, clean, now), np.where(mask, since, 10)
    kernels.selective_update.update(now, mask, known, 10.0, HoldLimits(3.0, 7.0), since, clean)
    np.testing.assert_array_equal(clean, expected[0])
    np.testing.assert_array_equal(since, expected[1])


def divided(patch: Mask, spike: int, valley: float, narrow: int) -> list[int]:
    """Return the columns of the valleys, step by step."""
    heights = np.where(patch.any(axis=0), len(patch) - patch.argmax(axis=0), 0)
    heights = scipy.ndimage.grey_opening(heights, spike, mode="nearest")
    cuts, parts = list[int](), [(0, len(heights))]
    while parts:
        left, right = parts.pop()
        own = heights[left:right]
        lower = np.minimum(np.maximum.accumulate(own), np.maximum.accumulate(own[::-1])[::-1])
        depth = 1 - own / np.maximum(lower, 1)
        depth[:narrow], depth[len(depth) - narrow :] = 0, 0
        if len(own) < 2 * narrow or depth.max() <= valley:
            continue
        deepest = np.flatnonzero(depth == depth.max())
        deepest = deepest[deepest - deepest[0] == np.arange(len(deepest))]  # of one valley
        cut = left + int(deepest[len(deepest) // 2])
        cuts.append(cut)
        parts += [(left, cut), (cut, right)]
    return sorted(cuts)


def test_valleys() -> None:
    rng, cuts = np.random.default_rng(0), 0
    for _ in range(100):
        width = int(rng.integers(1, 60))
        tops = scipy.ndimage.uniform_filter1d(rng.integers(0, 40, width), 4)
        patch = (np.arange(40)[:, None] >= tops).astype(np.uint8)
        spike, narrow = int(rng.choice([1, 3, 5])), int(rng.integers(1, 8))
        patch &= rng.random(patch.shape) < 0.9
        found = kernels.outlines.divided(patch, spike, 0.1, narrow)
        ends = [0, *divided(patch, spike, 0.1, narrow), width]
        for left, right, part in zip(ends[:-1], ends[1:], found.tolist(), strict=True):
            y, x = np.nonzero(patch[:, left:right])
            box = left + x.min(), y.min(), np.ptp(x) + 1, np.ptp(y) + 1
            assert part == [*box, len(x)]
        cuts += len(found) - 1
    assert cuts > 50


def film(size: tuple[int, int]) -> list[Planes]:
    """Return pictures of a ground that flickers between two colors, with noise and a block."""
    rng, pictures = np.random.default_rng(0), []
    ground = rng.integers(0, 256, (3, *size))
    for index in range(40):
        planes = ground + rng.normal(0, 3, ground.shape)
        planes[:, :, : size[1] // 2] += 60 * rng.integers(0, 2, (size[0], size[1] // 2))
        planes[:, 2:9, index : index + 8] = 200
        pictures.append(np.clip(planes, 0, 255).astype(np.uint8))
    return pictures


@NEEDS_CV2
@pytest.mark.parametrize("rate", [0.02, 0.3])
def test_a_mixture_is_that_of_opencv(rate: float) -> None:
    """But for rounding: OpenCV scales the weights also where it learns nothing."""
    import cv2

    pictures = film((30, 100))
    mixture, other = Mixture(4.0), cv2.createBackgroundSubtractorMOG2(500, 16.0, False)
    mixture.begin(pictures[0])
    for _ in range(5):
        other.apply(picture_of(pictures[0]))
    shares = []
    for planes in pictures[1:]:
        mask = mixture.foreground(planes)
        expected = other.apply(picture_of(planes), learningRate=0) > 0
        assert (mask != expected).mean() < 0.003
        shares.append(mask.mean())
        mixture.learn(planes, rate)
        other.apply(picture_of(planes), learningRate=rate)
        means = np.asarray(other.getBackgroundImage(), np.uint8)
        apart = planes_of(means).astype(int) - mixture.picture()
        assert (np.abs(apart) > 1).mean() < 0.01
    assert shares[0] > 0.2 > shares[-1] > 0.01
    weights = mixture._model[:, ::4, : kernels.mixture.PART]
    np.testing.assert_allclose(weights.sum(axis=0), 1, atol=0.02)
    assert (np.diff(weights, axis=0) <= 0).all()
    assert (weights > 0).sum(axis=0).max() > 2


def bytes_of(*shape: int) -> NDArray[np.uint8]:
    """Return zeros."""
    return np.zeros(shape, np.uint8)


MODEL = 5, 4 * 2, 5 * 32  # of 4 x 64 pixels
LEARNING = MixtureLearning(0.3, 0.05, 9.0, 15.0, 4.0, 75.0)
LIMITS = LightLimits(0.5, 1.5, 10.0, 3.0)
FITTING: dict[str, tuple[Any, ...]] = {
    "components.label": (bytes_of(4, 64), np.zeros((4, 64), np.int32)),
    "components.fill_holes": (bytes_of(4, 64), bytes_of(4, 64), bytes_of(4, 64)),
    "ghosts.outline_gradients": (
        bytes_of(4, 64), bytes_of(4, 64, 3), bytes_of(4, 64), np.zeros((2, 4), np.int64),
        np.zeros((2, 2)),
    ),
    "illumination.without_light": (
        bytes_of(4, 64), np.zeros((3, 4, 64), np.uint16), np.zeros((3, 4, 64), np.uint16), LIMITS,
        bytes_of(4, 64),
    ),
    "illumination.without_tremble": (
        bytes_of(4, 64), bytes_of(3, 4, 64), bytes_of(3, 4, 64), bytes_of(3, 4, 64),
        bytes_of(4, 64),
    ),
    "mixture.foreground": (
        np.zeros(MODEL, np.float32), bytes_of(3, 4, 64), 0.9, 16.0, bytes_of(4, 64)
    ),
    "mixture.learn": (np.zeros(MODEL, np.float32), bytes_of(3, 4, 64), LEARNING),
    "mixture.means": (np.ones(MODEL, np.float32), 0.9, bytes_of(3, 4, 64)),
    "planes.expose": (bytes_of(4, 64, 3), bytes_of(3, 256), bytes_of(3, 4, 64)),
    "planes.relight": (bytes_of(4, 64, 3), 1.3, bytes_of(4, 64, 3)),
    "planes.window_sums": (bytes_of(3, 4, 64), np.zeros((3, 4, 64), np.uint16)),
    "selective_update.update": (
        bytes_of(3, 4, 64), bytes_of(4, 64), bytes_of(4, 64), 1.0, HoldLimits(1.0, 2.0),
        np.zeros((4, 64)), bytes_of(3, 4, 64),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", FITTING)
def test_arrays_of_other_sizes_are_refused(name: str) -> None:
    """One of them at a time is longer by one, in each of its axes."""
    kernel, arguments = attrgetter(name)(kernels), FITTING[name]
    kernel(*arguments)
    for place, value in enumerate(arguments):
        for axis in range(np.ndim(value) if isinstance(value, np.ndarray) else 0):
            longer = np.repeat(value, np.eye(value.shape[axis], dtype=int)[0] + 1, axis=axis)
            with pytest.raises((ValueError, TypeError), match=r"needs|must be"):
                kernel(*arguments[:place], longer, *arguments[place + 1 :])


@pytest.mark.parametrize("sums", [(2, 8), (1, 9)])
@pytest.mark.parametrize("block", [0, 4])
def test_blocks_that_do_not_lie_in_the_picture_are_refused(
    sums: tuple[int, int], block: int
) -> None:
    """In 7 x 35 pixels, and every second one of 13 x 69, there is a row of 8 blocks of 4 x 4."""
    picture = bytes_of(7, 35, 3)
    with pytest.raises(ValueError, match="blocks that lie in the picture"):
        kernels.planes.green_means(picture, block, np.zeros(sums, np.float32))
    picture = bytes_of(13, 69, 3)
    with pytest.raises(ValueError, match="blocks that lie in the picture"):
        kernels.cuts.look(picture, 2, block, np.zeros(512), np.zeros(sums))
    with pytest.raises(ValueError, match="512 colors"):
        kernels.cuts.look(picture, 2, 4, np.zeros(511), np.zeros((1, 8)))
