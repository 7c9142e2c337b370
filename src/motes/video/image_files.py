"""Image files as frames: each file of a folder, or one image alone."""

from __future__ import annotations

import configparser
import math
import os
import re
from collections import Counter
from collections.abc import Generator, Mapping, Sequence
from functools import cached_property, partial
from itertools import pairwise
from operator import itemgetter
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from motes.core.errors import SourceError, counted
from motes.core.frame import FRAME_INTERVAL
from motes.video.report import Reader, Report, Stamped

IMAGE_ENDINGS = frozenset(
    {".bmp", ".jpeg", ".jpg", ".pgm", ".png", ".pnm", ".ppm", ".tif", ".tiff", ".webp"}
)
INFO = "seqinfo.ini"
"""The file in which the MOTChallenge has the rate of a folder of images."""


class ImageFiles(Reader):
    """Image files, one frame each: the first picture, in the natural order of the names.

    Their rate is `fps`, else that of `rate_in`, else one is assumed: `1 / FRAME_INTERVAL`. Raises a
    SourceError if none of the paths is an image, or the file of the rate has none; while reading,
    at the first one that is damaged.
    """

    def __init__(self, name: str, paths: list[str], fps: float | None) -> None:
        self._paths = sorted(filter(_is_image, paths), key=_natural)
        if not self._paths:
            inner = next((path for path in sorted(paths) if _has_images(path)), None)
            endings = ", ".join(sorted(IMAGE_ENDINGS))
            advice = f"they would end in {endings}" if inner is None else f"try {inner}"
            raise SourceError(f"There are no images in {name}; {advice}.")
        self._folder = os.path.commonpath({os.path.dirname(path) for path in self._paths})
        self.fps = rate_in(self._folder) if fps is None else fps
        self._interval = 1 / self.fps if self.fps else FRAME_INTERVAL
        self.count = len(self._paths)
        self.duration = self.count * self._interval

    def pictures(self, report: Report) -> Generator[Stamped, None, None]:
        """Yield the pictures in order, at the rate of the files."""
        report.assumed, report.leap = self.fps is None, leap(self.files)
        for index, path in enumerate(self._paths):
            yield index * self._interval, partial(self._first_picture, path, report)

    def _first_picture(self, path: str, report: Report) -> NDArray[np.uint8]:
        """Read one image; count the pictures left out of a file with several."""
        from PIL import Image

        from motes.video.animation import picture_numbers, pixels_of, readable, reads_high_bytes

        with readable(path), Image.open(path) as image:
            report.coarse |= reads_high_bytes(image)
            numbers = picture_numbers(image)
            report.left_out += len(numbers) - 1
            image.seek(numbers[0])
            return pixels_of(image, lambda: self._depth, report)

    @cached_property
    def _depth(self) -> int:
        from motes.video.animation import depth_of_pictures

        return depth_of_pictures([(path, 0) for path in self._paths])

    @cached_property
    def files(self) -> list[str]:
        """The paths of the pictures in the folder that holds all of them."""
        start = self._folder or "."
        return [Path(os.path.relpath(path, start)).as_posix() for path in self._paths]


def files_in(path: str) -> list[str]:
    """Return the paths of all that is in a folder; raise a SourceError if it cannot be read."""
    try:
        return [os.path.join(path, name) for name in os.listdir(path)]
    except OSError as error:
        raise SourceError(f"The folder {path} cannot be read: {error.strerror}.") from error


def _is_image(path: str) -> bool:
    """Return whether a path has the ending of an image, and is not hidden."""
    ending = os.path.splitext(path)[1].lower()
    return ending in IMAGE_ENDINGS and not os.path.basename(path).startswith(".")


def _has_images(path: str) -> bool:
    """Return whether a path is a folder with images, as in the layouts of benchmarks."""
    try:
        return any(map(_is_image, os.listdir(path)))
    except OSError:  # as of a file
        return False


def rate_in(folder: str | Path) -> float | None:
    """Return the frames per second in the seqinfo.ini of a folder of images; None without one.

    The file lies in the folder, or beside it and names it, as in the MOTChallenge. Raises a
    SourceError if the file has another number than a rate.
    """
    here = Path(folder).absolute()
    for path, name in ((here / INFO, None), (here.parent / INFO, here.name)):
        if path.is_file():
            section = _sequence(path)
            if name in (None, section.get("imDir", "img1")):
                return _rate(path, section.get("frameRate"))
    return None


def _sequence(path: Path) -> Mapping[str, str]:
    """Return the section Sequence of a seqinfo.ini; empty without one."""
    parser = configparser.ConfigParser(interpolation=None)
    try:
        parser.read_string(path.read_text(encoding="utf-8-sig"))
    except (OSError, UnicodeDecodeError, configparser.Error):
        raise SourceError(f"{path} cannot be read as INI; correct or remove it.") from None
    return parser["Sequence"] if parser.has_section("Sequence") else {}


def _rate(path: Path, text: str | None) -> float | None:
    if text is None:
        return None
    try:
        rate = float(text)
    except ValueError:
        rate = math.nan
    if not 0 < rate < math.inf:
        raise SourceError(f"{path} has frameRate={text}; give frames per second there.")
    return rate


def leap(names: Sequence[str]) -> str | None:
    """Return one line about images in order whose names do not follow each other; None if all do.

    Then some are missing, or they are of several series or channels. Of numbers that have no usual
    step, as a clock's, nothing is known.
    """
    steps = [_step(*pair) for pair in pairwise(names)]
    usual, count = max(Counter(steps).items(), key=itemgetter(1), default=(0, 0))
    known = 2 * count > len(steps)
    leaps = [n for n, step in enumerate(steps) if step is None or (known and step != usual)]
    if not leaps:
        return None
    more = f", and so {counted(len(leaps) - 1, 'time')} more" * (len(leaps) > 1)
    return (
        f"{names[leaps[0] + 1]} comes after {names[leaps[0]]}{more}: all are read as one film, "
        f"whose frames and times have no gap; a pattern in quotes chooses others."
    )


def _step(before: str, after: str) -> int | None:
    """Return by how much a number in a name grows, 0 if not one does; None if the text differs."""
    pairs = [*zip(*(re.split(r"(\d+)", name) for name in (before, after)), strict=False)]
    if any(one != other for one, other in pairs[::2]):
        return None if len(pairs) > 1 else 0  # names without numbers are in no order
    grown = [int(other) - int(one) for one, other in pairs[1::2] if one != other]
    return grown[0] if len(grown) == 1 else 0


def _natural(name: str) -> list[tuple[int, int | str]]:
    parts = re.findall(r"\d+|\D+", name)
    return [(0, int(part)) if part.isdecimal() else (1, part) for part in parts]
