"""Pictures of a film for the page, decoded on demand in a process of its own."""

from __future__ import annotations

import io
from collections import OrderedDict
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from motes.core.errors import ConfigError
from motes.studio.containers import check_container
from motes.studio.messages import OpenFilm
from motes.studio.opening import facts_of, opened
from motes.studio.safety import Limits
from motes.video.seeker import Seeker

QUALITY = 85
"""Of JPEGs."""
HELD = 64 << 20
"""Bytes of JPEGs that are kept."""
WIDEST = 3840
THUMBNAILS = 200
"""Most thumbnails of a strip."""


class Pictures:
    """JPEGs of the frames of a film.

    Parameters
    ----------
    path
        The film.
    limits
        Of its size.
    check
        Called now and then while it is opened.
    whole
        Whether it is known to be damaged.

    Raises
    ------
    SourceError
        If it cannot be read.
    ConfigError
        If it is larger than the limits.
    """

    def __init__(
        self, path: str, limits: Limits, check: Callable[[], None], *, whole: bool
    ) -> None:
        check_container(path, limits)
        self._film = film = opened(path, check, whole=whole)
        if film.width * film.height > limits.pixels:
            raise ConfigError(
                f"{film.name} has {film.width}x{film.height} pixels, more than "
                f"{limits.pixels:,}; rescale it."
            )
        if len(film.times) > limits.frames:
            raise ConfigError(
                f"{film.name} has {len(film.times)} frames, more than {limits.frames:,}; cut it."
            )
        self._held: OrderedDict[tuple[int, int], bytes] = OrderedDict()
        self._size, self._seeker = 0, Seeker(film)

    @property
    def facts(self) -> OpenFilm:
        """Size and length of the film."""
        return facts_of(self._film)

    @property
    def times(self) -> list[float]:
        """The time of each frame, in seconds."""
        return self._film.times

    def picture(self, index: int, width: int) -> bytes:
        """Return a frame as JPEG, at most `width` pixels wide.

        Raises
        ------
        ConfigError
            If the film has no such frame.
        SourceError
            If it cannot be read.
        """
        if not 0 <= index < len(self._film.times):
            raise ConfigError(
                f"There is no frame {index}; the last one is {self._film.frames[-1]}."
            )
        width = max(16, min(width, WIDEST, self._film.width))
        key = index, width
        if key in self._held:
            self._held.move_to_end(key)
            return self._held[key]
        data = jpeg(self._seeker.pixels(index), width)
        self._held[key] = data
        self._size += len(data)
        while self._size > HELD:
            self._size -= len(self._held.popitem(last=False)[1])
        return data

    def strip(self, count: int, height: int) -> bytes:
        """Return thumbnails side by side: of the key pictures nearest to equal steps."""
        count, height = max(1, min(count, THUMBNAILS)), max(16, min(height, 200))
        last, keys = len(self._film.times) - 1, np.array(self._film.keys or self._film.frames)
        width = max(1, round(height * self._film.width / self._film.height))
        out = Image.new("RGB", (width * count, height))
        for place, wanted in enumerate(np.linspace(0, last, count)):
            index = int(keys[np.abs(keys - wanted).argmin()])
            picture = Image.fromarray(self._seeker.pixels(index))
            out.paste(picture.resize((width, height)), (place * width, 0))
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
