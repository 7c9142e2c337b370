"""One picture of a video, with its number and its time."""

from __future__ import annotations

import math
from collections.abc import Hashable
from fractions import Fraction
from functools import lru_cache
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from motes.core.errors import SourceError
from motes.core.log import LOG
from motes.core.types import Bytes

FRAME_INTERVAL = 1 / 25
"""Seconds between frames if a source does not give them (PAL; the papers' cameras)."""
LARGEST_VIEW = 2**31 - 1
"""Bytes from the first to the last row of an image that is read where it lies."""
WHOLE, NUMBER = (int, np.integer), (float, int, np.floating, np.integer, Fraction)
"""The types of whole numbers and of numbers that users may give; PyAV has times in fractions."""
BYTE = np.dtype(np.uint8)
DEPTHS = (8, 10, 12, 14, 16)
"""The bits of cameras whose pictures are held in 16."""
OUTLIERS = 1e-4
"""Share of the pixels that may be brighter than the depth holds, as a sensor's stuck ones are."""
OTHER_COLORS = ("P", "CMYK", "YCbCr", "LAB", "HSV")
"""Modes of Pillow whose arrays look like gray or RGB."""


class Frame(msgspec.Struct, frozen=True, eq=False):
    """A picture of a video, with its number and its time.

    Raises
    ------
    SourceError
        If the index is not a whole number, the time not a number, or the pixels not an image.
    """

    index: int
    """Number of the frame, from 0."""
    time: float
    """In seconds."""
    pixels: Bytes
    """RGB uint8 of shape (H, W, 3). They may be given in any form that `as_rgb` takes. They are
    read where they lie in memory: do not change them while a tracker works on the frame."""
    cache: dict[Hashable, Any] = msgspec.field(default_factory=dict)
    """Features that cues have computed from the pixels, each under its own key."""
    arrived: float | None = None
    """The reading of `time.monotonic` when a live source sent the picture, else None."""
    depth: int | None = None
    """The bits that the film uses of pixels in uint16; None to find them in this frame."""

    def __post_init__(self) -> None:
        if not isinstance(self.index, WHOLE):
            raise SourceError(f"A frame's index is a whole number, no {type(self.index).__name__}.")
        time: Any = self.time
        if not isinstance(time, NUMBER):
            raise SourceError(f"Frame {self.index} has the time {time!r}; give it seconds.")
        if isinstance(time, Fraction):
            msgspec.structs.force_setattr(self, "time", float(time))
        if _readable(self.pixels):
            return  # the usual case, and fast
        depth = self.depth
        if getattr(self.pixels, "dtype", None) == np.uint16:
            values = np.asarray(self.pixels, np.uint16)
            if depth is None:
                depth = depth_of(values)
                msgspec.structs.force_setattr(self, "depth", depth)
                if depth < DEPTHS[-1]:
                    _say(depth_note(depth))
            elif depth in DEPTHS and exceeds(values, depth):
                _say(
                    f"a picture is too bright for {depth} bits, those of the first one, and parts "
                    f"become white; give the camera's bits, as in Frame(0, 0.0, pixels, depth=16)."
                )
        msgspec.structs.force_setattr(self, "pixels", as_rgb(self.pixels, depth))

    @property
    def width(self) -> int:
        """Number of columns."""
        return int(self.pixels.shape[1])

    @property
    def height(self) -> int:
        """Number of rows."""
        return int(self.pixels.shape[0])

    def __repr__(self) -> str:
        return f"Frame(index={self.index}, time={self.time:.3f} s, {self.width}x{self.height})"


def depth_of(values: NDArray[np.uint16]) -> int:
    """Return the least of `DEPTHS` that holds all values of pictures but a few `OUTLIERS`."""
    level = int(np.quantile(values, 1 - OUTLIERS, method="higher")) if values.size else 0
    return next(depth for depth in DEPTHS if level < 1 << depth)


def depth_note(depth: int) -> str:
    """Return one line about the depth of pictures in 16 bits."""
    return f"the pictures use {depth} of 16 bits: 0 to {(1 << depth) - 1} become 0 to 255."


def exceeds(values: NDArray[np.uint16], depth: int) -> bool:
    """Return whether more than a few pixels of a picture are too bright for a depth."""
    return depth < DEPTHS[-1] and bool(np.count_nonzero(values >> depth) > OUTLIERS * values.size)


@lru_cache
def _say(note: str) -> None:
    """Log a note, once for all films."""
    LOG.warning(note)


def as_frame(picture: Any, last: Frame | None = None, step: int = 1) -> Frame:
    """Return an image as the first frame of a video, or `step` frames after the last one.

    A `Frame` stays as it is. Raises a SourceError if it is no image (see `as_rgb`), or the frame's
    time is not finite.
    """
    if not isinstance(picture, Frame):
        if last is None:
            return Frame(0, 0.0, picture)
        time = last.time + step * FRAME_INTERVAL
        return Frame(last.index + step, time, picture, depth=last.depth)
    if not math.isfinite(picture.time):
        raise SourceError(f"Frame {picture.index} is at {picture.time} s; give it a finite time.")
    if last is not None and picture.depth != last.depth:
        _say(
            f"frame {picture.index} uses {picture.depth or 8} bits, those before "
            f"{last.depth or 8}, so their brightness differs; give all the camera's, as in "
            f"Frame(0, 0.0, pixels, depth=16)."
        )
    return picture


def as_rgb(pixels: NDArray[Any], depth: int | None = None) -> Bytes:
    """Return an image as RGB uint8 (H, W, 3), where it lies in memory if that is possible.

    Takes gray (H, W) or (H, W, 1), RGB and RGBA (alpha is dropped), as uint8, uint16 (of which
    `depth` bits are used, by default as `depth_of` finds), bool, or float in [0, 1].

    The result is a view of every uint8 image whose pixels, and rows, lie one after the other, with
    or without gaps: parts of images, gray and RGBA, and BGR as `bgr[:, :, ::-1]`. All else is
    copied. A view is not in C order, and one of gray pixels can only be read; what needs more
    memory takes `np.ascontiguousarray`. Raises a SourceError for any other shape or type, an empty
    image, or floats outside [0, 1].
    """
    if _readable(pixels):
        return pixels
    if pixels is None:
        raise SourceError("There is no picture, but None; has the film ended?")
    if getattr(pixels, "mode", "RGB") in OTHER_COLORS:
        raise SourceError("This image of Pillow has no RGB; give image.convert('RGB').")
    try:
        image = np.asarray(pixels)
    except ValueError:  # as the pair of OpenCV's read
        image = np.empty(0)
    if image.ndim == 2:
        image = image[:, :, None]
    if image.ndim != 3 or image.shape[2] not in (1, 3, 4) or image.size == 0:
        raise SourceError(
            f"An image has shape (height, width), or (height, width, 1, 3 or 4); got "
            f"{getattr(pixels, 'shape', None) or type(pixels).__name__}."
        )
    if image.dtype == np.uint16:
        used = depth_of(image) if depth is None else depth
        if used not in DEPTHS:
            raise SourceError(f"A depth is one of {DEPTHS} bits; got {used}.")
        image = (image >> (used - 8)).clip(max=255).astype(np.uint8)
    elif image.dtype == np.bool_:
        image = image.astype(np.uint8) * np.uint8(255)
    elif np.issubdtype(image.dtype, np.floating):
        if not np.isfinite(image).all():
            raise SourceError("An image has NaN or infinite values; give floats from 0 to 1.")
        least, most = float(image.min()), float(image.max())
        if least < 0 or most > 1:
            raise SourceError(
                f"A floating-point image has values from 0 to 1; got {least:g} to {most:g}. Scale "
                f"it first."
            )
        image = np.rint(image * 255).astype(np.uint8)
    elif image.dtype != np.uint8:
        raise SourceError(
            f"An image is uint8, uint16, bool or float in [0, 1]; got {image.dtype}. Convert it."
        )
    height, width, channels = image.shape
    image = np.broadcast_to(image, (height, width, 3)) if channels == 1 else image[:, :, :3]
    return image if _readable(image) else np.ascontiguousarray(image)


def from_bgr(image: NDArray[Any]) -> NDArray[Any]:
    """Return a BGR image as RGB: a view, which kernels read where the image lies."""
    colors = getattr(image, "shape", ())[2:] in ((3,), (4,))  # all else is gray, RGB, or refused
    return np.asarray(image)[:, :, 2::-1] if colors else image  # alpha comes last


def _readable(image: Any) -> bool:
    """Return whether kernels can read an image where it lies (`Picture` of `kernels`)."""
    if type(image) is not np.ndarray or image.ndim != 3 or image.dtype != BYTE:
        return False
    height, width, channels = image.shape
    line, pixel, channel = image.strides
    size = 1 + 2 * abs(channel)
    in_order = (
        -1 <= channel <= 1
        and pixel >= size
        and pixel * (width - 1) + size <= line
        and line * height <= LARGEST_VIEW
    )
    filled = channels == 3 and height > 0 and width > 0
    return filled and (in_order or image.flags.c_contiguous)
