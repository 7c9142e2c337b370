"""Every compiled loop, and nothing else; imports numpy and numba only.

One file, though a long one: numba keeps a compiled kernel until the kernel's own file changes, and
would not see a change in another file that it calls.

Kernels release the GIL, allocate nothing inside loops and know no Python objects. An ellipse is a
row x, y, a, b, theta. Color spaces are numbered (`RGB`, `HSV`); a pixel's bin is
(i0 * n1 + i1) * n2 + i2 for bins n0 x n1 x n2, equally wide in each channel. `slots` maps each
of these bins to a place in a histogram that holds only the bins wanted, its last place taking
all others.

An ellipse's pixels are read at the points of `lattice`, (2, n) in the unit disk; where it is empty,
those are read whose row and column add up to a multiple of the first number of `grid`, and whose
row is a multiple of the second: 1, 1 is every pixel.
"""

from __future__ import annotations

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


def _kernel(function: F) -> F:
    """Compile a loop on first use, without the GIL, kept on disk where possible."""
    return cast(F, numba.njit(nogil=True, cache=CACHED, error_model="numpy")(function))


RGB, HSV = 0, 1
EPANECHNIKOV, RADIAL, UNIFORM = 0, 1, 2
LANES = 4


@_kernel
def _channel_table(space: int, n0: int, n1: int, n2: int) -> NDArray[np.uint32]:
    """Return what each channel's value adds to an RGB color's bin, (3, 256); HSV needs none."""
    table = np.zeros((3, 256), np.uint32)
    if space == RGB:
        for value in range(256):
            table[0, value] = ((value * n0) >> 8) * n1 * n2
            table[1, value] = ((value * n1) >> 8) * n2
            table[2, value] = (value * n2) >> 8
    return table


@_kernel
def _hsv_bin(r: Any, g: Any, b: Any, n0: int, n1: int, n2: int) -> Any:
    """Return the bin of an RGB color in HSV; channels run from 0 to 1, gray has hue 0."""
    high = max(r, g, b)
    spread = high - min(r, g, b)
    if spread == 0:
        return (high * n2) >> 8
    # Six times the hue, times the spread: an integer, so that bins are exact.
    if high == r:
        hue = g - b
        if hue < 0:
            hue += 6 * spread
    elif high == g:
        hue = 2 * spread + b - r
    else:
        hue = 4 * spread + r - g
    i0 = (hue * n0) // (6 * spread)
    i1 = min((spread * n1) // high, n1 - 1)
    return (i0 * n1 + i1) * n2 + ((high * n2) >> 8)


@_kernel
def _capacity(
    window: tuple[int, int, int, int],
    ellipses: NDArray[np.float64],
    lattice: NDArray[np.float64],
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
def _points(
    window: tuple[int, int, int, int],
    ellipse: NDArray[np.float64],
    lattice: NDArray[np.float64],
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
    # 1 - r² with r over the bandwidth sqrt(a² + b²), or over the ellipse itself; or 1 everywhere.
    uu, vv = (0.0, 0.0) if profile == UNIFORM else (1.0, 1.0)
    if profile == RADIAL:
        uu, vv = a * a / (a * a + b * b), b * b / (a * a + b * b)
    if lattice.shape[1] > 0:
        ax, ay, bx, by = a * cos, a * sin, -b * sin, b * cos
        right, bottom = left + width, top + height
        x0, y0 = x + 0.5, y + 0.5
        for i in range(lattice.shape[1]):  # branchless, so that it becomes vector code
            u, v = lattice[0, i], lattice[1, i]
            px = x0 + u * ax + v * bx
            py = y0 + u * ay + v * by
            inside = (px >= left) & (py >= top) & (px < right) & (py < bottom)
            place = (np.int32(py) - np.int32(top)) * np.int32(width) + (
                np.int32(px) - np.int32(left)
            )
            offsets[i] = np.uint32(channels * place) if inside else np.uint32(0)
            weights[i] = 1.0 - (u * u * uu + v * v * vv) if inside else 0.0
        return int(lattice.shape[1])
    half_width, half_height = math.hypot(a * cos, b * sin), math.hypot(a * sin, b * cos)
    if not math.isfinite(x + y + half_width + half_height):
        return 0
    first = max(left, math.ceil(x - half_width))
    last = min(left + width - 1, math.floor(x + half_width))
    above = max(top, math.ceil(y - half_height))
    below = min(top + height - 1, math.floor(y + half_height))
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
    return count


@_kernel
def _slot(
    flat: NDArray[np.uint8],
    offset: Any,
    slots: NDArray[np.uint32],
    table: NDArray[np.uint32],
    space: int,
    n0: int,
    n1: int,
    n2: int,
) -> Any:
    """Return the slot of the color at a place in the flat image."""
    r, g, b = flat[offset], flat[offset + np.uint32(1)], flat[offset + np.uint32(2)]
    if space == RGB:
        return slots[table[0, r] + table[1, g] + table[2, b]]
    return slots[_hsv_bin(np.int64(r), np.int64(g), np.int64(b), n0, n1, n2)]


@_kernel
def _fill(
    flat: NDArray[np.uint8],
    offsets: NDArray[np.uint32],
    weights: NDArray[np.float64],
    count: int,
    slots: NDArray[np.uint32],
    table: NDArray[np.uint32],
    space: int,
    n0: int,
    n1: int,
    n2: int,
    lanes: NDArray[np.float64],
) -> None:
    """Add the weights of `count` pixels to a histogram, which is afterwards in lane 0.

    Neighbors often share a bin; adding them in turn to separate lanes keeps one addition from
    waiting for the one before.
    """
    lanes[:] = 0.0
    for i in range(count):
        slot = _slot(flat, offsets[i], slots, table, space, n0, n1, n2)
        lanes[np.uint32(i) % np.uint32(LANES), slot] += weights[i]
    for slot in range(lanes.shape[1]):
        lanes[0, slot] += lanes[1, slot] + lanes[2, slot] + lanes[3, slot]


@_kernel
def color_histograms(
    pixels: NDArray[np.uint8],
    ellipses: NDArray[np.float64],
    lattice: NDArray[np.float64],
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
    table = _channel_table(space, n0, n1, n2)
    window = (0, 0, pixels.shape[1], pixels.shape[0])
    room = _capacity(window, ellipses, lattice)
    offsets, weights = np.empty(room, np.uint32), np.empty(room)
    lanes = np.empty((LANES, histograms.shape[1]))
    for n in range(ellipses.shape[0]):
        count = _points(window, ellipses[n], lattice, grid, profile, 3, offsets, weights)
        _fill(flat, offsets, weights, count, slots, table, space, n0, n1, n2, lanes)
        total = lanes[0].sum()
        for slot in range(lanes.shape[1]):
            histograms[n, slot] = lanes[0, slot] / total if total > 0.0 else 0.0


@_kernel
def color_distances(
    pixels: NDArray[np.uint8],
    ellipses: NDArray[np.float64],
    lattice: NDArray[np.float64],
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
    table = _channel_table(space, n0, n1, n2)
    window = (0, 0, pixels.shape[1], pixels.shape[0])
    room = _capacity(window, ellipses, lattice)
    offsets, weights = np.empty(room, np.uint32), np.empty(room)
    occupied = roots.shape[0]
    lanes = np.empty((LANES, occupied + 1))
    for n in range(ellipses.shape[0]):
        count = _points(window, ellipses[n], lattice, grid, profile, 3, offsets, weights)
        _fill(flat, offsets, weights, count, slots, table, space, n0, n1, n2, lanes)
        rho, total = 0.0, lanes[0, occupied]
        for u in range(occupied):
            rho += roots[u] * math.sqrt(lanes[0, u])
            total += lanes[0, u]
        if total > 0.0:
            rho /= math.sqrt(total)
        distances[n] = math.sqrt(max(0.0, 1.0 - rho))


@_kernel
def _gray(
    pixels: NDArray[np.uint8], left: int, top: int, step: int, gray: NDArray[np.float32]
) -> None:
    """Write the mean luma of blocks of step x step pixels; past the border its pixels repeat."""
    height, width = pixels.shape[0], pixels.shape[1]
    share = np.float32(1.0 / (256 * step * step))
    gray[:] = np.float32(0.0)
    for row in range(gray.shape[0]):
        for y in range(top + row * step, top + (row + 1) * step):
            line = pixels[min(max(y, 0), height - 1)]
            for offset in range(left, left + step):
                for column in range(gray.shape[1]):
                    color = line[min(max(offset + column * step, 0), width - 1)]
                    gray[row, column] += share * np.float32(
                        77 * np.int32(color[0]) + 150 * np.int32(color[1]) + 29 * np.int32(color[2])
                    )


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
    lattice: NDArray[np.float64],
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
        lanes[:] = 0.0
        for i in range(points):
            value = flat[offsets[i]]
            strong = weights[i] * value if value > threshold else 0.0
            lanes[np.uint32(i) % np.uint32(LANES), numbers[offsets[i]]] += strong
        total = 0.0
        for u in range(count):
            lanes[0, u] += lanes[1, u] + lanes[2, u] + lanes[3, u]
            total += lanes[0, u]
        shift = shifts[n] if total > 0.0 else 0.0
        whole = math.floor(shift)
        part = shift - whole
        scale = 0.25 / total if total > 0.0 else 0.0
        for u in range(count):
            first = (u + whole) % count
            # The triangle at distances 1 + part, part, 1 - part and 2 - part.
            histograms[n, u] = scale * (
                (1.0 - part) * lanes[0, (first - 1) % count]
                + (2.0 - part) * lanes[0, first]
                + (1.0 + part) * lanes[0, (first + 1) % count]
                + part * lanes[0, (first + 2) % count]
            )


@_kernel
def sobel(
    pixels: NDArray[np.uint8],
    left: int,
    top: int,
    threshold: float,
    count: int,
    bins: NDArray[np.uint8],
) -> None:
    """Write the bin of each pixel's edge orientation, `count` where it is no strong edge.

    Ng and Delp, equations 10 to 14; past the border of the image its pixels repeat. The `count`
    bins are of equal width over half a turn, the first one centered on -pi/2, a horizontal edge.
    """
    height, width = bins.shape
    gx, gy = np.empty((height, width), np.float32), np.empty((height, width), np.float32)
    smooth, derivative = np.array([2.0, 1.0], np.float32), np.array([0.0, 1.0], np.float32)
    _gradients(pixels, left, top, 1, smooth, derivative, gx, gy)
    least, wide = np.float32(threshold * threshold), np.float32(count)
    real, imaginary = np.empty(width, np.float32), np.empty(width, np.float32)
    turn = np.empty(width, np.float32)
    for y in range(height):
        u, v, line = gx[y], gy[y], bins[y]
        for x in range(width):  # twice the angle: opposite directions are one
            real[x] = u[x] * u[x] - v[x] * v[x]
            imaginary[x] = np.float32(2.0) * u[x] * v[x]
        _turn(imaginary, real, turn)
        for x in range(width):
            number = np.int32(turn[x] * wide + np.float32(0.5))
            number = number if number < count else np.int32(0)  # half a turn on
            strong = u[x] * u[x] + v[x] * v[x] > least
            line[x] = np.uint8(number if strong else count)


@_kernel
def edge_histograms(
    bins: NDArray[np.uint8],
    left: int,
    top: int,
    ellipses: NDArray[np.float64],
    lattice: NDArray[np.float64],
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
    count = histograms.shape[1] - 1
    lanes = np.empty((LANES, count + 1))
    for n in range(ellipses.shape[0]):
        points = _points(window, ellipses[n], lattice, grid, profile, 1, offsets, weights)
        lanes[:] = 0.0
        for i in range(points):
            lanes[np.uint32(i) % np.uint32(LANES), flat[offsets[i]]] += weights[i]
        total = 0.0
        for u in range(count + 1):
            lanes[0, u] += lanes[1, u] + lanes[2, u] + lanes[3, u]
            total += lanes[0, u] if u < count else 0.0
        for u in range(count):
            histograms[n, u] = lanes[0, u] / total if total > 0.0 else 0.0
        histograms[n, count] = 1.0 if total == 0.0 and lanes[0, count] > 0.0 else 0.0


@_kernel
def values_within(
    plane: NDArray[np.float32],
    left: int,
    top: int,
    ellipse: NDArray[np.float64],
    lattice: NDArray[np.float64],
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


@_kernel
def bounds(ellipses: NDArray[np.float64]) -> tuple[float, float, float, float]:
    """Return the left, top, right and bottom end of what ellipses cover.

    Those with NaN or infinity cover nothing; the left end of nothing is right of its right end.
    """
    left = top = np.inf
    right = bottom = -np.inf
    for n in range(ellipses.shape[0]):
        x, y, a, b = ellipses[n, 0], ellipses[n, 1], ellipses[n, 2], ellipses[n, 3]
        cos, sin = math.cos(ellipses[n, 4]), math.sin(ellipses[n, 4])
        across, down = math.hypot(a * cos, b * sin), math.hypot(a * sin, b * cos)
        if not math.isfinite(x + y + across + down):
            continue
        left, top = min(left, x - across), min(top, y - down)
        right, bottom = max(right, x + across), max(bottom, y + down)
    return left, top, right, bottom


@_kernel
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
            for j in range(5):
                covariance[i, j] += weights[n] * off[i] * off[j]


@_kernel
def mean_shift(
    pixels: NDArray[np.uint8],
    ellipse: NDArray[np.float64],
    lattice: NDArray[np.float64],
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
    table = _channel_table(space, n0, n1, n2)
    window = (0, 0, pixels.shape[1], pixels.shape[0])
    room = _capacity(window, ellipse.reshape(1, 5), lattice)
    offsets, weights = np.empty(room, np.uint32), np.empty(room)
    count = _points(window, ellipse, lattice, grid, EPANECHNIKOV, 3, offsets, weights)
    total, sum_x, sum_y = 0.0, 0.0, 0.0
    for i in range(count):
        if weights[i] > 0.0:
            weight = ratios[_slot(flat, offsets[i], slots, table, space, n0, n1, n2)]
            row, column = divmod(np.int64(offsets[i]) // 3, pixels.shape[1])
            total += weight
            sum_x += weight * column
            sum_y += weight * row
    if total > 0.0:
        center[0] = sum_x / total
        center[1] = sum_y / total


def cache_folder() -> Path | None:
    """Return the folder where compiled kernels are kept, None where there is none."""
    folder = color_distances.stats.cache_path  # type: ignore[attr-defined]
    return Path(folder) if CACHED and folder else None
