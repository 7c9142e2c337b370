"""What a tracker says about one frame."""

from __future__ import annotations

from enum import StrEnum

import msgspec

from motes.core.geometry import Box, Ellipse
from motes.core.types import Floats


class Status(StrEnum):
    """Where a tracker is: searching → tracking → lost → searching."""

    SEARCHING = "searching"
    """The target is looked for; the ellipse is the best guess, not a finding."""
    TRACKING = "tracking"
    """The target is followed."""
    OCCLUDED = "occluded"
    """Something hides the target; the ellipse is where it should be. Only a `Scene` says so."""
    LOST = "lost"
    """This frame ended the tracking; from the next one on the target is searched for."""


class Track(msgspec.Struct, frozen=True, eq=False):
    """Where the target is in one frame, and how sure the tracker is.

    Attributes
    ----------
    frame, time
        Index of the frame and its time in seconds.
    ellipse
        The estimate; `box` is the box around it.
    covariance
        (5, 5), of x, y, a, b, theta over the weighted particles; pixels and radians.
    confidence
        0 to 1: the estimated probability that `box` overlaps the target by more than half, times
        the weight of the particles that fulfill the appearance rule.
    status
        See `Status`.
    distance
        Distance between the target model and the estimate's region, 0 (same) to 1.
    effective_sample_size
        1 to the number of particles.
    """

    frame: int
    time: float
    ellipse: Ellipse
    covariance: Floats
    confidence: float
    status: Status
    distance: float
    effective_sample_size: float

    @property
    def box(self) -> Box:
        """The axis-parallel box around the ellipse: x, y, width, height."""
        return self.ellipse.box
