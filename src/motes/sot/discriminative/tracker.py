"""The default tracker: experts of different kinds that check each other, joined by particles.

A step is a partitioned particle filter (MacCormick and Isard, ECCV 2000): first the place, then the
size. Particles find the target in a near window, by gradients and colors (`localization.py`).
Experts of other kinds (`expert.py`) say where they see it, or that it is not there: a filter that
is confined to the target in a wide window, and a memory of what was there before (`backdrop.py`).
Where they part, both places are followed until the evidence of the next frames decides, and nothing
is learned meanwhile (`rival.py`). The evidence of a place is the sum of the log odds that the
near window and the experts give it. It decides whether the target is there, and so whether the
tracker learns or searches. Whether it is the target or a neighbor who looks alike is a belief
(`belief.py`) that is reported and changes nothing else. A trained network, if there is one,
follows the target beside the particles (`network_track.py`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence, Set
from typing import ClassVar

import numpy as np
from msgspec.structs import replace

from motes.core.frame import Frame
from motes.core.geometry import Ellipse, iou
from motes.core.saved_state import in_types_of, middle_of
from motes.core.track import Status
from motes.cues.color import borders, contrast
from motes.cues.search_window import CELL_SIZE
from motes.sot.algorithm import Algorithm, StepInfo
from motes.sot.discriminative import prediction
from motes.sot.discriminative.belief import GAIN, Belief
from motes.sot.discriminative.config import DiscriminativeConfig
from motes.sot.discriminative.exclusion import BESIDE, Claim, Taken, excluded
from motes.sot.discriminative.expert import probability
from motes.sot.discriminative.localization import WindowEstimate
from motes.sot.discriminative.network_track import AGREES, NetworkTrack
from motes.sot.discriminative.placing import NO_PARTICLES, evidence_at, find, search, turned
from motes.sot.discriminative.prediction import Light, small_picture
from motes.sot.discriminative.report import (
    at_region,
    particles_of,
    report,
    reported_ellipse,
    reported_size,
)
from motes.sot.discriminative.rival import DECIDED, Rival
from motes.sot.discriminative.size import Trend, TurnEstimate, estimated
from motes.sot.discriminative.standing import Standing
from motes.sot.discriminative.state import DiscriminativeState

RUNNING_MEAN_RATE = 0.05
"""Weight of a frame in the running means of contrast, borders and likeness."""


class Discriminative(
    DiscriminativeConfig,
    Algorithm[DiscriminativeState],
    frozen=True,
    dict=True,
    tag="discriminative",
):
    """The default tracker."""

    state_type: ClassVar[type[DiscriminativeState]] = DiscriminativeState
    presence: ClassVar[None] = None

    def init(
        self, rng: np.random.Generator, frame: Frame, region: Ellipse
    ) -> tuple[DiscriminativeState, StepInfo]:
        """Learn the target in the box around `region` and start tracking it."""
        box = Ellipse.from_box(region.box)
        correlation = self.correlation.learn(frame, box)
        posterior = self.posterior.learn(frame, box)
        window = posterior.grid.sample_window(frame, box)
        integral, border = self.posterior.integrals(posterior, window)
        middle = np.array([0.0, 0.0, *correlation.grid.half])
        state = DiscriminativeState(
            ellipse=box,
            shape=region,
            correlation=correlation,
            posterior=posterior,
            experts=self.experts.learn(frame, box),
            scale=self.scale.learn(frame, box),
            appearance=self.redetection.learn(frame, box),
            contrast=contrast(integral, middle),
            taken=Taken(),
            border=borders(border, middle[None])[0],
            search_particles=NO_PARTICLES,
            scale_due=True,
            factors=np.ones(1),
            size=Trend(),
            turn=TurnEstimate.begin(frame, region),
            standing=Standing(),
            reported=Standing(),
            rival=Rival(box),
            motion=prediction.started(small_picture(frame)),
            light=Light(),
            belief=Belief.begin(frame, box),
            network=NetworkTrack.begin(self.network, frame, box) if self.network else None,
        )
        return state, report(self, state, frame)

    def step(
        self, rng: np.random.Generator, state: DiscriminativeState, frame: Frame
    ) -> tuple[DiscriminativeState, StepInfo]:
        """Predict; localize, also turned and by a search if needed; estimate the size; learn."""
        picture = small_picture(frame)
        expected = prediction.predictions(state.motion, picture, frame)
        light = state.light.followed(*expected.shared)
        frame = light.taken_off(frame)
        found = find(self, rng, state, frame, expected)
        if not state.scale_due and found.estimate.evidence < DECIDED and not found.jumped:
            found = found._replace(estimate=turned(self, rng, state, frame, found.estimate))
        if found.estimate.evidence < 0:
            found = search(self, rng, state, frame, found)
        estimate, jumped = found.estimate, found.jumped
        standing = state.standing.after(estimate.evidence, jumped=jumped)
        learned = not (standing.missed or found.rival.alive)
        pose, sized = estimate.pose, learned and state.scale_due
        if sized:
            pose, factors = estimated(self, rng, state.scale, state.border, frame, estimate)
            state = replace(state, factors=factors)
        elif not (learned or jumped):  # an uncertain size is ignored
            pose = pose._replace(a=state.ellipse.a, b=state.ellipse.b)
        size = reported_size(state, pose, sized=sized, learned=learned, jumped=jumped)
        place = reported_ellipse(state.shape, pose, size, pose.theta)
        turn, seen = pose.theta - state.ellipse.theta, standing.status is Status.TRACKING
        after = replace(
            state,
            ellipse=pose,
            size=size,
            turn=state.turn.followed(frame, place, pose.theta, turn, seen=seen),
            standing=standing,
            rival=found.rival,
            search_particles=found.searchers if standing.missed else NO_PARTICLES,
            scale_due=not state.scale_due,
        )
        if learned:
            after = self._learned(after, frame, estimate)
            light = light.learned(self.posterior.learning_rate)
        steady = not (jumped or state.standing.missed or standing.missed)
        motion = expected.update(state.motion, state.ellipse, pose if steady else None)
        experts = self.experts.updated(state.experts, frame, estimate.sights, pose, float(learned))
        belief = state.belief.after(frame, pose, motion.camera, seen=estimate.evidence > 0)
        # A tracked target is lost once that is decided: with less, part of it is often there.
        margin = DECIDED if state.reported.status is Status.TRACKING else 0.0
        certain = probability(estimate.evidence + margin) * belief.probability
        reported = state.reported.after(certain - 0.5, jumped=jumped)
        after = replace(
            after, motion=motion, light=light, experts=experts, belief=belief, reported=reported
        )
        info = report(self, after, frame, estimate, particles_of(estimate, state, pose))
        after, info = self._joined(rng, after, frame, info, estimate.evidence)
        return replace(after, taken=Taken()), info

    def stacked(self, first: DiscriminativeState, second: DiscriminativeState) -> bool:
        """Return whether targets of one frame overlap by more than `BESIDE`."""
        return bool(iou(first.ellipse.box, second.ellipse.box) > BESIDE)

    def displaced(
        self,
        before: Sequence[DiscriminativeState],
        after: Sequence[DiscriminativeState],
        stacked: Set[tuple[int, int]] = frozenset(),
    ) -> dict[int, DiscriminativeState]:
        """Return the states of the targets that are where another one is; see `exclusion.py`."""
        claims = {}
        for index, (last, state) in enumerate(zip(before, after, strict=True)):
            if state.standing.confirmed:
                missed = last.standing.missed > 0 or bool(last.taken.places)
                leap = last.motion.leap(last.ellipse, state.ellipse)
                against = GAIN * state.belief.distance + DECIDED * missed + leap
                claims[index] = Claim(last.ellipse, state.ellipse, missed, against)
        again = {}
        for index, (places, overlap) in excluded(claims, stacked).items():
            taken = Taken(before[index].taken.places + places, overlap)
            again[index] = replace(before[index], taken=taken)
        return again

    def learn_also(
        self, state: DiscriminativeState, frame: Frame, region: Ellipse
    ) -> DiscriminativeState:
        """Return the state with learned models of both looks.

        The windows keep the proportions of the first box, as in all frames. The filter and the
        histograms of the first frame, which never learn, stay.
        """
        first, box = Ellipse.from_box(state.shape.box), Ellipse.from_box(region.box)
        grown = box.side / first.side
        place = box._replace(a=grown * first.a, b=grown * first.b)
        return replace(
            state,
            correlation=self.correlation.learn_also(state.correlation, frame, place),
            posterior=self.posterior.learn_also(state.posterior, frame, place),
            experts=self.experts.learn_also(state.experts, frame, place),
            belief=state.belief.learned_also(frame, place),
        )

    def correct(
        self, state: DiscriminativeState, frame: Frame, region: Ellipse
    ) -> tuple[DiscriminativeState, StepInfo]:
        """Put the target at `region` of the current frame; the learned models are kept."""
        box = Ellipse.from_box(region.box)
        state = replace(
            state,
            ellipse=box,
            shape=region,
            search_particles=NO_PARTICLES,
            size=Trend(),
            turn=TurnEstimate.begin(frame, region),
            standing=Standing(),
            reported=Standing(),
            rival=Rival(box),
            experts=self.experts.placed(state.experts, box),
            belief=state.belief.placed(frame, box),
            network=state.network and state.network.placed(box),
        )
        return state, report(self, state, frame)

    def typed(self, state: DiscriminativeState, frame: Frame) -> DiscriminativeState:
        """Return a saved state with the experts' models in their types."""
        middle = middle_of(frame, state.correlation.a, state.correlation.b)
        models = in_types_of(self.experts.learn(frame, middle), state.experts, "state.experts")
        if (state.network is None) is not (self.network is None):
            raise ValueError("state.network is not that of the configuration")
        return replace(state, experts=models)

    def _joined(
        self,
        rng: np.random.Generator,
        state: DiscriminativeState,
        frame: Frame,
        info: StepInfo,
        evidence: float,
    ) -> tuple[DiscriminativeState, StepInfo]:
        """Return the state and the report after the network, if there is one, has looked too.

        The confidence is the geometric mean of both where they agree, so that either can doubt, and
        half of one's where they part: one of two places. `evidence` is that of the particles'.
        """
        if self.network is None or state.network is None:
            return state, info
        track, network = info.track, state.network.followed(self.network, frame)
        own = probability(evidence)  # without the belief, which moves nothing
        if iou(network.place.box, track.box) > AGREES:
            network, region = network.agreed(), network.mean(track.box, own)
            confidence = math.sqrt(track.confidence * network.score)
            unseen = state.standing.status is not Status.TRACKING
            again = unseen and network.score > own and not state.taken.holds(network.place)
        else:
            there = evidence_at(self, rng, state, frame, network.place)
            network = network.compared(there - evidence)
            region = network.place if network.ahead else track.ellipse
            confidence = (network.score if network.ahead else track.confidence) / 2
            again = network.decided and network.ahead
            if network.ahead:  # the belief is of the particles' place
                info = replace(info, track=replace(track, belief=math.nan))
        standing = network.standing.after(confidence - 0.5, jumped=False)  # its sign counts
        if again:
            state, _ = self.correct(state, frame, region)
        if network.decided:
            network = network.placed(Ellipse.from_box(region.box))
        state = replace(state, network=replace(network, standing=standing))
        return state, at_region(info, region, confidence, standing.status)

    def _learned(
        self, state: DiscriminativeState, frame: Frame, estimate: WindowEstimate
    ) -> DiscriminativeState:
        """Return the state after learning from a frame, in a window at the target."""
        correlation, posterior, pose = self.correlation, self.posterior, state.ellipse
        window, spectra = estimate.window, estimate.spectra
        integral, box = estimate.integral, estimate.box
        resized = pose[2:4] != estimate.window_pose[2:4]
        if resized or math.hypot(*box[:2].tolist()) > CELL_SIZE:  # more than a cell off its center
            grid = state.correlation.grid
            window = grid.sample_window(frame, pose)
            spectra = correlation.spectra(grid, window)
            integral = posterior.integral(state.posterior, window)
            box = np.array([0.0, 0.0, *grid.half])
        x, y = box[:2].tolist()
        scale = state.scale
        if not state.scale_due:  # it was in this frame
            sizes = self.scale.spectra(scale, frame, pose)
            scale = self.scale.updated(scale, sizes, correlation.learning_rate)
        kept = 1 - RUNNING_MEAN_RATE
        border = borders(integral, box[None])[0]
        return replace(
            state,
            correlation=correlation.updated(
                state.correlation, spectra, correlation.learning_rate, x, y
            ),
            posterior=posterior.updated(state.posterior, window, posterior.learning_rate, x, y),
            appearance=self.redetection.updated(state.appearance, frame, pose, RUNNING_MEAN_RATE),
            scale=scale,
            contrast=kept * state.contrast + RUNNING_MEAN_RATE * estimate.contrast,
            border=kept * state.border + RUNNING_MEAN_RATE * border,
        )
