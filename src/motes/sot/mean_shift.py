"""The mean-shift tracker that Nummiaro et al. compare with (section VI).

One hypothesis climbs the Bhattacharyya coefficient by the mean-shift vector of Comaniciu, Ramesh
and Meer (CVPR 2000), for three sizes. It may start from the prediction of a Kalman filter
(Comaniciu and Ramesh, ICIP 2000).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Annotated, ClassVar

import msgspec
import numpy as np
from msgspec import Meta

from motes.core.config import Config, Count, Positive, Share
from motes.core.frame import FRAME_INTERVAL, Frame
from motes.core.geometry import Ellipse
from motes.core.saved_state import LEAST_HALF, SAME, check, middle_of
from motes.core.track import Status, Track
from motes.core.types import Floats
from motes.cues.base import Cue
from motes.cues.color import Color, ColorModel
from motes.cues.sampling import DENSE, EveryPixel, Lattice
from motes.sot.algorithm import Algorithm
from motes.sot.filtering.appearance_rule import AppearanceRule, BackgroundStatistics, Calibration
from motes.sot.filtering.motion import LONGEST_INTERVAL
from motes.sot.step_info import StepInfo


class Kalman(Config, frozen=True, tag="kalman"):
    """Constant-velocity Kalman filter for the center; x and y share one covariance.

    Attributes
    ----------
    acceleration
        Standard deviation of the velocity's change in 1/25 s, as a share of the mean half-axis of
        the first region. With a larger value the prediction follows the last mean-shift results
        more.
    measurement
        Standard deviation of the error of the mean-shift result, as a share of the mean half-axis
        of the first region. With a larger value the prediction is smoother.
    """

    acceleration: Positive = 0.5
    measurement: Positive = 0.2

    def predict(self, mean: Floats, covariance: Floats, dt: float, unit: float) -> Moments:
        """Return mean (2, 2), rows position and velocity, and covariance (2, 2), dt s later."""
        steps = dt / FRAME_INTERVAL
        move = np.array([[1.0, steps], [0.0, 1.0]])
        noise = np.array([[steps**4 / 4, steps**3 / 2], [steps**3 / 2, steps**2]])
        noise *= (self.acceleration * unit) ** 2
        return move @ mean, move @ covariance @ move.T + noise

    def update(self, mean: Floats, covariance: Floats, center: Floats, unit: float) -> Moments:
        """Return mean and covariance after the center (2,) was measured."""
        gain = covariance[:, 0] / (covariance[0, 0] + (self.measurement * unit) ** 2)
        mean = mean + np.outer(gain, center - mean[0])
        return mean, covariance - np.outer(gain, covariance[0])


Moments = tuple[Floats, Floats]


@dataclass(frozen=True, slots=True, eq=False)
class ShiftState:
    """The state after a frame.

    Attributes
    ----------
    time
        Time of the last frame, in seconds.
    ellipse
        The only hypothesis.
    model, background
        The target model, and the background statistics of the appearance rule.
    unit
        Mean half-axis of the first region, in pixels.
    mean, covariance
        (2, 2) each: of the Kalman filter. The rows of the mean are position and velocity.
    status, frames_missed
        The status, and the number of frames in a row that failed the appearance rule.
    """

    time: Annotated[float, SAME]
    ellipse: Ellipse
    model: ColorModel
    background: BackgroundStatistics
    unit: Annotated[float, Meta(ge=LEAST_HALF)]
    mean: Floats
    covariance: Floats
    status: Status
    frames_missed: int


class MeanShift(Algorithm[ShiftState], Config, frozen=True, tag="mean_shift"):
    """A tracker with one hypothesis.

    Its color cue reads every pixel, so the appearance rule measures the background at fewer
    positions by default, and reads a lattice of each large region there.

    Attributes
    ----------
    color
        The target's histogram of colors. The shift reads the same pixels.
    prediction
        A Kalman filter, whose prediction is the start of the search. Without it, the last position
        is the start.
    scale
        Step of the size: sizes of 1 - scale, 1 and 1 + scale times the last one are compared, and
        the most similar one is kept. A larger value follows faster growth, in coarser steps.
    iterations
        Largest number of shifts for each size. More are slower and reach farther.
    tolerance
        The iterations end with a shift of fewer than this many pixels. A larger value is faster and
        less exact.
    presence
        The appearance rule: whether the target is present, and when it is lost or found. The only
        hypothesis must fulfill it.
    calibration
        The map from the distance between estimate and target model to the confidence.
    """

    state_type: ClassVar[type[ShiftState]] = ShiftState

    color: Color = Color(kernel="epanechnikov", sampling=EveryPixel())
    prediction: Kalman | None = None
    scale: Share = 0.05
    iterations: Count = 20
    tolerance: Positive = 0.5
    presence: AppearanceRule = AppearanceRule(max_positions=5000)
    calibration: Calibration = Calibration(middle=0.245, width=0.066)

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
        return self._observe(_begun(frame, region, model, background), frame, region)

    def step(
        self, rng: np.random.Generator, state: ShiftState, frame: Frame
    ) -> tuple[ShiftState, StepInfo]:
        """Predict, climb with three sizes, keep the most similar one; draws no random numbers."""
        start, mean, covariance = state.ellipse, state.mean, state.covariance
        if self.prediction:
            dt = min(frame.time - state.time, LONGEST_INTERVAL)
            mean, covariance = self.prediction.predict(mean, covariance, dt, state.unit)
            inside = np.clip(mean[0], 0, [frame.width - 1, frame.height - 1])
            start = start._replace(x=float(inside[0]), y=float(inside[1]))
        found = [
            self._climb(state.model, frame, start._replace(a=start.a * size, b=start.b * size))
            for size in (1.0, 1 - self.scale, 1 + self.scale)
            if size >= 1 or min(start.a, start.b) * size >= 1
        ]
        distances = self.color.distances(state.model, frame, np.array(found))
        ellipse = found[int(np.argmin(distances))]
        if self.prediction:
            mean, covariance = self.prediction.update(
                mean, covariance, np.array([ellipse.x, ellipse.y]), state.unit
            )
        state = replace(state, time=frame.time, mean=mean, covariance=covariance)
        return self._observe(state, frame, ellipse)

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
        state = replace(
            state,
            mean=np.array([[region.x, region.y], [0.0, 0.0]]),
            covariance=np.diag([0.0, state.unit**2]),
            status=Status.TRACKING,
            frames_missed=0,
        )
        return self._observe(state, frame, region)

    def check(self, state: ShiftState, frame: Frame) -> ShiftState:
        """Return a saved state; raise a ValueError if no frame leaves such a state."""
        middle = middle_of(frame, 1.0, 1.0)  # for any size, histograms have the same shape
        model = self.color.learn(frame, middle)
        check(state, _begun(frame, middle, model, BackgroundStatistics(0.0, 0.0)), "state")
        return state

    def _climb(self, model: ColorModel, frame: Frame, ellipse: Ellipse) -> Ellipse:
        """Shift the ellipse to more similar places until it moves less than the tolerance."""
        distance = self._distance(model, frame, ellipse)
        for _ in range(self.iterations):
            x, y = self.color.shift(model, frame, ellipse)
            moved = ellipse._replace(x=x, y=y)
            step = math.hypot(x - ellipse.x, y - ellipse.y)
            after = self._distance(model, frame, moved)
            while after > distance and step >= self.tolerance:
                moved = moved._replace(x=(moved.x + ellipse.x) / 2, y=(moved.y + ellipse.y) / 2)
                step /= 2
                after = self._distance(model, frame, moved)
            if after > distance:
                break
            ellipse, distance = moved, after
            if step < self.tolerance:
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


def _begun(
    frame: Frame, region: Ellipse, model: ColorModel, background: BackgroundStatistics
) -> ShiftState:
    """Return the state at the start."""
    unit = math.sqrt(region.a * region.b)
    return ShiftState(
        time=frame.time,
        ellipse=region,
        model=model,
        background=background,
        unit=unit,
        mean=np.array([[region.x, region.y], [0.0, 0.0]]),
        covariance=np.diag([0.0, unit**2]),
        status=Status.TRACKING,
        frames_missed=0,
    )
