"""Distortion of a lens: from the pixels of a picture to those of one without distortion."""

from __future__ import annotations

import math
import re
from typing import Annotated, Self

from msgspec import Meta

from motes.core.config import Config
from motes.core.errors import ConfigError
from motes.core.files import lines_of
from motes.core.geometry import FARTHEST
from motes.mot.analytics.ground_plane import Number, Point

STEPS = 50
"""Most iterations; a point is exact to `PRECISION` long before, unless the model has no inverse."""
PRECISION = 1e-12
SETTLED = 1e-6
"""Largest last step of a point that is found, in units of the focal length."""
WIDEST = 100_000
"""Largest side of pictures, in pixels."""


class Lens(Config, frozen=True):
    """A camera as OpenCV calibrates it.

    A point x, y in units of the focal length is seen at

        x (1 + k1 r² + k2 r⁴ + k3 r⁶) / (1 + k4 r² + k5 r⁴ + k6 r⁶) + 2 p1 x y + p2 (r² + 2 x²)

    and y likewise. Brown, Close-range camera calibration, 1971.
    """

    matrix: Annotated[tuple[Number, ...], Meta(min_length=9, max_length=9)]
    """Nine numbers, row by row: fx, 0, cx, 0, fy, cy, 0, 0, 1."""
    distortion: Annotated[tuple[Number, ...], Meta(min_length=4, max_length=8)]
    """k1, k2, p1, p2, and then k3, or k3 to k6."""
    size: tuple[int, int] | None = None
    """Width and height of the pictures that it was calibrated with; None if unknown."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if not (self.matrix[0] > 0 and self.matrix[4] > 0):
            raise ConfigError("The camera matrix needs focal lengths above 0.")
        if self.size is not None and not all(0 < side <= WIDEST for side in self.size):
            raise ConfigError(f"Pictures of {self.size[0]}x{self.size[1]} pixels are of no camera.")

    @classmethod
    def parse(cls, text: str) -> Self:
        """Return the lens in a file of `cv2.FileStorage`, YAML or XML.

        The names are those of OpenCV's calibration sample: camera_matrix, distortion_coefficients,
        image_width and image_height. Raises a ConfigError if they are not there, or a model has
        more than 8 coefficients.
        """
        entry = _xml_entry if text.lstrip().startswith("<") else _yaml_entry
        matrix, distortion, width, height = (
            _numbers(name, *entry(text.lower(), name))
            for name in ("camera_matrix", "distortion_coefficients", "image_width", "image_height")
        )
        if len(matrix) != 9 or not distortion:
            raise ConfigError(
                "It has no camera_matrix and distortion_coefficients, as OpenCV's calibration "
                "writes them; give the YAML or XML file of cv2.FileStorage."
            )
        if not any(distortion[8:]):  # those of a thin prism and of a tilted sensor
            distortion = distortion[:8]
        if len(distortion) not in (4, 5, 8):
            raise ConfigError(
                f"The lens has {len(distortion)} coefficients; calibrate with 4, 5 or 8."
            )
        size = (int(width[0]), int(height[0])) if width and height else None
        return cls(tuple(matrix), tuple(distortion), size)

    def undistorted(self, point: Point) -> Point | None:
        """Return the place of a pixel in a picture of the same camera without distortion.

        None where the model has no inverse, as far outside of the pictures of the calibration.
        """
        fx, _, cx, _, fy, cy, *_ = self.matrix
        k1, k2, p1, p2, k3, k4, k5, k6 = (*self.distortion, *(0.0,) * (8 - len(self.distortion)))
        x = seen_x = (point[0] - cx) / fx
        y = seen_y = (point[1] - cy) / fy
        for _ in range(STEPS):
            r = x * x + y * y
            radial = 1 + r * (k1 + r * (k2 + r * k3))
            below = 1 + r * (k4 + r * (k5 + r * k6))
            aside = 2 * p1 * x * y + p2 * (r + 2 * x * x)
            down = p1 * (r + 2 * y * y) + 2 * p2 * x * y
            if not radial:
                return None
            before = x, y
            x, y = (seen_x - aside) * below / radial, (seen_y - down) * below / radial
            step = abs(x - before[0]) + abs(y - before[1])
            if step < PRECISION:
                break
        return (fx * x + cx, fy * y + cy) if step < SETTLED else None


def _yaml_entry(text: str, name: str) -> tuple[str, str]:
    """Return the value of a key of YAML, and of a matrix what stands before its `data`.

    Both are "" where there is none.
    """
    lines = lines_of(text)
    for number, line in enumerate(lines):
        key, colon, value = line.partition(":")
        if not colon or key.rstrip() != name:
            continue
        if "!!opencv-matrix" not in value:
            return value, ""
        end = number + 1
        while end < len(lines) and (lines[end][:1].isspace() or not lines[end]):
            end += 1
        block = "\n".join(lines[number + 1 : end])
        before, _, data = block.partition("data")
        return data.partition("[")[2].partition("]")[0], before
    return "", ""


def _xml_entry(text: str, name: str) -> tuple[str, str]:
    """Return the text of an element of XML, as `_yaml_entry` that of a key."""
    start = text.find(f"<{name}")
    body = text[start : text.find(f"</{name}", start)].partition(">")[2] if start >= 0 else ""
    before, found, data = body.partition("<data>")
    return (data.partition("</data")[0], before) if found else (body, "")


def _numbers(name: str, value: str, shape: str) -> list[float]:
    """Return the numbers of an entry, of a matrix as many as its rows and columns say, if they do.

    Raises a ConfigError if one is none, or is not finite, or there are more or fewer.
    """
    try:
        found = [float(field) for field in value.replace(",", " ").split()]
    except ValueError:
        raise ConfigError(f"{name} holds a value that is not a number.") from None
    if not all(abs(number) <= FARTHEST for number in found):
        raise ConfigError(f"{name} holds a number that is not finite, or too large.")
    sides = [int(each) for each in re.findall(r"\b(?:rows|cols)\W+(\d{1,6})\b", shape)]
    if sides and math.prod(sides) != len(found):
        raise ConfigError(
            f"{name} has {len(found)} numbers, not the {' x '.join(map(str, sides))} of its rows "
            f"and columns; give the file as OpenCV wrote it."
        )
    return found
