"""Distortion of a lens: from the pixels of a picture to those of one without distortion."""

from __future__ import annotations

from typing import Annotated, Self

from msgspec import Meta

from motes.core.callables import optional
from motes.core.config import Config, from_dict
from motes.core.errors import ConfigError
from motes.mot.analytics.ground_plane import Number, Point

MATRICES = "camera_matrix", "distortion_coefficients"
SIDES = "image_width", "image_height"
"""The names of OpenCV's calibration sample."""
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
            raise ConfigError(
                f"Pictures of {self.size[0]:g}x{self.size[1]:g} pixels are of no camera."
            )

    @classmethod
    def parse(cls, text: str) -> Self:
        """Return the lens in a file of `cv2.FileStorage`, YAML or XML.

        Raises a ConfigError if it has no lens, or one with more than 8 coefficients, and a
        MissingDependencyError without OpenCV.
        """
        cv2 = optional("cv2", "A lens needs OpenCV", "motes[opencv]")
        try:
            file = cv2.FileStorage(text, cv2.FILE_STORAGE_READ | cv2.FILE_STORAGE_MEMORY)
            keys = file.root().keys()
            named = {key.lower(): file.getNode(key) for key in keys}
            matrix, distortion = (named[name].mat().ravel() for name in MATRICES)
            sides = [int(named[name].real()) for name in SIDES if name in named]
        except (cv2.error, SystemError, LookupError, AttributeError, ValueError, OverflowError):
            raise ConfigError(
                "It has no camera_matrix and distortion_coefficients, as OpenCV's calibration "
                "writes them; give the YAML or XML file of cv2.FileStorage."
            ) from None
        if not any(distortion[8:]):  # those of a thin prism and of a tilted sensor
            distortion = distortion[:8]
        if len(distortion) not in (4, 5, 8):
            raise ConfigError(
                f"The lens has {len(distortion)} coefficients; calibrate with 4, 5 or 8."
            )
        size = sides if len(sides) == 2 else None
        values = {"matrix": matrix.tolist(), "distortion": distortion.tolist(), "size": size}
        lens: Self = from_dict(values, cls)
        return lens

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
