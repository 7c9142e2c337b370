"""A known target: its histogram in a file, and the places where it may appear."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Self

import msgspec
import numpy as np
from msgspec import Meta
from numpy.typing import NDArray

from motes.core.config import Config, Count, Positive, from_dict, from_json, from_toml
from motes.core.errors import ConfigError, FormatError
from motes.core.files import write_whole
from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.cues.color import Color, ColorModel


class _File(Config, frozen=True, tag="motes_histogram"):
    """The content of a histogram file: pairs of bin number and share, without empty bins."""

    cue: Color
    a: Positive
    b: Positive
    theta: float
    bins: tuple[tuple[int, Annotated[float, Meta(gt=0, le=1)]], ...]


@dataclass(frozen=True, slots=True, eq=False)
class Target:
    """A target whose histogram is known before it is seen (Nummiaro et al., section V).

    Attributes
    ----------
    cue
        The cue that made the histogram; a tracker that searches for the target needs the same bins.
    model
        The histogram.
    size
        An ellipse of the target's size, at the origin.
    """

    cue: Color
    model: ColorModel
    size: Ellipse

    @classmethod
    def learn(cls, cue: Color, frame: Frame, region: Ellipse) -> Self:
        """Return the target in a region of a frame."""
        return cls(cue, cue.learn(frame, region), region._replace(x=0.0, y=0.0))

    def save(self, path: str | Path) -> None:
        """Write the target as JSON.

        Raises
        ------
        FormatError
            If the file cannot be written.
        """
        occupied = np.flatnonzero(self.model.histogram)
        bins = tuple((int(u), float(self.model.histogram[u])) for u in occupied)
        a, b, theta = (float(value) for value in self.size[2:])
        file = _File(cue=self.cue, a=a, b=b, theta=theta, bins=bins)
        try:
            write_whole(path, msgspec.json.format(msgspec.json.encode(file)) + b"\n")
        except OSError as error:
            raise FormatError(
                f"{path} cannot be written: {error.strerror}; make room, or choose another place."
            ) from None

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a target that `save` wrote.

        Raises
        ------
        FormatError
            If the file is missing or is not a histogram file.
        """
        try:
            file: _File = from_dict(from_json(Path(path).read_bytes()), _File)
        except OSError as error:
            raise FormatError(f"Cannot read the histogram {path}: {error.strerror}.") from None
        except ConfigError as error:
            raise FormatError(
                f"{path} is not a histogram file ({error}); make one with `motes histogram`."
            ) from None
        histogram = np.zeros(file.cue.size)
        numbers = [number for number, _ in file.bins]
        if not numbers or not 0 <= min(numbers) <= max(numbers) < histogram.size:
            raise FormatError(f"{path}: bins must be 0 to {histogram.size - 1}, at least one.")
        histogram[numbers] = [share for _, share in file.bins]
        histogram /= histogram.sum()
        return cls(
            file.cue, ColorModel(histogram, histogram), Ellipse(0, 0, file.a, file.b, file.theta)
        )


Side = Annotated[float, Meta(ge=1)]


class Place(Config, frozen=True):
    """Where a target may appear: a box, or a border along the frame's edge.

    Attributes
    ----------
    name
        A name for error messages.
    box
        x, y, width, height, in pixels; width and height are 1 or more.
    border
        Width in pixels of the strip along all four edges.
    """

    name: str = ""
    box: tuple[float, float, Side, Side] | None = None
    border: Count | None = None

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
    ConfigError
        If the file cannot be read or has another form.
    """
    try:
        text = Path(path).read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigError(f"Cannot read the places in {path}: {error}.") from None
    places: _Places = from_dict(from_toml(text, str(path)), _Places)
    if not places.place:
        raise ConfigError(f"{path} names no place; add a [[place]] with a box or a border.")
    return places.place


def boxes_of(places: tuple[Place, ...], frame: Frame) -> NDArray[np.float64]:
    """Return the boxes (R, 4) of all places in a frame."""
    return np.array([box for place in places for box in place.boxes(frame)], np.float64)
