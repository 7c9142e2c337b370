"""The particle filter: one pure step, after Nummiaro et al., figure 2."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motes.config import Config, Count, Share
from motes.cues.color import Color, ColorModel
from motes.estimate import mean_ellipse
from motes.frame import Frame
from motes.geometry import Ellipse
from motes.likelihood import Gaussian
from motes.motion import LONGEST_INTERVAL, ConstantVelocity, RandomWalk, SecondOrder
from motes.presence import AppearanceRule, Background, Calibration
from motes.resampling import Resampling, Weights
from motes.track import Status, Track

Floats = NDArray[np.float64]


class Adaptation(Config, frozen=True):
    """How the target model learns: slowly, and only while the appearance rule holds.

    Nummiaro et al. name such models in sections IV and VIII.

    Attributes
    ----------
    rate
        Share of each frame's estimate that enters the model; 0 keeps the model fixed.
    anchor
        Share of the first frame's model that is kept for good.
    """

    rate: Share = 0.0
    anchor: Share = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class FilterState:
    """What the next step needs.

    Attributes
    ----------
    time
        Of the last frame, in seconds.
    states
        (N, d) the particles, in the motion model's columns.
    weights
        Theirs, after the last frame.
    model
        The target model.
    background
        What the appearance rule compares with.
    first
        The target's first region; all noise is proportional to its size.
    places
        (R, 4) boxes over which particles are spread in a search.
    status, missed
        Where the tracker is, and for how many frames in a row the appearance rule has failed.
    """

    time: float
    states: Floats
    weights: Weights
    model: ColorModel
    background: Background
    first: Ellipse
    places: Floats
    status: Status
    missed: int


@dataclass(frozen=True, slots=True, eq=False)
class Info:
    """What an observer of a step may want.

    Attributes
    ----------
    track
        The estimate.
    ellipses
        (N, 5) the particles: x, y, a, b, theta.
    weights
        (N,) their probabilities after this frame.
    distances
        (N,) to the target model.
    appearing
        Number of particles that fulfill the appearance rule.
    model
        The target model that this frame was compared with.
    """

    track: Track
    ellipses: Floats
    weights: Floats
    distances: Floats
    appearing: int
    model: ColorModel


class ParticleFilter(Config, frozen=True, tag="particle_filter"):
    """A tracker with many hypotheses.

    Attributes
    ----------
    particles
        How many: N.
    motion
        How the target moves.
    cue
        What pixels say about an ellipse.
    likelihood
        From the cue's distance to a log-likelihood.
    resampling
        When and how particles are selected.
    presence
        When the target counts as there, lost and found.
    calibration
        From the estimate's distance to its confidence.
    adaptation
        How the target model learns.
    """

    particles: Count = 100
    motion: RandomWalk | ConstantVelocity | SecondOrder = ConstantVelocity()
    cue: Color = Color()
    likelihood: Gaussian = Gaussian()
    resampling: Resampling = Resampling()
    presence: AppearanceRule = AppearanceRule()
    calibration: Calibration = Calibration()
    adaptation: Adaptation = Adaptation()

    def init(
        self, rng: np.random.Generator, frame: Frame, region: Ellipse
    ) -> tuple[FilterState, Info]:
        """Learn the target in `region` and start tracking it: initialization by hand."""
        model = self.cue.learn(frame, region)
        background = self.presence.background(self.cue, model, frame, region, target_in_frame=True)
        places = np.array([[0.0, 0.0, frame.width, frame.height]])
        start = np.tile(np.array(region), (self.particles, 1))
        return self._begin(frame, start, model, background, region, places, Status.TRACKING)

    def search(
        self,
        rng: np.random.Generator,
        frame: Frame,
        model: ColorModel,
        size: Ellipse,
        places: Floats | None = None,
        background: Frame | None = None,
    ) -> tuple[FilterState, Info]:
        """Start looking for a target whose model is known: initialization by a known histogram.

        Parameters
        ----------
        rng
            Source of randomness.
        frame
            The first frame.
        model, size
            The target's model, and an ellipse of its size; the center does not matter.
        places
            (R, 4) boxes where it may appear, such as doors and borders; else the whole frame.
        background
            An image without the target; else `frame` is taken for one.
        """
        if places is None:
            places = np.array([[0.0, 0.0, frame.width, frame.height]])
        rule = self.presence.background(
            self.cue, model, background or frame, size, target_in_frame=False
        )
        start = spread(rng, places, size, self.particles)
        return self._begin(frame, start, model, rule, size, places, Status.SEARCHING)

    def step(
        self, rng: np.random.Generator, state: FilterState, frame: Frame
    ) -> tuple[FilterState, Info]:
        """Select, propagate, observe and estimate (figure 2), then judge and learn.

        While the target is searched for, half of the particles go on from where they are, and the
        other half is spread anew over the places where it may appear.
        """
        searching = state.status is not Status.TRACKING
        states, weights = state.states, state.weights
        if searching or self.resampling.due(weights):
            states = states[self.resampling.ancestors(rng, weights)]
            weights = Weights.uniform(self.particles)
        dt = min(frame.time - state.time, LONGEST_INTERVAL)
        states = self.motion.propagate(rng, states, dt, state.first)
        if searching:
            fresh = spread(rng, state.places, state.first, (self.particles + 1) // 2)
            # A random half: most schemes return ancestors in order, so that any fixed half would
            # lose some particles for certain, however good.
            replaced = rng.choice(self.particles, len(fresh), replace=False)
            states[replaced] = self.motion.initial(fresh)
        return self._observe(state, frame, states, weights)

    def correct(
        self, state: FilterState, frame: Frame, region: Ellipse
    ) -> tuple[FilterState, Info]:
        """Put the target at `region` of the current frame; the target model is kept."""
        states = self.motion.initial(np.tile(np.array(region), (self.particles, 1)))
        state = replace(state, status=Status.TRACKING, missed=0)
        weights = Weights.uniform(self.particles)
        after, info = self._observe(state, frame, states, weights)
        return replace(after, model=state.model), info

    def _begin(
        self,
        frame: Frame,
        ellipses: Floats,
        model: ColorModel,
        background: Background,
        first: Ellipse,
        places: Floats,
        status: Status,
    ) -> tuple[FilterState, Info]:
        state = FilterState(
            time=frame.time,
            states=self.motion.initial(ellipses),
            weights=Weights.uniform(self.particles),
            model=model,
            background=background,
            first=first,
            places=places,
            status=status,
            missed=0,
        )
        return self._observe(state, frame, state.states, state.weights)

    def _observe(
        self, state: FilterState, frame: Frame, states: Floats, weights: Weights
    ) -> tuple[FilterState, Info]:
        """Weigh the new states by the frame, estimate, judge whether the target is there, learn."""
        ellipses = self.motion.ellipses(states)
        distances = self.cue.distances(state.model, frame, ellipses)
        weights = Weights.from_log(weights.log + self.likelihood.log(distances))
        estimate, covariance = mean_ellipse(ellipses, weights.values)
        distance = float(self.cue.distances(state.model, frame, np.array([estimate]))[0])
        appears = self.presence.holds(state.background, distances)
        appearing = int(np.count_nonzero(appears))
        there = appearing > self.presence.fraction * self.particles
        status, missed = self.presence.next_status(state.status, there, state.missed)
        model = state.model
        if there and self.adaptation.rate > 0:
            model = self.cue.adapt(
                model, frame, estimate, self.adaptation.rate, self.adaptation.anchor
            )
        track = Track(
            frame=frame.index,
            time=frame.time,
            ellipse=estimate,
            covariance=covariance,
            confidence=self.calibration.probability(distance)
            * min(1.0, float(weights.values[appears].sum())),
            status=status,
            distance=distance,
            effective_sample_size=weights.effective_sample_size,
        )
        info = Info(track, ellipses, weights.values, distances, appearing, state.model)
        after = replace(
            state,
            time=frame.time,
            states=states,
            weights=weights,
            model=model,
            status=status,
            missed=missed,
        )
        return after, info


def spread(rng: np.random.Generator, places: Floats, size: Ellipse, n: int) -> Floats:
    """Return n ellipses (n, 5) of one size, centers uniform over the boxes `places` (R, 4)."""
    area = places[:, 2] * places[:, 3]
    chosen = places[rng.choice(len(places), n, p=area / area.sum())]
    ellipses = np.empty((n, 5))
    ellipses[:, :2] = chosen[:, :2] - 0.5 + rng.random((n, 2)) * chosen[:, 2:]
    ellipses[:, 2:] = size[2:]
    return ellipses
