"""One picture of a video, with its number and its time."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motes.core.errors import SourceError
from motes.core.types import Bytes

FRAME_INTERVAL = 1 / 25
"""Seconds between frames if a source does not give them (PAL; the papers' cameras)."""


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """A picture: `index` from 0, `time` in seconds, `pixels` RGB uint8 of shape (H, W, 3).

    Pixels may be given in any form that `as_rgb` takes. `cache` holds features that cues have
    computed from them, each under its own key.

    Raises
    ------
    SourceError
        If the index is no whole number, the time no number, or the pixels no image.
    """

    index: int
    time: float
    pixels: Bytes
    cache: dict[Hashable, Any] = field(default_factory=dict, init=False, repr=False)

    def __post_init__(self) -> None:
        if not isinstance(self.index, int | np.integer):
            raise SourceError(f"A frame's index is a whole number; got {self.index!r}.")
        if not isinstance(self.time, float | int | np.floating | np.integer):
            raise SourceError(f"Frame {self.index} has the time {self.time!r}; give it seconds.")
        object.__setattr__(self, "pixels", as_rgb(self.pixels))

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


def as_rgb(pixels: NDArray[Any]) -> Bytes:
    """Return an image as RGB uint8 (H, W, 3), C-contiguous and writable.

    Takes gray (H, W) or (H, W, 1), RGB and RGBA (alpha is dropped), as uint8, uint16 (the high
    byte is kept), bool, or float in [0, 1]. Copies only where something must change.

    Raises
    ------
    SourceError
        For any other shape or type, an empty image, or floats outside [0, 1].
    """
    image = np.asarray(pixels)
    rgb = image.dtype == np.uint8 and image.ndim == 3 and image.shape[2] == 3
    if rgb and image.size and image.flags.carray:
        return image  # the usual case, and fast
    if image.ndim == 2:
        image = image[:, :, None]
    if image.ndim != 3 or image.shape[2] not in (1, 3, 4) or image.size == 0:
        raise SourceError(
            f"An image has shape (height, width), or (height, width, 1, 3 or 4); got {image.shape}."
        )
    if image.dtype == np.uint16:
        image = (image >> 8).astype(np.uint8)
    elif image.dtype == np.bool_:
        image = image.astype(np.uint8) * np.uint8(255)
    elif np.issubdtype(image.dtype, np.floating):
        if not (np.isfinite(image).all() and image.min() >= 0 and image.max() <= 1):
            raise SourceError("A floating-point image has values from 0 to 1; scale it first.")
        image = np.rint(image * 255).astype(np.uint8)
    elif image.dtype != np.uint8:
        raise SourceError(
            f"An image is uint8, uint16, bool or float in [0, 1]; got {image.dtype}. Convert it."
        )
    image = np.repeat(image, 3, axis=2) if image.shape[2] == 1 else image[:, :, :3]
    # Kernels read memory in C order.
    return np.require(image, np.uint8, ["C", "W"])
