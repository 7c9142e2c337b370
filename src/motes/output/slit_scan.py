"""Slit scans: the pixels under a line, frame after frame; each crossing is seen at a glance.

Beside each mark stands what was counted, as it was when it came to the other side of the line.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from motes.core.frame import Frame, as_rgb
from motes.core.geometry import Box
from motes.core.track import Status, Track
from motes.core.types import Bytes
from motes.mot.analytics.ground_plane import Point
from motes.mot.analytics.regions import crossing
from motes.output.overlay import font, in_font

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
SIDE = 96
"""Width and height of the picture of what was counted, in pixels."""
AROUND = 0.75
"""How far such a picture reaches from the object's middle, by the longer side of its box."""
COUNTED, COLUMNS = 2000, 8
"""Largest number of such pictures, of which older ones are left out, and of those side by side."""


class Mark(NamedTuple):
    """A counted crossing: frame, place on the line from 0 to 1, identity, if the second way."""

    frame: int
    place: float
    identity: int
    second: bool


class SlitScan:
    """The pixels under a line in all frames: time downwards, the line across.

    `points` are the line's ends x1, y1, x2, y2, and `names` those of its directions, written below
    with strokes in the colors of their marks.
    """

    def __init__(
        self, points: tuple[float, float, float, float], names: tuple[str, ...] = ()
    ) -> None:
        self._points, self._names = points, names
        self._rows: list[Bytes] = []
        self._times: list[tuple[int, float]] = []
        self._step, self._frames = 1, 0
        self._marks: list[Mark] = []
        self._seen: dict[int, tuple[Point, Bytes]] = {}
        """Where each object was last, and how it looked when it came to that side of the line."""
        self._counted = dict[Mark, Bytes]()

    def add(self, frame: Frame, tracks: Sequence[Track] = ()) -> None:
        """Add a frame, and the objects in it."""
        if self._frames % self._step == 0:
            self._rows.append(self._under(as_rgb(frame.pixels)))
            self._times.append((frame.index, frame.time))
        self._frames += 1
        if len(self._rows) > LONGEST:
            self._rows, self._times = self._rows[::2], self._times[::2]
            self._step *= 2
        before, self._seen = self._seen, {}
        for each in tracks:
            seen, foot = before.get(each.identity), each.box.foot
            if each.status is Status.TRACKING:
                same = seen is not None and not crossing(self._points, seen[0], foot)
                seen = foot, seen[1] if seen and same else _look(frame, each.box)
            if seen is not None:
                self._seen[each.identity] = seen

    def mark(self, frame: int, foot: tuple[float, float], identity: int, *, second: bool) -> None:
        """Mark a crossing, in the first or the second direction of the line."""
        x1, y1, x2, y2 = self._points
        along = (foot[0] - x1) * (x2 - x1) + (foot[1] - y1) * (y2 - y1)
        place = along / ((x2 - x1) ** 2 + (y2 - y1) ** 2)
        mark = Mark(frame, min(max(place, 0.0), 1.0), identity, second)
        self._marks.append(mark)
        if identity in self._seen:
            self._counted[mark] = self._seen[identity][1]
            if len(self._counted) > COUNTED:
                self._counted.pop(next(iter(self._counted)))

    def picture(self) -> Bytes:
        """Return the picture, RGB; at least one frame must have been added."""
        from PIL import Image, ImageDraw

        scan = np.stack(self._rows).repeat(SCALE, axis=0).repeat(SCALE, axis=1)
        across, frames = MARGIN + scan.shape[1], [frame for frame, _ in self._times]
        rows = {mark: SCALE * int(np.searchsorted(frames, mark.frame)) for mark in self._marks}
        looks, ends = list[tuple[Mark, int, int]](), [0] * COLUMNS
        for mark in sorted(self._counted):
            top = max(0, min(rows[mark] - SIDE // 2, scan.shape[0] - SIDE))
            column = next((n for n, end in enumerate(ends) if end <= top), None)
            if column is not None:
                ends[column] = top + SIDE
                looks.append((mark, across + SIDE * column, top))
        height = max(scan.shape[0] + LEGEND * bool(self._names), *ends)
        image = Image.new("RGB", (across + SIDE * np.count_nonzero(ends), height))
        image.paste(Image.fromarray(scan), (MARGIN, 0))
        pen, typeface = ImageDraw.Draw(image), font(11)
        for row in range(0, len(frames), max(1, TICKS // SCALE)):
            seconds = self._times[row][1]
            text = f"{int(seconds // 60)}:{seconds % 60:04.1f}"
            pen.line((MARGIN - 6, SCALE * row, MARGIN, SCALE * row), (255, 255, 255))
            pen.text((2, SCALE * row), text, (255, 255, 255), typeface)
        for row, (name, color) in enumerate(zip(self._names, COLORS, strict=False)):
            y = scan.shape[0] + 4 + 14 * row
            pen.line((4, y + 7, 18, y + 7), color, 3)
            pen.text((24, y), in_font(name), color, typeface)
        for mark in self._marks:
            y = rows[mark]
            x, color = MARGIN + mark.place * (scan.shape[1] - 1), COLORS[mark.second]
            pen.line((MARGIN, y, across - 1, y), color)
            pen.ellipse((x - 5, y - 5, x + 5, y + 5), outline=color, width=2)
            name = str(mark.identity)
            wide = pen.textlength(name, typeface)
            place = x + 8 if x + 8 + wide < across else x - 8 - wide, y + 1
            pen.text(place, name, color, typeface, stroke_width=1, stroke_fill=(0, 0, 0))
        for mark, x, y in reversed(looks):
            color = COLORS[mark.second]
            pen.line((across, rows[mark], x, rows[mark]), color)
            image.paste(Image.fromarray(self._counted[mark]), (x, y))
            pen.rectangle((x, y, x + SIDE - 1, y + SIDE - 1), outline=color)
            text = f"{mark.identity}\nframe {mark.frame}"
            pen.text((x + 4, y + 2), text, color, typeface, stroke_width=1, stroke_fill=(0, 0, 0))
        return np.array(image)

    def _under(self, pixels: Bytes) -> Bytes:
        """Return the pixels under the line, (n, 3); beside the picture they are black."""
        x1, y1, x2, y2 = self._points
        count = round(max(abs(x2 - x1), abs(y2 - y1))) + 1
        x = np.rint(np.linspace(x1, x2, count)).astype(int)
        y = np.rint(np.linspace(y1, y2, count)).astype(int)
        inside = (x >= 0) & (x < pixels.shape[1]) & (y >= 0) & (y < pixels.shape[0])
        out = np.zeros((count, 3), np.uint8)
        out[inside] = pixels[y[inside], x[inside]]
        return out


def _look(frame: Frame, box: Box) -> Bytes:
    """Return an object with what is around it."""
    from PIL import Image

    middle, reach = (box.x + box.width / 2, box.y + box.height / 2), AROUND * max(box[2:])
    extent = *(each - reach for each in middle), *(each + reach for each in middle)
    image = Image.fromarray(np.ascontiguousarray(as_rgb(frame.pixels)))
    seen = image.transform((SIDE, SIDE), Image.Transform.EXTENT, extent, Image.Resampling.BILINEAR)
    return np.array(seen)
