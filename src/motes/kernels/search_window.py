"""A window of fixed samples cut from a picture, and its cells of gradients."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from motes.kernels.compiling import unordered


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
    # Not itself a loop: so what is turned is compiled only where something is.
    if across[1] == 0.0 and down[0] == 0.0:
        _cut_upright(pixels, corner, (across[0], down[1]), out)
    else:
        _cut_turned(pixels, corner, across, down, out)


@unordered
def _cut_turned(
    pixels: NDArray[np.uint8],
    corner: tuple[float, float],
    across: tuple[float, float],
    down: tuple[float, float],
    out: NDArray[np.float32],
) -> None:
    """Do as `cut` does with samples along any two directions."""
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


@unordered
def _cut_between(
    pixels: NDArray[np.uint8],
    corner: tuple[float, float],
    across: tuple[float, float],
    down: tuple[float, float],
    out: NDArray[np.float32],
) -> None:
    """Do as `_cut_turned` does with samples between pixels."""
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


@unordered
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


@unordered
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


@unordered
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


@unordered
def _vote(
    samples: NDArray[np.float32],
    cell: int,
    sectors: NDArray[np.uint8],
    votes: NDArray[np.float32],
) -> None:
    """Write the votes of samples' gradients, each for the four cells (h + 2, 18 (w + 2)) around."""
    height, width = samples.shape[1], samples.shape[2]
    bright, magnitude = np.empty((height + 2, width + 2), np.float32), np.empty(width, np.float32)
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
    _brightness(samples, bright)
    for i in range(height):
        before, here, after = bright[i], bright[i + 1], bright[i + 2]
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


@unordered
def _brightness(samples: NDArray[np.float32], out: NDArray[np.float32]) -> None:
    """Write R + G + B of samples (H + 2, W + 2), those at the border twice."""
    height, width = samples.shape[1], samples.shape[2]
    for i in range(height + 2):
        row, line = min(max(i - 1, 0), height - 1), out[i]
        red, green, blue, inner = samples[0, row], samples[1, row], samples[2, row], line[1:]
        for j in range(width):
            inner[j] = red[j] + green[j] + blue[j]
        line[0], line[width + 1] = line[1], line[width]
