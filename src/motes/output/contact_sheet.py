"""A contact sheet: parts of many frames around a target, in one picture."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
from msgspec.structs import replace

from motes.core.geometry import Ellipse
from motes.core.track import Status, Track
from motes.core.types import Bytes
from motes.output.overlay import draw, font

if TYPE_CHECKING:
    from PIL import Image

TILE, LINE, GAP = 220, 17, 6
"""Sides of a tile, height of a line of its text and distance of tiles, in pixels."""
LEAST_LINES = 2
"""Lines that a tile's text has room for; there are more if a text needs them."""
COLUMNS = 5
CONTEXT = 4.0
"""Side of a tile in mean sides of the target."""
PAPER, INK = (255, 255, 255), (40, 40, 40)


def contact_sheet(pictures: Iterable[tuple[Bytes, Track, str]]) -> Bytes:
    """Return a picture (H, W, 3) with a tile for each frame: pixels, track, and a text.

    The target is drawn as in `draw`. A tile shows its surroundings, as large as fits; without a
    place, all of the frame. Long lines of a text are broken between its words.
    """
    from PIL import Image, ImageDraw

    parts, texts = [], []
    for pixels, track, text in pictures:
        parts.append(_around(pixels, track))
        texts.append(broken(text))
    caption = LINE * max([LEAST_LINES, *map(len, texts)]) + 4
    tiles = []
    for part, lines in zip(parts, texts, strict=True):
        tile = Image.new("RGB", (TILE, TILE + caption), PAPER)
        tile.paste(part, ((TILE - part.width) // 2, (TILE - part.height) // 2))
        text = "\n".join(lines)
        ImageDraw.Draw(tile).multiline_text((2, TILE + 3), text, INK, font(13), spacing=2)
        tiles.append(tile)
    columns = max(min(COLUMNS, len(tiles)), 1)
    rows = -(-len(tiles) // columns)
    size = columns * (TILE + GAP) + GAP, rows * (TILE + caption + GAP) + GAP
    sheet = Image.new("RGB", size, PAPER)
    for i, tile in enumerate(tiles):
        row, column = divmod(i, columns)
        sheet.paste(tile, (GAP + column * (TILE + GAP), GAP + row * (TILE + caption + GAP)))
    return np.array(sheet)


def broken(text: str) -> list[str]:
    """Return the lines of a text, broken between words so that each fits on a tile."""
    lines = []
    for long in text.split("\n"):
        line = ""
        for word in long.split():
            longer = f"{line} {word}".strip()
            if line and font(13).getlength(longer) > TILE - 4:
                lines.append(line)
                longer = word
            line = longer
        lines.append(line)
    return lines


def _around(pixels: Bytes, track: Track) -> Image.Image:
    """Return a tile's picture: the part of a frame around a target, with the target drawn on it."""
    from PIL import Image

    height, width = pixels.shape[:2]
    if track.status is Status.ABSENT or not all(map(math.isfinite, track.ellipse)):
        return _fitted(Image.fromarray(pixels))
    x, y, a, b, _ = track.ellipse
    half = CONTEXT * track.ellipse.side / 2
    left, top = max(math.floor(x - half), 0), max(math.floor(y - half), 0)
    right, bottom = min(math.ceil(x + half), width), min(math.ceil(y + half), height)
    if right - left < 2 or bottom - top < 2:
        return _fitted(Image.fromarray(pixels))
    part = _fitted(Image.fromarray(pixels[top:bottom, left:right]))
    scale = part.width / (right - left)
    center = scale * (x - left + 0.5) - 0.5, scale * (y - top + 0.5) - 0.5
    ellipse = Ellipse(*center, scale * a, scale * b, track.ellipse.theta)
    return Image.fromarray(draw(np.array(part), replace(track, ellipse=ellipse), label=""))


def _fitted(part: Image.Image) -> Image.Image:
    """Return a picture as large as fits on a tile."""
    scale = TILE / max(part.size)
    width, height = (max(round(scale * side), 1) for side in part.size)
    return part.resize((width, height))
