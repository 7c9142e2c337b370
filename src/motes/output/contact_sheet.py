"""A contact sheet: parts of many frames around a target, in one picture."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from motes.core.track import Status, Track
from motes.core.types import Bytes
from motes.output.overlay import draw, font

TILE, CAPTION, GAP = 220, 38, 6
"""Sides of a tile, height of its text and distance of tiles, in pixels."""
COLUMNS = 5
CONTEXT = 4.0
"""Side of a tile in mean sides of the target."""
PAPER, INK = (255, 255, 255), (40, 40, 40)


def contact_sheet(pictures: Iterable[tuple[Bytes, Track, str]]) -> Bytes:
    """Return a picture (H, W, 3) with a tile for each frame: pixels, track, and up to two lines.

    The target is drawn as in `draw`. A tile shows its surroundings; without a place, all of the
    frame.
    """
    from PIL import Image, ImageDraw

    tiles = []
    for pixels, track, text in pictures:
        tile = Image.new("RGB", (TILE, TILE + CAPTION), PAPER)
        part = Image.fromarray(_around(pixels, track))
        part.thumbnail((TILE, TILE))
        tile.paste(part, ((TILE - part.width) // 2, (TILE - part.height) // 2))
        ImageDraw.Draw(tile).multiline_text((2, TILE + 3), text, INK, font(13), spacing=2)
        tiles.append(tile)
    columns = max(min(COLUMNS, len(tiles)), 1)
    rows = -(-len(tiles) // columns)
    size = columns * (TILE + GAP) + GAP, rows * (TILE + CAPTION + GAP) + GAP
    sheet = Image.new("RGB", size, PAPER)
    for i, tile in enumerate(tiles):
        row, column = divmod(i, columns)
        sheet.paste(tile, (GAP + column * (TILE + GAP), GAP + row * (TILE + CAPTION + GAP)))
    return np.array(sheet)


def _around(pixels: Bytes, track: Track) -> Bytes:
    """Return the part of a frame around a target, with the target drawn on it."""
    height, width = pixels.shape[:2]
    if track.status is Status.ABSENT or not all(map(math.isfinite, track.ellipse)):
        return pixels
    x, y = track.ellipse[:2]
    half = max(CONTEXT * track.ellipse.side / 2, TILE / 4)
    left, top = max(math.floor(x - half), 0), max(math.floor(y - half), 0)
    right, bottom = min(math.ceil(x + half), width), min(math.ceil(y + half), height)
    if right - left < 2 or bottom - top < 2:
        return pixels
    drawn = draw(pixels, track, label="")
    return np.ascontiguousarray(drawn[top:bottom, left:right])
