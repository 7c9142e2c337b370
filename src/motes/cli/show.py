"""The live picture of a run: an output that shows what an overlay would hold."""

from __future__ import annotations

from collections.abc import Callable
from typing import Self

from motes.cli.messages import log
from motes.cli.moment import Moment, Sink
from motes.output.live_picture import View, view
from motes.output.overlay import Draw


class Show(Sink):
    """Shows the newest picture of a run.

    Parameters
    ----------
    painted
        Returns a function that draws a result; called with each of them.
    """

    def __init__(self, painted: Callable[[Moment], Draw]) -> None:
        self._painted = painted
        self._view: View | None = None

    def write(self, moment: Moment) -> None:
        """Show a frame."""
        assert self._view is not None
        self._view.offer(self._painted(moment))

    def __enter__(self) -> Self:
        self._view = view()
        if self._view.address is not None:
            log(f"The live picture is at {self._view.address}")
        return self

    def __exit__(self, *_: object) -> None:
        if self._view is not None:
            self._view.close()
