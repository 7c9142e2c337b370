"""A track: where an object is in one frame."""

from __future__ import annotations

import math
from enum import StrEnum
from typing import Any

import msgspec

from motes.core.geometry import Box, Ellipse
from motes.core.types import Floats


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


class Track(msgspec.Struct, frozen=True, eq=False):
    """Where an object is in one frame, and how sure the tracker is: what a row holds.

    Where an object of a `Scene` is not seen, its place is only predicted, with confidence 0: it is
    `occluded` where another object covers it, else `lost`, as in its last frame.
    """

    frame: int
    time: float
    """Index of the frame and its time in seconds."""
    ellipse: Ellipse
    """The estimate; `box` is the box around it."""
    covariance: Floats
    """(5, 5), of x, y, a, b, theta over the weighted particles; pixels and radians."""
    confidence: float
    """0 to 1: the estimated probability that `box` overlaps the target by more than half, times the
    weight of the particles that fulfill the appearance rule."""
    status: Status
    """See `Status`."""
    distance: float
    """Distance between the target model and the estimate's region, 0 (same) to 1."""
    effective_sample_size: float
    """1 to the number of particles."""
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

    @property
    def gone(self) -> bool:
        """Whether this is its last frame: it is `lost`, and not sought."""
        return self.status is Status.LOST and not self.sought

    @property
    def box(self) -> Box:
        """The axis-parallel box around the ellipse: x, y, width, height."""
        return self.ellipse.box

    @property
    def xyxy(self) -> tuple[float, float, float, float]:
        """The box as left, top, right and bottom: x, y, x + width, y + height.

        This is the form that supervision, torchvision and most detectors take.
        """
        x, y, width, height = self.box
        return x, y, x + width, y + height

    def to_dict(self) -> dict[str, Any]:
        """Return the columns of a row file, with values that `json.dumps` takes.

        The keys are frame, time, id, label, those of the box (left, top, width, height) and of the
        ellipse (x, y, a, b, theta), confidence, status, distance, effective_sample_size and
        occluded_by. Numbers are not rounded; one that is not finite is None.
        """
        sides = zip(("left", "top", "width", "height"), self.box, strict=True)
        return {
            "frame": int(self.frame),
            "time": finite(self.time),
            "id": int(self.identity),
            "label": self.label,
            **{name: finite(value) for name, value in sides},
            **{name: finite(value) for name, value in self.ellipse._asdict().items()},
            "confidence": finite(self.confidence),
            "status": str(self.status),
            "distance": finite(self.distance),
            "effective_sample_size": finite(self.effective_sample_size),
            "occluded_by": self.occluded_by,
        }

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
