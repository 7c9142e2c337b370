"""The truth of one target: of OTB, `groundtruth_rect.txt`, and of others, `groundtruth.txt`.

There is a line for each frame from the first one on. OTB's is a box x,y,width,height; pixels count
from 1, and a frame without the target has a box without size, as in the later sequences. Wu, Lim
and Yang, Object tracking benchmark, PAMI 2015. VOT's is such a box, or the four corners of a
rotated one; pixels count from 0, and a frame without the target has NaN. Kristan et al., A novel
performance evaluation methodology for single-target trackers, PAMI 2016. motes writes corners
alone, as boxes do not tell the first pixel.

LaSOT's and GOT-10k's are boxes whose pixels count from 1; files beside them mark the frames without
the target. Fan et al., LaSOT, CVPR 2019; Huang, Zhao and Huang, GOT-10k, PAMI 2021.

Each region becomes a box and an ellipse in the coordinates of `motes.core.geometry`, except for the
number of the first pixel, which the text does not contain. The corners of a polygon lie on the
outline: a box x, y, width, height has the corners x, y to x + width, y + height. A box therefore
gives the same region written as a box or as a polygon, as in the polygons and boxes that VOT
published for the same frames.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from motes.core.errors import FormatError, counted
from motes.core.files import check_ended, lines_of, read_text
from motes.core.geometry import Box, Ellipse
from motes.core.track import Track
from motes.formats.recording import UNTIMED, FilmFacts, Recording, sound
from motes.formats.text import any_number, at, fields_of

Kind = Literal["otb", "vot", "lasot", "got10k"]

FIRST_PIXEL = {"otb": 1, "vot": 0, "lasot": 1, "got10k": 1}
ABSENCES: dict[str, Sequence[str]] = {
    "lasot": ("full_occlusion.txt", "out_of_view.txt"), "got10k": ("absence.label",),
}  # fmt: skip
"""Files beside the truth with a 1 for each frame in which the target cannot be seen."""
MARKS: dict[Kind, Sequence[str]] = {
    "lasot": ABSENCES["lasot"],
    "got10k": ("absence.label", "meta_info.ini", "cover.label", "cut_by_image.label"),
    "vot": ("color", "sequence", "camera_motion.tag", "camera_motion.label"),
}
"""What lies beside a `groundtruth.txt` of each dataset."""
NOWHERE = {"otb": "0,0,0,0", "vot": "nan,nan,nan,nan"}


def write(kind: Kind, recorded: Recording) -> Iterator[bytes]:
    """Yield a line for each frame; raise a FormatError if there are several objects."""
    here = recorded.only_object(kind.upper())
    last = max((row.frame for row in recorded), default=-1)
    for frame in range(max(last + 1, recorded.length)):
        line = _line(kind, here[frame]) if frame in here else NOWHERE[kind]
        yield line.encode() + b"\n"


def _line(kind: Kind, each: Track) -> str:
    if kind == "otb":
        x, y, width, height = each.box
        return f"{x + 1:.2f},{y + 1:.2f},{width:.2f},{height:.2f}"
    x, y, a, b, theta = each.ellipse
    cos, sin = math.cos(theta), math.sin(theta)
    corners = [
        (x + 0.5 + u * a * cos - v * b * sin, y + 0.5 + u * a * sin + v * b * cos)
        for u, v in ((-1, -1), (1, -1), (1, 1), (-1, 1))
    ]
    return ",".join(f"{value:.4f}" for corner in corners for value in corner)


def kind_of(path: Path) -> Kind | None:
    """Return the dataset of a `groundtruth.txt` by what lies beside it; None without a mark."""
    found = (
        kind for kind, marks in MARKS.items() if any((path.parent / m).exists() for m in marks)
    )
    return next(found, None)


def absences(kind: str, folder: Path, count: int) -> list[bool]:
    """Return whether each frame of a truth is marked as one without the target.

    Raises a FormatError if a file of marks has another number of frames, or other words than 0 and
    1.
    """
    absent = [False] * count
    for name in ABSENCES.get(kind, ()):
        if (folder / name).is_file():
            words = read_text(folder / name, FormatError).replace(",", " ").split()
            if len(words) != count:
                raise FormatError(f"{name} is for {len(words)} frames, not {count}")
            if other := next((word for word in words if word not in ("0", "1")), None):
                raise FormatError(f"{name} has {other[:20]!r}, neither 0 nor 1")
            absent = [one or word == "1" for one, word in zip(absent, words, strict=True)]
    return absent


def read(kind: Kind, path: Path, facts: FilmFacts) -> Recording:
    """Return the target of a truth; masks become ellipses and boxes."""
    text = read_text(path, FormatError)
    check_ended(text)
    # Others have boxes of any size where the target is absent.
    regions, first = read_regions(text, strict=kind in ("otb", "vot")), FIRST_PIXEL[kind]
    if kind != "vot" and not all(region.is_box for region in regions):
        raise FormatError("a line has more than the four numbers of a box; of VOT, give --from vot")
    absent = absences(kind, path.parent, len(regions))
    objects = []
    for frame, region in enumerate(regions):
        if not (region is ABSENT or region is UNKNOWN or absent[frame]):
            x, y, *rest = region.ellipse
            ellipse = Ellipse(x - first, y - first, *rest)
            x, y, *sides = region.box
            bounds = Box(x - first, y - first, *sides)
            objects.append(sound(Track(frame, UNTIMED, ellipse, bounds=bounds)))
    masks = sum(line.lstrip().startswith("m") for line in lines_of(text))
    left_out = [f"the pixels of {counted(masks, 'mask')}, but for box and ellipse"] * bool(masks)
    times = dict.fromkeys(range(len(regions)))
    unknown = [(frame, 1) for frame, region in enumerate(regions) if region is UNKNOWN]
    return Recording.of(facts, objects, times, left_out=left_out, searched=unknown)


class TruthRegion(NamedTuple):
    """A target in one frame."""

    box: Box
    """The smallest box around it."""
    ellipse: Ellipse
    """For a box, the inscribed ellipse. For a polygon of four corners, the ellipse inscribed in the
    rectangle with the polygon's center, area, orientation and ratio of second moments. For other
    polygons and masks, the ellipse with their center and second moments."""
    is_box: bool = False
    """Whether the annotation is only a box."""

    @classmethod
    def of_pixels(cls, x: NDArray[np.int64], y: NDArray[np.int64]) -> TruthRegion:
        """Return the region of pixels, of their columns and rows (n,)."""
        if not x.size:
            return ABSENT
        low = float(x.min()), float(y.min())
        box = Box(*low, float(x.max()) - low[0] + 1, float(y.max()) - low[1] + 1)
        (xx, xy), (_, yy) = np.cov(x, y, bias=True)
        # Each pixel is a square, which adds its own second moment, 1/12.
        center, moments = (float(x.mean()), float(y.mean())), (xx + 1 / 12, xy, yy + 1 / 12)
        return cls(box, _ellipse_of_moments(center, moments, scale=2))


_NAN = math.nan
ABSENT = TruthRegion(Box(*[_NAN] * 4), Ellipse(*[_NAN] * 5), is_box=True)
"""The frame has no target."""
UNKNOWN = TruthRegion(*ABSENT)
"""It is not told where the target is, as where a tracker began or has lost it."""


def read_regions(text: str, *, strict: bool = False) -> list[TruthRegion]:
    """Return the regions of a text, one for each frame.

    Each row is a frame, in order, with the fields of `fields_of`.
    A row is one of:

    - a box x, y, width, height;
    - a polygon x, y, x, y … of at least four corners;
    - a mask in VOT's form, `m x, y, width, height, runs …`: runs of pixels in the box, row by row,
      alternately outside and inside the target;
    - no target: NaN alone, a box or polygon without width or height, an empty mask, or VOT's code
      0;
    - an unknown place: VOT's codes of results, 1 where the tracker began, 2 where it has failed.

    Empty lines are skipped. Raises a FormatError if a line has another format, with its number. If
    `strict`, a box with a negative side is an error, instead of no target.
    """
    regions = []
    for number, line in enumerate(lines_of(text), 1):
        if line.strip():
            with at(f"line {number}"):
                regions.append(_parse_row(line.strip(), strict))
    return regions


def _parse_row(row: str, strict: bool) -> TruthRegion:
    mask = row.startswith("m")
    values = [any_number(field) for field in fields_of(row.lstrip("m").strip(" \t,;"))]
    if all(math.isnan(value) for value in values):
        return ABSENT
    if not all(math.isfinite(value) for value in values):
        raise ValueError("the numbers must be finite")
    if mask:
        return _region_of_runs(values)
    if len(values) == 4:
        box = Box(*values)
        if strict and min(box.width, box.height) < 0:
            raise ValueError(f"a box of {box.width:g}x{box.height:g} pixels has a negative side")
        present = box.width > 0 and box.height > 0
        return TruthRegion(box, Ellipse.from_box(box), is_box=True) if present else ABSENT
    if len(values) >= 8 and len(values) % 2 == 0:
        return region_of_corners(np.reshape(values, (-1, 2)))
    if len(values) == 1 and values[0] in (0, 1, 2):
        return UNKNOWN if values[0] else ABSENT
    raise ValueError(
        f"a row has 4 numbers (x, y, width, height) or the 8 and more of a polygon, "
        f"not {len(values)}"
    )


def _region_of_runs(values: list[float]) -> TruthRegion:
    if len(values) < 4 or any(value != int(value) for value in values):
        raise ValueError("a mask is x, y, width, height and runs, all whole numbers")
    x, y, width, height, *runs = map(int, values)
    if min(width, height, *runs) < 0 or sum(runs) > width * height:
        raise ValueError(f"the mask's runs do not fit into its {width}x{height} pixels")
    inside = np.flatnonzero(np.repeat(np.arange(len(runs)) % 2, runs))
    if not inside.size:
        return ABSENT
    return TruthRegion.of_pixels(x + inside % width, y + inside // width)


def region_of_corners(corners: NDArray[np.float64]) -> TruthRegion:
    """Return the region of a polygon of corners (n, 2) on its outline, in order.

    Raises a ValueError if it has no area, or crosses itself.
    """
    low, high = corners.min(axis=0), corners.max(axis=0)
    if (low == high).any():
        return ABSENT
    middle = (low + high) / 2  # moments far from the origin would lose digits
    (x, y), (u, v) = (corners - middle).T, (np.roll(corners, -1, axis=0) - middle).T
    # Integrals over the area are sums over the edges (Green), made positive for both directions.
    cross = x * v - u * y
    cross *= np.copysign(1, cross.sum())
    area = cross.sum() / 2
    if area > 0:
        mx, my = (cross * (x + u)).sum() / (6 * area), (cross * (y + v)).sum() / (6 * area)
        xx = (cross * (x * x + x * u + u * u)).sum() / (12 * area) - mx * mx
        yy = (cross * (y * y + y * v + v * v)).sum() / (12 * area) - my * my
        xy = (cross * (x * v + 2 * x * y + 2 * u * v + u * y)).sum() / (24 * area) - mx * my
        determinant = xx * yy - xy * xy
    if area <= 0 or determinant <= 0:
        raise ValueError("the polygon has no area, or crosses itself")
    # The second moments of an ellipse are a²/4, those of a rectangle with half sides a are a²/3.
    # For four corners the scale is sqrt(3) if they are a rectangle; otherwise it keeps the area.
    scale = math.sqrt(area / 4 / math.sqrt(determinant)) if len(corners) == 4 else 2.0
    # Coordinates of the outline are half a pixel larger than those of pixel centers.
    center = float(middle[0] + mx - 0.5), float(middle[1] + my - 0.5)
    box = Box(*low.tolist(), *(high - low).tolist())
    return TruthRegion(box, _ellipse_of_moments(center, (float(xx), float(xy), float(yy)), scale))


def _ellipse_of_moments(
    center: tuple[float, float], moments: tuple[float, float, float], scale: float
) -> Ellipse:
    """Return the ellipse with half-axes of `scale` standard deviations (xx, xy, yy).

    Its `a` is the axis within 45 degrees of x, so upright regions have the angle 0.
    """
    xx, xy, yy = moments
    theta = math.atan2(math.copysign(2, xx - yy) * xy, abs(xx - yy)) / 2
    cos, sin = math.cos(theta), math.sin(theta)
    along = xx * cos * cos + 2 * xy * cos * sin + yy * sin * sin
    across = xx * sin * sin - 2 * xy * cos * sin + yy * cos * cos
    return Ellipse(*center, scale * math.sqrt(along), scale * math.sqrt(across), theta)
