"""An image file with one picture or several: animated PNG, WebP and GIF, TIFF with pages.

Pillow composes each complete picture of an animation and gives the time for which it is shown.
"""

from __future__ import annotations

import contextlib
import re
import warnings
from collections.abc import Callable, Generator, Iterator, Sequence
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageOps

from motes.core.errors import MotesError, SourceError, counted
from motes.core.frame import FRAME_INTERVAL, as_rgb, depth_of
from motes.video.report import DEPTH_SAMPLES, Reader, Report, Stamped

# Not MPO, the JPEG of many phones: its other pictures show the same moment as the first.
ANIMATED = frozenset({"GIF", "PNG", "WEBP"})

_ABOUT = 270
_SIZE = re.compile(r'(?:^(channels|slices|frames)=|\bSize([CZT])=")(\d+)', re.MULTILINE)
"""The TIFF tag ImageDescription, and the numbers of channels, depths and times in it, by ImageJ and
OME. Where there are several of two kinds, pages take turns."""
_INTERVAL = re.compile(r'(?:^finterval=|\bTimeIncrement=")(\d+\.?\d*(?:[eE][+-]?\d\d?)?)\b', re.M)
_NO_SECONDS = re.compile(r'(?:^tunit=|\bTimeIncrementUnit=")(?!s(?:ec)?\b)', re.M)
"""There, too: the time from one page to the next, and a unit of it that is not the usual one."""
_SUBFILE = 254
_REDUCED_OR_MASK = 0b101
"""The TIFF tag NewSubfileType, and its bits for reduced copies and masks of another page."""


class Animation(Reader):
    """The pictures of one image file, at the times in the file.

    Pages of a TIFF are as far apart as ImageJ or OME says there, else 1/25 s.

    Raises a SourceError when it is opened, if the file is missing or not an image. Later, at the
    first picture that cannot be read.
    """

    def __init__(self, path: str) -> None:
        self._path = path
        with readable(path), contextlib.ExitStack() as opened:
            self._image = opened.enter_context(Image.open(path))
            about = str(getattr(self._image, "tag_v2", {}).get(_ABOUT))
            self._coarse = reads_high_bytes(self._image)
            self._numbers = picture_numbers(self._image)
            self.count = len(self._numbers)
            sizes = {a or b: int(n) for a, b, n in _SIZE.findall(about)}
            most = max((n for name, n in sizes.items() if name not in ("channels", "C")), default=1)
            if sizes and self.count > most:
                raise SourceError(
                    f"{path} has {self.count} pictures of {counted(most, 'moment')}: its channels "
                    f"or depths take turns; save one of them alone."
                )
            told = None if _NO_SECONDS.search(about) else _INTERVAL.search(about)
            self._interval = (float(told[1]) or None) if told else None
            timed = self._image.format in ANIMATED and len(self._numbers) > 1
            # The times of an animation are read together with its pictures.
            self.duration = None if timed else self.count * (self._interval or FRAME_INTERVAL)
            shown = self._show(self._numbers[0]) if timed else self._interval
            self.fps = 1 / shown if shown else None
            opened.pop_all()

    @property
    def files(self) -> Sequence[str]:
        """The name of a still image; none of an animation, whose pictures share a file."""
        return [Path(self._path).name] * (self.count == 1)

    def pictures(self, report: Report) -> Generator[Stamped, None, None]:
        """Yield the pictures in order."""
        moment = 0.0
        report.coarse = self._coarse
        untimed = self._interval is None and self._image.format not in ANIMATED
        report.assumed = untimed and len(self._numbers) > 1
        for index, number in enumerate(self._numbers):
            with readable(self._path, index):
                shown = self._show(number)
            yield moment, partial(self._pixels, index, report)
            moment += shown

    def _show(self, number: int) -> float:
        """Go to a picture; return for how many seconds it is shown."""
        self._image.seek(number)
        if self._image.format not in ANIMATED:
            return self._interval or FRAME_INTERVAL
        self._image.load()  # the time is known only after this
        return float(self._image.info.get("duration", 0)) / 1000

    def _pixels(self, index: int, report: Report) -> NDArray[np.uint8]:
        with readable(self._path, index):
            return pixels_of(self._image, lambda: self._film_depth, report)

    @cached_property
    def _film_depth(self) -> int:
        return depth_of_pictures([(self._path, number) for number in self._numbers])

    def close(self) -> None:
        """Close the file."""
        self._image.close()


def picture_numbers(image: Image.Image) -> list[int]:
    """Return the numbers of the pictures in an image file that are frames, in order."""
    count = getattr(image, "n_frames", 1)
    if image.format in ANIMATED:
        # A PNG may begin with a picture for programs that do not know animations.
        return list(range(int(image.info.get("default_image", False)), count))
    if image.format == "TIFF" and count > 1:
        pages = [number for number in range(count) if not _page_kind(image, number)]
        image.seek(0)
        return pages or [0]
    return [0]


def _page_kind(image: Image.Image, number: int) -> int:
    """Return 0 for an ordinary TIFF page, else the bits of a reduced copy or a mask."""
    image.seek(number)
    return int(image.tag_v2.get(_SUBFILE, 0)) & _REDUCED_OR_MASK  # type: ignore[attr-defined]


def pixels_of(
    image: Image.Image, depth: Callable[[], int] | None = None, report: Report | None = None
) -> NDArray[np.uint8]:
    """Return an open image, upright, as RGB uint8 of shape (height, width, 3), in C order.

    `depth` returns the bits that the film uses of 16; by default those that this image needs.
    """
    values = values_of(ImageOps.exif_transpose(image))
    used = depth() if depth is not None and values.dtype == np.uint16 else None
    if used is not None and report is not None:
        report.count_depth(values, used)
    return np.require(as_rgb(values, used), requirements=["C", "W"])


def reads_high_bytes(image: Image.Image) -> bool:
    """Return whether an image that is not loaded has colors of 16 bits, of which Pillow reads 8."""
    return image.mode in ("RGB", "RGBA") and ";16" in str(getattr(image, "tile", ""))


def values_of(image: Image.Image) -> NDArray[Any]:
    """Return the values of an open image, in uint16 where it has 16 bits of gray."""
    if image.mode.startswith("I"):  # 16 bits of gray, perhaps in 32
        values = np.asarray(image)
        least, most = int(values.min()), int(values.max())
        if least < 0 or most > 65535:
            raise SourceError(f"its values go from {least} to {most}; scale them to 0 to 65535.")
        return values.astype(np.uint16)
    # Through RGBA: RGB has no room for the transparency of a palette.
    return np.asarray(image if image.mode in ("RGB", "F") else image.convert("RGBA"))


def depth_of_pictures(pictures: Sequence[tuple[str, int]]) -> int:
    """Return the bits that pictures use, by some of them: pairs of a file and a number in it."""
    places = {round(i) for i in np.linspace(0, len(pictures) - 1, DEPTH_SAMPLES)}
    found = 0
    for path, number in (pictures[place] for place in sorted(places)):
        with readable(path, number), Image.open(path) as image:
            image.seek(number)
            values = values_of(image)
            found = max(found, depth_of(values) if values.dtype == np.uint16 else 0)
    return found


@contextlib.contextmanager
def readable(path: str | Path, index: int = 0) -> Iterator[None]:
    """Turn any error raised while an image is read into a SourceError of one line."""
    what = f"Picture {index} of {path}" if index else f"The image {path}"
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # warnings of large pictures and odd metadata
            yield
    except FileNotFoundError:
        raise SourceError(f"There is no image {path}; check the name.") from None
    except MotesError as error:
        if str(path) in str(error):
            raise
        raise SourceError(f"{what}: {error}") from None  # its values are none of a picture
    except Image.DecompressionBombError:
        most = 2 * (Image.MAX_IMAGE_PIXELS or 0)
        raise SourceError(f"{what} is too large: more than {most} pixels; scale it down.") from None
    except Exception as error:  # decoders of damaged images raise errors of many kinds
        reason = getattr(error, "strerror", None) or "damaged, or not an image"
        advice = "choose an end before that" if index else "replace it"
        raise SourceError(f"{what} cannot be read: {reason}; {advice}.") from error
