"""The places where a known target may appear: in a file, and new particles there."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
from msgspec import Meta

from motes.core.config import Config, Count
from motes.core.errors import ConfigError
from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.types import Floats

Side = Annotated[float, Meta(ge=1)]


class Place(Config, frozen=True):
    """Where a target may appear: a box, or a border along the frame's edge."""

    name: str = ""
    """A name for error messages."""
    box: tuple[float, float, Side, Side] | None = None
    """x, y, width, height, in pixels; width and height are 1 or more."""
    border: Count | None = None
    """Width in pixels of the strip along all four edges."""

    def boxes(self, frame: Frame) -> list[tuple[float, float, float, float]]:
        """Return the boxes (x, y, width, height) of this place in a frame.

        Raises
        ------
        ConfigError
            If the place has no box and no border, or both, or lies outside the frame.
        """
        w, h = frame.width, frame.height
        if self.box is not None and self.border is None:
            x, y, width, height = self.box
            left, top = max(x, 0.0), max(y, 0.0)
            right, bottom = min(x + width, float(w)), min(y + height, float(h))
            if min(right - left, bottom - top) < 1:
                raise ConfigError(f"Place {self.name!r} lies outside the frame of {w}x{h}.")
            return [(left, top, right - left, bottom - top)]
        if self.border is not None and self.box is None:
            s = self.border
            if 2 * s >= min(w, h):
                raise ConfigError(f"Place {self.name!r}: a border of {s} fills the frame {w}x{h}.")
            return [(0, 0, w, s), (0, h - s, w, s), (0, s, s, h - 2 * s), (w - s, s, s, h - 2 * s)]
        raise ConfigError(
            f"Place {self.name!r} needs either box = [x, y, w, h] or border = pixels."
        )


class _Places(Config, frozen=True):
    place: tuple[Place, ...]


def load_places(path: str | Path) -> tuple[Place, ...]:
    """Read places from TOML: tables `[[place]]` with `box = [x, y, w, h]` or `border = 30`.

    Raises
    ------
    SourceError
        If the file cannot be read.
    ConfigError
        If it has another form.
    """
    places = _Places.load(path)
    if not places.place:
        raise ConfigError(f"{path} names no place; add a [[place]] with a box or a border.")
    return places.place


def boxes_of(places: tuple[Place, ...], frame: Frame) -> Floats:
    """Return the boxes (R, 4) of all places in a frame."""
    return np.array([box for place in places for box in place.boxes(frame)], np.float64)


def scatter(rng: np.random.Generator, places: Floats, size: Ellipse, n: int) -> Floats:
    """Return n ellipses (n, 5) of one size, centers uniform over the boxes `places` (R, 4)."""
    area = places[:, 2] * places[:, 3]
    shares = np.cumsum(area / area.sum())
    chosen = places[(shares / shares[-1]).searchsorted(rng.random(n), side="right")]
    ellipses = np.empty((n, 5))
    ellipses[:, :2] = chosen[:, :2] - 0.5 + rng.random((n, 2)) * chosen[:, 2:]
    ellipses[:, 2:] = size[2:]
    return ellipses
