"""The objects of a scene drawn on a frame: identities, trails, lines and zones."""

from __future__ import annotations

import colorsys
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from motes.core.frame import as_rgb
from motes.core.track import Status
from motes.mot.analytics.events import Regions
from motes.mot.tracked_object import SceneTrack
from motes.output.overlay import font

Color = tuple[int, int, int]
Point = tuple[float, float]

PLACE: Color = (255, 255, 255)
GOLDEN = 0.618034
"""Hues a golden section apart: any number of them, the last ones farthest from each other."""


def color_of(identity: int) -> Color:
    """Return an identity's color, the same in every frame."""
    red, green, blue = colorsys.hsv_to_rgb(identity * GOLDEN % 1, 0.75, 1.0)
    return round(255 * red), round(255 * green), round(255 * blue)


def draw_scene(
    pixels: NDArray[np.uint8],
    tracks: Sequence[SceneTrack],
    trails: Mapping[int, Sequence[Point]],
    places: Regions | None = None,
) -> NDArray[np.uint8]:
    """Return a copy of a frame's pixels with a scene drawn on it.

    Parameters
    ----------
    pixels
        RGB uint8 of shape (H, W, 3); left as it is.
    tracks
        Boxes with their identities; thin and without a label's ground where hidden.
    trails
        Each identity's way so far.
    places
        Lines and zones.
    """
    from PIL import Image, ImageDraw

    image = Image.fromarray(as_rgb(pixels))
    pen = ImageDraw.Draw(image, "RGBA")
    line = max(1, round(min(image.size) / 240))
    letters = font(max(9, round(min(image.size) / 28)))
    shapes: list[tuple[float, ...]] = [each.points for each in places.line] if places else []
    shapes += [(*each.points, *each.points[:2]) for each in places.zone] if places else []
    for points in shapes:
        pen.line(_whole(np.array(points)), (*PLACE, 200), line)
    for each in tracks:
        color, hidden = color_of(each.identity), each.track.status is not Status.TRACKING
        way = np.reshape(trails.get(each.identity, ()), (-1, 2))
        if len(way) > 1:
            pen.line(_whole(way), (*color, 200), line)
        box = each.track.box
        corners = _whole(np.array([box[:2], (box.x + box.width - 1, box.y + box.height - 1)]))
        pen.rectangle(corners, outline=(*color, 255), width=line if hidden else 2 * line)
        text = f"{each.identity}" + (f" {each.track.status}" if hidden else "")
        # Inside the frame, whatever the box does.
        _, _, right, bottom = pen.textbbox((0, 0), text, letters)
        x = min(max(corners[0], 0), image.width - right)
        y = min(max(corners[1] - bottom - line, 0), image.height - bottom)
        if not hidden:
            pen.rectangle((x, y, x + right, y + bottom), (*color, 255))
        pen.text((x, y), text, color if hidden else (0, 0, 0), letters)
    drawn: NDArray[np.uint8] = np.array(image)
    return drawn


def _whole(points: NDArray[np.float64]) -> list[int]:
    """Return points as Pillow takes them, in 32 bits."""
    flat: list[int] = np.rint(points.clip(-1e6, 1e6)).astype(int).ravel().tolist()
    return flat
