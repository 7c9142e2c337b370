"""The particle filter: one pure step, after Nummiaro et al., figure 2.

With several cues, after Maggio et al., section 4, or Ng and Delp.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import ClassVar

import numpy as np
from msgspec.structs import replace

from motes import kernels
from motes.core.config import Config, Particles
from motes.core.errors import ConfigError
from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.registry import tag_of
from motes.core.saved_state import in_types_of, middle_of
from motes.core.track import TRACKING, Status, Track
from motes.core.types import Floats, check_finite
from motes.cues.base import CUES, AdaptableCue, Cue
from motes.cues.color import Color, Posterior
from motes.cues.correlation_filter import Correlation
from motes.cues.gradients import Edges, Hog
from motes.cues.structure_tensor import Orientation
from motes.sot.algorithm import Algorithm, StepInfo
from motes.sot.filtering.appearance_rule import AppearanceRule, BackgroundStatistics, Calibration
from motes.sot.filtering.color_step import ColorStep
from motes.sot.filtering.fusion import Fixed, Fusion, fuse_distances
from motes.sot.filtering.likelihood import Gaussian, Likelihood
from motes.sot.filtering.model_update import (
    Adaptation,
    ExponentialForgetting,
    PerCue,
    Strategy,
    UpdaterState,
    update_models,
)
from motes.sot.filtering.motion import LONGEST_INTERVAL, ConstantVelocity, Motion
from motes.sot.filtering.resampling import (
    KldSampling,
    Multinomial,
    Resampling,
    Weights,
    mean_ellipse,
)
from motes.sot.known_target import scatter
from motes.sot.particle_state import FilterState, Model, Observation


class ParticleFilter(Algorithm[FilterState], Config, frozen=True, dict=True, tag="particle_filter"):
    """A tracker with many hypotheses, the particles. It needs at least one cue."""

    state_type: ClassVar[type[FilterState]] = FilterState
    open_field: ClassVar[str | None] = "extra_cues"

    particles: Particles = 100
    """Number of particles. More are more exact and slower. With `budget` it is the number in the
    first frame only, within the limits of that."""
    motion: Motion = ConstantVelocity()
    """The motion model: how particles move from frame to frame."""
    color: Color | None = None
    """Cue: the target's histogram of colors."""
    orientation: Orientation | None = None
    """Cue: the target's histogram of edge orientations, from the structure tensor."""
    edges: Edges | None = None
    """Cue: the target's histogram of strong Sobel edges."""
    hog: Hog | None = None
    """Cue: the target's histograms of oriented gradients."""
    correlation: Correlation | None = None
    """Cue: a learned correlation filter over gradients and colors."""
    posterior: Posterior | None = None
    """Cue: the posterior of the target's colors against its surroundings."""
    extra_cues: dict[str, Cue] = {}  # noqa: RUF012  (msgspec copies it)
    """Cues of other packages, by name. In files and options they stand among the other keys."""
    fusion: Fusion = Fixed()
    """The rule by which the likelihoods of several cues become one weight for each particle."""
    likelihood: Likelihood = Gaussian()
    """The map from a particle's distance to the target model to its likelihood, for each cue."""
    resampling: Resampling = Multinomial()
    """When particles are resampled, and by which method."""
    presence: AppearanceRule = AppearanceRule()
    """The appearance rule: whether the target is present, and when it is lost or found."""
    calibration: Calibration = Calibration()
    """The map from the distance to the target model, and the particles' spread, to the
    confidence."""
    adaptation: Adaptation = ExponentialForgetting()
    """The update of the target models' histograms, in frames in which the target is present. The
    cues `correlation` and `posterior` have learning rates of their own."""
    budget: KldSampling | None = None
    """The rule for the number of particles of the next frame. Without it, the number is always
    `particles`."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.cues:
            raise ConfigError(f"A particle filter needs a cue: {', '.join(CUES.names())}.")
        self._check_cues_named()

    def _check_cues_named(self) -> None:
        """Raise a ConfigError if a part names a cue that is not in use, or has its own rate."""
        weighted = self.fusion.weights if isinstance(self.fusion, Fixed) else {}
        updated = self.adaptation.cues if isinstance(self.adaptation, PerCue) else {}
        for key, names in (("fusion.weights", weighted), ("adaptation.cues", updated)):
            if other := next((name for name in names if name not in self.cues), None):
                raise ConfigError(
                    f"{key} names {other!r}; the cues in use are {', '.join(self.cues)}."
                )
        if other := next((name for name in updated if name not in self.strategies), None):
            raise ConfigError(
                f"adaptation.cues names {other!r}, whose model has a learning_rate of its own; "
                f"leave it out there."
            )

    @cached_property
    def cues(self) -> dict[str, Cue]:
        """The cues in use, by name."""
        fields = {name: getattr(self, name) for name in self.__struct_fields__}
        return {n: cue for n, cue in fields.items() if isinstance(cue, Cue)} | self.extra_cues

    @cached_property
    def strategies(self) -> dict[str, Strategy]:
        """How the models that are histograms learn, by their cue's name."""
        names = [name for name, cue in self.cues.items() if isinstance(cue, AdaptableCue)]
        return {name: self.adaptation.strategy(name) for name in names}

    @cached_property
    def learns(self) -> bool:
        """Whether any model ever changes."""
        cues = self.cues.values()
        own = any(type(cue).update_reading is not Cue.update_reading for cue in cues)
        return own or any(strategy.learns for strategy in self.strategies.values())

    @cached_property
    def color_step(self) -> ColorStep | None:
        """The compiled step that gives the same as one part by part; None for most filters."""
        return ColorStep.of(self.resampling, self.motion, self.cues, self.likelihood, self.presence)

    def init(
        self, rng: np.random.Generator, frame: Frame, region: Ellipse
    ) -> tuple[FilterState, StepInfo]:
        """Learn the target in `region` and start tracking it: initialization by hand."""
        # The motion model may swap the half-axes and turn the ellipse by a right angle.
        region = Ellipse(*self.motion.ellipses(self.motion.initial(np.array([region])))[0].tolist())
        models = {name: cue.learn(frame, region) for name, cue in self.cues.items()}
        backgrounds = self._backgrounds(models, frame, region, target_in_frame=True)
        places = np.array([[0.0, 0.0, frame.width, frame.height]])
        start = np.tile(np.array(region), (self._first_count, 1))
        return self._begin(frame, start, models, backgrounds, region, places, Status.TRACKING)

    def search(
        self,
        rng: np.random.Generator,
        frame: Frame,
        models: dict[str, Model],
        size: Ellipse,
        places: Floats | None = None,
        background: Frame | None = None,
    ) -> tuple[FilterState, StepInfo]:
        """Start looking for a target whose model is known: initialization by a known histogram.

        Parameters
        ----------
        models, size
            The target's model for each cue, and an ellipse of its size; its center is not used.
        places
            (R, 4) boxes where the target may appear, such as doors; by default the whole frame.
        background
            An image without the target; by default `frame`.
        """
        if places is None:
            places = np.array([[0.0, 0.0, frame.width, frame.height]])
        backgrounds = self._backgrounds(models, background or frame, size, target_in_frame=False)
        start = scatter(rng, places, size, self._first_count)
        status = Status.SEARCHING
        return self._begin(frame, start, models, backgrounds, size, places, status, known=True)

    def hand_over(
        self, frame: Frame, models: dict[str, Model], samples: Floats
    ) -> tuple[FilterState, StepInfo]:
        """Start with the samples and models that another tracker gives: section VII.

        Samples are (N, 5) ellipses where the target may be, the first particles; there is a model
        for each cue. The status is that of the appearance rule: `tracking` if the target is there.
        """
        size, _ = mean_ellipse(samples, np.full(len(samples), 1 / len(samples)))
        backgrounds = self._backgrounds(models, frame, size, target_in_frame=True)
        low, high = samples[:, :2].min(axis=0), samples[:, :2].max(axis=0)
        places = np.array([[*low, *np.maximum(high - low, 1.0)]])
        status = Status.SEARCHING
        return self._begin(frame, samples, models, backgrounds, size, places, status)

    def step(
        self,
        rng: np.random.Generator,
        state: FilterState,
        frame: Frame,
        expected: Floats | None = None,
    ) -> tuple[FilterState, StepInfo]:
        """Select, propagate, observe and estimate (figure 2), then judge and learn.

        A target that is searched for is first looked for at `expected`, ellipses (N, 5) where
        another tracker sees it (section VII). If it is there, they are the particles.

        While the target is searched for, half of the particles move on, and the other half is
        spread over the search regions.
        """
        absent = state.status is not TRACKING
        # A known target that has just appeared is looked at more closely before it counts as found.
        searching = absent and not state.frames_missed
        if absent and expected is not None:
            # The other tracker has seen it for long enough, so one frame is enough here.
            anew = replace(state, known=False, frames_missed=0)
            states, prior = self.motion.initial(expected), np.zeros(len(expected))
            after, info = self._judge(anew, frame, self._observe(anew, frame, states, prior))
            if info.track.status is Status.TRACKING:
                return replace(after, known=state.known), info
        n = self.particles if self.budget is None else self._count(state, self.budget)
        dt, first = min(frame.time - state.time, LONGEST_INTERVAL), state.reference_size
        if self.color_step is not None and not searching:
            return self._judge(state, frame, self.color_step.step(rng, frame, state, n, dt))
        states, prior = state.states, state.weights.log
        if searching or n != len(states) or self.resampling.due(state.weights):
            states = states.take(self.resampling.ancestors(rng, state.weights, n), axis=0)
            prior = np.zeros(n)
        states = self.motion.propagate(rng, states, dt, first)
        if searching:
            fresh = scatter(rng, state.search_regions, first, (n + 1) // 2)
            # The half is random: systematic selection returns ancestors in order, and a fixed half
            # would always drop the same particles.
            replaced = rng.choice(n, len(fresh), replace=False)
            states[replaced] = self.motion.initial(fresh)
        return self._judge(state, frame, self._observe(state, frame, states, prior))

    def learn_also(self, state: FilterState, frame: Frame, region: Ellipse) -> FilterState:
        """Return the state with models of both looks, and the background of the other frame."""
        models = state.models
        models = {n: cue.learn_also(models[n], frame, region) for n, cue in self.cues.items()}
        backgrounds = self._backgrounds(models, frame, region, target_in_frame=True)
        return replace(state, models=models, backgrounds=backgrounds)

    def correct(
        self, state: FilterState, frame: Frame, region: Ellipse
    ) -> tuple[FilterState, StepInfo]:
        """Put the target at `region` of the current frame; the target model is kept."""
        states = self.motion.initial(np.tile(np.array(region), (self._first_count, 1)))
        state = replace(state, status=Status.TRACKING, frames_missed=0)
        seen = self._observe(state, frame, states, np.zeros(self._first_count))
        return self._judge(state, frame, seen)

    def typed(self, state: FilterState, frame: Frame) -> FilterState:
        """Return a saved state with models and memories in their types, which the cues know."""
        middle = middle_of(frame, *state.reference_size[2:4])
        models = {name: cue.learn(frame, middle) for name, cue in self.cues.items()}
        memories = dict[str, UpdaterState]()
        for name in filter(self.strategies.get, state.memories):
            flat = np.full_like(models[name].histogram, 1 / len(models[name].histogram))
            memory = self.strategies[name].learn(None, flat, flat, flat).memory
            if memory is not None:
                memories[name] = memory
        models = in_types_of(models, state.models, "state.models")
        memories = in_types_of(memories, state.memories, "state.memories")
        return replace(state, models=models, memories=memories)

    @property
    def _first_count(self) -> int:
        """How many particles there are where no spread tells it: `particles`, as allowed."""
        return self.particles if self.budget is None else self.budget.allowed(self.particles)

    def _count(self, state: FilterState, budget: KldSampling) -> int:
        """Return how many particles the next frame gets."""
        # Particles at one place, as at the start, do not show how far they will spread.
        if (state.states == state.states[0]).all():
            return self._first_count
        return budget.count(self.motion.ellipses(state.states), state.reference_size)

    def _backgrounds(
        self, models: Mapping[str, Model], frame: Frame, region: Ellipse, *, target_in_frame: bool
    ) -> dict[str, BackgroundStatistics]:
        found = {}
        for name, cue in self.cues.items():
            found[name] = self.presence.background(
                cue, models[name], frame, region, target_in_frame=target_in_frame
            )
            check_finite(found[name].mean, "cue", name)
        return found

    def _begin(
        self,
        frame: Frame,
        ellipses: Floats,
        models: dict[str, Model],
        backgrounds: dict[str, BackgroundStatistics],
        first: Ellipse,
        places: Floats,
        status: Status,
        *,
        known: bool = False,
    ) -> tuple[FilterState, StepInfo]:
        state = FilterState(
            time=frame.time, states=self.motion.initial(ellipses),
            weights=Weights.uniform(len(ellipses)), models=models, memories={},
            backgrounds=backgrounds, reference_size=first, search_regions=places,
            status=status, frames_missed=0, known=known,
        )  # fmt: skip
        seen = self._observe(state, frame, state.states, np.zeros(len(ellipses)))
        return self._judge(state, frame, seen)

    def _observe(
        self, state: FilterState, frame: Frame, states: Floats, prior: Floats
    ) -> Observation:
        """Weight new states, with log-weights `prior`, by the frame, and estimate the target."""
        if self.color_step is not None:  # which resamples in every frame, so that no prior is left
            return self.color_step.observe(frame, state, states)
        models = state.models
        ellipses = self.motion.ellipses(states)
        check_finite(ellipses, "motion model", tag_of(type(self.motion)))
        distances = self._distances(models, frame, ellipses)
        names = list(self.cues)
        logs = self.likelihood.log(distances)
        weights, shares = self.fusion.fuse(names, prior, logs, ellipses)
        estimate, covariance = mean_ellipse(ellipses, weights.values)
        reliability = self.fusion.reliability(names)
        spread = kernels.particles.spread(covariance, estimate[2:4])
        overall = fuse_distances(distances, reliability)
        regions = self.presence.regions(estimate, frame)
        seen = fuse_distances(self._distances(models, frame, regions), reliability)
        distance = float(seen[0])
        around = float((1 - seen[1:] ** 2).mean()) if seen.size > 1 else 0.0
        each = map(self.presence.threshold, state.backgrounds.values())
        threshold = sum(share * one for share, one in zip(reliability.tolist(), each, strict=True))
        counted = self.presence.counted(overall, ellipses, frame)
        appearing, support = kernels.particles.appearing(counted, weights.values, threshold)
        return Observation(
            states, ellipses, weights, dict(zip(names, shares.tolist(), strict=True)),
            estimate, covariance, spread, weights.effective_sample_size,
            distance, around, appearing, support,
        )  # fmt: skip

    def _distances(self, models: Mapping[str, Model], frame: Frame, ellipses: Floats) -> Floats:
        """Return the distances (J, N) of ellipses (N, 5) by each cue."""
        distances = []
        for name, cue in self.cues.items():
            distances.append(cue.distances(models[name], frame, ellipses))
            check_finite(distances[-1], "cue", name)
        return np.array(distances)

    def _judge(
        self, state: FilterState, frame: Frame, seen: Observation
    ) -> tuple[FilterState, StepInfo]:
        """Decide whether the target is there, and learn from it if so."""
        appears = seen.appearing > self.presence.fraction * len(seen.states)
        rho = 1 - seen.distance**2
        there = self.presence.holds(state.status, appears, rho, seen.around, seen.spread)
        status, missed = self.presence.next_status(
            state.status, there, state.frames_missed, known=state.known
        )
        models, memories = state.models, state.memories
        # A model learns at most once from a frame.
        if self.learns and there and frame.time > state.time:
            models, memories = update_models(
                self.cues, self.strategies, models, memories, frame, seen.estimate
            )
        confidence = self.calibration.probability(seen.distance, seen.spread)
        if not self.calibration.spread:
            confidence *= min(1.0, seen.support)
        track = Track(
            frame.index, frame.time, seen.estimate, seen.covariance, confidence, status,
            seen.distance, seen.effective_sample_size,
        )  # fmt: skip
        info = StepInfo(
            track, seen.ellipses, seen.weights.values, seen.appearing, state.models, seen.shares
        )
        after = replace(
            state, time=frame.time, states=seen.states, weights=seen.weights,
            models=models, memories=memories, status=status, frames_missed=missed,
        )  # fmt: skip
        return after, info
