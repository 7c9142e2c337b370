"""Image files, and those that hold several pictures: animated PNG, WebP and GIF, pages of a TIFF.

Pillow composes each picture of an animation whole, and tells how long it is shown.
"""

from __future__ import annotations

import contextlib
import warnings
from collections.abc import Generator, Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageOps

from motes.core.errors import MotesError, SourceError
from motes.core.frame import FRAME_INTERVAL, as_rgb

if TYPE_CHECKING:
    from motes.video.decoder import Report, Stamped

# Not MPO, the JPEG of many phones: what follows its first picture shows the same moment again.
ANIMATED = frozenset({"GIF", "PNG", "WEBP"})

_SUBFILE = 254
_REDUCED_OR_MASK = 0b101
"""A TIFF's tag of what a page is, and its bits for pages that belong to another page."""


class Animation:
    """The pictures of one image file, at the times that it gives; pages are 1/25 s apart.

    Attributes
    ----------
    fps
        By how long the first picture is shown.
    duration
        Seconds; None for an animation, whose later times come with its pictures.
    count
        How many pictures there are; 1 for a still image.

    Raises
    ------
    SourceError
        Here, if the file is missing or not an image; later, at the first picture that cannot be
        read.
    """

    live = False

    def __init__(self, path: str) -> None:
        self._path = path
        with readable(path), contextlib.ExitStack() as opened:
            self._image = opened.enter_context(Image.open(path))
            self._numbers = picture_numbers(self._image)
            self.count = len(self._numbers)
            timed = self._image.format in ANIMATED and self.count > 1
            self.duration = None if timed else self.count * FRAME_INTERVAL
            self.fps: float | None = 1 / (self._show(self._numbers[0]) or FRAME_INTERVAL)
            opened.pop_all()

    def pictures(self, report: Report) -> Generator[Stamped, None, None]:
        """Yield the pictures in order."""
        moment = 0.0
        for index, number in enumerate(self._numbers):
            with readable(self._path, index):
                shown = self._show(number)
            yield moment, partial(self._pixels, index)
            moment += shown

    def _show(self, number: int) -> float:
        """Turn to a picture; return for how many seconds it is shown."""
        self._image.seek(number)
        if self._image.format not in ANIMATED:
            return FRAME_INTERVAL
        self._image.load()  # only then is the time known
        return float(self._image.info.get("duration", 0)) / 1000

    def _pixels(self, index: int) -> NDArray[np.uint8]:
        with readable(self._path, index):
            return pixels_of(self._image)

    def file_of(self, index: int) -> str | None:
        """Return the name of a still image; None for an animation, whose pictures share a file."""
        return Path(self._path).name if self.count == 1 else None

    def close(self) -> None:
        """Let go of the file."""
        self._image.close()


def picture_numbers(image: Image.Image) -> list[int]:
    """Return the numbers of the pictures in an image file that follow each other."""
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
    """Return what a TIFF's page is: 0, or the reduced picture or the mask of another page."""
    image.seek(number)
    return int(image.tag_v2.get(_SUBFILE, 0)) & _REDUCED_OR_MASK  # type: ignore[attr-defined]


def pixels_of(image: Image.Image) -> NDArray[np.uint8]:
    """Return an open image, upright, as RGB uint8 of shape (height, width, 3)."""
    image = ImageOps.exif_transpose(image)
    if image.mode.startswith("I;16"):
        return as_rgb(np.asarray(image).astype(np.uint16))
    if image.mode == "I":  # 16 bits of gray in 32
        return as_rgb(np.asarray(image).clip(0, 65535).astype(np.uint16))
    if image.mode in ("RGB", "F"):
        return as_rgb(np.asarray(image))
    # By way of RGBA, as the transparency of a palette has nowhere to go in RGB.
    return as_rgb(np.asarray(image.convert("RGBA")))


@contextlib.contextmanager
def readable(path: str | Path, index: int = 0) -> Iterator[None]:
    """Raise a SourceError in one line for whatever reading an image raises.

    Parameters
    ----------
    path
        The image.
    index
        Which of its pictures is read.
    """
    what = f"Picture {index} of {path}" if index else f"The image {path}"
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of large pictures and odd metadata
            yield
    except FileNotFoundError:
        raise SourceError(f"There is no image {path}; check the name.") from None
    except MotesError:
        raise
    except Image.DecompressionBombError:
        most = 2 * (Image.MAX_IMAGE_PIXELS or 0)
        raise SourceError(f"{what} is too large: more than {most} pixels; scale it down.") from None
    except Exception as error:  # decoders of damaged images raise nearly anything
        reason = getattr(error, "strerror", None) or "damaged, or not an image"
        advice = "choose an end before that" if index else "replace it"
        raise SourceError(f"{what} cannot be read: {reason}; {advice}.") from error
