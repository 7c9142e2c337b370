"""Plain second implementations, slow and obvious, and small scenes to track in."""

import math
from collections.abc import Sequence
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import strategies as st
from numpy.typing import NDArray
from PIL import Image

from motes.core.frame import FRAME_INTERVAL, Frame
from motes.core.geometry import Ellipse
from motes.cues.sampling import Checkerboard, EveryPixel, Sampling

Floats = NDArray[np.float64]
Pixels = NDArray[np.uint8]
Bins = tuple[int, int, int]

SHARES: dict[str, Sampling] = {
    "all": EveryPixel(),
    "half": Checkerboard(share="half"),
    "quarter": Checkerboard(share="quarter"),
}
"""Samplings of pixels, by the shares of a `checkerboard`."""


@cache
def bin_of(r: int, g: int, b: int, space: str, bins: Bins) -> int:
    """Return a color's bin in exact arithmetic; a channel's bins are equally wide."""
    high = max(r, g, b)
    if space == "rgb":
        parts = [Fraction(r, 256), Fraction(g, 256), Fraction(b, 256)]
    else:
        low = min(r, g, b)
        if high == low:
            hue = saturation = Fraction(0)
        else:
            # As colorsys does it, with fractions.
            saturation = Fraction(high - low, high)
            rc, gc, bc = (Fraction(high - c, high - low) for c in (r, g, b))
            if r == high:
                hue = bc - gc
            elif g == high:
                hue = 2 + rc - bc
            else:
                hue = 4 + gc - rc
            hue = (hue / 6) % 1
        parts = [hue, saturation, Fraction(high, 256)]
    indices = [min(int(part * n), n - 1) for part, n in zip(parts, bins, strict=True)]
    if space == "hsv+v":
        colored = parts[1] > Fraction(1, 10) and Fraction(high, 255) > Fraction(2, 10)
        pair = indices[0] * bins[1] + indices[1]
        return pair if colored else bins[0] * bins[1] + indices[2]
    return (indices[0] * bins[1] + indices[1]) * bins[2] + indices[2]


def size(space: str, bins: Bins) -> int:
    """Return how many bins there are."""
    return bins[0] * bins[1] + bins[2] if space == "hsv+v" else math.prod(bins)


def bin_image(pixels: Pixels, space: str, bins: Bins) -> NDArray[np.int64]:
    """Return every pixel's bin, (H, W)."""
    return np.array([[bin_of(*map(int, c), space, bins) for c in row] for row in pixels])


def radii(shape: Sequence[int], ellipse: Sequence[float]) -> tuple[Floats, Floats]:
    """Return each pixel's distance from the center, and the same in the ellipse's own half-axes.

    The second is Mahalanobis': the ellipse is where (p - c)^T M (p - c) < 1.
    """
    x, y, a, b, theta = ellipse
    turn = np.array([[math.cos(theta), -math.sin(theta)], [math.sin(theta), math.cos(theta)]])
    form = turn @ np.diag([a**-2, b**-2]) @ turn.T
    rows, columns = np.mgrid[: shape[0], : shape[1]]
    off = np.stack([columns - x, rows - y], axis=-1)
    inner = np.einsum("hwi,ij,hwj->hw", off, form, off)
    return np.hypot(off[..., 0], off[..., 1]), np.sqrt(np.maximum(inner, 0))


def on_a_border(shape: Sequence[int], ellipse: Sequence[float]) -> bool:
    """Tell whether a pixel lies so near the ellipse that rounding decides whether it counts."""
    return bool((np.abs(radii(shape, ellipse)[1] - 1) < 1e-9).any())


def kernel(r: Floats) -> Floats:
    """Equation 2."""
    return np.where(r < 1, 1 - r**2, 0.0)


def weighted(profile: str, ellipse: Sequence[float], distance: Floats, own: Floats) -> Floats:
    """Return the weights of pixels inside an ellipse, by their `radii`."""
    if profile == "uniform":
        return np.ones_like(own)
    if profile == "gaussian":
        return np.exp(-(own**2) / 2)
    return kernel(distance / math.hypot(ellipse[2], ellipse[3]) if profile == "radial" else own)


def checkerboard(shape: Sequence[int], share: str) -> Floats:
    """Return 1 for each pixel that is read, else 0: `all`, or as in Ng and Delp, figure 2."""
    board = np.zeros(shape[:2])
    for row in range(shape[0]):
        for column in range(shape[1]):
            if share == "half":
                board[row, column] = (row + column) % 2 == 0
            elif share == "quarter":
                board[row, column] = row % 2 == 0 and column % 2 == 0
            else:
                board[row, column] = 1
    return board


def every_pixel(
    pixels: Pixels,
    ellipse: Sequence[float],
    space: str,
    bins: Bins,
    profile: str,
    share: str = "all",
) -> Floats:
    """Equations 3 and 4 over every pixel of the ellipse, or a part; zeros where there is none."""
    distance, own = radii(pixels.shape, ellipse)
    weights = weighted(profile, ellipse, distance, own) * (own < 1)
    weights *= checkerboard(pixels.shape, share)
    return _normalized(weights.ravel(), bin_image(pixels, space, bins).ravel(), size(space, bins))


def lattice_places(ellipse: Sequence[float], lattice: NDArray[np.float32]) -> tuple[Floats, Floats]:
    """Return the points (n, 2) that a lattice has in an ellipse, and their offsets."""
    x, y, a, b, theta = ellipse
    turn = np.array([[math.cos(theta), -math.sin(theta)], [math.sin(theta), math.cos(theta)]])
    offsets = (lattice.T.astype(float) * [a, b]) @ turn.T
    return offsets + np.array([x, y]), offsets


def between_pixels(ellipse: Sequence[float], lattice: NDArray[np.float32]) -> bool:
    """Tell whether a lattice point lies so near two pixels that single precision decides."""
    places = lattice_places(ellipse, lattice)[0] + 0.5
    return bool((np.abs(places - np.rint(places)) < 1e-4).any())


def on_lattice(
    pixels: Pixels,
    ellipse: Sequence[float],
    lattice: NDArray[np.float32],
    space: str,
    bins: Bins,
    profile: str,
) -> Floats:
    """Equations 3 and 4 over a lattice's points; each reads the pixel whose square it lies in."""
    points, offsets = lattice_places(ellipse, lattice)
    weights = weighted(profile, ellipse, np.hypot(*offsets.T), np.hypot(*lattice.astype(float)))
    nearest = np.floor(points + 0.5)
    inside = ((nearest >= 0) & (nearest < [pixels.shape[1], pixels.shape[0]])).all(axis=1)
    columns, rows = nearest[inside].astype(int).T
    numbers = np.array(
        [bin_of(*map(int, pixels[r, c]), space, bins) for r, c in zip(rows, columns, strict=True)],
        np.int64,
    )
    return _normalized(weights[inside], numbers, size(space, bins))


def _normalized(weights: Floats, numbers: NDArray[np.int64], size: int) -> Floats:
    histogram = np.zeros(size)
    np.add.at(histogram, numbers, weights)
    total = histogram.sum()
    return histogram / total if total > 0 else histogram


def gray_blocks(pixels: Pixels, step: int, margin: int = 0) -> Floats:
    """Return the mean luma of blocks of pixels, and of `margin` blocks more on each side.

    Past the border of the picture its pixels repeat, also within the last blocks.
    """
    luma = pixels.astype(np.float64) @ [77 / 256, 150 / 256, 29 / 256]
    more = [(margin * step, -length % step + margin * step) for length in luma.shape]
    padded = np.pad(luma, more, mode="edge")
    rows, columns = padded.shape[0] // step, padded.shape[1] // step
    means: Floats = padded.reshape(rows, step, columns, step).mean(axis=(1, 3))
    return means


def filtered(image: Floats, across: Floats, down: Floats) -> Floats:
    """Return the sums of image[y + i, x + j] down[i] across[j] where all of these are there."""
    rows = np.array([np.convolve(row, across[::-1], "valid") for row in image])
    return np.array([np.convolve(column, down[::-1], "valid") for column in rows.T]).T


def structure_tensor(
    pixels: Pixels, step: int, smooth: Floats, derivative: Floats, window: Floats
) -> Floats:
    """Maggio et al., equation 3, for every block of a picture: (H, W, 2, 2).

    Filters are given by their taps at 0 … r, the derivative's to the other side being negative.
    """
    even, odd, average = (
        np.concatenate([sign * taps[:0:-1], taps]).astype(np.float64)
        for sign, taps in ((1, smooth), (-1, derivative), (1, window))
    )
    gray = gray_blocks(pixels, step, len(smooth) + len(window) - 2)
    gradient = [filtered(gray, odd, even), filtered(gray, even, odd)]
    parts = [[filtered(u * v, average, average) for v in gradient] for u in gradient]
    return np.moveaxis(np.array(parts), (0, 1), (2, 3))


def edges(tensors: Floats) -> tuple[Floats, Floats]:
    """Return certainty (Maggio et al., equation 4) and orientation (5), in [-pi/2, pi/2)."""
    low, high = np.moveaxis(np.linalg.eigvalsh(tensors), -1, 0)
    vectors = np.linalg.eigh(tensors).eigenvectors[..., :, 1]
    angles = np.arctan2(vectors[..., 1], vectors[..., 0])
    return (high - low) * (high + low), (angles + np.pi / 2) % np.pi - np.pi / 2


def triangle(histogram: Floats, shift: float) -> Floats:
    """Return a circular histogram turned back by `shift` bins and smoothed by a triangle.

    The triangle has height 1/2 at a bin's middle and falls to 0 two bins beside it.
    """
    count = len(histogram)
    off = np.abs(np.arange(count)[:, None] + shift - np.arange(count)) % count
    smoothed: Floats = np.maximum(0, 0.5 - np.minimum(off, count - off) / 4) @ histogram
    return smoothed


def orientation_histogram(
    certainty: Floats,
    numbers: NDArray[np.integer],
    ellipse: Sequence[float],
    lattice: NDArray[np.float32],
    profile: str,
    threshold: float,
    count: int,
) -> Floats:
    """Return the certainties above a threshold by bin, neither smoothed nor turned; sum 1.

    Over a lattice's points or, if there are none, every place; zeros where nothing is left.
    """
    if lattice.size:
        points, offsets = lattice_places(ellipse, lattice)
        weights = weighted(profile, ellipse, np.hypot(*offsets.T), np.hypot(*lattice.astype(float)))
        columns, rows = np.floor(points + 0.5).T
        inside = (rows >= 0) & (columns >= 0)
        inside &= (rows < certainty.shape[0]) & (columns < certainty.shape[1])
        weights = weights[inside]
        at: tuple[Any, ...] = rows[inside].astype(int), columns[inside].astype(int)
    else:
        distance, own = radii(certainty.shape, ellipse)
        at = np.nonzero(own < 1)
        weights = weighted(profile, ellipse, distance, own)[at]
    strong = certainty[at] * (certainty[at] > threshold)
    histogram = np.zeros(count)
    np.add.at(histogram, numbers[at], weights * strong)
    return histogram / histogram.sum() if histogram.sum() > 0 else histogram


def sobel(pixels: Pixels) -> tuple[Floats, Floats]:
    """Return strength and orientation of each pixel's edge: Ng and Delp, equations 10 to 13.

    Past the border of the image its pixels repeat. Orientations are in [-pi/2, pi/2).
    """
    kx = ((-1, 0, 1), (-2, 0, 2), (-1, 0, 1))
    ky = ((-1, -2, -1), (0, 0, 0), (1, 2, 1))
    height, width = pixels.shape[:2]
    strength, angle = np.zeros((height, width)), np.zeros((height, width))
    for y in range(height):
        for x in range(width):
            gx = gy = 0.0
            for i in range(3):
                for j in range(3):
                    row = min(max(y + i - 1, 0), height - 1)
                    column = min(max(x + j - 1, 0), width - 1)
                    r, g, b = map(int, pixels[row, column])
                    gray = (77 * r + 150 * g + 29 * b) / 256
                    gx += kx[i][j] * gray
                    gy += ky[i][j] * gray
            strength[y, x] = math.sqrt(gx**2 + gy**2)
            angle[y, x] = math.atan(gy / gx) if gx != 0 else -math.pi / 2
    return strength, angle


def smooth_gradient(pixels: Pixels, y: int, x: int) -> tuple[float, float]:
    """Return the gradient of a pixel's gray values, smoothed by (1, 6, 1) / 8 both ways.

    Past the border of the image its pixels repeat.
    """
    height, width = pixels.shape[:2]

    def gray(row: int, column: int) -> float:
        r, g, b = map(int, pixels[min(max(row, 0), height - 1), min(max(column, 0), width - 1)])
        return (77 * r + 150 * g + 29 * b) / 256

    taps = {-1: 1 / 8, 0: 6 / 8, 1: 1 / 8}

    def smooth(row: int, column: int) -> float:
        return sum(
            p * q * gray(row + i, column + j) for i, p in taps.items() for j, q in taps.items()
        )

    return ((smooth(y, x + 1) - smooth(y, x - 1)) / 2, (smooth(y + 1, x) - smooth(y - 1, x)) / 2)


def edge_bins(strength: Floats, angle: Floats, threshold: float, count: int) -> NDArray[np.int64]:
    """Return each pixel's bin (H, W), the first one centered on -pi/2; -1 for no strong edge."""
    places = np.floor((angle + math.pi / 2) / math.pi * count + 0.5).astype(np.int64) % count
    return np.where(strength > threshold, places, -1)


def bhattacharyya(p: Floats, q: Floats) -> float:
    """Equation 7."""
    return math.sqrt(max(0.0, 1 - sum(math.sqrt(u * v) for u, v in zip(p, q, strict=True))))


def moments(weights: Floats, ellipses: Floats) -> tuple[Floats, Floats]:
    """Return mean (5,) and covariance (5, 5) of ellipses, one at a time; angles modulo pi."""
    weights = weights / weights.sum()
    doubled = sum(w * np.exp(2j * row[4]) for w, row in zip(weights, ellipses, strict=True))
    mean = np.array([*(weights @ ellipses[:, :4]), np.angle(doubled) / 2])
    found = np.zeros((5, 5))
    for w, row in zip(weights, ellipses, strict=True):
        off = row - mean
        off[4] = (off[4] + np.pi / 2) % np.pi - np.pi / 2
        found += w * np.outer(off, off)
    return mean, found


def mosaic(seed: int, height: int, width: int, colors: int = 24) -> Pixels:
    """Return an image of a few random colors, with the corners of the color cube among them."""
    rng = np.random.default_rng(seed)
    palette = rng.integers(0, 256, (colors, 3), np.uint8)
    palette[:8] = np.array(np.meshgrid([0, 255], [0, 255], [0, 255])).reshape(3, 8).T
    return palette[rng.integers(0, colors, (height, width))]


def frame(pixels: Pixels, index: int = 0) -> Frame:
    """Return an image as a frame of a film of 25 frames a second."""
    return Frame(index, index * FRAME_INTERVAL, pixels)


def edge(slope: tuple[float, float], contrast: float = 60) -> Frame:
    """Return a picture, 60 on one side of a straight edge through its middle, more beyond."""
    y, x = np.mgrid[:41, :41] - 20
    gray = np.where(slope[0] * x + slope[1] * y > 0, 60 + contrast, 60).astype(np.uint8)
    return frame(np.repeat(gray[:, :, None], 3, axis=2))


MIDDLE = Ellipse(20, 20, 12, 12)
"""A disk in the middle of a picture of an `edge`."""


def scene(
    index: int,
    center: tuple[float, float] | None,
    size: tuple[int, int] = (96, 72),
    half: tuple[float, float] = (10.0, 7.0),
) -> Frame:
    """Return a gray, noisy street; where there is a center, a red and blue ellipse in it."""
    width, height = size
    rng = np.random.default_rng(index)
    gray = 110 + 12 * np.sin(np.arange(width) / 7) + 12 * np.cos(np.arange(height) / 5)[:, None]
    pixels = np.repeat(gray[:, :, None], 3, axis=2)
    if center is not None:
        own = radii(pixels.shape, (*center, *half, 0.0))[1]
        pixels[own < 1] = (200, 30, 40)
        pixels[own < 0.55] = (30, 50, 190)
    pixels += rng.normal(0, 3, pixels.shape)
    return frame(pixels.clip(0, 255).astype(np.uint8), index)


def region(center: tuple[float, float], half: tuple[float, float] = (10.0, 7.0)) -> Ellipse:
    """Return the target's ellipse in a `scene`."""
    return Ellipse(*center, *half)


def sequence(folder: Path, limit: int | None = None) -> tuple[list[Frame], Floats]:
    """Return a real sequence's frames and true boxes (x, y, w, h), counted from 0."""
    text = (folder / "groundtruth_rect.txt").read_text().replace(",", " ").split()
    boxes = np.array(text, np.float64).reshape(-1, 4)[:limit] - [1, 1, 0, 0]
    paths = sorted((folder / "img").glob("*.jpg"))[: len(boxes)]
    frames = [
        frame(np.array(Image.open(path).convert("RGB")), index) for index, path in enumerate(paths)
    ]
    return frames, boxes


pictures = st.builds(mosaic, st.integers(0, 99), st.integers(1, 16), st.integers(1, 16))
regions = st.builds(
    Ellipse,
    *(st.floats(-6, 22), st.floats(-6, 22), st.floats(0.3, 30), st.floats(0.3, 30)),
    st.floats(-4, 4),
)
extents = st.floats(0.3, 12) | st.floats(12, 400)
wide_regions = st.builds(
    Ellipse, st.floats(-15, 40), st.floats(-15, 40), extents, extents, st.floats(-4, 4)
)
"""From a part of a pixel to far larger than the picture."""


def rows(*ellipses: Ellipse) -> NDArray[np.float64]:
    """Return ellipses as an array (n, 5)."""
    return np.array(ellipses, np.float64)
