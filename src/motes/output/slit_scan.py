"""Slit scans: the pixels under a line, frame after frame; each crossing is seen at a glance."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motes.core.frame import as_rgb
from motes.output.overlay import font

Pixels = NDArray[np.uint8]

LONGEST = 8000
"""Largest number of rows: then every other one is left out, and so on."""
SCALE = 2
"""Width and height of a slit's pixel in the picture."""
MARGIN = 60
"""Width of the column with the times, in pixels."""
LEGEND = 34
"""Height of the names of the directions, in pixels."""
TICKS = 50
"""Least distance of two times, in pixels."""
COLORS = (230, 159, 0), (86, 180, 233)
"""Colors of the first and the second direction."""


class SlitScan:
    """The pixels under a line in all frames: time downwards, the line across.

    Parameters
    ----------
    points
        The line's ends: x1, y1, x2, y2.
    names
        The names of its directions, written below with strokes in the colors of their marks.
    """

    def __init__(
        self, points: tuple[float, float, float, float], names: tuple[str, ...] = ()
    ) -> None:
        self._points, self._names = points, names
        self._rows: list[Pixels] = []
        self._times: list[tuple[int, float]] = []
        self._step, self._frames = 1, 0
        self._marks: list[tuple[int, float, int, bool]] = []

    def add(self, pixels: Pixels, frame: int, time: float) -> None:
        """Add a frame (H, W, 3) with its index, and its time in seconds."""
        if self._frames % self._step == 0:
            self._rows.append(self._under(as_rgb(pixels)))
            self._times.append((frame, time))
        self._frames += 1
        if len(self._rows) > LONGEST:
            self._rows, self._times = self._rows[::2], self._times[::2]
            self._step *= 2

    def mark(self, frame: int, foot: tuple[float, float], identity: int, *, second: bool) -> None:
        """Mark a crossing, in the first or the second direction of the line."""
        x1, y1, x2, y2 = self._points
        along = (foot[0] - x1) * (x2 - x1) + (foot[1] - y1) * (y2 - y1)
        place = along / ((x2 - x1) ** 2 + (y2 - y1) ** 2)
        self._marks.append((frame, min(max(place, 0.0), 1.0), identity, second))

    def picture(self) -> Pixels:
        """Return the picture, RGB; at least one frame must have been added."""
        from PIL import Image, ImageDraw

        scan = np.stack(self._rows).repeat(SCALE, axis=0).repeat(SCALE, axis=1)
        height = scan.shape[0] + LEGEND * bool(self._names)
        image = Image.new("RGB", (MARGIN + scan.shape[1], height))
        image.paste(Image.fromarray(scan), (MARGIN, 0))
        pen, typeface = ImageDraw.Draw(image), font(11)
        frames = [frame for frame, _ in self._times]
        for row in range(0, len(frames), max(1, TICKS // SCALE)):
            seconds = self._times[row][1]
            text = f"{int(seconds // 60)}:{seconds % 60:04.1f}"
            pen.line((MARGIN - 6, SCALE * row, MARGIN, SCALE * row), (255, 255, 255))
            pen.text((2, SCALE * row), text, (255, 255, 255), typeface)
        for row, (name, color) in enumerate(zip(self._names, COLORS, strict=False)):
            y = scan.shape[0] + 4 + 14 * row
            pen.line((4, y + 7, 18, y + 7), color, 3)
            pen.text((24, y), name, color, typeface)
        for frame, place, identity, second in self._marks:
            y = SCALE * int(np.searchsorted(frames, frame))
            x, color = MARGIN + place * (scan.shape[1] - 1), COLORS[second]
            pen.line((MARGIN, y, image.width, y), color)
            pen.ellipse((x - 5, y - 5, x + 5, y + 5), outline=color, width=2)
            pen.text((min(x + 8, image.width - 30), y + 1), str(identity), color, typeface)
        return np.array(image)

    def _under(self, pixels: Pixels) -> Pixels:
        """Return the pixels under the line, (n, 3); beside the picture they are black."""
        x1, y1, x2, y2 = self._points
        count = round(max(abs(x2 - x1), abs(y2 - y1))) + 1
        x = np.rint(np.linspace(x1, x2, count)).astype(int)
        y = np.rint(np.linspace(y1, y2, count)).astype(int)
        inside = (x >= 0) & (x < pixels.shape[1]) & (y >= 0) & (y < pixels.shape[0])
        out = np.zeros((count, 3), np.uint8)
        out[inside] = pixels[y[inside], x[inside]]
        return out
