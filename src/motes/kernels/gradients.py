"""Gray values and their derivatives, of a region and at single pixels, and angles.

Filters are given by their taps at 0 … r. Past the border of the image its pixels repeat.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from motes.kernels.compiling import kernel
from motes.kernels.sampling import colors_at


@kernel
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


@kernel
def _every_third(values: NDArray[Any], share: Any, before: int, out: NDArray[np.float32]) -> None:
    """Write every third value times `share`, after `before` copies of the first, then the last."""
    inner = out[before : before + (values.shape[0] + 2) // 3]
    for x in range(inner.shape[0]):
        inner[x] = share * np.float32(np.int32(values[3 * x]))
    left, right = out[:before], out[before + inner.shape[0] :]
    for x in range(left.shape[0]):
        left[x] = inner[0]
    for x in range(right.shape[0]):
        right[x] = inner[inner.shape[0] - 1]


@kernel
def gray_values(pixels: NDArray[np.uint8], left: int, top: int, gray: NDArray[np.float32]) -> None:
    """Write the luma of a region's pixels; past the border of the image its pixels repeat."""
    height, width = pixels.shape[0], pixels.shape[1]
    flat = pixels.reshape(-1)
    first, last = min(max(left, 0), width - 1), max(min(left + gray.shape[1], width), 1)
    luma, share = np.empty(3 * (last - first) - 2, np.uint16), np.float32(1 / 256)
    for row in range(gray.shape[0]):
        y = min(max(top + row, 0), height - 1)
        _luma(flat, 3 * (y * width + first), luma)
        _every_third(luma, share, first - left, gray[row])


@kernel
def _gray_blocks(
    pixels: NDArray[np.uint8], left: int, top: int, step: int, gray: NDArray[np.float32]
) -> None:
    """Write the mean luma of blocks of step x step pixels, as `gray_values` does of pixels."""
    height, width = pixels.shape[0], pixels.shape[1]
    flat, across = pixels.reshape(-1), gray.shape[1] * step
    first, last = min(max(left, 0), width - 1), max(min(left + across, width), 1)
    luma = np.empty(3 * (last - first) - 2, np.uint16)
    sums, line = np.empty(luma.shape[0], np.uint32), np.empty(across, np.float32)
    share = np.float32(1.0 / (256 * step * step))
    for row in range(gray.shape[0]):
        for i in range(sums.shape[0]):
            sums[i] = 0
        for y in range(top + row * step, top + (row + 1) * step):
            _luma(flat, 3 * (min(max(y, 0), height - 1) * width + first), luma)
            for i in range(sums.shape[0]):
                sums[i] += luma[i]
        _every_third(sums, share, first - left, line)
        for column in range(gray.shape[1]):
            total = np.float32(0)
            for x in range(column * step, (column + 1) * step):
                total += line[x]
            gray[row, column] = total


@kernel
def along_rows(
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


@kernel
def along_columns(
    source: NDArray[np.float32], taps: NDArray[np.float32], sign: float, out: NDArray[np.float32]
) -> None:
    """Write the columns of `source` filtered, as `along_rows` does with rows."""
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


@kernel
def derivatives(
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
    if step == 1:
        gray_values(pixels, left - margin, top - margin, gray)
    else:
        _gray_blocks(pixels, left - margin * step, top - margin * step, step, gray)
    rows = np.empty((height + 2 * margin, width), np.float32)
    along_rows(gray, derivative, -1.0, rows)
    along_columns(rows, smooth, 1.0, gx)
    along_rows(gray, smooth, 1.0, rows)
    along_columns(rows, derivative, -1.0, gy)


@kernel
def derivatives_at(
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

    Filters are given by their taps at 0 … r, as `derivatives` takes them; past the border of the
    image its pixels repeat. `room` (2, 2r + 1, n), `offsets` and `colors` are room to work in.
    """
    r, byte, across = smooth.shape[0] - 1, np.uint32(255), np.float64(width)
    columns, rows = room[0], room[1]
    line, last, bottom = np.int32(3 * width), np.int32(width - 1), np.int32(height - 1)
    for i in range(places.shape[0]):  # by division in double precision, which is exact
        rows[r, i] = np.int32(np.float64(places[i]) / across)
        columns[r, i] = np.int32(np.int32(places[i]) - np.int32(rows[r, i] * np.int32(width)))
        gx[i], gy[i] = np.float32(0), np.float32(0)
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
            colors_at(flat, offsets, places.shape[0], colors)
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


@kernel
def turns(y: NDArray[np.float32], x: NDArray[np.float32], out: NDArray[np.float32]) -> None:
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
