"""Image files as frames: each file of a folder, or one image alone."""

from __future__ import annotations

import os
import re
from collections.abc import Generator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from motes.core.errors import SourceError
from motes.core.frame import FRAME_INTERVAL

if TYPE_CHECKING:
    from motes.video.decoder import Stamped
    from motes.video.report import Report

IMAGE_ENDINGS = frozenset(
    {".bmp", ".jpeg", ".jpg", ".pgm", ".png", ".pnm", ".ppm", ".tif", ".tiff", ".webp"}
)


class ImageFiles:
    """Image files, one frame each: the first picture, in the natural order of the names.

    Raises
    ------
    SourceError
        If none of the paths is an image; while reading, at the first one that is damaged.
    """

    fps: float | None = 1 / FRAME_INTERVAL
    duration: float | None
    count: int | None
    live = realtime = False

    def __init__(self, name: str, paths: list[str]) -> None:
        self._paths = sorted(
            (
                path
                for path in paths
                if os.path.splitext(path)[1].lower() in IMAGE_ENDINGS
                and not os.path.basename(path).startswith(".")
            ),
            key=_natural,
        )
        if not self._paths:
            endings = ", ".join(sorted(IMAGE_ENDINGS))
            raise SourceError(f"There are no images in {name}; they would end in {endings}.")
        self._folder = os.path.commonpath({os.path.dirname(path) for path in self._paths})
        self.count = len(self._paths)
        self.duration = len(self._paths) * FRAME_INTERVAL

    def pictures(self, report: Report) -> Generator[Stamped, None, None]:
        """Yield the pictures in order, `FRAME_INTERVAL` apart."""
        for index, path in enumerate(self._paths):
            yield index * FRAME_INTERVAL, partial(_first_picture, path, report)

    def file_of(self, index: int) -> str | None:
        """Return the path of a picture in the folder that holds all of them."""
        return Path(os.path.relpath(self._paths[index], self._folder or ".")).as_posix()

    def close(self) -> None:
        """Do nothing: each file is closed when it has been read."""


def files_in(path: str) -> list[str]:
    """Return the paths of all that is in a folder; raise a SourceError if it cannot be read."""
    try:
        return [os.path.join(path, name) for name in os.listdir(path)]
    except OSError as error:
        raise SourceError(f"The folder {path} cannot be read: {error.strerror}.") from error


def read_image(path: str | Path) -> NDArray[np.uint8]:
    """Read the first picture of an image file, upright, as RGB uint8 of shape (height, width, 3).

    Raises
    ------
    SourceError
        If the file is missing or not an image.
    """
    from PIL import Image

    from motes.video.animation import pixels_of, readable

    with readable(path), Image.open(path) as image:
        return pixels_of(image)


def _first_picture(path: str, report: Report) -> NDArray[np.uint8]:
    """Read one image of a folder; count the pictures left out of a file with several."""
    from PIL import Image

    from motes.video.animation import picture_numbers, pixels_of, readable

    with readable(path), Image.open(path) as image:
        numbers = picture_numbers(image)
        report.left_out += len(numbers) - 1
        image.seek(numbers[0])
        return pixels_of(image)


def _natural(name: str) -> list[tuple[int, int | str]]:
    parts = re.findall(r"\d+|\D+", name)
    return [(0, int(part)) if part.isdecimal() else (1, part) for part in parts]
