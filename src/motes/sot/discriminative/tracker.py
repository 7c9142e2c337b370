"""The default tracker: particles over cues that learn the target against its surroundings.

A step is a partitioned particle filter (MacCormick and Isard, ECCV 2000): first the place, then the
size, then the exact place. Particles look their likelihood up in dense results: the response of a
correlation filter, and sums of the pixels' color posterior. The filter of the first frame is kept.
Its response and the color contrast at the estimate give the certainty. The tracker learns only
while it is certain; when it is not, it searches in the same frame.
"""

from __future__ import annotations

import math
from functools import cached_property
from typing import ClassVar

import numpy as np
from msgspec.structs import replace

from motes.core.config import Config, NonNegative, Particles, Positive
from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.saved_state import check, middle_of, rows
from motes.core.track import Status
from motes.core.types import Floats
from motes.cues.color_posterior import Posterior, borders, contrast
from motes.cues.correlation_filter import Correlation
from motes.cues.scale_filter import ScaleFilter
from motes.cues.search_window import CELL_SIZE
from motes.sot.algorithm import Algorithm
from motes.sot.discriminative import prediction
from motes.sot.discriminative.confidence_gate import ConfidenceGate, TargetStatus
from motes.sot.discriminative.light import Light
from motes.sot.discriminative.localization import Localizer, WindowEstimate
from motes.sot.discriminative.redetection import Redetection
from motes.sot.discriminative.report import (
    Reporter,
    particles_of,
    reported_ellipse,
    reported_size,
)
from motes.sot.discriminative.size_estimate import SizeEstimator
from motes.sot.discriminative.small_picture import small_picture
from motes.sot.discriminative.state import DiscriminativeInfo, DiscriminativeState
from motes.sot.discriminative.trend import Trend
from motes.sot.discriminative.turn_estimate import TurnEstimate
from motes.sot.filtering.appearance_rule import Calibration
from motes.sot.filtering.resampling import Resampling
from motes.sot.filtering.sample_size import KldSampling

RUNNING_MEAN_RATE = 0.05
"""Weight of a frame in the running means of contrast and borders."""
TURN_GAIN = 1.15
"""A turned window must be this many times as certain; otherwise noise would turn the target."""
FAR = 0.25
"""A prediction farther than this from the last place, in mean sides of the target, is checked if
the target is in doubt there."""
CENTERED = CELL_SIZE
"""A target up to this many samples from the center of the window needs no second window."""
NO_PARTICLES = np.empty((0, 5))
"""The search particles while nothing is searched for."""


class Discriminative(
    Algorithm[DiscriminativeState, DiscriminativeInfo],
    Config,
    frozen=True,
    dict=True,
    tag="discriminative",
):
    """The default tracker.

    Attributes
    ----------
    particles
        Number of particles that are spread over a window. As many search for a missed target.
    budget
        Number of particles after the first of three rounds: fewer where fewer places are likely.
    correlation
        Cue for the place: the correlation filter.
    posterior
        Cue for the place: the color posterior.
    color_gain
        Weight of color, relative to the color contrast of the target. With 0, gradients alone
        count, for the place and for the certainty.
    sigma
        The weight of a particle is exp(pool / sigma), where the pool joins both cues. With a larger
        value, the estimate is a mean over a larger area.
    resampling
        How particles are selected.
    scale
        Cue for the size: the scale filter.
    redetection
        How a missed target is searched for.
    border_gain
        Weight of the posterior at the border in the estimate of the size; the scale filter has
        weight 1.
    turn
        Angle of the turned windows that are tried when the tracker is not certain, in radians.
    gate
        How certain the tracker must be to learn, and to keep the target.
    calibration
        The map from 1 - certainty to the confidence.
    """

    state_type: ClassVar[type[DiscriminativeState]] = DiscriminativeState
    presence: ClassVar[None] = None

    particles: Particles = 400
    budget: KldSampling = KldSampling(min=100, max=400, bin=0.25)
    correlation: Correlation = Correlation(sharpness=1 / 12)
    posterior: Posterior = Posterior()
    color_gain: NonNegative = 1.0
    sigma: Positive = 0.02
    resampling: Resampling = Resampling(scheme="systematic", threshold=1.0)
    scale: ScaleFilter = ScaleFilter()
    redetection: Redetection = Redetection()
    border_gain: NonNegative = 0.2
    turn: Positive = 0.25
    gate: ConfidenceGate = ConfidenceGate()
    calibration: Calibration = Calibration(middle=0.73, width=0.05)

    @cached_property
    def cues(self) -> dict[str, Correlation | Posterior]:
        """The cues for the place, by name."""
        return {"correlation": self.correlation, "posterior": self.posterior}

    @cached_property
    def localizer(self) -> Localizer:
        """The localization in a window, with the values of this configuration."""
        return Localizer(
            particles=self.particles,
            budget=self.budget,
            correlation=self.correlation,
            posterior=self.posterior,
            color_gain=self.color_gain,
            sigma=self.sigma,
            resampling=self.resampling,
        )

    @cached_property
    def sizes(self) -> SizeEstimator:
        """The estimator of the size, with the values of this configuration."""
        return SizeEstimator(self.scale, self.border_gain, self.sigma, self.resampling)

    @cached_property
    def reporter(self) -> Reporter:
        """The maker of reports, with the values of this configuration."""
        return Reporter(self.particles, self.calibration, self.localizer)

    def init(
        self, rng: np.random.Generator, frame: Frame, region: Ellipse
    ) -> tuple[DiscriminativeState, DiscriminativeInfo]:
        """Learn the target in the box around `region` and start tracking it."""
        box = Ellipse.from_box(region.box)
        correlation = self.correlation.learn(frame, box)
        posterior = self.posterior.learn(frame, box)
        integral = self.posterior.integral(posterior, posterior.grid.sample_window(frame, box))
        middle = np.array([0.0, 0.0, *correlation.grid.half])
        first_contrast = contrast(integral, middle)
        state = DiscriminativeState(
            time=frame.time,
            ellipse=box,
            shape=region,
            correlation=correlation,
            posterior=posterior,
            scale=self.scale.learn(frame, box),
            appearance=self.redetection.learn(frame, box),
            contrast=first_contrast,
            first_contrast=first_contrast,
            border=borders(integral, middle[None])[0],
            search_particles=NO_PARTICLES,
            scale_due=True,
            factors=np.ones(1),
            size=Trend(),
            turn=TurnEstimate.begin(frame, region),
            target=TargetStatus(),
            motion=prediction.started(small_picture(frame)),
            light=Light(),
        )
        return state, self.reporter.report(state, frame, NO_PARTICLES, None, 1.0)

    def step(
        self, rng: np.random.Generator, state: DiscriminativeState, frame: Frame
    ) -> tuple[DiscriminativeState, DiscriminativeInfo]:
        """Predict; localize, also turned and by a search if needed; estimate the size; learn."""
        picture, before = small_picture(frame), state
        sight = prediction.predictions(state.motion, picture, frame)
        light = state.light.followed(*sight.shared)
        frame = light.taken_off(frame)
        look = self._look(rng, state, frame, sight.likeliest(state.motion))
        state = replace(state, ellipse=look.window_pose)
        turning = self._doubted(state, look) and not state.scale_due
        if turning:
            look = self._turn(rng, state, frame, look)
        missed = not self.gate.is_present(look.certainty, state.target.reference)
        elsewhere = None
        if missed and not (turning and state.target.frames_missed):
            state, elsewhere = self._search(rng, state, frame, look.certainty)
        look = elsewhere or look
        place, sized = look.pose, None
        if state.scale_due and elsewhere is None and self.gate.was_present(state.target):
            sized = self.sizes.estimate(rng, state.scale, state.border, frame, look)
            state, place = replace(state, factors=sized.factors), sized.pose
        spectra = sized.spectra if sized else None
        if place != look.pose or math.hypot(*look.box[:2].tolist()) > CENTERED:
            look, spectra = self.localizer.localize(rng, state, frame, place), None
        half_axis = sized.half_axis if sized else None
        jumped = elsewhere is not None
        after, info, learned = self._observe(state, frame, look, half_axis, jumped=jumped)
        if learned and state.scale_due:
            if spectra is None:
                spectra = self.scale.spectra(state.scale, frame, after.ellipse)
            after = replace(
                after, scale=self.scale.updated(state.scale, spectra, self.scale.learning_rate)
            )
        seen = elsewhere is None and not (before.target.frames_missed or after.target.frames_missed)
        motion = sight.update(before.motion, before.ellipse, after.ellipse if seen else None)
        light = light.learned(self.posterior.learning_rate) if learned else light
        return replace(after, motion=motion, light=light, scale_due=not state.scale_due), info

    def learn_also(
        self, state: DiscriminativeState, frame: Frame, region: Ellipse
    ) -> DiscriminativeState:
        """Return the state with learned models of both looks.

        The windows keep the proportions of the first box, as in all frames. The filter of the first
        frame, by which the certainty is judged, stays.
        """
        first, box = Ellipse.from_box(state.shape.box), Ellipse.from_box(region.box)
        grown = box.side / first.side
        place = box._replace(a=grown * first.a, b=grown * first.b)
        return replace(
            state,
            correlation=self.correlation.learn_also(state.correlation, frame, place),
            posterior=self.posterior.learn_also(state.posterior, frame, place),
        )

    def correct(
        self, state: DiscriminativeState, frame: Frame, region: Ellipse
    ) -> tuple[DiscriminativeState, DiscriminativeInfo]:
        """Put the target at `region` of the current frame; the learned models are kept."""
        state = replace(
            state,
            ellipse=Ellipse.from_box(region.box),
            shape=region,
            search_particles=NO_PARTICLES,
            size=Trend(),
            turn=TurnEstimate.begin(frame, region),
            target=state.target._replace(
                status=Status.TRACKING, frames_missed=0, confirmations=0, contradictions=0
            ),
        )
        return state, self.reporter.report(state, frame, NO_PARTICLES, None, 1.0)

    def check(self, state: DiscriminativeState, frame: Frame) -> DiscriminativeState:
        """Return a saved state; raise a ValueError if no frame leaves such a one."""
        middle = middle_of(frame, state.correlation.a, state.correlation.b)
        fresh, _ = self.init(np.random.default_rng(0), frame, Ellipse.from_box(middle.box))
        searchers = (
            rows(np.zeros(5), state.search_particles)
            if len(state.search_particles)
            else NO_PARTICLES
        )
        factors = rows(1.0, state.factors)
        turn = TurnEstimate.begin(frame, middle._replace(theta=state.shape.theta))
        fresh = replace(fresh, search_particles=searchers, factors=factors, turn=turn)
        check(state, fresh, "state")
        return state

    def _doubted(self, state: DiscriminativeState, look: WindowEstimate) -> bool:
        """Return whether the target is less certain than its first frames were."""
        return look.certainty < self.gate.relative_to_start * state.target.reference

    def _look(
        self, rng: np.random.Generator, state: DiscriminativeState, frame: Frame, shift: Floats
    ) -> WindowEstimate:
        """Return the estimate in the window at the predicted place, or at the last one.

        A far prediction may be wrong: if it is in doubt, the more certain of both places is taken.
        """
        last = state.ellipse
        x, y = np.clip(last[:2] + shift, 0, (frame.width - 1, frame.height - 1)).tolist()
        look = self.localizer.localize(rng, state, frame, last._replace(x=x, y=y))
        far = math.hypot(*shift.tolist()) > FAR * last.side
        if not (far and self._doubted(state, look)):
            return look
        there = self.localizer.localize(rng, state, frame, last)
        return max(look, there, key=lambda look: look.certainty)

    def _turn(
        self,
        rng: np.random.Generator,
        state: DiscriminativeState,
        frame: Frame,
        look: WindowEstimate,
    ) -> WindowEstimate:
        """Return the estimate, or a more certain one of a window turned to either side."""
        looks = [
            self.localizer.localize(
                rng, state, frame, look.window_pose._replace(theta=look.window_pose.theta + turn)
            )
            for turn in (-self.turn, self.turn)
        ]
        best = max(looks, key=lambda look: look.certainty)
        return best if best.certainty > TURN_GAIN * look.certainty else look

    def _search(
        self, rng: np.random.Generator, state: DiscriminativeState, frame: Frame, here: float
    ) -> tuple[DiscriminativeState, WindowEstimate | None]:
        """Return the state after the search, and the estimate at another place, if one is accepted.

        Parameters
        ----------
        here
            Certainty at the place without the search.
        """
        searchers = state.search_particles
        if not len(searchers):
            searchers = np.tile(np.array(state.ellipse), (self.particles, 1))
        searchers, places = self.redetection.step(
            rng, state.appearance, searchers, frame, state.ellipse, state.target.frames_missed + 1
        )
        looks = [self.localizer.localize(rng, state, frame, place) for place in places]
        best = max(looks, key=lambda look: look.certainty)
        there = best.certainty > here
        there &= self.gate.accepts_redetection(best.certainty, state.target.reference)
        return replace(state, search_particles=searchers), best if there else None

    def _observe(
        self,
        state: DiscriminativeState,
        frame: Frame,
        look: WindowEstimate,
        half_axis: float | None,
        *,
        jumped: bool,
    ) -> tuple[DiscriminativeState, DiscriminativeInfo, bool]:
        """Return the next state, the report, and whether the models learned from this frame.

        Parameters
        ----------
        half_axis
            The half-axis a in pixels, if the size was estimated.
        jumped
            Whether the search has found this place.
        """
        standing, there, learned = self.gate.update(
            state.target, look.certainty, look.response, jumped=jumped
        )
        followed = there or self.gate.may_move(look.certainty, state.target)
        found = look.pose if followed else state.ellipse
        if not learned and not jumped:  # an uncertain size is ignored
            found = found._replace(a=state.ellipse.a, b=state.ellipse.b)
        size = reported_size(state, found, half_axis, learned=learned, jumped=jumped)
        place = reported_ellipse(state.shape, found, size, found.theta)
        turned = found.theta - state.ellipse.theta
        seen = standing.status is Status.TRACKING
        after = replace(
            state,
            time=frame.time,
            ellipse=found,
            size=size,
            turn=state.turn.followed(frame, place, found.theta, turned, seen=seen),
            target=standing,
            search_particles=state.search_particles if standing.frames_missed else NO_PARTICLES,
        )
        if learned:
            after = self._learned(after, look)
        if not followed:  # perhaps without a search: only the last window was uncertain
            info = self.reporter.report(after, frame, state.search_particles, None, look.certainty)
            return after, info, learned
        ellipses = particles_of(look, state.factors, found)
        info = self.reporter.report(after, frame, ellipses, look.weights, look.certainty)
        return after, info, learned

    def _learned(self, state: DiscriminativeState, look: WindowEstimate) -> DiscriminativeState:
        """Return the state after learning from a frame."""
        x, y = look.box[:2].tolist()
        border = borders(look.integral, look.box[None])[0]
        correlation, posterior = self.correlation, self.posterior
        return replace(
            state,
            correlation=correlation.updated(
                state.correlation, look.spectra, correlation.learning_rate, x, y
            ),
            posterior=posterior.updated(
                state.posterior, look.window, posterior.learning_rate, x, y
            ),
            contrast=(1 - RUNNING_MEAN_RATE) * state.contrast + RUNNING_MEAN_RATE * look.contrast,
            border=(1 - RUNNING_MEAN_RATE) * state.border + RUNNING_MEAN_RATE * border,
        )
