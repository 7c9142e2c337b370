"""Distortion of a lens: from the pixels of a picture to those of one without distortion."""

from __future__ import annotations

import re
from typing import Annotated, Self

from msgspec import Meta

from motes.core.config import Config
from motes.core.errors import ConfigError
from motes.mot.analytics.ground_plane import Number, Point

STEPS = 50
"""Most iterations; a point is exact to `PRECISION` long before, unless the model has no inverse."""
PRECISION = 1e-12


class Lens(Config, frozen=True):
    """A camera as OpenCV calibrates it.

    A point x, y in units of the focal length is seen at

        x (1 + k1 r² + k2 r⁴ + k3 r⁶) / (1 + k4 r² + k5 r⁴ + k6 r⁶) + 2 p1 x y + p2 (r² + 2 x²)

    and y likewise. Brown, Close-range camera calibration, 1971.

    Attributes
    ----------
    matrix
        Nine numbers, row by row: fx, 0, cx, 0, fy, cy, 0, 0, 1.
    distortion
        k1, k2, p1, p2, and then k3, or k3 to k6.
    size
        Width and height of the pictures that it was calibrated with; None if unknown.
    """

    matrix: Annotated[tuple[Number, ...], Meta(min_length=9, max_length=9)]
    distortion: Annotated[tuple[Number, ...], Meta(min_length=4, max_length=8)]
    size: tuple[int, int] | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if not (self.matrix[0] > 0 and self.matrix[4] > 0):
            raise ConfigError("The camera matrix needs focal lengths above 0.")

    @classmethod
    def parse(cls, text: str) -> Self:
        """Return the lens in a file of `cv2.FileStorage`, YAML or XML.

        The names are those of OpenCV's calibration sample: camera_matrix,
        distortion_coefficients, image_width and image_height.

        Raises
        ------
        ConfigError
            If they are not there, or a model has more than 8 coefficients.
        """
        matrix = _numbers(text, "camera_matrix")
        distortion = _numbers(text, "distortion_coefficients")
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
        sides = [_numbers(text, name) for name in ("image_width", "image_height")]
        size = (int(sides[0][0]), int(sides[1][0])) if all(sides) else None
        return cls(tuple(matrix), tuple(distortion), size)

    def undistorted(self, point: Point) -> Point:
        """Return the place of a pixel in a picture of the same camera without distortion."""
        fx, _, cx, _, fy, cy, *_ = self.matrix
        k1, k2, p1, p2, k3, k4, k5, k6 = (*self.distortion, *(0.0,) * (8 - len(self.distortion)))
        x = seen_x = (point[0] - cx) / fx
        y = seen_y = (point[1] - cy) / fy
        for _ in range(STEPS):
            r = x * x + y * y
            radial = (1 + r * (k1 + r * (k2 + r * k3))) / (1 + r * (k4 + r * (k5 + r * k6)))
            aside = 2 * p1 * x * y + p2 * (r + 2 * x * x)
            down = p1 * (r + 2 * y * y) + 2 * p2 * x * y
            before = x, y
            x, y = (seen_x - aside) / radial, (seen_y - down) / radial
            if abs(x - before[0]) + abs(y - before[1]) < PRECISION:
                break
        return fx * x + cx, fy * y + cy


def _numbers(text: str, name: str) -> list[float]:
    """Return the numbers of an entry of a file of cv2.FileStorage; none if it is missing."""
    forms = (
        rf"^{name}\s*:\s*([-\d.eE+]+)\s*$",  # YAML, a number
        rf"<{name}>\s*([-\d.eE+]+)\s*</{name}>",  # XML, a number
        rf"^{name}\s*:\s*!!opencv-matrix.*?data\s*:\s*\[(.*?)\]",  # YAML, a matrix
        rf"<{name}\b[^>]*>.*?<data>(.*?)</data>",  # XML, a matrix
    )
    for form in forms:
        found = re.search(form, text, re.DOTALL | re.MULTILINE | re.IGNORECASE)
        if found:
            try:
                return [float(field) for field in re.split(r"[,\s]+", found[1].strip()) if field]
            except ValueError:
                raise ConfigError(f"{name} holds a value that is not a number.") from None
    return []
