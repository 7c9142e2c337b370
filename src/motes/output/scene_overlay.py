"""The objects of a scene drawn on a frame: identities, trails, lines, zones; heatmap, paths."""

from __future__ import annotations

import colorsys
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motes.core.errors import ConfigError
from motes.core.frame import as_rgb
from motes.core.track import Status, Track, check_listed
from motes.core.types import Bytes, Floats
from motes.mot.analytics.ground_plane import Point
from motes.mot.analytics.regions import Regions
from motes.output.overlay import Color, font, in_font

REGION_COLOR: Color = (255, 255, 255)
PLACES = 5
"""Places of a text, one below the other, of which it takes the first that no other one has."""
GOLDEN_RATIO = 0.618034
"""Step between the hues of successive identities, which keeps recent ones far from each other."""


def color_of(identity: int) -> Color:
    """Return an identity's color, the same in every frame."""
    red, green, blue = colorsys.hsv_to_rgb(identity * GOLDEN_RATIO % 1, 0.75, 1.0)
    return round(255 * red), round(255 * green), round(255 * blue)


def draw_scene(
    pixels: NDArray[Any],
    tracks: Sequence[Track],
    trails: Mapping[int, Sequence[Point]] = {},
    regions: Regions | None = None,
    caption: str | Sequence[object] = (),
    notes: Mapping[int, object] = {},
) -> Bytes:
    """Return a copy of a frame's pixels with a scene drawn on it.

    Parameters
    ----------
    pixels
        RGB uint8 of shape (H, W, 3); not changed.
    tracks
        The objects, drawn as boxes with their identities and classes. An object that is not tracked
        has thin lines and a dark label.
    trails
        The past places of each identity, oldest first; one that is NaN interrupts the line.
    regions
        Lines and zones of the event counter. A stroke from a line shows its first direction. Where
        there are several, each has its name.
    caption
        Text or lines of it in the upper left corner, such as time and totals.
    notes
        Further text beside identities, such as their speeds.

    Raises
    ------
    ConfigError
        If these are no tracks, trails or regions.
    """
    check_listed(tracks)
    if not isinstance(trails, Mapping) or not isinstance(regions, Regions | None):
        raise ConfigError("Give trails as a mapping of identities to places, and lines as Regions.")
    from PIL import Image, ImageDraw

    image = Image.fromarray(as_rgb(pixels))
    pen = ImageDraw.Draw(image, "RGBA")
    line = max(1, round(min(image.size) / 240))
    typeface = font(max(9, round(min(image.size) / 28)))
    shapes: list[tuple[float, ...]] = [each.points for each in regions.line] if regions else []
    shapes += [(*each.points, *each.points[:2]) for each in regions.zone] if regions else []
    for points in shapes:
        pen.line(_rounded(np.array(points)), (*REGION_COLOR, 200), line)
    reach, said = 2 * line, list[tuple[str, int, int]]()
    for name, each_line in regions.lines.items() if regions else ():
        begin, tip = np.array(each_line.stroke)
        pen.line(_rounded(np.array([begin, tip])), (*REGION_COLOR, 200), line)
        column, row = _rounded(tip[None])
        pen.ellipse((column - reach, row - reach, column + reach, row + reach), REGION_COLOR)
        text = f"{name} {each_line.label[0]}" if len(shapes) > 1 else each_line.label[0]
        said.append((text, column + 2 * reach, row))
    for name, zone in regions.zones.items() if regions and len(shapes) > 1 else ():
        column, row = _rounded(np.array(zone.points[:2]))
        said.append((name, column, row))
    for each in tracks:
        color, box = color_of(each.identity), each.box
        for part in stretches(trails.get(each.identity, ())):
            if len(part) > 1:
                pen.line(_rounded(part), (*color, 200), line)
        far = np.add(box[:2], np.maximum(box[2:], 1) - 1)  # a box has a pixel at least
        corners = _rounded(np.array([box[:2], far]))
        pen.rectangle(corners, outline=(*color, 255), width=line if _hidden(each) else 2 * line)
    y, widest = float(line), 0.0
    for text in map(in_font, (caption,) if isinstance(caption, str) else caption):
        _, _, right, bottom = pen.textbbox((0, 0), text, typeface)
        pen.rectangle((line, y, 3 * line + right, y + bottom), (0, 0, 0, 160))
        pen.text((2 * line, y), text, (255, 255, 255), typeface)
        y, widest = y + bottom + line, max(widest, 3 * line + right)
    taken = np.array([(line, line, widest, y)])
    for name, column, row in said:
        text = in_font(name)
        place = _free((column, row), pen.textbbox((0, 0), text, typeface), image.size, taken)
        taken = np.vstack([taken, place])
        pen.rectangle(place, (0, 0, 0, 160))
        pen.text(place[:2], text, REGION_COLOR, typeface)
    for each in sorted(tracks, key=_hidden):  # the labels of those that are seen come first
        color, hidden = color_of(each.identity), _hidden(each)
        number = f"{each.identity}" if each.identity > 0 else ""
        words = number, each.label, notes.get(each.identity), each.status if hidden else None
        text = in_font(" ".join(str(word) for word in words if word not in ("", None)))
        size = pen.textbbox((0, 0), text, typeface)
        left, top = _rounded(np.array([each.box[:2]]))
        place = _free((left, top - line - size[3]), size, image.size, taken)
        taken = np.vstack([taken, place])
        ground = (0, 0, 0, 160) if hidden else (*color, 255)
        pen.rectangle(place, ground)
        pen.text(place[:2], text, color if hidden else (0, 0, 0), typeface)
    return np.array(image)


def stretches(trail: Sequence[Point]) -> list[Floats]:
    """Return the parts of a trail, (n, 2) each, between places that are NaN."""
    try:
        places = np.array(trail, np.float64) if len(trail) else np.empty((0, 2))
    except (TypeError, ValueError):
        places = np.empty(0)
    if places.shape[1:] != (2,):  # boxes would be drawn as twice as many places
        raise ConfigError(f"A trail is a list of places x, y; got {repr(trail)[:80]}.")
    parts = np.split(places, np.flatnonzero(np.isnan(places).any(axis=1)))
    return [part for each in parts if len(part := each[np.isfinite(each).all(axis=1)])]


def _hidden(track: Track) -> bool:
    """Return whether an object is not tracked."""
    return track.status is not Status.TRACKING


def _free(
    start: Point, text: tuple[float, ...], image: tuple[int, int], taken: Floats
) -> tuple[float, float, float, float]:
    """Return the place of a text (left, top, right, bottom), inside the picture.

    It is the first one from the start downwards that meets none of those taken, (n, 4).
    """
    _, _, wide, high = text
    left, top = max(min(start[0], image[0] - wide), 0), max(start[1], 0)
    for _ in range(PLACES):
        top = min(top, image[1] - high)
        place = left, top, left + wide, top + high
        met = ((taken[:, :2] < place[2:]) & (taken[:, 2:] > place[:2])).all(axis=1)
        if not met.any():
            break
        top = max(top + high, taken[met, 3].max() + 1)
    return place


def _rounded(points: Floats) -> list[int]:
    """Return points as whole numbers in a flat list, within Pillow's 32 bits."""
    flat: list[int] = np.rint(points.clip(-1e6, 1e6)).astype(int).ravel().tolist()
    return flat


SPREAD = 0.01
"""Standard deviation of the spot that a foot leaves, as a share of the frame's diagonal."""
DIM = 0.6
"""Share of its brightness that the frame keeps below the paths."""


def heatmap(pixels: Bytes, seconds: Floats) -> Bytes:
    """Return a frame with colors for how long feet have been at each place.

    `seconds` (H, W) is the time for which a foot was at each pixel, over all objects.
    """
    from scipy.ndimage import gaussian_filter

    spread = SPREAD * float(np.hypot(*seconds.shape))
    heat = gaussian_filter(seconds.astype(np.float64), spread)
    share = np.sqrt(heat / heat.max()) if heat.max() > 0 else heat
    # From transparent over yellow to red.
    color = np.stack([np.full_like(share, 255), 255 * (1 - share), np.zeros_like(share)], axis=2)
    opacity = 0.8 * share[:, :, None]
    mixed = (1 - opacity) * as_rgb(pixels) + opacity * color
    heated: Bytes = np.rint(mixed).clip(0, 255).astype(np.uint8)
    return heated


def paths(pixels: Bytes, feet: Mapping[int, Sequence[Point]]) -> Bytes:
    """Return a darkened frame with the path of each identity's foot in its color; a dot ends it.

    A place that is NaN interrupts a path.
    """
    from PIL import Image, ImageDraw

    image = Image.fromarray(np.rint(DIM * as_rgb(pixels)).astype(np.uint8))
    pen = ImageDraw.Draw(image)
    width = max(1, round(min(image.size) / 240))
    for identity, points in feet.items():
        for part in (parts := stretches(points)):
            if len(part) > 1:
                pen.line(part.ravel().tolist(), color_of(identity), width)
        x, y = parts[-1][-1].tolist()
        reach = 2 * width
        pen.ellipse((x - reach, y - reach, x + reach, y + reach), fill=color_of(identity))
    return np.array(image)
