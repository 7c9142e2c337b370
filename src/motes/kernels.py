"""Every compiled loop, and nothing else; imports numpy and numba only.

One file, though a long one: numba keeps a compiled kernel until the kernel's own file changes, and
would not see a change in another file that it calls.

Kernels that read pixels release the GIL; all allocate nothing inside loops and know no Python
objects. An ellipse is a row x, y, a, b, theta. Color spaces are numbered (`RGB`, `HSV`, `HSV_V`);
a pixel's bin is (i0 * n1 + i1) * n2 + i2 for bins n0 x n1 x n2, equally wide in each channel, or in
`HSV_V` i0 * n1 + i1 of n0 x n1 for a pixel with color and n0 * n1 + i2 for one without. `slots`
maps each of these bins to a place in a histogram that holds only the bins wanted, its last place
taking all others.

An ellipse's pixels are read at the points of `lattice`, (2, n) in the unit disk; where it is empty,
those are read whose row and column add up to a multiple of the first number of `grid`, and whose
row is a multiple of the second: 1, 1 is every pixel.
"""

from __future__ import annotations

import functools
import math
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

F = TypeVar("F", bound=Callable[..., object])


def _use_cache() -> bool:
    """Point numba at a writable cache folder; False where there is none (a read-only system)."""
    if "NUMBA_CACHE_DIR" not in os.environ:
        try:
            home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
            folder = home / "motes" / "numba"
            folder.mkdir(parents=True, exist_ok=True)
        except (OSError, RuntimeError):
            return False
        if not os.access(folder, os.W_OK):
            return False
        os.environ["NUMBA_CACHE_DIR"] = str(folder)
    return True


CACHED = _use_cache()
"""Whether compiled kernels are kept on disk for the next run."""

import numba  # noqa: E402  (reads NUMBA_CACHE_DIR when imported)
from numba.core import event  # noqa: E402


def _kernel(function: F) -> F:
    """Compile a loop on first use, without the GIL, kept on disk where possible."""
    return cast(F, numba.njit(nogil=True, cache=CACHED, error_model="numpy")(function))


def _brief(function: F) -> F:
    """Compile a loop of microseconds, for which handing over the GIL would take longer."""
    return cast(F, numba.njit(cache=CACHED, error_model="numpy")(function))


def _unordered(function: F) -> F:
    """Compile a loop whose sums may be added up in any order, as vector code does."""
    options: Any = {"nogil": True, "cache": CACHED, "error_model": "numpy"}
    return cast(F, numba.njit(fastmath={"reassoc", "contract"}, **options)(function))


RGB, HSV, HSV_V = 0, 1, 2
EPANECHNIKOV, RADIAL, UNIFORM, GAUSSIAN = 0, 1, 2, 3
LANES = 4
BAND = 32


@_brief
def walk(
    states: NDArray[np.float64],
    normal: NDArray[np.float64],
    deviations: NDArray[np.float64],
    steps: float,
    kept: float,
    a: float,
    b: float,
    kept_size: float,
    size_deviation: float,
    out: NDArray[np.float64],
) -> None:
    """Write the states (N, 5 + 4k) that follow: x, y, a, b, theta and k orders of their changes.

    A column takes its normal number times its deviation, and `steps` times the new value of its
    change. Of a change the share `kept` is left; half-axes keep `kept_size` of their distance, in
    logarithms, to the first ones `a` and `b`, and are then scaled by a common factor, whose
    logarithm is the last normal number times `size_deviation`. They stay at one pixel or more.
    """
    columns = states.shape[1]
    for n in range(states.shape[0]):
        for i in range(columns - 1, 4, -1):
            out[n, i] = kept * states[n, i] + deviations[i] * normal[n, i]
            if i + 4 < columns:
                out[n, i] += steps * out[n, i + 4]
        for i in range(5):
            out[n, i] = states[n, i] + deviations[i] * normal[n, i]
            if i < 4 and columns > 5:
                out[n, i] += steps * out[n, i + 5]
        growth = size_deviation * normal[n, columns]
        out[n, 2] = max(a * math.exp(kept_size * math.log(max(out[n, 2], 1.0) / a) + growth), 1.0)
        out[n, 3] = max(b * math.exp(kept_size * math.log(max(out[n, 3], 1.0) / b) + growth), 1.0)


@_brief
def ancestors(
    weights: NDArray[np.float64], positions: NDArray[np.float64], chosen: NDArray[np.intp]
) -> None:
    """Write, for each position from 0 to 1, the first particle whose cumulated weight exceeds it.

    Positions are shares of the sum of weights; a particle without weight is never chosen, if any
    has one.
    """
    cumulated = np.empty(weights.shape[0])
    total, last = 0.0, 0
    for n in range(weights.shape[0]):
        total += weights[n]
        cumulated[n] = total
        if weights[n] > 0.0:
            last = n
    for i in range(positions.shape[0]):
        position = positions[i] * total
        low, high = 0, last  # rounding may lift the largest position onto the last sum
        while low < high:
            middle = (low + high) >> 1
            if cumulated[middle] > position:
                high = middle
            else:
                low = middle + 1
        chosen[i] = low


@_brief
def gaussian(
    distances: NDArray[np.float64],
    sigmas: NDArray[np.float64],
    epsilon: float,
    logs: NDArray[np.float64],
) -> None:
    """Write log(exp(-d² / (2 sigma²)) + epsilon) of distances (J, N) and sigmas (J,)."""
    for j in range(distances.shape[0]):
        scale = -0.5 / (sigmas[j] * sigmas[j])
        for n in range(distances.shape[1]):
            log = scale * distances[j, n] * distances[j, n]
            logs[j, n] = math.log(math.exp(log) + epsilon) if epsilon > 0.0 else log


@_brief
def normalize(logs: NDArray[np.float64], values: NDArray[np.float64]) -> bool:
    """Write probabilities for log-weights, whose NaN and +inf become -inf; True if none has any.

    They are then uniform.
    """
    top = -np.inf
    for n in range(logs.shape[0]):
        if not logs[n] < np.inf:
            logs[n] = -np.inf
        top = max(top, logs[n])
    if top == -np.inf:
        values[:] = 1.0 / logs.shape[0]
        return True
    total = 0.0
    for n in range(logs.shape[0]):
        values[n] = math.exp(logs[n] - top)
        total += values[n]
    for n in range(logs.shape[0]):
        values[n] /= total
    return False


@_brief
def combine(
    distances: NDArray[np.float64], shares: NDArray[np.float64], out: NDArray[np.float64]
) -> None:
    """Write the root of the mean of the squared distances (J, N) of cues by their shares (J,)."""
    out[:] = 0.0
    for j in range(distances.shape[0]):
        for n in range(distances.shape[1]):
            out[n] += shares[j] * distances[j, n] * distances[j, n]
    for n in range(out.shape[0]):
        out[n] = math.sqrt(out[n])


@_brief
def appearing(
    distances: NDArray[np.float64], weights: NDArray[np.float64], threshold: float
) -> tuple[int, float]:
    """Return how many particles have a rho, 1 - d², above a threshold, and the sum of weights."""
    count, support = 0, 0.0
    for n in range(distances.shape[0]):
        if 1.0 - distances[n] * distances[n] > threshold:
            count += 1
            support += weights[n]
    return count, support


@_kernel
def _capacity(
    window: tuple[int, int, int, int],
    ellipses: NDArray[np.float64],
    lattice: NDArray[np.float32],
) -> int:
    """Return for how many points of an ellipse room is needed."""
    if lattice.shape[1] > 0:
        return int(lattice.shape[1])
    most = 0.0
    for n in range(ellipses.shape[0]):
        side = 2 * max(ellipses[n, 2], ellipses[n, 3]) + 2
        area = min(side, float(window[2])) * min(side, float(window[3]))
        most = area if area > most else most  # NaN is not
    return int(most) + 1


@_kernel
def _bell(weights: NDArray[np.float64]) -> None:
    """Replace 1 - r² from 0 to 1 by exp(-r² / 2), as a series right to 1e-11: vector code."""
    for i in range(weights.shape[0]):
        t = 0.5 * (weights[i] - 1.0)
        tail = 1.0 + t / 6 * (1.0 + t / 7 * (1.0 + t / 8 * (1.0 + t / 9 * (1.0 + t / 10))))
        weights[i] = 1.0 + t * (1.0 + t / 2 * (1.0 + t / 3 * (1.0 + t / 4 * (1.0 + t / 5 * tail))))


@_kernel
def _points(
    window: tuple[int, int, int, int],
    ellipse: NDArray[np.float64],
    lattice: NDArray[np.float32],
    grid: tuple[int, int],
    profile: int,
    channels: int,
    offsets: NDArray[np.uint32],
    weights: NDArray[np.float64],
) -> int:
    """Write the pixels of an ellipse that are read, and their kernel weights; return how many.

    A pixel is its place in the flat `window` (left, top, width, height) of an image. Lattice points
    outside weigh nothing. Coordinates are the image's, whatever the window, down to rounding.
    """
    left, top, width, height = window
    x, y, a, b, theta = ellipse[0], ellipse[1], ellipse[2], ellipse[3], ellipse[4]
    cos, sin = math.cos(theta), math.sin(theta)
    across = math.sqrt(a * a * cos * cos + b * b * sin * sin)
    down = math.sqrt(a * a * sin * sin + b * b * cos * cos)
    # 1 - r² with r over the bandwidth sqrt(a² + b²), or over the ellipse itself; or 1 everywhere.
    # A bell is made of the second.
    uu, vv = (0.0, 0.0) if profile == UNIFORM else (1.0, 1.0)
    if profile == RADIAL:
        uu, vv = a * a / (a * a + b * b), b * b / (a * a + b * b)
    right, bottom = left + width, top + height
    if not math.isfinite(x + y + across + down):
        return 0
    if x + across < left - 1 or y + down < top - 1 or x - across > right or y - down > bottom:
        return 0
    if lattice.shape[1] > 0:
        ax, ay = np.float32(a * cos), np.float32(a * sin)
        bx, by = np.float32(-b * sin), np.float32(b * cos)
        # Places are counted from the ellipse's own corner, whole numbers taken off: so they are
        # positive and small, and single precision is right to 1e-4 pixels in an ellipse of 1,000.
        corner_x, corner_y = math.floor(x + 0.5 - across), math.floor(y + 0.5 - down)
        x0, y0 = np.float32(x + 0.5 - corner_x), np.float32(y + 0.5 - corner_y)
        column, row = corner_x - left, corner_y - top
        corner = np.int32(channels * (row * width + column))
        pixel, line = np.int32(channels), np.int32(channels * width)
        us, vs, one = lattice[0], lattice[1], np.float32(1)
        du, dv = np.float32(uu), np.float32(vv)
        for i in range(us.shape[0]):  # without branches, so that it becomes vector code
            u, v = us[i], vs[i]
            px, py = np.int32(x0 + u * ax + v * bx), np.int32(y0 + u * ay + v * by)
            place = np.int32(py * line) + np.int32(px * pixel)
            offsets[i] = np.int32(corner + np.int32(place))
            weights[i] = one - (u * u * du + v * v * dv)
        if profile == GAUSSIAN:
            _bell(weights)
        if (
            x - across < left or y - down < top or x + across + 1 >= right or y + down + 1 >= bottom
        ):  # fmt: skip
            for i in range(us.shape[0]):
                u, v = us[i], vs[i]
                at_x = column + int(np.int32(x0 + u * ax + v * bx))
                at_y = row + int(np.int32(y0 + u * ay + v * by))
                if at_x < 0 or at_y < 0 or at_x >= width or at_y >= height:
                    offsets[i], weights[i] = np.uint32(0), 0.0
                else:  # again: an absurdly large ellipse may have overflowed above, and elsewhere
                    offsets[i] = np.uint32(channels * (at_y * width + at_x))
        return int(lattice.shape[1])
    first = max(left, math.ceil(x - across))
    last = min(left + width - 1, math.floor(x + across))
    above = max(top, math.ceil(y - down))
    below = min(top + height - 1, math.floor(y + down))
    across, down = grid
    count = 0
    for row in range(above + -above % down, below + 1, down):
        for column in range(first + -(row + first) % across, last + 1, across):
            u = ((column - x) * cos + (row - y) * sin) / a
            v = ((row - y) * cos - (column - x) * sin) / b
            if u * u + v * v < 1.0:
                offsets[count] = channels * ((row - top) * width + column - left)
                weights[count] = 1.0 - (u * u * uu + v * v * vv)
                count += 1
    if profile == GAUSSIAN:
        _bell(weights[:count])
    return count


@_kernel
def _colors(
    flat: NDArray[np.uint8], offsets: NDArray[np.uint32], count: int, colors: NDArray[np.uint32]
) -> None:
    """Write the colors at places in the flat image, each as r + 256 g + 65536 b."""
    for i in range(count):
        offset = offsets[i]
        colors[i] = (
            np.uint32(flat[offset])
            | (np.uint32(flat[offset + np.uint32(1)]) << np.uint32(8))
            | (np.uint32(flat[offset + np.uint32(2)]) << np.uint32(16))
        )


@_kernel
def _color_bins(
    colors: NDArray[np.uint32], count: int, space: int, n0: int, n1: int, n2: int
) -> None:
    """Replace colors, as `_colors` writes them, by their bins; without branches: vector code.

    In HSV, channels run from 0 to 1, gray has hue 0. Hue and saturation are fractions of small
    integers, whose quotient in single precision is never rounded onto or over the next integer:
    bins are exact. A pixel has color in `HSV_V` where saturation is above 0.1 and value above 0.2.
    """
    m0, m1, m2 = np.uint32(n0), np.uint32(n1), np.uint32(n2)
    byte, eight = np.uint32(255), np.uint32(8)
    if space == RGB:
        for i in range(count):
            color = colors[i]
            i0 = ((color & byte) * m0) >> eight
            i1 = (((color >> eight) & byte) * m1) >> eight
            colors[i] = (i0 * m1 + i1) * m2 + (((color >> np.uint32(16)) * m2) >> eight)
        return
    f0, f1, six = np.float32(n0), np.float32(n1), np.float32(6)
    apart, pairs = space == HSV_V, m0 * m1
    for i in range(count):
        color = colors[i]
        r = np.float32(np.int32(color & byte))
        g = np.float32(np.int32((color >> eight) & byte))
        b = np.float32(np.int32(color >> np.uint32(16)))
        high = max(r, max(g, b))
        spread = high - min(r, min(g, b))
        # Six times the hue, times the spread.
        hue = np.float32(4) * spread + r - g
        hue = np.float32(2) * spread + b - r if high == g else hue
        hue = g - b if high == r else hue
        hue = hue + six * spread if hue < np.float32(0) else hue
        gray = spread == np.float32(0)
        i0 = np.uint32(np.int32(hue * f0 / (np.float32(1) if gray else six * spread)))
        i1 = np.uint32(np.int32(spread * f1 / (np.float32(1) if gray else high)))
        i1 = min(i1, m1 - np.uint32(1))
        i2 = (np.uint32(np.int32(high)) * m2) >> eight
        pair = i0 * m1 + i1
        if apart:
            colored = (np.float32(10) * spread > high) & (high > np.float32(51))
            colors[i] = pair if colored else pairs + i2
        else:
            colors[i] = pair * m2 + i2


@_kernel
def _fill(
    keys: NDArray[np.uint32],
    weights: NDArray[np.float64],
    count: int,
    slots: NDArray[Any],
    lanes: NDArray[np.float64],
) -> None:
    """Add each pixel's weight to the slot of its key in a histogram, which is then in lane 0.

    Neighbors often share a slot; adding them in turn to four lanes keeps one addition from waiting
    for the one before.
    """
    lanes[:] = 0.0
    first, second, third, fourth = lanes[0], lanes[1], lanes[2], lanes[3]
    whole = count - count % LANES
    for i in range(0, whole, LANES):
        first[slots[keys[i]]] += weights[i]
        second[slots[keys[i + 1]]] += weights[i + 1]
        third[slots[keys[i + 2]]] += weights[i + 2]
        fourth[slots[keys[i + 3]]] += weights[i + 3]
    for i in range(whole, count):
        first[slots[keys[i]]] += weights[i]
    for slot in range(first.shape[0]):
        first[slot] += second[slot] + third[slot] + fourth[slot]


@_unordered
def _coefficient(roots: NDArray[np.float64], histogram: NDArray[np.float64]) -> float:
    """Return the Bhattacharyya coefficient of a model, by its square roots, with a histogram.

    The histogram is not normalized, and may go on behind the model's last bin; 0 if it is empty.
    """
    rho, total = 0.0, 0.0
    for u in range(roots.shape[0]):
        rho += roots[u] * math.sqrt(histogram[u])
    for u in range(histogram.shape[0]):
        total += histogram[u]
    return rho / math.sqrt(total) if total > 0.0 else 0.0


@_brief
def bhattacharyya(
    histograms: NDArray[np.float64], roots: NDArray[np.float64], distances: NDArray[np.float64]
) -> None:
    """Write the distances sqrt(1 - rho) of histograms (N, m) to a model, by its square roots."""
    for n in range(histograms.shape[0]):
        distances[n] = math.sqrt(max(0.0, 1.0 - _coefficient(roots, histograms[n])))


@_kernel
def color_histograms(
    pixels: NDArray[np.uint8],
    ellipses: NDArray[np.float64],
    lattice: NDArray[np.float32],
    grid: tuple[int, int],
    profile: int,
    slots: NDArray[np.uint32],
    space: int,
    n0: int,
    n1: int,
    n2: int,
    histograms: NDArray[np.float64],
) -> None:
    """Write each ellipse's normalized histogram (equation 3), zeros where it sees no pixel."""
    flat = pixels.reshape(-1)
    window = (0, 0, pixels.shape[1], pixels.shape[0])
    room = _capacity(window, ellipses, lattice)
    offsets, colors = np.empty(room, np.uint32), np.empty(room, np.uint32)
    weights = np.empty(room)
    lanes = np.empty((LANES, histograms.shape[1]))
    for n in range(ellipses.shape[0]):
        count = _points(window, ellipses[n], lattice, grid, profile, 3, offsets, weights)
        _colors(flat, offsets, count, colors)
        _color_bins(colors, count, space, n0, n1, n2)
        _fill(colors, weights, count, slots, lanes)
        total = lanes[0].sum()
        for slot in range(lanes.shape[1]):
            histograms[n, slot] = lanes[0, slot] / total if total > 0.0 else 0.0


@_kernel
def color_distances(
    pixels: NDArray[np.uint8],
    ellipses: NDArray[np.float64],
    lattice: NDArray[np.float32],
    grid: tuple[int, int],
    profile: int,
    slots: NDArray[np.uint32],
    roots: NDArray[np.float64],
    space: int,
    n0: int,
    n1: int,
    n2: int,
    distances: NDArray[np.float64],
) -> None:
    """Write each ellipse's Bhattacharyya distance to a target model (equations 6 and 7).

    `roots` holds the square roots of the model's occupied bins, which alone can add to the sum.
    An ellipse that sees no pixel is at distance 1.
    """
    flat = pixels.reshape(-1)
    window = (0, 0, pixels.shape[1], pixels.shape[0])
    room = _capacity(window, ellipses, lattice)
    offsets, colors = np.empty(room, np.uint32), np.empty(room, np.uint32)
    weights = np.empty(room)
    lanes = np.empty((LANES, roots.shape[0] + 1))
    for n in range(ellipses.shape[0]):
        count = _points(window, ellipses[n], lattice, grid, profile, 3, offsets, weights)
        _colors(flat, offsets, count, colors)
        _color_bins(colors, count, space, n0, n1, n2)
        _fill(colors, weights, count, slots, lanes)
        rho = _coefficient(roots, lanes[0])
        distances[n] = math.sqrt(max(0.0, 1.0 - rho))


@_kernel
def _luma(flat: NDArray[np.uint8], start: int, luma: NDArray[np.uint16]) -> None:
    """Write 256 times the luma at each byte of a row of pixels, as if each were a red one.

    Every third is of use: three times the work in less time, since it is vector code.
    """
    count = luma.shape[0]
    red, green = flat[start : start + count], flat[start + 1 : start + 1 + count]
    blue = flat[start + 2 : start + 2 + count]
    for i in range(count):
        luma[i] = (
            np.uint16(77) * np.uint16(red[i])
            + np.uint16(150) * np.uint16(green[i])
            + np.uint16(29) * np.uint16(blue[i])
        )


@_kernel
def _every_third(values: NDArray[Any], share: Any, before: int, out: NDArray[np.float32]) -> None:
    """Write every third value times `share`, after `before` copies of the first, then the last."""
    inner = out[before : before + (values.shape[0] + 2) // 3]
    for x in range(inner.shape[0]):
        inner[x] = share * np.float32(np.int32(values[3 * x]))
    out[:before] = inner[0]
    out[before + inner.shape[0] :] = inner[inner.shape[0] - 1]


@_kernel
def _gray(
    pixels: NDArray[np.uint8], left: int, top: int, step: int, gray: NDArray[np.float32]
) -> None:
    """Write the mean luma of blocks of step x step pixels; past the border its pixels repeat."""
    height, width = pixels.shape[0], pixels.shape[1]
    flat, across = pixels.reshape(-1), gray.shape[1] * step
    first, last = min(max(left, 0), width - 1), max(min(left + across, width), 1)
    luma = np.empty(3 * (last - first) - 2, np.uint16)
    sums, line = np.empty(luma.shape[0], np.uint32), np.empty(across, np.float32)
    share = np.float32(1.0 / (256 * step * step))
    for row in range(gray.shape[0]):
        sums[:] = np.uint32(0)
        for y in range(top + row * step, top + (row + 1) * step):
            _luma(flat, 3 * (min(max(y, 0), height - 1) * width + first), luma)
            if step > 1:
                for i in range(sums.shape[0]):
                    sums[i] += luma[i]
        if step == 1:
            _every_third(luma, share, first - left, gray[row])
            continue
        _every_third(sums, share, first - left, line)
        for column in range(gray.shape[1]):
            total = np.float32(0)
            for x in range(column * step, (column + 1) * step):
                total += line[x]
            gray[row, column] = total


@_kernel
def _along_rows(
    source: NDArray[np.float32], taps: NDArray[np.float32], sign: float, out: NDArray[np.float32]
) -> None:
    """Write the rows of `source` filtered by taps at 0 … r, at -k `sign` times those at k."""
    r, width = taps.shape[0] - 1, out.shape[1]
    mirrored = np.float32(sign)
    for y in range(out.shape[0]):
        line, middle = out[y], source[y, r : r + width]
        for x in range(width):
            line[x] = taps[0] * middle[x]
        for k in range(1, r + 1):
            tap = taps[k]
            after, before = source[y, r + k : r + k + width], source[y, r - k : r - k + width]
            for x in range(width):
                line[x] += tap * (after[x] + mirrored * before[x])


@_kernel
def _along_columns(
    source: NDArray[np.float32], taps: NDArray[np.float32], sign: float, out: NDArray[np.float32]
) -> None:
    """Write the columns of `source` filtered, as `_along_rows` does with rows."""
    r, width = taps.shape[0] - 1, out.shape[1]
    mirrored = np.float32(sign)
    for y in range(out.shape[0]):
        line, middle = out[y], source[y + r]
        for x in range(width):
            line[x] = taps[0] * middle[x]
        for k in range(1, r + 1):
            tap, after, before = taps[k], source[y + r + k], source[y + r - k]
            for x in range(width):
                line[x] += tap * (after[x] + mirrored * before[x])


@_kernel
def _turn(y: NDArray[np.float32], x: NDArray[np.float32], out: NDArray[np.float32]) -> None:
    """Write the angle of (x, y) as a share of a turn, from 0 at (-1, -0) up to 1 at (-1, 0).

    A polynomial for the arctangent up to 1/8 turn (Abramowitz and Stegun 4.4.49, error under 1.2e-5
    radians) and three reflections, all without branches, so that it becomes vector code.
    """
    for i in range(out.shape[0]):
        across, up = abs(x[i]), abs(y[i])
        most = max(across, up)
        t = min(across, up) / (most if most > 0 else np.float32(1.0))
        s = t * t
        angle = t * (
            np.float32(0.9998660)
            + s * (
                np.float32(-0.3302995)
                + s * (
                    np.float32(0.1801410)
                    + s * (np.float32(-0.0851330) + s * np.float32(0.0208351))
                )
            )
        )  # fmt: skip
        angle *= np.float32(0.5 / np.pi)
        angle = np.float32(0.25) - angle if up > across else angle
        angle = np.float32(0.5) - angle if x[i] < 0 else angle
        out[i] = np.float32(0.5) + (angle if y[i] >= 0 else -angle)


@_kernel
def _gradients(
    pixels: NDArray[np.uint8],
    left: int,
    top: int,
    step: int,
    smooth: NDArray[np.float32],
    derivative: NDArray[np.float32],
    gx: NDArray[np.float32],
    gy: NDArray[np.float32],
) -> None:
    """Write the two derivatives of a region's gray values, in blocks of step x step pixels."""
    height, width = gx.shape
    margin = smooth.shape[0] - 1
    gray = np.empty((height + 2 * margin, width + 2 * margin), np.float32)
    _gray(pixels, left - margin * step, top - margin * step, step, gray)
    rows = np.empty((height + 2 * margin, width), np.float32)
    _along_rows(gray, derivative, -1.0, rows)
    _along_columns(rows, smooth, 1.0, gx)
    _along_rows(gray, smooth, 1.0, rows)
    _along_columns(rows, derivative, -1.0, gy)


@_kernel
def structure_tensor(
    pixels: NDArray[np.uint8],
    left: int,
    top: int,
    step: int,
    smooth: NDArray[np.float32],
    derivative: NDArray[np.float32],
    window: NDArray[np.float32],
    certainty: NDArray[np.float32],
    bins: NDArray[np.uint8],
    count: int,
) -> None:
    """Write certainty and orientation bin of each block of step x step pixels of a region.

    With J the structure tensor (Maggio et al., equation 3), z = J11 - J22 + 2i J12 has
    |z| = lambda_max - lambda_min, and twice the angle of the dominant eigenvector for its own: the
    certainty is |z| trace J (equation 4), the bin one of `count` of equal width over
    [-pi/2, pi/2). Filters are given by their taps at 0 … r.
    """
    height, width = certainty.shape
    outer = window.shape[0] - 1
    gx = np.empty((height + 2 * outer, width + 2 * outer), np.float32)
    gy = np.empty_like(gx)
    _gradients(pixels, left - outer * step, top - outer * step, step, smooth, derivative, gx, gy)
    narrow = np.empty((height + 2 * outer, width), np.float32)
    product = np.empty_like(gx)
    averages = np.empty((3, height, width), np.float32)
    for part in range(3):
        for y in range(gx.shape[0]):
            u, v, line = gx[y], gy[y], product[y]
            if part == 0:
                for x in range(line.shape[0]):
                    line[x] = u[x] * u[x] - v[x] * v[x]
            elif part == 1:
                for x in range(line.shape[0]):
                    line[x] = np.float32(2.0) * u[x] * v[x]
            else:
                for x in range(line.shape[0]):
                    line[x] = u[x] * u[x] + v[x] * v[x]
        _along_rows(product, window, 1.0, narrow)
        _along_columns(narrow, window, 1.0, averages[part])
    turn, wide = np.empty(width, np.float32), np.float32(count)
    for y in range(height):
        real, imaginary, trace = averages[0, y], averages[1, y], averages[2, y]
        line = certainty[y]
        for x in range(width):
            line[x] = np.sqrt(real[x] * real[x] + imaginary[x] * imaginary[x]) * trace[x]
        _turn(imaginary, real, turn)
        for x in range(width):
            # Rounding may give a whole turn, which is none.
            number = np.int32(turn[x] * wide)
            bins[y, x] = np.uint8(number if number < count else 0)


@_kernel
def orientation_histograms(
    certainty: NDArray[np.float32],
    bins: NDArray[np.uint8],
    left: int,
    top: int,
    ellipses: NDArray[np.float64],
    lattice: NDArray[np.float32],
    grid: tuple[int, int],
    profile: int,
    threshold: float,
    shifts: NDArray[np.float64],
    histograms: NDArray[np.float64],
) -> None:
    """Write each ellipse's normalized orientation histogram, zeros where it has no strong edge.

    Certainties above `threshold` are cumulated; the histogram is then turned back by `shifts`
    bins, whole or not, and smoothed by a triangle of two bins to either side, in one: the triangle
    is read at the shifted places. The plane begins at (left, top), in the units of the ellipses.
    """
    flat, numbers = certainty.reshape(-1), bins.reshape(-1)
    window = (left, top, certainty.shape[1], certainty.shape[0])
    room = _capacity(window, ellipses, lattice)
    offsets, weights = np.empty(room, np.uint32), np.empty(room)
    count = histograms.shape[1]
    lanes = np.empty((LANES, count))
    for n in range(ellipses.shape[0]):
        points = _points(window, ellipses[n], lattice, grid, profile, 1, offsets, weights)
        for i in range(points):
            value = flat[offsets[i]]
            # A branch that goes either way half of the time would take longer than all the rest.
            weights[i] *= value * np.float32(value > threshold)
        _fill(offsets, weights, points, numbers, lanes)
        total = 0.0
        for u in range(count):
            total += lanes[0, u]
        shift = shifts[n] if total > 0.0 else 0.0
        whole = math.floor(shift)
        part = shift - whole
        scale = 0.25 / total if total > 0.0 else 0.0
        place = whole % count
        for u in range(count):
            before = (place if place > 0 else count) - 1
            after = place + 1 if place + 1 < count else 0
            last = after + 1 if after + 1 < count else 0
            # The triangle at distances 1 + part, part, 1 - part and 2 - part.
            histograms[n, u] = scale * (
                (1.0 - part) * lanes[0, before]
                + (2.0 - part) * lanes[0, place]
                + (1.0 + part) * lanes[0, after]
                + part * lanes[0, last]
            )
            place = after


@_kernel
def _edge_bins(
    gx: NDArray[np.float32],
    gy: NDArray[np.float32],
    threshold: float,
    count: int,
    turn: NDArray[np.float32],
    bins: NDArray[np.uint8],
) -> None:
    """Write the bins of edges' orientations, `count` where one is no strong edge.

    Ng and Delp, equations 12 to 14. The `count` bins are of equal width over half a turn, the first
    one centered on -pi/2, a horizontal edge. Overwrites the derivatives; `turn` is room to work in.
    """
    least, wide, two = np.float32(threshold**4), np.float32(count), np.float32(2)
    for i in range(bins.shape[0]):  # twice the angle, opposite directions are one; strength squared
        real, imaginary = gx[i] * gx[i] - gy[i] * gy[i], two * gx[i] * gy[i]
        gx[i], gy[i] = real, imaginary
    _turn(gy, gx, turn)
    for i in range(bins.shape[0]):
        number = np.int32(turn[i] * wide + np.float32(0.5))
        number = number if number < count else np.int32(0)  # half a turn on
        strong = gx[i] * gx[i] + gy[i] * gy[i] > least
        bins[i] = np.uint8(number if strong else count)


@_kernel
def sobel(
    pixels: NDArray[np.uint8],
    left: int,
    top: int,
    threshold: float,
    count: int,
    bins: NDArray[np.uint8],
) -> None:
    """Write the bin of each pixel's edge, as `_edge_bins` does, by Sobel's operator.

    Ng and Delp, equations 10 and 11; past the border of the image its pixels repeat.
    """
    height, width = bins.shape
    gray = np.empty((height + 2, width + 2), np.float32)
    _gray(pixels, left - 1, top - 1, 1, gray)
    lines = np.empty((3, width), np.float32)
    gx, gy, turn = lines[0], lines[1], lines[2]
    two = np.float32(2)
    for y in range(height):
        above, here, below = gray[y], gray[y + 1], gray[y + 2]
        for x in range(width):
            gx[x] = (
                (above[x + 2] - above[x])
                + two * (here[x + 2] - here[x])
                + (below[x + 2] - below[x])
            )
            gy[x] = (
                (below[x] - above[x])
                + two * (below[x + 1] - above[x + 1])
                + (below[x + 2] - above[x + 2])
            )
        _edge_bins(gx, gy, threshold, count, turn, bins[y])


@_kernel
def _derivatives_at(
    flat: NDArray[np.uint8],
    places: NDArray[np.uint32],
    width: int,
    height: int,
    smooth: NDArray[np.float32],
    derivative: NDArray[np.float32],
    room: NDArray[np.int32],
    offsets: NDArray[np.uint32],
    colors: NDArray[np.uint32],
    gx: NDArray[np.float32],
    gy: NDArray[np.float32],
) -> None:
    """Write the two derivatives of gray values at pixels, by their places in the image.

    Filters are given by their taps at 0 … r, as `_gradients` takes them; past the border of the
    image its pixels repeat. `room` (2, 2r + 1, n), `offsets` and `colors` are room to work in.
    """
    gx[:] = np.float32(0)
    gy[:] = np.float32(0)
    r, byte, across = smooth.shape[0] - 1, np.uint32(255), np.float64(width)
    columns, rows = room[0], room[1]
    line, last, bottom = np.int32(3 * width), np.int32(width - 1), np.int32(height - 1)
    for i in range(places.shape[0]):  # by division in double precision, which is exact
        rows[r, i] = np.int32(np.float64(places[i]) / across)
        columns[r, i] = np.int32(np.int32(places[i]) - np.int32(rows[r, i] * np.int32(width)))
    for k in range(2 * r + 1):
        if k != r:
            off = np.int32(k - r)
            for i in range(places.shape[0]):
                row, column = np.int32(rows[r, i] + off), np.int32(columns[r, i] + off)
                rows[k, i] = np.int32(min(max(row, np.int32(0)), bottom) * line)
                columns[k, i] = np.int32(min(max(column, np.int32(0)), last) * np.int32(3))
    for i in range(places.shape[0]):
        rows[r, i] = np.int32(rows[r, i] * line)
        columns[r, i] = np.int32(columns[r, i] * np.int32(3))
    for dy in range(-r, r + 1):
        for dx in range(-r, r + 1):
            to_x = np.float32(np.sign(dx)) * derivative[abs(dx)] * smooth[abs(dy)]
            to_y = np.float32(np.sign(dy)) * derivative[abs(dy)] * smooth[abs(dx)]
            if to_x == 0.0 and to_y == 0.0:
                continue
            to_x, to_y = to_x * np.float32(1 / 256), to_y * np.float32(1 / 256)
            x, y = columns[dx + r], rows[dy + r]
            for i in range(places.shape[0]):
                offsets[i] = np.int32(x[i] + y[i])
            _colors(flat, offsets, places.shape[0], colors)
            for i in range(places.shape[0]):
                color = colors[i]
                luma = np.float32(
                    np.int32(
                        np.uint32(77) * (color & byte)
                        + np.uint32(150) * ((color >> np.uint32(8)) & byte)
                        + np.uint32(29) * (color >> np.uint32(16))
                    )
                )
                gx[i] += to_x * luma
                gy[i] += to_y * luma


@_kernel
def _edge_histogram(
    slots: NDArray[np.uint8],
    keys: NDArray[np.uint32],
    weights: NDArray[np.float64],
    points: int,
    lanes: NDArray[np.float64],
    histogram: NDArray[np.float64],
) -> None:
    """Write the normalized histogram (count + 1,) of strong edges, as `edge_histograms` has it."""
    _fill(keys, weights, points, slots, lanes)
    count = histogram.shape[0] - 1
    total = 0.0
    for u in range(count):
        total += lanes[0, u]
    for u in range(count):
        histogram[u] = lanes[0, u] / total if total > 0.0 else 0.0
    histogram[count] = 1.0 if total == 0.0 and lanes[0, count] > 0.0 else 0.0


@_kernel
def edge_histograms(
    bins: NDArray[np.uint8],
    left: int,
    top: int,
    ellipses: NDArray[np.float64],
    lattice: NDArray[np.float32],
    grid: tuple[int, int],
    profile: int,
    histograms: NDArray[np.float64],
) -> None:
    """Write each ellipse's histogram of strong edges (Ng and Delp, equations 18 and 19).

    Its last place is 1 where there is none, else 0; all are 0 where no pixel is seen. The plane
    begins at (left, top).
    """
    flat = bins.reshape(-1)
    window = (left, top, bins.shape[1], bins.shape[0])
    room = _capacity(window, ellipses, lattice)
    offsets, weights = np.empty(room, np.uint32), np.empty(room)
    lanes = np.empty((LANES, histograms.shape[1]))
    for n in range(ellipses.shape[0]):
        points = _points(window, ellipses[n], lattice, grid, profile, 1, offsets, weights)
        _edge_histogram(flat, offsets, weights, points, lanes, histograms[n])


@_kernel
def edge_histograms_at(
    pixels: NDArray[np.uint8],
    ellipses: NDArray[np.float64],
    lattice: NDArray[np.float32],
    profile: int,
    threshold: float,
    histograms: NDArray[np.float64],
) -> None:
    """Write the same histograms without a plane, by Sobel's operator at a lattice's points."""
    flat = pixels.reshape(-1)
    height, width = pixels.shape[0], pixels.shape[1]
    room, count = lattice.shape[1], histograms.shape[1] - 1
    places, weights = np.empty(room, np.uint32), np.empty(room)
    offsets, colors = np.empty(room, np.uint32), np.empty(room, np.uint32)
    work = np.empty((2, 3, room), np.int32)
    smooth, derivative = np.array([2, 1], np.float32), np.array([0, 1], np.float32)
    planes = np.empty((3, room), np.float32)
    gx, gy, turn = planes[0], planes[1], planes[2]
    order, bins = np.arange(room).astype(np.uint32), np.empty(room, np.uint8)
    lanes = np.empty((LANES, count + 1))
    for n in range(ellipses.shape[0]):
        points = _points(
            (0, 0, width, height), ellipses[n], lattice, (1, 1), profile, 1, places, weights
        )
        if points > 0:
            _derivatives_at(
                flat, places, width, height, smooth, derivative, work, offsets, colors, gx, gy
            )
            _edge_bins(gx, gy, threshold, count, turn, bins)
        _edge_histogram(bins, order, weights, points, lanes, histograms[n])


@_kernel
def _directions(
    gx: NDArray[np.float32],
    gy: NDArray[np.float32],
    count: int,
    strength: NDArray[np.float32],
    bins: NDArray[np.uint8],
) -> None:
    """Write the strength of gradients and the bins of their directions.

    The `count` bins are of equal width over a whole turn, the first one centered on the -x axis.
    """
    turn = strength  # which is written over in the end
    _turn(gy, gx, turn)
    wide = np.float32(count)
    for i in range(bins.shape[0]):
        number = np.int32(turn[i] * wide + np.float32(0.5))
        bins[i] = np.uint8(number if number < count else np.int32(0))  # a whole turn is none
        strength[i] = np.sqrt(gx[i] * gx[i] + gy[i] * gy[i])


@_kernel
def gradients(
    pixels: NDArray[np.uint8],
    left: int,
    top: int,
    smooth: NDArray[np.float32],
    derivative: NDArray[np.float32],
    strength: NDArray[np.float32],
    bins: NDArray[np.uint8],
    count: int,
) -> None:
    """Write strength and direction of the gradient at each pixel of a region, as `_directions`."""
    height, width = strength.shape
    for above in range(0, height, BAND):  # which stay in the processor's cache
        rows = min(BAND, height - above)
        gx, gy = np.empty((rows, width), np.float32), np.empty((rows, width), np.float32)
        _gradients(pixels, left, top + above, 1, smooth, derivative, gx, gy)
        for y in range(rows):
            _directions(gx[y], gy[y], count, strength[above + y], bins[above + y])


@_kernel
def _cells(
    window: tuple[int, int, int, int],
    ellipse: NDArray[np.float64],
    lattice: NDArray[np.float32],
    side: int,
    offsets: NDArray[np.uint32],
    count: int,
    cells: NDArray[np.uint32],
) -> None:
    """Write in which of side x side cells of the box around an ellipse its points lie.

    The box is that of the ellipse's own axes, and turns with it. Points are as `_points` writes
    them, for one channel.
    """
    half, last = 0.5 * side, np.int32(side - 1)
    if lattice.shape[1] > 0:
        us, vs = lattice[0], lattice[1]
        for i in range(count):
            column, row = np.int32((us[i] + 1.0) * half), np.int32((vs[i] + 1.0) * half)
            cells[i] = np.uint32(min(row, last) * side + min(column, last))
        return
    left, top, width, _ = window
    cos, sin = math.cos(ellipse[4]), math.sin(ellipse[4])
    for i in range(count):
        line, place = divmod(np.int64(offsets[i]), width)
        x, y = left + place - ellipse[0], top + line - ellipse[1]
        u, v = (x * cos + y * sin) / ellipse[2], (y * cos - x * sin) / ellipse[3]
        column, row = np.int32((u + 1.0) * half), np.int32((v + 1.0) * half)
        cells[i] = np.uint32(min(row, last) * side + min(column, last))


@_kernel
def _hog(
    cells: NDArray[np.uint32],
    bins: NDArray[np.uint8],
    strength: NDArray[np.float32],
    weights: NDArray[np.float64],
    points: int,
    slots: NDArray[np.uint8],
    count: int,
    turned: bool,
    lanes: NDArray[np.float64],
    histogram: NDArray[np.float64],
) -> None:
    """Write the normalized histogram of gradients by cell and direction.

    If `turned`, each cell's is turned by whole bins, all alike, so that the direction that is
    strongest over all cells comes first. `slots` are 0, 1, 2 …; `cells` and `weights` are
    overwritten, and `lanes` is room to work in.
    """
    for i in range(points):
        cells[i] = cells[i] * np.uint32(count) + np.uint32(bins[i])
        weights[i] *= strength[i]
    _fill(cells, weights, points, slots, lanes)
    total, most, first = 0.0, 0.0, 0
    for u in range(count):
        direction = 0.0
        for cell in range(0, histogram.shape[0], count):
            direction += lanes[0, cell + u]
        total += direction
        if turned and direction > most:
            most, first = direction, u
    for cell in range(0, histogram.shape[0], count):
        for u in range(count):
            value = lanes[0, cell + (u + first) % count]
            histogram[cell + u] = value / total if total > 0.0 else 0.0


@_kernel
def hog_histograms(
    strength: NDArray[np.float32],
    bins: NDArray[np.uint8],
    left: int,
    top: int,
    ellipses: NDArray[np.float64],
    lattice: NDArray[np.float32],
    grid: tuple[int, int],
    profile: int,
    side: int,
    turned: bool,
    histograms: NDArray[np.float64],
) -> None:
    """Write each ellipse's histogram of gradients, as `_hog` does; zeros where there is none.

    It has side x side cells. The plane begins at (left, top).
    """
    values, numbers = strength.reshape(-1), bins.reshape(-1)
    window = (left, top, bins.shape[1], bins.shape[0])
    room, size = _capacity(window, ellipses, lattice), histograms.shape[1]
    offsets, weights = np.empty(room, np.uint32), np.empty(room)
    cells, found = np.empty(room, np.uint32), np.empty(room, np.float32)
    at, count = np.empty(room, np.uint8), size // (side * side)
    slots, lanes = np.arange(size).astype(np.uint8), np.empty((LANES, size))
    for n in range(ellipses.shape[0]):
        points = _points(window, ellipses[n], lattice, grid, profile, 1, offsets, weights)
        for i in range(points):
            found[i], at[i] = values[offsets[i]], numbers[offsets[i]]
        _cells(window, ellipses[n], lattice, side, offsets, points, cells)
        _hog(cells, at, found, weights, points, slots, count, turned, lanes, histograms[n])


@_kernel
def hog_histograms_at(
    pixels: NDArray[np.uint8],
    ellipses: NDArray[np.float64],
    lattice: NDArray[np.float32],
    profile: int,
    side: int,
    turned: bool,
    smooth: NDArray[np.float32],
    derivative: NDArray[np.float32],
    histograms: NDArray[np.float64],
) -> None:
    """Write the same histograms without a plane, by gradients at a lattice's points."""
    flat = pixels.reshape(-1)
    window = (0, 0, pixels.shape[1], pixels.shape[0])
    room, size = lattice.shape[1], histograms.shape[1]
    count = size // (side * side)
    places, weights = np.empty(room, np.uint32), np.empty(room)
    offsets, colors = np.empty(room, np.uint32), np.empty(room, np.uint32)
    work = np.empty((2, 2 * smooth.shape[0] - 1, room), np.int32)
    planes = np.empty((3, room), np.float32)
    gx, gy, strength = planes[0], planes[1], planes[2]
    cells, bins = np.empty(room, np.uint32), np.empty(room, np.uint8)
    slots, lanes = np.arange(size).astype(np.uint8), np.empty((LANES, size))
    for n in range(ellipses.shape[0]):
        points = _points(window, ellipses[n], lattice, (1, 1), profile, 1, places, weights)
        if points > 0:
            _derivatives_at(
                flat, places, pixels.shape[1], pixels.shape[0], smooth, derivative, work,
                offsets, colors, gx, gy,
            )  # fmt: skip
            _directions(gx, gy, count, strength, bins)
        _cells(window, ellipses[n], lattice, side, places, points, cells)
        _hog(cells, bins, strength, weights, points, slots, count, turned, lanes, histograms[n])


@_kernel
def values_within(
    plane: NDArray[np.float32],
    left: int,
    top: int,
    ellipse: NDArray[np.float64],
    lattice: NDArray[np.float32],
    grid: tuple[int, int],
) -> NDArray[np.float32]:
    """Return the values of a plane (H, W) at the points of an ellipse, without those outside.

    The plane begins at (left, top), in the units of the ellipse.
    """
    window = (left, top, plane.shape[1], plane.shape[0])
    flat = plane.reshape(-1)
    room = _capacity(window, ellipse.reshape(1, 5), lattice)
    offsets, weights = np.empty(room, np.uint32), np.empty(room)
    points = _points(window, ellipse, lattice, grid, UNIFORM, 1, offsets, weights)
    values = np.empty(points, np.float32)
    count = 0
    for i in range(points):
        if weights[i] > 0.0:
            values[count] = flat[offsets[i]]
            count += 1
    return values[:count]


@_brief
def bounds(ellipses: NDArray[np.float64]) -> tuple[float, float, float, float]:
    """Return the left, top, right and bottom end of what ellipses cover.

    Those with NaN or infinity cover nothing; the left end of nothing is right of its right end.
    """
    left = top = np.inf
    right = bottom = -np.inf
    for n in range(ellipses.shape[0]):
        x, y, a, b = ellipses[n, 0], ellipses[n, 1], ellipses[n, 2], ellipses[n, 3]
        cos, sin = math.cos(ellipses[n, 4]), math.sin(ellipses[n, 4])
        across = math.sqrt(a * a * cos * cos + b * b * sin * sin)
        down = math.sqrt(a * a * sin * sin + b * b * cos * cos)
        if not math.isfinite(x + y + across + down):
            continue
        left, top = min(left, x - across), min(top, y - down)
        right, bottom = max(right, x + across), max(bottom, y + down)
    return left, top, right, bottom


@_brief
def moments(
    ellipses: NDArray[np.float64],
    weights: NDArray[np.float64],
    mean: NDArray[np.float64],
    covariance: NDArray[np.float64],
) -> None:
    """Write the weighted mean (5,) and covariance (5, 5) of ellipses, angles modulo pi."""
    mean[:] = 0.0
    covariance[:] = 0.0
    sin, cos = 0.0, 0.0
    for n in range(ellipses.shape[0]):
        for i in range(4):
            mean[i] += weights[n] * ellipses[n, i]
        sin += weights[n] * math.sin(2 * ellipses[n, 4])
        cos += weights[n] * math.cos(2 * ellipses[n, 4])
    mean[4] = math.atan2(sin, cos) / 2
    off = np.empty(5)
    for n in range(ellipses.shape[0]):
        for i in range(5):
            off[i] = ellipses[n, i] - mean[i]
        off[4] -= math.pi * np.rint(off[4] / math.pi)
        for i in range(5):
            weighted = weights[n] * off[i]
            for j in range(i + 1):
                covariance[i, j] += weighted * off[j]
    for i in range(5):
        for j in range(i):
            covariance[j, i] = covariance[i, j]


@_kernel
def mean_shift(
    pixels: NDArray[np.uint8],
    ellipse: NDArray[np.float64],
    lattice: NDArray[np.float32],
    grid: tuple[int, int],
    slots: NDArray[np.uint32],
    ratios: NDArray[np.float64],
    space: int,
    n0: int,
    n1: int,
    n2: int,
    center: NDArray[np.float64],
) -> None:
    """Write the mean (x, y) of an ellipse's pixels, each weighted by its bin's entry in `ratios`.

    Leaves `center` as it is where no pixel has any weight.
    """
    flat = pixels.reshape(-1)
    window = (0, 0, pixels.shape[1], pixels.shape[0])
    room = _capacity(window, ellipse.reshape(1, 5), lattice)
    offsets, colors = np.empty(room, np.uint32), np.empty(room, np.uint32)
    weights = np.empty(room)
    count = _points(window, ellipse, lattice, grid, EPANECHNIKOV, 3, offsets, weights)
    _colors(flat, offsets, count, colors)
    _color_bins(colors, count, space, n0, n1, n2)
    total, sum_x, sum_y = 0.0, 0.0, 0.0
    for i in range(count):
        if weights[i] > 0.0:
            weight = ratios[slots[colors[i]]]
            row, column = divmod(np.int64(offsets[i]) // 3, pixels.shape[1])
            total += weight
            sum_x += weight * column
            sum_y += weight * row
    if total > 0.0:
        center[0] = sum_x / total
        center[1] = sum_y / total


@_unordered
def cut(
    pixels: NDArray[np.uint8],
    corner: tuple[float, float],
    across: tuple[float, float],
    down: tuple[float, float],
    out: NDArray[np.float32],
) -> None:
    """Write the samples (3, H, W) of a part of a picture, RGB 0 to 255.

    The sample in row i and column j lies at corner + j across + i down, each in x and y. Where it
    stands for several pixels, it is the mean of up to 4x4 of them; between pixels it is bilinear.
    Outside the picture its border goes on.
    """
    if across[1] == 0.0 and down[0] == 0.0:
        _cut_upright(pixels, corner, (across[0], down[1]), out)
        return
    height, width = pixels.shape[0], pixels.shape[1]
    rows, columns = out.shape[1], out.shape[2]
    step_x, step_y = math.hypot(across[0], across[1]), math.hypot(down[0], down[1])
    if step_x < 1.0 or step_y < 1.0:
        _cut_between(pixels, corner, across, down, out)
        return
    across_count, down_count = min(int(step_x + 0.5), 4), min(int(step_y + 0.5), 4)
    share = np.float32(1.0 / (across_count * down_count))
    for i in range(rows):
        for j in range(columns):
            red, green, blue = 0, 0, 0
            for u in range(down_count):
                along = i - 0.5 + (u + 0.5) / down_count
                left = corner[0] + along * down[0] + 0.5
                top = corner[1] + along * down[1] + 0.5
                for v in range(across_count):
                    beside = j - 0.5 + (v + 0.5) / across_count
                    column = int(min(max(left + beside * across[0], 0.0), width - 1.0))
                    row = int(min(max(top + beside * across[1], 0.0), height - 1.0))
                    red += pixels[row, column, 0]
                    green += pixels[row, column, 1]
                    blue += pixels[row, column, 2]
            out[0, i, j], out[1, i, j], out[2, i, j] = red * share, green * share, blue * share


@_unordered
def _cut_between(
    pixels: NDArray[np.uint8],
    corner: tuple[float, float],
    across: tuple[float, float],
    down: tuple[float, float],
    out: NDArray[np.float32],
) -> None:
    """Do as `cut` does with samples between pixels."""
    height, width = pixels.shape[0], pixels.shape[1]
    flat, green, blue = pixels.reshape(3 * height * width), np.uint64(1), np.uint64(2)
    zero, one = np.float32(0.0), np.float32(1.0)
    right, low = np.float32(width - 1), np.float32(height - 1)
    across_x, across_y = np.float32(across[0]), np.float32(across[1])
    for i in range(out.shape[1]):
        left, top = np.float32(corner[0] + i * down[0]), np.float32(corner[1] + i * down[1])
        for j in range(out.shape[2]):
            x = min(max(left + np.float32(j) * across_x, zero), right)
            y = min(max(top + np.float32(j) * across_y, zero), low)
            column, row = np.int32(x), np.int32(y)
            # Places that can't be negative: of the four pixels around.
            here = np.uint64(3 * (row * width + column))
            beside = here + np.uint64(3 if column < width - 1 else 0)
            below = here + np.uint64(3 * width if row < height - 1 else 0)
            across_below = below + (beside - here)
            x, y = x - np.float32(column), y - np.float32(row)
            share3 = x * y
            share1, share2 = x - share3, y - share3
            share0 = one - x - share2
            out[0, i, j] = (
                share0 * flat[here]
                + share1 * flat[beside]
                + share2 * flat[below]
                + share3 * flat[across_below]
            )
            out[1, i, j] = (
                share0 * flat[here + green]
                + share1 * flat[beside + green]
                + share2 * flat[below + green]
                + share3 * flat[across_below + green]
            )
            out[2, i, j] = (
                share0 * flat[here + blue]
                + share1 * flat[beside + blue]
                + share2 * flat[below + blue]
                + share3 * flat[across_below + blue]
            )


@_unordered
def _cut_upright(
    pixels: NDArray[np.uint8],
    corner: tuple[float, float],
    step: tuple[float, float],
    out: NDArray[np.float32],
) -> None:
    """Do as `cut` does with samples along the picture's rows and columns, `step` pixels apart."""
    height, width = pixels.shape[0], pixels.shape[1]
    columns, beside = _taps(corner[0], step[0], out.shape[2], width)
    rows, along = _taps(corner[1], step[1], out.shape[1], height)
    left = 3 * columns[0, 0]
    span = 3 * (columns[-1, -1] + 1) - left
    # Places that can't be negative, and slices from 0, are what the compiler makes vector code of.
    # (Loops over elements compile several times faster than array expressions.)
    taps = columns.shape[1]
    places = np.empty((columns.shape[0], taps), np.uint64)
    for j in range(columns.shape[0]):
        for v in range(taps):
            places[j, v] = 3 * columns[j, v] - left
    green, blue = np.uint64(1), np.uint64(2)
    flat, line = pixels.reshape(height, 3 * width), np.empty(span, np.float32)
    for i in range(rows.shape[0]):
        for c in range(span):
            line[c] = 0.0
        for u in range(rows.shape[1]):
            share, source = along[i, u], flat[rows[i, u], left : left + span]
            for c in range(span):
                line[c] += share * np.float32(source[c])
        for j in range(places.shape[0]):
            r, g, b = np.float32(0.0), np.float32(0.0), np.float32(0.0)
            for v in range(places.shape[1]):
                share, place = beside[j, v], places[j, v]
                r += share * line[place]
                g += share * line[place + green]
                b += share * line[place + blue]
            out[0, i, j], out[1, i, j], out[2, i, j] = r, g, b


@_unordered
def _taps(
    start: float, step: float, count: int, limit: int
) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """Return which of `limit` pixels in a line count how much for each of `count` samples."""
    n = 2 if step < 1.0 else min(int(step + 0.5), 4)
    places, shares = np.empty((count, n), np.int64), np.empty((count, n), np.float32)
    for i in range(count):
        if step < 1.0:
            x = min(max(start + i * step, 0.0), limit - 1.0)
            places[i, 0], places[i, 1] = int(x), min(int(x) + 1, limit - 1)
            shares[i, 0], shares[i, 1] = 1.0 - (x - int(x)), x - int(x)
        else:
            for u in range(n):
                x = start + (i - 0.5 + (u + 0.5) / n) * step + 0.5
                places[i, u], shares[i, u] = int(min(max(x, 0.0), limit - 1.0)), 1.0 / n
    return places, shares


@_unordered
def gradient_cells(
    samples: NDArray[np.float32],
    cell: int,
    sectors: NDArray[np.uint8],
    out: NDArray[np.float32],
) -> None:
    """Write the features (30, h, w) of cells of samples (3, H, W), H = cell * h, W = cell * w.

    9 orientations of gradients without and 18 with their sign, each normalized by the energy of
    the four blocks of 2x2 cells around, truncated at 0.2 and averaged; then gray and two color
    differences. `sectors` (512, 512) has the number of a gradient's sector, 18 to the turn, at row
    256 + dy / 3 and column 256 + dx / 3, the derivatives being those of R + G + B.
    """
    rows, columns = out.shape[1], out.shape[2]
    # One cell more on each side, into which the outermost samples' votes fall.
    votes = np.empty((rows + 2, 18 * (columns + 2)), np.float32)
    _vote(samples, cell, sectors, votes)
    energy = np.empty((rows + 2, columns + 2), np.float32)
    for i in range(1, rows + 1):
        for j in range(1, columns + 1):
            total = np.float32(0.0)
            for k in range(18 * j, 18 * j + 9):
                both = votes[i, k] + votes[i, k + 9]
                total += both * both
            energy[i, j] = total
    for j in range(1, columns + 1):
        energy[0, j], energy[rows + 1, j] = energy[1, j], energy[rows, j]
    for i in range(rows + 2):
        energy[i, 0], energy[i, columns + 1] = energy[i, 1], energy[i, columns]
    one, top, half = np.float32(1.0), np.float32(0.2), np.float32(0.5)
    norms, line = np.empty((4, columns), np.float32), np.empty(columns, np.float32)
    for i in range(rows):
        above, here, below = energy[i], energy[i + 1], energy[i + 2]
        for j in range(columns):
            # A gradient of one gray value counts as none.
            middle = here[j + 1] + one
            norms[0, j] = one / math.sqrt(above[j] + above[j + 1] + here[j] + middle)
            norms[1, j] = one / math.sqrt(above[j + 2] + above[j + 1] + here[j + 2] + middle)
            norms[2, j] = one / math.sqrt(below[j] + below[j + 1] + here[j] + middle)
            norms[3, j] = one / math.sqrt(below[j + 2] + below[j + 1] + here[j + 2] + middle)
        n0, n1, n2, n3 = norms[0], norms[1], norms[2], norms[3]
        inner = votes[i + 1, 18:]
        for k in range(27):
            for j in range(columns):
                line[j] = (
                    inner[18 * j + k] + inner[18 * j + k + 9] if k < 9 else inner[18 * j + k - 9]
                )
            to = out[k, i]
            for j in range(columns):
                to[j] = half * (
                    min(line[j] * n0[j], top)
                    + min(line[j] * n1[j], top)
                    + min(line[j] * n2[j], top)
                    + min(line[j] * n3[j], top)
                )
    scale = np.float32(1.0 / (cell * cell * 255.0))
    for i in range(rows):
        for j in range(columns):
            red, green, blue = np.float32(0.0), np.float32(0.0), np.float32(0.0)
            for row in range(i * cell, (i + 1) * cell):
                for column in range(j * cell, (j + 1) * cell):
                    red += samples[0, row, column]
                    green += samples[1, row, column]
                    blue += samples[2, row, column]
            out[27, i, j] = (red + green + blue) * scale / 3 - half
            out[28, i, j] = (red - green) * scale
            out[29, i, j] = (half * (red + green) - blue) * scale


@_unordered
def _vote(
    samples: NDArray[np.float32],
    cell: int,
    sectors: NDArray[np.uint8],
    votes: NDArray[np.float32],
) -> None:
    """Write the votes of samples' gradients, each for the four cells (h + 2, 18 (w + 2)) around."""
    height, width = samples.shape[1], samples.shape[2]
    before, here = np.empty(width + 2, np.float32), np.empty(width + 2, np.float32)
    after, magnitude = np.empty(width + 2, np.float32), np.empty(width, np.float32)
    left, across = np.empty(width, np.uint64), np.empty(width, np.float32)
    place, next_cell = np.empty(width, np.uint64), np.uint64(18)
    line = np.empty(votes.shape[1], np.float32)
    third, middle = np.float32(1 / 3), np.float32(256.5)
    for j in range(width):
        x = (j + 0.5) / cell + 0.5
        left[j], across[j] = 18 * int(x), x - int(x)
    for i in range(votes.shape[0]):
        for k in range(votes.shape[1]):
            votes[i, k] = 0.0
    _brightness(samples, 0, here)
    _brightness(samples, 0, before)
    for i in range(height):
        _brightness(samples, min(i + 1, height - 1), after)
        for j in range(width):
            dx, dy = here[j + 2] - here[j], after[j + 1] - before[j + 1]
            magnitude[j] = math.sqrt(dx * dx + dy * dy)
            # To 32 bits, with a sign first: a processor has no other quick way from floats.
            row, column = np.int32(dy * third + middle), np.int32(dx * third + middle)
            place[j] = left[j] + sectors[np.uint32(row), np.uint32(column)]
        for k in range(line.shape[0]):
            line[k] = 0.0
        for j in range(width):
            far = magnitude[j] * across[j]
            line[place[j]] += magnitude[j] - far
            line[place[j] + next_cell] += far
        y = (i + 0.5) / cell + 0.5
        low = np.float32(y - int(y))
        upper, lower = votes[int(y)], votes[int(y) + 1]
        for k in range(line.shape[0]):
            upper[k] += (1 - low) * line[k]
            lower[k] += low * line[k]
        before, here, after = here, after, before


@_unordered
def _brightness(samples: NDArray[np.float32], row: int, out: NDArray[np.float32]) -> None:
    """Write R + G + B of a row (W + 2,), its ends twice."""
    width = samples.shape[2]
    red, green, blue, inner = samples[0, row], samples[1, row], samples[2, row], out[1:]
    for j in range(width):
        inner[j] = red[j] + green[j] + blue[j]
    out[0], out[width + 1] = out[1], out[width]


@_unordered
def correlate(
    numerator: NDArray[np.complex64],
    power: NDArray[np.float32],
    spectra: NDArray[np.complex64],
    out: NDArray[np.complex64],
) -> None:
    """Write what a filter (K, F) and (F,) makes of spectra (K, F): the response's spectrum (F,)."""
    for i in range(out.shape[0]):
        out[i] = 0.0
    for k in range(numerator.shape[0]):
        for i in range(numerator.shape[1]):
            out[i] += np.conj(numerator[k, i]) * spectra[k, i]
    for i in range(out.shape[0]):
        out[i] /= power[i]


@_unordered
def teach(
    spectra: NDArray[np.complex64],
    label: NDArray[np.complex64],
    rate: float,
    numerator: NDArray[np.complex64],
    power: NDArray[np.float32],
) -> None:
    """Put a share `rate` of a lesson, spectra (K, F) and label (F,), into a filter (K, F), (F,)."""
    new, kept = np.float32(rate), np.float32(1.0 - rate)
    for i in range(power.shape[0]):
        power[i] *= kept
    for k in range(numerator.shape[0]):
        for i in range(power.shape[0]):
            value = spectra[k, i]
            numerator[k, i] = kept * numerator[k, i] + new * label[i] * value
            power[i] += new * (value.real * value.real + value.imag * value.imag)


@_kernel
def add_colors(
    samples: NDArray[np.float32],
    inner: tuple[float, float, float, float],
    outer: tuple[float, float, float, float],
    share: float,
    inside: NDArray[np.float32],
    outside: NDArray[np.float32],
) -> None:
    """Add `share` of 32x32x32 colors: of samples in the box `inner`, and of those not in `outer`.

    Boxes are left, top, right and bottom, in samples.
    """
    height, width = samples.shape[1], samples.shape[2]
    here, there = _inside(inner, height, width), height * width - _inside(outer, height, width)
    one, other = np.float32(share / max(here, 1)), np.float32(share / max(there, 1))
    for i in range(height):
        for j in range(width):
            if inner[1] <= i < inner[3] and inner[0] <= j < inner[2]:
                inside[_color32(samples, i, j)] += one
            elif not (outer[1] <= i < outer[3] and outer[0] <= j < outer[2]):
                outside[_color32(samples, i, j)] += other


@_kernel
def _inside(box: tuple[float, float, float, float], height: int, width: int) -> int:
    """Return how many samples lie in a box."""
    across, down = 0, 0
    for j in range(width):
        across += box[0] <= j < box[2]
    for i in range(height):
        down += box[1] <= i < box[3]
    return across * down


@_kernel
def color_integral(
    samples: NDArray[np.float32],
    inside: NDArray[np.float32],
    outside: NDArray[np.float32],
    out: NDArray[np.float64],
) -> None:
    """Write the sums (H + 1, W + 1), above and left of each corner, of inside / (inside + outside).

    A color that was never seen counts 1/2.
    """
    out[0] = 0.0
    for i in range(samples.shape[1]):
        total, out[i + 1, 0] = 0.0, 0.0
        for j in range(samples.shape[2]):
            total += _posterior(inside, outside, _color32(samples, i, j))
            out[i + 1, j + 1] = out[i, j + 1] + total


@_unordered
def _color32(samples: NDArray[np.float32], i: int, j: int) -> int:
    red, green, blue = int(samples[0, i, j]), int(samples[1, i, j]), int(samples[2, i, j])
    return ((red >> 3) << 10) + ((green >> 3) << 5) + (blue >> 3)


@_unordered
def _posterior(inside: NDArray[np.float32], outside: NDArray[np.float32], color: int) -> float:
    return float((inside[color] + 1e-6) / (inside[color] + outside[color] + 2e-6))


@_kernel
def box_means(
    integral: NDArray[np.float64], boxes: NDArray[np.float64], out: NDArray[np.float64]
) -> None:
    """Write the mean over boxes (N, 4), x and y off the middle and half sides, from sums."""
    for n in range(boxes.shape[0]):
        out[n] = _box_mean(integral, boxes[n, 0], boxes[n, 1], boxes[n, 2], boxes[n, 3])


@_unordered
def _box_mean(
    integral: NDArray[np.float64], x: float, y: float, across: float, down: float
) -> float:
    """Return the mean over a box; what reaches outside is left out; it has at least one sample."""
    rows, columns = integral.shape[0] - 1, integral.shape[1] - 1
    x, y = x + columns / 2, y + rows / 2
    left, top = min(max(x - across, 0.0), columns - 1.0), min(max(y - down, 0.0), rows - 1.0)
    right = min(max(x + across, left + 1.0), float(columns))
    bottom = min(max(y + down, top + 1.0), float(rows))
    total = _between(integral, bottom, right) - _between(integral, bottom, left)
    total += _between(integral, top, left) - _between(integral, top, right)
    return float(total / ((right - left) * (bottom - top)))


@_unordered
def _between(plane: NDArray[Any], y: float, x: float) -> float:
    """Return a plane's bilinear value at row y and column x, both inside it."""
    i, j = min(int(y), plane.shape[0] - 2), min(int(x), plane.shape[1] - 2)
    down, across = y - i, x - j
    high = (1 - across) * plane[i, j] + across * plane[i, j + 1]
    low = (1 - across) * plane[i + 1, j] + across * plane[i + 1, j + 1]
    return float((1 - down) * high + down * low)


@_kernel
def look_up(
    plane: NDArray[np.float32],
    points: NDArray[np.float64],
    step: float,
    out: NDArray[np.float64],
) -> None:
    """Write a plane's bilinear value at points (N, 2) off its middle; 0 outside of it.

    `step` is from one value to the next.
    """
    for n in range(points.shape[0]):
        x, y = plane.shape[1] // 2 + points[n, 0] / step, plane.shape[0] // 2 + points[n, 1] / step
        out[n] = 0.0
        if 0.0 <= x <= plane.shape[1] - 1 and 0.0 <= y <= plane.shape[0] - 1:
            out[n] = _between(plane, y, x)


@_kernel
def pool(
    integral: NDArray[np.float64],
    half: tuple[float, float],
    share: float,
    points: NDArray[np.float64],
    out: NDArray[np.float64],
) -> None:
    """Mix into values `out` a share of the mean over boxes around points (N, 2) off the middle."""
    for n in range(points.shape[0]):
        mean = _box_mean(integral, points[n, 0], points[n, 1], half[0], half[1])
        out[n] = (1 - share) * out[n] + share * mean


def cache_folder() -> Path | None:
    """Return the folder where compiled kernels are kept, None where there is none."""
    folder = color_distances.stats.cache_path  # type: ignore[attr-defined]
    return Path(folder) if CACHED and folder else None


def when_compiling(tell: Callable[[], None]) -> None:
    """Call a function before the next kernel is compiled that no folder keeps, and never again."""

    class Once(event.Listener):
        def on_start(self, _: event.Event) -> None:
            stop()
            tell()

        def on_end(self, _: event.Event) -> None:
            """Told at the start."""

    once = Once()
    stop = functools.partial(event.unregister, "numba:compile", once)
    event.register("numba:compile", once)  # type: ignore[no-untyped-call]
