"""The live picture of a run: an output that shows what an overlay would hold."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Generic, Self, TypeVar

from motes.cli.messages import log
from motes.cli.watch_outputs import FrameResult
from motes.mot.analytics.regions import Regions
from motes.output.live_picture import View, view
from motes.output.overlay import Draw
from motes.output.painters import ScenePainter, TrackPainter

if TYPE_CHECKING:
    from motes.cli.track_loop import Step

T = TypeVar("T")


class Show(Generic[T]):
    """Shows the newest picture of a run.

    Parameters
    ----------
    painted
        Returns a function that draws a result; called with each of them.
    """

    result = None

    def __init__(self, painted: Callable[[T], Draw]) -> None:
        self._painted = painted
        self._view: View | None = None

    def write(self, step: T) -> None:
        """Show a frame."""
        assert self._view is not None
        self._view.offer(self._painted(step))

    def __enter__(self) -> Self:
        self._view = view()
        if self._view.address is not None:
            log(f"The live picture is at {self._view.address}")
        return self

    def __exit__(self, *_: object) -> None:
        if self._view is not None:
            self._view.close()


def show_scene(places: Regions) -> Show[FrameResult]:
    """Return the live picture of several objects, and of lines and zones."""
    painter = ScenePainter(places)
    return Show(lambda moment: painter.painted(moment.frame, moment.tracks, moment.events))


def show_track() -> Show[Step]:
    """Return the live picture of one object."""
    painter = TrackPainter()
    return Show(lambda step: painter.painted(step.frame, step.info))
