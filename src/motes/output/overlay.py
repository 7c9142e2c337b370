"""Estimates, particles and labels drawn on a frame."""

from __future__ import annotations

import io
import math
from functools import lru_cache
from typing import TYPE_CHECKING, Any
from unicodedata import combining, normalize

import numpy as np
from numpy.typing import ArrayLike, NDArray

from motes.core.errors import ConfigError
from motes.core.frame import as_rgb
from motes.core.track import Status, Track
from motes.core.types import Bytes, Floats

if TYPE_CHECKING:
    from PIL import Image, ImageFont

Color = tuple[int, int, int]

# The palette of Okabe and Ito, whose colors color-blind readers can distinguish.
COLORS: dict[Status, Color] = {
    Status.TRACKING: (86, 180, 233),
    Status.SEARCHING: (230, 159, 0),
    Status.OCCLUDED: (240, 228, 66),
    Status.LOST: (213, 94, 0),
    Status.INTERPOLATED: (204, 121, 167),
    Status.ABSENT: (160, 160, 160),
}
PARTICLE: Color = (255, 110, 205)
CASING_COLOR: Color = (0, 0, 0)
"""Color of the dark edges of a line, which keep it visible on every background."""
SUPERSAMPLING = 2
"""Lines are drawn this many times larger and then averaged, which smooths their edges."""


def draw(
    pixels: NDArray[Any],
    track: Track,
    *,
    particles: ArrayLike | None = None,
    weights: ArrayLike | None = None,
    trail: ArrayLike | None = None,
    label: str | None = None,
) -> Bytes:
    """Return a copy of a frame's pixels with a track drawn on it.

    The estimate is an outline: solid and blue while tracking, dashed and orange while searching,
    dashed and yellow when occluded, dashed and red-brown when lost. Parts outside the frame are
    clipped.

    Parameters
    ----------
    pixels
        RGB uint8 of shape (H, W, 3); not changed.
    track
        The estimate, its status and its confidence.
    particles
        (N, 5) particles x, y, a, b, theta, or only their (N, 2) centers; each becomes a dot.
    weights
        (N,) weights, at least 0: dots of lower weight are fainter. Without them all dots are equal.
    trail
        (M, 2) previous centers, the oldest first and faintest; a center that is not finite
        interrupts the line.
    label
        Text for the upper left corner, above a bar of the confidence. By default the frame's
        number, the status, the confidence and the class; "" for no label.

    Raises
    ------
    ConfigError
        If there is no track, or the particles, the weights or the trail have another shape.
    """
    if not isinstance(track, Track):
        raise ConfigError(
            f"Draw a Track, as Tracker.update returns it; got {type(track).__name__}. draw_scene "
            f"draws those of a Scene."
        )
    from PIL import Image, ImageDraw

    image = Image.fromarray(as_rgb(pixels))
    if track.status is Status.ABSENT:  # there is no ellipse to draw
        if label != "":
            text = label or f"{track.frame}  {track.status}"
            _draw_label(image, text, 0.0, COLORS[Status.ABSENT])
        return np.array(image)
    line = max(1.0, min(image.size) / 240)
    dots, alpha = _dots(particles, weights)
    path = _points(trail, "trail")
    # Ellipse.polygon starts at the end of the half-axis a; each dash covers three of six sides.
    dashes = round(min(max(math.hypot(*track.ellipse[2:4]) / (2 * line), 6), 300))
    outline = np.vstack([track.ellipse.polygon(6 * dashes), track.ellipse.polygon(1)])
    strokes = [outline]
    if track.status != Status.TRACKING:
        strokes = [outline[start : start + 4] for start in range(0, 6 * dashes, 6)]

    low, high = _region(np.concatenate([outline, dots, path]), 3 * line, image.size)
    width, height = (high - low).tolist()
    part = image.crop((*low.tolist(), *high.tolist()))
    part = part.resize((SUPERSAMPLING * width, SUPERSAMPLING * height), Image.Resampling.NEAREST)
    pen = ImageDraw.Draw(part, "RGBA")

    def scaled(points: Floats) -> list[int]:
        # Pillow has 32-bit coordinates; points a million pixels away are not visible anyway.
        inner = SUPERSAMPLING * (points - low) + (SUPERSAMPLING - 1) / 2
        flat: list[int] = np.rint(inner.clip(-1e6, 1e6)).astype(int).ravel().tolist()
        return flat

    color = COLORS[track.status]
    for age, step in enumerate(np.stack([path[:-1], path[1:]], axis=1), start=1):
        if np.isfinite(step).all():
            ink = (*color, round(40 + 180 * age / len(path)))
            pen.line(scaled(step), ink, round(SUPERSAMPLING * line))
    for x, y, opacity in zip(*np.reshape(scaled(dots), (-1, 2)).T.tolist(), alpha, strict=True):
        for radius, hue in ((1.8 * line, CASING_COLOR), (1.2 * line, PARTICLE)):
            reach = SUPERSAMPLING * radius
            pen.ellipse((x - reach, y - reach, x + reach, y + reach), (*hue, opacity))
    for thickness, ink in ((3 * line, (*CASING_COLOR, 255)), (1.5 * line, (*color, 255))):
        for stroke in strokes:
            pen.line(scaled(stroke), ink, round(SUPERSAMPLING * thickness))
    image.paste(part.reduce(SUPERSAMPLING), tuple(low.tolist()))

    if label != "":
        _draw_label(image, label or describe(track), track.confidence, color)
    return np.array(image)


def png(pixels: Bytes) -> bytes:
    """Return a picture as a PNG file."""
    from PIL import Image

    data = io.BytesIO()
    Image.fromarray(pixels).save(data, "PNG")
    return data.getvalue()


def _points(points: ArrayLike | None, name: str) -> Floats:
    """Return the x and y of points, (N, 2)."""
    if points is None or not np.size(points):
        return np.empty((0, 2))
    table = np.asarray(points, np.float64)
    if table.ndim != 2 or table.shape[1] < 2:
        raise ConfigError(
            f"The {name} of an overlay must be rows that start with x, y; got shape {table.shape}."
        )
    return table[:, :2]


def _dots(particles: ArrayLike | None, weights: ArrayLike | None) -> tuple[Floats, list[int]]:
    """Return the centers of finite particles and their opacities, 0 to 255."""
    dots = _points(particles, "particles")
    weight = np.ones(len(dots)) if weights is None else np.asarray(weights, np.float64)
    if weight.shape != (len(dots),):
        raise ConfigError(
            f"An overlay of {len(dots)} particles needs one weight for each; "
            f"got weights of shape {weight.shape}."
        )
    kept = np.isfinite(np.column_stack([dots, weight])).all(axis=1)
    dots, weight = dots[kept], weight[kept]
    share = weight / max(weight.max(initial=0), np.finfo(float).tiny)
    return dots, np.rint(60 + 180 * share).astype(int).tolist()


def _region(
    points: Floats, margin: float, size: tuple[int, int]
) -> tuple[NDArray[np.int_], NDArray[np.int_]]:
    """Return the corners of the part of an image that drawing near the points may change."""
    finite = points[np.isfinite(points).all(axis=1)]
    limit = np.array(size)
    low = np.floor(finite.min(axis=0) - margin).clip(0, limit - 1).astype(int)
    high = np.ceil(finite.max(axis=0) + margin + 1).clip(low + 1, limit).astype(int)
    return low, high


def describe(track: Track, *more: str) -> str:
    """Return what an overlay says of a track: frame, status, confidence, and more words.

    Its class comes last, as it may be longer than the picture is wide.
    """
    words = [f"{track.frame}", f"{track.status}", f"{track.confidence:.2f}", *more]
    if track.label:
        words.append(in_font(track.label))
    return "  ".join(words)


@lru_cache
def font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    """Return Pillow's default font in a size in pixels."""
    from PIL import ImageFont

    return ImageFont.load_default(size)  # cached: loading takes longer than drawing text


def in_font(text: object) -> str:
    """Return a text as Pillow's default font can show it, without accents, which it lacks."""
    return "".join(each for each in normalize("NFD", str(text)) if not combining(each))


def _draw_label(image: Image.Image, text: str, confidence: float, color: Color) -> None:
    """Draw text in the upper left corner, on a dark panel above a bar of the confidence."""
    from PIL import ImageDraw

    size = max(8, round(min(image.width / 40, image.height / 26)))
    typeface = font(size)
    pen = ImageDraw.Draw(image, "RGBA")
    pad = max(2, round(size / 2))
    _, _, right, bottom = pen.textbbox((2 * pad, 1.5 * pad), text, typeface)
    panel = (pad, pad, max(min(right, image.width - 2 * pad), 0) + pad, bottom + 2 * pad)
    pen.rectangle(panel, (0, 0, 0, 165))
    pen.text((2 * pad, 1.5 * pad), text, (255, 255, 255, 255), typeface)
    bar = panel[3] - max(2, round(pad / 2))
    end = panel[0] + (panel[2] - panel[0]) * min(max(confidence, 0), 1)
    pen.rectangle((panel[0], bar, end, panel[3]), (*color, 255))
