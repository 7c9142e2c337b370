"""The appearance rule: whether the target is present.

Nummiaro et al., section V, equations 11 to 13.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from msgspec import Meta

from motes.core.config import Config, Count, NonNegative, Positive, Share
from motes.core.frame import Frame
from motes.core.geometry import Ellipse, as_ellipse
from motes.core.track import TRACKING, Status
from motes.core.types import Floats
from motes.cues.base import Cue


@dataclass(frozen=True, slots=True, eq=False)
class BackgroundStatistics:
    """Mean and standard deviation of the background's similarity rho to a target."""

    mean: float
    deviation: float


class AppearanceRule(Config, frozen=True):
    """A particle shows the target if its rho is above mu + 2 sigma of the background.

    Equation 13: rho is the similarity to the target model, mu and sigma are the mean and the
    standard deviation of the background's rho.
    """

    fraction: Annotated[float, Meta(ge=0, lt=1)] = 0.1
    """Share f of the particles: the target is present if more than this share fulfills the rule.
    With a larger value it counts as lost sooner."""
    frames: Count = 5
    """A tracked target is lost after this many frames in a row in which it is not present. The
    paper has "a couple of frames"."""
    found_frames: Count = 5
    """A target that is known before it is seen, as by a histogram in a file, is found after this
    many frames in a row in which it is present; also after it was lost. With a larger value it is
    found later, and others that resemble it in single frames are not taken for it. In the paper it
    is 1."""
    deviations: NonNegative = 2.0
    """The threshold lies this many standard deviations above the mean similarity rho of the
    background. With a larger value a particle must be more similar to the target."""
    margin: Share = 0.0
    """Least height of the threshold: share of the way from the background's mean similarity to 1.
    With a larger value a particle must be more similar to the target; 0 is the paper's rule, which
    is of random places, but particles gather where the background is most similar."""
    contrast: Share = 0.0
    """Share of the way from the mean rho of the regions at the corners of its box to 1 that the
    estimate's rho must be above. With a larger value the target counts as lost sooner. With 0, the
    paper's rule, nothing is compared; else a target that is tracked need not fulfill equation 13,
    as light that changes lowers all rho."""
    spread: NonNegative = 0.0
    """Largest standard deviation of the particles' places, in mean half-axes of the estimate. With
    a smaller value a target counts as lost sooner. 0 allows any, as the paper's rule does."""
    max_threshold: Share = 0.9
    """Largest value of the threshold, a rho from 0 to 1. Where a gray or dim background resembles
    the target, it would otherwise be above 1, which no target reaches."""
    in_frame: bool = False
    """If true, a particle whose center lies outside the frame does not fulfill the rule: equations
    11 and 12 are of regions whose centers lie in the frame."""
    max_positions: Count = 20_000
    """Largest number of positions at which the background is measured, evenly spread. A smaller
    value is faster and less exact."""

    def background(
        self, cue: Cue, model: Any, frame: Frame, region: Ellipse, *, target_in_frame: bool
    ) -> BackgroundStatistics:
        """Return mean and standard deviation of rho over the frame (equations 11 and 12).

        Parameters
        ----------
        cue, model
            The cue, and the target model that it compares with.
        frame
            The background image, or a frame with the target in it.
        region
            The target's region; a region of this size is moved over the frame.
        target_in_frame
            Whether the frame shows the target in `region`. Pixels where the moved region would
            overlap it are then left out, unless no others are left.
        """
        region = as_ellipse(region)
        step = math.ceil(math.sqrt(frame.width * frame.height / self.max_positions))
        y, x = np.mgrid[: frame.height : step, : frame.width : step]
        moved = np.empty((x.size, 5))
        moved[:, 0], moved[:, 1], moved[:, 2:] = x.ravel(), y.ravel(), region[2:]
        if target_in_frame:
            box = region.box
            beside = (abs(moved[:, 0] - region.x) > box.width) | (
                abs(moved[:, 1] - region.y) > box.height
            )
            if beside.any():
                moved = moved[beside]
        rho = 1 - cue.distances(model, frame, moved) ** 2
        return BackgroundStatistics(float(rho.mean()), float(rho.std()))

    def threshold(self, background: BackgroundStatistics) -> float:
        """Return the rho above which a particle shows the target (equation 13)."""
        threshold = max(
            background.mean + self.deviations * background.deviation,
            background.mean + self.margin * (1 - background.mean),
        )
        return min(threshold, self.max_threshold)

    def regions(self, estimate: Ellipse, frame: Frame) -> Floats:
        """Return the estimate, and with a contrast those at its corners in the frame, (n, 5)."""
        right, down = estimate.box.width / 2, estimate.box.height / 2
        signs = [(-1, -1), (1, -1), (-1, 1), (1, 1)] if self.contrast else []
        corners = [(estimate.x + i * right, estimate.y + j * down) for i, j in signs]
        inside = [(x, y) for x, y in corners if 0 <= x < frame.width and 0 <= y < frame.height]
        return np.array([estimate, *((x, y, *estimate[2:]) for x, y in inside)])

    def holds(self, last: Status, appears: bool, rho: float, around: float, spread: float) -> bool:
        """Return whether the target is there, whose status was `last`.

        `appears`: enough particles fulfill equation 13. `rho` is the estimate's, `around` the mean
        of the regions beside it. `spread` is in mean half-axes.
        """
        if self.spread and spread > self.spread:
            return False
        if not self.contrast:
            return appears
        least = min(around + self.contrast * (1 - around), self.max_threshold)
        return rho > least and (appears or last is TRACKING)

    def counted(self, distances: Floats, ellipses: Floats, frame: Frame) -> Floats:
        """Return the distances (N,) that the rule counts; 1, the largest, where `in_frame` refuses.

        `ellipses` (N, 5) are the particles, of which the centers matter.
        """
        if not self.in_frame:
            return distances
        half = 0.5  # the center of a pixel has whole coordinates
        centers = ellipses[:, :2]
        inside = (centers >= -half) & (centers < [frame.width - half, frame.height - half])
        return np.where(inside.all(axis=1), distances, 1.0)

    def next_status(
        self, before: Status, there: bool, against: int, *, known: bool = False
    ) -> tuple[Status, int]:
        """Return the status after a frame, and how many frames in a row were against it.

        A tracked target is lost after `frames` in which the rule did not hold. A searched one is
        found in one frame; if it is `known` before it is seen, in `found_frames`.
        """
        if there is (before is TRACKING):
            return before if there else Status.SEARCHING, 0
        against += 1
        if there:
            if against >= (self.found_frames if known else 1):
                return Status.TRACKING, 0
            return Status.SEARCHING, against
        if against >= self.frames:
            return Status.LOST, 0
        return Status.TRACKING, against


class Calibration(Config, frozen=True):
    """The confidence: probability that the estimate covers the target, by what the rule judges.

    odds = exp((middle - d) / width) / (4 s)^spread, with the estimate's distance d and the standard
    deviation s of the particles' places, in mean half-axes: a logistic fit, over frames of 24 real
    sequences and 13 films, of "the estimate's box overlaps the true one by more than half". In the
    sources of motes, benchmarks/calibration.py has its error on those left out of the fit.
    """

    middle: Share = 0.33
    """Distance at which the confidence is one half. A larger value gives higher confidences."""
    width: Positive = 0.09
    """Width of the fall around `middle`, as a distance. With a larger value it is less steep."""
    spread: NonNegative = 0.0
    """Power of the spread. With a larger value the confidence falls more where particles spread.
    With 0 it is multiplied by the weight of those that fulfill equation 13 instead."""

    def probability(self, distance: float, spread: float = 0.25) -> float:
        """Return the probability for an estimate at this distance to the target model.

        `spread` is that of the particles; below 0.02 it counts as 0.02. The default is a usual one.
        """
        steps = (distance - self.middle) / self.width
        steps += self.spread * math.log(4 * max(spread, 0.02))
        # The hyperbolic tangent cannot overflow.
        return 0.5 - 0.5 * math.tanh(steps / 2)
