"""A known target: its colors, in a file, and the places where it may appear."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Self

import msgspec
import numpy as np
from msgspec import Meta

from motes.core.config import Config, Count, Positive, from_dict
from motes.core.errors import ConfigError, FormatError
from motes.core.files import write_whole, writing
from motes.core.frame import Frame
from motes.core.geometry import Ellipse, as_ellipse
from motes.core.types import Floats
from motes.cues.base import Cue
from motes.cues.color import Color, ColorModel


class _File(Config, frozen=True, tag="motes_histogram"):
    """The content of a histogram file: pairs of bin number and share, without empty bins."""

    a: Positive
    b: Positive
    theta: float
    cue: Color
    bins: tuple[tuple[int, Annotated[float, Meta(gt=0, le=1)]], ...]


@dataclass(frozen=True, slots=True, eq=False)
class KnownTarget:
    """A target whose colors are known before it is seen (Nummiaro et al., section V)."""

    color: Color
    """The cue that made the histogram; a tracker that searches for the target needs the same
    one."""
    model: ColorModel
    """The target's histogram."""
    size: Ellipse
    """An ellipse of the target's size, at the origin."""

    @classmethod
    def learn(cls, color: Color, frame: Frame, region: Ellipse) -> Self:
        """Return the target in a region of a frame, by the cue of a tracker."""
        region = as_ellipse(region)
        return cls(color, color.learn(frame, region), region._replace(x=0.0, y=0.0))

    def models_for(self, cues: Mapping[str, Cue]) -> dict[str, ColorModel]:
        """Return the models for the cues of a tracker, which must read colors as the target's does.

        They may differ in which pixels they read, and in the weights of these.

        Raises
        ------
        ConfigError
            If the tracker has another cue, or settings by which histograms cannot be compared.
        """
        color = cues.get("color")
        if not isinstance(color, Color) or len(cues) > 1:
            raise ConfigError(
                f"The tracker compares {', '.join(cues)}; a known target is searched by color "
                f"alone, as with preset nummiaro."
            )
        for key in ("space", "bins"):
            mine, its = getattr(color, key), getattr(self.color, key)
            if mine != its:
                raise ConfigError(
                    f"The tracker's color.{key} is {mine}, the histogram's {its}; "
                    f"make it anew with the tracker's settings."
                )
        return {"color": self.model}

    def save(self, path: str | Path) -> None:
        """Write the target as JSON.

        Raises
        ------
        FormatError
            If the file cannot be written.
        """
        histogram = self.model.histogram
        bins = tuple((int(u), float(histogram[u])) for u in np.flatnonzero(histogram))
        a, b, theta = (float(value) for value in self.size[2:])
        file = _File(a, b, theta, self.color, bins)
        with writing(path):
            write_whole(path, msgspec.json.format(msgspec.json.encode(file)) + b"\n")

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a target that `save` wrote.

        Raises
        ------
        FormatError
            If the file is missing or is not a histogram file.
        """
        try:
            file: _File = from_dict(msgspec.json.decode(Path(path).read_bytes()), _File)
        except OSError as error:
            raise FormatError(f"Cannot read the histogram {path}: {error.strerror}.") from None
        except (ConfigError, msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
            raise FormatError(
                f"{path} is not a histogram file ({error}); make one with KnownTarget.save."
            ) from None
        histogram = np.zeros(file.cue.size)
        numbers = [number for number, _ in file.bins]
        if not numbers or not 0 <= min(numbers) <= max(numbers) < histogram.size:
            raise FormatError(f"{path}: bins must be 0 to {histogram.size - 1}, at least one.")
        histogram[numbers] = [share for _, share in file.bins]
        histogram /= histogram.sum()
        model = ColorModel(histogram, histogram)
        return cls(file.cue, model, Ellipse(0, 0, file.a, file.b, file.theta))


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
