"""The mean-shift tracker that Nummiaro et al. compare with (section VI).

One hypothesis climbs the Bhattacharyya coefficient by the mean-shift vector of Comaniciu, Ramesh
and Meer (CVPR 2000), for three sizes. It starts from the last place.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import ClassVar

import msgspec
import numpy as np

from motes.core.config import Config
from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.track import Status, Track
from motes.cues.base import Cue
from motes.cues.color import Color, ColorModel
from motes.cues.sampling import DENSE, EveryPixel, Lattice
from motes.sot.algorithm import Algorithm, StepInfo
from motes.sot.filtering.appearance_rule import AppearanceRule, BackgroundStatistics, Calibration

SCALE = 0.05
"""Step of the size: sizes of 1 - SCALE, 1 and 1 + SCALE times the last one are compared."""
ITERATIONS = 20
"""Largest number of shifts for each size; most end after a few, by the tolerance."""
TOLERANCE = 0.5
"""The iterations end with a shift of fewer pixels: less than a place can be read to."""


@dataclass(frozen=True, slots=True, eq=False)
class ShiftState:
    """The state after a frame."""

    ellipse: Ellipse
    """The only hypothesis."""
    model: ColorModel
    background: BackgroundStatistics
    """The target model, and the background statistics of the appearance rule."""
    status: Status
    frames_missed: int
    """The status, and the number of frames in a row that failed the appearance rule."""


class MeanShift(Algorithm[ShiftState], Config, frozen=True, tag="mean_shift"):
    """A tracker with one hypothesis.

    Its color cue reads every pixel, so the appearance rule measures the background at fewer
    positions by default, and reads a lattice of each large region there.
    """

    state_type: ClassVar[type[ShiftState]] = ShiftState

    color: Color = Color(kernel="epanechnikov", sampling=EveryPixel())
    """The target's histogram of colors. The shift reads the same pixels."""
    presence: AppearanceRule = AppearanceRule(max_positions=5000)
    """The appearance rule: whether the target is present, and when it is lost or found. The only
    hypothesis must fulfill it."""
    calibration: Calibration = Calibration(middle=0.245, width=0.066)
    """The map from the distance between estimate and target model to the confidence."""

    @property
    def cues(self) -> dict[str, Cue]:
        """The only cue, by name."""
        return {"color": self.color}

    def init(
        self, rng: np.random.Generator, frame: Frame, region: Ellipse
    ) -> tuple[ShiftState, StepInfo]:
        """Learn the target in `region` and start tracking it; draws no random numbers."""
        model = self.color.learn(frame, region)
        reading = self.color
        if region.area > DENSE and not isinstance(reading.sampling, Lattice):
            # Thousands of regions of every pixel would take half a minute on 12 megapixels.
            reading = msgspec.structs.replace(reading, sampling=Lattice(points=DENSE))
        background = self.presence.background(reading, model, frame, region, target_in_frame=True)
        begun = ShiftState(region, model, background, Status.TRACKING, frames_missed=0)
        return self._observe(begun, frame, region)

    def step(
        self, rng: np.random.Generator, state: ShiftState, frame: Frame
    ) -> tuple[ShiftState, StepInfo]:
        """Climb with three sizes, keep the most similar place; draws no random numbers."""
        start = state.ellipse
        found = [
            self._climb(state.model, frame, start._replace(a=start.a * size, b=start.b * size))
            for size in (1.0, 1 - SCALE, 1 + SCALE)
            if size >= 1 or min(start.a, start.b) * size >= 1
        ]
        distances = self.color.distances(state.model, frame, np.array(found))
        return self._observe(state, frame, found[int(np.argmin(distances))])

    def learn_also(self, state: ShiftState, frame: Frame, region: Ellipse) -> ShiftState:
        """Return the state with a model of both looks, and the background of the other frame."""
        model = self.color.learn_also(state.model, frame, region)
        background = self.presence.background(
            self.color, model, frame, region, target_in_frame=True
        )
        return replace(state, model=model, background=background)

    def correct(
        self, state: ShiftState, frame: Frame, region: Ellipse
    ) -> tuple[ShiftState, StepInfo]:
        """Put the target at `region` of the current frame; the target model is kept."""
        state = replace(state, status=Status.TRACKING, frames_missed=0)
        return self._observe(state, frame, region)

    def _climb(self, model: ColorModel, frame: Frame, ellipse: Ellipse) -> Ellipse:
        """Shift the ellipse to more similar places until it moves less than the tolerance."""
        distance = self._distance(model, frame, ellipse)
        for _ in range(ITERATIONS):
            x, y = self.color.shift(model, frame, ellipse)
            moved = ellipse._replace(x=x, y=y)
            step = math.hypot(x - ellipse.x, y - ellipse.y)
            after = self._distance(model, frame, moved)
            while after > distance and step >= TOLERANCE:
                moved = moved._replace(x=(moved.x + ellipse.x) / 2, y=(moved.y + ellipse.y) / 2)
                step /= 2
                after = self._distance(model, frame, moved)
            if after > distance:
                break
            ellipse, distance = moved, after
            if step < TOLERANCE:
                break
        return ellipse

    def _distance(self, model: ColorModel, frame: Frame, ellipse: Ellipse) -> float:
        return float(self.color.distances(model, frame, np.array([ellipse], float))[0])

    def _observe(
        self, state: ShiftState, frame: Frame, ellipse: Ellipse
    ) -> tuple[ShiftState, StepInfo]:
        """Return the state and the report for the ellipse that was found."""
        found = self.presence.regions(ellipse, frame)
        distances = self.color.distances(state.model, frame, found)
        counted = float(self.presence.counted(distances, found, frame)[0])
        appears = 1 - counted**2 > self.presence.threshold(state.background)
        rho = 1 - distances**2
        around = float(rho[1:].mean()) if rho.size > 1 else 0.0
        there = self.presence.holds(state.status, appears, float(rho[0]), around, 0.0)
        status, missed = self.presence.next_status(state.status, there, state.frames_missed)
        distance = float(distances[0])
        sure = self.calibration.probability(distance) * there
        track = Track(
            frame.index, frame.time, ellipse, np.zeros((5, 5)), sure, status, distance, 1.0
        )
        models, weights = {"color": state.model}, {"color": 1.0}
        info = StepInfo(track, np.array([ellipse]), np.ones(1), int(appears), models, weights)
        return replace(state, ellipse=ellipse, status=status, frames_missed=missed), info
