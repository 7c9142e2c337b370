"""The interface of tracking algorithms: pure steps to the next state, and what each reports."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence, Set
from typing import Any, ClassVar, Generic, TypeVar

import msgspec
import numpy as np

from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.registry import Registry
from motes.core.track import Track
from motes.core.types import Floats
from motes.cues.base import Cue
from motes.sot.filtering.appearance_rule import AppearanceRule


class StepInfo(msgspec.Struct, frozen=True, eq=False):
    """What any observer of a step can read."""

    track: Track
    """The estimate."""
    ellipses: Floats = np.empty((0, 5))
    """(N, 5) the hypotheses, such as particles: x, y, a, b, theta. There may be none."""
    weights: Floats = np.empty(0)
    """(N,) their probabilities after this frame."""
    n_supporting: int | None = None
    """Number of hypotheses that fulfill the appearance rule; None without such a rule."""
    models: Mapping[str, Any] = {}
    """The target model of each cue."""
    cue_weights: Mapping[str, float] = {}
    """The weight of each cue; they sum to 1."""
    note: str | None = None
    """A line about the region of a first frame that holds nothing to follow; None elsewhere."""


S = TypeVar("S")


class Algorithm(Generic[S]):
    """A tracking algorithm with states of type `S`.

    It is also a `Config` with a tag. Its methods are pure: they change nothing that they are given,
    and all randomness comes from `rng`. A state holds everything that the next step needs.
    """

    __slots__ = ()

    state_type: ClassVar[type[Any]]
    """The type `S`; a saved state is read as this type."""

    @property
    @abstractmethod
    def cues(self) -> Mapping[str, Cue]:
        """The cues in use, by name."""

    @property
    @abstractmethod
    def presence(self) -> AppearanceRule | None:
        """The appearance rule; None if the algorithm has another rule for lost targets."""

    @abstractmethod
    def init(self, rng: np.random.Generator, frame: Frame, region: Ellipse) -> tuple[S, StepInfo]:
        """Learn the target in `region`, an ellipse in the first frame, and start tracking it."""

    @abstractmethod
    def step(self, rng: np.random.Generator, state: S, frame: Frame) -> tuple[S, StepInfo]:
        """Find the target in the next frame, which has a later time than that of `state`.

        It returns the state after this frame, and a report of it.
        """

    def stacked(self, first: S, second: S) -> bool:
        """Return whether targets of one frame lie upon each other, as a person and his shirt do.

        By default none do.
        """
        return False

    def displaced(
        self, before: Sequence[S], after: Sequence[S], stacked: Set[tuple[int, int]] = frozenset()
    ) -> dict[int, S]:
        """Return states to step from anew, by index, of targets found where another one is.

        Parameters
        ----------
        before, after
            The states of targets in one video, before a frame and after it.
        stacked
            Pairs of indices, the lower one first, of targets that may be at one place: they were
            placed upon each other.

        Returns
        -------
        Some of `before`, which now also know where their targets are not. By default there are
        none: each target is followed as if it were alone.
        """
        return {}

    def learn_also(self, state: S, frame: Frame, region: Ellipse) -> S:
        """Return a state that was just begun, whose target also looks as in another frame's region.

        The place of the target stays. By default, nothing is learned.
        """
        return state

    @abstractmethod
    def correct(self, state: S, frame: Frame, region: Ellipse) -> tuple[S, StepInfo]:
        """Put the target at an ellipse `region` of the frame of `state`; the target model is kept.

        It returns the new state and a report of the same frame.
        """

    def typed(self, state: S, frame: Frame) -> S:
        """Return a saved state of a frame, with parts of type `Any` in their types.

        By default there are none.

        Raises
        ------
        ValueError
            If the state is of another configuration.
        """
        return state


TRACKERS = Registry[type[Algorithm[Any]]](
    "tracker",
    "motes.trackers",
    Algorithm,
    {
        "particle_filter": "motes.sot.particle_filter:ParticleFilter",
        "mean_shift": "motes.sot.mean_shift:MeanShift",
        "discriminative": "motes.sot.discriminative.tracker:Discriminative",
    },
)
