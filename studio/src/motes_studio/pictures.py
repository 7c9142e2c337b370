"""Pictures of a film for the page, decoded on demand."""

from __future__ import annotations

import io

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from motes_studio.workplace import Workplace

QUALITY = 85
"""Of JPEGs."""
WIDEST = 3840
THUMBNAILS = 200
"""Most thumbnails of a strip."""
SHORT = 2e8
"""Pixels of all pictures of a film that are decoded soon, as it may have one key picture alone."""


def picture(place: Workplace, index: int, width: int) -> bytes:
    """Return a frame as JPEG, at most `width` pixels wide; raise a SourceError if it is damaged."""
    width = max(16, min(width, WIDEST, place.film.width))
    return jpeg(place.seeker.pixels(index), width)


def strip(place: Workplace, count: int, height: int) -> bytes:
    """Return thumbnails side by side, at equal steps; of a long film, the nearest key pictures."""
    film = place.film
    count, height = max(1, min(count, THUMBNAILS)), max(16, min(height, 200))
    last, long = len(film.times) - 1, film.width * film.height * len(film.times) > SHORT
    keys = np.array((long and film.keys) or film.frames)
    width = max(1, round(height * film.width / film.height))
    out = Image.new("RGB", (width * count, height))
    for at, wanted in enumerate(np.linspace(0, last, count)):
        index = int(keys[np.abs(keys - wanted).argmin()])
        thumbnail = Image.fromarray(place.seeker.pixels(index))
        out.paste(thumbnail.resize((width, height)), (at * width, 0))
    return _encoded(out)


def jpeg(pixels: NDArray[np.uint8], width: int) -> bytes:
    """Return a picture as JPEG, of this width."""
    picture = Image.fromarray(pixels)
    if width < picture.width:
        height = max(1, round(width * picture.height / picture.width))
        picture = picture.resize((width, height), Image.Resampling.BILINEAR, reducing_gap=1.5)
    return _encoded(picture)


def _encoded(picture: Image.Image) -> bytes:
    out = io.BytesIO()
    picture.save(out, "JPEG", quality=QUALITY)
    return out.getvalue()
