"""The result of a frame, and the outputs that take it: of one target, or of several objects."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol, Self

from motes.core.frame import Frame
from motes.core.track import Status, Track
from motes.rows.journal import FrameRow, ObjectRow, object_rows
from motes.rows.schema import hindsight
from motes.sot.step_info import StepInfo

if TYPE_CHECKING:
    from motes.mot.analytics.events import Event
    from motes.mot.analytics.real_units import GroundPlace
    from motes.mot.tracked_object import SceneTrack


class Hindsight(StepInfo, frozen=True, eq=False):
    """What is known of a frame in hindsight: a track without particles."""


@dataclass(frozen=True, slots=True)
class Moment:
    """The result of a frame.

    Attributes
    ----------
    frame
        The frame.
    info
        The report of the tracker of one target; None before it has one.
    seconds
        Time of the tracker.
    place
        The target's place on the ground; None if it is not measured, or not seen.
    tracks, events
        Several objects, and what they do.
    single
        Whether it is of one target, which `tracks` does not have.
    """

    frame: Frame
    info: StepInfo | None = None
    seconds: float = 0.0
    place: GroundPlace | None = None
    tracks: Sequence[SceneTrack] = ()
    events: Sequence[Event] = ()
    single: bool = True

    @property
    def picture(self) -> FrameRow:
        """The rows of the frame."""
        if not self.single:
            return FrameRow(self.frame.index, self.frame.time, object_rows(self.tracks))
        known = hindsight(self.info.track) if isinstance(self.info, Hindsight) else {}
        further = known if self.place is None else known | self.place.columns
        target = ObjectRow.of_target(self.track, further)
        return FrameRow(self.frame.index, self.frame.time, (target,))

    @property
    def track(self) -> Track | None:
        """The target's track; None before there is a target."""
        return self.info.track if self.info else None

    @property
    def status(self) -> Status:
        """The track's status; without a track, searching."""
        return self.info.track.status if self.info else Status.SEARCHING


Moments = Callable[[Iterator[Frame]], Generator[Moment, None, None]]
"""Makes the results of a run from its frames."""


class Sink(AbstractContextManager[object], Protocol):
    """An output: it takes the result of each frame, and is closed as a context manager."""

    @abstractmethod
    def write(self, moment: Moment, /) -> None:
        """Add a frame."""

    @property
    def result(self) -> str | None:
        """The name of what was written, for the summary; None for nothing."""
        return None

    def __enter__(self) -> Self:
        return self

    @abstractmethod
    def __exit__(self, *exception: Any) -> None:
        """Finish what was written."""
