"""Places on the ground, in metres, of points in a picture."""

from __future__ import annotations

from functools import cache
from typing import Annotated, TypeAlias

import numpy as np
from msgspec import Meta

from motes.core.config import Config
from motes.core.errors import ConfigError
from motes.core.geometry import FARTHEST
from motes.core.types import Floats

Point: TypeAlias = tuple[float, float]
Number = Annotated[float, Meta(ge=-FARTHEST, le=FARTHEST)]
Scale = Annotated[float, Meta(ge=1e-9, le=1e9)]
"""Pixels in a metre: from those of a planet to those of a microscope."""
Pair = tuple[Number, Number, Number, Number]
Triple = tuple[Number, Number, Number]
Homography: TypeAlias = tuple[Triple, Triple, Triple]
"""A map (3, 3) of the points (x, y, 1) of a plane, up to scale; the rows as OpenCV finds them."""

DEGENERATE = 1e-9
"""Points on one line do not determine a homography: its second smallest singular value is 0."""


class Ground(Config, frozen=True):
    """A plane ground, described in one of three ways.

    Raises
    ------
    ConfigError
        If it is not described in exactly one way, or does not determine a plane.
    """

    scale: Scale | None = None
    """Pixels in a metre: for a camera that looks straight down, or as an approximation."""
    homography: Homography | None = None
    """Maps (x, y, 1) in pixels to (X, Y, 1) in metres, times anything."""
    points: tuple[Pair, ...] | None = None
    """Four or more points on the ground, no three of four on a line, as x, y in the picture and X,
    Y in metres; the homography that fits them best is used."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if sum(way is not None for way in (self.scale, self.homography, self.points)) != 1:
            raise ConfigError("The ground takes exactly one of scale, homography and points.")
        if self.points is not None and len(self.points) < 4:
            raise ConfigError(
                f"The ground needs four points or more, each [x, y, X, Y], and has "
                f"{len(self.points)}; add some that are far from the others."
            )
        _matrix(self)

    def metres(self, point: Point) -> Point | None:
        """Return the place on the ground of a picture's point; None on the horizon or above.

        A homography does not tell which side of its horizon is the ground: both are.
        """
        x, y, w = (_matrix(self) @ (*point, 1.0)).tolist()
        if self.homography is not None and w < 0:
            x, y, w = -x, -y, -w
        return (x / w, y / w) if w > 0 and max(abs(x), abs(y)) <= w * FARTHEST else None


@cache
def _matrix(ground: Ground) -> Floats:
    """Return the homography, (3, 3), from pixels to metres; fitted, w > 0 below the horizon."""
    if ground.scale is not None:
        return np.diag([1.0, 1.0, ground.scale])
    if ground.points is not None:
        return _fitted(np.array(ground.points))
    matrix = np.array(ground.homography)
    if np.linalg.matrix_rank(matrix) < 3:
        raise ConfigError("The homography maps the picture onto a line; give another one.")
    return matrix


def _fitted(points: Floats) -> Floats:
    """Return the homography (3, 3) that maps x, y to X, Y, all four in `points` (n, 4).

    The direct linear transform over normalized points: Hartley, In defense of the eight-point
    algorithm, PAMI 1997. Its sign is such that w > 0 at the points.
    """
    pixels, metres = (_normalizing(part) for part in (points[:, :2], points[:, 2:]))
    ones = np.ones((len(points), 1))
    x = np.hstack([points[:, :2], ones]) @ pixels.T
    u, v, _ = (np.hstack([points[:, 2:], ones]) @ metres.T).T
    zero = np.zeros_like(x)
    rows = np.vstack([np.hstack([x, zero, -u[:, None] * x]), np.hstack([zero, x, -v[:, None] * x])])
    _, singular, basis = np.linalg.svd(rows)
    if singular[7] <= DEGENERATE * singular[0]:
        raise ConfigError("Points on a line do not determine the ground; give others.")
    matrix: Floats = np.linalg.inv(metres) @ basis[8].reshape(3, 3) @ pixels
    w = np.hstack([points[:, :2], ones]) @ matrix[2]
    if w.max() > 0 > w.min():
        raise ConfigError("The points do not lie on one side of a horizon; check their order.")
    return -matrix if w[0] < 0 else matrix


def _normalizing(points: Floats) -> Floats:
    """Return the similarity (3, 3) that moves points to the origin, at a mean distance of 1."""
    center = points.mean(axis=0)
    spread = np.hypot(*(points - center).T).mean() or 1.0
    return np.array([[1, 0, -center[0]], [0, 1, -center[1]], [0, 0, spread]]) / spread
