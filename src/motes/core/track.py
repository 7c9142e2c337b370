"""A track: where an object is in one frame."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from enum import StrEnum
from typing import Any, Self

import msgspec
import numpy as np

from motes.core.errors import ConfigError
from motes.core.geometry import Box, Ellipse
from motes.core.types import Floats

BOX = ("left", "top", "width", "height")
"""The axis-parallel box around the object, in pixels."""
ELLIPSE = ("x", "y", "a", "b", "theta")
"""Its center and half-axes in pixels, and the angle of a in radians."""
COLUMNS = (
    "frame", "time", "id", "label", *BOX, *ELLIPSE, "confidence", "belief", "status",
    "distance", "effective_sample_size", "occluded_by",
)  # fmt: skip
"""The columns of all rows: the keys of `Track.to_dict`."""
DEVIATIONS = ("x_std", "y_std", "a_std", "b_std", "theta_std")
"""Columns of standard deviations, in the order of an ellipse."""
GROUND = ("x_m", "y_m", "x_m_std", "y_m_std", "speed", "speed_std")
"""Further columns of places in metres and speeds in metres per second."""
ROUNDING = 1e-12
"""What is smaller, in metres or metres per second, is an error of rounding."""
SURE = 0.5
"""The lowest confidence of an object that others may take for seen."""
UNKNOWN = np.diag([math.nan] * 5)
"""The covariance of a place of which none is known."""


class Status(StrEnum):
    """The status of a tracker: searching → tracking → lost → searching."""

    SEARCHING = "searching"
    """The target is searched for; the ellipse is only the best guess."""
    TRACKING = "tracking"
    """The target is followed."""
    OCCLUDED = "occluded"
    """Another object hides it; the ellipse is its predicted place. Only a `Scene` reports it."""
    LOST = "lost"
    """This frame ended the tracking; from the next one on the target is searched for. Of an object
    of a `Scene`: it is not seen, though nothing hides it (`Track.sought`)."""
    INTERPOLATED = "interpolated"
    """Not seen, but between frames in which it was: a smoother has bridged them."""
    ABSENT = "absent"
    """A user has marked the target as absent; there is no ellipse."""


TRACKING = Status.TRACKING
"""For what runs in every frame: Python 3.11 calls a function each time a member is named."""


class Track(msgspec.Struct, frozen=True, eq=False):
    """Where an object is in one frame, and how sure the tracker is: what a row holds.

    Where an object of a `Scene` is not seen, its place is only predicted, with confidence 0: it is
    `occluded` where another object covers it, else `lost`, as in its last frame. In a track that is
    read from a file, numbers that the file does not have are NaN.
    """

    frame: int
    time: float
    """Index of the frame and its time in seconds."""
    ellipse: Ellipse
    """The estimate; `box` is the box around it."""
    covariance: Floats = UNKNOWN
    """(5, 5), of x, y, a, b, theta over the weighted particles; pixels and radians."""
    confidence: float = 1.0
    """0 to 1: the estimated probability that `box` overlaps the target by more than half, times the
    weight of the particles that fulfill the appearance rule."""
    status: Status = Status.TRACKING
    """See `Status`."""
    distance: float = math.nan
    """Distance between the target model and the estimate's region, 0 (same) to 1."""
    effective_sample_size: float = math.nan
    """1 to the number of particles."""
    belief: float = math.nan
    """0 to 1: the probability that what is followed is the target, and not a neighbor who looks
    alike. It is a factor of the confidence. NaN of a tracker that knows of no neighbors."""
    outlier: bool = False
    """Whether a tracker reported a place in this frame that other frames contradict. It is known in
    hindsight only: see `motes.smooth` and `motes.correct`."""
    smoothed: bool = False
    """Whether the track is one of these in hindsight."""
    identity: int = 1
    """From 1 up; the same from entry to exit, and never used twice."""
    label: str | None = None
    """The name of its class, such as "car": that of most of its detections so far. None if nothing
    knows classes."""
    occluded_by: int | None = None
    """The identity of the object that occludes it, if it is `occluded`."""
    detected: bool = False
    """Whether a detection confirms it in this frame."""
    velocity: tuple[float, float] = (0.0, 0.0)
    """Of an object of a `Scene`: in x and y, in pixels a second."""
    sought: bool = False
    """Of an object of a `Scene`: whether it is `lost`, but keeps its identity if it is found
    again."""
    further: Mapping[str, float | str | None] = {}
    """Further columns of its row, by name, such as `speed`."""
    mask: str | None = None
    """Its pixels, in the compressed runs of COCO (`motes.formats.masks`); None without a mask."""
    keyframe: bool = True
    """Whether a user has drawn it, or would have to: a tool that interpolates needs this one."""
    bounds: Box | None = None
    """The box around what a file holds, such as a turned rectangle; None if it is the ellipse's."""

    @classmethod
    def nowhere(
        cls, frame: int, time: float, status: Status = Status.SEARCHING, identity: int = 1
    ) -> Self:
        """Return the track of an object that has no place in a frame."""
        nan = math.nan
        return cls(frame, time, Ellipse(*[nan] * 5), UNKNOWN, nan, status, identity=identity)

    @property
    def gone(self) -> bool:
        """Whether this is its last frame: it is `lost`, and not sought."""
        return self.status is Status.LOST and not self.sought

    @property
    def box(self) -> Box:
        """The axis-parallel box around the ellipse: x, y, width, height."""
        if self.bounds is not None:
            return self.bounds
        return self.ellipse.box if math.isfinite(self.ellipse.theta) else Box(*[math.nan] * 4)

    @property
    def xyxy(self) -> tuple[float, float, float, float]:
        """The box as left, top, right and bottom: x, y, x + width, y + height.

        This is the form that supervision, torchvision and most detectors take.
        """
        x, y, width, height = self.box
        return x, y, x + width, y + height

    @property
    def placed(self) -> bool:
        """Whether it has a place, perhaps only a guess."""
        return math.isfinite(self.ellipse.x)

    @property
    def searched(self) -> bool:
        """Whether it is searched for without a guess of its place; an absent one is not."""
        return not self.placed and self.status is not Status.ABSENT

    @property
    def visible(self) -> bool:
        """Whether it is in the picture: seen, or bridged between frames in which it was."""
        return self.status in (Status.TRACKING, Status.INTERPOLATED)

    @property
    def guessed(self) -> bool:
        """Whether its place is a guess: interpolated, or wrong more probably than right."""
        unsure = self.status is Status.TRACKING and self.confidence < SURE
        return self.status is Status.INTERPOLATED or unsure

    def number(self, name: str) -> float:
        """Return the number in a further column; NaN where it is not known."""
        value = self.further.get(name)
        return float(value) if isinstance(value, int | float) else math.nan

    def to_dict(self) -> dict[str, Any]:
        """Return the columns of a row file, with values that `json.dumps` takes.

        The keys are frame, time, id, label, those of the box (left, top, width, height) and of the
        ellipse (x, y, a, b, theta), confidence, belief, status, distance, effective_sample_size
        and occluded_by. Numbers are not rounded; one that is not finite is None.
        """
        sides = zip(BOX, self.box, strict=True)
        return {
            "frame": int(self.frame),
            "time": finite(self.time),
            "id": int(self.identity),
            "label": self.label or None,
            **{name: finite(value) for name, value in sides},
            **{name: finite(value) for name, value in self.ellipse._asdict().items()},
            "confidence": finite(self.confidence),
            "belief": finite(self.belief),
            "status": str(self.status),
            "distance": finite(self.distance),
            "effective_sample_size": finite(self.effective_sample_size),
            "occluded_by": self.occluded_by,
        }

    @classmethod
    def from_dict(cls, row: Mapping[str, Any]) -> Self:
        """Return the track of a row with a frame, an ellipse or a box, and what else is known.

        Numbers that are missing or None are NaN; other keys are further columns.

        Raises
        ------
        KeyError, TypeError, ValueError
            If a key is missing, or a value does not fit its column.
        """
        known = {name: value for name, value in row.items() if value is not None}

        def number(name: str) -> float:
            return float(known.get(name, math.nan))

        box = Box(*(float(known[name]) for name in BOX)) if "left" in known else None
        ellipse = Ellipse(*map(number, ELLIPSE))
        if box is not None and "x" not in known:
            ellipse = Ellipse.from_box(box)
        front = known.get("occluded_by")
        return cls(
            int(known["frame"]),
            number("time"),
            ellipse,
            np.diag([number(name) ** 2 for name in DEVIATIONS]),
            number("confidence"),
            Status(known.get("status", Status.TRACKING)),
            number("distance"),
            number("effective_sample_size"),
            number("belief"),
            outlier=known.get("outlier") == 1,
            identity=int(known.get("id", 1)),
            label=known.get("label"),
            occluded_by=None if front is None else int(front),
            further={name: known[name] for name in known if name not in COLUMNS},
            bounds=box,
        )

    def __repr__(self) -> str:
        box = ", ".join(f"{value:.1f}" for value in self.box)
        hidden = "" if self.occluded_by is None else f", occluded_by={self.occluded_by}"
        name = "" if self.label is None else f", label={self.label!r}"
        return (
            f"Track(frame={self.frame}, time={self.time:.3f} s, identity={self.identity}, "
            f"status={self.status}, box=({box}), confidence={self.confidence:.2f}{hidden}{name})"
        )


def finite(value: float) -> float | None:
    """Return a number for JSON: a Python float, or None if it is not finite."""
    return float(value) if math.isfinite(value) else None


def check_listed(tracks: object) -> None:
    """Raise a ConfigError if these are not the tracks of a frame."""
    if not isinstance(tracks, Collection) or not all(isinstance(each, Track) for each in tracks):
        raise ConfigError(f"Give a list of Tracks, as Scene.update returns it; got {tracks!r}.")
